"""The study's conclusions, each on made-up records whose answer is known, and one small study from end to end."""

import csv
from dataclasses import replace

import numpy as np
import pytest

from lmgcpy.experiment.biaxial import BiaxialRecord, Frame
from lmgcpy.experiment.study.engine import carry_out_study
from lmgcpy.experiment.study.folder import StudyFolder
from lmgcpy.experiment.texsol.conclusions import (
    column,
    compression_in_links,
    frames_at_equal_force,
    frames_of_column,
    stiffening,
)
from lmgcpy.experiment.texsol.report_2d import summary
from lmgcpy.experiment.texsol.result import deviation
from lmgcpy.experiment.texsol.study import Study2D

STRAIN = np.linspace(0.0002, 0.1, 500)


def record(reaction, law="rigid-wire", frames=()):
    reaction = np.asarray(reaction, dtype=float)
    zeros = np.zeros_like(reaction)
    return BiaxialRecord(
        law=law,
        tolerance=1e-2,
        inertial_number=1e-3,
        strain=STRAIN[: len(reaction)],
        reaction=reaction,
        top_force=reaction,
        lateral=zeros,
        size=np.ones((len(reaction), 2)),
        stress={part: np.zeros((len(reaction), 2, 2)) for part in ("total", "sand", "wire")},
        residual=zeros,
        iterations=zeros,
        interactions=zeros,
        kinetic=zeros,
        stored=zeros,
        defect=zeros,
        status=["converged"] * len(reaction),
        frames=list(frames),
    )


def frame(strain, forces, lines, in_wire, top_force=10.0):
    walls = np.array([0.0, 2.0, 0.0, 1.0])
    return Frame(strain, top_force, np.zeros((1, 2)), walls, np.array(lines), np.array(forces), np.array(in_wire))


def test_running_mean_keeps_constants_and_straight_lines():
    line = record(3.0 + 50.0 * STRAIN)
    np.testing.assert_allclose(line.smooth(line.reaction)[20:-20], line.reaction[20:-20], rtol=1e-12)
    constant = record(np.full(500, 7.0))
    np.testing.assert_allclose(constant.smooth(constant.reaction), 7.0, rtol=1e-12)


def test_stiffening_is_the_ratio_of_reactions():
    found = stiffening(record(np.full(500, 3.0)), record(np.full(500, 2.0), "none"), [0.01, 0.05, 0.2])
    assert found == [(0.01, pytest.approx(1.5)), (0.05, pytest.approx(1.5))]


def test_column_finds_where_the_rods_leave_the_wire():
    wire = record(np.ones(500))
    where, ratio = column(record(np.where(STRAIN < 0.06, 1.0, 5.0)), wire)
    # before half the width of the running mean, 0.25 %, has gone by, the step shows in the mean
    assert where == pytest.approx(0.06, abs=0.0025)
    assert ratio == pytest.approx(5.0)
    spike = np.where(np.abs(STRAIN - 0.05) < 3e-4, 9.0, 1.0)
    assert column(record(spike), wire)[0] is None
    assert column(record(np.full(500, 1.5)), wire) == (None, pytest.approx(1.5))


def test_compression_in_links_counts_vertical_load_of_pushed_links():
    """A vertical rod of length 1 with 4 N in a box 2 m x 1 m carries 4 N m / 2 m^2 = 2 Pa of 10 N / 2 m = 5 Pa."""
    lines = [[[0.0, 0.0], [0.0, 1.0]], [[0.0, 0.0], [1.0, 0.0]], [[0.0, 0.0], [0.0, 1.0]]]
    pushed = frame(0.03, [4.0, 9.0, -5.0], lines, [True, True, True])
    pulled = frame(0.05, [-4.0, -9.0, 5.0], lines, [True, True, False])
    share, where = compression_in_links(record(np.ones(500), frames=[pushed, pulled]))
    assert share == pytest.approx(0.4)
    assert where == 0.03


def test_deviation_is_relative_to_the_tighter_run():
    assert deviation(record(np.full(500, 11.0)), record(np.full(250, 10.0))) == pytest.approx(0.1)


def test_frames_at_equal_force():
    line = [[[0.0, 0.0], [0.0, 1.0]]]

    def frames(forces):
        return [frame(0.02 * (k + 1), [1.0], line, [False], top_force=force) for k, force in enumerate(forces)]

    stiff = record(np.ones(500), frames=frames([100.0, 150.0, 140.0, 300.0]))
    soft = record(np.ones(500), "none", frames=frames([90.0, 100.4, 140.5, 120.0]))
    one, two = frames_at_equal_force(stiff, soft)  # 100 and 140 N are in both; at 140 both are crushed more
    assert (one.strain, two.strain) == (0.06, 0.06)
    one, two = frames_at_equal_force(record(np.ones(500), frames=frames([200.0, 180.0, 220.0])), soft)
    assert (one.top_force, two.top_force) == (180.0, 140.5)


WIRES = ("rigid-wire", "rigid-rod")


@pytest.fixture(scope="module")
def result():
    return carry_out_study(
        Study2D(laws=("none", *WIRES), grain_count=60, bead_count=14, strain=0.012, check_strain=0.003, seed=2)
    )


@pytest.mark.long
def test_a_small_study_writes_what_it_promises(result, tmp_path):
    wires = (*WIRES, "elastic-wire", "elastic-rod")
    sizes = {"grain_count": 100, "bead_count": 20, "strain": 0.02, "check_strain": 0.004}
    result = carry_out_study(replace(result.study, laws=("none", *wires), **sizes))
    written = {path.name for path in result.study.report(result, StudyFolder(tmp_path / "out", Study2D))}
    assert written == {
        "reaction.csv", "reaction.png", "stress.csv", "stress.png", "links.csv", "links.png", "sample.png", "summary.md",
        *(f"chains-{law}.png" for law in wires),
    }  # fmt: skip
    with (tmp_path / "out" / "reaction.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["law"] for row in rows} == {"none", *wires}
    mine = [float(row["support reaction [N/m]"]) for row in rows if row["law"] == "rigid-wire"]
    np.testing.assert_allclose(mine, result.records["rigid-wire"].reaction, rtol=1e-5)


@pytest.mark.long
def test_the_summary_answers_the_questions(result):
    text = summary(result)
    for heading in ("Does the wire stiffen", "compression column", "The wire's part", "The runs", "the solver's"):
        assert heading in text
    assert "nan" not in text.lower()


@pytest.mark.long
def test_threads_do_not_change_the_result(result):
    study = result.study
    alone = carry_out_study(Study2D(**{**study.__dict__, "laws": ("rigid-wire",), "threads": 1, "check_strain": 0.0}))
    np.testing.assert_array_equal(alone.records["rigid-wire"].reaction, result.records["rigid-wire"].reaction)


def test_frames_of_the_column_are_those_beside_the_jump():
    line = [[[0.0, 0.0], [0.0, 1.0]]]
    frames = [
        frame(strain, [1.0], line, [True], force) for strain, force in ((0.03, 9.0), (0.055, 2.0), (0.07, 7.0), (0.09, 5.0))
    ]
    wire, rod = record(np.ones(500)), record(np.where(STRAIN < 0.06, 1.0, 5.0), "rigid-rod", frames)
    before, at = frames_of_column(rod, wire)
    assert (before.strain, at.strain) == (0.055, 0.07)
    assert frames_of_column(record(np.ones(500), "rigid-rod", frames), wire) is None
