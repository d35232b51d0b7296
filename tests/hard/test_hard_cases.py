"""Every hard case with every solver: its numbers hold, or the solver fails as the case says that it does."""

from __future__ import annotations

import warnings

import pytest
from case import Case, Result
from cases import CASES

RUNS = [(case, solver) for case in CASES for solver in case.solvers]


def named(runs: list[tuple[Case, str]]) -> list[str]:
    """The ids of tests."""
    return [f"{case.name}-{solver}" for case, solver in runs]


def run(case: Case, solver: str, *, long: bool = False) -> Result:
    """Run a case; of its warnings those are expected that it says it gives, and no others but those of jerks, which many
    cases are about."""
    with warnings.catch_warnings():
        # jerks, waves that the step damps, and the round-off of stiff links
        of_many = "In the step.*jerk without rebound", "Until t = .* waves of the wire", r"Until t = .* made \S+e-[23]\d J"
        for text in (*case.says, *of_many):
            warnings.filterwarnings("ignore", text, RuntimeWarning)
        return case.run(solver, long=long)


def check(case: Case, solver: str, result: Result) -> None:
    """What is expected to fail must fail, and the default solver may not: what it misses is an expected failure."""
    told = f"{case.name} with {solver}: {result}"
    if solver in case.fails and solver != "Auto":
        assert not result.holds, f"{told}; it was to fail: {case.fails[solver]}"
        return
    if solver in case.fails and not result.holds:
        pytest.xfail(f"{told}; {case.fails[solver]}")
    assert solver not in case.fails, f"{told}: mended; take it out of what fails"
    for number in result.numbers:
        assert number.holds, f"{told}; {number.what} may be {number.bound:.0e}"


@pytest.mark.default_parameters(
    "capstan-Auto",
    "disk in a wedge-Auto",
    "arch of stones-Auto",
    "column of spheres under 1e4 times its mass-Auto",
)
@pytest.mark.parametrize(("case", "solver"), RUNS, ids=named(RUNS))
def test_hard_case(case, solver):
    check(case, solver, run(case, solver))


LONG = [(case, solver) for case, solver in RUNS if case.long]


@pytest.mark.long
@pytest.mark.parametrize(("case", "solver"), LONG, ids=named(LONG))
def test_long_form(case, solver):
    check(case, solver, run(case, solver, long=True))


TAUT = [case for case in CASES if case.without]


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:In the step:RuntimeWarning", "ignore:Until t:RuntimeWarning")
@pytest.mark.parametrize("case", TAUT, ids=[case.name for case in TAUT])
def test_it_fails_without_geometric_stiffness(case):
    result = case.run("Newton", geometric_stiffness=False)
    assert not result.holds, f"{case.name}: {result}; it was to fail: {case.without}"


def test_every_case_says_why_it_is_hard():
    for case in CASES:
        text = case.scene.__doc__
        assert "Hard:" in text, case.name
        assert "Number" in text, case.name
