"""What a run watches, and says to the user: each file finds one thing and has its sentence. A run says each thing once."""

from __future__ import annotations


class Said:
    """The things that a run has said, by their names. One object serves all that watch a run."""

    def __init__(self) -> None:
        self._names: frozenset[str] = frozenset()

    def __contains__(self, name: str) -> bool:
        return name in self._names

    def first(self, name: str) -> bool:
        """Whether a thing is said for the first time; it counts as said from now on."""
        first = name not in self._names
        self._names |= {name}
        return first

    def any_of(self, beginning: str) -> bool:
        """Whether something was said whose name begins so."""
        return any(name.startswith(beginning) for name in self._names)
