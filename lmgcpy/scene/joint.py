"""Points of bodies at which links act, and joints: two points of two bodies that a law ties."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from lmgcpy.contact.detection_tables import JointTable, Points
from lmgcpy.contact.positions import in_plane
from lmgcpy.errors import shown, vector
from lmgcpy.laws import Law
from lmgcpy.scene.body import Body, Boundary
from lmgcpy.scene.cell import Cell

OPEN = 1e-6
"""Distance of its points, in parts of the size of the joint, from which a rigid joint is refused at the start. The first
step would close it with a velocity of that distance divided by the time step."""


class Node(NamedTuple):
    """A body, and the point of it at which a link acts."""

    body: Body
    point: np.ndarray | None
    """From the centre of the body, along its axes [m], (d,); None for the centre, where the link ends at the surface."""

    @property
    def offset(self) -> np.ndarray:
        """The point, zero for the centre [m], (d,)."""
        return np.zeros(self.body.dimension) if self.point is None else self.point

    @property
    def turns(self) -> bool:
        """Whether the point is off the centre and turns with the body."""
        return bool(self.offset.any()) and (self.body.dimension == 2 or self.body.turns)

    @property
    def radius(self) -> float:
        """Distance from where the link acts to where its gap begins [m]."""
        return self.body.link_radius if self.point is None else 0.0

    @property
    def place(self) -> np.ndarray:
        """Where the link acts now [m], (d,)."""
        body, offset = self.body, self.offset
        if not self.turns:
            return body.position + offset
        turned = in_plane(body.rotation, offset) if body.dimension == 2 else body.rotation.apply(offset)
        return body.position + turned

    def __repr__(self) -> str:
        return repr(self.body) if self.point is None else f"the point {shown(self.point.tolist())} of {self.body!r}"


def node_of(body: Body, point: Any) -> Node:
    """A body with the point of it that was given."""
    if point is None:
        return Node(body, None)
    at = vector(point, f"The point at which {body!r} is linked", body.dimension)
    node = Node(body, at)
    if at.any() and not node.turns and not isinstance(body, Boundary):
        raise ValueError(
            f"{body!r} keeps no rotation, so that no point off its centre is known: make it a clump of one sphere, "
            "lmgcpy.clump([radius], [(0, 0, 0)], density=...).at(position), or take its centre."
        )
    return node


def points_of(nodes: Sequence[Node]) -> Points:
    """The points of some nodes as arrays."""
    return Points(np.array([node.offset for node in nodes]), np.array([node.turns for node in nodes], dtype=bool))


class Joint:
    """A point of ``bodies[0]``, the antagonist, tied to a point of ``bodies[1]``, the candidate; ``Scene.link`` makes it.

    ``collide``: whether the two bodies may also be in contact.
    """

    def __init__(self, nodes: tuple[Node, Node], law: Law, *, collide: bool, settled: bool, cell: Cell | None):
        self.nodes, self.law, self.collide = nodes, law, collide
        self._settled = settled
        self.check_start(cell)

    @property
    def bodies(self) -> tuple:
        """The two bodies."""
        return tuple(node.body for node in self.nodes)

    def opening(self, cell: Cell | None = None) -> np.ndarray:
        """Vector from the antagonist's point to the candidate's [m], (d,); in a periodic cell between nearest images."""
        between = self.nodes[1].place - self.nodes[0].place
        return between if cell is None else cell.lattice.shortened(between[None], cell.edges)[0]

    def check_start(self, cell: Cell | None) -> None:
        """ValueError for a rigid joint whose points are apart in a scene that is written."""
        if self._settled or "rigid" not in self.law.TRAITS:
            return
        way = float(np.linalg.norm(self.opening(cell)))
        size = max(float(np.linalg.norm(node.offset)) + node.body.link_radius for node in self.nodes)
        if way > OPEN * size:
            raise ValueError(
                f"The joint between {self.nodes[0]!r} and {self.nodes[1]!r} is open by {way:.3g} m: the first step would "
                "close it with a blow. Move the bodies or the points."
            )

    def __repr__(self) -> str:
        return f"<Joint of {self.bodies[0]!r} and {self.bodies[1]!r}, {self.law!r}>"


def joint_tables(joints: list[Joint], dimension: int) -> list[JointTable]:
    """The joints as the detection gets them, those of equal laws in one table."""
    tables = []
    for law in dict.fromkeys(joint.law for joint in joints):
        mine = [node for joint in joints if joint.law == law for node in joint.nodes]
        bodies = np.array([node.body.id for node in mine], dtype=np.int64)
        zero = np.zeros(dimension * len(mine) // 2)
        tables.append(JointTable(bodies, [law], zero, zero, zero, 0.0, points=points_of(mine)))
    return tables
