"""Non-linear Gauss-Seidel on the velocities of the bodies (Jean 1999), with whole wires as blocks.

A sweep visits the groups of interactions in canonical order and calls the kernel of each group once, by its address:
no call per interaction, and nothing to compile anew when another set of laws comes together.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic

from lmgcpy.errors import flag, named_arguments, number, whole
from lmgcpy.jit import kernel
from lmgcpy.solve.contact_block import momentum
from lmgcpy.solve.problem import Conic
from lmgcpy.solve.report import CONVERGED, NOT_FINITE, SPENT, STAGNATED
from lmgcpy.solve.solver import Outcome
from lmgcpy.solve.system import Groups, System


def _call(typing_context, address, start, stop, offset, s):
    """``double f(int64 start, int64 stop, int64 offset, System s)`` at an address."""

    def generate(context, builder, signature, arguments):
        kinds = [context.get_value_type(kind) for kind in signature.args[1:]]
        function = ir.FunctionType(context.get_value_type(signature.return_type), kinds)
        return builder.call(builder.inttoptr(arguments[0], function.as_pointer()), arguments[1:])

    return types.float64(address, start, stop, offset, s), generate


call: Any = intrinsic(_call)
"""``call(address, start, stop, offset, s)`` in compiled code."""


def group_signature(system_type):
    """numba signature of the kernels that :func:`call` calls."""
    return types.float64(types.int64, types.int64, types.int64, system_type)


def total_error(groups, s):
    """Euclidean norm of e over all interactions [m/s]; leaves the worst one in ``s.worst``."""
    s.worst[0] = -1.0
    s.worst[1] = -1.0
    total = 0.0
    for g in range(groups.start.shape[0]):
        total += call(groups.error[g], groups.start[g], groups.stop[g], groups.offset[g], s)
    return np.sqrt(total)


def sweep_groups(groups, s):
    """One sweep over all interactions; False where a law raised an exception."""
    total = 0.0
    for g in range(groups.start.shape[0]):
        total += call(groups.sweep[g], groups.start[g], groups.stop[g], groups.offset[g], s)
    return total == 0.0


def measure(groups, s, free_velocity, nothing, tolerance):
    """The residual; one within tolerance is told only after measuring it again on velocities made anew."""
    residual = total_error(groups, s) / nothing
    if residual <= tolerance:
        apply_impulses(free_velocity, s)
        residual = total_error(groups, s) / nothing
    return residual


def round_off(s):
    """What arithmetic leaves of relative velocities [m/s]: four units of the fastest body's, over all interactions."""
    fastest = 0.0
    for b in range(s.velocity.shape[0]):
        for k in range(s.velocity.shape[1]):
            fastest = max(fastest, abs(s.velocity[b, k]))
    return 4.0 * 2.0**-52 * fastest * np.sqrt(s.impulse.shape[0])


def apply_impulses(free_velocity, s):
    """``v = v_free + M^-1 H r``, from the impulses, so that nothing of the path by which they came is left in v."""
    momentum(s, s.velocity)
    for b in range(s.velocity.shape[0]):
        for k in range(s.velocity.shape[1]):
            s.velocity[b, k] = free_velocity[b, k] + s.inverse_mass[b, k] * s.velocity[b, k]


def begin(groups, s, free_velocity, guess, tolerance):
    """Start from the impulses ``guess``; returns (``|e(0)|``, residual, whether nothing is left to do, status).

    Where ``|e(0)|`` is no more than round-off, near rest, no error can be told relative to it, and ``r = 0`` is the answer.
    """
    s.impulse[:, :] = 0.0
    s.velocity[:, :] = free_velocity
    nothing = total_error(groups, s)
    if nothing <= round_off(s):
        s.worst[0] = 0.0
        return nothing, 0.0, True, CONVERGED
    if not np.isfinite(nothing):
        return nothing, nothing, True, NOT_FINITE
    s.impulse[:, :] = guess
    apply_impulses(free_velocity, s)
    residual = total_error(groups, s) / nothing
    return nothing, residual, residual <= tolerance, CONVERGED


@kernel
def gauss_seidel(groups: Groups, s: System, free_velocity, guess, tolerance, max_iterations):
    """Sweep until ``|e(r)| <= tolerance |e(0)|``; returns (sweeps, residual, status).

    The error is measured after sweeps 1, 2, 3 ... and then at intervals of an eighth of the sweeps done, so that
    measuring costs about an eighth; before success is told it is measured again on velocities made anew from the
    impulses. Stagnation: the last half of the sweeps, at least 1000 of them, gained less than 1 %.
    """
    nothing, residual, done, status = begin(groups, s, free_velocity, guess, tolerance)
    if done:
        return 0, residual, status
    best = residual
    milestone = residual
    milestone_sweep = 0
    sweeps = 0
    check = 1
    status = SPENT
    while sweeps < max_iterations:
        if not sweep_groups(groups, s):
            status = NOT_FINITE
            break
        sweeps += 1
        if sweeps < check and sweeps < max_iterations:
            continue
        check = sweeps + 1 + sweeps // 8
        residual = measure(groups, s, free_velocity, nothing, tolerance)
        if residual <= tolerance:
            status = CONVERGED
            break
        if not np.isfinite(residual):
            status = NOT_FINITE
            break
        best = min(best, residual)
        if sweeps >= 2 * milestone_sweep and sweeps - milestone_sweep >= 1000:
            if best > 0.99 * milestone:
                status = STAGNATED
                break
            milestone = best
            milestone_sweep = sweeps
    if status != CONVERGED and status != NOT_FINITE:
        apply_impulses(free_velocity, s)
        residual = total_error(groups, s) / nothing
    return sweeps, residual, status


@named_arguments
@dataclass(frozen=True)
class GaussSeidel:
    """Gauss-Seidel, the standard method of the field, with every wire solved as one block.

    ``tolerance``: stops at ``|e(r)| <= tolerance |e(0)|`` (see ``lmgcpy.residual``); ``max_iterations``: sweeps a step
    at the most; ``wire_blocks``: False visits the links of a wire one at a time, as other codes do.
    """

    tolerance: float = 1e-4
    max_iterations: int = 10_000
    wire_blocks: bool = True

    def __post_init__(self):
        object.__setattr__(self, "tolerance", number(self.tolerance, "tolerance", above=0.0, maximum=1.0))
        object.__setattr__(self, "max_iterations", whole(self.max_iterations, "max_iterations", minimum=1))
        flag(self.wire_blocks, "wire_blocks")

    def solve(
        self,
        groups: Groups,
        system: Any,
        free_velocity: np.ndarray,
        guess: np.ndarray,
        *,
        conic: Callable[[], Conic] | None = None,
        **operator: Any,
    ) -> Outcome:
        """Solve in place from the impulses ``guess``.

        ``conic`` is for other solvers; ``operator``: functions that stand in for those on bodies, for a problem with an
        assembled W.
        """
        solve = gauss_seidel.specialise(**operator)
        return Outcome(*solve(groups, system, free_velocity, guess, self.tolerance, self.max_iterations))
