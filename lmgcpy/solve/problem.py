"""One step as a problem of its own: ``u = W r + q`` with an assembled Delassus operator, and a cone per interaction.

The laws enter in conic form: biases are part of ``q``, and what is left of a law is its cone, its friction and its
compliance. Three cones cover the laws that come with lmgcpy:

* contact: ``0 <= u_n _|_ r_n >= 0`` and ``r_t`` in the disk of radius ``mu r_n``, opposing ``u_t`` when sliding;
* pull: ``0 <= -(u_n + C r_n) _|_ -r_n >= 0``, ``r_t = 0`` (wires);
* both: ``u_n + C r_n = 0``, ``r_t = 0`` (rods).

A link with geometric stiffness kappa has ``r_t = -kappa u_t`` in place of ``r_t = 0``.
"""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lmgcpy.errors import LARGEST, named_arguments, numbers, one_of, shown, whole
from lmgcpy.laws import Law
from lmgcpy.laws import get as law_of_name
from lmgcpy.solve.delassus import check_semidefinite, checked_operator, unsolvable
from lmgcpy.solve.solver import Solver, check_solver

if TYPE_CHECKING:
    import scipy.sparse as sparse

CONTACT, PULL, BOTH = range(3)
MEASURES = ("natural", "fclib", "slip")


def cone_of(law: type[Law]) -> int:
    """Which of the three cones a law's impulse lives in."""
    if law.APPLIES_TO == "contact":
        return CONTACT
    return PULL if "pull" in law.TRAITS else BOTH


@named_arguments
@dataclass(frozen=True)
class Problem:
    """A frozen problem of m interactions in dimension d; see the module's text.

    Whatever it is made of is checked and copied: TypeError for what are no numbers, ValueError for those that make no
    problem, such as shapes that do not fit, indices of W that lead out of it, or a W that is not symmetric.
    """

    W: sparse.csr_array
    """Delassus operator [1/kg], (m d, m d), normal component first; given in any sparse format, kept as sorted rows."""
    q: np.ndarray
    """Free relative velocity, biases included [m/s], (m d,)."""
    mu: np.ndarray
    """Coefficient of friction of the contacts, (m,)."""
    dimension: int
    """2 or 3."""
    laws: tuple[str, ...]
    """Name of the law of each interaction, (m,)."""
    compliance: np.ndarray
    """Compliance of the links [1/kg], (m,)."""
    guess: np.ndarray
    """Impulses to start from [N s], (m, d)."""
    geometric: np.ndarray = field(default_factory=lambda: np.zeros(0))
    """Geometric stiffness of the links [kg], (m,): what they answer to a velocity across them; zero if none is given."""
    scale: np.ndarray | None = None
    """Time step over the radius of the smaller body [s/m], (m,); None where it is not known."""
    cone_by_law: Mapping[str, int] = field(default_factory=dict)
    """Cone (0 contact, 1 pull, 2 both) of the laws that are not registered, by name."""

    def __post_init__(self):
        whole(self.dimension, "dimension of a problem", minimum=2, maximum=3)
        if not isinstance(self.cone_by_law, Mapping):
            raise TypeError(f"cone_by_law of a problem must be cones by names of laws, got {shown(self.cone_by_law)}.")
        for law, cone in self.cone_by_law.items():
            whole(cone, f"cone_by_law[{shown(law)}] of a problem", minimum=CONTACT, maximum=BOTH)
        object.__setattr__(self, "W", checked_operator(self.W))
        for name in ("q", "mu", "compliance", "guess", "geometric") + (() if self.scale is None else ("scale",)):
            object.__setattr__(self, name, numbers(getattr(self, name), f"{name} of a problem"))
        if self.geometric.size == 0:
            object.__setattr__(self, "geometric", np.zeros_like(self.mu))
        self._check_shapes()
        check_semidefinite(self.W)
        contact = self.cones == CONTACT
        diagonal = self.W.diagonal()[:: self.dimension]
        for name, values, sound, bound in (
            ("mu", self.mu, self.mu >= 0.0, "at least 0"),
            ("compliance", self.compliance, self.compliance >= 0.0, "at least 0"),
            ("geometric", self.geometric, self.geometric >= 0.0, "at least 0"),
            ("geometric", self.geometric, ~contact | (self.geometric == 0.0), "0 for a contact"),
            *(() if self.scale is None else (("scale", self.scale, self.scale >= 0.0, "at least 0"),)),
            ("W", diagonal, np.where(contact, diagonal > 0.0, diagonal >= 0.0), "above 0 on its diagonal"),
            ("W", diagonal, ~contact | (diagonal >= 1.0 / LARGEST), f"at least {1.0 / LARGEST:g} on its diagonal"),
        ):
            if not sound.all():
                i = int(np.argmin(sound))
                law = self.laws[i]
                raise ValueError(f"{name} of a problem must be {bound}, got {values[i]:g} for interaction {i} ('{law}').")

    def _check_shapes(self) -> None:
        if self.mu.ndim != 1:
            raise ValueError(f"mu of a problem must have shape (m,), got {self.mu.shape}.")
        count, d = len(self.mu), self.dimension
        if self.W.shape == 2 * self.q.shape and len(self.q) % d == 0:  # two against mu
            count = len(self.q) // d
        shapes = {
            "mu": (count,),
            "W": (count * d, count * d),
            "q": (count * d,),
            "compliance": (count,),
            "guess": (count, d),
            "geometric": (count,),
        }
        if self.scale is not None:
            shapes["scale"] = (count,)
        for name, shape in shapes.items():
            got = getattr(self, name).shape
            if got != shape:
                raise ValueError(f"{name} of a problem of {count} interactions must have shape {shape}, got {got}.")
        if not isinstance(self.laws, (tuple, list)) or len(self.laws) != count:
            raise ValueError(f"A problem of {count} interactions must name {count} laws, got {shown(self.laws)}.")

    @property
    def cones(self) -> np.ndarray:
        """Cone of each interaction (0 contact, 1 pull, 2 both), (m,)."""
        known = self.cone_by_law
        of = {name: known[name] if name in known else cone_of(law_of_name(name)) for name in set(self.laws)}
        return np.array([of[name] for name in self.laws], dtype=np.int64)

    def velocities(self, impulses: np.ndarray) -> np.ndarray:
        """``W r + q`` [m/s], (m, d)."""
        return (self.W @ np.asarray(impulses, dtype=float).ravel() + self.q).reshape(-1, self.dimension)

    @property
    def rows(self) -> np.ndarray:
        """Which components of an impulse may be other than zero, (m, d) bool."""
        across = ((self.cones == CONTACT) & (self.mu > 0.0)) | (self.geometric > 0.0)
        rows = np.repeat(across[:, None], self.dimension, axis=1)
        rows[:, 0] = True
        return rows

    def local_weight(self) -> np.ndarray:
        """Mean diagonal of each local block, over the rows that the law has [1/kg], (m,)."""
        diagonal = self.W.diagonal().reshape(-1, self.dimension)
        return np.where(self.rows[:, 1], diagonal.mean(axis=1), diagonal[:, 0])

    def __repr__(self) -> str:
        names, counts = np.unique(np.array(self.laws, dtype=str), return_counts=True)
        by_law = ", ".join(f"{count} {name}" for name, count in zip(names, counts, strict=True))
        return f"<Problem in {self.dimension}D: {by_law or 'no interaction'}, {self.W.nnz} entries of W>"


class Conic(NamedTuple):
    """A step in conic form."""

    problem: Problem
    acting: np.ndarray
    """Which interactions of the step are in the problem, (m,) bool."""


@dataclass(frozen=True)
class ConicForm:
    """Makes the problem of a step in conic form when it is called, which may take longer than some sweeps."""

    make: Callable[[], Conic]
    missing: str | None = None
    """Name of a law of the step that has no conic form: then the call raises TypeError."""

    def __call__(self) -> Conic:
        return self.make()


@dataclass(frozen=True)
class Solution:
    """What a solver made of a problem."""

    impulses: np.ndarray
    """[N s], (m, d)."""
    velocities: np.ndarray
    """[m/s], (m, d)."""
    residual: float
    """``natural``, computed from the problem as it stands."""
    status: str
    """"converged", "budget spent", "stagnated", "not finite" or "round-off"."""
    iterations: int
    """Sweeps."""
    factorisations: int
    """Newton steps."""
    seconds: float
    """Time of the clock that the solver took [s]."""

    def __repr__(self) -> str:
        newton = f" and {self.factorisations} Newton steps" if self.factorisations else ""
        return (
            f"<Solution of {len(self.impulses)} interactions: {self.status} after {self.iterations} sweeps{newton} at a "
            f"residual of {self.residual:.2e} in {self.seconds:.4f} s>"
        )


def _check(problem: Any, call: str) -> None:
    if not isinstance(problem, Problem):
        raise TypeError(
            f"{call} takes a problem, from lmgcpy.io.fclib.read(path) or Simulation.problem(), got {shown(problem)}."
        )


def react_alone(problem: Problem, free: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Impulses that satisfy the laws where W is ``weight`` times the identity and the free velocity ``free``, (m, d)."""
    cones = problem.cones
    impulse = np.zeros_like(free)
    with_compliance = np.where(cones == CONTACT, weight, weight + problem.compliance)
    changes = with_compliance > 0.0  # else no impulse changes the velocity
    normal = np.divide(-free[:, 0], with_compliance, out=np.zeros(len(free)), where=changes)
    impulse[:, 0] = np.select([cones == CONTACT, cones == PULL], [np.maximum(normal, 0.0), np.minimum(normal, 0.0)], normal)
    contact = (cones == CONTACT) & (problem.mu > 0.0)
    limit = problem.mu[contact] * impulse[contact, 0]
    tangential = -free[contact, 1:] / weight[contact, None]
    size = np.linalg.norm(tangential, axis=1)
    inside = np.where(size > limit, limit / np.where(size > 0.0, size, 1.0), 1.0)
    impulse[contact, 1:] = tangential * inside[:, None]
    stiff = problem.geometric > 0.0
    kappa = problem.geometric[stiff]
    impulse[stiff, 1:] = -(kappa / (1.0 + kappa * weight[stiff]))[:, None] * free[stiff, 1:]
    return impulse


@named_arguments
def residual(problem: Problem, impulses: Any, *, measure: str = "natural") -> float:
    """How far impulses (m, d) are from solving a problem.

    "natural": ``|e(r)| / |e(0)|`` with ``e = w (r - react(w I, u - w r))``, ``w`` the mean diagonal of the local block:
    the error of the velocities relative to that of doing nothing. "fclib": ``|w0 r - P_K(w0 r - (u + mu |u_t| n))| / |q|``
    with ``w0`` the mean diagonal of W, the measure of published solvers; links have their own law's projection. Both are
    infinite where they overflow.
    "slip": the largest ``h |e_i| / R_i``, R_i the radius of the smaller body, of a problem that knows it, as those of
    ``Simulation.problem`` do (ValueError where it does not).
    """
    _check(problem, "residual")
    one_of(measure, "measure", MEASURES)
    r = numbers(impulses, "impulses")
    if r.shape != problem.guess.shape:
        raise ValueError(f"impulses must have shape {problem.guess.shape}, got {r.shape}.")
    if measure == "slip":
        if problem.scale is None:
            raise ValueError(
                "This problem knows no sizes of bodies, as those from FCLIB files do not, so that measure='slip' has no "
                "meaning: say 'natural' or 'fclib', or take the problem from Simulation.problem()."
            )
        return float((problem.scale * np.linalg.norm(_errors(problem, r), axis=1)).max(initial=0.0))
    with np.errstate(over="ignore", invalid="ignore"):
        if measure == "fclib":
            error, scale = _fclib_error(problem, r), float(np.linalg.norm(problem.q))
        else:
            error, scale = _natural_error(problem, r), _natural_error(problem, np.zeros_like(r))
    if scale == 0.0:
        return 0.0 if error == 0.0 else np.inf
    return error / scale if np.isfinite(error) else np.inf


def _errors(problem: Problem, r: np.ndarray) -> np.ndarray:
    """``w (r - react(w I, u - w r))`` [m/s], (m, d)."""
    weight = problem.local_weight()
    free = problem.velocities(r) - weight[:, None] * r
    return weight[:, None] * (r - react_alone(problem, free, weight))


def _natural_error(problem: Problem, r: np.ndarray) -> float:
    return float(np.linalg.norm(_errors(problem, r)))


def _fclib_error(problem: Problem, r: np.ndarray) -> float:
    u = problem.velocities(r)
    w0 = float(problem.W.diagonal().mean()) if len(problem.mu) else 1.0
    cones = problem.cones
    weight = np.full(len(problem.mu), w0)
    projected = w0 * react_alone(problem, u - w0 * r, weight)
    contact = cones == CONTACT
    shifted = u[contact]
    shifted[:, 0] += problem.mu[contact] * np.linalg.norm(u[contact, 1:], axis=1)
    projected[contact] = project_on_cone(w0 * r[contact] - shifted, problem.mu[contact])
    return float(np.linalg.norm(w0 * r - projected))


def project_on_cone(x: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """Euclidean projection of rows (n, t...) on the cone ``|t| <= mu n``, (m, d)."""
    n, t = x[:, 0], x[:, 1:]
    size = np.linalg.norm(t, axis=1)
    inside = size <= mu * n
    polar = mu * size <= -n
    on_edge = (n + mu * size) / (1.0 + mu**2)
    edge = np.column_stack([on_edge, t * (mu * on_edge / np.where(size > 0.0, size, 1.0))[:, None]])
    return np.where(inside[:, None], x, np.where(polar[:, None], 0.0, edge))


@named_arguments
def solve(problem: Problem, *, solver: Solver | None = None, guess: Any = None) -> Solution:
    """Solve a problem, from ``guess`` (m, d) or the problem's own.

    ``solver``: such as ``lmgcpy.Newton(tolerance=1e-10)``; ``lmgcpy.Auto()`` if none is given. Where the impulses grow
    without bound, ValueError tells that W is not positive semidefinite, or else FloatingPointError that there is no
    solution.
    """
    from lmgcpy.solve.matrix_system import DRIVER_NAMES, assemble_problem
    from lmgcpy.solve.newton.alternating import Auto
    from lmgcpy.solve.report import STATUS

    _check(problem, "solve")
    solver = Auto() if solver is None else solver
    check_solver(solver)
    start = problem.guess if guess is None else numbers(guess, "guess")
    if start.shape != problem.guess.shape:
        raise ValueError(f"guess must have shape {problem.guess.shape}, got {start.shape}.")
    start = np.where(problem.rows, start, 0.0)
    table, system, kernels = assemble_problem(problem, solver.wire_blocks)
    operator = DRIVER_NAMES[problem.dimension]
    begin = clock.perf_counter()
    free_velocity = problem.q.reshape(-1, problem.dimension).copy()
    all_act = np.ones(len(problem.mu), dtype=bool)
    with np.errstate(all="ignore"):  # what comes out is looked at
        outcome = solver.solve(
            table, system, free_velocity, start, conic=ConicForm(lambda: Conic(problem, all_act)), **operator
        )
    seconds = clock.perf_counter() - begin
    del kernels  # the table holds their addresses, which end with them
    impulses = system.impulse
    error = residual(problem, impulses) if (np.abs(impulses) <= LARGEST).all() else np.inf
    if error > 1.0:  # worse than doing nothing
        unsolvable(problem.W, finite=error < np.inf)
    return Solution(
        impulses=impulses,
        velocities=problem.velocities(impulses),
        residual=error,
        status=STATUS[outcome.status],
        iterations=outcome.iterations,
        factorisations=outcome.factorisations,
        seconds=seconds,
    )
