"""The work of one case, in the worker that does it, or in a process of its own, which can be killed when its time is over,
whatever it does: Dask cannot end a task."""

from __future__ import annotations

import faulthandler
import importlib
import multiprocessing
import os
import pickle
import signal
import threading
import time as clock
from collections.abc import Mapping
from concurrent.futures import BrokenExecutor
from contextlib import suppress
from dataclasses import dataclass
from importlib.util import find_spec
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any

import numpy as np

from lmgcpy.errors import number, numbers, shown
from lmgcpy.errors import told as in_text
from lmgcpy.experiment.campaign.cases import FAILED, FINISHED, TO_COME, CampaignCase, CaseResult, is_text
from lmgcpy.experiment.campaign.workers import end_with_parent
from lmgcpy.experiment.study.engine import Site, Study, carry_out_study
from lmgcpy.experiment.study.folder import StudyFolder
from lmgcpy.experiment.study.stages import ToldStages
from lmgcpy.version import versions

LONGEST_WAIT = 60.0
"""Longest single wait for a process; systems have bounds of their own [s]."""
GRACE = 10.0
"""Time in which a process must end after its case; a process whose worker is gone ends itself after the same time [s]."""


@dataclass(frozen=True)
class Order:
    """An order for a worker: a case, and the campaign to which it belongs."""

    case: CampaignCase
    campaign: str
    """Folder of the campaign, as the one who ordered sees it."""
    site: Site
    """The site of the campaign, which tells the case to end."""
    versions: dict[str, str]
    """Of the one who ordered."""

    @property
    def progress_file(self) -> Path:
        """File into which the case writes how far it is."""
        return Path(self.campaign) / "cases" / f"{self.case.name}.progress"


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
    told = ToldStages(order.progress_file if seen else None)
    if order.site.interrupted():
        return made(TO_COME)
    try:
        numbers, curves = _computed(case, folder, told, order.site)
    except KeyboardInterrupt:
        return made(TO_COME) if order.site.interrupted() else made(FAILED, "KeyboardInterrupt: the case raised it itself.")
    except SystemExit as error:
        return made(FAILED, f"SystemExit: the case called sys.exit({in_text(error.code)}).")
    except (Exception, GeneratorExit) as error:
        return made(FAILED, f"{type(error).__name__}: {in_text(error, str)}")
    finally:
        told.end()
    return made(FINISHED, "", numbers, curves)


def _computed(
    case: CampaignCase, folder: Path | None, told: ToldStages, campaign: Site
) -> tuple[dict[str, float], dict[str, Any]]:
    """Numbers and curves of a case."""
    if isinstance(case.work, Study):
        kept = None if folder is None else StudyFolder(folder, type(case.work))
        resume = kept is not None and _holds(kept, case.work)
        result = carry_out_study(case.work, told, kept, resume=resume, outer=campaign)
        return case.work.measures(result)
    if folder is not None:
        folder.mkdir(exist_ok=True)
    site = Site(told, folder, campaign)
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


# ------------------------------------------------------------------------------------------------ in a process of its own


def do_case_within(order: Order, seconds: float) -> CaseResult:
    """Do a case in a process of its own. A case that does not end in time is killed, with the processes that it began, and
    has failed.

    The time counts from the start of the process, imports included. Raises BrokenExecutor if the process dies.
    """
    multiprocessing.current_process().daemon = False  # as Dask's workers are; such processes may begin none
    spawn = multiprocessing.get_context("spawn")
    here, there = spawn.Pipe(duplex=False)
    process = spawn.Process(target=_alone, args=(there, _packed(order), seconds), daemon=True)
    end = clock.monotonic() + seconds
    with here:
        process.start()
        there.close()
        try:
            result = _answer(here, process, end)
            if result is not None:
                process.join(GRACE)
        except (EOFError, OSError):
            raise BrokenExecutor("The process of the case died") from None
        finally:
            _kill(process)
    return _killed(order, seconds) if result is None else result


def _answer(here: Connection, process: BaseProcess, end: float) -> CaseResult | None:
    """The result that the process sends until ``end``, None if it sends nothing; EOFError if it dies before."""
    while (left := end - clock.monotonic()) > 0.0:
        if wait([here, process.sentinel], min(LONGEST_WAIT, left)):
            if here.poll():
                return here.recv()
            raise EOFError
    return None


def _killed(order: Order, seconds: float) -> CaseResult:
    """The result of a case that did not end in time."""
    with suppress(OSError):
        order.progress_file.unlink()
    error = f"TimeoutError: the case did not end within {seconds:g} s and was killed."
    return CaseResult(order.case.name, order.case.parameters, FAILED, seconds, error, {}, {}, versions())


def _kill(process: BaseProcess) -> None:
    """End a process and those that it began."""
    with suppress(OSError, AttributeError):  # it is no group yet, or no longer; Windows has none
        os.killpg(process.pid, signal.SIGKILL)  # type: ignore[arg-type]
    process.kill()
    process.join()


def _packed(order: Order) -> bytes:
    """An order in bytes. A worker of Dask may have its function by value: only cloudpickle, which Dask needs, can pickle it
    again."""
    return importlib.import_module("cloudpickle" if find_spec("cloudpickle") else "pickle").dumps(order)


def _alone(there: Connection, order: bytes, seconds: float) -> None:
    """Do a case in this process, which Ctrl-C does not reach: the campaign tells the case to end."""
    with suppress(OSError, AttributeError):
        os.setpgid(0, 0)
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    # a case whose worker is gone is done again elsewhere
    threading.Thread(target=end_with_parent, args=(True,), daemon=True).start()
    with suppress(OverflowError):
        faulthandler.dump_traceback_later(seconds + GRACE, exit=True)
    there.send(do_case(pickle.loads(order)))
