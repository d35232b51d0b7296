"""A TexSol study that is interrupted and killed and goes on gives what the uninterrupted one gives, bit for bit."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import lmgcpy as lm
from lmgcpy.cli import main
from lmgcpy.experiment.biaxial import Biaxial
from lmgcpy.experiment.compaction import compact
from lmgcpy.experiment.study.engine import carry_out_study
from lmgcpy.experiment.study.folder import StudyFolder
from lmgcpy.experiment.texsol.sample import lay_sample
from lmgcpy.experiment.texsol.study import Study2D, Study3D, TexSolStudy

OPTIONS = {
    **{"laws": "none,rigid-wire", "grains": 30, "beads": 8, "strain": 0.5, "tolerance": 0.1, "seed": 1},
    **{"preparation": "dense", "theta-max": 0.6},  # a relaxation that is long enough to be interrupted twice
}
TINY = ["texsol", *(str(word) for name, value in OPTIONS.items() for word in (f"--{name}", value))]
RUNS = ("compaction", "none", "none-tight", "rigid-wire", "rigid-wire-tight")


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def stopped(signal, name, step, *arguments):
    script = Path(__file__).parents[1] / "stop_study.py"
    command = [sys.executable, script, signal, name, str(step), *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, timeout=100)


def without_seconds(summary):
    summary = re.sub(r"^\d+ s of steps in all, \d tests at once", "", summary, flags=re.M)
    return re.sub(r"\| \d+ \|$", "|", summary, flags=re.M)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The folder of a study that was not interrupted."""
    out = tmp_path_factory.mktemp("whole") / "study"
    done = run(*TINY, "--out", out)
    assert done.exit_code == 0, done.output
    return out


def same_study(out, whole):
    """Every table to the letter, every number of every run to the bit; only times of the clock may differ."""
    for name in ("reaction.csv", "stress.csv"):
        assert (out / name).read_text() == (whole / name).read_text()
    summaries = [without_seconds((folder / "summary.md").read_text()) for folder in (out, whole)]
    assert summaries[0] == summaries[1]
    for name in RUNS:
        with lm.io.open_run(out / "runs" / f"{name}.h5") as a, lm.io.open_run(whole / "runs" / f"{name}.h5") as b:
            assert lm.io.compare(a, b) is None, name
            assert a.closed


@pytest.mark.long
def test_interrupted_and_killed_again_and_again_it_is_the_same_study(whole, tmp_path):
    """Ctrl-C and SIGKILL in the compaction (judged over 50 steps) and while two tests are under way."""
    out = tmp_path / "study"
    with lm.io.open_run(whole / "runs" / "compaction.h5") as it:
        steps = len(it.history)
    assert steps > 70
    go_on = ("texsol", "--resume", "--out", out)
    line = f"Interrupted; go on with: lmgcpy texsol --resume --out {out}"

    first = stopped("SIGINT", "compaction", 30, *TINY, "--out", out)
    assert first.returncode == 130, first.stderr
    assert first.stdout == ""
    assert first.stderr.splitlines()[1:] == [line]  # after that of the stage of the sample
    with lm.io.open_run(out / "runs" / "compaction.h5") as it:
        assert it.closed
        assert 30 <= len(it.history) < steps

    again = run(*TINY, "--out", out)
    assert again.exit_code != 0
    assert f"holds an interrupted study: go on with lmgcpy texsol --resume --out {out}" in again.output

    assert stopped("SIGKILL", "compaction", steps - 16, *go_on).returncode == -9
    with lm.io.open_run(out / "runs" / "compaction.h5") as it:
        assert not it.closed
        assert len(it.history) == steps - 16
    assert stopped("SIGKILL", "rigid-wire", 7, *go_on).returncode == -9
    assert not (out / "runs" / "none-tight.h5").exists()  # the last in the queue of two threads
    fourth = stopped("SIGINT", "rigid-wire", 13, *go_on)
    assert fourth.returncode == 130, fourth.stderr
    assert fourth.stderr.splitlines()[-1] == line
    for file in (out / "runs").glob("*.h5"):
        with lm.io.open_run(file) as it:
            assert it.closed
    with lm.io.open_run(out / "runs" / "rigid-wire.h5") as it:
        assert 13 <= len(it.history) < 26
    assert not (out / "summary.md").exists()

    before = (out / "runs" / "compaction.h5").read_bytes()
    last = run(*go_on, "--threads", 1)
    assert last.exit_code == 0, last.output
    assert last.stderr.count("biaxial test") == 4
    assert (out / "runs" / "compaction.h5").read_bytes() == before  # finished runs are read only
    same_study(out, whole)


@pytest.mark.long
def test_files_change_no_bit(whole):
    """The same study kept in memory."""
    about = json.loads((whole / "study.json").read_text())
    study = Study2D(**{**about["study"], "laws": tuple(about["study"]["laws"])})
    result = carry_out_study(study)
    again = carry_out_study(study, folder=StudyFolder(whole, TexSolStudy), resume=True)
    assert result.compaction.steps == again.compaction.steps > 0
    assert result.compaction.unrest == again.compaction.unrest
    assert np.array_equal(result.sample.positions, again.sample.positions)
    for mine, other in ((result.records, again.records), (result.checks, again.checks)):
        for law, record in mine.items():
            for name, value in vars(record).items():
                if name == "stress":
                    assert all(np.array_equal(part, other[law].stress[key]) for key, part in value.items())
                elif name == "frames":
                    for frame, same in zip(value, other[law].frames, strict=True):
                        assert all(np.array_equal(part, getattr(same, key)) for key, part in vars(frame).items())
                elif name != "seconds":
                    assert np.array_equal(value, getattr(other[law], name)), name


@pytest.mark.long
def test_force_begins_anew_and_a_finished_study_is_only_told_again(whole, tmp_path):
    out = tmp_path / "study"
    StudyFolder(out, TexSolStudy).begin(Study2D(grain_count=40))
    (out / "runs" / "rigid-rod.h5").write_text("of the former study")
    (out / "runs" / ".names").write_text("rigid-rod\n")
    done = run(*TINY, "--out", out, "--force")
    assert done.exit_code == 0, done.output
    same_study(out, whole)
    assert not (out / "runs" / "rigid-rod.h5").exists()
    (out / "summary.md").unlink()
    files = {file: file.read_bytes() for file in (out / "runs").iterdir()}
    assert run("texsol", "--resume", "--out", out).exit_code == 0
    same_study(out, whole)
    assert files == {file: file.read_bytes() for file in (out / "runs").iterdir()}


@pytest.mark.long
def test_a_study_under_way_is_left_alone(tmp_path):
    out = StudyFolder(tmp_path / "study", TexSolStudy)
    out.begin(Study2D())
    out.run_names.enter("none", out.run_file("none"))
    lm.Simulation(one_disk(), time_step=1.0).run(steps=1, record=out.run_file("none"))
    take = "import sys; from lmgcpy.writing import FileLock; lock = FileLock(sys.argv[1])"
    hold = f"{take}; print('held', flush=True); input()"
    with subprocess.Popen([sys.executable, "-c", hold, out.run_file("none")], stdin=-1, stdout=-1, text=True) as other:
        try:
            assert other.stdout.readline() == "held\n"
            told = run(*TINY, "--out", out.path, "--force")
        finally:
            other.kill()
    assert told.exit_code == 1
    assert "is under way: wait for its end" in told.output
    assert out.run_file("none").exists()


def one_disk():
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=1.0, position=(0, 0), mass=1.0))
    return scene


def test_the_summary_answers_the_questions(whole):
    text = (whole / "summary.md").read_text()
    for heading in ("Does the wire stiffen", "The wire's part", "The runs", "the solver's"):
        assert heading in text
    assert "nan" not in text.lower()


def test_what_cannot_be_resumed_gets_a_sentence(whole, tmp_path):
    def told(out, *arguments):
        done = run("texsol", "--resume", "--out", out, *arguments)
        assert done.exit_code not in (0, 130)
        assert "Traceback" not in done.output
        return " ".join(done.output.split())

    assert "There is no study to go on with in" in told(tmp_path / "nowhere")
    assert not (tmp_path / "nowhere").exists()
    assert "leave out --axial-rigidity, --quick, --seed" in told(whole, "--seed", 2, "--quick", "--axial-rigidity", 1e6)

    out = tmp_path / "study"
    folder = StudyFolder(out, TexSolStudy)
    about = json.loads((whole / "study.json").read_text())
    out.mkdir()

    def write(**fields):
        folder.study_file.write_text(json.dumps({**about, "study": {**about["study"], **fields}}))

    folder.study_file.write_text('{"format": ')
    assert "study.json' is damaged (Expecting value" in told(out)
    folder.study_file.write_text('{"format": "of another program", "study": {}}')
    assert "study.json' is damaged" in told(out)
    write(strain="much")
    assert "study.json' is damaged: strain must be a number" in told(out)
    write(colour="blue")
    assert "whose studies have other fields than those of this version (they differ in colour)" in told(out)


@pytest.mark.parametrize(("kind", "turn"), [(Study2D, 0.6), (Study3D, 0.1)])
def test_a_study_of_a_former_version_is_what_it_was(kind, turn, tmp_path):
    """Before 0.2 samples were relaxed without friction, and the turns of the wire and the solver were no fields."""
    folder = StudyFolder(tmp_path / "study", TexSolStudy)
    folder.begin(kind(seed=5))
    about = json.loads(folder.study_file.read_text())
    for field in kind.FORMER:
        del about["study"][field]
    folder.study_file.write_text(json.dumps(about))
    former = folder.read()
    assert former.seed == 5
    assert (former.preparation, former.theta_max, former.solver) == ("dense", turn, "accelerated")
    folder.begin(former)
    assert folder.read() == former


@pytest.mark.long
@pytest.mark.parametrize("name", ["compaction", "none"])
def test_a_run_of_another_study_is_refused_and_ends_the_others(name, whole, tmp_path):
    other, out = tmp_path / "other", tmp_path / "study"
    study = Study2D(laws=("none",), grain_count=30, bead_count=8, strain=0.005, tolerance=0.1, seed=2, check_strain=0.0)
    carry_out_study(study, folder=StudyFolder(other, TexSolStudy))
    StudyFolder(out, TexSolStudy).begin(StudyFolder(whole, TexSolStudy).read())
    (out / "runs" / f"{name}.h5").write_bytes((other / "runs" / f"{name}.h5").read_bytes())
    done = run("texsol", "--resume", "--out", out)
    assert done.exit_code == 1
    assert f"{name}.h5' is the file of another run: " in " ".join(done.output.split())
    assert not (out / "summary.md").exists()


@pytest.mark.long
def test_the_test_itself_is_part_of_what_its_file_is_of(tmp_path):
    """Loads and drives are functions, which are not in the file, but their numbers are."""
    sample = compact(lay_sample(30, 8, seed=1), pressure=1e5, density=2600.0).sample
    file = tmp_path / "test.h5"
    solver = lm.AcceleratedGaussSeidel(tolerance=0.1)
    first = Biaxial(sample, solver=solver).run(0.002, frames=2, file=file)
    again, step = Biaxial(sample, solver=solver).run(0.002, frames=2, file=file), Biaxial(sample).time_step
    np.testing.assert_array_equal(first.reaction, again.reaction)
    assert [frame.strain for frame in first.frames] == [frame.strain for frame in again.frames] != []
    with pytest.raises(ValueError, match=r"'notes strain' is 0.002 there and 0.003 here"):
        Biaxial(sample, solver=solver).run(0.003, frames=2, file=file)
    with pytest.raises(ValueError, match=r"'notes pressure' is 100000.0 there and 200000.0 here"):
        Biaxial(sample, pressure=2e5, time_step=step, solver=solver).run(0.002, frames=2, file=file)
