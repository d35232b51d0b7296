"""A form in a deforming periodic cell: each function calls the same function without the cell and adds the terms of G.

With the branch l between two centres and the velocity gradient G of the cell, whose columns are the velocities of its
edges' rows, bodies have ``G l`` more of relative velocity, and an impulse r gives ``r (x) l`` to G
(:mod:`lmgcpy.dynamics.cell`).
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from lmgcpy.compiled.fingerprint import Slot
from lmgcpy.contact.frames import cross

base_velocity: Callable[..., Any] = Slot("base_velocity")
"""``relative_velocity`` without the cell. The names below that begin with ``base_`` are likewise without it."""
base_push: Callable[..., Any] = Slot("base_push")
base_momentum: Callable[..., Any] = Slot("base_momentum")
base_velocities: Callable[..., Any] = Slot("base_velocities")
in_frame: Callable[..., Any] = Slot("in_frame")
"""``(i, s, vector)``: the vector in the local frame, with as many components as an impulse has."""
in_space: Callable[..., Any] = Slot("in_space")
"""``(i, s, r)``: the impulse along the axes."""
flow: Callable[..., Any] = Slot("flow")
"""``(velocity, i, s)``: ``G l``."""
plus_first: Callable[..., Any] = Slot("plus_first")
"""``(u, v)``: u with v added to its first components."""
row: Callable[..., Any] = Slot("row")


@cache
def sum_of_first(count: int, rows: int) -> Callable:
    """Function ``(u, v)`` that adds the vector v of ``count`` numbers to the first of the ``rows`` numbers of u."""
    sums = [f"u[{k}] + v[{k}]" if k < count else f"u[{k}]" for k in range(rows)]
    return eval(f"lambda u, v: ({', '.join(sums)})", {"__name__": __name__})


def relative_velocity(i, s):
    """``H^T v`` of interaction ``i``."""
    return plus_first(base_velocity(i, s), in_frame(i, s, flow(s.velocity, i, s)))


def push(i, s, d):
    """Add ``M^-1 H d`` of an impulse ``d`` on interaction ``i`` to the velocities of its bodies and of the cell."""
    base_push(i, s, d)
    force = in_space(i, s, d)
    for k in range(s.branch.shape[1]):
        edge = s.cell[i] + np.uintp(k)
        for axis in range(len(force)):
            s.velocity[edge, axis] += s.inverse_mass[edge, axis] * (s.branch[i, k] * force[axis])


def momentum(start, stop, walls, s):
    """Add ``H r`` of some interactions to ``s.velocity``."""
    base_momentum(start, stop, walls, s)
    for i in range(start, stop):
        force = in_space(i, s, row(s.impulse, i, 0))
        for k in range(s.branch.shape[1]):
            edge = s.cell[i] + np.uintp(k)
            for axis in range(len(force)):
                s.velocity[edge, axis] += s.branch[i, k] * force[axis]
    return 0.0


def relative_velocities(start, stop, s, velocity, result):
    """``H^T v`` of some interactions for velocities of the bodies, into ``result`` (m, d or more)."""
    base_velocities(start, stop, s, velocity, result)
    for i in range(start, stop):
        u = in_frame(i, s, flow(velocity, i, s))
        for k in range(len(u)):
            result[i, k] += u[k]


def flow_2d(velocity, i, s):
    x = 0.0
    y = 0.0
    for k in range(s.branch.shape[1]):
        edge = s.cell[i] + np.uintp(k)
        x += s.branch[i, k] * velocity[edge, 0]
        y += s.branch[i, k] * velocity[edge, 1]
    return x, y


def in_frame_2d(i, s, v):
    n_x = s.normal[i, 0]
    n_y = s.normal[i, 1]
    return n_x * v[0] + n_y * v[1], n_x * v[1] - n_y * v[0]


def in_space_2d(i, s, r):
    n_x = s.normal[i, 0]
    n_y = s.normal[i, 1]
    return n_x * r[0] - n_y * r[1], n_y * r[0] + n_x * r[1]


def flow_3d(velocity, i, s):
    x = 0.0
    y = 0.0
    z = 0.0
    for k in range(s.branch.shape[1]):
        edge = s.cell[i] + np.uintp(k)
        x += s.branch[i, k] * velocity[edge, 0]
        y += s.branch[i, k] * velocity[edge, 1]
        z += s.branch[i, k] * velocity[edge, 2]
    return x, y, z


def frame_3d(i, s):
    """The axes n, t and s = n x t of the local frame."""
    n = (s.normal[i, 0], s.normal[i, 1], s.normal[i, 2])
    t = (s.tangent[i, 0], s.tangent[i, 1], s.tangent[i, 2])
    return n, t, cross(n, t)


def in_frame_3d(i, s, v):
    n, t, b = frame_3d(i, s)
    return (
        n[0] * v[0] + n[1] * v[1] + n[2] * v[2],
        t[0] * v[0] + t[1] * v[1] + t[2] * v[2],
        b[0] * v[0] + b[1] * v[1] + b[2] * v[2],
    )


def in_space_3d(i, s, r):
    n, t, b = frame_3d(i, s)
    return (
        n[0] * r[0] + t[0] * r[1] + b[0] * r[2],
        n[1] * r[0] + t[1] * r[1] + b[1] * r[2],
        n[2] * r[0] + t[2] * r[1] + b[2] * r[2],
    )
