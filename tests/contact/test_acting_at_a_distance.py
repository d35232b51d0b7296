"""Laws that act at a distance are seen up to their reach, whatever the alert distance is."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm

FORCE = 2.0


class Spring(lm.Law):
    """A pull of 2 N up to a gap, as of a bridge of water; the contact itself is hard."""

    NAME = "constant-pull"
    APPLIES_TO = "contact"
    PREPARED = ("bias", "hold")

    reach = lm.Parameter("m", "gap at which the bridge breaks", minimum=0.0)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (max(gap, 0.0) / time_step, time_step * FORCE if gap <= parameters[0] else 0.0)

    @staticmethod
    def react(W, u, prepared):
        bias, hold = prepared
        return (max(-hold, -(u[0] + bias) / W[0][0]),)


class OfRadii(Spring):
    """The same up to a third of the smaller radius."""

    NAME = "pull-of-radii"

    def acts_within(self, radius, other):
        return min(radius, other) / 3.0


def pulled(law, gap, alert=None, radius=0.1):
    """A disk that starts at rest in front of a wall, after twenty steps."""
    scene = lm.Scene(dimension=2)
    body = scene.add(lm.disk(radius=radius, position=(0.0, radius + gap), mass=1.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", law, alert=alert)
    lm.Simulation(scene, time_step=1e-3).run(steps=20)
    return body.velocity[1]


@pytest.mark.default_parameters(reach=(0.03,))
@pytest.mark.parametrize("alert", [None, 0.0, 1e-3, 0.5])
@pytest.mark.parametrize("reach", [1e-3, 0.03, 0.3])
def test_the_answer_does_not_depend_on_the_alert_distance(reach, alert):
    """Within the reach the pull of 2 N on 1 kg gives 0.04 m/s in 20 ms; beyond it nothing moves. The alert distance
    is 0.02 m by default."""
    assert pulled(Spring(reach=reach), 0.97 * reach, alert) == pytest.approx(-0.04, rel=1e-12)
    assert pulled(Spring(reach=reach), 1.01 * reach, alert) == 0.0


@pytest.mark.parametrize("radius", [0.01, 0.1, 1.0])
def test_a_reach_may_be_a_formula_of_the_radii(radius):
    law = OfRadii(reach=10.0)
    assert pulled(law, 0.32 * radius, 0.0, radius) == pytest.approx(-0.04, rel=1e-12)
    assert pulled(law, 0.34 * radius, 0.0, radius) == 0.0


def test_a_body_that_flies_into_the_reach_is_seen_in_the_step_in_which_it_gets_there():
    """The pull begins in the first step that begins within the reach: the velocity before and after is that of a scene that
    sees everything."""
    motions = []
    for alert in (None, 3.0):
        scene = lm.Scene(dimension=2)
        small = scene.add(lm.disk(radius=0.05, position=(0.0, 0.5), mass=1.0, velocity=(0.0, -3.0)))
        scene.add(lm.disk(radius=0.05, position=(0.0, 0.0), mass=1.0))
        scene.see("GRAIN", "GRAIN", Spring(reach=0.2), alert=alert)
        sim = lm.Simulation(scene, time_step=7e-3)
        motions.append([small.velocity[1] for _ in range(40) if sim.step() is None or True])
    assert np.array_equal(*motions)
    assert min(motions[0]) < -3.0


@pytest.mark.parametrize(("answer", "sentence"), [(-1.0, "at least 0"), ("far", "must be a number"), (np.nan, "finite")])
def test_a_reach_that_is_none_gets_a_sentence(answer, sentence):
    class Wrong(Spring):
        NAME = "wrong-reach"

        def acts_within(self, radius, other):
            return answer

    with pytest.raises((TypeError, ValueError), match=f"acts_within of law 'wrong-reach'.*{sentence}"):
        pulled(Wrong(reach=1.0), 0.1)
