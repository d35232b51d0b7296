"""What a campaign keeps of a study, against materials whose strength is known."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from test_texsol_2d import STRAIN, record
from test_texsol_3d import record as triaxial

from lmgcpy.experiment.texsol.conclusions import envelope, mobilised_angle
from lmgcpy.experiment.texsol.result import measures


@pytest.mark.parametrize("phi", [5.0, 22.0, 40.0])
@pytest.mark.parametrize("cohesion", [0.0, 0.3, 20.0])
def test_an_envelope_is_that_of_mohr_and_coulomb(phi, cohesion):
    """Strengths s1 = K s3 + 2 c sqrt(K) at two pressures give back c and phi; round-off grows with K."""
    sine, pressures = np.sin(np.radians(phi)), (1.0, 10.0)
    K = (1.0 + sine) / (1.0 - sine)
    angles = [mobilised_angle((K - 1.0) * s3 + 2.0 * cohesion * np.sqrt(K), s3) for s3 in pressures]
    assert envelope(tuple(angles), pressures) == pytest.approx((cohesion, phi), rel=1e-10, abs=1e-12)


def test_the_mobilised_angle_is_that_of_the_circle():
    """sin phi = (s1 - s3)/(s1 + s3)."""
    for phi in (0.0, 10.0, 30.0, 60.0):
        sine = np.sin(np.radians(phi))
        assert mobilised_angle(2.0 * sine / (1.0 - sine), 1.0) == pytest.approx(phi, abs=1e-12)


def test_strengths_and_gains_of_a_biaxial_study():
    """A box 2 m wide, 0.5 m high under 3 N at the side: s3 = 6 Pa. Deviators of 12 and 24 Pa are angles of 30 degrees, and
    of asin 2/3; halved in the last half they are the late ones."""
    fading = np.where(STRAIN < 0.05, 1.0, 0.5)
    records = {}
    for law, q in (("none", 12.0), ("rigid-wire", 24.0)):
        one = record(2.0 * (6.0 + q * fading), law)
        one.size[:] = 2.0, 0.5
        one.lateral = np.full(len(STRAIN), 3.0)
        one.stress["wire"][:, 0, 0] = 5.0
        records[law] = one
    numbers, curves = measures(SimpleNamespace(records=records))
    # running means of constants are constants to round-off
    assert numbers["none: peak friction angle [deg]"] == pytest.approx(30.0, rel=1e-9)
    assert numbers["rigid-wire: peak deviator [Pa]"] == pytest.approx(24.0, rel=1e-9)
    assert numbers["rigid-wire: late deviator [Pa]"] == pytest.approx(12.0, rel=1e-12)
    assert numbers["rigid-wire: late friction angle [deg]"] == pytest.approx(30.0, rel=1e-12)
    assert numbers["rigid-wire: gain of the peak deviator [Pa]"] == pytest.approx(12.0, rel=1e-9)
    gain = np.degrees(np.arcsin(2.0 / 3.0)) - 30.0
    assert numbers["rigid-wire: gain of the peak friction angle [deg]"] == pytest.approx(gain, rel=1e-9)
    assert numbers["rigid-wire: late mean stress of the wire [Pa]"] == pytest.approx(2.5, rel=1e-12)
    assert numbers["none: late change of volume"] == 0.0
    assert not any("cohesion" in name for name in numbers)
    assert curves["none"]["deviator [Pa]"][50] == pytest.approx(12.0, rel=1e-9)


def test_a_biaxial_test_along_x_has_its_platens_there():
    one = record(np.full(500, 8.0))
    one.size[:] = 2.0, 0.5
    one.lateral, one.axis = np.full(500, 3.0), "x"
    assert one.lateral_pressure[0] == 1.5  # on walls 2 m long
    assert one.deviator[0] == 14.5  # platens of 0.5 m


def test_a_single_test_has_names_without_its_own():
    numbers, curves = measures(SimpleNamespace(records={"none-z": triaxial(np.full(500, 1e5), "none")}))
    assert numbers["peak deviator [Pa]"] == pytest.approx(1e5, rel=1e-9)
    assert list(curves) == [""]
    assert not any("gain" in name for name in numbers)
