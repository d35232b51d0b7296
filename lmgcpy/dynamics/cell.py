"""The motion of a periodic cell and of the bodies with it.

The cell deforms with the velocity gradient G; edges follow as ``dL/dt = G L``. A body at x moves with ``dx/dt = v + G x``:
its velocity v, which all its images share, is relative to the mean flow. Two bodies that touch at centres ``l = x_c - x_a``
apart, a being the nearest image, have the relative velocity ``v_c - v_a + G l`` besides what their spins add, whichever
images are taken. Bodies move by

    dv/dt = F/m - G v        (SLLOD: Evans, Morriss, Statistical Mechanics of Nonequilibrium Liquids, 1990, section 6.3).

In a steady shear (``G G = 0``) a body on which no force acts goes straight on as seen from outside. In other flows this
leaves out the acceleration ``(dG/dt + G G) x``, another one for each image: the drive of the cell gives it.

The power of an impulse r at a contact contains ``r . G l``, so that G is a velocity like others: its entries in ``H^T`` are
the components of l, contacts act on it with ``V sigma``, Weber's stress sigma, and a stress imposed on the cell is the load
``V sigma_imposed`` on G. The mean flow takes the power ``sum m v . G v`` from the velocities. The same power must go to G,
through the kinetic stress ``sum m v (x) v``. So

    I dG/dt = V (sigma_imposed - sigma) + sum m v (x) v

for each component that is not held, with an inertia I that the user chooses as one chooses the mass of a piston
(Parrinello, Rahman 1981; for contact dynamics Radjai, Voivret in Discrete-element Modeling of Granular Materials, 2011,
chapter 7).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.contact.frames import local_frames
from lmgcpy.contact.groups import Group, first_contact
from lmgcpy.contact.interactions import Interactions
from lmgcpy.contact.lattice import Lattice

TURNS = 1e-6
"""A flow turns if an eigenvalue of G has an imaginary part above this part of the norm of G. (The eigenvalues of a shear
are zero; rounding makes them 1e-8 of the norm.)"""
THINNEST = 1e-9
"""Least volume of a cell, in parts of the product of its edges: beyond that its inverse loses all digits of a gap."""


class TurnedOver(Exception):
    """Carries the rest of a sentence about a cell that a step would turn inside out."""


@dataclass(frozen=True)
class CellMotion:
    """The periodic cell of a model; n bodies, d dimensions, p edges.

    An edge has a row among the bodies: its velocity is the column of G for its axis [1/s], its mass is the inertia of that
    column [kg m^2], and a load on it is a stress [Pa].
    """

    lattice: Lattice
    unbounded: np.ndarray
    """Bodies without bounds, (n,) bool. They do not move with the cell: bodies that touch them slide along them."""

    @classmethod
    def of(cls, lattice: Lattice, extent: np.ndarray) -> CellMotion:
        """The motion of a cell and of bodies of these extents [m], (n,), infinite for bodies without bounds and for
        edges."""
        unbounded = ~np.isfinite(extent)
        unbounded[lattice.rows] = False
        return cls(lattice, unbounded)

    def gradient(self, velocities: np.ndarray) -> np.ndarray:
        """G [1/s], (d, d), from the velocities of the bodies, (n, k)."""
        d = self.lattice.dimension
        gradient = np.zeros((d, d))
        gradient[:, self.lattice.axes] = velocities[self.lattice.rows, :d].T
        return gradient

    def first_move(self, moving: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """Displacements of bodies, ``s + S x``, and of edges, ``S L``, in 2D with the turns, (n, 3).

        ``moving``: velocities times the time, s and in the rows of the edges S, (n, k); ``positions``: at its beginning,
        (n, 3).
        """
        self._refuse_turning_over(-self.gradient(moving), positions)
        return self._move(moving, positions)

    def _move(self, moving: np.ndarray, positions: np.ndarray) -> np.ndarray:
        d, rows = self.lattice.dimension, self.lattice.rows
        move = moving[:, :3].copy()
        move[rows] = 0.0
        flow = positions[:, :d] @ self.gradient(moving).T
        flow[self.unbounded] = 0.0
        move[:, :d] += flow
        return move

    def _refuse_turning_over(self, gradient: np.ndarray, positions: np.ndarray) -> None:
        """TurnedOver unless ``1 - t S`` keeps the cell's orientation for all t up to 1, which is if no real eigenvalue of
        S, (d, d), is 1 or more, and unless the edges span a cell."""
        finite = np.isfinite(gradient).all()
        values = np.linalg.eigvals(gradient) if finite else np.array([np.inf])
        real = np.abs(values.imag) <= 1e-12 * np.abs(values)
        largest = float(values.real[real].max(initial=0.0))
        if not largest < 1.0:
            raise TurnedOver(
                "the periodic cell would turn over: an edge changes by more than its own length. A time step "
                f"{0.5 / largest:.1g} times as long would do."
            )
        edges = self.lattice.edges(positions)
        lengths = float(np.prod(np.linalg.norm(edges, axis=1)))
        if not (np.isfinite(lengths) and self.lattice.volume(edges) > THINNEST * lengths):
            raise TurnedOver(
                f"the edges of the periodic cell span no volume, or next to none: {edges.tolist()} m. See what drives it."
            )

    def last_move(self, moving: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """Displacements with the positions x' at the end of the time in place of those at its beginning,
        ``x' - x = s + S x'``.

        After a first move over the same time, bodies on which no force acts have gone straight on in a shear flow: the
        difference between x' and x makes up for the change ``-G v`` of their velocity.
        """
        d = self.lattice.dimension
        self._refuse_turning_over(self.gradient(moving), positions)
        move = self._move(moving, positions)
        follows = ~self.unbounded
        own = move[follows, :d]  # s + S x, and x' - x = (1 - S)^-1 (s + S x)
        move[follows, :d] = np.linalg.solve(np.eye(d) - self.gradient(moving), own.T).T
        return move

    def before(self, positions: np.ndarray, moving: np.ndarray) -> np.ndarray:
        """Positions before a last move to these ones, (n, d); positions (n, d) and ``moving`` (n, d or more)."""
        d, rows = self.lattice.dimension, self.lattice.rows
        own = moving[:, :d].copy()
        own[rows] = 0.0
        flow = positions @ self.gradient(moving).T
        flow[self.unbounded] = 0.0
        return positions - own - flow

    def straighten(self, positions: np.ndarray) -> None:
        """Let the edges among the positions (n, 3) lean less, in place."""
        d, rows = self.lattice.dimension, self.lattice.rows
        positions[rows, :d] = self.lattice.straightened(self.lattice.edges(positions))

    def volume(self, positions: np.ndarray) -> float:
        """Volume of the cell at these positions of the bodies [m^d]."""
        return self.lattice.volume(self.lattice.edges(positions))

    def inertial_force(self, velocities: np.ndarray, free_mass: np.ndarray, time_step: float) -> np.ndarray:
        """Forces ``-m G v`` on the bodies, as a step takes them, and ``sum m v (x) v`` on the gradient, (n, k)."""
        d, rows = self.lattice.dimension, self.lattice.rows
        own = velocities[:, :d].copy()
        own[rows] = 0.0
        momentum = free_mass[:, :d] * own
        momentum[rows] = 0.0
        force = np.zeros_like(velocities)
        force[:, :d] = -free_mass[:, :d] * (own @ convection(self.gradient(velocities), time_step).T)
        force[rows, :d] = (momentum.T @ own).T[self.lattice.axes] * (free_mass[rows, :d] > 0.0)
        return force

    def yields(self, inverse_mass: np.ndarray) -> bool:
        """Whether a component of the gradient is not held."""
        return bool(inverse_mass[self.lattice.rows, : self.lattice.dimension].any())

    def deforms(self, inverse_mass: np.ndarray, *velocities: np.ndarray) -> bool:
        """Whether G may be other than zero in a step with these velocities (n, k)."""
        return self.yields(inverse_mass) or any(v[self.lattice.rows].any() for v in velocities)

    def branches(self, groups: list[Group], interactions: Interactions) -> np.ndarray:
        """Components of l along the axes of the edges [m], (m, p); zero if one of the two bodies has no bounds. On a thread
        or membrane l ends at the foot of the contact, the mean of the nodes by their weights."""
        normal = interactions.normal
        along = interactions.arm.sum(axis=1)
        for group in groups:
            if group.chain is not None:
                part = slice(group.start, group.stop)
                along[part] += interactions.gap[part] + group.chain.radius_sum
        branch = along[:, None] * normal
        if len(interactions.lateral):  # in 2D, t = (-n_y, n_x)
            lateral = interactions.lateral.copy()
            for part, side in sides_on_elements(groups):
                lateral[part, side] = 0.0
            across = lateral[:, 1] - lateral[:, 0]
            branch += across[:, None] * np.column_stack([-normal[:, 1], normal[:, 0]])
        if len(interactions.lever):
            links, of_sides = first_contact(groups), interactions.lever.reshape(-1, 2, 3).copy()
            for part, side in sides_on_elements(groups):
                lever = of_sides[part, side]
                of_sides[part, side] = (lever * normal[part]).sum(axis=1)[:, None] * normal[part]
            levers = of_sides[:, 1] - of_sides[:, 0]
            branch[:links] += levers[:links]
            branch[links:] = levers[links:]
        for group in groups:
            if group.jointed:  # all links of a joint are between the same two points
                part, d = slice(group.start, group.stop), normal.shape[1]
                gap = interactions.gap[part, None] * normal[part]
                branch[part] += np.repeat(gap.reshape(-1, d, d).sum(axis=1), d, axis=0) - gap
        branch[self.unbounded[interactions.candidate] | self.unbounded[interactions.antagonist]] = 0.0
        return np.ascontiguousarray(branch[:, self.lattice.axes])

    def add_to_blocks(
        self, branch: np.ndarray, groups: list[Group], interactions: Interactions, inverse_mass: np.ndarray, tasks: int
    ) -> None:
        """Add the mobility of the cell to the local blocks of W, in place: ``e . D e'`` for axes e, e' of the local frame,
        with the diagonal ``D_a = T sum_b l_b^2 / I_ab`` [1/kg].

        T is the number of ``tasks`` that are done side by side; each has a T-th of the inertia I
        (:mod:`lmgcpy.solve.sweeps.cell_copies`).
        """
        d = self.lattice.dimension
        mobility = branch**2 @ (tasks * inverse_mass[self.lattice.rows, :d])
        frame = local_frames(interactions.normal)
        blocks = (frame * mobility[:, None]) @ frame.transpose(0, 2, 1)
        links = first_contact(groups)
        interactions.delassus[:] += np.einsum("mii->mi", blocks)
        # a link is coupled with the next link: the term of the cell there is left to the iteration
        interactions.coupling[links:] += blocks[links:, 0, 1]
        if d == 3:
            interactions.shear[links:] += blocks[links:, :2, 2]
        for group in groups:
            group.diagonal = group.diagonal and group.chain is not None


def sides_on_elements(groups: list[Group]) -> list[tuple[slice, int]]:
    """Interactions and side, 0 or 1, of the sides that are elements of surfaces between bodies."""
    return [
        (slice(group.start, group.stop), side)
        for group in groups
        if group.on_elements and group.kinds is not None
        for side, count in enumerate(group.kinds.corners)
        if count > 1
    ]


def convection(gradient: np.ndarray, time_step: float) -> np.ndarray:
    """The matrix K, (d, d), of the change ``-h K v`` of velocities in a step with the gradient G, (d, d) [1/s].

    Explicit steps have ``K = G``. In a flow that rotates with the rate w they make speeds grow by the factor
    ``sqrt(1 + (h w)^2)`` in each step. There K comes from the implicit midpoint, ``v+ - v = -h G (v+ + v) / 2``, which
    gives

        K = (1 + h G / 2)^-1 G

    and keeps the speeds of a rotation at any h. In a shear (``G G = 0``) both are the same.
    """
    if not (np.abs(np.linalg.eigvals(gradient).imag) > TURNS * np.linalg.norm(gradient)).any():
        return gradient
    return np.linalg.solve(np.eye(len(gradient)) + 0.5 * time_step * gradient, gradient)
