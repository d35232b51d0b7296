"""The first difference of two trees of dictionaries, arrays and plain values."""

from __future__ import annotations

from typing import Any

import numpy as np

from lmgcpy.errors import shown


def first_difference(there: Any, here: Any, where: str = "", sides: tuple[str, str] = ("there", "here")) -> str:
    """The first difference as a clause, "time_step is 0.1 there and 0.2 here"; empty if there is none."""
    if isinstance(there, list) and isinstance(here, list):
        there, here = dict(enumerate(there)), dict(enumerate(here))
    if isinstance(there, dict) and isinstance(here, dict):
        for name in sorted(here.keys() | there.keys(), key=str):
            what = f"{where} {name}".strip()
            if name not in there or name not in here:
                return f"there is {'no' if name not in there else 'a'} '{what}' in it"
            different = first_difference(there[name], here[name], what, sides)
            if different:
                return different
        return ""
    if isinstance(there, np.ndarray) or isinstance(here, np.ndarray):
        same = np.shape(there) == np.shape(here) and np.array_equal(there, here, equal_nan=True)
        return "" if same else _of_arrays(there, here, where, sides)
    return "" if there == here else f"'{where}' is {shown(there)} {sides[0]} and {shown(here)} {sides[1]}"


def _of_arrays(there: Any, here: Any, where: str, sides: tuple[str, str]) -> str:
    """The first number that differs, or the shapes."""
    if np.shape(there) != np.shape(here):
        return f"'{where}' has {len(np.atleast_1d(there))} rows {sides[0]} and {len(np.atleast_1d(here))} {sides[1]}"
    index = tuple(int(k) for k in np.argwhere(~((there == here) | ((there != there) & (here != here))))[0])
    numbers = f"{shown(there[index])} {sides[0]} and {shown(here[index])} {sides[1]}"
    return f"'{where}' is {numbers}, in row {index[0]}" if index else f"'{where}' is {numbers}"
