"""Properties of laws, and the search for counterexamples."""

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
from lmgcpy.testing.case import LawCase
from lmgcpy.testing.draw import USUAL, Spread, cases

ROUND_OFF = 1e-10
"""Allowed error relative to the terms of a velocity (``LawCase.speed``), a million units of round-off: a hundred for the
condition of a block of W (coupling at most 0.99), a hundred for the operations, and a hundred for laws that iterate."""


@dataclass(frozen=True)
class Property:
    """A property of laws; ``check`` raises :class:`Nonconformance` for a law that breaks it."""

    name: str
    statement: str
    """The property in one line."""
    explanation: str
    """The property in full."""
    applies: Callable[[Law], str]
    """The reason why the property does not apply to a law; "" if it applies."""
    check: Callable[[Law], None]

    def __repr__(self) -> str:
        return f"<property {self.name}: {self.statement}>"


PROPERTIES: dict[str, Property] = {}
"""Properties by name, in the order in which they are checked."""


def to_every_law(law: Law) -> str:
    """The property applies to every law."""
    return ""


def to_laws_with(trait: str) -> Callable[[Law], str]:
    """The property applies to laws that declare a trait."""
    return lambda law: "" if trait in law.TRAITS else f"the law does not declare '{trait}'"


def to_laws_that_give(function: str) -> Callable[[Law], str]:
    """The property applies to laws that have an optional function."""
    return lambda law: "" if getattr(law, function) is not None else f"the law gives no {function}"


def to_laws_with_tangent(law: Law) -> str:
    """The property applies to laws with more than one row."""
    return "" if law.rows(law.DIMENSIONS[0]) > 1 else "the law has no tangential component"


def to_laws_in_space(law: Law) -> str:
    """The property applies to laws of scenes in 3D with more than the normal row."""
    if 3 not in law.DIMENSIONS:
        return "the law is for scenes in 2D"
    return "" if law.rows(3) > 1 else "the law has no tangential component"


def to_contact_laws(law: Law) -> str:
    """The property applies to laws of contacts."""
    return "" if law.APPLIES_TO == "contact" else "the law is for links"


def run_once(
    name: str, statement: str, applies: Callable[[Law], str] = to_every_law
) -> Callable[[Callable[[Law], str]], Callable[[Law], str]]:
    """Decorator that makes a property of a function ``law -> error, or ""``."""

    def enter(function: Callable[[Law], str]) -> Callable[[Law], str]:
        def check(law: Law) -> None:
            __tracebackhide__ = True  # pytest shows the message only
            try:
                with np.errstate(all="ignore"):
                    message = function(law)
            except Nonconformance as error:
                raise Nonconformance(error.property, error.message, error.law or law, error.given) from error.__cause__
            except Exception as error:  # a run failed; its sentence names law and time
                raise Nonconformance(name, f"it ended with {type(error).__name__}: {error}", law) from error
            if message:
                raise Nonconformance(name, message, law)

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
) -> Callable[[Callable[[LawCase, Any], str]], Callable[[LawCase, Any], str]]:
    """Decorator that makes a property of a function ``(case, draw) -> error, or ""``, checked in ``examples`` cases."""

    def enter(function: Callable[[LawCase, Any], str]) -> Callable[[LawCase, Any], str]:
        def check(law: Law) -> None:
            __tracebackhide__ = True
            search(law, name, function, spread, examples)

        PROPERTIES[name] = Property(name, statement, function.__doc__ or "", applies, check)
        return function

    return enter


def search(law: Law, name: str, function: Callable[[LawCase, Any], str], spread: Spread, examples: int) -> None:
    """Raise Nonconformance with the smallest case found by hypothesis in which ``function`` gives an error."""
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
            message = function(case, data.draw)
        except Nonconformance as error:
            raise Nonconformance(error.property, error.message, case.law, str(case)) from error.__cause__
        if message:
            raise Nonconformance(name, message, case.law, str(case))

    try:
        with np.errstate(all="ignore"):  # the answers are checked for NaN and infinity
            look()
    except Nonconformance as found:
        # a new exception, without the notes of hypothesis: the text of the case shows the draw
        raise Nonconformance(found.property, found.message, found.law, found.given) from found.__cause__
    except Flaky:
        message = "the same input gave once a wrong and once a right answer: the law remembers something."
        raise Nonconformance("purity", message, law) from None
    except Unsatisfiable:
        message = "no input was found that can show the property: the law gives no finite and smooth answer there."
        raise Nonconformance(name, message, law) from None
