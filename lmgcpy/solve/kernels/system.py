"""The problem of one time step as the kernels see it: interactions one after another in flat arrays, and the velocities.

Interactions stand in canonical order in groups of one law and one kind of contactor pair, or of one chain. The
Delassus operator is never assembled: kernels work on the velocities of the bodies.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from lmgcpy.compiled.reference import by_reference


@by_reference
class System(NamedTuple):
    """Arrays of one step in dimension d; m interactions, n bodies, k components of a body's velocity: (v_x, v_y, spin)
    [m/s, m/s, rad/s] in 2D, (v_x, v_y, v_z, spin_x, spin_y, spin_z) in 3D. The frame is (n, t) in 2D, t being n turned by
    +90 degrees, and (n, t, s = n x t) in 3D."""

    candidate: np.ndarray
    """Row of the candidate body, (m,) uint32."""
    antagonist: np.ndarray
    """Row of the antagonist body, (m,) uint32."""
    normal: np.ndarray
    """Normal, from the antagonist to the candidate, (m, d)."""
    tangent: np.ndarray
    """Tangent t of the frame in 3D, (m, 3); (0, 3) in 2D."""
    arm: np.ndarray
    """(m, 2): distance along the normal from the candidate's and the antagonist's centre to the contact point [m],
    both positive towards it; the part of the levers that turns spin into tangential velocity."""
    lateral: np.ndarray
    """(m, 2), or (0, 2) if every pair is central: tangential coordinate of the contact point seen from the candidate's and
    the antagonist's centre [m]; the part of the levers that turns spin into normal velocity. (0, 2) in 3D."""
    lever: np.ndarray
    """Contact point seen from the candidate's and from the antagonist's centre, along the axes of space [m], (m, 6); (0, 6)
    in 2D and if every pair is central."""
    moment: np.ndarray
    """Moments of unit impulses along n, t and s about the centres of the candidate and the antagonist, along the axes of
    these bodies [m], (m, 18): n on the candidate, n on the antagonist, t on the candidate, and so on. (0, 18) in 2D and if
    every pair is central."""
    axes: np.ndarray
    """Rotation from the axes of each body, along which its spin is, to those of space, row by row of the matrix, (n, 9);
    (0, 9) if no body keeps a rotation in space."""
    rolling: np.ndarray
    """Effective radius of contacts with rolling friction [m], 0 of others, (m,); (0,) in scenes without any. Arrays of
    shape (m, d) have columns for the rolling components there, after the others."""
    edges: np.ndarray
    """Rows of the edges of a periodic cell among the bodies, (p,) int64; (0,) if no cell deforms."""
    branch: np.ndarray
    """Components along the axes of the edges of the vector from the antagonist's centre to the candidate's [m], (m, p),
    zero if one of them has no bounds; (0, 0) if no cell deforms."""
    cell: np.ndarray
    """Row of the first edge of the cell on which an interaction acts, (m,) uint32: in slabs the first of the copies of the
    edges that its task has (``lmgcpy.solve.sweeps.cell_copies``); (0,) if no cell deforms. The other edges follow."""
    delassus: np.ndarray
    """Diagonal of the local block (W_nn, W_tt, W_ss) [1/kg], (m, d)."""
    coupling: np.ndarray
    """(m,) [1/kg]: W_nt of a contact; of a link, the entry of W between it and the next link of its chain. In 3D (0,) if
    there are no links and all blocks are diagonal."""
    shear: np.ndarray
    """(W_ns, W_ts) of a contact in 3D [1/kg], (m, 2); (0, 2) in 2D and if ``coupling`` is empty."""
    corner: np.ndarray
    """Rows of the bodies at the corners of elements, of the candidate first, (m, c) uint32; (0, c) without elements. The
    candidate or antagonist itself is the body at the nearest corner then."""
    weight: np.ndarray
    """Numbers by which these bodies move the contact point, d + 1 a corner (``elements_in_space``), zero in places that an
    interaction does not need, (m, (d + 1) c)."""
    prepared: np.ndarray
    """Numbers that the laws' ``prepare`` returned, row by row of each group, flat."""
    impulse: np.ndarray
    """(r_n, r_t, r_s) [N s], (m, d)."""
    velocity: np.ndarray
    """Velocities of the bodies under the present impulses, (n, k)."""
    inverse_mass: np.ndarray
    """Inverse masses and inertias by component [1/kg], zero if driven, (n, k)."""
    geometric: np.ndarray
    """Geometric stiffness of the links [kg], which come first, (links,); (0,) if it is off."""
    carried: np.ndarray
    """Velocity across each link that its wire carries along as it turns [m/s], (links, d - 1), or none."""
    own: np.ndarray
    """Local block of W of each link [1/kg], (links, d, d), or none."""
    following: np.ndarray
    """Block of W between each link and the next one of its chain, (links, d, d), or none."""
    scratch: np.ndarray
    """Scratch of the wire blocks, (links, k), k = 4 or more with geometric stiffness. It begins with zeros and is kept
    between visits."""
    scale: np.ndarray
    """Time step over the size of the smaller body [s/m], (m,): an error of velocity times this is a displacement in the
    step, in parts of that body. Zero if no size is known."""
    squared_error: np.ndarray
    """Squares of the errors as last measured [m^2/s^2], (m,)."""
    noise: np.ndarray
    """Scratch, (n, 4): sizes of the terms of the velocities of the bodies (``lmgcpy.solve.kernels.rounding``), the greatest
    impulse on each, and on a neighbour (``lmgcpy.solve.kernels.loads``)."""
    floor: np.ndarray
    """Scratch: sizes of the terms of the relative velocities [m/s], (m,)."""
    farness: np.ndarray
    """Largest coordinate of each body over the time step [m/s], (n,): its position is rounded by ``eps`` times that way."""
    measured: np.ndarray
    """(6,): the residual as last measured, the largest ``scale |e|``, the row of its interaction, its error [m/s], and the
    largest error of a force over the load of the bodies."""

    @property
    def deforms(self) -> bool:
        """Whether there is a periodic cell that deforms."""
        return len(self.edges) > 0

    def reordered(self, row: np.ndarray, free_velocity: np.ndarray) -> tuple[System, np.ndarray]:
        """The system with body b in row ``row[b]``, (n,), and the velocities without impulses (n, k) in the same order.

        Both systems share the array of velocities: the solution is left in it in the new order.
        """
        body = np.empty_like(row)
        body[row] = np.arange(len(row), dtype=row.dtype)
        rows = row.astype(np.uint32)
        pairs = {name: rows.take(getattr(self, name)) for name in ("candidate", "antagonist", "corner")}
        # take copies rows of a matrix four to fifteen times as fast as brackets do
        bodies = {"inverse_mass": self.inverse_mass.take(body, axis=0), "farness": self.farness.take(body)}
        cell = {"edges": row[self.edges].astype(np.int64), "cell": rows.take(self.cell)}
        if len(self.axes):
            bodies["axes"] = self.axes.take(body, axis=0)
        return self._replace(**cell, **bodies, **pairs), free_velocity.take(body, axis=0)


class Groups(NamedTuple):
    """Rows of the groups in a :class:`System`, the order in which they are swept, and their kernels; int64.

    They are listed piece by piece, (p,) each: a piece is a group, or in a partitioned scene the part of a group in one
    slab. Pieces one after another are a task, which one thread does; tasks of a phase touch no body in common that they
    write to.
    """

    sweep: np.ndarray
    """Address of the kernel that updates the impulses of a piece."""
    error: np.ndarray
    """Address of the kernel that measures the error of a piece."""
    momentum: np.ndarray
    """Address of the kernel that gives its impulses to the bodies."""
    start: np.ndarray
    stop: np.ndarray
    """Rows of the piece's interactions."""
    offset: np.ndarray
    """First of its numbers in ``System.prepared``."""
    walls: np.ndarray
    """0 or 1 if the candidates or antagonists are held walls and are not to be written to; else -1."""
    task: np.ndarray
    """First piece of each task, and the end."""
    phase: np.ndarray
    """First task of each phase, and the end."""

    @classmethod
    def in_order(cls, kernels: Sequence[Any], start: Any, stop: Any, offset: Any) -> Groups:
        """Groups that are swept one after another by one thread; ``kernels``: the kernels of each group, with ``sweep``,
        ``error`` and ``momentum``."""
        addresses = ([getattr(k, name).address for k in kernels] for name in ("sweep", "error", "momentum"))
        walls, ends = [-1] * len(kernels), (np.array([0, len(kernels)]), np.array([0, 1]))
        return cls._make([*np.array([*addresses, start, stop, offset, walls], dtype=np.int64), *ends])
