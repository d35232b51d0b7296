"""The parts of solvers by sweeps: sweeping, measuring, and distinguishing an error from round-off.

A sweep visits the groups of interactions in canonical order and calls the kernel of each group once, by its address:
no call per interaction, and nothing to compile anew when another set of laws comes together.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.compiled.by_address import call
from lmgcpy.compiled.kernel import kernel
from lmgcpy.solve.kernels.loads import add_load, load_of, share_load  # of bodies, if the specialisation gives no others
from lmgcpy.solve.kernels.rounding import (  # of bodies, as the loads
    ROUNDING,
    add_noise,
    begin_noise,
    gather_noise,
    kinetic_energy,
)
from lmgcpy.solve.problems.report import CONVERGED, NOT_FINITE, ROUND_OFF, SPENT
from lmgcpy.solve.sweeps.cell_copies import TOTAL
from lmgcpy.solve.sweeps.iterates import iterates_work, part
from lmgcpy.solve.sweeps.light_bodies import CENTRE, FLY, LAY_ASIDE, SETTLE, TAKE_BACK, WEIGH
from lmgcpy.solve.sweeps.team import Team, share_chunks, share_phases

SWEEP, ERROR, MOMENTUM, NOISE, LOAD, SHARE, CLEAR, COMBINE, NOTHING, GUESS = map(np.int64, range(10))
WORST, QUIET, SUM, LOUD, UNLOADED, FORCE = map(np.int64, range(10, 16))
"""Kinds of work; the kinds of ``iterates.py``, ``light_bodies.py`` and ``cell_copies.py`` follow, in this order. They are
numbers of numpy: of plain numbers, each would compile a new function."""
NEAR = 32.0
"""Round-off is examined closely if the error is within this number of times an estimate that costs next to nothing."""
LOST = 2.0**-53
"""Largest error of rounding a number, in parts of the number."""
LONG = 40
"""A solve has taken long if its round-off was examined more often than this, that is after some 500 sweeps."""
GROWN = 1e6
"""Sweeps end if the residual is beyond this number of times its least value. In a step without a solution, in which
impulses of 1e15 N s lose the velocities to round-off, wire blocks that cross made it grow by a third a sweep."""
HALF_AS_MANY, MORE = 1.5, 100
"""Sweeps end if for half as many as before, and for a hundred more, nothing is wrong but the balance of light bodies."""
LARGEST_RESIDUAL, LARGEST_SLIP, LARGEST_ENERGY = 1e-2, 3e-3, 100.0
"""Round-off counts as solved up to these, or to the tolerances if they are larger: its floor grows with the impulses, and
impulses that explode would hide any error. Errors that are small along links may still be large across them, so that the
kinetic energy is bounded, too, in parts of the step's own. A jerk may make six times as much."""


@kernel
def work(kind, task, job):
    """Do one task; specialised for the kinds of bodies; see :mod:`lmgcpy.solve.sweeps.team`.

    Each kind reads only the arrays of the job that it needs.
    """
    if kind <= ERROR:
        # new impulses, and the sum of the numbers that the kernels return; or errors, and the sum of their squares
        groups = job.groups
        address = groups.sweep if kind == SWEEP else groups.error
        total = 0.0
        for p in range(groups.task[task], groups.task[task + 1]):
            total += call(address[p], groups.start[p], groups.stop[p], groups.offset[p], job.s)
        job.partial[task, 0] = total
    elif kind <= SHARE:
        add_momentum(kind, task, job)
    elif kind <= GUESS:
        bodies_work(kind, task, job)
    elif kind <= FORCE:
        look(kind, task, job)
    else:
        iterates_work(kind, task, job)


def add_momentum(kind, task, job):
    """Give the impulses, the sizes of their terms, or the greatest of them to the bodies."""
    groups = job.groups
    job.partial[task, 1] = 0.0
    job.partial[task, 2] = 0.0
    for p in range(groups.task[task], groups.task[task + 1]):
        if kind == MOMENTUM:
            call(groups.momentum[p], groups.start[p], groups.stop[p], groups.walls[p], job.s)
        elif kind == NOISE:
            add_noise(groups.start[p], groups.stop[p], groups.walls[p], job.s)
        elif kind == LOAD:
            add_load(groups.start[p], groups.stop[p], groups.walls[p], job.s, job.partial[task])
        else:
            share_load(groups.start[p], groups.stop[p], groups.walls[p], job.s)


def bodies_work(kind, task, job):
    """Work on a part of the arrays of bodies and impulses, by kind."""
    s = job.s
    first, last = part(task, job.free_velocity.shape[0], job.chunks)
    if kind == CLEAR:
        clear(first, last, s, job.free_velocity)
    elif kind == COMBINE:
        combine(first, last, s, job.free_velocity)
    else:
        for b in range(first, last):
            for k in range(s.velocity.shape[1]):
                s.velocity[b, k] = job.free_velocity[b, k]
        first, last = part(task, s.impulse.shape[0], job.chunks)
        for i in range(first, last):
            for k in range(s.impulse.shape[1]):
                s.impulse[i, k] = job.guess[i, k] if kind == GUESS else 0.0


def look(kind, task, job):
    """Read numbers from the errors of a part of the interactions, by kind."""
    s = job.s
    first, last = part(task, job.free_velocity.shape[0], job.chunks)
    low, high = part(task, s.squared_error.shape[0], job.chunks)
    found = job.partial[task]
    # sum of (W_nn r_n)^2 and the largest slip, (scale e)^2
    if kind == WORST:
        worst(low, high, s, found)
    # sizes of the terms of v_free, by which round-off is known, and its kinetic energy
    elif kind == QUIET:
        begin_noise(first, last, s, job.free_velocity, job.limits[4])
        found[0] = kinetic_energy(first, last, s, job.free_velocity)
    # loads of the bodies, before they are gathered
    elif kind == UNLOADED:
        for b in range(first, last):
            s.noise[b, 2] = 0.0
            s.noise[b, 3] = 0.0
    # largest error of a force, |e| / W_nn over the load
    elif kind == FORCE:
        found[0] = force_error(low, high, s, job.bounds[3])
    # sum of the squared terms of e(0), and the energy of the errors, e(0)^2 / (2 W_nn)
    elif kind == SUM:
        gather_noise(low, high, s)
        total = undone = 0.0
        for i in range(low, high):
            total += s.floor[i] * s.floor[i]
            if s.delassus[i, 0] > 0.0:
                undone += 0.5 * s.squared_error[i] / s.delassus[i, 0]
        found[0] = total
        found[1] = undone
    # number of interactions with more than round-off, and kinetic energy
    else:
        gather_noise(low, high, s)
        found[0] = loud(low, high, s, job.limits, job.bounds)
        found[1] = kinetic_energy(first, last, s, s.velocity)


def worst(first, last, s, found):
    """The sum of ``(W_nn r_n)^2`` of some interactions [m^2/s^2], the largest ``(scale e)^2``, its row and its error."""
    largest = -1.0
    row = first
    total = 0.0
    for k in range(first, last):
        i = np.uintp(k)
        share = s.scale[i] * s.scale[i] * s.squared_error[i]
        total += (s.delassus[i, 0] * s.impulse[i, 0]) ** 2
        if share > largest:
            largest = share
            row = k
    found[0] = total
    found[1] = largest
    found[2] = row
    found[3] = np.sqrt(s.squared_error[row]) if row < last else 0.0


def force_error(first, last, s, typical):
    """The largest ``|e| / W_nn`` of some interactions over the load of their bodies; 1 if these bear nothing."""
    largest = 0.0
    for k in range(first, last):
        i = np.uintp(k)
        error = np.sqrt(s.squared_error[i])
        if error > 0.0 and error > largest * s.delassus[i, 0] * load_of(i, s, typical):
            load = s.delassus[i, 0] * load_of(i, s, typical)
            largest = error / load if load > 0.0 else max(largest, 1.0)
    return largest


def loud(first, last, s, limits, bounds):
    """Number of interactions that are off by more than their round-off and by more than ``limits`` allow."""
    count = 0.0
    for i in range(first, last):
        allowed = limits[0]
        if s.scale[i] * allowed > limits[1]:
            allowed = limits[1] / s.scale[i]
        allowed = min(allowed, bounds[2] * s.delassus[i, 0] * load_of(i, s, bounds[3]))
        if not s.squared_error[i] <= max(allowed, ROUNDING * s.floor[i]) ** 2:
            count += 1.0
    return count


def clear(first, last, s, free_velocity):
    """Make room for the momentum of some bodies."""
    for b in range(first, last):
        for k in range(s.velocity.shape[1]):
            s.velocity[b, k] = 0.0


def combine(first, last, s, free_velocity):
    """``v = v_free + M^-1 H r`` of some bodies, from their momentum."""
    for b in range(first, last):
        for k in range(s.velocity.shape[1]):
            s.velocity[b, k] = free_velocity[b, k] + s.inverse_mass[b, k] * s.velocity[b, k]


# ------------------------------------------------------------------------------------------- what leads the work


def total_error(team):
    """Euclidean norm of e over all interactions [m/s]."""
    share_phases(ERROR, team)
    total = 0.0
    for task in range(team.phase[-1]):
        total += team.partial[task, 0]
    return np.sqrt(total)


def sum_of_parts(kind, team):
    """Have a kind of work done for whole arrays; the sums of the two numbers that the parts leave."""
    share_chunks(kind, team)
    first = second = 0.0
    for task in range(team.chunks):
        first += team.partial[task, 0]
        second += team.partial[task, 1]
    return first, second


def greatest(kind, team):
    """Have a kind of work done for whole arrays; the greatest number that the parts leave."""
    share_chunks(kind, team)
    found = 0.0
    for task in range(team.chunks):
        found = max(found, team.partial[task, 0])
    return found


def largest_force_error(team):
    """The largest error of a force, and imbalance of a light body, over the load of the bodies; both are left in
    ``team.measured``."""
    share_chunks(UNLOADED, team)
    share_phases(LOAD, team)
    logarithms = 0.0
    count = 0.0
    for task in range(team.phase[-1]):
        logarithms += team.partial[task, 1]
        count += team.partial[task, 2]
    team.bounds[3] = np.exp(logarithms / count) if count > 0.0 else 0.0
    share_phases(SHARE, team)
    team.measured[4] = greatest(FORCE, team)
    if team.light > 0:
        team.measured[5] = greatest(WEIGH, team)
        team.limits[7] = 0.0
        for task in range(team.chunks):
            team.limits[7] = max(team.limits[7], team.partial[task, 1])
    return max(team.measured[4], team.measured[5])


def rate(team, nothing):
    """The largest of the residual, the slip and the error of a force, each over its bound, times the tolerance: all three
    are within their bounds if this is within the tolerance. They are left in ``team.measured``.

    Impulses may be so large that errors of a hundredth of e(0) are lost in ``u - w r``: then the residual is no less than
    this loss.
    """
    tolerance, slip, force = team.bounds[0], team.bounds[1], team.bounds[2]
    residual = total_error(team) / nothing
    share_chunks(WORST, team)
    largest = -1.0
    team.limits[6] = 0.0
    for task in range(team.chunks):
        team.limits[6] += team.partial[task, 0]
        if team.partial[task, 1] > largest:
            largest = team.partial[task, 1]
            team.measured[2] = team.partial[task, 2]
            team.measured[3] = team.partial[task, 3]
    lost = LOST * np.sqrt(team.limits[6])
    if lost > LARGEST_RESIDUAL * nothing:
        residual = max(residual, lost / nothing)
    team.measured[0] = residual
    team.measured[1] = np.sqrt(max(largest, 0.0))
    excess = max(team.measured[1] / slip, largest_force_error(team) / force)
    return tolerance * excess if excess > 1.0 and tolerance * excess > residual else residual


def sweep_groups(team):
    """Sweep once over all interactions; False if a law raised an exception."""
    share_phases(SWEEP, team)
    total = 0.0
    for task in range(team.phase[-1]):
        total += team.partial[task, 0]
    return total == 0.0


def measure(team, nothing):
    """The error by :func:`rate`; it is within the tolerance only if it is so on velocities computed anew.

    Light bodies get the velocities that their impulses give them, by which momentum is kept, if the bounds allow it.
    """
    residual = rate(team, nothing)
    if residual > team.bounds[0]:
        return residual
    apply_impulses(team)
    residual = rate(team, nothing)
    if team.light == 0 or residual > team.bounds[0]:
        return residual
    share_chunks(LAY_ASIDE, team)
    share_chunks(SETTLE, team)
    settled = rate(team, nothing)
    if settled <= team.bounds[0]:
        return settled
    share_chunks(TAKE_BACK, team)
    apply_impulses(team)
    return rate(team, nothing)


def only_out_of_balance(bounds, measured):
    """Whether nothing but the balance of light bodies was out of its bound, as last measured."""
    return measured[0] <= bounds[0] and measured[1] <= bounds[1] and measured[4] <= bounds[2] < measured[5]


def alone_out_of_balance(team, sweeps, others):
    """Sweep after which something was wrong beside the balance of light bodies that bear little, ``others`` so far, and
    whether since then there were many sweeps."""
    if team.limits[7] > team.bounds[2] or not only_out_of_balance(team.bounds, team.measured):
        return sweeps, False
    return others, sweeps >= HALF_AS_MANY * others + MORE


def at_round_off(team, nothing):
    """Whether the error that :func:`measure` found above the tolerance is round-off.

    It is round-off if two conditions hold. Each interaction is off by no more than its own round-off, or by so little that
    the tolerances would be kept if all were off by that. And the error is small for any impulses: the residual, unless e(0)
    itself is near round-off; the slip; and the kinetic energy, in parts of the energy of the velocities without impulses
    and of the errors e(0). Both are checked on velocities computed anew, and only if a rough estimate allows it, by the
    round-off of the terms of all velocities times NEAR.
    """
    team.limits[5] += 1.0
    tolerance, slip = team.bounds[0], team.bounds[1]
    # rough estimate: round-off of e(0), and NEAR times the round-off of W_nn r_n
    error = team.measured[3] if team.measured[0] <= tolerance else team.measured[0] * nothing
    without = ROUNDING * np.sqrt(team.limits[2])
    if not error <= without + NEAR * ROUNDING * np.sqrt(team.limits[6]):
        return False
    apply_impulses(team)
    if team.light > 0:  # their velocities follow from the impulses
        share_chunks(LAY_ASIDE, team)
        share_chunks(SETTLE, team)
    rate(team, nothing)
    # noise_i of each interaction, with the rounding of gaps if the solve takes long
    team.limits[4] = 1.0 if team.limits[5] > LONG else 0.0
    share_chunks(QUIET, team)
    share_phases(NOISE, team)
    # error of an interaction if all m share the tolerance evenly, tolerance |e(0)| / sqrt(m)
    team.limits[0] = tolerance * nothing / np.sqrt(team.rows)
    team.limits[1] = slip
    count, energy = sum_of_parts(LOUD, team)
    # small for any impulses: residual, slip and kinetic energy
    error = team.measured[0] * nothing
    small = error <= max(tolerance, LARGEST_RESIDUAL) * nothing or error <= NEAR * without
    found = count == 0.0 and small and team.measured[1] <= max(slip, LARGEST_SLIP) and energy <= team.limits[3]
    if team.light > 0 and not found:
        share_chunks(TAKE_BACK, team)
        apply_impulses(team)
        rate(team, nothing)
    return found


def apply_impulses(team):
    """``v = v_free + M^-1 H r``, from the impulses alone, so that v keeps no round-off of the sweeps."""
    share_chunks(CLEAR, team)
    share_phases(MOMENTUM, team, TOTAL)
    share_chunks(COMBINE, team)


def begin(team, swept):
    """Start from the guess; returns (``|e(0)|``, residual, whether nothing is left to do, status).

    If ``|e(0)|`` is no more than round-off, near rest, no error can be measured relative to it, and ``r = 0`` is the
    answer. Otherwise only a guess that was ``swept`` before may pass without a sweep: an interaction that begins to act
    would be left without an impulse as long as others are loaded more. With such a guess the centres of light bodies are
    those of the last sweeps, or those at which it leaves no imbalance, whichever errs less.
    """
    if team.light > 0:  # e(0) is of a flight with their own mass
        share_chunks(FLY, team)
    # |e(0)|: the errors of r = 0
    share_chunks(NOTHING, team)
    nothing = total_error(team)
    # round-off of e(0), and the energies with which the energy of errors is compared
    team.limits[4], team.limits[5] = 1.0, 0.0
    free, _ = sum_of_parts(QUIET, team)
    team.limits[2], undone = sum_of_parts(SUM, team)
    team.limits[3] = LARGEST_ENERGY * (free + undone)
    team.measured[:] = 0.0
    if nothing <= ROUNDING * np.sqrt(team.limits[2]):
        if team.light > 0:  # they fly as well, and nothing is out of balance
            share_chunks(SETTLE, team)
        return nothing, 0.0, True, CONVERGED
    if not np.isfinite(nothing):
        team.measured[0] = nothing
        return nothing, nothing, True, NOT_FINITE
    if team.light > 0:
        share_chunks(CENTRE, team)
    # the guess and its velocities, v = v_free + M^-1 H r
    share_chunks(GUESS, team)
    apply_impulses(team)
    residual = rate(team, nothing)
    if swept and team.light > 0 and residual > team.bounds[0]:
        # impulses of Newton steps belong to the bodies' own masses
        share_chunks(LAY_ASIDE, team)
        share_chunks(SETTLE, team)
        settled = rate(team, nothing)
        if settled < residual:
            residual = settled
        else:
            share_chunks(TAKE_BACK, team)
            apply_impulses(team)
            residual = rate(team, nothing)
    return nothing, residual, swept and residual <= team.bounds[0], CONVERGED


@kernel
def judge(team: Team):
    """Take the guess for the answer and measure it on velocities made from it; returns (0 sweeps, status)."""
    nothing, residual, done, status = begin(team, True)
    if done:
        return 0, status
    if not np.isfinite(residual):
        return 0, NOT_FINITE
    return 0, ROUND_OFF if at_round_off(team, nothing) else SPENT
