"""A case in a process of its own, which can be killed when its time is over, whatever it does: Dask cannot end a task."""

from __future__ import annotations

import faulthandler
import importlib
import multiprocessing
import os
import pickle
import signal
import threading
import time as clock
from concurrent.futures import BrokenExecutor
from contextlib import suppress
from importlib.util import find_spec
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess

from lmgcpy.experiment.campaign.cases import FAILED, CaseResult
from lmgcpy.experiment.campaign.work import Order, do_case
from lmgcpy.experiment.campaign.workers import end_with_parent
from lmgcpy.version import versions

LONGEST_WAIT = 60.0
"""Longest single wait for a process; systems have bounds of their own [s]."""
GRACE = 10.0
"""Time in which a process must end after its case; a process whose worker is gone ends itself after the same time [s]."""


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
