"""Parameters of a law that differ from link to link."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.scene.description import describe, from_description

STIFFNESS = [100.0, 400.0, 50.0]


def hanging(law, count=4, **options):
    """A wire of beads of 1 kg that hangs from the first."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    beads = [scene.add(lm.disk(radius=0.05, mass=1.0, position=(0.0, -0.5 * i))) for i in range(count)]
    beads[0].fix()
    scene.chain(beads, law, **options)
    return scene


@pytest.mark.default_parameters("law1")
@pytest.mark.parametrize("law", [lm.ElasticRod(stiffness=1.0), lm.ElasticWire(stiffness=1.0)])
def test_each_link_has_its_own_stiffness(law):
    """At rest link i carries the beads below it, and is longer by their weight over its stiffness. Steps of half
    a period or more damp as implicit Euler does: theta is 1."""
    scene = hanging(law, parameters={"stiffness": STIFFNESS})
    sim = lm.Simulation(scene, time_step=0.1, theta=1.0).run(steps=400)
    stretch = -np.diff(sim.positions[:, 1]) - 0.5
    assert stretch == pytest.approx([30.0 / 100.0, 20.0 / 400.0, 10.0 / 50.0], rel=1e-6)


def test_axial_rigidity_is_by_the_length_of_each_link():
    """k = EA / l0 of the link."""
    scene = hanging(lm.ElasticWire(axial_rigidity=1.0), parameters={"axial_rigidity": [0.5, 1.0, 2.0]})
    assert scene.compile().chains[0].parameters[:, 0] == pytest.approx([1.0, 2.0, 4.0])


def test_a_run_with_its_own_parameters_goes_on_with_them(tmp_path):
    """By its file, bit for bit; the description holds the arrays."""
    parameters = {"stiffness": STIFFNESS}
    scene = hanging(lm.ElasticWire(stiffness=1.0), parameters=parameters)
    again = from_description(describe(scene))
    assert again.chains[0].parameters["stiffness"].tolist() == STIFFNESS
    whole = lm.Simulation(scene, time_step=1e-3).run(steps=40)
    other = lm.Simulation(hanging(lm.ElasticWire(stiffness=1.0), parameters=parameters), time_step=1e-3)
    other.run(steps=15, record=tmp_path / "run.h5")
    rest = lm.resume(tmp_path / "run.h5").run(steps=25)
    assert np.array_equal(whole.positions, rest.positions)
    plain = lm.Simulation(hanging(lm.ElasticWire(stiffness=1.0)), time_step=1e-3).run(steps=40)
    assert not np.array_equal(whole.positions, plain.positions)


def test_one_value_for_all_is_the_law_itself():
    """The same bits."""
    runs = [
        lm.Simulation(hanging(lm.ElasticWire(stiffness=k), **options), time_step=1e-3).run(steps=30).positions
        for k, options in ((70.0, {}), (1.0, {"parameters": {"stiffness": [70.0] * 3}}))
    ]
    assert np.array_equal(*runs)


@pytest.mark.parametrize(
    ("parameters", "error", "words"),
    [
        ({"strength": [1.0] * 3}, ValueError, "parameters: law 'elastic-wire' has no 'strength'"),
        ({"stiffness": [1.0, 2.0]}, ValueError, r"parameters\['stiffness'\] must be 3 numbers, one a link"),
        ({"stiffness": 1.0}, ValueError, r"parameters\['stiffness'\] must be 3 numbers, one a link"),
        ({"stiffness": "stiff"}, TypeError, r"parameters\['stiffness'\]"),
        (
            {"stiffness": [1.0, -2.0, 1.0]},
            ValueError,
            "Link 1 of the chain: stiffness of law 'elastic-wire' must be above 0",
        ),
        ({"stiffness": [1.0, np.nan, 1.0]}, ValueError, "finite"),
        ([1.0, 2.0, 3.0], TypeError, "parameters are arrays by name"),
        ({"axial_rigidity": [1.0] * 3}, ValueError, "Link 0 of the chain: .*axial_rigidity"),
    ],
)
def test_wrong_parameters_get_a_sentence(parameters, error, words):
    with pytest.raises(error, match=words):
        hanging(lm.ElasticWire(stiffness=1.0), parameters=parameters)
