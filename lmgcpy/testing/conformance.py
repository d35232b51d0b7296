"""The two entry points of the kit, tests of a law and a report on it; and properties of laws with the search for
counterexamples.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from hypothesis.errors import Flaky, Unsatisfiable

from lmgcpy.errors import named_arguments, one_of, shown
from lmgcpy.laws import Law
from lmgcpy.testing.case import LawCase, Nonconformance
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


@dataclass(frozen=True)
class Check:
    """The check of one property of one law. A call raises Nonconformance (an AssertionError) if the property is broken."""

    law: Law
    property: Property

    def __call__(self) -> None:
        __tracebackhide__ = True
        self.property.check(self.law)

    def __repr__(self) -> str:
        return f"<check of {self.property.name} of {self.law!r}>"


@named_arguments
def conformance(*laws: Law, skip: Iterable[str] = ()) -> Callable[[Callable[[Any], Any]], Any]:
    """Decorator that turns one test into one test for each property that applies to the laws::

        @lmgcpy.testing.conformance(MyLaw(strength=10.0))
        def test_my_law(check):
            check()

    ``laws`` are instances; the tests vary parameters around theirs. ``skip`` names properties that the laws are known not
    to have. The decorator needs pytest. It raises TypeError or ValueError with a sentence.
    """
    import pytest

    without = set(_known(skip))
    if not laws:
        raise TypeError("conformance takes at least one law, as conformance(MyLaw(strength=10.0)).")
    cases = []
    for law in laws:
        _check_law(law, "conformance")
        for name, prop in PROPERTIES.items():
            if name not in without and not prop.applies(law):
                of = law.NAME if len(laws) == 1 else repr(law).replace(" ", "")
                cases.append(pytest.param(Check(law, prop), id=f"{of}-{name}"))
    return pytest.mark.parametrize("check", cases)


@dataclass(frozen=True)
class Finding:
    """The result of the check of one property."""

    property: Property
    outcome: str
    """"holds", "broken", "does not apply", or "not checked"."""
    message: str
    """The breach, or the reason why the property was not checked."""

    def __str__(self) -> str:
        message = self.property.statement if self.outcome == "holds" else self.message
        return f"{self.property.name:<14}{self.outcome:<16}" + message.replace("\n", "\n" + 30 * " ")

    def __repr__(self) -> str:
        return f"<Finding: {self.property.name} {self.outcome}>"


@dataclass(frozen=True)
class LawReport:
    """The ``findings`` on a law, in the order of the properties. ``print`` shows them."""

    law: Law
    findings: tuple[Finding, ...]

    @property
    def conforms(self) -> bool:
        """Whether all properties hold or do not apply."""
        return all(finding.outcome in ("holds", "does not apply") for finding in self.findings)

    @property
    def broken(self) -> list[str]:
        """Names of the properties that are broken."""
        return [finding.property.name for finding in self.findings if finding.outcome == "broken"]

    def __str__(self) -> str:
        verdict = "conforms" if self.conforms else f"breaks {', '.join(self.broken)}"
        return "\n".join([f"{self.law!r} (law '{self.law.NAME}') {verdict}.", "", *map(str, self.findings)])

    def __repr__(self) -> str:
        return f"<LawReport: {self.law!r} {'conforms' if self.conforms else f'breaks {len(self.broken)} properties'}>"


@named_arguments
def report(law: Law, *, skip: Iterable[str] = ()) -> LawReport:
    """Check all properties of a law, for scripts. If the interface is broken, no other property is checked."""
    _check_law(law, "report")
    without = set(_known(skip))
    findings: dict[str, Finding] = {}
    for name, prop in PROPERTIES.items():
        reason = "skipped" if name in without else prop.applies(law)
        if reason:
            findings[name] = Finding(prop, "does not apply", reason)
        elif "interface" in findings and findings["interface"].outcome == "broken":
            findings[name] = Finding(prop, "not checked", "interface comes first")
        else:
            _look(law, prop, findings)
    return LawReport(law, tuple(findings.values()))


def _look(law: Law, prop: Property, findings: dict[str, Finding]) -> None:
    try:
        prop.check(law)
    except Nonconformance as failure:
        cause = PROPERTIES[failure.property]
        findings[cause.name] = Finding(cause, "broken", str(failure))
        if cause is not prop:
            findings[prop.name] = Finding(prop, "not checked", f"{cause.name} comes first")
    else:
        findings.setdefault(prop.name, Finding(prop, "holds", ""))


def _known(names: Iterable[str]) -> list[str]:
    if isinstance(names, str):
        raise TypeError(f"skip takes a list of names of properties, as skip=['{names}'], got {shown(names)}.")
    return [one_of(name, "A property to skip", PROPERTIES) for name in names]


def _check_law(law: Any, call: str) -> None:
    if isinstance(law, type) and issubclass(law, Law):
        raise TypeError(f"{call} takes laws with their parameters, as {law.__name__}(...), got the class.")
    if not isinstance(law, Law):
        raise TypeError(f"{call} takes laws, as lmgcpy.Coulomb(friction=0.3), got {shown(law)}.")
