"""The engine of studies: stages, run files, interruption, resume, an executor for what is independent, order of errors.

A study is a frozen dataclass, a subclass of :class:`Study`, whose fields say what to compute. It states four things and
nothing else:

* what it **lays**: ``lay`` makes the sample; nothing has been written yet, and an error here leaves no folder;
* how it **prepares**: ``prepare`` brings the sample into the state from which every test starts;
* what it **tests**: ``tests`` lists tasks that are independent of each other; it is asked again with their
  results, and may list further ones, such as the next step of a bisection;
* what it **reports**: ``result`` gathers the results, ``report`` writes tables, figures, a summary.

:func:`~lmgcpy.experiment.carry_out_study` does the rest. A task is a function of a module with arguments that can be
pickled; it gets a :class:`Site` first, by which it starts its runs::

    def compress(site, study, sample, law):
        test = Biaxial(sample, law)
        steps = test.step_count(study.strain)
        return site.run("wire", "biaxial test", steps, test.run, study.strain)

So it runs in a thread, in another process, or on another machine that sees the study's folder, with the same result.
Every run has a file in the folder, from which it goes on after an interruption. A further study is about 200 lines: some
60 say what to compute, as in ``tests/experiment/study/slides.py``, the others are its options and its report.
"""

from __future__ import annotations

import importlib
import inspect
import tempfile
import threading
import uuid
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_EXCEPTION, BrokenExecutor, CancelledError, Executor, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager, nullcontext, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from lmgcpy.experiment.study.folder import RunNames, StudyFolder
from lmgcpy.experiment.study.stages import Stages
from lmgcpy.simulation.simulation import between_steps

STUDIES = {
    "texsol": "lmgcpy.experiment.texsol.study:Study2D",
    "texsol-3d": "lmgcpy.experiment.texsol.study:Study3D",
    "column": "lmgcpy.experiment.column.study:ColumnStudy",
}
"""The registered studies: where each class is, by the word for it. A campaign knows of studies what is here."""
LOOK = 0.2
"""Interval at which the engine looks whether Ctrl-C was pressed while tasks are under way [s]."""


class Site:
    """The site at which the tasks of a study work: it gives every run its file and its stage, and says whether the run
    shall end.

    Threads share it. Another process gets a copy. The copy ends its runs if it finds a file, which the engine creates
    beside the run files, or among the temporary files if the study has no folder. A study that is a case of a campaign has
    a site inside the site of the campaign, and ends with it.
    """

    def __init__(self, stages: Stages, runs: Path | None, outer: Site | None = None):
        self._stages = stages
        self._runs = runs
        self._outer = outer
        self._stop_file = (Path(tempfile.gettempdir()) if runs is None else runs) / f".stop-{uuid.uuid4().hex}"
        self._stopped = threading.Event()
        self._pressed: Callable[[], bool] = lambda: False
        self.is_copy = False

    def __repr__(self) -> str:
        return f"<Site of a study: {'no folder' if self._runs is None else self._runs.parent}>"

    def __getstate__(self) -> dict[str, Any]:
        return {name: getattr(self, name) for name in ("_stages", "_runs", "_outer", "_stop_file")}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._stopped = threading.Event()
        self._pressed = lambda: False
        self.is_copy = True

    def stage(self, label: str, total: int) -> Any:
        """A stage of at most ``total`` steps; see :meth:`lmgcpy.experiment.Stages.stage`."""
        return self._stages.stage(label, total)

    def run(self, name: str, label: str, steps: int, call: Callable[..., Any], /, *arguments: Any, **options: Any) -> Any:
        """``call(*arguments, **options)``, with ``file``, ``on_step`` and ``interrupted`` of the run of that name.

        ``label`` is the name of its stage, which has at most ``steps`` steps.
        """
        file = None
        if self._runs is not None:
            file = self._runs / f"{name}.h5"
            RunNames(self._runs).enter(name, file)
        with self.stage(label, steps) as tick:
            return call(*arguments, file=file, on_step=tick, interrupted=self.interrupted, **options)

    def interrupted(self) -> bool:
        """Whether the runs shall end between two steps."""
        if self._pressed() or self._stopped.is_set() or (self._outer is not None and self._outer.interrupted()):
            return True
        return self.is_copy and self._stop_file.exists()

    def stop(self) -> None:
        """End all runs of the study between two steps, here and in other processes."""
        self._stopped.set()
        with suppress(OSError):  # on a full disk threads end now, other processes when their runs end
            self._stop_file.touch()

    @contextmanager
    def listening(self) -> Iterator[Callable[[], bool]]:
        """Let Ctrl-C end the runs between two steps; gives a function that returns whether it was pressed."""
        try:
            with between_steps() as self._pressed:
                yield self._pressed
        finally:
            if not self.is_copy:
                with suppress(OSError):  # the error of a folder that cannot be made is the one to show
                    self._stop_file.unlink()


@dataclass(frozen=True)
class Task:
    """A part of a study that is independent of the others: ``work(site, *arguments)``."""

    name: str
    """Name under which its result is kept."""
    work: Callable[..., Any]
    """A function of a module."""
    arguments: tuple[Any, ...] = ()
    """Can be pickled, as well as the result."""

    def __repr__(self) -> str:
        return f"<Task '{self.name}': {self.work.__name__}>"


class Study(ABC):
    """The base of the dataclasses of studies, which say what to compute; see the description of the module."""

    COMMAND: ClassVar[str]
    """The command of ``lmgcpy`` that makes such studies; it names their kind in study.json."""
    IGNORED: ClassVar[tuple[str, ...]] = ()
    """Beginnings of warnings that the runs of the study do not show, regular expressions."""

    FORMER: ClassVar[Mapping[str, Any]] = {}
    """Fields that studies of former versions did not have, with the values that say what those did."""

    threads: int
    """Number of tasks at once, if no executor is given."""

    @abstractmethod
    def lay(self, site: Site) -> Any:
        """Make the sample; nothing is written yet."""

    def prepare(self, laid: Any, site: Site) -> Any:
        """Bring the sample that was laid into the state from which all tests start."""
        return laid

    @abstractmethod
    def tests(self, prepared: Any, done: Mapping[str, Any]) -> Sequence[Task]:
        """The next tasks, the longest first, given the results of those that are ``done``; none when all are."""

    @abstractmethod
    def result(self, prepared: Any, done: Mapping[str, Any]) -> Any:
        """All that the study computed."""

    @abstractmethod
    def report(self, result: Any, folder: StudyFolder) -> list[Path]:
        """Write the report into the folder, the summary last; returns the files."""

    def measures(self, result: Any) -> tuple[dict[str, float], dict[str, dict[str, np.ndarray]]]:
        """The part of the result that a campaign keeps: numbers by name, with the unit at the end as "strength [Pa]", and
        by test columns of one length, the first of them the abscissa."""
        return {}, {}

    def expected_seconds(self) -> float | None:
        """Time that the study will take on one processor [s], None if nobody knows."""
        return None

    @classmethod
    def kind(cls) -> dict[str, Any]:
        """Entries of study.json beside the fields, by which the classes of one command differ."""
        return {}

    @classmethod
    def class_of(cls, about: Mapping[str, Any]) -> type[Study]:
        """The class of the study that study.json describes; KeyError if there is none."""
        return cls


def study_or_function(path: str) -> Any:
    """The class of the registered study of this name, or the function or class of a study that "module:name" names.

    Raises ValueError with a sentence if there is none.
    """
    module, _, name = STUDIES.get(path, path).partition(":")
    try:
        found = getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise ValueError(f"The study or function '{path}' cannot be imported: {error}.") from error
    if not inspect.isfunction(found) and not (isinstance(found, type) and issubclass(found, Study)):
        raise ValueError(f"'{path}' is neither a function nor the class of a study: give 'module:name' of one.")
    return found


def carry_out_study(
    study: Study,
    stages: Stages | None = None,
    folder: StudyFolder | None = None,
    *,
    resume: bool = False,
    executor: Executor | None = None,
    outer: Site | None = None,
) -> Any:
    """Carry a study out and return its result.

    With a ``folder`` every run is recorded in a file there; ``resume``: some of the files exist already, and their runs go
    on. Tasks run on the ``executor``, which stays open; without one, in as many threads as the study says. The result does
    not depend on it. Ctrl-C (KeyboardInterrupt), the end of an ``outer`` site, or an error in one run, ends every run
    between two steps; the files are then complete up to there. An error is raised before the interruptions that it caused.
    """
    site = Site(stages or Stages(quiet=True), None if folder is None else folder.runs, outer)
    with _ignoring(study), site.listening() as pressed:
        laid = study.lay(site)
        if folder is not None and resume:
            folder.run_names.take_up(folder.runs.glob("*.h5"))
        elif folder is not None:
            folder.begin(study)
        prepared = study.prepare(laid, site)
        done: dict[str, Any] = {}
        with ThreadPoolExecutor(study.threads) if executor is None else nullcontext(executor) as pool:
            while tasks := study.tests(prepared, done):
                futures = {task.name: pool.submit(_perform, study, task, site) for task in tasks}
                _finish(list(futures.values()), site, pressed)
                if site.interrupted():
                    raise KeyboardInterrupt
                done.update({name: future.result() for name, future in futures.items()})
    return study.result(prepared, done)


class RunInterrupted(Exception):
    """The interruption of a task in another process; executors take a KeyboardInterrupt for the end of their worker."""


def _perform(study: Study, task: Task, site: Site) -> Any:
    """Do a task in the thread or process to which the executor has brought it."""
    if not site.is_copy:
        return task.work(site, *task.arguments)
    with _ignoring(study), site.listening():  # the process has signals and warnings of its own
        try:
            return task.work(site, *task.arguments)
        except KeyboardInterrupt as interrupt:
            raise RunInterrupted(str(interrupt)) from None


def _finish(futures: Sequence[Future], site: Site, pressed: Callable[[], bool]) -> None:
    """Wait for all tasks; if one fails or Ctrl-C is pressed, stop the others, and raise what ended the study."""
    running: set[Future] = set(futures)
    try:
        while running:
            ended, running = wait(running, timeout=LOOK, return_when=FIRST_EXCEPTION)
            if pressed() or any(future.cancelled() or future.exception() for future in ended):
                site.stop()
                running = {future for future in running if not future.cancel()}
    except BaseException:
        site.stop()
        raise
    errors = [CancelledError() if future.cancelled() else future.exception() for future in futures]
    for error in sorted(filter(None, errors), key=_rank):
        raise KeyboardInterrupt(*error.args) if _rank(error) == 1 or (_rank(error) > 1 and pressed()) else error


def _rank(error: BaseException) -> int:
    """Order in which errors are raised: an error before the interruptions that it caused, then tasks that were lost."""
    later: tuple[Any, ...] = ((KeyboardInterrupt, RunInterrupted), BrokenExecutor, CancelledError)
    return next((k for k, kind in enumerate(later, start=1) if isinstance(error, kind)), 0)


@contextmanager
def _ignoring(study: Study) -> Iterator[None]:
    """Without the warnings that the study ignores."""
    with warnings.catch_warnings():
        for message in study.IGNORED:
            warnings.filterwarnings("ignore", message=message)
        yield
