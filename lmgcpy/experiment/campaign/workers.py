"""Who does the cases: an executor of ``concurrent.futures``, of processes of this machine or of a Dask cluster."""

from __future__ import annotations

import asyncio
import json
import logging
import multiprocessing
import os
import signal
import threading
import time as clock
from collections.abc import Callable, Iterator
from concurrent.futures import BrokenExecutor, CancelledError, Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager, suppress
from multiprocessing import get_context
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from lmgcpy.errors import regular_file, shown
from lmgcpy.version import versions

ANSWER = 8.0
"""Time in which a scheduler must answer [s]."""
DEATHS = 4
"""A case is given up once this number of workers has died over it, the last one while it did no other case."""
WORKER = "LMGCPY_CAMPAIGN_WORKER"
"""Variable that the workers of this machine have."""
ENVIRONMENT = (WORKER, "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables that are 1 for them: one thread for linear algebra, as there are as many workers as processors."""
_CHANGES = threading.Lock()
"""Held while this process has the environment of its workers."""
GUARD = "put the call under if __name__ == '__main__':"
"""Advice for a script that begins a campaign."""


class OwnProcesses(Executor):
    """Processes of this machine that survive each other: each is a pool of its own, and another begins in its place if it
    dies. (A pool of several ends all of them if one dies.)"""

    def __init__(self, count: int):
        self._threads = ThreadPoolExecutor(count)
        self._idle: SimpleQueue[ProcessPoolExecutor] = SimpleQueue()
        pools = [_begun() for _ in range(count)]
        try:
            pools[0].submit(os.getpid).result()
        except BrokenExecutor as error:
            raise RuntimeError(
                f"The workers on this machine did not start ({error}). They import the script of the campaign: {GUARD} "
                "there."
            ) from None
        for pool in pools:
            self._idle.put(pool)

    def submit(self, call: Callable[..., Any], /, *arguments: Any, **options: Any) -> Future:
        """Let a process call a function of a module; BrokenExecutor if it dies."""
        return self._threads.submit(self._call, call, *arguments, **options)

    def _call(self, call: Callable[..., Any], /, *arguments: Any, **options: Any) -> Any:
        pool = self._idle.get()
        try:
            return pool.submit(call, *arguments, **options).result()
        except BrokenExecutor:
            pool.shutdown()
            pool = _begun()
            raise
        finally:
            self._idle.put(pool)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """End the processes after their work."""
        self._threads.shutdown(wait, cancel_futures=cancel_futures)
        while not self._idle.empty():
            self._idle.get().shutdown(wait)


def _begun() -> ProcessPoolExecutor:
    """A pool of one process, which begins now, in the environment of workers."""
    with _CHANGES, _environment():
        pool = ProcessPoolExecutor(1, get_context("spawn"), initializer=_as_worker)
        pool.submit(os.getpid)
    return pool


def cluster(client: Any) -> tuple[Executor, int]:
    """The workers of a Dask cluster that a client knows, as an executor, and their number; RuntimeError if one has another
    version of lmgcpy."""
    for worker, there in client.run(versions).items():
        if there["lmgcpy"] != versions()["lmgcpy"]:
            raise RuntimeError(
                f"The worker {worker} has lmgcpy {there['lmgcpy']}, this process {versions()['lmgcpy']}: install the same "
                "version everywhere."
            )
    return client.get_executor(pure=False), max(1, len(client.scheduler_info(n_workers=-1)["workers"]))


def client_at(address: str | None, file: str | None) -> Any:
    """A client of the scheduler at an address, or at the one in a file that it has written; ConnectionError if nobody
    answers or if it has no workers."""
    if not has_dask():
        raise ImportError('A scheduler needs Dask: pip install "lmgcpy[scale]".')
    from distributed import Client

    address = address or _address_in(str(file))
    where = f"'{address}'" if file is None else f"'{address}', the address in '{file}',"
    begin = clock.monotonic()
    try:
        with _silent("distributed"):  # which logs what it raises
            _within(ANSWER, lambda: asyncio.run(_greet(address)))
            left = max(1.0, begin + ANSWER - clock.monotonic())
            client = _within(left, lambda: Client(address, timeout=left, set_as_default=False))
    except Exception as error:  # whoever answers there may send anything
        raise ConnectionError(
            f"No Dask scheduler answers at {where} within {ANSWER:g} s ({shown(error)}): begin one, or leave the address "
            "out for processes of this machine."
        ) from None
    if not client.scheduler_info(n_workers=-1)["workers"]:
        client.close()
        raise ConnectionError(f"The scheduler at {where} has no workers: begin some, for example by 'dask worker'.")
    return client


def deaths(error: BaseException) -> int:
    """Number of workers that have died over a call that ended with this error."""
    if hasattr(error, "allowed_failures"):  # KilledWorker: Dask tries again by itself, as often as its scheduler is set to
        return error.allowed_failures + 1
    return int(isinstance(error, (CancelledError, BrokenExecutor)))


def _address_in(file: str) -> str:
    """The address in the file of a scheduler; ValueError if it has none."""
    try:
        return str(json.loads(Path(regular_file(file, "the file of a scheduler")).read_text(encoding="utf-8"))["address"])
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise ValueError(f"'{file}' is no file that a Dask scheduler has written ({shown(error)}).") from error


async def _greet(address: str) -> None:
    """See that a scheduler answers. A client that gets no answer, or a wrong one, cannot be closed without a word."""
    from distributed.core import rpc
    from distributed.security import Security

    given = {"timeout": 0.9 * ANSWER, "connection_args": Security().get_connection_args("client")}
    async with rpc(address, **given) as there:
        about = await asyncio.wait_for(there.identity(), ANSWER)
    if "workers" not in about:
        raise ValueError(f"there is a {about.get('type')} of Dask")


def _within(seconds: float, call: Callable[[], Any]) -> Any:
    """Return or raise what a call does; TimeoutError if it does neither in time. The call then goes on in a thread of its
    own."""
    done: list[tuple[Any, BaseException | None]] = []

    def make() -> None:
        try:
            done.append((call(), None))
        except BaseException as error:
            done.append((None, error))

    thread = threading.Thread(target=make, daemon=True)
    thread.start()
    thread.join(seconds)
    if not done:
        raise TimeoutError("nothing was said")
    result, error = done[0]
    if error is not None:
        raise error
    return result


@contextmanager
def _silent(name: str) -> Iterator[None]:
    """A logger and those below it say nothing meanwhile."""
    logger = logging.getLogger(name)
    before, logger.disabled = logger.disabled, True
    others = [other for other in logging.root.manager.loggerDict if other.startswith(f"{name}.")]
    levels = {other: logging.getLogger(other).level for other in others}
    for other in others:
        logging.getLogger(other).setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        logger.disabled = before
        for other, level in levels.items():
            logging.getLogger(other).setLevel(level)


def _as_worker() -> None:
    """Leave Ctrl-C to the campaign, which tells the cases to end between two steps, and end with it if it is killed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=end_with_parent, daemon=True).start()


def end_with_parent(group: bool = False) -> None:
    """End this process when the one that began it has ended; ``group``: with the processes that it began."""
    multiprocessing.parent_process().join()  # type: ignore[union-attr]
    if group:
        with suppress(OSError, AttributeError):
            os.killpg(0, signal.SIGKILL)
    os._exit(1)


def has_dask() -> bool:
    """Whether the extra ``lmgcpy[scale]`` is installed."""
    try:
        import distributed  # noqa: F401
    except ImportError:
        return False
    return True


def processors() -> int:
    """How many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def _environment() -> Iterator[None]:
    """Processes that begin meanwhile have the variables of workers, unless the user says what these are."""
    added = [name for name in ENVIRONMENT if name not in os.environ]
    os.environ.update(dict.fromkeys(added, "1"))
    try:
        yield
    finally:
        for name in added:
            del os.environ[name]
