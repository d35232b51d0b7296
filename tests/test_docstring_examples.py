"""Examples in docstrings run and print what stands there."""

import doctest
import inspect

import pytest

import lmgcpy as lm

LAWS = [f"{word}{shape}" for word in ("Elastic", "Rigid", "Voigt") for shape in ("Rod", "Wire")]
PUBLIC = [
    *("Scene", "Simulation", "Chain", "Cell", "Law", "Coulomb", "Restitution", "RollingCoulomb", "Signorini", *LAWS),
    *("AcceleratedGaussSeidel", "Auto", "GaussSeidel", "Newton"),
    *("measure.angular_momentum", "measure.density", "measure.mean_strain", "measure.stress", "measure.wire_links"),
    *("measure.facets", "measure.forces_along"),
]
"""Names whose docstrings have an example."""
SLOW = {"ElasticRod", "RigidRod", "VoigtRod", "VoigtWire"}
"""Each takes some seconds; links as rods and as wires are alike."""


@pytest.mark.default_parameters(name=sorted(set(PUBLIC) - SLOW))
@pytest.mark.parametrize("name", PUBLIC)
def test_the_example_of_a_docstring_runs(name):
    of = lm
    for word in name.split("."):
        of = getattr(of, word)
    example = doctest.DocTestParser().get_doctest(inspect.getdoc(of), {}, name, None, None)
    assert len(example.examples) >= 2
    told = []
    doctest.DocTestRunner().run(example, out=told.append)
    assert not told, "".join(told)
