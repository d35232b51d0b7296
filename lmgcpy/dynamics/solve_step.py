"""The solve of one step: the solver gets its :class:`Step <lmgcpy.Step>`, and its answer is checked."""

from __future__ import annotations

import time as clock

from lmgcpy.dynamics.faults import LawFault, check_solution, fault_of_solve
from lmgcpy.dynamics.geometric_stiffness import LinkStiffness, solve_stiffened
from lmgcpy.dynamics.step_problem import StepProblem
from lmgcpy.solve.problems.report import NOT_FINITE, STATUS, Report
from lmgcpy.solve.sweeps.solver import Solver


def solve_step(problem: StepProblem, solver: Solver, links: LinkStiffness | None) -> tuple[StepProblem, Report]:
    """Solve from the guess; returns the problem with the stiffness of its links and the velocities at its end.

    ``links``: the links if they have geometric stiffness, else None. Raises FloatingPointError, with the interaction, if a
    number stops being finite, and RuntimeError if a law fails.
    """
    start, solves = clock.perf_counter(), 1
    problem.begin()
    if links is not None and links.count:
        problem, outcome, solves = solve_stiffened(links, problem, solver)
    else:
        outcome = solver.solve(problem)
    report = Report(
        iterations=outcome.iterations,
        factorisations=outcome.factorisations,
        residual=outcome.residual,
        slip=outcome.slip,
        force=outcome.force,
        status=STATUS[outcome.status],
        worst=problem.worst(),
        interactions=len(problem.system.impulse),
        seconds=clock.perf_counter() - start,
        solves=solves,
    )
    if outcome.status == NOT_FINITE:
        raise fault(problem, solver)
    check_solution(problem, solver)
    problem.end()
    return problem, report


def fault(problem: StepProblem, solver: Solver) -> Exception:
    """The error for a step without a finite result."""
    when = f"In the step from t = {problem.data.time:g} s"
    try:
        what = fault_of_solve(problem, solver.solve)
    except LawFault as law_fault:
        error = RuntimeError(f"{when} {law_fault}.")
        error.__cause__ = law_fault.__cause__
        return error
    return FloatingPointError(f"{when} a number stopped being finite: {what}.")
