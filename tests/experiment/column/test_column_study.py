"""The columns side by side: which content stands, what is written, interrupted and resumed."""

import csv
import json
import re
import shutil
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import lmgcpy as lm
import lmgcpy.view
from lmgcpy.cli import main
from lmgcpy.experiment.column import study as column_study
from lmgcpy.experiment.column.course import time_unit
from lmgcpy.experiment.column.result import Fall, bracket, lasting_tension, linear_content, middle
from lmgcpy.experiment.column.study import ColumnStudy
from lmgcpy.experiment.study.engine import carry_out_study
from lmgcpy.experiment.study.folder import StudyFolder
from lmgcpy.view import painter

TINY = ["column", "--grains", "30", "--contents", "0.6", "--travel", "2", "--aspect", "1", "--seed", "5"]
RUNS = ("pour-dry", "pour-0.6", "release-dry", "release-0.6")


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


# ------------------------------------------------------------------------------------------------- what stands, and where


def test_the_bracket_is_the_least_that_stands_and_the_next_that_falls():
    assert bracket({0.0: False, 0.1: False, 0.4: True, 0.8: True}) == (0.1, 0.4)
    assert bracket({0.0: False, 0.1: False}) == (0.1, None)
    assert bracket({0.0: True, 0.1: True}) == (None, 0.0)
    # what falls above the least that stands is luck, and not asked for
    assert bracket({0.0: False, 0.1: True, 0.8: False}) == (0.0, 0.1)


def test_the_next_content_lies_in_the_middle():
    assert middle({0.0: False, 0.1: False, 0.4: True}) == 0.2
    assert middle({0.0: False, 0.4: False}) is None
    assert middle({0.0: False, 0.4: True}) is None  # how little wire is still a wire is for the user to say
    assert middle({0.0: True, 0.4: True}) is None


class Outcome:
    """Of a column that stands from a content on."""

    def __init__(self, content, threshold):
        self.content, self.stands = content, content >= threshold


@pytest.mark.default_parameters("3.0-2-tried0")
@pytest.mark.parametrize(
    ("threshold", "refinements", "tried"),
    [
        (3.0, 2, [0.0, 1.0, 2.0, 2.83, 4.0]),
        (3.0, 0, [0.0, 1.0, 4.0]),
        (9.0, 2, [0.0, 1.0, 4.0]),
        (0.5, 2, [0.0, 1.0, 4.0]),
    ],
)
def test_the_ladder_is_refined_where_it_brackets(threshold, refinements, tried, monkeypatch):
    monkeypatch.setattr(column_study, "_fall", lambda site, study, content, laid: Outcome(content, threshold))
    study = ColumnStudy(contents=(4.0, 1.0), grain_count=60, refinements=refinements)
    assert [fall.content for fall in carry_out_study(study).falls] == tried


def course(height, radius):
    """A course that ends at this height and radius of 95 %."""
    return type("Course", (), {"height": np.array([[height, height]]), "spread": np.array([[radius] * 3])})()


@pytest.mark.parametrize(
    ("height", "radius", "stands"), [(0.96, 1.09, True), (0.94, 1.0, False), (1.0, 1.11, False), (0.4, 2.5, False)]
)
def test_a_column_stands_that_keeps_its_height_and_its_place(height, radius, stands):
    fall = Fall(0.1, None, course(2.0, 3.0), course(2.0 * height, 3.0 * radius))
    assert (fall.kept_height, fall.grown_radius) == (pytest.approx(height), pytest.approx(radius))
    assert fall.stands is stands


def test_an_error_in_one_column_ends_the_others(monkeypatch):
    def fail(site, study, content, laid):
        if content == 0.0:
            raise FloatingPointError("of the dry column")
        while not site.interrupted():
            time.sleep(0.01)
        raise KeyboardInterrupt

    monkeypatch.setattr(column_study, "_fall", fail)
    with pytest.raises(FloatingPointError, match="of the dry column"):
        carry_out_study(ColumnStudy(contents=(0.4,), grain_count=60))


def test_a_distance_of_nodes_is_of_a_thread():
    with pytest.raises(ValueError, match="node_distance is of a thread, and the wire of this study has beads"):
        ColumnStudy(node_distance=1.0)
    study = ColumnStudy(wire="thread", node_distance=1.1, grain_count=120)
    far, near = study.lay_column(0.8), replace(study, node_distance=0.7).lay_column(0.8)
    assert far.sample.thread
    assert far.sample.bead_count < 0.7 * near.sample.bead_count
    assert not study.lay_column(0.0).sample.thread


def test_a_study_from_before_there_were_threads_is_read(tmp_path):
    folder = StudyFolder(tmp_path / "study", ColumnStudy)
    folder.begin(ColumnStudy(seed=3))
    about = json.loads(folder.study_file.read_text())
    for field in ("wire", "node_distance"):
        del about["study"][field]
    folder.study_file.write_text(json.dumps(about))
    assert folder.read() == ColumnStudy(seed=3)


# ----------------------------------------------------------------------------------------------------- from end to end


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The folder of a study that was not interrupted; its pictures, which take longer than its runs, are coarse."""
    out = tmp_path_factory.mktemp("whole") / "study"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(painter, "FINER", 1)
        done = run(*TINY, "--out", out)
    assert done.exit_code == 0, done.output
    return out, done


def test_it_writes_what_it_promises(whole):
    out, done = whole
    told = done.stdout.splitlines()
    files = ("columns.csv", "course.csv", "course.png", "columns.png", "inside.png", "summary.md")
    assert told[: len(files)] == [str(out / name) for name in files]
    assert all((out / name).stat().st_size > 100 for name in files)
    assert {file.stem for file in (out / "runs").glob("*.h5")} == set(RUNS)
    summary = (out / "summary.md").read_text()
    assert "\n".join(told[len(files) :]) + "\n" == summary
    for part in ("## The columns", "## The dry column against experiments", "## The tension in the wire", "## The runs"):
        assert part in summary
    assert "nan" not in summary


@pytest.fixture(scope="module")
def again(whole):
    """Its result, of the runs in the folder."""
    folder = StudyFolder(whole[0], ColumnStudy)
    return carry_out_study(folder.read(), folder=folder, resume=True)


def test_tables_say_what_the_runs_hold(whole, again):
    out, _ = whole
    with (out / "columns.csv").open() as file:
        dry, wired = csv.DictReader(file)
    assert (dry["beads or nodes"], dry["wire content [km/m^3]"]) == ("0", "0")
    length_per_volume = float(wired["wire content [km/m^3]"])
    assert length_per_volume == pytest.approx(linear_content(again.falls[1]), rel=1e-5)
    # content / d^2, but for the volume: that of the settled column instead of that at a solid fraction of 0.6
    assert length_per_volume == pytest.approx(0.6 / 0.5e-3**2 / 1000.0, rel=0.35)
    with (out / "course.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["column"] == "wire 0.6"]
    with lm.io.open_run(out / "runs" / "release-0.6.h5") as it:
        assert len(rows) == len(it.history)
        spread = np.array([[float(row[f"radius of {share} % [m]"]) for share in (95, 99)] for row in rows])
        np.testing.assert_allclose(spread, it.observed["spread"][:, :2], rtol=1e-5)
        # a running mean, told by four digits
        assert 0.0 < float(wired["greatest tension [N]"]) <= 1.001 * it.observed["tension"][:, 0].max()


def test_lasting_tension_is_a_running_mean(again):
    """Constants stay, but for half a window at the ends; a blow of one step counts as what it is over a tenth of a unit."""
    fall = again.falls[1]
    steps = len(fall.release.time)
    count = round(0.1 * time_unit(fall.laid) / fall.release.time[0])
    blow = np.full((steps, 2), 3.0)
    blow[steps // 2] += 7.0 * count
    mean = lasting_tension(replace(fall, release=replace(fall.release, tension=blow)))
    assert mean[count : steps // 2 - count] == pytest.approx(3.0)
    assert mean.max() == pytest.approx(10.0)


@pytest.mark.long
def test_without_pyvista_it_says_what_is_missing(whole, tmp_path, monkeypatch):
    def missing(*arguments, **options):
        raise ImportError("Pictures need pyvista: pip install lmgcpy[view].")

    folder = StudyFolder(tmp_path / "study", ColumnStudy)
    shutil.copytree(whole[0], folder.path, ignore=shutil.ignore_patterns("*.png"))
    result = carry_out_study(folder.read(), folder=folder, resume=True)
    monkeypatch.setattr(lmgcpy.view, "render", missing)
    written = result.study.report(result, folder)
    assert [path.name for path in written] == ["columns.csv", "course.csv", "course.png", "summary.md"]
    assert "There is no picture of the columns. Pictures need pyvista" in folder.summary.read_text()


def without_seconds(summary):
    summary = re.sub(r"\d+ s of steps in all, \d columns", "", summary)
    return re.sub(r"\| \d+ \|$", "|", summary, flags=re.M)


def stopped(signal, name, step, *arguments):
    script = Path(__file__).parents[1] / "stop_study.py"
    command = [sys.executable, script, signal, name, str(step), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=100)


@pytest.mark.long
def test_interrupted_and_killed_it_is_the_same_study(whole, tmp_path):
    """Ctrl-C in a pour, SIGKILL in a release; what goes on gives every table and every run to the last bit."""
    out = tmp_path / "study"
    first = stopped("SIGINT", "pour-0.6", 5, *TINY, "--out", out)
    assert first.returncode == 130, first.stderr
    assert first.stdout == ""
    assert first.stderr.splitlines()[-1] == f"Interrupted; go on with: lmgcpy column --resume --out {out}"
    again = run(*TINY, "--out", out)
    assert again.exit_code == 1
    assert "holds an interrupted study: go on with lmgcpy column --resume" in again.output
    assert stopped("SIGKILL", "release-dry", 20, "column", "--resume", "--out", out).returncode == -9
    assert not (out / "summary.md").exists()
    last = run("column", "--resume", "--out", out, "--threads", 1)
    assert last.exit_code == 0, last.output
    for name in ("columns.csv", "course.csv"):
        assert (out / name).read_text() == (whole[0] / name).read_text()
    summaries = [without_seconds((folder / "summary.md").read_text()) for folder in (out, whole[0])]
    assert summaries[0] == summaries[1]
    for name in RUNS:
        with lm.io.open_run(out / "runs" / f"{name}.h5") as a, lm.io.open_run(whole[0] / "runs" / f"{name}.h5") as b:
            assert lm.io.compare(a, b) is None, name


def test_what_cannot_be_resumed_gets_a_sentence(whole, tmp_path):
    about = json.loads((whole[0] / "study.json").read_text())
    out = tmp_path / "study"
    out.mkdir()

    def told(text):
        (out / "study.json").write_text(text)
        done = run("column", "--resume", "--out", out)
        assert done.exit_code == 1
        assert "Traceback" not in done.output
        return " ".join(done.output.split())

    assert "study.json' is damaged (Expecting value" in told('{"format": ')
    assert "is of another kind of study, 'lmgcpy texsol study'" in told(
        json.dumps({**about, "format": "lmgcpy texsol study"})
    )
    wrong = {**about, "study": {**about["study"], "aspect": "high"}}
    assert "study.json' is damaged: aspect must be a number, got 'high'." in told(json.dumps(wrong))
    more = {**about, "study": {**about["study"], "colour": "blue"}}
    assert "(they differ in colour)" in told(json.dumps(more))


def test_quick_keeps_what_the_user_said():
    from lmgcpy.cli.column import new_study

    quick = new_study({}, True)
    assert quick.grain_count < ColumnStudy().grain_count
    assert new_study({"grains": 77, "diameter": 2.0}, True) == ColumnStudy(
        contents=quick.contents, grain_count=77, diameter=2e-3
    )
    assert new_study({"contents": (0.1, 0.7)}, True).contents == (0.1, 0.7)
