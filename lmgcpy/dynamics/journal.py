"""Changes that are whole or not there, whatever ends them: an error, or a signal such as Ctrl-C at any line."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from typing import Generic, TypeVar

Before = TypeVar("Before")
T = TypeVar("T")

OFTEN = 10
"""How often the way back is begun again at once; after that, before the next change."""


class Journal(Generic[Before]):
    """Keeps the state before a change until the change is made.

    Python calls the handlers of signals where functions begin, return or loop, and not within an assignment. So the change
    is made by the one assignment that clears the journal. A second signal may end the way back, which is begun again.
    """

    __slots__ = ("_before", "_under_way")

    def __init__(self) -> None:
        self._before: Before | None = None
        self._under_way = False

    def whole_or_not_at_all(
        self, keep: Callable[[], Before], make: Callable[[], T], go_back: Callable[[Before], None]
    ) -> T:
        """Call ``make``, which changes what ``keep`` keeps; ``go_back`` puts it back, and may be called more than once."""
        self.settle(go_back)
        try:
            self._before = keep()
            self._under_way = True
            made = make()
            self._before = None
            return made
        except BaseException:
            for _ in range(OFTEN):
                with suppress(BaseException):  # a second signal; the first one is raised below
                    self._end_going_back(go_back)
                    break
            raise
        finally:
            self._under_way = False

    def settle(self, go_back: Callable[[Before], None]) -> None:
        """See that nothing is half changed; RuntimeError if a change is under way."""
        if self._under_way and self._before is not None:
            raise RuntimeError(
                "A step is under way: functions that the scene calls within a step, as those of time, can make neither "
                "another one nor a checkpoint."
            )
        self._end_going_back(go_back)

    def _end_going_back(self, go_back: Callable[[Before], None]) -> None:
        if self._before is not None:
            go_back(self._before)
            self._before = None
