"""What a property of laws is, and how one is looked for a counterexample."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from hypothesis.errors import Flaky, Unsatisfiable

from lmgcpy.laws import Law
from lmgcpy.testing.answers import Nonconformance
from lmgcpy.testing.case import Case
from lmgcpy.testing.draw import USUAL, Spread, cases

ROUND_OFF = 1e-10
"""Of the terms that make up a velocity (``Case.speed``): a million units of round-off, a hundred for the condition of a
block of W (coupling at most 0.99), a hundred for the operations, and a hundred for laws that iterate."""


@dataclass(frozen=True)
class Property:
    """Something that laws promise; ``check`` raises :class:`Nonconformance` for a law that breaks it."""

    name: str
    statement: str
    """In one line."""
    explanation: str
    """In full."""
    applies: Callable[[Law], str]
    """Why it does not apply to a law; "" where it does."""
    check: Callable[[Law], None]

    def __repr__(self) -> str:
        return f"<property {self.name}: {self.statement}>"


PROPERTIES: dict[str, Property] = {}
"""By name, in the order in which they are looked at."""


def to_every_law(law: Law) -> str:
    """Applies."""
    return ""


def to_laws_with(trait: str) -> Callable[[Law], str]:
    """Applies to laws that declare a trait."""
    return lambda law: "" if trait in law.TRAITS else f"the law does not declare '{trait}'"


def to_laws_that_give(function: str) -> Callable[[Law], str]:
    """Applies to laws that have an optional function."""
    return lambda law: "" if getattr(law, function) is not None else f"the law gives no {function}"


def to_laws_with_tangent(law: Law) -> str:
    """Applies to laws of more than one row."""
    return "" if law.rows(2) > 1 else "the law has no tangential component"


def run_once(
    name: str, statement: str, applies: Callable[[Law], str] = to_every_law
) -> Callable[[Callable[[Law], str]], Callable[[Law], str]]:
    """Enter a function ``law -> what is wrong, or ""`` as a property."""

    def enter(function: Callable[[Law], str]) -> Callable[[Law], str]:
        def check(law: Law) -> None:
            __tracebackhide__ = True  # by pytest: the message says it
            try:
                with np.errstate(all="ignore"):
                    told = function(law)
            except Nonconformance as error:
                raise Nonconformance(error.property, error.told, error.law or law, error.given) from error.__cause__
            except Exception as error:  # of a run, whose sentences name law and time
                raise Nonconformance(name, f"it ended with {type(error).__name__}: {error}", law) from error
            if told:
                raise Nonconformance(name, told, law)

        PROPERTIES[name] = Property(name, statement, function.__doc__ or "", applies, check)
        return function

    return enter


def drawn(
    name: str,
    statement: str,
    applies: Callable[[Law], str] = to_every_law,
    *,
    spread: Spread = USUAL,
    examples: int = 100,
) -> Callable[[Callable[[Case, Any], str]], Callable[[Case, Any], str]]:
    """Enter a function ``(case, draw) -> what is wrong, or ""`` as a property, looked at in so many cases."""

    def enter(function: Callable[[Case, Any], str]) -> Callable[[Case, Any], str]:
        def check(law: Law) -> None:
            __tracebackhide__ = True
            search(law, name, function, spread, examples)

        PROPERTIES[name] = Property(name, statement, function.__doc__ or "", applies, check)
        return function

    return enter


def search(law: Law, name: str, function: Callable[[Case, Any], str], spread: Spread, examples: int) -> None:
    """Raise Nonconformance with the smallest case that hypothesis finds in which ``function`` tells of something wrong."""
    __tracebackhide__ = True

    @settings(
        max_examples=examples,
        derandomize=True,
        database=None,
        deadline=None,
        print_blob=False,
        report_multiple_bugs=False,
        suppress_health_check=list(HealthCheck),
        phases=(Phase.generate, Phase.shrink),
    )
    @given(st.data())
    def look(data: Any) -> None:
        case = data.draw(cases(law, spread))
        try:
            told = function(case, data.draw)
        except Nonconformance as error:
            raise Nonconformance(error.property, error.told, case.law, str(case)) from error.__cause__
        if told:
            raise Nonconformance(name, told, case.law, str(case))

    try:
        with np.errstate(all="ignore"):  # numbers are looked at when they are answered
            look()
    except Nonconformance as found:
        # one without hypothesis' notes: what it drew is in the words of the case
        raise Nonconformance(found.property, found.told, found.law, found.given) from found.__cause__
    except Flaky:
        told = "the same input gave an answer that is wrong once and right another time: the law remembers something."
        raise Nonconformance("purity", told, law) from None
    except Unsatisfiable:
        told = "no input was found on which it can be seen: the law answers nothing there that is finite and smooth."
        raise Nonconformance(name, told, law) from None
