"""Contacts across the faces of a periodic cell.

Two contactors are near if an image of one is near the other; a cell that is wide enough has at most one such image
(:meth:`Images.check_width`). The narrow phase is the same as without a cell: an antagonist that is an image gets a row of
its own behind the rows of the contactors and bodies. In the interactions the body itself then replaces the image.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from lmgcpy.contact.broad_phase import near_pairs, sorted_pairs
from lmgcpy.contact.detection_tables import ContactorTable
from lmgcpy.contact.elements import Elements
from lmgcpy.contact.groups import Group
from lmgcpy.contact.lattice import Lattice


class Seen(NamedTuple):
    """The arrays that a narrow phase reads. In a periodic cell the images are the last rows."""

    placed: np.ndarray
    """Positions of the contactors, (k, w)."""
    body: np.ndarray
    """Row of the body of each contactor, (k,)."""
    shapes: np.ndarray
    """Numbers of their shapes, flat."""
    bodies: np.ndarray
    """Positions of the bodies, (n, w)."""
    inverse_mass: np.ndarray
    """By component, (n, c)."""


class Images:
    """The images that a list of neighbours needs, of a scene with a lattice."""

    def __init__(self, lattice: Lattice, contactors: ContactorTable, bounded: np.ndarray):
        """``bounded``: whether each contactor is bounded, (k,) bool."""
        self.lattice = lattice
        self._contactors = contactors
        self._bounded = bounded
        self.measure(contactors.bounding_radius)
        self._set(np.zeros(0, np.int64), np.zeros((0, len(lattice.rows))))

    def measure(self, radii: np.ndarray) -> None:
        """Go on with other bounding radii of the contactors (k,)."""
        self._radii = radii
        self._largest = float(radii[self._bounded].max(initial=0.0))
        reach = np.linalg.norm(self._contactors.swing, axis=1) + radii
        elements = self._contactors.elements
        if elements is not None:  # seen from the body at a corner
            reach[elements.rows] += radii[elements.rows]
        self._longest = float(reach[self._bounded].max(initial=0.0))
        """Largest radius of a circle or sphere around the centre of a body that contains it; the cell must be wider than
        twice this radius."""

    def _set(self, contactor: np.ndarray, shift: np.ndarray) -> None:
        """Set the contactor of each image, (g,), and the number of edges by which it is shifted, (g, p)."""
        self._contactor, self._shift = contactor, shift
        self._body = self._contactors.body[contactor]

    def with_edges(self, placed: np.ndarray, bodies: np.ndarray) -> np.ndarray:
        """Positions of the contactors, and below them the edges of the cell, (k + p, w)."""
        edges = np.zeros((len(self.lattice.rows), placed.shape[1]))
        edges[:, : self.lattice.dimension] = self.lattice.edges(bodies)
        return np.concatenate([placed, edges])

    def _edges(self, placed: np.ndarray) -> np.ndarray:
        return placed[len(self._contactors.body) :, : self.lattice.dimension]

    def across(self, placed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See :meth:`Lattice.across <lmgcpy.contact.lattice.Lattice.across>`, for positions of the contactors."""
        return self.lattice.across(placed[:, : self.lattice.dimension], self._edges(placed))

    def most_reach(self, placed: np.ndarray) -> float:
        """The largest reach that the width of the cell allows [m], less a thousandth of the width."""
        width = float(self.lattice.widths(self._edges(placed)).min())
        return 0.499 * width - max(2.0 * self._largest, self._longest)

    def check_width(self, placed: np.ndarray, reach: float) -> None:
        """ValueError if two images of a contactor may be within ``reach`` [m] of another contactor, or if a body may be
        within ``reach`` of its own image."""
        least = 2.0 * max(2.0 * self._largest, self._longest) + 2.0 * reach
        width = float(self.lattice.widths(self._edges(placed)).min())
        if not width > least:
            raise ValueError(
                f"The periodic cell is {width:.3g} m wide, where a body may meet two images of another one: it must be "
                f"wider than {least:.3g} m, twice the largest diameter plus the distance within which contacts are "
                "looked for. Take a larger cell, or a smaller time step or alert distance."
            )

    def near_pairs(self, placed: np.ndarray, reach: float) -> np.ndarray:
        """Pairs of bounded contactors of which some images are within ``reach`` [m], (q, 2) int32, sorted."""
        self.check_width(placed, reach)
        lattice, edges = self.lattice, self._edges(placed)
        bounded = np.flatnonzero(self._bounded)
        radius, count = self._radii[bounded], len(bounded)
        points = lattice.wrapped(placed[bounded, : lattice.dimension], edges)
        at = lattice.reduced(points, edges)
        margin = (2.0 * self._largest + reach) / lattice.widths(edges)
        copies, owner = [points], [np.arange(count)]
        shifts = list(itertools.product((-1, 0, 1), repeat=len(edges)))
        for shift in shifts[len(shifts) // 2 + 1 :]:  # a pair across a face is one pair, seen from its one side
            there = at + shift
            within = np.flatnonzero(((there >= -margin) & (there <= 1.0 + margin)).all(axis=1))
            copies.append(points[within] + np.array(shift) @ edges)
            owner.append(within)
        owners = np.concatenate(owner)
        near = near_pairs(np.concatenate(copies), radius[owners], reach)
        near = owners[near[near[:, 0] < count]]  # not two images
        near = np.sort(near, axis=1).astype(np.int32)
        return bounded.astype(np.int32).take(sorted_pairs(near, count))

    def course(self, rows: np.ndarray, bodies: np.ndarray) -> np.ndarray | None:
        """Positions of the bodies in some rows (l + 1,), each as the image nearest to the one before, (l + 1, w). None if
        no image differs from its body."""
        points, d = bodies[rows], self.lattice.dimension
        course = self.lattice.course(points[:, :d], self.lattice.edges(bodies))
        if np.shares_memory(course, points):
            return None
        points[:, :d] = course
        return points

    def carried_along(self, listed_at: np.ndarray, placed: np.ndarray) -> tuple[np.ndarray, float]:
        """Positions (k + p, w) that contactors would have if they had moved with the cell since a list was made, and the
        least ratio by which the cell has shortened distances since then.

        A pair outside the list may have come nearer since then by this shortening, and by the motions of both relative to
        the cell.
        """
        d = self.lattice.dimension
        old, new = (self.lattice.basis(self._edges(points)) for points in (listed_at, placed))
        deformed = new @ np.linalg.inv(old)
        if not np.array_equal(np.rint(np.linalg.inv(old) @ new), np.eye(d)):  # other edges of the same lattice
            return placed, 0.0
        carried = listed_at.copy()
        carried[:, :d] = listed_at[:, :d] @ deformed.T
        carried[: len(self._bounded)][~self._bounded, :d] = listed_at[: len(self._bounded)][~self._bounded, :d]
        return carried, float(np.linalg.svd(deformed, compute_uv=False).min())

    def shortening(self, ratio: float, reach: float) -> float:
        """By how much distances between surfaces within ``reach`` may have become shorter by that ratio [m]."""
        return max(0.0, 1.0 - ratio) * (2.0 * self._largest + reach)

    def look_at(self, groups: Iterable[Group], placed: np.ndarray) -> None:
        """Find the images that the pairs of some groups need; each group gets its pairs with the rows of the images."""
        edges, d, p = self._edges(placed), self.lattice.dimension, len(self.lattice.rows)
        contacts = [group for group in groups if not group.chain]
        wanted = []
        for group in contacts:
            c, a = group.pairs.T
            shift = self.lattice.nearest(placed[c, :d] - placed[a, :d], edges)
            shift[~(self._bounded[c] & self._bounded[a])] = 0.0
            wanted.append(np.column_stack([a.astype(float), shift]))
        rows = np.concatenate([np.zeros((0, 1 + p)), *wanted])
        across = rows[:, 1:].any(axis=1)
        images, index = np.unique(rows[across], axis=0, return_inverse=True)
        self._set(images[:, 0].astype(np.int64), images[:, 1:])
        antagonist = rows[:, 0].astype(np.int32)
        antagonist[across] = len(placed) + index.ravel()
        first = 0
        for group in contacts:
            last = first + len(group.pairs)
            group.placed_pairs = np.column_stack([group.pairs[:, 0], antagonist[first:last]])
            first = last

    def seen(self, plain: Seen, stride: int) -> Seen:
        """Contactors and bodies with the images behind them; ``stride``: length of the row of a shape."""
        p, count = len(self.lattice.rows), len(plain.bodies)
        shift = np.zeros((len(self._shift), plain.bodies.shape[1]))
        shift[:, : self.lattice.dimension] = self._shifts(plain.bodies)
        images = count + np.arange(len(shift))
        shapes = plain.shapes.reshape(-1, stride)
        return Seen(
            np.concatenate([plain.placed, plain.placed[self._contactor] + shift]),
            np.concatenate([plain.body, np.zeros(p, np.int64), images]),
            np.concatenate([shapes, np.zeros((p, stride)), shapes[self._contactor]]).ravel(),
            np.concatenate([plain.bodies, plain.bodies[self._body] + shift]),
            np.concatenate([plain.inverse_mass, plain.inverse_mass[self._body]]),
        )

    def _shifts(self, bodies: np.ndarray) -> np.ndarray:
        """Where each image is from its contactor [m], (g, d)."""
        return self._shift @ self.lattice.edges(bodies)

    def elements(self, plain: Elements, bodies: np.ndarray) -> Elements:
        """The elements with the images behind them, for positions of the bodies (n, w)."""
        return plain.with_images(self._contactor, len(self.lattice.rows), self._shifts(bodies))

    def name_bodies(self, antagonist: np.ndarray, count: int) -> None:
        """Replace the rows of images by the rows of their bodies; ``count``: number of bodies."""
        image = antagonist >= count
        antagonist[image] = self._body[antagonist[image] - count]
