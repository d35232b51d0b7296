"""The box around a sample: wall forces and Weber stress of packings whose stress is known, in 2D and 3D."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.experiment.box import Box, Sample, characteristic_time
from lmgcpy.experiment.texsol.sample import lay_sample_3d

PRESSURE, DENSITY, RADIUS = 1e5, 2600.0, 5e-3


def cubic(dimension, count=4, **more):
    """A square or simple cubic packing that fills its box, ``count`` particles along each axis."""
    places = RADIUS * (1.0 + 2.0 * np.array(list(itertools.product(range(count), repeat=dimension)), dtype=float))
    box = np.full(dimension, 2.0 * RADIUS * count)
    return Sample(places, np.full(len(places), RADIUS), more.get("wires", ()), more.get("reference_gap", 0.0), box)


def loaded(sample, axis=None):
    """Without friction, which would allow of self-stress in shear."""
    box = Box(sample, density=DENSITY, friction=0.0, axis=axis)
    box.load_laterally(PRESSURE)
    box.load_top(PRESSURE)
    step = 0.1 * characteristic_time(sample.diameter, DENSITY, PRESSURE)
    return box, lm.Simulation(box.scene, time_step=step, solver=lm.GaussSeidel(tolerance=1e-10, max_iterations=100_000))


@pytest.mark.parametrize(("dimension", "axis"), [(2, 0), (2, 1), (3, 0), (3, 1), (3, 2)])
def test_isotropic_pressure_on_a_regular_packing_is_its_stress(dimension, axis):
    """Each row between two walls carries p times the area of a cell, so sigma = -p I; the solver stops at an error of 1e-10
    of that of doing nothing, and errors along a row of four add up to some tens of that."""
    sample = cubic(dimension)
    box, sim = loaded(sample, axis)
    sim.run(steps=3)
    np.testing.assert_allclose(lm.measure.stress(sim)["total"], -PRESSURE * np.eye(dimension), atol=1e-7 * PRESSURE)
    area = (8.0 * RADIUS) ** (dimension - 1)
    np.testing.assert_allclose(box.reactions(sim), np.full(2 * dimension, PRESSURE * area), rtol=1e-7)
    assert box.unbalanced(sim) < 1e-7 * PRESSURE * area
    assert box.penetration(sim) < 1e-9 * RADIUS
    coordination, rattlers, *fabric = box.network(sim)
    assert (coordination, rattlers) == (2 * dimension, 0.0)
    np.testing.assert_allclose(np.reshape(fabric, (dimension, dimension)), np.eye(dimension) / dimension, atol=1e-12)


def test_loads_follow_the_present_area():
    """A packing of half the height, in a box with the platens across x: the load on the platen is p times height times
    depth, that on each lateral wall p times its own two sizes."""
    full = cubic(3)
    low = full.positions[:, 2] < 4.0 * RADIUS
    sample = Sample(full.positions[low], full.radii[low], (), 0.0, full.box * [1.0, 1.0, 0.5])
    box, sim = loaded(sample, axis=0)
    sim.run(steps=3)
    side, height = 8.0 * RADIUS, 4.0 * RADIUS
    expected = PRESSURE * np.repeat([side * height, side * height, side * side], 2)
    np.testing.assert_allclose(box.reactions(sim), expected, rtol=1e-7)


def test_unbalanced_force_is_the_mean_resultant():
    """Before anything is loaded nothing acts; a wall that strikes a row of four, alone, is stopped by one resultant: the
    contacts' forces within the row cancel but for what each particle gains in momentum in the step."""
    box, sim = loaded(cubic(2))
    before = sim.velocities.copy()
    sim.velocities[box.walls[1][1].id, 1] = -0.1
    before = sim.velocities[: len(box.particles)].copy()
    sim.step()
    mass = sim.model.mass[: len(box.particles), :1]
    gained = mass * (sim.velocities[: len(box.particles)] - before) / sim.time_step
    assert box.unbalanced(sim) == pytest.approx(np.linalg.norm(gained, axis=1).mean(), rel=1e-9)


def test_several_wires_are_several_chains():
    sample = cubic(3, wires=(4, 8), reference_gap=1e-4)
    assert sample.bead_count == 12
    box = Box(sample, density=DENSITY, friction=0.3, law=lm.RigidWire(), block_spin=True)
    assert [[bead.id for bead in chain.bodies] for chain in box.scene.chains] == [list(range(4)), list(range(4, 12))]


def test_time_scale_is_that_of_the_grains():
    """Beads finer than every grain do not count; beads among the grains' sizes do, as in 2D."""
    places = [[0.1, 0.1], [0.3, 0.1], [0.5, 0.1]]
    fine = Sample(places, [0.01, 0.01, 0.05], (2,), 0.1, (0.6, 0.2))
    alike = Sample(places, [0.05, 0.05, 0.04], (2,), 0.1, (0.6, 0.2))
    assert fine.diameter == pytest.approx(0.1)
    assert alike.diameter == pytest.approx(2.0 * 0.14 / 3.0)


def test_the_sample_now_is_the_sample_before_moved_to_the_origin():
    sample = cubic(3)
    box, sim = loaded(sample)
    sim.run(steps=2)
    sim.positions[:] += [0.1, 0.2, 0.3]
    now = box.sample(sample)
    np.testing.assert_allclose(now.positions, sample.positions, atol=1e-9)
    np.testing.assert_allclose(now.box, sample.box, atol=1e-9)


def test_a_thread_is_between_its_nodes_and_no_part_of_the_sand():
    """Nodes have the mass given and no contacts of their own; without a law there is no thread. Nothing else changes."""
    sample = replace(lay_sample_3d(60, 60, seed=0, thread=True), bead_mass=1e-8)
    given = {"density": 2600.0, "friction": 0.4, "wire_friction": (0.3, 0.2)}
    box, sand = Box(sample, law=lm.RigidWire(), **given), Box(sample, **given)
    count = sample.bead_count
    assert box.nodes == count
    assert sand.nodes == sand.bead_count == 0
    assert [body.mass for body in box.particles[:count]] == [1e-8] * count
    grains = [body.position.tolist() for body in box.particles[count:]]
    assert grains == [body.position.tolist() for body in sand.particles]
    friction = {frozenset(colours): law.friction for *colours, law, _ in box.scene.rows}
    assert friction[frozenset(("GRAIN", "THREAD"))] == 0.3
    assert friction[frozenset(("THREAD",))] == 0.2
    assert friction[frozenset(("GRAIN",))] == 0.4


def test_friction_of_a_thread_is_refused_for_beads():
    with pytest.raises(ValueError, match="wire_friction is the friction of a smooth thread"):
        Box(lay_sample_3d(60, 60, seed=0), density=2600.0, friction=0.4, wire_friction=(0.3, 0.2))


def test_reference_gaps_of_single_links():
    """One for each link of all wires, in their order; another number of them is refused."""
    gaps = [1e-4, 2e-4, 3e-4, 4e-4]
    sample = cubic(3, wires=(3, 3), reference_gap=gaps)
    assert [part.tolist() for part in sample.link_gaps] == [gaps[:2], gaps[2:]]
    assert sample.wire_length == pytest.approx(sum(gaps) + 4 * 2.0 * RADIUS)
    with pytest.raises(ValueError, match="a number, or one for each of its 4 links"):
        cubic(3, wires=(3, 3), reference_gap=gaps[:3])


def test_nodes_of_a_slack_thread_may_be_close():
    """A relaxation brings nodes closer than the thread is thick, which a new scene of one's own refuses."""
    sample = lay_sample_3d(60, 60, seed=0, thread=True)
    places = sample.positions.copy()
    places[1] = places[0] + 0.5 * sample.radii[0] * np.array([1.0, 0.0, 0.0])
    box = Box(replace(sample, positions=places), density=2600.0, friction=0.4, law=lm.RigidWire())
    lm.Simulation(box.scene, time_step=1e-6, on_unconverged="ignore", overlap="ignore").run(steps=2)
