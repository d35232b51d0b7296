"""The two entry points of the kit: tests of a law, and a report on it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

from lmgcpy.errors import named_arguments, one_of, shown
from lmgcpy.laws import Law
from lmgcpy.testing.answers import Nonconformance
from lmgcpy.testing.property import PROPERTIES, Property


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
