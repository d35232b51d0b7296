"""Calls of a law's functions in plain Python; every answer is checked before it is used."""

from __future__ import annotations

import math
from typing import Any

from lmgcpy.errors import shown, told
from lmgcpy.laws import Law

Numbers = tuple[float, ...]
Matrix = tuple[Numbers, ...]


class Nonconformance(AssertionError):
    """A law breaks a property. The message gives the name of the property, the law, the finding and the input."""

    def __init__(self, name: str, message: str, law: Law | None = None, given: str = ""):
        self.property, self.message, self.law, self.given = name, message, law, given
        of = f" of {law!r} (law '{law.NAME}')" if law is not None else ""
        super().__init__(f"{name}{of}: {message}{given and f'{chr(10)}{given}'}")


def ask(law: Law, function: str, *arguments: Any) -> Any:
    """The answer of a function of the law; Nonconformance if it raises."""
    try:
        return getattr(law, function)(*arguments)
    except Exception as error:
        raise Nonconformance("finite", f"{function} raised {told(error)}, expected numbers.") from error


def numbers(law: Law, function: str, count: int, why: str, *arguments: Any, infinite: bool = False) -> Numbers:
    """The tuple of ``count`` finite numbers that a function of the law returns; ``infinite`` allows infinite numbers."""
    answer = ask(law, function, *arguments)
    if not isinstance(answer, tuple) or len(answer) != count:
        raise Nonconformance("interface", f"{function} returned {shown(answer)}, expected a tuple of {count}, {why}.")
    return tuple(_number(function, value, infinite) for value in answer)


def rows_of_numbers(law: Law, function: str, count: int, *arguments: Any) -> Matrix:
    """The square matrix, a tuple of rows, that a function of the law returns."""
    answer = ask(law, function, *arguments)
    if not isinstance(answer, tuple) or [len(row) if isinstance(row, tuple) else -1 for row in answer] != [count] * count:
        raise Nonconformance(
            "interface", f"{function} returned {shown(answer)}, expected a tuple of {count} tuples of {count} numbers."
        )
    return tuple(tuple(_number(function, value, False) for value in row) for row in answer)


def number(law: Law, function: str, *arguments: Any) -> float:
    """The finite number that a function of the law returns."""
    return _number(function, ask(law, function, *arguments), False)


def _number(function: str, value: Any, infinite: bool) -> float:
    try:
        result = float(value)
    except (TypeError, ValueError) as error:
        raise Nonconformance("interface", f"{function} returned {shown(value)} where a number was expected.") from error
    if math.isnan(result) or (math.isinf(result) and not infinite):
        raise Nonconformance("finite", f"{function} returned {result}, expected a finite number.")
    return result
