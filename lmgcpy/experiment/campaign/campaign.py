"""A campaign: a study or a function, the parameters that are varied, and the cases that result; read from a TOML file.

    study = "texsol-3d"            # or "texsol", "column", or "module:name" of your own
    case_timeout = 3600            # a case that takes longer is killed and has failed [s]; no limit without it

    [fixed]                        # parameters of all cases
    grain_count = 800

    [over]                         # all combinations of these
    bead_count = [0, 200, 400]
    axes = ["z", "x"]
    seed = [0, 1, 2, 3, 4]

    [[cases]]                      # further ones, one by one
    bead_count = 800
"""

from __future__ import annotations

import dataclasses
import inspect
import itertools
import math
import os
import sys
import tomllib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from multiprocessing import current_process
from pathlib import Path
from typing import Any

from lmgcpy.errors import closest, flag, named_arguments, number, regular_file, shown, whole
from lmgcpy.experiment.campaign.case_queue import CaseQueue, executor_for
from lmgcpy.experiment.campaign.cases import CampaignCase, CampaignFolder, CampaignResults, Parameter, case_name, is_text
from lmgcpy.experiment.campaign.workers import GUARD, WORKER
from lmgcpy.experiment.study.engine import STUDIES, Study, study_or_function
from lmgcpy.experiment.study.stages import CaseStages

PLAIN = (bool, int, float, str, type(None))
"""Types of a parameter, which a file can hold; a tuple holds some of them."""
MOST = 1_000_000
"""Most cases of a campaign."""
KEYS = ("study", "case_timeout", "fixed", "over", "cases")
"""Keys of the TOML file."""


@named_arguments
@dataclass(frozen=True, repr=False)
class Campaign:
    """Many cases of one computation, which are independent of each other.

    ``work`` is a study, such as ``Study3D(grain_count=800)``, or a function ``work(site, **parameters)`` of a module. It
    returns a mapping: numbers by name, with the unit at the end of the name, as "strength [Pa]", and arrays of one length,
    the columns of a curve. ``site.run(name, label, steps, call, ...)`` gives a run of it a file from which it goes on, as
    in a study.

    ``over`` gives lists of values by parameter, all of whose combinations are cases, the last parameter changing fastest;
    ``cases`` lists further ones, each a mapping; ``fixed`` gives parameters that all cases have.

    ``case_timeout``: a case that takes longer [s] is killed and has failed, None for no such limit. Each case is then done
    in a process of its own, whose start, a few seconds, counts. It is no part of what the campaign computes: a campaign may
    go on with another one.

    Raises TypeError and ValueError with a sentence if the work has no such parameter, or if there is no case, or one twice.
    """

    work: Any
    over: Mapping[str, Iterable[Any]] = field(default_factory=dict)
    cases: Sequence[Mapping[str, Any]] = ()
    fixed: Mapping[str, Any] = field(default_factory=dict)
    case_timeout: float | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.work, Study) and not inspect.isfunction(self.work):
            raise TypeError(f"A campaign is of a study, or of a function of a module, got {shown(self.work)}.")
        if self.case_timeout is not None:
            object.__setattr__(self, "case_timeout", number(self.case_timeout, "case_timeout", above=0.0, unit="s"))
        if not isinstance(self.over, Mapping) or not isinstance(self.fixed, Mapping):
            raise TypeError("over and fixed of a campaign are mappings of parameters, as in over={'seed': range(5)}.")
        fixed = {name: _plain(value, name) for name, value in self.fixed.items()}
        over: dict[str, list[Parameter]] = {}
        for name, values in self.over.items():
            if isinstance(values, (str, bytes, Mapping)) or not isinstance(values, Iterable):
                raise TypeError(f"over['{name}'] of a campaign is a list of values, got {shown(values)}.")
            over[name] = [_plain(value, name) for value in values]
            if not over[name]:
                raise ValueError(f"over['{name}'] of a campaign has no value: there would be no case.")
        if isinstance(self.cases, (str, bytes, Mapping)) or not isinstance(self.cases, Iterable):
            raise TypeError(f"cases of a campaign is a list of mappings of parameters, got {shown(self.cases)}.")
        single = []
        for case in self.cases:
            if not isinstance(case, Mapping):
                raise TypeError(f"A case of a campaign is a mapping of parameters, got {shown(case)}.")
            single.append({name: _plain(value, name) for name, value in case.items()})
        for name, value in (("fixed", fixed), ("over", over), ("cases", single)):
            object.__setattr__(self, name, value)
        count = math.prod(len(values) for values in over.values())
        if count > MOST:
            raise ValueError(f"over of a campaign makes {count} cases, more than {MOST}: vary less at a time.")
        if not over and not single:
            raise ValueError("A campaign without over and cases has no case: give the parameters that are to be varied.")
        (name, count), *_ = Counter(case.name for case in self.all_cases()).most_common(1)
        if count > 1:
            raise ValueError(f"The campaign has the case '{name}' twice: take one of them out.")

    def all_cases(self) -> list[CampaignCase]:
        """The cases in their order: the combinations of ``over``, then ``cases``."""
        combined = [dict(zip(self.over, values, strict=True)) for values in itertools.product(*self.over.values())]
        return [self._case(parameters) for parameters in [*(combined if self.over else []), *self.cases]]

    def _case(self, parameters: Mapping[str, Any]) -> CampaignCase:
        own = dict(parameters)
        given = {**self.fixed, **own}
        name = case_name(own)
        if isinstance(self.work, Study):
            return CampaignCase(name, own, _study_with(self.work, given, name), {})
        try:
            inspect.signature(self.work).bind("site", **given)
        except TypeError as error:
            raise TypeError(f"Case '{name}': {self.work.__name__}(site, ...) cannot be called so: {error}.") from error
        return CampaignCase(name, own, self.work, given)

    def described(self) -> dict[str, Any]:
        """The description that a folder keeps: plain words, numbers and lists. The case_timeout may change on the way."""
        fields: dict[str, Any] = {}
        named: Any = self.work
        if isinstance(self.work, Study):
            named = type(self.work)
            # how many tests run at once changes no result
            fields = {name: _listed(v) for name, v in dataclasses.asdict(self.work).items() if name != "threads"}  # type: ignore[call-overload]
        return {
            "work": f"{named.__module__}:{named.__qualname__}",
            "study": fields,
            "fixed": {name: _listed(value) for name, value in self.fixed.items()},
            "cases": [{name: _listed(v) for name, v in case.parameters.items()} for case in self.all_cases()],
        }

    def run(
        self,
        out: str | os.PathLike,
        *,
        workers: int | None = None,
        executor: Executor | None = None,
        client: Any = None,
        scheduler: str | None = None,
        scheduler_file: str | None = None,
        resume: bool = False,
        force: bool = False,
        progress: bool = False,
    ) -> CampaignResults:
        """Carry the campaign out in the folder ``out`` and return its results.

        The cases go to ``workers`` processes of this machine, by default as many as it has processors; to an ``executor``
        of ``concurrent.futures``, which stays open; or to the Dask cluster of a ``client``, or of the ``scheduler`` at an
        address or in a file. The results have the same bits. A case that fails is recorded with its error; one whose worker
        dies is done again, from its run files if the worker sees the folder. ``resume`` goes on with the cases in the
        folder, to which others may be added (more seeds), and tries again those that failed; ``force`` writes into a
        folder that is not empty; ``progress`` shows the running cases on a terminal.

        Ctrl-C (KeyboardInterrupt) ends the runs between two steps. Raises FileExistsError, FileNotFoundError, ValueError or
        BlockingIOError if the folder is not fit for it, ConnectionError if no scheduler answers, and RuntimeError if
        workers have another version of lmgcpy.
        """
        if getattr(current_process(), "_inheriting", False):  # a worker imports the script that has begun it
            told = f"The script begins a campaign where it is imported, as by each worker: {GUARD}"
            raise SystemExit(1 if WORKER in os.environ else told)  # whoever began the worker says it
        flag(resume, "resume")
        flag(force, "force")
        flag(progress, "progress")
        if workers is not None:
            whole(workers, "workers", minimum=1)
        cases = self.all_cases()
        folder = CampaignFolder(out)
        folder.check(self.described(), resume=resume, force=force)
        with folder.held():
            folder.check(self.described(), resume=resume, force=force)  # as another one may have left it
            if resume:
                folder.enlarge(self.described())
            else:
                folder.begin(self.described())
            done = {result.name for result in folder.results(cases).finished}
            to_come = [case for case in cases if case.name not in done]
            if to_come:
                where = workers, executor, client, scheduler, scheduler_file
                stages = CaseStages(folder.cases, len(cases), len(done), quiet=not progress)
                with executor_for(len(to_come), *where) as (team, count), stages:
                    CaseQueue(to_come, folder, team, count, stages, self.case_timeout).go()
        return folder.results(cases)

    def __repr__(self) -> str:
        of = self.work.__name__ if inspect.isfunction(self.work) else type(self.work).__name__
        return f"<Campaign of {len(self.all_cases())} cases of {of}>"


def read_campaign(path: str | os.PathLike) -> Campaign:
    """The campaign of a TOML file; ValueError or TypeError with a sentence that names the file.

    A function is looked for beside the file as well.
    """
    file = Path(regular_file(path, "the file of a campaign"))
    try:
        about = tomllib.loads(file.read_text(encoding="utf-8"))
    except ValueError as error:  # of TOML, or of what is no text
        raise ValueError(f"'{path}' is no TOML file: {error}.") from error
    for key in about:
        if key not in KEYS:
            raise ValueError(f"'{path}' has an unknown key '{key}'{closest(key, KEYS)}")
    word = about.pop("study", None)
    if not isinstance(word, str):
        raise ValueError(f"'{path}' must say the study, for example study = \"texsol-3d\", got {shown(word)}.")
    try:
        return Campaign(_work(word, file.resolve().parent), **about)
    except (TypeError, ValueError) as error:
        raise type(error)(f"'{path}': {error}") from error


def _work(word: str, beside: Path) -> Any:
    """The study with its defaults, or the function."""
    if word not in STUDIES:
        if ":" not in word:
            raise ValueError(f"There is no study '{word}'{closest(word, [*STUDIES, 'module:function'])}")
        if str(beside) not in sys.path:
            sys.path.insert(0, str(beside))  # processes of this machine begin with the same path
    found = study_or_function(word)
    return found() if isinstance(found, type) else found


def _study_with(study: Study, given: Mapping[str, Any], case: str) -> Study:
    """The study with other values of some of its fields. A single value is taken as a tuple of one."""
    fields = {item.name: getattr(study, item.name) for item in dataclasses.fields(study)}  # type: ignore[arg-type]
    for name in given:
        if name not in fields or name == "threads":
            known = [name for name in fields if name != "threads"]
            raise ValueError(f"{type(study).__name__} has no parameter '{name}' to be varied{closest(name, known)}")
    values = {
        name: (value,) if isinstance(fields[name], tuple) and not isinstance(value, tuple) else value
        for name, value in given.items()
    }
    try:
        return dataclasses.replace(study, **values, threads=1)  # type: ignore[type-var]
    except (TypeError, ValueError) as error:
        raise type(error)(f"Case '{case}': {error}") from error


def _plain(value: Any, name: str) -> Parameter:
    """A parameter as a file can hold it; TypeError with a sentence if no file can."""
    value = value.item() if hasattr(value, "item") and getattr(value, "ndim", 0) == 0 else value
    if isinstance(value, (list, tuple)):
        return tuple(_plain(item, name) for item in value)
    if isinstance(value, str) and not is_text(value):
        raise ValueError(f"Parameter '{name}' of a campaign is {shown(value)}, which no file can hold.")
    if not isinstance(value, PLAIN):
        raise TypeError(f"Parameter '{name}' of a campaign is a number, a word or a tuple of these, got {shown(value)}.")
    return value


def _listed(value: Any) -> Any:
    return [_listed(item) for item in value] if isinstance(value, tuple) else value
