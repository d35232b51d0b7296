"""How kernels run now: compiled, or as plain Python, and whether one that is not in the cache may be compiled."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numba

INTERPRETED = bool(numba.config.DISABLE_JIT)  # type: ignore[attr-defined]
"""Whether kernels always run as plain Python: ``NUMBA_DISABLE_JIT=1`` at the start of the process, for debuggers and
coverage."""


class NotCompiled(BaseException):
    """A kernel is not in the cache, and is not to be compiled now. No handler of errors is to take it for one."""


class _Mode:
    """Of this process."""

    def __init__(self) -> None:
        self.plain = INTERPRETED
        self.loads_only = False
        """Whether a kernel that is not in the cache raises :class:`NotCompiled`."""
        self.called: list[Any] = []
        """Kernels that were called, which keep how: to ask at each call would cost a small scene some percent."""

    def _set(self, plain: bool) -> None:
        self.plain = plain
        for kernel in self.called:
            kernel.forget()
        self.called.clear()

    @contextmanager
    def as_plain_python(self) -> Iterator[None]:
        """Kernels run as plain Python."""
        self._set(True)
        try:
            yield
        finally:
            self._set(INTERPRETED)


mode = _Mode()
