"""Compaction: when it is at rest, what it reports, and the drag that keeps a fine wire from being crumpled."""

import numpy as np
import pytest
from conftest import DENSITY, PRESSURE, relax

import lmgcpy as lm
from lmgcpy.experiment.box import Box, characteristic_time
from lmgcpy.experiment.compaction import WINDOW, DampedSimulation, Unrest, compact, inner_solid_fraction, unrest
from lmgcpy.experiment.texsol.sample import lay_sample_3d


def straightness(sample, links=10):
    """Distance of beads so many links apart over the length of wire between them, mean."""
    beads = sample.positions[sample.chains[0]]
    spacing = sample.reference_gap + 2.0 * sample.radii[0]
    return np.linalg.norm(beads[links:] - beads[:-links], axis=1).mean() / (links * spacing)


def test_laid_sample_is_free_of_overlap_and_its_wire_as_long_as_said():
    laid = lay_sample_3d(150, 121, wires=2, seed=1)
    assert laid.wires == (60, 60)
    x, r = laid.positions, laid.radii
    gaps = np.linalg.norm(x[:, None] - x[None], axis=2) - r[:, None] - r[None]
    np.fill_diagonal(gaps, np.inf)
    assert gaps.min() > -1e-9 * r.min()
    for chain in laid.chains:
        links = np.linalg.norm(np.diff(x[chain], axis=0), axis=1) - 2.0 * r[0]
        np.testing.assert_allclose(links, laid.reference_gap, rtol=1e-9)
    assert r[0] == pytest.approx(0.2 * 0.4e-3)
    assert ((x - r[:, None] > -1e-12) & (x + r[:, None] < laid.box + 1e-12)).all()
    assert lay_sample_3d(20, 0).wires == ()


def test_compaction_is_dense_at_rest_and_free_of_overlap(compaction_3d):
    """The random close packing of such spheres has 0.64; in a box of five grains its walls take some of it away."""
    assert compaction_3d.at_rest
    assert 0.60 < compaction_3d.solid_fraction < 0.66
    assert compaction_3d.solid_fraction == inner_solid_fraction(compaction_3d.sample)
    # of a bead's radius, a sixth of a grain's; a thousandth of the error of doing nothing, in each of hundreds of steps
    assert compaction_3d.penetration < 0.02 * compaction_3d.sample.radii[0]
    assert compaction_3d.mean_residual <= 1e-3
    # of walls, mean over the window that is judged
    assert np.abs(compaction_3d.stress + PRESSURE * np.eye(3)).max() < 0.02 * PRESSURE


def test_the_network_is_that_of_frictionless_grains(compaction_3d):
    """Isostatic: 6 contacts a particle, a little less where many are at walls, as such a contact counts for one particle
    only. At equal pressures the fabric is isotropic: the mean of n_z^2 over 500 directions is 1/3 to 0.3/sqrt(500) =
    0.013, and three times that is allowed."""
    assert 4.5 < compaction_3d.coordination < 6.5
    assert compaction_3d.rattlers < 0.15
    assert np.trace(compaction_3d.fabric) == pytest.approx(1.0)
    np.testing.assert_allclose(compaction_3d.fabric, np.eye(3) / 3.0, atol=0.04)


@pytest.mark.long
def test_friction_leaves_the_sample_looser(compaction_3d):
    rough = relax(lay_sample_3d(150, 120, seed=1), friction=0.4)
    assert rough.solid_fraction < compaction_3d.solid_fraction - 0.01
    assert rough.coordination < compaction_3d.coordination


def test_the_wire_keeps_its_length(sample_3d):
    beads = sample_3d.positions[sample_3d.chains[0]]
    links = np.linalg.norm(np.diff(beads, axis=0), axis=1)
    assert links.max() < 1.01 * (sample_3d.reference_gap + 2.0 * sample_3d.radii[0])


@pytest.mark.long
def test_without_drag_the_wire_is_crumpled(sample_3d):
    """Measured: 0.93 as laid, 0.87 with the drag, 0.73 without."""
    laid = lay_sample_3d(150, 120, seed=1)
    crumpled = straightness(relax(laid, drag=0.0, max_steps=300).sample)
    lost, lost_with_drag = straightness(laid) - crumpled, straightness(laid) - straightness(sample_3d)
    assert lost > 1.5 * lost_with_drag > 0.0


def test_drag_is_exact_and_leaves_no_trace_in_a_failed_step():
    """A disk that meets nothing: v(t) = v(0) exp(-t / drag time)."""

    def push(time):
        return 1.0 / (time < 0.45)  # fails later on

    scene = lm.Scene(dimension=2)
    disk = scene.add(lm.disk(radius=1.0, position=(0, 0), mass=1.0, velocity=(1.0, 0.0)))
    disk.impose_force(spin=push)
    sim = DampedSimulation(scene, drag_time=0.5, time_step=0.1)
    sim.run(steps=4)
    assert disk.velocity[0] == pytest.approx(np.exp(-0.4 / 0.5), rel=1e-14)
    before = sim.velocities.copy()
    with pytest.raises((RuntimeError, ZeroDivisionError)):
        sim.run(steps=2)
    np.testing.assert_array_equal(sim.velocities, before)


def rows(box, sample, **changed):
    """Of a box at rest, for a window."""
    count, d = WINDOW + 1, sample.dimension
    area = np.array([np.prod(np.delete(sample.box, k)) for k in range(d)])
    calm = {
        "reactions": np.tile(np.repeat(PRESSURE * area, 2), (count, 1)),
        "size": np.tile(sample.box, (count, 1)),
        "unbalanced": np.zeros(count),
        "kinetic": np.zeros(count),
    }
    return {**calm, **changed}


def test_rest_is_all_four_at_once(sample_3d):
    box = Box(sample_3d, density=DENSITY, friction=0.0)
    calm = rows(box, sample_3d)
    d, count = sample_3d.diameter, len(sample_3d.radii)
    still = unrest(calm, PRESSURE, box)
    assert still.is_rest
    assert still.volume_change == 0.0
    assert still.imbalance == pytest.approx(0.0, abs=1e-12)

    pushed = calm["reactions"].copy()
    pushed[:, 1] *= 1.03
    of_floor = calm["reactions"].copy()
    of_floor[:, 4] *= 1.03
    shrunk = calm["size"].copy()
    shrunk[-1, 1] *= 1.0 - 4e-4
    restless = {
        "imbalance": (unrest({**calm, "reactions": pushed}, PRESSURE, box), 0.03),
        "volume_change": (unrest({**calm, "size": shrunk}, PRESSURE, box), 4e-4),
        "force": (unrest({**calm, "unbalanced": np.full(51, 0.03 * PRESSURE * d**2)}, PRESSURE, box), 0.03),
        "kinetic": (unrest({**calm, "kinetic": np.full(51, 2e-4 * count * PRESSURE * d**3)}, PRESSURE, box), 2e-4),
    }
    for name, (left, value) in restless.items():
        assert getattr(left, name) == pytest.approx(value, rel=1e-6), name
        assert not left.is_rest, name
    assert unrest({**calm, "reactions": of_floor}, PRESSURE, box).is_rest  # it is held, not loaded
    assert not unrest({name: values[:-1] for name, values in calm.items()}, PRESSURE, box).is_rest
    assert not Unrest().is_rest


def test_a_sample_that_is_at_rest_is_left_as_it_is(compaction_3d):
    """Compacted once more it needs a window, and what it may move by is what rest allows."""
    sample = compaction_3d.sample
    again = relax(sample)
    assert again.at_rest
    assert again.steps < compaction_3d.steps
    assert np.prod(again.sample.box) == pytest.approx(np.prod(sample.box), rel=0.01)


def test_a_file_changes_no_bit_and_a_finished_compaction_is_only_read(tmp_path):
    laid = lay_sample_3d(40, 30, seed=1)
    options = {"pressure": PRESSURE, "density": DENSITY, "drag": 2.0, "max_steps": 60}
    options["time_step"] = 0.08 * characteristic_time(laid.diameter, DENSITY, PRESSURE)
    file = tmp_path / "compaction.h5"
    stop = iter([False] * 25 + [True])
    with pytest.raises(KeyboardInterrupt):
        compact(laid, file=file, interrupted=lambda: next(stop), **options)
    done = compact(laid, file=file, **options)
    again, kept = compact(laid, file=file, **options), compact(laid, **options)
    for other in (again, kept):
        np.testing.assert_array_equal(done.sample.positions, other.sample.positions)
        np.testing.assert_array_equal(done.fabric, other.fabric)
        assert (done.unrest, done.coordination, done.steps) == (other.unrest, other.coordination, other.steps)
    with pytest.raises(ValueError, match=r"'notes drag' is 2.0 there and 3.0 here"):
        compact(laid, file=file, **{**options, "drag": 3.0})
