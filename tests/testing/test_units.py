"""Units as the conformance kit reads them."""

import pytest

from lmgcpy.testing.units import NONE, dimensions

READ = {
    "-": (0, 0, 0),
    "1": (0, 0, 0),
    "rad": (0, 0, 0),
    "m": (1, 0, 0),
    "1/s": (0, -1, 0),
    "s^-1": (0, -1, 0),
    "Hz": (0, -1, 0),
    "m/s^2": (1, -2, 0),
    "m/s/s": (1, -2, 0),
    "kg/s": (0, -1, 1),
    "N": (1, -2, 1),
    "N s": (1, -1, 1),
    "N*s/m": (0, -1, 1),
    "N·s/m": (0, -1, 1),
    "N/m": (0, -2, 1),
    "N/(m s)": (0, -3, 1),
    "N/m^1.5": (-0.5, -2, 1),
    "Pa": (-1, -2, 1),
    "Pa m^0.5": (-0.5, -2, 1),
    "J/m^2": (0, -2, 1),
    "J/m²": (0, -2, 1),
    "J/m**2": (0, -2, 1),
    "W/(m K)": (1, -3, 1),
    "m s⁻¹": (1, -1, 0),
}


@pytest.mark.parametrize(("unit", "powers"), READ.items())
def test_a_unit_has_powers_of_length_time_and_mass(unit, powers):
    assert dimensions(unit)[:3] == powers


def test_equal_units_have_equal_dimensions():
    assert dimensions("N s") == dimensions("kg m/s")
    assert dimensions("J") == dimensions("N m")
    assert dimensions("-") == NONE


IN_THE_PLANE = {"Pa": 0, "J/m^2": 1, "m^2": 1, "kg/m^3": -2, "N": 1, "N/m": 0, "m": 1}


@pytest.mark.parametrize(("unit", "length"), IN_THE_PLANE.items())
def test_in_the_plane_one_metre_of_an_area_is_depth(unit, length):
    """What is per metre of depth keeps it: a stress [Pa] times a length is a force per metre of depth, "N" in 2D."""
    assert dimensions(unit).in_the_plane().length == length


def test_a_factor_is_what_a_number_is_multiplied_by():
    assert dimensions("N/m").factor(length=10.0, time=2.0, mass=3.0) == 3.0 / 4.0


REFUSED = {
    "MPa": "holds 'MPa', which is not known; did you mean 'Pa'",
    "mm": "holds 'mm', which is not known; did you mean 'm'",
    "furlong": "holds 'furlong', which is not known. Known: 1, Hz, J, K, N, Pa, W, kg, m, rad, s. Laws use SI.",
    "N/m s": "has a factor after a division",
    "N/": "ends after a division",
    "(N": "a parenthesis that is not closed",
    "N)": "cannot be read",
    "m^": "cannot be read at '\\^'",
    "": "cannot be read: write it in SI",
    "[N]": "cannot be read at '\\[N\\]'",
}


@pytest.mark.parametrize(("unit", "words"), REFUSED.items())
def test_what_is_no_unit_gets_a_sentence(unit, words):
    with pytest.raises(ValueError, match=words):
        dimensions(unit)
