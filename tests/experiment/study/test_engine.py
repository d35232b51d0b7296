"""The engine of studies on a small study of its own: interrupted, resumed, on threads and processes, with errors."""

import importlib
import io
import math
import multiprocessing
import os
import pickle
import signal
import tempfile
from concurrent.futures import BrokenExecutor, CancelledError, Future, ProcessPoolExecutor, ThreadPoolExecutor

import numpy as np
import pytest
from slides import SLOPE, STEP, Slides

import lmgcpy as lm
import lmgcpy.experiment
from lmgcpy.experiment import ColumnStudy, Site, Stages, Study2D, Study3D, StudyFolder, carry_out_study
from lmgcpy.experiment.study.engine import RunInterrupted, _finish


@pytest.fixture(scope="module")
def processes():
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        yield pool


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The small study, carried out without interruption, and its folder."""
    folder = StudyFolder(tmp_path_factory.mktemp("whole") / "study", Slides)
    result = carry_out_study(Slides(), folder=folder)
    Slides().report(result, folder)
    return result, folder


class PressesCtrlC(Stages):
    """Sends Ctrl-C to the process when a stage is at a step."""

    def __init__(self, stage, step):
        super().__init__(quiet=True)
        self.at = (stage, step)

    def stage(self, name, total):
        stages = super().stage(name, total)

        class Watched:
            def __enter__(self):
                tick = stages.__enter__()

                def told(done):
                    tick(done)
                    if (name, done) == at:
                        os.kill(os.getpid(), signal.SIGINT)

                return told

            def __exit__(self, *exception):
                return stages.__exit__(*exception)

        at = self.at
        return Watched()


def files_of(folder):
    return {path.name for path in folder.runs.iterdir() if path.name != ".names"}


def same(one, other):
    return one.keys() == other.keys() and all(np.array_equal(one[name], other[name]) for name in one)


def test_what_it_computes(whole):
    """From rest the disk slides by g (sin a - mu cos a) t (t + h)/2: the scheme's sum of velocities, to round-off."""
    duration = Slides().steps * STEP
    for friction, (distance, height) in whole[0].items():
        pull = 9.81 * (math.sin(SLOPE) - friction * math.cos(SLOPE))
        assert distance == pytest.approx(0.5 * pull * duration**2, rel=2.0 / Slides().steps)
        assert height == pytest.approx(0.1, abs=1e-9)
    assert files_of(whole[1]) == {"held.h5", "slide-0.1.h5", "slide-0.3.h5"}
    assert "| 0.1 |" in whole[1].summary.read_text()


@pytest.mark.default_parameters("stage1")
@pytest.mark.parametrize("stage", [("held by friction", 7), ("slide at 0.3", 11)])
def test_interrupted_and_resumed_it_is_the_same(stage, whole, tmp_path):
    folder = StudyFolder(tmp_path / "study", Slides)
    with pytest.raises(KeyboardInterrupt):
        carry_out_study(Slides(), PressesCtrlC(*stage), folder)
    assert folder.interrupted
    assert files_of(folder) <= files_of(whole[1])
    result = carry_out_study(folder.read(), folder=folder, resume=True)
    assert same(result, whole[0])
    folder.read().report(result, folder)
    assert (folder.path / "slides.csv").read_text() == (whole[1].path / "slides.csv").read_text()
    for name in ("held", "slide-0.1", "slide-0.3"):
        with lm.io.open_run(folder.run_file(name)) as a, lm.io.open_run(whole[1].run_file(name)) as b:
            assert lm.io.compare(a, b) is None, name


@pytest.mark.long
def test_force_deletes_the_runs_of_the_former_study_and_nothing_else(tmp_path):
    """Files in ``runs`` that no run of the study wrote stay; one that is in the way of a run is named. Before, every .h5
    went."""
    folder = StudyFolder(tmp_path / "study", Slides)
    carry_out_study(Slides(frictions=(0.1, 0.2), steps=10), folder=folder)
    mine = [folder.runs / name for name in ("thesis.h5", "slide-9.h5", "held.h5.backup")]
    for file in mine:
        file.write_text("mine")
    (folder.runs / "slide-0.1.h5.mending").write_text("left by a kill")
    with (folder.runs / ".names").open("a") as names:
        names.write("../../outside\n/etc/hosts\n\0\n")
    (tmp_path / "outside.h5").write_text("mine")
    carry_out_study(Slides(frictions=(0.3,), steps=10), folder=folder)
    assert files_of(folder) == {"held.h5", "slide-0.3.h5", *(file.name for file in mine)}
    assert all(file.read_text() == "mine" for file in (*mine, tmp_path / "outside.h5"))
    with pytest.raises(FileExistsError, match=r"slide-9\.h5' is no file of this study: move it"):
        carry_out_study(Slides(frictions=(9,), steps=10), folder=folder)
    assert mine[1].read_text() == "mine"


@pytest.mark.long
def test_a_folder_of_before_goes_on_with_all_files_that_it_has(tmp_path):
    """Versions before 0.2 wrote no names."""
    folder = StudyFolder(tmp_path / "study", Slides)
    study = Slides(frictions=(0.1,), steps=10)
    result = carry_out_study(study, folder=folder)
    (folder.runs / ".names").unlink()
    assert same(carry_out_study(study, folder=folder, resume=True), result)
    folder.begin(study)
    assert not files_of(folder)


@pytest.mark.long
def test_every_executor_gives_the_same_bits(whole, processes, tmp_path):
    with ThreadPoolExecutor(1) as one:
        assert same(carry_out_study(Slides(), executor=one), whole[0])
        assert one.submit(int).result() == 0  # it stays open
    assert same(carry_out_study(Slides(), executor=processes), whole[0])
    folder = StudyFolder(tmp_path / "study", Slides)
    assert same(carry_out_study(Slides(), folder=folder, executor=processes), whole[0])
    assert files_of(folder) == files_of(whole[1])


@pytest.mark.long
def test_a_texsol_study_on_processes(processes):
    study = Study2D(
        laws=("none", "rigid-wire"), grain_count=20, bead_count=6, strain=0.004, tolerance=0.1, check_strain=0.0
    )
    here, there = carry_out_study(study), carry_out_study(study, executor=processes)
    for law, record in here.records.items():
        other = there.records[law]
        assert same(record.stress, other.stress)
        for name in ("strain", "reaction", "top_force", "residual", "iterations", "kinetic"):
            assert np.array_equal(getattr(record, name), getattr(other, name)), name


@pytest.mark.parametrize("study", [Study2D(grain_count=20, bead_count=6), Study3D(grain_count=20, bead_count=12)])
def test_tasks_can_be_pickled(study):
    laid = study.lay_sample()
    tasks = study.tests(type("Compaction", (), {"sample": laid})(), {})
    assert [task.name for task in pickle.loads(pickle.dumps(tasks))] == [task.name for task in tasks]


def test_tasks_of_the_column_can_be_pickled():
    study = ColumnStudy(contents=(0.6,), grain_count=30, aspect=1.0)
    tasks = study.tests(study.lay(None), {})
    assert [task.name for task in pickle.loads(pickle.dumps(tasks))] == ["fall-0.6", "fall-dry"]


@pytest.mark.default_parameters("threads")
@pytest.mark.parametrize("where", ["threads", "processes"])
def test_an_error_in_one_task_ends_the_others(where, processes, tmp_path):
    """The others have 100 000 steps to make."""
    folder = StudyFolder(tmp_path / "study", Slides)
    folder.begin(Slides())
    carry_out_study(Slides(frictions=()), folder=folder, resume=True)  # what is prepared
    study = FailsToSlide(frictions=(0.1, -1.0))
    with pytest.raises(ValueError, match="friction of law 'coulomb' must be at least 0"):
        carry_out_study(study, folder=folder, resume=True, executor=processes if where == "processes" else None)
    assert not [name for name in files_of(folder) if name.startswith(".stop")]
    file = folder.run_file("slide-0.1")
    if file.exists():  # it had begun
        with lm.io.open_run(file) as run:
            assert run.closed
            assert len(run.history) < 100_000


class FailsToSlide(Slides):
    """Long slides after a short preparation."""

    def tests(self, prepared, done):
        return Slides(self.frictions, 100_000).tests(prepared, done)


def ended(*outcomes):
    """Futures that ended so."""
    futures = []
    for outcome in outcomes:
        future = Future()
        if outcome is None:
            future.set_result(0)
        elif isinstance(outcome, CancelledError):
            future.cancel()
        else:
            future.set_exception(outcome)
        futures.append(future)
    return futures


@pytest.mark.parametrize(
    ("outcomes", "pressed", "raised"),
    [
        ((KeyboardInterrupt(), None, ValueError("first")), False, ValueError),
        ((CancelledError(), RunInterrupted("in a process"), OSError("full")), True, OSError),
        ((CancelledError(), RunInterrupted("in a process")), True, KeyboardInterrupt),
        ((CancelledError(), BrokenExecutor("killed")), False, BrokenExecutor),
        ((CancelledError(), BrokenExecutor("by Ctrl-C")), True, KeyboardInterrupt),
    ],
)
def test_the_order_of_errors(outcomes, pressed, raised):
    site = Site(Stages(quiet=True), None)
    with pytest.raises(raised), site.listening():
        _finish(ended(*outcomes), site, lambda: pressed)
    assert site.interrupted()


def test_a_copy_of_a_site_is_stopped_by_a_file(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    site = Site(Stages(quiet=True), None)
    copy = pickle.loads(pickle.dumps(site))
    assert not copy.interrupted()
    with site.listening():
        site.stop()
        assert copy.interrupted()
        assert len(list(tmp_path.iterdir())) == 1
    assert not list(tmp_path.iterdir())


def test_stages_tell_one_line_each_and_a_copy_has_no_bar(capsys):
    stream = io.StringIO()
    with Stages(stream).stage("sample", 3) as tick:
        tick(3)
    assert stream.getvalue().startswith("sample: ")
    copy = pickle.loads(pickle.dumps(Stages(stream)))
    assert not copy.terminal
    with copy.stage("there", 1):
        pass
    assert capsys.readouterr().err.startswith("there: ")


def test_the_front_door_has_the_names_it_says():
    for module, names in lmgcpy.experiment.MODULES.items():
        there = importlib.import_module(f"lmgcpy.experiment.{module}")
        for name in names:
            assert getattr(lmgcpy.experiment, name) is getattr(there, name)
    with pytest.raises(AttributeError, match="did you mean 'Biaxial'"):
        lmgcpy.experiment.Biaxal  # noqa: B018
