"""Who does the cases: processes of this machine, or the workers of a Dask cluster."""

from __future__ import annotations

import asyncio
import json
import logging
import os
import signal
import threading
import time as clock
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, ProcessPoolExecutor, wait
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from lmgcpy.errors import shown
from lmgcpy.io.untrusted import regular_file
from lmgcpy.version import versions

ANSWER = 8.0
"""Time in which a scheduler must answer [s]."""
GONE = 30.0
"""Workers of this machine that have died come back within this time [s]."""
DEATHS = 4
"""A case is given up once this number of workers has died over it, the last one while it did no other case."""
WORKER = "LMGCPY_CAMPAIGN_WORKER"
"""Variable that the workers of this machine have."""
ENVIRONMENT = (WORKER, "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
"""Variables that are 1 for them: one thread for linear algebra, as there are as many workers as processors."""
GUARD = "put the call under if __name__ == '__main__':"
"""Advice for a script that begins a campaign."""


class Workers(ABC):
    """Workers that call functions; each call submitted is a future of ``concurrent.futures`` or one like it."""

    count: int
    """How many there are."""

    @abstractmethod
    def submit(self, call: Callable[..., Any], *arguments: Any) -> Any:
        """Let a worker call a function of a module."""

    @abstractmethod
    def wait(self, futures: Sequence[Any], seconds: float) -> list[Any]:
        """The futures that are done, after at most this time."""

    @abstractmethod
    def deaths(self, error: BaseException) -> int:
        """Number of workers that have died over a call that ended with this error."""

    @abstractmethod
    def close(self) -> None:
        """End workers of one's own, without waiting for their work."""


class Processes(Workers):
    """Processes of this machine, by ``concurrent.futures``."""

    def __init__(self, count: int):
        self.count = count
        self._pool = self._begun()
        try:
            self._pool.submit(os.getpid).result()
        except BrokenExecutor as error:
            raise _did_not_start(error) from None

    def _begun(self) -> ProcessPoolExecutor:
        with _environment():
            pool = ProcessPoolExecutor(self.count, get_context("spawn"), initializer=_deaf)
            for _ in range(self.count):  # processes begin when they are needed, and take the environment of then
                pool.submit(os.getpid)
        return pool

    def submit(self, call: Callable[..., Any], *arguments: Any) -> Any:
        try:
            return self._pool.submit(call, *arguments)
        except BrokenExecutor:  # a process has died, and all others were ended with it
            self._pool = self._begun()
            return self._pool.submit(call, *arguments)

    def wait(self, futures: Sequence[Any], seconds: float) -> list[Any]:
        return list(wait(futures, timeout=seconds, return_when=FIRST_COMPLETED).done)

    def deaths(self, error: BaseException) -> int:
        return int(isinstance(error, BrokenExecutor))

    def close(self) -> None:
        self._pool.shutdown(wait=True, cancel_futures=True)


class Cluster(Workers):
    """The workers of a Dask cluster that a client knows."""

    def __init__(self, client: Any, *, to_close: Sequence[Any] = (), own: bool = False):
        """``to_close``: what ends with the campaign; ``own``: whether the workers do."""
        self._client, self._to_close, self._own = client, to_close, own
        self._seen = clock.monotonic()
        self.count = max(1, len(client.scheduler_info(n_workers=-1)["workers"]))
        for worker, there in client.run(versions).items():
            if there["lmgcpy"] != versions()["lmgcpy"]:
                self.close()
                raise RuntimeError(
                    f"The worker {worker} has lmgcpy {there['lmgcpy']}, this process {versions()['lmgcpy']}: install the "
                    "same version everywhere."
                )

    @classmethod
    def begun_here(cls, count: int) -> Cluster:
        """Workers on this machine, one thread each, that talk to nobody but this process."""
        from distributed import Client, LocalCluster

        from lmgcpy.experiment.campaign.own_worker import OwnWorker

        try:
            with _environment(), _silent("distributed"):
                cluster = LocalCluster(
                    n_workers=count,
                    threads_per_worker=1,
                    processes=True,
                    host="127.0.0.1",
                    dashboard_address="127.0.0.1:0",  # any free port, which is closed below
                    scheduler_kwargs={"dashboard": False, "allowed_failures": 0},  # deaths are counted in ``carry_out``
                    memory_limit=None,
                    silence_logs=logging.CRITICAL,
                )
        except RuntimeError as error:
            raise _did_not_start(error) from None
        client = Client(cluster, set_as_default=False)
        cluster.sync(_close_pages, cluster.scheduler)
        client.register_plugin(OwnWorker())
        return cls(client, to_close=(client, cluster), own=True)

    @classmethod
    def at(cls, address: str | None, file: str | None) -> Cluster:
        """The workers of a scheduler at an address, or at the one in a file that it has written; ConnectionError if nobody
        answers."""
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
                f"No Dask scheduler answers at {where} within {ANSWER:g} s ({shown(error)}): begin one, or leave the "
                "address out for processes of this machine."
            ) from None
        if not client.scheduler_info(n_workers=-1)["workers"]:
            client.close()
            raise ConnectionError(f"The scheduler at {where} has no workers: begin some, for example by 'dask worker'.")
        return cls(client, to_close=(client,))

    def submit(self, call: Callable[..., Any], *arguments: Any) -> Any:
        return self._client.submit(call, *arguments, pure=False)

    def wait(self, futures: Sequence[Any], seconds: float) -> list[Any]:
        from distributed import wait as wait_for

        try:
            with self._client.as_current():
                wait_for(futures, timeout=seconds, return_when="FIRST_COMPLETED")
        except TimeoutError:
            self._see_workers()
            return []
        return [future for future in futures if future.done()]

    def _see_workers(self) -> None:
        """RuntimeError if all workers of this machine have died and none has come back."""
        now = clock.monotonic()
        if not self._own or self._client.scheduler_info(n_workers=-1)["workers"]:
            self._seen = now
        elif now > self._seen + GONE:
            raise RuntimeError("All workers have died, and none came back: see whether memory suffices, and resume.")

    def deaths(self, error: BaseException) -> int:
        from distributed.scheduler import KilledWorker

        if isinstance(error, KilledWorker):  # Dask tries again by itself, as often as its scheduler is set to
            return error.allowed_failures + 1
        return int(isinstance(error, (CancelledError, BrokenExecutor)))

    def close(self) -> None:
        for one in self._to_close:
            one.close()


def _did_not_start(error: Exception) -> RuntimeError:
    """The error of workers that did not start; they say nothing themselves."""
    return RuntimeError(
        f"The workers on this machine did not start ({error}). They import the script of the campaign: {GUARD} there."
    )


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


async def _close_pages(server: Any) -> None:
    server.http_server.stop()


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


def _deaf() -> None:
    """Leave Ctrl-C to the campaign, which tells the cases to end between two steps."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


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
