"""Compaction and shear of periodic cells: the stress that is held, what is reported, and files."""

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.experiment import PeriodicCell, PeriodicSample, PeriodicShear, compact, lay_periodic

PRESSURE = 1e5


@pytest.fixture(scope="module", params=[2, pytest.param(3, marks=pytest.mark.long)])
def compaction(request):
    dimension = request.param
    radii = lm.sample.grading(60, minimum=0.005, maximum=0.010, dimension=dimension, seed=0)
    return compact(lay_periodic(radii, dimension=dimension, seed=0), pressure=PRESSURE)


def test_scattered_grains_do_not_overlap_across_faces_either():
    radii = lm.sample.grading(80, minimum=0.005, maximum=0.010, seed=2)
    cell = (0.25, 0.2)
    positions = lm.sample.scatter(radii, cell=cell, seed=1)
    apart = positions[:, None] - positions[None]
    apart -= np.array(cell) * np.rint(apart / cell)
    distance = np.linalg.norm(apart, axis=2)
    np.fill_diagonal(distance, np.inf)
    assert (distance >= radii[:, None] + radii[None] - 1e-15).all()
    assert ((positions >= 0.0) & (positions < cell)).all()
    assert (positions == lm.sample.scatter(radii, cell=cell, seed=1)).all()


def test_a_compacted_cell_has_the_imposed_stress(compaction):
    """It is called at rest where no component of the mean stress is off by more than 1e-3 of the pressure. Without friction
    the grains are about isostatic: 2 D contacts a grain that carries, within what 60 grains scatter."""
    d = compaction.sample.dimension
    assert compaction.at_rest
    assert compaction.unconverged == 0
    assert np.abs(compaction.stress + PRESSURE * np.eye(d)).max() < 1e-3 * PRESSURE
    assert compaction.coordination == pytest.approx(2 * d, rel=0.1)
    assert {2: 0.80, 3: 0.58}[d] < compaction.solid_fraction < {2: 0.87, 3: 0.68}[d]
    # the cell deforms and does not turn: its first edge lies along x
    assert (compaction.sample.edges[0, 1:] == 0.0).all()
    assert compaction.penetration < 0.01 * compaction.sample.diameter


def test_shear_holds_the_normal_stress(compaction, tmp_path):
    shear = PeriodicShear(compaction.sample, pressure=PRESSURE, friction=0.4)
    record = shear.run(0.06, file=tmp_path / "shear.h5", frames=3)
    d = compaction.sample.dimension
    assert record.strain[-1] == pytest.approx(0.06)
    assert record.unconverged == 0
    late = record.mean(0.02)
    assert late["normal"] == pytest.approx(1.0, abs=0.03)
    assert 0.2 < late["friction"] < 0.8
    assert record.rate[:, 0, 1] == pytest.approx(shear.rate)
    held = record.rate.copy()
    held[:, 0, 1] = held[:, 1, 1] = 0.0
    assert not held.any()
    # what the cell has dilated is what its yielding edge has moved
    size = np.prod(np.diag(compaction.sample.edges))
    assert record.solid_fraction[-1] == pytest.approx(compaction.sample.solid_volume / shear.held.cell.volume)
    assert size == pytest.approx(compaction.sample.solid_volume / compaction.sample.solid_fraction)
    assert np.abs(record.defect).max() < 1e-10 * PRESSURE * size
    again = PeriodicShear(compaction.sample, pressure=PRESSURE, friction=0.4).run(
        0.06, file=tmp_path / "shear.h5", frames=3
    )
    assert (again.stress == record.stress).all()
    assert again.stress.shape == (len(record.strain), d, d)
    with pytest.raises(ValueError, match=r"The shear ended at a strain of 0\.06, before 0\.5"):
        record.mean(0.5)


def test_the_present_sample_lies_in_its_cell(compaction):
    held = PeriodicCell(compaction.sample, density=2600.0, friction=0.0)
    inside = held.cell.lattice.reduced(held.sample.positions, held.sample.edges)
    assert ((inside > -1e-12) & (inside < 1.0 + 1e-12)).all()
    assert held.sample.solid_fraction == pytest.approx(compaction.solid_fraction)


@pytest.mark.parametrize(
    ("call", "error", "says"),
    [
        (lambda: lay_periodic([0.01] * 40, dimension=2, solid_fraction=0.8), ValueError, "no place was found for"),
        (lambda: lay_periodic([0.01], dimension=4), ValueError, "dimension must be"),
        (lambda: lm.sample.scatter([0.1], cell=(0.3, 1.0)), ValueError, "the cell is too narrow"),
        (lambda: lm.sample.scatter([0.1], cell=(1.0, None)), ValueError, "this box must be closed"),
        (lambda: PeriodicSample([[0, 0]], [0.1], [1, 1]), ValueError, "edges of the periodic sample must be"),
        (lambda: compact(3, pressure=1.0), TypeError, "compact takes a Sample, .* or a PeriodicSample"),
        (lambda: PeriodicShear(None, pressure=-1.0), ValueError, "pressure must be above 0 Pa"),
    ],
)
def test_bad_arguments_get_a_sentence(call, error, says):
    with pytest.raises(error, match=says):
        call()
