"""Sentences for users: what is wrong, where, and what to do. All are built-in kinds of exception."""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable
from typing import Any

import numpy as np


def closest(word: object, known: Iterable[str]) -> str:
    """Ending of a sentence about an unknown word: the closest match, if any, and the whole list."""
    names = sorted(known)
    match = difflib.get_close_matches(str(word), names, n=1, cutoff=0.5)
    hint = f"; did you mean '{match[0]}'?" if match else "."
    return f"{hint} Known: {', '.join(names) if names else 'none'}."


def number(
    value: Any,
    name: str,
    *,
    minimum: float = -math.inf,
    maximum: float = math.inf,
    above: float = -math.inf,
    unit: str = "",
) -> float:
    """``value`` as a finite float within bounds (``above``: exclusive), or a sentence that names it.

    Raises TypeError for what is no number and ValueError for NaN, infinity or a number out of bounds.
    """
    unit = f" {unit}" if unit and unit != "-" else ""
    if isinstance(value, (bool, str)) or value is None:
        raise TypeError(f"{name} must be a number{unit and ' in' + unit}, got {value!r}.")
    try:
        result = float(value)
    except (TypeError, ValueError) as error:
        raise TypeError(f"{name} must be a number{unit and ' in' + unit}, got {value!r}.") from error
    if not math.isfinite(result):
        raise ValueError(f"{name} must be finite, got {result}.")
    if not result > above and above != -math.inf:
        raise ValueError(f"{name} must be above {above:g}{unit}, got {result:g}{unit}.")
    if result < minimum:
        raise ValueError(f"{name} must be at least {minimum:g}{unit}, got {result:g}{unit}.")
    if result > maximum:
        raise ValueError(f"{name} must be at most {maximum:g}{unit}, got {result:g}{unit}.")
    return result


def whole(value: Any, name: str, *, minimum: int = 0) -> int:
    """``value`` as an integer of at least ``minimum``, or a sentence that names it (TypeError, ValueError)."""
    if isinstance(value, bool) or not isinstance(value, (int, np.integer)):
        raise TypeError(f"{name} must be a whole number, got {value!r}.")
    if value < minimum:
        raise ValueError(f"{name} must be at least {minimum}, got {value}.")
    return int(value)


def vector(value: Any, name: str, size: int) -> np.ndarray:
    """``value`` as a finite float array of shape (size,), or a sentence that names it (TypeError, ValueError)."""
    try:
        result = np.array(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise TypeError(f"{name} must be {size} numbers, got {value!r}.") from error
    if result.shape != (size,):
        shape = f"{result.size} numbers" if result.ndim == 1 else f"an array of shape {result.shape}"
        raise ValueError(f"{name} must be {size} numbers in dimension {size}, got {shape}: {value!r}.")
    if not np.isfinite(result).all():
        raise ValueError(f"{name} must be finite, got {value!r}.")
    return result
