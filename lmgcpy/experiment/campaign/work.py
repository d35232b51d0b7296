"""The work of one case, in the worker that does it."""

from __future__ import annotations

import json
import os
import time as clock
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lmgcpy.errors import number, numbers, shown
from lmgcpy.errors import told as in_text
from lmgcpy.experiment.campaign.cases import FAILED, FINISHED, TO_COME, CampaignCase, CaseResult, is_text
from lmgcpy.experiment.study.engine import Site, Study, carry_out_study
from lmgcpy.experiment.study.folder import StudyFolder
from lmgcpy.experiment.study.stages import Tick
from lmgcpy.version import versions

TOLD_EVERY = 0.5
"""Shortest time between two words on the progress of a case [s]."""


@dataclass(frozen=True)
class Order:
    """An order for a worker: a case, and the campaign to which it belongs."""

    case: CampaignCase
    campaign: str
    """Folder of the campaign, as the one who ordered sees it."""
    versions: dict[str, str]
    """Of the one who ordered."""

    @property
    def progress_file(self) -> Path:
        """File into which the case writes how far it is."""
        return Path(self.campaign) / "cases" / f"{self.case.name}.progress"


class Told:
    """Stages of a case, written to a file that the campaign reads: {"stage": ..., "done": ..., "total": ...}."""

    def __init__(self, file: Path | None):
        self._file = file
        self._last = 0.0

    @contextmanager
    def stage(self, name: str, total: int) -> Iterator[Tick]:
        """A stage of at most ``total`` steps."""

        def tick(done: int) -> None:
            now = clock.monotonic()
            if self._file is not None and (now > self._last + TOLD_EVERY or done == 0):
                self._last = now
                with suppress(OSError):  # nobody's result depends on it
                    new = self._file.with_suffix(f".{os.getpid()}")
                    new.write_text(json.dumps({"stage": name, "done": done, "total": total}), encoding="utf-8")
                    new.replace(self._file)

        tick(0)
        yield tick


def do_case(order: Order) -> CaseResult:
    """Do a case; errors are in the result. The status is "to come" where the campaign was stopped before the end.

    Runs are recorded in the case's folder and go on from there, if the worker sees the folder of the campaign.
    """
    case, here = order.case, versions()
    begin = clock.perf_counter()

    def made(status: str, error: str = "", numbers: Any = None, curves: Any = None) -> CaseResult:
        seconds = clock.perf_counter() - begin
        error = error.encode("utf-8", "backslashreplace").decode()  # as files and terminals can hold it
        return CaseResult(case.name, case.parameters, status, seconds, error, numbers or {}, curves or {}, here)

    if here["lmgcpy"] != order.versions["lmgcpy"]:
        have = f"The worker has lmgcpy {here['lmgcpy']}, the campaign {order.versions['lmgcpy']}"
        return made(FAILED, f"{have}: install the same version there.")
    campaign = Path(order.campaign)
    seen = (campaign / "campaign.json").exists()
    folder = campaign / "cases" / case.name if seen else None
    told = Told(order.progress_file if seen else None)
    stop = campaign / ".stop"

    def stopped() -> bool:
        return seen and stop.exists()

    if stopped():
        return made(TO_COME)
    try:
        numbers, curves = _computed(case, folder, told, stopped)
    except KeyboardInterrupt:
        return made(TO_COME) if stopped() else made(FAILED, "KeyboardInterrupt: the case raised it itself.")
    except SystemExit as error:
        return made(FAILED, f"SystemExit: the case called sys.exit({in_text(error.code)}).")
    except (Exception, GeneratorExit) as error:
        return made(FAILED, f"{type(error).__name__}: {in_text(error, str)}")
    finally:
        if told._file is not None:
            with suppress(OSError):
                told._file.unlink(missing_ok=True)
    return made(FINISHED, "", numbers, curves)


def _computed(case: CampaignCase, folder: Path | None, told: Any, stopped: Any) -> tuple[dict[str, float], dict[str, Any]]:
    """Numbers and curves of a case."""
    if isinstance(case.work, Study):
        kept = None if folder is None else StudyFolder(folder, type(case.work))
        resume = kept is not None and _holds(kept, case.work)
        result = carry_out_study(case.work, told, kept, resume=resume, stopped=stopped)
        return case.work.measures(result)
    if folder is not None:
        folder.mkdir(exist_ok=True)
    site = Site(told, folder, stopped)
    with site.listening():
        return as_result(case.work(site, **case.arguments), case.work.__name__)


def _holds(folder: StudyFolder, study: Study) -> bool:
    """Whether a folder holds this study, from which it goes on; one that is damaged is begun anew."""
    try:
        return folder.study_file.exists() and folder.read() == study
    except ValueError:
        return False


def as_result(given: Any, name: str) -> tuple[dict[str, float], dict[str, Any]]:
    """Numbers and curves in the result of a function; TypeError or ValueError with a sentence."""
    if not isinstance(given, Mapping) or not all(isinstance(key, str) for key in given):
        raise TypeError(f"{name} must return numbers and arrays by name, got {shown(given)}.")
    for key in given:
        if not is_text(key):
            raise ValueError(f"{name} returned a result under the name {shown(key)}, which no file can hold.")
    single: dict[str, float] = {}
    columns: dict[str, np.ndarray] = {}
    for key, value in given.items():
        if np.ndim(value) == 0:
            single[key] = number(value, f"'{key}' that {name} returned")
        else:
            columns[key] = numbers(value, f"'{key}' that {name} returned")
            if columns[key].ndim != 1:
                raise ValueError(f"'{key}' that {name} returned must be a number or a column, got shape {np.shape(value)}.")
    if len({len(column) for column in columns.values()}) > 1:
        lengths = ", ".join(f"'{key}' {len(column)}" for key, column in columns.items())
        raise ValueError(f"The columns that {name} returned must be of one length, got {lengths}.")
    return single, {"": columns} if columns else {}
