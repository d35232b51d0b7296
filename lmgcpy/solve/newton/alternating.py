"""Solvers that alternate sweeps with Newton steps: ``Newton`` for the last digits, ``Auto`` for everything.

Sweeps are cheap and find most statuses within some hundreds, but they hardly reduce the slow modes of a jammed sample
or of a locked chain. Newton steps on the statuses found solve these modes at once, and fail if many statuses are wrong.
So they alternate: sweeps, Newton steps as long as they gain, twice as many sweeps, and so on. ``Auto`` first tries a few
Newton steps, and goes on with its sweeps if these gain nothing: on steps of samples, Newton steps after sweeps of the
same cost are mostly three times too early.

The patience with Newton steps that gain nothing doubles as well. If a solution has just ceased to exist as loads grew,
sweeps always return to the same impulses, and the residual must grow for many steps before it falls. (A step of a
biaxial test with rigid rods was solved to 1e-6 within 300 Newton steps from 8 of eight first turns of 700 to 1500
sweeps; with a constant patience from 3.)

If Newton steps have still gained nothing, their last impulses are disturbed a little, with the same random numbers every
time, because sweeps alone would lead back to them. (Sweeps then start from these impulses, not from the best so far, and
a gain is measured from the largest residual since the last gain. This solves 46 of 48 steps of compactions of 100 to 200
spheres to 1e-8, in 23 600 Newton steps; without both it is 42, in 31 600.)

The kernels of the laws measure every result, as they do for every other solver.

**When a step is given up**, with the status "stagnated". In jammed samples with friction neither sweeps nor Newton steps
need come to an end: impulses drift along self-stresses, and contacts go on changing their statuses, while the residual
stays the same. Work spent then is lost. So a solve ends when it has cost :data:`TWICE` as much as when its least residual
last fell by a tenth, plus a grace. Costs are counted in sweeps, never read off a clock.

The grace is taken from successful solves. (Of 31 solves to 1e-6 and 1e-8, steps of packs of 100 to 200 rough spheres,
the two TexSol steps and 2000 settling spheres, the longest wait for a gain was 9.9e7 visits beyond twice; eight
waited for more than 2e7. A step of 500 rough spheres to 1e-4 needs more than 1e8.) It is at least the cost of a first
attempt with Newton steps.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass
from math import ceil
from typing import Any, ClassVar

import numpy as np

from lmgcpy.errors import named_arguments, whole
from lmgcpy.solve.newton.active_set import ActiveSet
from lmgcpy.solve.newton.proximal import PATIENCE, Attempt, proximal_newton
from lmgcpy.solve.problems.report import CONVERGED, NOT_FINITE, ROUND_OFF, SPENT, STAGNATED, Outcome
from lmgcpy.solve.sweeps.accelerated import MOMENTUM, new_state, sweep_with_momentum
from lmgcpy.solve.sweeps.solver import Solver
from lmgcpy.solve.sweeps.step import Step

TWICE = 2.0
LESS = 0.9
"""A residual is a gain if it is below this share of the residual at the last gain."""
GRACE = 1.5e8
"""Number of visits of interactions that a solve may always spend without a gain: six to fifteen seconds."""


class Progress:
    """The cost of a solve so far, and its cost at the last gain, in sweeps over ``interactions`` interactions."""

    def __init__(self, interactions: int, step: float, patience: int):
        self._step = step
        self._grace = max(GRACE / max(interactions, 1), patience * step)
        self._spent = self._gained = 0.0
        self._least = float("inf")

    def add(self, residual: float, *, sweeps: int = 0, newton: int = 0) -> None:
        """Add the cost of sweeps or Newton steps, and the residual to which they led."""
        self._spent += sweeps + newton * self._step
        if residual < LESS * self._least:
            self._least, self._gained = residual, self._spent

    @property
    def sweeps_left(self) -> int:
        """Sweeps that may go by from here without a gain."""
        return max(0, ceil(TWICE * self._gained + self._grace - self._spent))

    @property
    def newton_left(self) -> int:
        """Newton steps that may go by from here without a gain."""
        return ceil(self.sweeps_left / self._step)


ENDED = (CONVERGED, ROUND_OFF, NOT_FINITE)
"""Statuses of sweeps after which nothing is left to do."""
WORK = 320_000
"""Greatest cost of the Newton steps of a solve, in sweeps: in large samples in 3D one Newton step takes seconds."""
LONGEST = 8000
"""Most sweeps of a turn. (With 16 000 instead of 4000 three more of a hundred errors are reached on the steps of
``benchmarks/auto_choice.py``, and the errors that are not reached cost a sixth more.)"""
NEARLY = 2
"""Before the first Newton steps, sweeps go on if they are expected to end within the cost of ``NEARLY`` times seven Newton
steps; their residual is taken to fall as one over their number. (Values from one to three make no difference on the steps
of ``benchmarks/auto_choice.py``.)"""
TRIAL = 4
"""Newton steps that ``Auto`` tries first. If the statuses are right, the residual halves within these. If not, sweeps go on
as if there had been no Newton steps, :data:`LONGER` times as long."""
LONGER = 4
"""Factor of the turn after a trial. First turn and this one together, five first turns, cost as much as the first Newton
steps after the trial may cost, :data:`PATIENCE`."""
MOST_PATIENCE, LAST_PATIENCE = 8 * PATIENCE, 400
"""Largest patience with Newton steps, and the patience with the last ones, when the sweeps are spent."""
GAIN = 0.5
"""Newton steps that leave more than this share of the least residual so far have gained nothing."""
SIDES = 4
"""Most times that Newton steps go on because the impulses that they found have friction resist other slips."""
DISTURBANCE = 0.01
"""Standard deviation of the factors by which impulses are disturbed then. (Eight steps of biaxial tests, each from eleven
first turns of 100 to 2000 sweeps: all 88 solves succeed to 1e-8, 85 of them within 400 Newton steps.)"""


def sweeps_of_seven_steps(interactions: int, dimension: int) -> int:
    """Sweeps that cost as much as seven Newton steps: measured, 1000 of up to 5000 interactions in 2D and 3000 of 6000 in
    3D; the fill of a factorisation grows with the power 3/2 of the size in 2D and with its square in 3D."""
    return max(1000, int(14.0 * interactions**0.5)) if dimension == 2 else max(1000, interactions // 2)


def newton_steps(sweeps: int, interactions: int, dimension: int) -> int:
    """Number of Newton steps that cost as much as ``sweeps`` sweeps."""
    return 7 * sweeps // sweeps_of_seven_steps(interactions, dimension)


@dataclass(frozen=True)
class Alternating(Solver):
    """Sweeps with momentum and Newton steps by turns.

    ``tolerance``, ``wire_blocks``, ``slip``, ``force``: as of :class:`Solver <lmgcpy.Solver>`. ``max_iterations``: largest
    number of sweeps. ``max_factorisations``: largest number of Newton steps, each of which factorises a sparse matrix (a
    path counts as the Newton steps that cost as much). Newton steps never cost more than :data:`WORK` sweeps. A solve ends
    as "stagnated" if it has cost twice as much as up to its last gain, plus a grace.
    """

    tolerance: float = 1e-8
    max_iterations: int = 20_000
    max_factorisations: int = 2000

    NEEDS_CONIC: ClassVar[bool]
    """Whether laws without a conic form are refused; else they get sweeps alone."""
    TRIES: ClassVar[bool]
    """Whether the first Newton steps are a trial of :data:`TRIAL` steps."""

    @abstractmethod
    def first_turn(self, interactions: int, dimension: int) -> int:
        """Sweeps before the first Newton steps; before the next it is twice as many, after a trial four times."""

    def __post_init__(self) -> None:
        super().__post_init__()
        object.__setattr__(self, "max_factorisations", whole(self.max_factorisations, "max_factorisations"))

    def solve(self, step: Step) -> Outcome:
        """Sweeps and Newton steps by turns from the guess, until one of them solves the step or both are spent."""
        system, size = step.system, (len(step.guess), step.dimension)
        turn, state, guess = self.first_turn(*size), new_state(), None
        seven, sweeps = sweeps_of_seven_steps(*size), 0

        def sweep() -> Outcome:
            left = max(self.max_iterations - sweeps, 1)
            if guess is None:  # the first sweeps, or they go on
                return self._sweep(step, min(turn, left), overtime=NEARLY * seven, most=left, state=state)
            return self._sweep(step.starting_from(guess), min(turn, left), swept=True)

        swept = sweep()
        if swept.status in ENDED:
            return swept
        patience, trial = PATIENCE, self.TRIES
        _, slip, force = self.bounds
        most = min(self.max_factorisations, newton_steps(WORK, *size))
        progress = Progress(len(step.guess), seven / 7.0, PATIENCE)
        factorisations = 0
        best, least = step.guess, np.inf
        active: ActiveSet | None = None
        last = False
        while True:
            sweeps += swept.iterations
            progress.add(swept.residual, sweeps=swept.iterations)
            if swept.status in ENDED:
                return swept._replace(iterations=sweeps, factorisations=factorisations)
            if swept.residual < least:
                best, least = system.impulse.copy(), swept.residual
            given_up = not progress.sweeps_left
            if last or given_up or factorisations >= most:
                break
            last = sweeps >= self.max_iterations
            if active is None:
                if step.law_without_conic and not self.NEEDS_CONIC:
                    turn, last = self.max_iterations, True
                    swept = sweep()
                    continue
                problem, acting = step.conic()
                active, noise = ActiveSet(problem), np.random.default_rng(0)
            start, left = system.impulse[acting], min(most - factorisations, 2 * progress.newton_left)
            # Newton steps know of the residual only; it is to fall as the worst displacement must, and as the worst force
            # on a light body, which is off by much at any residual
            aim = self.tolerance
            if swept.slip > slip:
                aim = min(aim, 0.5 * swept.residual * slip / swept.slip)
            # (not with Newton: there spheres on a net of light beads made 3 % of their energy so)
            if not self.NEEDS_CONIC and len(step.light.body) and swept.force > force:
                aim = min(aim, 0.5 * swept.residual * force / swept.force)
            within = min(LAST_PATIENCE if last else patience, progress.newton_left)
            enough = max(GAIN * least, aim)
            on_trial, trial = trial and not last, False
            active.resist(step, acting, start)
            if on_trial:
                attempt = steps_that_gain(active, start, aim, left, within, enough)
            else:
                attempt = proximal_newton(active, start, aim, left, within)
            factorisations += attempt.factorisations
            for _ in range(SIDES):
                if not active.resist(step, acting, attempt.impulses):
                    break
                attempt = proximal_newton(active, attempt.impulses, aim, max(left // SIDES, TRIAL), within)
                factorisations += attempt.factorisations
            progress.add(attempt.residual, newton=attempt.factorisations)
            found = system.impulse.copy()
            found[acting] = attempt.impulses
            if attempt.residual < least:
                best, least = found, attempt.residual
            if attempt.residual <= enough:
                guess = found
            elif not on_trial:
                guess = found.copy()
                guess[acting] = attempt.last
                guess *= 1.0 + DISTURBANCE * noise.standard_normal((len(guess), 1))
            if on_trial:
                turn *= LONGER
            else:
                turn, patience = max(turn, min(2 * turn, LONGEST)), min(2 * patience, MOST_PATIENCE)
            swept = sweep()
        if swept.residual > least:
            swept = self.finish(step, best)  # a sweep from there may raise the residual again, by half
        if given_up and swept.status == SPENT:
            swept = swept._replace(status=STAGNATED)
        return swept._replace(iterations=sweeps, factorisations=factorisations)

    def _sweep(self, step: Step, turn: int, **others: Any) -> Outcome:
        """Sweep from the guess of a step; see :func:`sweep_with_momentum`."""
        return sweep_with_momentum(step, self.bounds, turn, MOMENTUM, **others)


def steps_that_gain(active: ActiveSet, start: np.ndarray, aim: float, most: int, patience: int, enough: float) -> Attempt:
    """:data:`TRIAL` Newton steps, and further steps if these have gained, that is, if they leave ``enough`` or less."""
    first = proximal_newton(active, start, aim, min(TRIAL, most), patience)
    if first.residual > enough or first.residual <= aim:
        return first
    rest = proximal_newton(active, first.impulses, aim, most - first.factorisations, patience)
    return rest._replace(factorisations=first.factorisations + rest.factorisations)


@named_arguments
@dataclass(frozen=True)
class Newton(Alternating):
    """Newton steps on active sets that a few sweeps find: for the last digits, stiff wires and rods.

    ``tolerance``: residual at which a problem is solved. ``max_iterations``: largest number of sweeps.
    ``max_factorisations``: largest number of Newton steps, each of which factorises a sparse matrix (a path counts as the
    Newton steps that cost as much); they never cost more than 320 000 sweeps. ``wire_blocks``, ``slip``, ``force``: as of
    ``GaussSeidel``. Needs laws with a conic form, as the laws of lmgcpy have; TypeError if a law of the scene has none.

    A tower of three disks of 10 N each:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> balls = [scene.add(lm.disk(radius=0.1, position=(0.0, 0.1 + 0.2 * i), mass=1.0)) for i in range(3)]
    >>> floor = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0), color="GRAIN"))
    >>> scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    >>> sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Newton(tolerance=1e-9)).run(steps=5)
    >>> sorted(sim.interactions.force[:, 0].round(6).tolist()), sim.report.solved
    ([10.0, 20.0, 30.0], True)
    """

    NEEDS_CONIC = True
    TRIES = False

    def first_turn(self, interactions: int, dimension: int) -> int:
        return 100


@named_arguments
@dataclass(frozen=True)
class Auto(Alternating):
    """The solver for everything: sweeps with momentum, and Newton steps if sweeps alone would take too long.

    Newton steps begin when the sweeps have cost as much as seven Newton steps. Laws without a conic form get none. The
    report has the numbers of sweeps and of Newton steps. ``tolerance``, ``max_iterations``, ``max_factorisations``,
    ``wire_blocks``, ``slip``, ``force``: as of :class:`Newton`.

    A tower of three disks of 10 N each:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> balls = [scene.add(lm.disk(radius=0.1, position=(0.0, 0.1 + 0.2 * i), mass=1.0)) for i in range(3)]
    >>> floor = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0), color="GRAIN"))
    >>> scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    >>> sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-9)).run(steps=5)
    >>> sorted(sim.interactions.force[:, 0].round(6).tolist()), sim.report.solved
    ([10.0, 20.0, 30.0], True)
    """

    tolerance: float = 1e-3
    max_iterations: int = 40_000

    NEEDS_CONIC = False
    TRIES = True

    def first_turn(self, interactions: int, dimension: int) -> int:
        return sweeps_of_seven_steps(interactions, dimension)
