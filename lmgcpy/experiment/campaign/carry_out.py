"""A campaign carried out: its cases in turn to whoever is free, their results into the folder as they come."""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from contextlib import closing, contextmanager
from multiprocessing import current_process
from typing import Any

from lmgcpy.errors import flag, whole
from lmgcpy.experiment.campaign.alone import do_case_within
from lmgcpy.experiment.campaign.cases import FAILED, TO_COME, CampaignCase, CampaignResults, CaseResult
from lmgcpy.experiment.campaign.folder import CampaignFolder
from lmgcpy.experiment.campaign.work import Order, do_case
from lmgcpy.experiment.campaign.workers import (
    DEATHS,
    GUARD,
    WORKER,
    OwnProcesses,
    client_at,
    cluster,
    deaths,
    processors,
)
from lmgcpy.experiment.study.engine import Site
from lmgcpy.experiment.study.stages import CaseStages, Stages
from lmgcpy.version import versions

LOOK = 0.25
"""Interval at which the campaign looks for results and for Ctrl-C [s]."""
AHEAD = 2
"""Cases that a worker has been given beside the one that it does, so that it never waits."""


def carry_out(
    campaign: Any,
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
    """Carry a :class:`~lmgcpy.experiment.Campaign` out in the folder ``out`` and return its results.

    The cases go to ``workers`` processes of this machine, by default as many as it has processors; or to an ``executor`` of
    ``concurrent.futures``, which stays open; or to the Dask cluster of a ``client``, or of the ``scheduler`` at an address
    or in a file. The results have the same bits. A case that fails is recorded with its error, and so is
    one that is killed at the end of the ``case_timeout``; one whose worker dies is done again, from its run files if the
    worker sees the folder. ``resume`` does the cases to come, and again those that failed. ``progress`` shows the running
    cases on a terminal. Ctrl-C (KeyboardInterrupt) ends the runs between two steps.

    Raises FileExistsError, FileNotFoundError and ValueError as :meth:`CampaignFolder.begin`, BlockingIOError if another
    campaign works in the folder, ConnectionError if no scheduler answers, RuntimeError if workers have another version of
    lmgcpy.
    """
    if getattr(current_process(), "_inheriting", False):  # a worker imports the script that has begun it
        said = WORKER in os.environ  # by the one who began the worker
        raise SystemExit(1 if said else f"The script begins a campaign where it is imported, as by each worker: {GUARD}")
    flag(resume, "resume")
    flag(force, "force")
    flag(progress, "progress")
    if workers is not None:
        whole(workers, "workers", minimum=1)
    cases = campaign.all_cases()
    folder = CampaignFolder(out)
    folder.check(campaign, resume=resume, force=force)
    with folder.held():
        folder.check(campaign, resume=resume, force=force)  # as another one may have left it
        if not resume:
            folder.begin(campaign)
        done = {result.name for result in folder.results(cases).finished}
        to_come = [case for case in cases if case.name not in done]
        if to_come:
            stages = CaseStages(folder.cases, len(cases), len(done), quiet=not progress)
            where = workers, executor, client, scheduler, scheduler_file
            with _team(len(to_come), *where) as (team, count), stages:
                _Round(to_come, folder, team, count, stages, campaign.case_timeout).go()
    return folder.results(cases)


@contextmanager
def _team(
    most: int, workers: int | None, executor: Executor | None, client: Any, scheduler: str | None, file: str | None
) -> Iterator[tuple[Executor, int]]:
    """The executor that does at ``most`` so many cases, and the number of its workers. Only one's own ends."""
    if executor is not None:
        yield executor, getattr(executor, "_max_workers", processors())
    elif client is not None:
        yield cluster(client)
    elif scheduler is not None or file is not None:
        with closing(client_at(scheduler, file)) as own:
            yield cluster(own)
    else:
        count = min(workers or processors(), most)
        pool = OwnProcesses(count)
        try:
            yield pool, count
        finally:
            pool.shutdown(cancel_futures=True)


class _Round:
    """The cases under way, and those that wait for a worker."""

    def __init__(
        self,
        cases: list[CampaignCase],
        folder: CampaignFolder,
        team: Executor,
        count: int,
        stages: CaseStages,
        limit: float | None,
    ):
        """``count``: number of workers of the team; ``limit``: time that a case may take, None for any [s]."""
        self._folder, self._team, self._count, self._stages, self._limit = folder, team, count, stages, limit
        self._site = Site(Stages(quiet=True), folder.cases.resolve())
        self._queue = deque(cases)
        self._running: dict[Future, CampaignCase] = {}
        self._deaths: dict[str, int] = {}
        self._here, self._campaign = versions(), str(folder.path.resolve())

    def go(self) -> None:
        """Do the cases until all have ended; Ctrl-C ends those that run between two steps, and raises KeyboardInterrupt."""
        with self._site.listening() as pressed:
            try:
                while self._running or (self._queue and not pressed()):
                    while self._may_begin() and not pressed():
                        case = self._queue.popleft()
                        self._running[self._begun(Order(case, self._campaign, self._site, self._here))] = case
                    ended = wait(self._running, LOOK, FIRST_COMPLETED).done
                    if pressed():
                        self._site.stop()  # cases that no worker has begun end at once
                    for future in ended:
                        self._end(self._running.pop(future), future)
                    self._stages.look()
            except BaseException:
                self._site.stop()
                wait(self._running)  # until they have seen it
                raise
            if pressed():
                raise KeyboardInterrupt

    def _begun(self, order: Order) -> Future:
        """The future of a case that a worker is to do: by itself, or in a process that it kills if time is limited."""
        if self._limit is None:
            return self._team.submit(do_case, order)
        return self._team.submit(do_case_within, order, self._limit)

    def _may_begin(self) -> bool:
        """Whether the next case may be given to the workers now."""
        if not self._queue or any(map(self._is_last_try, self._running.values())):
            return False
        if self._is_last_try(self._queue[0]):
            return not self._running
        return len(self._running) < (1 + AHEAD) * self._count

    def _is_last_try(self, case: CampaignCase) -> bool:
        """Whether a case is given up if its worker dies once more. It is then done alone: the dead worker may have been
        doing another case, as a worker is given more than one at a time."""
        return self._deaths.get(case.name, 0) >= DEATHS - 1

    def _end(self, case: CampaignCase, future: Future) -> None:
        """Enter what became of a case, or put it back in the queue if its worker has died."""
        error = CancelledError() if future.cancelled() else future.exception()
        died = 0 if error is None else deaths(error)
        if died:
            last = self._is_last_try(case)
            self._deaths[case.name] = self._deaths.get(case.name, 0) + died
            if not last:
                self._queue.appendleft(case)
                return
            error = RuntimeError(f"its worker died {self._deaths[case.name]} times, for want of memory perhaps")
        if error is None:
            result = future.result()
        else:
            sentence = f"{type(error).__name__}: {error}"
            result = CaseResult(case.name, case.parameters, FAILED, 0.0, sentence, {}, {}, self._here)
        if result.status != TO_COME:
            self._folder.enter(result)
            words = f"{result.status}, {result.seconds:.1f} s" + (f": {result.error}" if result.error else "")
            self._stages.ended(result.name, words, result.status == FAILED)
