"""The lattice of a periodic cell: its edges among the bodies, images of points, and the widths of the cell.

A point x and its images ``x + sum n_k L_k``, n whole numbers and L_k the edges, are the same body. Positions are kept
unwrapped: a body that leaves the cell goes on, so that displacements need no images. A link joins the nearest ones.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np


@dataclass(frozen=True)
class Lattice:
    """Rows of the p edges of a cell in arrays of bodies, and the axes of these edges; d dimensions."""

    rows: np.ndarray
    """Row of each edge among the bodies, (p,) int64. Its position is the edge [m]."""
    axes: np.ndarray
    """Axis of each edge, ascending, (p,) int64."""
    dimension: int

    def edges(self, positions: np.ndarray) -> np.ndarray:
        """Edges of the cell [m], (p, d), from the positions of the bodies (n, d or more)."""
        return positions[self.rows, : self.dimension]

    def basis(self, edges: np.ndarray) -> np.ndarray:
        """Matrix whose columns are the edges, and unit vectors along the axes that have none, (d, d)."""
        basis = np.eye(self.dimension)
        basis[:, self.axes] = edges.T
        return basis

    def volume(self, edges: np.ndarray) -> float:
        """Volume between the edges, per unit of length along the axes that have none [m^p]."""
        return abs(float(np.linalg.det(self.basis(edges))))

    def widths(self, edges: np.ndarray) -> np.ndarray:
        """Distance between the faces that each edge joins [m], (p,)."""
        return 1.0 / np.linalg.norm(np.linalg.inv(self.basis(edges))[self.axes], axis=1)

    def reduced(self, points: np.ndarray, edges: np.ndarray) -> np.ndarray:
        """Coordinates of points (m, d) along the edges, in parts of them, (m, p)."""
        return points @ np.linalg.inv(self.basis(edges))[self.axes].T

    def across(self, points: np.ndarray, edges: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates of points (m, d) at right angles to the faces of the cell [m], (m, d), and their periods, (d,): the
        widths of the cell, infinite for axes without an edge.

        The coordinates of two points differ by no more than their distance, up to a period. Periodic ones begin with 0.
        """
        inverse = np.linalg.inv(self.basis(edges))
        step = 1.0 / np.linalg.norm(inverse, axis=1)
        period = np.full(self.dimension, np.inf)
        period[self.axes] = step[self.axes]
        at = points @ inverse.T
        at[:, self.axes] -= np.floor(at[:, self.axes])
        return at * step, period

    def nearest(self, differences: np.ndarray, edges: np.ndarray) -> np.ndarray:
        """Whole numbers n (m, p) for which ``x - n L`` is the shortest image of each difference x of positions (m, d).

        The result is the shortest image if the shortest image is below half the least width: its reduced coordinates are
        then below one half.
        """
        return np.rint(self.reduced(differences, edges))

    def crossed(self, differences: np.ndarray, edges: np.ndarray) -> np.ndarray:
        """The way across the cell by which each difference of positions (m, d) is more than its shortest image [m]."""
        return self.nearest(differences, edges) @ edges

    def shortened(self, differences: np.ndarray, edges: np.ndarray) -> np.ndarray:
        """The shortest image of each difference of positions (m, d) [m]."""
        return differences - self.crossed(differences, edges)

    def course(self, points: np.ndarray, edges: np.ndarray) -> np.ndarray:
        """Points along a chain (l + 1, d), each as the image that is nearest to the one before it [m]."""
        crossed = self.nearest(np.diff(points, axis=0), edges)
        if not crossed.any():
            return points
        return np.concatenate([points[:1], points[1:] - np.cumsum(crossed, axis=0) @ edges])

    def wrapped(self, points: np.ndarray, edges: np.ndarray) -> np.ndarray:
        """The images of points (m, d) that lie within the cell [m]."""
        return points - np.floor(self.reduced(points, edges)) @ edges

    def straightened(self, edges: np.ndarray) -> np.ndarray:
        """Edges of the same lattice that lean less, (p, d): a cell that is sheared on and on stays a box.

        An edge loses whole multiples of another edge if its component along that edge is above 0.6 of its length. The
        bound is not one half, so that a cell that rocks about one half is not changed in every step. Each change shortens
        an edge.
        """
        edges = edges.copy()
        again = True
        while again:
            again = False
            for one in range(len(edges)):
                for other in range(len(edges)):
                    leaning = float(edges[one] @ edges[other]) / float(edges[other] @ edges[other])
                    if one != other and abs(leaning) > 0.6:
                        edges[one] -= np.rint(leaning) * edges[other]
                        again = True
        return edges


def crossing(lattice: Lattice | None, positions: np.ndarray) -> Callable[[np.ndarray], np.ndarray] | None:
    """Gives the ways across the cell that are in differences (m, d), see :meth:`Lattice.crossed`, at these positions of the
    bodies (n, d or more); None without a cell."""
    return None if lattice is None else partial(lattice.crossed, edges=lattice.edges(positions))


def chain_course(lattice: Lattice | None, positions: np.ndarray, path: np.ndarray) -> np.ndarray:
    """Positions along a chain, of the bodies of ``path`` (l + 1,) among these positions (n, d); in a periodic cell each as
    the image nearest to the one before [m], (l + 1, d)."""
    points = positions[path]
    return points if lattice is None else lattice.course(points, lattice.edges(positions))
