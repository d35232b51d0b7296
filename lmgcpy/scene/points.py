"""Points of bodies at which links act."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from lmgcpy.contact.detection_tables import Points
from lmgcpy.contact.positions import in_plane
from lmgcpy.errors import shown, vector
from lmgcpy.scene.body import Body, Boundary


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
