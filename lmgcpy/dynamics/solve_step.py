"""The solve of one step: the solver gets its :class:`Step <lmgcpy.Step>`, and its answer is checked."""

from __future__ import annotations

import time as clock

import numpy as np

from lmgcpy.dynamics.assembled_problem import conic_form
from lmgcpy.dynamics.assembly import KEPT, StepProblem
from lmgcpy.dynamics.faults.diagnosis import LawFault, fault_of_solve
from lmgcpy.dynamics.faults.finite_checks import VELOCITY, check_bodies, check_impulses
from lmgcpy.dynamics.geometric_stiffness import LinkStiffness, solve_stiffened
from lmgcpy.solve.kernels.system import System
from lmgcpy.solve.problems.report import NOT_FINITE, STATUS, Outcome, Report
from lmgcpy.solve.sweeps.solver import Solver
from lmgcpy.solve.sweeps.step import Step


def solve_step(
    problem: StepProblem, solver: Solver, links: LinkStiffness | None, row: np.ndarray | None, threads: int
) -> tuple[StepProblem, Report]:
    """Solve from the guess; returns the problem with the stiffness of its links and the velocities at its end.

    ``links``: the links if they have geometric stiffness, else None; ``row``: row of each body in the solver's arrays (n,),
    None if each body keeps its own row. Raises FloatingPointError, with the interaction, if a number stops being finite,
    and RuntimeError if a law fails.
    """

    def call(problem: StepProblem) -> Outcome:
        return call_solver(problem, solver, row, threads)

    start, solves = clock.perf_counter(), 1
    if links is not None and links.count:
        problem, outcome, solves = solve_stiffened(links, problem, call)
    else:
        outcome = call(problem)
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
    time = problem.data.time
    if outcome.status == NOT_FINITE:
        raise fault(problem, solver)
    check_impulses(problem, solver)
    check_bodies(problem.system.velocity, VELOCITY[problem.dimension], "at its end", time)
    problem.end()
    return problem, report


def call_solver(problem: StepProblem, solver: Solver, row: np.ndarray | None = None, threads: int = 1) -> Outcome:
    """Let a solver solve the problem of a step in place."""
    if row is None:
        step = problem.step
        if step is None or step.threads != threads:
            step = as_step(problem, problem.system, problem.free_velocity, threads)
            # the step holds the problem: large arrays would wait for the collector of garbage
            keep = len(problem.guess) <= KEPT and not len(problem.light.body)
            problem.step = step if keep else None
        return solver.solve(step)
    system, free_velocity = problem.system.reordered(row, problem.free_velocity)
    outcome = solver.solve(as_step(problem, system, free_velocity, threads, row))
    problem.system.velocity[:] = system.velocity.take(row, axis=0)
    return outcome


def as_step(
    problem: StepProblem, system: System, free_velocity: np.ndarray, threads: int, row: np.ndarray | None = None
) -> Step:
    """The step as a solver gets it; ``row``: see :func:`solve_step`."""
    light = problem.light
    if len(light.body):
        free_velocity = free_velocity.copy()  # sweeps move the centres of light bodies
        if row is not None:
            light = light._replace(body=row[light.body])
    conic, components = conic_form(problem), problem.components
    return Step(problem.table, system, free_velocity, problem.guess, conic, components, light=light, threads=threads)


def fault(problem: StepProblem, solver: Solver) -> Exception:
    """The error for a step without a finite result."""
    when = f"In the step from t = {problem.data.time:g} s"
    try:
        what = fault_of_solve(problem, lambda watched: call_solver(watched, solver))
    except LawFault as law_fault:
        error = RuntimeError(f"{when} {law_fault}.")
        error.__cause__ = law_fault.__cause__
        return error
    return FloatingPointError(f"{when} a number stopped being finite: {what}.")
