"""Observations: values that a user's functions return after every step, recorded with the run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from lmgcpy.errors import closest, shown

if TYPE_CHECKING:
    from lmgcpy.dynamics.stepper import Stepper

Observe = Mapping[str, Callable[[Any], Any]]
"""Functions of the simulation by name; each returns a number or an array of the same shape at every step."""


class Observed(dict[str, Any]):
    """Observed values by name; LookupError with a sentence for an unknown name."""

    def __missing__(self, name: str) -> NoReturn:
        raise LookupError(f"Nothing was observed under the name {shown(name)}{closest(name, self)}")


class Observations:
    """Functions by name, and the type of the values of each, as a numpy type with its shape.

    ``types`` gives the types by name, from a file; without it :meth:`probe` finds them.
    """

    def __init__(self, functions: Observe, types: Mapping[str, np.dtype] | None = None):
        if not isinstance(functions, Mapping):
            raise TypeError(f"observe must be functions of the simulation by name, got {functions!r}.")
        for name, function in functions.items():
            if not isinstance(name, str) or not name.isprintable() or name in ("", ".") or "/" in name:
                raise ValueError(f"observe: {name!r} cannot be a name; take a word such as 'reaction', without '/'.")
            if not callable(function):
                raise TypeError(f"observe['{name}'] must be a function of the simulation, got {function!r}.")
        self._functions = dict(functions)
        self.types: dict[str, np.dtype] = dict(types or {})

    def probe(self, sim: Stepper) -> None:
        """Call every function once, before the first step, to find the type of its values.

        Raises ValueError with a sentence if a function fails, and TypeError if it returns no numbers.
        """
        for name, function in self._functions.items():
            try:
                value = np.asarray(function(sim))
            except Exception as error:
                raise ValueError(
                    f"observe['{name}'] fails before the first step, when lmgcpy asks for its shape: "
                    f"{type(error).__name__}: {error}. There may be no interactions yet; let it return NaN then."
                ) from error
            if value.dtype.kind not in "biuf" or not value.size:
                raise TypeError(
                    f"observe['{name}'] must return a number, or an array of numbers of the same shape at every step; "
                    f"before the first it returned {value.tolist()!r}."
                )
            self.types[name] = np.dtype((value.dtype, value.shape))

    def look(self, sim: Stepper) -> dict[str, np.ndarray]:
        """The values now; ValueError if a shape or type differs from that before the first step."""
        row = {}
        for name, function in self._functions.items():
            value, kind = np.asarray(function(sim)), self.types[name]
            if value.shape != kind.shape or not np.can_cast(value.dtype, kind.base, "safe"):
                raise ValueError(
                    f"observe['{name}'] returned {value.dtype} of shape {value.shape} after step {sim.steps}, but its "
                    f"table is of {kind.base} of shape {kind.shape}: let it return the same type and shape at every step, "
                    "and before the first step (0.0, not 0)."
                )
            row[name] = value.astype(kind.base)
        return row

    def __iter__(self):
        return iter(self._functions)
