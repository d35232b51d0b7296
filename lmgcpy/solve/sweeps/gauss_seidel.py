"""Non-linear Gauss-Seidel on the velocities of the bodies (Jean 1999), with whole wires as blocks."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.errors import named_arguments
from lmgcpy.solve.problems.report import CONVERGED, NOT_FINITE, ROUND_OFF, SPENT, STAGNATED, Outcome
from lmgcpy.solve.sweeps.light_bodies import MOVE
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


@kernel
def gauss_seidel(team: Team, max_iterations):
    """Sweep until the errors are within ``team.bounds``; returns (sweeps, status).

    The error is measured after sweeps 1, 2, 3 ... and then at intervals of an eighth of the sweeps done, so that measuring
    costs about an eighth. Before the solver reports success, it measures again on velocities computed anew from the
    impulses. Stagnation: the last half of the sweeps, at least 1000 of them, gained less than 1 %; or the residual grew
    beyond :data:`GROWN` times its least value; or for long nothing but the balance of light bodies was wrong.
    """
    nothing, residual, done, status = begin(team, False)
    if done:
        return 0, status
    best = np.inf
    milestone = residual
    milestone_sweep = 0
    others = 0
    sweeps = 0
    check = 1
    status = SPENT
    while sweeps < max_iterations:
        # proximal step of light bodies: the centre v_c follows v
        if sweeps > 0 and team.light > 0:
            share_chunks(MOVE, team)
        # one sweep: each law gives the impulse r at the free velocity u - W r
        if not sweep_groups(team):
            status = NOT_FINITE
            break
        sweeps += 1
        if sweeps < check and sweeps < max_iterations:
            continue
        # |e(r)| / |e(0)|, after an eighth more sweeps
        check = sweeps + 1 + sweeps // 8
        residual = measure(team, nothing)
        if residual <= team.bounds[0]:
            status = CONVERGED
            break
        if not np.isfinite(residual):
            status = NOT_FINITE
            break
        if at_round_off(team, nothing):
            status = ROUND_OFF
            break
        # stagnation: only light bodies are out of balance, and have been for long
        others, for_long = alone_out_of_balance(team, sweeps, others)
        if for_long:
            status = STAGNATED
            break
        # or impulses grow without bound
        best = min(best, residual)
        if residual > GROWN * best:
            status = STAGNATED
            break
        # or the last half of the sweeps gained less than 1 %
        if sweeps >= 2 * milestone_sweep and sweeps - milestone_sweep >= 1000:
            if best > 0.99 * milestone:
                status = STAGNATED
                break
            milestone = best
            milestone_sweep = sweeps
    # v = v_free + M^-1 H r anew, and its errors
    if status in (SPENT, STAGNATED):
        apply_impulses(team)
        rate(team, nothing)
    return sweeps, status


@named_arguments
@dataclass(frozen=True)
class GaussSeidel(Solver):
    """Gauss-Seidel, the standard method of the field, with every wire solved as one block.

    ``tolerance``, ``max_iterations``, ``wire_blocks``, ``slip``, ``force``: as of :class:`Solver <lmgcpy.Solver>`.

    A tower of three disks of 10 N each:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> balls = [scene.add(lm.disk(radius=0.1, position=(0.0, 0.1 + 0.2 * i), mass=1.0)) for i in range(3)]
    >>> floor = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0), color="GRAIN"))
    >>> scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    >>> sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-9)).run(steps=5)
    >>> sorted(sim.interactions.force[:, 0].round(6).tolist()), sim.report.solved
    ([10.0, 20.0, 30.0], True)
    """

    def solve(self, step: Step) -> Outcome:
        """Sweep from the guess; see :func:`gauss_seidel`."""
        return step.led(gauss_seidel, self.bounds, self.max_iterations)
