"""The TexSol sample before and after its relaxation (issue of section 3: dense, no overlap, wire within its length)."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from lmgcpy.experiment.compaction import compact, inner_solid_fraction
from lmgcpy.experiment.texsol.sample import lay_sample, lay_sample_3d


def overlaps(sample):
    """Deepest overlap of any two particles, in radii of the finest."""
    x, r = sample.positions, sample.radii
    gaps = np.linalg.norm(x[:, None] - x[None], axis=2) - r[:, None] - r[None]
    np.fill_diagonal(gaps, np.inf)
    return -gaps.min() / r.min()


@pytest.fixture(scope="module")
def laid():
    return lay_sample(1700, 300, seed=0)


@pytest.fixture(scope="module")
def compaction(laid):
    return compact(laid, pressure=1e5, density=2600.0)


def test_laid_sample_has_no_overlap_and_a_wire_within_its_reference(laid):
    assert len(laid.radii) == 2000
    assert laid.bead_count == 300
    assert overlaps(laid) < 1e-9
    beads = laid.positions[:300]
    gaps = np.linalg.norm(np.diff(beads, axis=0), axis=1) - 2 * laid.radii[0]
    # every grain passes between two beads, and every link is slack by the twentieth part that the wire is laid with
    np.testing.assert_allclose(gaps, 2 * 0.010, rtol=1e-9)
    assert laid.reference_gap == pytest.approx(1.05 * 2 * 0.010)


@pytest.mark.long
def test_relaxation_is_dense_at_rest_and_free_of_overlap(laid, compaction):
    assert compaction.at_rest
    assert compaction.solid_fraction >= 0.80
    assert compaction.solid_fraction == inner_solid_fraction(compaction.sample)
    # the solver's tolerance of 1e-2 leaves overlaps; a hundredth of a radius is what it is trusted for
    assert compaction.penetration < 1e-2 * laid.radii.min() * 2
    assert compaction.unrest.imbalance < 0.02


@pytest.mark.long
def test_relaxation_keeps_the_wire_within_its_length(laid, compaction):
    """The wire's law holds to the solver's tolerance: no link is longer than its reference by more than 1 %."""
    sample = compaction.sample
    beads = sample.positions[:300]
    lengths = np.linalg.norm(np.diff(beads, axis=0), axis=1)
    assert lengths.max() < 1.01 * (sample.reference_gap + 2 * sample.radii[0])


def test_sand_alone():
    assert lay_sample(100, 0, seed=3).bead_count == 0


@pytest.mark.parametrize("wires", [1, 2])
@pytest.mark.parametrize(("distance", "every"), [(1.0, 3), (0.7, 2), (0.1, 1)])
def test_a_thread_follows_the_beads_at_a_node_distance(distance, every, wires):
    """Links of beads are 0.32 mean diameters long. The thread is as long as the wire of beads, and where that turns its
    nodes are closer, so that no segment is shorter than 0.95 of the wire between its ends."""
    of = {"wires": wires, "seed": 0}
    beads, thread = lay_sample_3d(60, 80, **of), lay_sample_3d(60, 80, **of, thread=True, node_distance=distance)
    link = beads.link_lengths[0][0]
    for one, other, lengths in zip(beads.chains, thread.chains, thread.link_lengths, strict=True):
        at = np.concatenate([[0], np.cumsum(np.round(lengths / link).astype(int))])
        off = np.linalg.norm(thread.positions[other] - beads.positions[one][at], axis=1)
        assert off.max() < 3.0 * beads.radii[0]  # segments that would cross are moved apart
        assert (off == 0.0).mean() > 0.8
        assert at[-1] == len(one) - 1
        chord = np.linalg.norm(np.diff(thread.positions[other], axis=0), axis=1)
        assert (chord >= 0.9 * lengths)[lengths > 1.5 * link].all()
        assert lengths.max() == pytest.approx(every * link)
    assert thread.wire_length == pytest.approx(beads.wire_length)
    assert thread.wires == tuple(len(chain) for chain in thread.chains)
    assert "nodes of" in repr(thread)


@pytest.mark.parametrize("thread", [False, True])
@pytest.mark.parametrize("slenderness", [0.5, 1.0, 2.0])
def test_a_sample_is_as_slender_as_asked_for(slenderness, thread):
    """To a grain of 5 to 14 in its height; as much sand and wire, which reaches up to the last grains."""
    sample = lay_sample_3d(600, 200, slenderness=slenderness, seed=1, thread=thread)
    width, depth, height = sample.box
    assert width == depth
    assert abs(height - slenderness * width) < sample.diameter
    nodes, grains = sample.positions[: sample.bead_count], sample.radii[sample.bead_count :]
    assert len(grains) == 600
    assert sample.wire_length == pytest.approx(199 * 0.32e-3)
    assert nodes[:, 2].max() > height - 2.5 * sample.diameter
    assert ((nodes > 0.0) & (nodes < sample.box)).all()


@pytest.mark.parametrize("seed", [2, 3, 4])
def test_a_thread_does_not_cross_itself(seed):
    """300 grains and a dense wire of 400 beads: segments that share no node keep their distance, to a twentieth of the
    thread's radius; segments through the beads' places would cross each other."""
    sample = lay_sample_3d(300, 400, seed=seed, thread=True)
    nodes, share = sample.positions[: sample.bead_count], np.linspace(0.0, 1.0, 21)[:, None]
    points = nodes[:-1, None] + share * np.diff(nodes, axis=0)[:, None]
    tree = cKDTree(points.reshape(-1, 3))
    pairs = tree.query_pairs(1.9 * sample.radii[0], output_type="ndarray") // 21
    assert (np.abs(np.diff(pairs, axis=1)) < 2).all()


def test_no_grain_lies_in_a_thread():
    """Grains stay off the segments, not only off the nodes: by the radius, to a fiftieth of it."""
    sample = lay_sample_3d(60, 80, seed=0, thread=True)
    nodes, grains = sample.positions[: sample.bead_count], sample.positions[sample.bead_count :]
    radius, start, way = sample.radii[0], nodes[:-1], np.diff(nodes, axis=0)
    share = np.clip(np.einsum("gsk,sk->gs", grains[:, None] - start, way) / (way**2).sum(axis=1), 0.0, 1.0)
    distance = np.linalg.norm(grains[:, None] - start - share[:, :, None] * way, axis=2)
    assert (distance - radius - sample.radii[sample.bead_count :, None]).min() > -0.02 * radius


def test_a_thread_may_be_thinner_than_beads():
    sample = lay_sample_3d(60, 80, seed=0, thread=True, thread_diameter=0.1e-3, node_distance=1.0)
    assert sample.radii[0] == 0.05e-3
    assert sample.link_lengths[0].max() == pytest.approx(3 * 0.32e-3)
