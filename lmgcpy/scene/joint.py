"""Joints: two points of two bodies that a law ties."""

from __future__ import annotations

import numpy as np

from lmgcpy.contact.detection_tables import JointTable
from lmgcpy.laws import Law
from lmgcpy.scene.cell import Cell
from lmgcpy.scene.points import Node, points_of

OPEN = 1e-6
"""Distance of its points, in parts of the size of the joint, from which a rigid joint is refused at the start. The first
step would close it with a velocity of that distance divided by the time step."""


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
