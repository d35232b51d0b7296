"""Light bodies between heavy ones: heavy in the sweep, light in the answer.

In one visit, a bead between two grains passes no more momentum to them than it has itself. If it weighs a hundredth of a
grain, a sweep moves the load of the grains by a hundredth, and thousands of sweeps pass before the bead bears it. So a
light body of mass m is swept as if it weighed M, and a force makes up for the difference that vanishes in the end.

With the laws as a convex function (without friction, or with the shift ``mu |u_t|`` held) the step is

    v* = argmin F(v),    F(v) = 1/2 (v - v_f).m (v - v_f) + S(H^T v)              v_f: velocities without impulses,

and one solve with M for m is a proximal point of F in the metric ``D = M - m`` of the light bodies, around a centre v_c:

    v_{j+1} = argmin F(v) + 1/2 (v - v_c).D (v - v_c),    v_c = v_j.

The two quadratic forms add up to the form of M around ``v_f' = (m v_f + (M - m) v_c)/M``, so that a solve *is* the solve of
an ordinary step with these masses and free velocities, and sweeps need to know nothing else. At a fixed point ``v = v_c``,
the force ``D (v_c - v)/h`` is zero, and v solves the step with the mass m, also with friction, whose laws hold by
themselves. Without friction it contracts towards the solution whatever M is (Rockafellar 1976, SIAM J. Control Optim. 14):

    |v_{j+1} - v*|^2_{2 m + D} + |v_{j+1} - v_j|^2_D <= |v_j - v*|^2_D.

If S is the mass that the body feels through its active laws, the error of a mode falls by ``D/(D + S)`` a move: a body that
is held arrives in one move, one that takes a heavy one along in a few, and one that flies (S = m) in M/m. So a body whose
moves have the same direction goes further each time. Each move takes a single sweep: an inexact proximal point, for which
there is no proof, nor is there one with friction. Momentum of the impulses makes it diverge as long as centres are on their
way, and takes a third of the sweeps away when they have arrived (``accelerated.py``).

A body that slides or flies among others that jitter does not get there: its moves have no common direction. If such
a body bears little, it needs no more than its own mass. So sweeps end if for long nothing but the balance of bodies that
bear little is wrong (``sweep.py``), and go on with the own masses of those out of balance (``lmgcpy.dynamics.stepper``).
Bodies that bear more keep M: the error of a force on a grain is measured with it.

What is left when sweeps end is the imbalance ``D (v_c - v)``, an impulse on the body that no law and no load gives. It is
bounded as the error of a force is (``lmgcpy.solve.kernels.loads``). Bodies get ``v_f + H r / m`` in the end if all bounds
allow it; else the work of the imbalance is entered in the balance of energy.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lmgcpy.solve.kernels.loads import LITTLE, NEARBY, is_little
from lmgcpy.solve.sweeps.iterates import part

FLY, CENTRE, MOVE, SETTLE, WEIGH, KEEP_CENTRE, BEST_CENTRE, LAY_ASIDE, TAKE_BACK = map(np.int64, range(22, 31))
"""Kinds of work, numbered after the kinds of ``iterates``."""
ALIGNED, GROWTH = 0.99, 2.5
"""If the cosine between a move and the last one is above the first number, the move is longer by the second, up to M/m, as
long as impulses have no momentum.
(Beads of 1/400 of a grain in a sample: 0.9 and 1.2 take as many sweeps, 0.99 and 6 do not come to an end.)"""


class LightBodies(NamedTuple):
    """The light bodies of a step, L of them with k components of velocity; none in most scenes."""

    body: np.ndarray
    """Rows of the bodies, (L,) int64."""
    rate: np.ndarray
    """Time step over the size of the body [s/m], (L,)."""
    share: np.ndarray
    """m / M, (L,)."""
    mass: np.ndarray
    """m by component [kg, kg m^2], (L, k), zero if driven."""
    free: np.ndarray
    """v_f: velocities without impulses, (L, k)."""
    start: np.ndarray
    """Velocities at the start of the step, (L, k), and the first centre. (v_f of a light body under a load is thousands of
    metres a second: from there some scenes took 20 000 sweeps instead of 10.)"""
    centre: np.ndarray
    """v_c, (L, k)."""
    best: np.ndarray
    """Centre at the best impulses, (L, k)."""
    aside: np.ndarray
    """Centre that is laid aside while another one is tried, (L, k)."""
    way: np.ndarray
    """``v - v_c`` of the last move, (L, k)."""
    stride: np.ndarray
    """How far the centre of a body moves, in parts of ``v - v_c``, (L,)."""
    out: np.ndarray
    """1 if a body that bears little is out of balance by more than its bound, as last measured, else 0, (L,)."""


def no_light_bodies(components: int) -> LightBodies:
    """The light bodies of a scene without any."""
    rows, none = np.zeros((0, components)), np.zeros(0)
    numbers = dict.fromkeys(("rate", "share", "stride", "out"), none)
    vectors = dict.fromkeys(("mass", "free", "start", "centre", "best", "aside", "way"), rows)
    return LightBodies(body=np.zeros(0, np.int64), **numbers, **vectors)


def light_work(kind, task, job):
    """Work on one part of the light bodies, by kind."""
    first, last = part(task, job.light.body.shape[0], job.chunks)
    # v_f' of a flight with the body's own mass: v_c = v_f
    if kind == FLY:
        shift(first, last, job.light.free, job)
    # v_f' around the centre v_c
    elif kind == CENTRE:
        shift(first, last, job.light.centre, job)
    # v_c <- v_c + stride (v - v_c)
    elif kind == MOVE:
        move(first, last, job)
    # the centre at which the imbalance D (v_c - v) is zero
    elif kind == SETTLE:
        settle(first, last, job)
    # centres of the best impulses, and centres laid aside
    elif kind == KEEP_CENTRE:
        take_over(first, last, job.light.centre, job.light.best)
    elif kind == BEST_CENTRE:
        take_over(first, last, job.light.best, job.light.centre)
        shift(first, last, job.light.centre, job)
    elif kind == LAY_ASIDE:
        take_over(first, last, job.light.centre, job.light.aside)
    elif kind == TAKE_BACK:
        take_over(first, last, job.light.aside, job.light.centre)
        shift(first, last, job.light.centre, job)
    # |D (v_c - v)| over the load of the body
    else:
        job.partial[task, 0], job.partial[task, 1] = imbalance(first, last, job)


def shift(first, last, centre, job):
    """``v_f' = (m v_f + (M - m) v_c)/M`` of some light bodies, into the velocities without impulses."""
    light = job.light
    for l in range(first, last):
        b = light.body[l]
        for k in range(light.free.shape[1]):
            v = light.free[l, k]
            if light.mass[l, k] > 0.0:
                v = light.share[l] * v + (1.0 - light.share[l]) * centre[l, k]
            job.free_velocity[b, k] = v


def take_over(first, last, x, y):
    """``y <- x`` for some light bodies."""
    for l in range(first, last):
        for k in range(x.shape[1]):
            y[l, k] = x[l, k]


def move(first, last, job):
    """``v_c <- v_c + stride (v - v_c)`` of some light bodies, with the changes of ``v_f'`` and v that follow.

    The velocities before, which sweeps with momentum keep, change by the same: momentum is of impulses only.
    """
    light, velocity, last_velocity = job.light, job.s.velocity, job.last_velocity
    width = velocity.shape[1]
    for l in range(first, last):
        b = light.body[l]
        # |d|^2 and the product with the last move, in the metric of m
        both = 0.0
        here = 0.0
        before = 0.0
        for k in range(light.free.shape[1]):
            m = light.mass[l, k]
            d = velocity[b, k] - light.centre[l, k]
            both += m * d * light.way[l, k]
            here += m * d * d
            before += m * light.way[l, k] ** 2
            light.way[l, k] = d
        if job.beta[0] == 0.0 and both > ALIGNED * np.sqrt(here * before):
            light.stride[l] = min(GROWTH * light.stride[l], 1.0 / light.share[l])
        else:
            light.stride[l] = 1.0
        for k in range(light.free.shape[1]):
            if light.mass[l, k] > 0.0:
                change = light.stride[l] * light.way[l, k]
                light.centre[l, k] += change
                change *= 1.0 - light.share[l]
                job.free_velocity[b, k] += change
                velocity[b, k] += change
                if last_velocity.shape[0] > 0:  # plain sweeps have none
                    last_velocity[b * width + k] += change


def settle(first, last, job):
    """Centres at which the present impulses of some light bodies leave no imbalance, ``v_c = v = v_f + H r / m``; the
    velocities are ``v_f' + H r / M`` before."""
    light, velocity = job.light, job.s.velocity
    for l in range(first, last):
        b = light.body[l]
        for k in range(light.free.shape[1]):
            if light.mass[l, k] > 0.0:
                given = velocity[b, k] - job.free_velocity[b, k]
                light.centre[l, k] = light.free[l, k] + given / light.share[l]
                velocity[b, k] = light.centre[l, k]
                job.free_velocity[b, k] = light.centre[l, k] - given


def imbalance(first, last, job):
    """The largest ``|D (v - v_c)|`` of some light bodies, over the load of the body, and of those that bear more than a
    little; spins count by the radius of gyration.

    An imbalance that is next to nothing beside the impulses of the step does not count, unless it is the body's own load:
    then the body would never fall.
    """
    light, s = job.light, job.s
    d = s.carried.shape[1] + 1
    worst = 0.0
    of_loaded = 0.0
    for l in range(first, last):
        b = light.body[l]
        more = 1.0 / light.share[l] - 1.0
        square = 0.0
        load = 0.0
        mass = 0.0
        for k in range(light.free.shape[1]):
            m = light.mass[l, k]
            if k < d:
                mass = max(mass, m)
                load += (m * (light.free[l, k] - light.start[l, k])) ** 2
            # |(M - m) (v - v_c)|^2; for a spin I = m gyration^2
            square += m * (more * (s.velocity[b, k] - light.centre[l, k])) ** 2
        # load: own impulses, a part of the neighbours' load, or m (v_f - v_start)
        bears = max(s.noise[b, 2], NEARBY * s.noise[b, 3], np.sqrt(load))
        left = np.sqrt(mass * square)
        # a little imbalance does not count, unless it is the load itself
        little = is_little(left, left * light.rate[l] / mass if mass > 0.0 else 0.0, job.bounds)
        light.out[l] = 0.0
        if left > 0.0 and not (little and abs(left - np.sqrt(load)) > 0.5 * np.sqrt(load)):
            share = left / bears if bears > 0.0 else 1.0
            if s.noise[b, 2] > LITTLE * job.bounds[3]:
                of_loaded = max(of_loaded, share)
            elif share > job.bounds[2]:
                light.out[l] = 1.0
            worst = max(worst, share)
    return worst, of_loaded
