"""What a run says of itself: links that are too long, interactions that make energy, beads that zigzag."""

from __future__ import annotations

import re
import warnings

import numpy as np
import pytest

import lmgcpy as lm


def jerked(load: float, time_step: float, **options) -> lm.Simulation:
    """Twenty links of 0.0101 m over 0.2 m, beads of 1 g and a load in the middle, which falls until they are taut."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    for i in range(21):
        scene.add(lm.disk(radius=0.002, position=(0.01 * i, 0.0), mass=load if i == 10 else 1e-3))
    scene.bodies[0].fix()
    scene.bodies[-1].fix()
    scene.chain(scene.bodies, lm.RigidWire(), reference_gap=0.0101 - 0.004)
    return lm.Simulation(scene, time_step=time_step, **options)


def said(sim: lm.Simulation, **how) -> list[str]:
    """The warnings of a run."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        sim.run(**how)
    return [str(warning.message) for warning in caught]


def test_a_wire_that_goes_wrong_says_so_once_each():
    """The scene in which every step is solved and energy is made: three sentences, each with a step that would do."""
    sim = jerked(1.0, 1e-3, geometric_stiffness=False)
    sentences = said(sim, duration=0.3)
    assert sim.unconverged_steps == 0
    for words in ("is off its reference length of 0.0101 m", "4 h^2 T/(m l) is", "out of nothing"):
        (sentence,) = (sentence for sentence in sentences if words in sentence)
        step = float(re.search(r"time step of ([\d.e-]+) s", sentence).group(1))
        assert 0.0 < step < 1e-3
    assert sim.energy.made > 0.25 * sim.energy.turned


def test_a_step_that_is_advised_is_not_longer_than_one_that_would_do():
    """Half of 1.9999 ms is 0.99995 ms, in two digits 1 ms, which is longer."""
    sentences = said(jerked(1.0, 1.9999e-3, geometric_stiffness=False), duration=0.3)
    (sentence,) = (each for each in sentences if "out of nothing" in each)
    assert re.search(r"time step of ([\d.e-]+) s", sentence).group(1) == "0.00099"


def test_zigzag_is_said_of_links_beyond_what_the_step_resolves():
    """From s = 4 on, with s as a number. The step that is named is right for the tension of that step."""
    sentences = said(jerked(1e-2, 1e-3, geometric_stiffness=False), duration=0.3)
    (sentence,) = (sentence for sentence in sentences if "4 h^2 T/(m l) is" in sentence)
    assert float(re.search(r"is ([\d.e+-]+),", sentence).group(1)) > 4.0


@pytest.mark.default_parameters(time_step=(2e-3,))
@pytest.mark.parametrize("load", [1e-3, 1.0, 100.0])
@pytest.mark.parametrize("time_step", [2e-3, 1e-3, 2.5e-4])
def test_nothing_is_said_where_it_is_right(load, time_step):
    """But that the jerk has no rebound, and that a wave is damped that the step is too long for. Ideal wires would throw
    the load back: with 1, 10 and 100 g they keep 0.84, 0.92 and 0.99 of the energy at 4 us, and 0.13 to 0.18 at 2 ms."""
    sim = jerked(load, time_step)
    right = "jerk without rebound", "waves of the wire"
    assert all(any(words in sentence for words in right) for sentence in said(sim, duration=0.15))
    assert sim.report.stretch <= 5e-2
    assert sim.energy.made <= 0.15 * sim.energy.turned


def test_the_stretch_is_that_of_the_longest_link():
    """Of the detection: half a step on from where the step before ended."""
    sim = jerked(1.0, 1e-3, geometric_stiffness=False)
    said(sim, steps=60)
    ahead = sim.positions + 0.5e-3 * sim.velocities
    lengths = np.linalg.norm(np.diff(ahead, axis=0), axis=1)
    said(sim, steps=1)
    assert sim.report.stretch == pytest.approx(max(lengths.max() / 0.0101 - 1.0, 0.0), abs=1e-12)


def test_what_is_stored_from_the_start_nobody_made():
    """A stretched elastic wire pulls a mass: work and what it stores cancel but for what the step damps."""
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0)).fix()
    scene.add(lm.disk(radius=0.1, position=(1.2, 0.0), mass=1.0))
    scene.chain(scene.bodies, lm.ElasticWire(stiffness=100.0), reference_gap=0.8)
    sim = lm.Simulation(scene, time_step=1e-3)
    assert not said(sim, duration=0.3)
    assert sim.energy.made <= 1e-12
    assert sim.energy.mechanical == pytest.approx(2.0, rel=0.05)  # k 0.2^2 / 2, less what the step damps


def test_links_that_are_drawn_may_do_work():
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0)).fix()
    scene.add(lm.disk(radius=0.1, position=(1.2, 0.0), mass=1.0))
    scene.chain(scene.bodies, lm.RigidWire(), reference_gap=0.6, relaxation=0.1)
    sim = lm.Simulation(scene, time_step=1e-3)
    assert not said(sim, duration=0.15)
    assert sim.energy.made <= 1e-12


class Motor(lm.Law):
    """A link that pushes by itself and promises nothing."""

    NAME = "motor-of-the-watch"
    APPLIES_TO = "link"
    PREPARED = ("push",)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (time_step,)

    @staticmethod
    def react(W, u, prepared):
        return (prepared[0],)


def test_a_law_that_promises_nothing_may_give_energy():
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0)).fix()
    scene.add(lm.disk(radius=0.1, position=(1.0, 0.0), mass=1.0))
    scene.chain(scene.bodies, Motor())
    sim = lm.Simulation(scene, time_step=1e-3)
    assert not said(sim, duration=0.1)
    assert sim.energy.kinetic > 0.0


def test_both_are_in_the_run_file(tmp_path):
    sim = jerked(1.0, 1e-3, geometric_stiffness=False)
    said(sim, steps=70, record=tmp_path / "run.h5")
    with lm.io.open_run(tmp_path / "run.h5") as run:
        history = run.history[:]
        assert history["stretch"].max() > 0.05
        assert history["made"][-1] == sim.energy.made
        assert run.options["geometric_stiffness"] is False
    again = lm.resume(tmp_path / "run.h5")
    assert again.energy.made == sim.energy.made
    assert again.geometric_stiffness is False


def test_a_warning_that_is_an_error_leaves_a_whole_step():
    """The step in which it is raised is made, as the same run without errors makes it."""
    told, quiet = (jerked(1.0, 1e-3, geometric_stiffness=False) for _ in range(2))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(RuntimeWarning):
            told.run(steps=300)
    said(quiet, steps=told.steps)
    assert told.time == quiet.time
    np.testing.assert_array_equal(told.positions, quiet.positions)
    np.testing.assert_array_equal(told.velocities, quiet.velocities)


@pytest.mark.parametrize("law", [lm.ElasticRod, lm.ElasticWire])
def test_an_elastic_link_that_turns_by_too_much_is_told(law):
    """A pair that spins by x in a step, on a stiff link. In the middle of the step it is turned by atan(x/2), so that it
    moves across itself by ``x/sqrt(1 + x^2/4)`` of its length l, and ends at ``l sqrt(1 + x^2/(1 + x^2/4))``: 1.34 l at
    x = 1, 1.246 l at 0.8, below what is told."""
    time_step = 1e-3
    for x, told in ((0.8, 0), (1.0, 1)):
        scene = lm.Scene(dimension=2)
        for p in (-0.05, 0.05):
            scene.add(lm.disk(radius=0.01, position=(p, 0.0), mass=1.0, velocity=(0.0, p * x / time_step)))
        scene.chain(scene.bodies, law(stiffness=1e12))
        sentences = said(lm.Simulation(scene, time_step=time_step), steps=1)
        assert len(sentences) == told
    assert "longer than its law predicts by 34.2 %" in sentences[0]
