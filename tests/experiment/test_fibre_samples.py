"""Samples of fibres among spheres and clumps: laid, compacted, and compressed in a triaxial test."""

from dataclasses import replace

import numpy as np
import pytest
from conftest import DENSITY, PRESSURE, relax

import lmgcpy as lm
from lmgcpy.experiment import Sample, Triaxial, lay_grains
from lmgcpy.experiment.box import Box
from lmgcpy.scene.body_3d import body_volume

pytestmark = pytest.mark.filterwarnings("ignore:In the step to")
"""Walls of a loose box hit single fibres, which then fly."""
TETRAPOD = lm.clump([1.0] * 4, 0.5 * np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]), density=DENSITY)
COUNT = 30
FIBRES = {"content": 0.08, "fibre_radius": 0.15e-3, "fibre_length": 1.5e-3}
SOLVER = lm.AcceleratedGaussSeidel(tolerance=3e-3, max_iterations=3000)


def laid(shape=None, **more):
    return lay_grains(COUNT, shape=shape, **{**FIBRES, "seed": 3, **more})


@pytest.fixture(scope="module")
def compaction():
    return relax(laid(), solver=lm.AcceleratedGaussSeidel(tolerance=3e-3, max_iterations=2000))


@pytest.fixture(scope="module")
def test_of(compaction):
    """The simulation and the record of a test to 2 % of crushing."""
    test = Triaxial(compaction.sample, inertial_number=2e-3, solver=SOLVER)
    return test, test.run(0.02, frames=2)


def test_grains_have_the_volumes_of_the_grading_whatever_their_shape():
    spheres, clumps = laid(), laid(TETRAPOD)
    volume = 4.0 / 3.0 * np.pi * float((spheres.radii**3).sum())
    fibres = [body for body in clumps.bodies if isinstance(body, lm.Capsule)]
    grains = [body for body in clumps.bodies if not isinstance(body, lm.Capsule)]
    assert len(grains) == COUNT
    assert sum(map(body_volume, grains)) == pytest.approx(volume, rel=1e-9)
    assert sum(body.mass for body in grains) == pytest.approx(DENSITY * volume, rel=1e-9)
    one = body_volume(fibres[0])
    assert abs(len(fibres) * one - FIBRES["content"] * volume) <= 0.5 * one
    assert clumps.solid_volume == pytest.approx(volume + len(fibres) * one, rel=1e-9)
    assert spheres.solid_volume == pytest.approx(clumps.solid_volume, rel=1e-9)
    # fibres do not count for the mean grain, and clumps count as spheres of their volume
    assert spheres.diameter == pytest.approx(2.0 * spheres.radii.mean(), rel=1e-12)
    assert clumps.diameter == pytest.approx(spheres.diameter, rel=1e-9)
    assert f"{len(fibres) + COUNT} particles, {len(fibres)} of them fibres" in repr(clumps)


def test_fibres_alone_have_a_mean_diameter():
    fibres = [body for body in laid().bodies]
    alone = Sample(np.empty((0, 3)), np.empty(0), (), 0.0, laid().box, bodies=fibres)
    assert alone.diameter == pytest.approx(2.0 * np.cbrt(0.75 / np.pi * body_volume(fibres[0])), rel=1e-12)


@pytest.mark.parametrize("shape", [None, TETRAPOD])
def test_a_box_holds_the_sample_and_gives_it_back(shape):
    """The bodies of the sample stay its own; those of the box are twins in the same places."""
    before = laid(shape)
    box = Box(before, density=DENSITY, friction=0.3)
    sim = lm.Simulation(box.scene, time_step=1e-9, overlap="stop")
    assert len(box.particles) == len(before.radii) + len(before.bodies)
    after = box.sample(before)
    np.testing.assert_array_equal(after.positions, before.positions)
    for body, same in zip(after.bodies, before.bodies, strict=True):
        assert same.id == body.id == -1
        np.testing.assert_allclose(body.position, same.position, rtol=1e-15)
        np.testing.assert_allclose(body.rotation.as_matrix(), same.rotation.as_matrix(), atol=1e-15)
    weights = sim.model.mass[: len(box.particles), 0].sum()
    assert box.mass == pytest.approx(weights, rel=1e-12)


def test_compaction_presses_the_sample_together(compaction):
    before = laid()
    sample = compaction.sample
    assert compaction.at_rest
    assert compaction.unconverged == 0
    assert compaction.solid_fraction == pytest.approx(sample.solid_volume / np.prod(sample.box), rel=1e-12)
    assert sample.solid_volume == pytest.approx(before.solid_volume, rel=1e-12)
    assert compaction.solid_fraction > 2.0 * before.solid_volume / np.prod(before.box)
    assert np.abs(compaction.stress + PRESSURE * np.eye(3)).max() < 0.02 * PRESSURE
    ends = [body.position + sign * body.rotation.apply([0, 0, 0.75e-3]) for body in sample.bodies for sign in (-1, 1)]
    # within the box to the deepest overlap
    assert np.min(ends) - 0.15e-3 > -compaction.penetration - 1e-9
    assert (np.max(ends, axis=0) + 0.15e-3 < sample.box + compaction.penetration + 1e-9).all()
    # of a grain's radius: contacts that closed fast keep what they overlapped by
    assert compaction.penetration < 0.02 * 0.5e-3


def test_weber_stress_agrees_with_the_pressure_on_the_walls(test_of):
    """Without gravity and at rest, each normal stress is the force on the walls across that axis over their area, fibres
    included: their contacts have levers, which the stress about centres of mass takes into account."""
    _, record = test_of
    sigma = -record.stress["total"].mean(axis=0)
    assert sigma[2, 2] == pytest.approx(record.axial.mean(), rel=0.02)
    np.testing.assert_allclose(np.diag(sigma)[:2], record.lateral.mean(axis=0), rtol=0.02)
    np.testing.assert_allclose(record.lateral.mean(axis=0), PRESSURE, rtol=0.02)
    assert record.deviator[record.strain > 0.01].mean() > 0.5 * PRESSURE


def test_energy_identity_holds_at_every_step(test_of):
    """Its defect is round-off of works of the order of p V times the strain of a step."""
    _, record = test_of
    assert record.unconverged == 0
    assert np.abs(record.defect).max() < 1e-12 * PRESSURE * record.size[0].prod()


def test_fibres_bear_force_and_turn(test_of):
    test, _ = test_of
    net = test.simulation.interactions
    particles = len(test.box.particles)
    fibre = np.arange(particles) >= COUNT
    between = (net.antagonist < particles) & (net.impulse[:, 0] > 0.0)
    touched = fibre[net.candidate[between]] | fibre[net.antagonist[between]]
    assert touched.sum() > 2 * fibre.sum()
    assert np.abs(test.simulation.spins[:particles][fibre]).max() > 0.0


@pytest.mark.long
def test_a_file_and_an_interruption_change_no_bit(compaction, tmp_path):
    def run(**more):
        return Triaxial(compaction.sample, inertial_number=2e-3, solver=SOLVER).run(0.003, **more)

    stop = iter([False] * 3 + [True])
    with pytest.raises(KeyboardInterrupt):
        run(file=tmp_path / "test.h5", interrupted=lambda: next(stop))
    filed, kept = run(file=tmp_path / "test.h5"), run()
    for name in ("axial", "lateral", "size", "kinetic"):
        np.testing.assert_array_equal(getattr(filed, name), getattr(kept, name))


@pytest.mark.long
def test_clumps_with_fibres_are_compacted_and_compressed():
    done = relax(laid(TETRAPOD))
    assert done.at_rest
    record = Triaxial(done.sample, inertial_number=2e-3, solver=SOLVER).run(0.02, frames=0)
    sigma = -record.stress["total"].mean(axis=0)
    assert sigma[2, 2] == pytest.approx(record.axial.mean(), rel=0.02)
    assert np.abs(record.defect).max() < 1e-12 * PRESSURE * record.size[0].prod()


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:In the step from")
def test_flexible_fibres_are_compacted_and_compressed():
    """Fibres of three capsules on joints: as many fibres in as many directions as rigid ones, of the same mass and volume.
    Joints stay closed, fibres bend, and each step balances. (Walls hit segments, which are light, and grains then overlap
    them by an eighth of their radius; the run warns of it.)"""
    loose = lay_grains(30, content=0.05, fibre_radius=2e-4, fibre_length=2.4e-3, segments=3, seed=3)
    rigid = lay_grains(30, content=0.05, fibre_radius=2e-4, fibre_length=2.4e-3, seed=3)
    fibres = len(rigid.bodies)
    assert len(loose.bodies) == 3 * fibres
    assert repr(loose) == repr(rigid)
    assert sum(body.mass for body in loose.bodies) == pytest.approx(sum(body.mass for body in rigid.bodies), rel=1e-12)
    assert loose.solid_volume == pytest.approx(rigid.solid_volume, rel=1e-12)
    done = relax(loose)
    assert done.at_rest
    axes = np.array([body.rotation.apply([0, 0, 1]) for body in done.sample.bodies]).reshape(fibres, 3, 3)
    bent = np.arccos(np.clip((axes[:, :-1] * axes[:, 1:]).sum(axis=2), -1.0, 1.0))
    assert bent.max() > 0.02
    test = Triaxial(done.sample, inertial_number=2e-3, solver=SOLVER)
    record = test.run(0.005, frames=0)
    assert len(test.box.scene.joints) == 2 * fibres
    assert max(np.linalg.norm(joint.opening()) for joint in test.box.scene.joints) < 1e-6
    assert np.abs(record.defect).max() < 1e-12 * PRESSURE * record.size[0].prod()


def test_capsules_that_make_no_whole_fibres_are_refused():
    loose = lay_grains(30, content=0.05, fibre_radius=2e-4, fibre_length=2.4e-3, seed=3)
    with pytest.raises(ValueError, match="it does not divide"):
        replace(loose, segments=len(loose.bodies) + 1)
    with pytest.raises(ValueError, match="make no whole fibres"):
        lm.sample.join_segments(lm.Scene(dimension=3), loose.bodies, len(loose.bodies) + 1)
