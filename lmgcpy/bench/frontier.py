"""The frontier of speed against error: every solver at every tolerance on every problem.

Each solve starts from the problem's guess. A solver that misses a tolerance does not try smaller ones, and ``Newton`` does
not try problems that are too large for Newton steps. Kernels are compiled and modules imported before any time is taken.
Solves shorter than :data:`SHORT` are repeated, and the median of their times counts.

Performance profiles (Dolan, More 2002, Math. Program. 91) are shares of problems by the time relative to the fastest.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from statistics import median

import numpy as np
import scipy.sparse as sparse

from lmgcpy.bench.cases import Case
from lmgcpy.bench.reference import ENOUGH, Reference, is_large, make_reference, sweep_budget
from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.solve.newton.active_set import ActiveSet
from lmgcpy.solve.newton.alternating import newton_steps
from lmgcpy.solve.newton.path import follow_path
from lmgcpy.solve.newton.path_3d import follow_curve
from lmgcpy.solve.newton.proximal import proximal_newton
from lmgcpy.solve.problems.problem import Problem
from lmgcpy.solve.solvers import SOLVERS, AnySolver
from lmgcpy.solve.standalone import Solution, solve
from lmgcpy.solve.sweeps.accelerated import AcceleratedGaussSeidel
from lmgcpy.solve.sweeps.gauss_seidel import GaussSeidel

TOLERANCES = tuple(10.0**-k for k in range(1, 11))
UPDATES, LARGE_UPDATES = 2e8, 1e8
"""Number of updates of interactions (sweeps times interactions) of a solve, see ``sweep_budget``; half of it for a large
problem: these take a minute (packings of 10 000 and 50 000 spheres on a shared core: 28 to 67 s)."""
SHORT, REPEATS = 0.2, 5
"""Time [s] below which a solve is repeated, and the number of solves."""


@dataclass(frozen=True)
class SolverRun:
    """One solver at one tolerance on one problem."""

    problem: str
    solver: str
    tolerance: float
    status: str
    residual: float
    """Residual in the ``natural`` measure."""
    error: float
    """Error of the relative velocities, divided by the error of doing nothing."""
    sweeps: int
    newton_steps: int
    updates: int
    """Sweeps times interactions."""
    seconds: float
    repeats: int


@dataclass(frozen=True)
class Judged:
    """A problem with its reference and all runs on it."""

    name: str
    family: str
    dimension: int
    interactions: int
    reference: Reference
    runs: tuple[SolverRun, ...]

    def best(self, solver: str, target: float) -> SolverRun | None:
        """The fastest run of a solver with an error of at most ``target``; None if there is none."""
        accurate = [run for run in self.runs if run.solver == solver and run.error <= target]
        return min(accurate, key=lambda run: run.seconds, default=None)


def judge(case: Case, solvers: Iterable[str] = tuple(SOLVERS)) -> Judged | None:
    """Run every solver on a problem; None if no impulse of its solution changes a velocity."""
    warm(case.problem)
    reference = make_reference(case)
    if reference is None:
        return None
    able = [solver for solver in solvers if solver != "newton" or not is_large(case.problem)]
    made = [pair for solver in able for pair in descend(case, solver)]
    reference = reference.with_solutions(velocities for run, velocities in made if run.residual <= ENOUGH)
    runs = tuple(replace(run, error=reference.error(velocities)) for run, velocities in made)
    return Judged(case.name, case.family, case.problem.dimension, case.interactions, reference, runs)


def descend(case: Case, name: str) -> Iterator[tuple[SolverRun, np.ndarray]]:
    """Runs of one solver, without their errors, and velocities (m, d).

    They go from the loosest tolerance to the first that the solver misses or solves to round-off only.
    """
    for tolerance in TOLERANCES:
        solver = within_budget(SOLVERS[name](tolerance=tolerance), case.problem)
        solution, seconds, repeats = timed(case.problem, solver)
        run = SolverRun(
            problem=case.name,
            solver=name,
            tolerance=tolerance,
            status=solution.status,
            residual=solution.residual,
            error=np.nan,
            sweeps=solution.iterations,
            newton_steps=solution.factorisations,
            updates=solution.iterations * case.interactions,
            seconds=seconds,
            repeats=repeats,
        )
        yield run, solution.velocities
        if solution.status != "converged":
            return


def within_budget(solver: AnySolver, problem: Problem) -> AnySolver:
    """The solver with the budget of the benchmark.

    All solvers have the same number of sweeps; Newton steps may cost as much again. A large problem has no Newton steps.
    """
    sweeps = sweep_budget(problem, LARGE_UPDATES if is_large(problem) else UPDATES)
    if isinstance(solver, (GaussSeidel, AcceleratedGaussSeidel)):
        return replace(solver, max_iterations=sweeps)
    steps = 0 if is_large(problem) else newton_steps(sweeps, *problem.guess.shape)
    return replace(solver, max_iterations=sweeps, max_factorisations=steps)


def timed(problem: Problem, solver: AnySolver) -> tuple[Solution, float, int]:
    """The solution, the median of the solver's times [s], and their number."""
    solution = solve(problem, solver=solver)
    seconds = [solution.seconds]
    if solution.seconds < SHORT:
        seconds += [solve(problem, solver=solver).seconds for _ in range(REPEATS - 1)]
    return solution, median(seconds), len(seconds)


def warm(problem: Problem) -> None:
    """Compile or load every kernel that the problem needs, and import the modules of Newton steps."""
    for kind in (GaussSeidel, AcceleratedGaussSeidel):  # Newton steps of this problem may take minutes
        solve(problem, solver=kind(tolerance=1e-15, max_iterations=1))
    d = problem.dimension
    one = Problem(sparse.csr_array(np.eye(d)), np.array([-1.0, 0.1, 0.0][:d]), np.full(1, 0.3), d, (Coulomb.NAME,),
                  np.zeros(1), np.zeros((1, d)))  # fmt: skip
    active = ActiveSet(one)
    proximal_newton(active, one.guess, 0.0, 1)
    follow = follow_path if d == 2 else follow_curve
    follow(active, -np.ones((1, d)), 1.0, one.guess, 20)  # from an open contact to a closed one: a path with a bend


SMALLEST = 20
"""Smallest number of interactions of a problem; on smaller ones the time of the function call dominates."""

OVERHEAD = 1e-3
"""Smallest time that counts [s]; shorter times are mostly the time of a call from Python."""


@dataclass(frozen=True)
class Profile:
    """Ratios of time to a true error, by solver."""

    target: float
    """Error to be reached."""
    ratios: dict[str, np.ndarray]
    """For each solver its time divided by the fastest time, (problems,) ascending; infinite if it missed the error."""
    unsolved: int
    """Number of problems that no solver solved to the error; they are left out."""

    @property
    def problems(self) -> int:
        return len(next(iter(self.ratios.values()))) if self.ratios else 0

    def failures(self, solver: str) -> int:
        """Number of problems on which a solver did not reach the error but another one did."""
        return int(np.isinf(self.ratios[solver]).sum())

    def share(self, solver: str, ratio: float) -> float:
        """Share of the problems on which a solver takes at most ``ratio`` times the time of the fastest."""
        return float(np.searchsorted(self.ratios[solver], ratio, side="right")) / max(self.problems, 1)


def profile(judged: Sequence[Judged], solvers: Sequence[str], target: float) -> Profile:
    """The profile over the problems with :data:`SMALLEST` interactions or more whose references can judge the error."""
    rows, unsolved = [], 0
    for problem in judged:
        if problem.interactions < SMALLEST or problem.reference.floor > target:
            continue
        best = [problem.best(solver, target) for solver in solvers]
        times = np.array([np.inf if run is None else max(run.seconds, OVERHEAD) for run in best])
        if np.isinf(times).all():
            unsolved += 1
        else:
            rows.append(times / times.min())
    table = np.array(rows).reshape(-1, len(solvers))
    return Profile(target, {solver: np.sort(table[:, k]) for k, solver in enumerate(solvers)}, unsolved)
