"""First calls of a law's functions, in plain Python: faults that would otherwise show inside compiled code, or not at all.

The conformance kit (:mod:`lmgcpy.testing`) looks for much more. This is what every scene does with a law that it does not
know: some hundred calls at gaps, velocities and states of either sign, a few milliseconds, once in a process.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np

from lmgcpy.errors import number, shown
from lmgcpy.laws.law import Law
from lmgcpy.laws.pair import Pair, as_asked, asks_for_pair, pair_of

FAULTS = (NameError, AttributeError, TypeError, IndexError)
"""Errors that are faults of the program for any numbers. Other errors, such as a division by zero, are raised in the run
if they happen."""
LENGTH, TIME_STEP, LENGTH_OF_LINK = 1e-3, 1e-4, 0.1
"""Gaps [m], time step [s], and reference length of a link [m] of the calls."""

_checked: set[tuple] = set()


def check_answers(law: Law, dimension: int) -> None:
    """Raise TypeError with a sentence if a function of the law fails or returns a wrong answer.

    Laws of lmgcpy itself are not called: its tests call them.
    """
    kind = type(law)
    functions = kind.prepare, kind.react, kind.slope, kind.energy, kind.initial, kind.commit, kind.dissipation
    key = kind, functions, law.rows(dimension)
    if key in _checked or kind.__module__.startswith("lmgcpy.laws."):
        return
    for gap, before, pair in _situations(law, dimension):
        _ask_everything(law, dimension, gap, before, pair)
    _checked.add(key)


def _situations(law: Law, dimension: int) -> Iterator[tuple[float, tuple[float, ...], Pair]]:
    """Gaps [m], velocities before the step [m/s], and pairs; of a law that asks for no pair one pair."""
    rows = law.rows(dimension)
    reach = number(
        law.acts_within(LENGTH_OF_LINK, LENGTH_OF_LINK), f"acts_within of law '{law.NAME}'", minimum=0.0, unit="m"
    )
    lengths = {LENGTH, 0.01 * LENGTH, 100.0 * LENGTH, 0.5 * reach, 2.0 * reach}
    lengths |= {value for name, value in law.values.items() if value and law.parameters()[name].unit == "m"}
    gaps = sorted({0.0, *lengths, *(-length for length in lengths)})
    known = [pair_of((LENGTH_OF_LINK, other), (1.0, other), TIME_STEP) for other in (LENGTH_OF_LINK, np.inf)]
    for gap, speed, pair in itertools.product(gaps, (-1.0, 0.0, 1.0), known if asks_for_pair(law) else known[:1]):
        yield gap, (speed,) * rows, pair


def _ask_everything(law: Law, dimension: int, gap: float, before: tuple[float, ...], pair: Pair) -> None:
    """Let an interaction begin with this gap and go on for three steps."""
    reference = 0.0
    rows, count = law.rows(dimension), len(law.states())
    parameters = tuple(float(value) for value in law.table(np.array([LENGTH_OF_LINK]))[0])
    state: Any = (0.0,) * count
    if law.initial is not None:
        birth = gap, reference, 0.0, parameters, *as_asked(law.initial, pair)
        state = _numbers(law, "initial", count, "one for each state", *birth)
    W = tuple(tuple(1.0 if i == j else 0.1 for j in range(rows)) for i in range(rows))
    for normal, tangential in itertools.product((-100.0, -1e-3, 1e-3, 100.0), (0.0, -1.0, 100.0)):
        if state is None:
            return
        u = (normal, *(tangential,) * (rows - 1))
        step = gap, reference, before, TIME_STEP, parameters, state, *as_asked(law.prepare, pair)
        prepared = _numbers(law, "prepare", len(law.PREPARED), "one for each name in PREPARED", *step)
        impulse = prepared and _numbers(law, "react", rows, "one for each row of the law", W, u, prepared)
        if (not prepared and law.PREPARED) or impulse is None:
            return
        if law.slope is not None:
            _matrix(law, rows, W, u, prepared)
        if law.energy is not None:
            _number(law, "energy", gap, reference, parameters, state, *as_asked(law.energy, pair))
        end = gap, reference, u, impulse, TIME_STEP, parameters, state
        if law.dissipation is not None:
            _number(law, "dissipation", *end, *as_asked(law.dissipation, pair))
        if law.commit is not None:
            state = _numbers(law, "commit", count, "one for each state", *end, *as_asked(law.commit, pair))


def _numbers(law: Law, function: str, count: int, why: str, *given: Any) -> tuple[float, ...] | None:
    """The tuple of numbers that a function returns; None if the numbers given are beyond its range."""
    answer = _ask(law, function, *given)
    if answer is None:
        return None
    if not isinstance(answer[0], tuple) or len(answer[0]) != count or not all(map(_is_number, answer[0])):
        raise _fault(law, function, f"returned {shown(answer[0])}, expected a tuple of {count} numbers, {why}", given)
    return tuple(map(float, answer[0]))


def _matrix(law: Law, rows: int, *given: Any) -> None:
    """Check the derivative of ``react``."""
    answer = _ask(law, "slope", *given)
    if answer is None:
        return
    lines = answer[0] if isinstance(answer[0], tuple) else ()
    if len(lines) != rows or not all(isinstance(line, tuple) and len(line) == rows for line in lines):
        what = f"returned {shown(answer[0])}, expected a tuple of {rows} rows, each a tuple of {rows} numbers"
        raise _fault(law, "slope", what, given)
    for value in itertools.chain(*lines):
        if not _is_number(value):
            raise _fault(law, "slope", f"returned {shown(value)} in a row, expected a number", given)


def _number(law: Law, function: str, *given: Any) -> None:
    answer = _ask(law, function, *given)
    if answer is not None and not _is_number(answer[0]):
        raise _fault(law, function, f"returned {shown(answer[0])}, expected a number", given)


def _ask(law: Law, function: str, *given: Any) -> tuple[Any] | None:
    """The answer of a function in a tuple; None if the numbers given are beyond its range."""
    try:
        with np.errstate(all="ignore"):
            return (getattr(law, function)(*given),)
    except FAULTS as error:
        raise _fault(law, function, f"raised {type(error).__name__}: {error}", given) from error
    except Exception as error:
        if "to unpack" in str(error):  # a tuple of another length: two components in a law that is used in 3D
            raise _fault(law, function, f"raised {type(error).__name__}: {error}", given) from error
        return None


def _fault(law: Law, function: str, what: str, given: tuple[Any, ...]) -> TypeError:
    arguments = ", ".join(shown(value) for value in given)
    where = f"{type(law).__module__}.{type(law).__qualname__}"
    return TypeError(f"Law '{law.NAME}' ({where}): {function}({arguments}) {what}.")


def _is_number(value: Any) -> bool:
    try:
        float(value)
    except (TypeError, ValueError):
        return False
    return True
