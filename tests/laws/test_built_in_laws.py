"""Every law that comes with lmgcpy keeps what laws promise, and a little more than strangers must."""

from __future__ import annotations

import math

import numpy as np
import pytest
from built_in import INSTANCES, name
from hypothesis import given
from hypothesis import strategies as st

import lmgcpy as lm
import lmgcpy.testing
from lmgcpy.testing.case import diagonal
from lmgcpy.testing.draw import cases, extreme, powers_of_ten

every_law = pytest.mark.parametrize("law", INSTANCES, ids=name)


def test_every_law_of_the_package_is_among_them():
    own = {word for word, registration in lm.laws.registrations().items() if registration.distribution == "lmgcpy"}
    assert own == {law.NAME for law in INSTANCES}


DEFAULT = {
    lm.Coulomb(friction=0.3): ("fixed-point", "cone", "dissipative", "no-dilatancy", "mirror", "purity", "scene"),
    lm.ElasticWire(axial_rigidity=100.0): ("fixed-point", "compiled", "conic", "potential", "pull", "units", "restart"),
}
"""Each property once, of a contact with friction or of a link that stores energy; a law takes some ten seconds with all,
most of them compiling. That each law solves its relation is in ``test_relations.py``."""


@pytest.mark.default_parameters(*(f"{name(law)}-{property}" for law, chosen in DEFAULT.items() for property in chosen))
@lmgcpy.testing.conformance(*INSTANCES)
def test_law(check):
    check()


@every_law
@given(data=st.data())
def test_sixty_decades_to_either_side_are_finite(law, data):
    """Solvers that fail pass through numbers of any size on their way; what comes out of a law must still be a number."""
    case = data.draw(cases(law, extreme(60.0)))
    assert not np.isnan(case.prepared).any()
    assert np.isfinite(case.impulse).all()
    if law.slope is not None:
        assert np.isfinite(case.slope(case.q)).all()
    if law.energy is not None:
        assert math.isfinite(case.energy(case.gap))


@every_law
@given(data=st.data())
def test_a_wrong_impulse_is_no_fixed_point(law, data):
    """The error that solvers measure sees an impulse that is off by d, as one of at least W_nn d.

    Off towards the side where the law has no bound, for w = W_nn: a monotone law then answers with less than what was
    offered, by d at least (min(w r, W_nn d) for a rigid law, d (C + W_nn) w / (w + C) with a compliance C).
    """
    case = data.draw(cases(law))
    w = case.W[0][0]
    d = 1e-3 * (case.speed + 1.0) / w
    r = np.array(case.impulse)
    r[0] += -d if "pull" in law.TRAITS else d
    u = np.array(case.q) + np.array(case.W) @ r
    again = case.react(diagonal([w] * len(r)), u - w * r, case.prepared)
    assert w * abs(again[0] - r[0]) > 0.99 * w * d


@every_law
@given(data=st.data(), further=powers_of_ten(-12.0, 3.0))
def test_the_normal_answer_is_monotone(law, data, further):
    """Along the normal, with W diagonal: a larger free velocity never gives a larger impulse, at any kink.

    So the local problem has one answer, and the sweep cannot cycle at one interaction.
    """
    case = data.draw(cases(law)).with_diagonal()
    upper = case.react(case.W, (case.q[0] + further, *case.q[1:]), case.prepared)[0]
    assert upper <= case.impulse[0] + 1e-15 * abs(case.impulse[0])


@pytest.mark.parametrize("law", [law for law in INSTANCES if law.slope is not None], ids=name)
@given(data=st.data())
def test_slope_lies_between_zero_and_rigid(law, data):
    """-1/W <= dr_n/du_n <= 0 at every point, kinks too: what keeps the wire block's matrix invertible."""
    case = data.draw(cases(law, extreme(60.0)))
    assert -(1.0 + 1e-15) / case.W[0][0] <= case.slope(case.q)[0][0] <= 0.0
