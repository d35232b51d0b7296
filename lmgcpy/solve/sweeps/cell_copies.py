"""Copies of a periodic cell that deforms, one for each task of a sweep in slabs.

Every interaction reads the velocity gradient G of the cell and, if the cell yields, changes it. But tasks that are done
side by side must write to no number in common. So each of the T tasks of a phase has a copy ``G_t`` with a T-th of the
cell's inertia I, and when the phase is over, G becomes the mean of the copies (mass splitting: Tonge, Benevolenski,
Voroshilov 2012, ACM Trans. Graph. 31(4)). If the impulses of the interactions change by d in a phase, and ``B_t d`` is the
sum of ``d_i (x) l_i`` over the interactions of task t, l being the branches,

    G_t = G + T I^-1 B_t d,        G <- G + sum_t (G_t - G) / T = G + I^-1 sum_t B_t d.

So no momentum is lost, and the bits do not depend on which thread did which task. In a task each visit minimises the energy
of the step (without friction, or with the shift ``mu |u_t|`` held) with

    sum_t T |B_t d|^2_(1/I) / 2    for    |sum_t B_t d|^2_(1/I) / 2.

The first is never less, and they are equal if ``d = 0`` or if all tasks push the cell equally. So a phase never raises
the energy, for any inertia, and loses little if the slabs have about equal numbers of bodies. It holds only if the visits
know the mobility that they meet: local blocks of W have the factor T as well (``CellMotion.add_to_blocks``). Without it
sweeps diverge in a cell with 1e-5 of the inertia that the grains give it.

In a cell with an imposed gradient the copies have no mobility and do not change.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.solve.kernels.system import Groups, System

LEND, AVERAGE, TOTAL = map(np.int64, range(31, 34))
"""Kinds of work, numbered after the kinds of ``light_bodies``; their task is a phase. They are done by the thread that
leads."""
APART = 3
"""Rows between the copies of two tasks: two threads never write to one line of the cache."""


def with_copies(system: System, groups: Groups) -> System:
    """The system with the copies behind its bodies, in velocities, inverse masses and sizes of terms."""
    (n, k), p = system.velocity.shape, len(system.edges)
    tasks, at_once = len(groups.task) - 1, np.diff(groups.phase)
    first = n + (p + APART) * np.arange(tasks)
    rows = (first[:, None] + np.arange(p)).ravel()
    inverse_mass = np.zeros((n + (p + APART) * tasks, k))
    inverse_mass[:n] = system.inverse_mass
    of_cell = np.repeat(at_once, at_once)[:, None, None] * system.inverse_mass[system.edges]
    inverse_mass[rows] = of_cell.reshape(-1, k)
    cell = np.empty_like(system.cell)
    for t in range(tasks):
        for piece in range(groups.task[t], groups.task[t + 1]):
            cell[groups.start[piece] : groups.stop[piece]] = first[t]
    shared = {"velocity": np.zeros(inverse_mass.shape), "noise": np.zeros((len(inverse_mass), system.noise.shape[1]))}
    return system._replace(inverse_mass=inverse_mass, cell=cell, **shared)


def cell_work(kind, phase, job):
    """Work on the copies of one phase, by kind."""
    s, first, last = job.s, job.groups.phase[phase], job.groups.phase[phase + 1]
    p = s.edges.shape[0]
    for j in range(p):
        edge = s.edges[j]
        begin = job.free_velocity.shape[0] + j
        # G_t = G, and the sizes of its terms
        if kind == LEND:
            for task in range(first, last):
                copy = begin + (p + APART) * task
                s.noise[copy, 0] = s.noise[edge, 0]
                for k in range(s.velocity.shape[1]):
                    s.velocity[copy, k] = s.velocity[edge, k]
            continue
        # G + sum_t (G_t - G) / T; of momenta the sum
        share = 1.0 if kind == TOTAL else 1.0 / (last - first)
        for k in range(s.velocity.shape[1]):
            s.velocity[edge, k] += share * gained(s.velocity, k, edge, begin + (p + APART) * first, last - first, p)
        s.noise[edge, 0] += share * gained(s.noise, 0, edge, begin + (p + APART) * first, last - first, p)


def gained(array, k, edge, copy, count, p):
    """Sum over some copies of an edge of the differences to the edge in column ``k``."""
    total = 0.0
    for _ in range(count):
        total += array[copy, k] - array[edge, k]
        copy += p + APART
    return total
