"""The queue of the cases of a campaign: they go to whoever is free, and their results into the folder as they come."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from concurrent.futures import FIRST_COMPLETED, CancelledError, Executor, Future, wait
from contextlib import closing, contextmanager
from typing import Any

from lmgcpy.experiment.campaign.case_work import Order, do_case, do_case_within
from lmgcpy.experiment.campaign.cases import FAILED, TO_COME, CampaignCase, CampaignFolder, CaseResult
from lmgcpy.experiment.campaign.workers import (
    DEATHS,
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


@contextmanager
def executor_for(
    most: int, workers: int | None, executor: Executor | None, client: Any, scheduler: str | None, file: str | None
) -> Iterator[tuple[Executor, int]]:
    """The executor for the cases, at ``most`` this number, and the number of its workers. It ends if it was begun here."""
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


class CaseQueue:
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
