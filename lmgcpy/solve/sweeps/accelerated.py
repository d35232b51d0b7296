"""Gauss-Seidel with momentum: the same sweeps, each started from a point extrapolated from the last two.

Late in a solve plain Gauss-Seidel hardly turns: from one sweep to the next the impulses of a jammed sample move by the
same vector, for hundreds of sweeps, until a contact opens or slips and the direction changes a little. (One step of a
biaxial test, rigid rods: 1000 sweeps moved the impulses 1000 times as far as one sweep, with seven changes of status.) With
``G`` one sweep, the iteration here is Nesterov's,

    x_{k+1} = G(y_k),    y_{k+1} = x_{k+1} + beta_j (x_{k+1} - x_k),    beta_j = min(j / (j + 3), 1 - damping),

``j`` counting the sweeps since the last restart, without those that gain much by themselves. As
``v = v_free + M^-1 H r`` is linear, the velocities of the bodies follow by the same combination; nothing is assembled
and no law is asked for more than its ``react``. An extrapolated impulse may leave its cone; the sweep brings it back, and
only results of sweeps are measured and returned.

Without friction a step is a convex problem and momentum may grow freely. Sliding with friction is not associated, its
operator is not symmetric, and momentum makes some of its modes grow: beyond ``1 - beta`` of about the square of the
asymmetry they swing without end. Hence restarts, and a damping that the swings control. The size of a step is the velocity
``|W_d (G(y) - y)|``, with W_d the diagonal of W. In the samples measured the residual is mostly 0.5 to 0.7 times as large.
When it has grown to twice the least since the last restart, the momentum is dropped (``j = 0``) and the damping doubled;
with every other sweep the damping decays by 0.3 %. As an estimate of the residual, the size of the step also decides when
it is measured, beside the intervals of plain Gauss-Seidel.

Measured, sweeps a step, mean over a 2D biaxial test to 5 % (1700 grains, wire of 300 beads, friction 0.4, warm start),
Gauss-Seidel at a budget of 20 000 against this: residual 1e-2, sand 2 100 against 350, rigid wire 5 600 to 6 100 against
750; residual 1e-3, sand 18 500 against 6 000, wire 19 700 against 10 100, of 241 steps 170 and 235 not converged against
26 and 60. Single steps of compaction without friction: 6 to 8 times fewer at 1e-2, 20 to 30 times at 1e-4. A sweep costs
20 to 35 % more. Rigid rods that lock (impulses grow without bound, 1e7 N against 6e4 N of load) converge in neither.

Sources: Nesterov (1983) Soviet Math. Dokl. 27; adaptive restart: O'Donoghue, Candes (2015) Found. Comput. Math. 15,
Su, Boyd, Candes (2016) JMLR 17; the method with projected sweeps as gradient in contact dynamics: Mazhar, Heyn, Negrut,
Tasora (2015) ACM Trans. Graph. 34(3). Control of the damping: measured here.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.compiled.mode import mode
from lmgcpy.errors import named_arguments, number
from lmgcpy.solve.problems.report import CONVERGED, NOT_FINITE, ROUND_OFF, SPENT, STAGNATED, Outcome
from lmgcpy.solve.sweeps.iterates import EXTRAPOLATE, KEEP, RESUME, START, STEP, TAKE_BEST
from lmgcpy.solve.sweeps.light_bodies import BEST_CENTRE, KEEP_CENTRE, MOVE
from lmgcpy.solve.sweeps.solver import Solver
from lmgcpy.solve.sweeps.step import Step
from lmgcpy.solve.sweeps.sweep import (
    GROWN,
    alone_out_of_balance,
    apply_impulses,
    at_round_off,
    begin,
    measure,
    rate,
    sweep_groups,
)
from lmgcpy.solve.sweeps.team import Team, share_chunks

GROWTH = 2.0
"""A step larger than this number of times the least one since the last restart drops the momentum."""
RECOVERY = 0.997
"""Decay of the damping a sweep: it halves in 230."""
FAST = 0.8
"""The momentum does not grow while a step is less than this part of the one before: the sweeps converge by themselves."""
MOMENTUM = 0.97
"""Bound of the momentum by default."""
FAR = 3.0
"""No momentum if a light body is out of balance by more than this number of times its bound."""
MOST_DAMPING = 0.5
"""Largest damping: the momentum that it leaves never did harm."""


def step_size(team):
    """``|w (x - y)|`` [m/s] of the last sweep."""
    share_chunks(STEP, team)
    total = 0.0
    for task in range(team.chunks):
        total += team.partial[task, 0]
    return np.sqrt(total)


STATE = np.dtype(
    [
        ("nothing", np.float64),  # |e(0)|, 0 before the first call
        ("best", np.float64),  # least residual
        ("milestone", np.float64),  # least residual when it last gained 1 % ...
        ("milestone_sweep", np.int64),  # ... and after which sweep that was
        ("others", np.int64),  # sweep after which something else than the balance of light bodies was wrong
        ("damping", np.float64),  # the momentum stays below 1 - damping
        ("run", np.int64),  # slow sweeps since the last restart, j
        ("previous", np.float64),  # size of the last step
        ("least", np.float64),  # least size of a step since the last restart
        ("ratio", np.float64),  # residual over size of the step, as last measured
        ("sweeps", np.int64),
        ("measured", np.int64),  # sweep after which the residual was measured
        ("check", np.int64),  # sweep after which it is measured next at the latest
    ]
)
"""State of the sweeps of a solve, from which it goes on after a pause."""


def new_state() -> np.ndarray:
    """The state of a solve that has not begun, (1,) of :data:`STATE`."""
    state = np.zeros(1, STATE)
    return state.view(np.recarray) if mode.plain else state  # compiled code reads fields as attributes of either


@kernel
def accelerated_gauss_seidel(team: Team, turn, overtime, most, momentum_bound, swept, state):
    """Sweep with momentum until the errors are within ``team.bounds``; returns (sweeps, status).

    The error is measured after sweeps 1, 2, 3 ..., then at intervals of an eighth of the sweeps done, and if the size of
    the step promises success. Without success the best impulses measured are returned. Stagnation: the last three quarters
    of the sweeps, and 4000, gained less than 1 %; or the residual has grown beyond :data:`GROWN` times its least value; or
    for long nothing but the balance of light bodies was wrong, and then the last impulses are returned.

    There are ``turn`` sweeps. If they are expected to end within ``overtime`` more, for a residual that falls as one over
    the number of sweeps, there is another turn, up to ``most`` sweeps in all. A further call with the same ``state`` goes
    on as if there had been no pause.
    """
    tolerance = team.bounds[0]
    now = state[0]
    if now.nothing > 0.0:
        share_chunks(RESUME, team)
        apply_impulses(team)
        if team.light > 0:  # their centres have moved since the last sweep
            now.run = 0
            now.previous = np.inf
    else:
        nothing, residual, done, status = begin(team, swept)
        if done:
            return 0, status
        share_chunks(START, team)
        now.nothing = nothing
        now.best = now.previous = now.least = np.inf
        now.milestone = residual
        now.damping = 1.0 - momentum_bound
        now.check = 1
    begun = now.sweeps
    last = begun + most
    limit = min(begun + turn, last)
    status = SPENT
    while now.sweeps < limit:
        if not sweep_groups(team):
            status = NOT_FINITE
            break
        now.sweeps += 1
        step = step_size(team)
        # measure: at the latest after an eighth more sweeps, or if the step is as small as a solved one's would be
        promising = now.ratio * step <= tolerance and now.sweeps >= now.measured + 8
        if now.sweeps >= now.check or promising or now.sweeps == limit:
            now.measured = now.sweeps
            now.check = now.sweeps + 1 + now.sweeps // 8
            residual = measure(team, now.nothing)
            if residual <= tolerance:
                status = CONVERGED
                break
            if not np.isfinite(residual):
                status = NOT_FINITE
                break
            if at_round_off(team, now.nothing):
                status = ROUND_OFF
                break
            now.others, for_long = alone_out_of_balance(team, now.sweeps, now.others)
            if for_long:
                share_chunks(KEEP, team)  # best are those with nothing else wrong
                share_chunks(KEEP_CENTRE, team)
                status = STAGNATED
                break
            now.ratio = residual / step
            if residual < now.best:
                now.best = residual
                share_chunks(KEEP, team)
                if team.light > 0:
                    share_chunks(KEEP_CENTRE, team)
            if now.sweeps == limit and now.sweeps * (now.best - tolerance) <= overtime * tolerance:
                limit = min(limit + turn, last)
            if residual > GROWN * now.best:
                status = STAGNATED
                break
            if now.best < 0.99 * now.milestone:
                now.milestone = now.best
                now.milestone_sweep = now.sweeps
            elif now.sweeps >= 4 * now.milestone_sweep + 4000:
                status = STAGNATED
                break
        # weigh the last results: beta_j grows with the slow sweeps
        if step > FAST * now.previous:
            now.run += 1
        now.previous = step
        beta = min(now.run / (now.run + 3.0), 1.0 - now.damping)
        # restart: the step has grown, so momentum made a mode swing
        if step > GROWTH * now.least:
            now.damping = min(MOST_DAMPING, 2.0 * max(now.damping, 1.0 - beta))
            beta = 0.0
            now.run = 0
            now.least = step
        else:
            now.damping = max(1.0 - momentum_bound, RECOVERY * now.damping)
            now.least = min(now.least, step)
        # none while a light body is far out of balance, as last measured; then as large as before
        team.beta[0] = 0.0 if team.light > 0 and team.measured[5] > FAR * team.bounds[2] else beta
        if team.light > 0:
            share_chunks(MOVE, team)
        share_chunks(EXTRAPOLATE, team)
    if status in (SPENT, STAGNATED):
        share_chunks(TAKE_BEST, team)
        if team.light > 0:
            share_chunks(BEST_CENTRE, team)
        apply_impulses(team)
        rate(team, now.nothing)
    return now.sweeps - begun, status


def sweep_with_momentum(
    step: Step,
    bounds: tuple[float, float, float],
    turn: int,
    momentum: float,
    *,
    overtime: float = -1.0,
    most: int | None = None,
    swept: bool = False,
    state: np.ndarray | None = None,
) -> Outcome:
    """Sweep from the guess of a step, ``turn`` times at the most, with a momentum of at most ``momentum``.

    ``overtime``, ``most``: see :func:`accelerated_gauss_seidel`; ``swept``: whether the guess comes from sweeps on this
    step and may pass as it is; ``state``: of :func:`new_state`, to go on later from where the sweeps on the same ``step``
    ended.
    """
    limits = turn, float(overtime), turn if most is None else most, momentum
    arguments = *limits, swept, new_state() if state is None else state
    return step.led(accelerated_gauss_seidel, bounds, *arguments, iterates=True)


@named_arguments
@dataclass(frozen=True)
class AcceleratedGaussSeidel(Solver):
    """Gauss-Seidel with momentum, for steps that take more than a few dozen sweeps; any law, wires as blocks.

    ``tolerance``, ``max_iterations``, ``wire_blocks``, ``slip``, ``force``: as of :class:`Solver <lmgcpy.Solver>`;
    ``momentum``: bound of the momentum, in [0, 1); with 0 the sweeps are plain Gauss-Seidel.

    A tower of three disks of 10 N each:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> balls = [scene.add(lm.disk(radius=0.1, position=(0.0, 0.1 + 0.2 * i), mass=1.0)) for i in range(3)]
    >>> floor = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0), color="GRAIN"))
    >>> scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    >>> sim = lm.Simulation(scene, time_step=1e-3, solver=lm.AcceleratedGaussSeidel(tolerance=1e-9)).run(steps=5)
    >>> sorted(sim.interactions.force[:, 0].round(6).tolist()), sim.report.solved
    ([10.0, 20.0, 30.0], True)
    """

    momentum: float = MOMENTUM

    def __post_init__(self) -> None:
        super().__post_init__()
        if not number(self.momentum, "momentum", minimum=0.0) < 1.0:
            raise ValueError(f"momentum must be in [0, 1), got {self.momentum:g}.")

    def solve(self, step: Step) -> Outcome:
        """Sweep from the guess; see :func:`accelerated_gauss_seidel`."""
        return sweep_with_momentum(step, self.bounds, self.max_iterations, float(self.momentum))
