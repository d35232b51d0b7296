"""Laws as a user makes them: validated, frozen, comparable; sentences name law, parameter and unit."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm


def test_parameters_are_attributes_and_values():
    law = lm.Restitution(restitution=0.5, friction=0.2)
    assert (law.restitution, law.friction) == (0.5, 0.2)
    assert law.values == {"friction": 0.2, "restitution": 0.5}
    assert repr(law) == "Restitution(friction=0.2, restitution=0.5)"


def test_a_default_is_taken_and_an_integer_becomes_a_float():
    law = lm.Restitution(restitution=1)
    assert law.friction == 0.0
    assert isinstance(law.restitution, float)


def test_equal_parameters_make_equal_laws():
    assert lm.Coulomb(friction=0.3) == lm.Coulomb(friction=0.3)
    assert hash(lm.Coulomb(friction=0.3)) == hash(lm.Coulomb(friction=0.3))
    assert lm.Coulomb(friction=0.3) != lm.Coulomb(friction=0.31)
    assert lm.RigidRod() != lm.RigidWire()


@pytest.mark.parametrize("name", ["friction", "colour"])
def test_a_law_is_frozen(name):
    law = lm.Coulomb(friction=0.3)
    with pytest.raises(AttributeError, match=f"frozen: make a new Coulomb instead of setting {name}"):
        setattr(law, name, 0.5)
    assert law.friction == 0.3


def test_values_is_a_copy():
    law = lm.Coulomb(friction=0.3)
    law.values["friction"] = 7.0
    assert law.friction == 0.3


def test_axial_rigidity_is_per_reference_length():
    """k = EA / l0, so that n links of length l0/n in series are as soft as one of length l0."""
    lengths = np.array([0.5, 0.25, 1.0])
    assert lm.ElasticRod(axial_rigidity=10.0).table(lengths).ravel().tolist() == [20.0, 40.0, 10.0]
    assert lm.ElasticRod(stiffness=10.0).table(lengths).ravel().tolist() == [10.0, 10.0, 10.0]


def test_axial_viscosity_is_per_reference_length():
    lengths = np.array([0.5, 0.25])
    assert lm.VoigtRod(axial_rigidity=10.0, axial_viscosity=2.0).table(lengths).tolist() == [[20.0, 4.0], [40.0, 8.0]]
    assert lm.VoigtRod(stiffness=10.0, axial_viscosity=2.0).table(lengths).tolist() == [[10.0, 4.0], [10.0, 8.0]]
