"""The chains in the description of a scene: through which bodies, and through which points of them, they go."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.contact.detection_tables import Points
from lmgcpy.contact.lattice import Lattice
from lmgcpy.contact.links import offsets_in_space


@dataclass(frozen=True)
class DescribedChain:
    """The l links between consecutive bodies of ``path``. The path of a closed chain ends with its first body."""

    path: np.ndarray
    """Ids of the bodies, (l + 1,)."""
    radius: np.ndarray
    """Distance from where a link acts to where its gap begins, of each body [m], (l + 1,)."""
    bead: np.ndarray
    """Whether the links act at the centre of each body: it is a bead, and no body to which the chain is tied, (l + 1,)."""
    gap: np.ndarray
    """Reference gaps [m], (l,)."""
    points: Points | None
    """Where links act on these bodies, None for their centres."""

    @property
    def reference(self) -> np.ndarray:
        """Reference lengths [m], (l,)."""
        return self.gap + self.radius[:-1] + self.radius[1:]

    def places(self, positions: np.ndarray, rotations: np.ndarray | None) -> np.ndarray:
        """Where links act on each body [m], (l + 1, d).

        ``positions`` (n, d) and ``rotations`` of the bodies: angles (n,), or quaternions (n, 4); None if no body keeps one.
        """
        centres = positions[self.path]
        if self.points is None:
            return centres
        placed = centres if rotations is None else np.column_stack([centres, rotations[self.path]])
        return centres + offsets_in_space(self.points, placed)

    def course(self, lattice: Lattice | None, positions: np.ndarray, rotations: np.ndarray | None) -> np.ndarray:
        """These places, in a periodic cell each as the image nearest to the one before [m], (l + 1, d)."""
        places = self.places(positions, rotations)
        return places if lattice is None else lattice.course(places, lattice.edges(positions))


def described_chains(scene: Mapping[str, Any]) -> list[DescribedChain]:
    """The chains in the description of a scene."""
    table, link_radius = scene["chains"], np.asarray(scene["bodies"]["link_radius"], dtype=float)
    bodies = np.asarray(table["bodies"], dtype=np.int64)
    points = np.asarray(table.get("points", np.full((len(bodies), int(scene["dimension"])), np.nan)))
    ends = np.cumsum(np.asarray(table["body_count"], dtype=np.int64))[:-1]
    gaps = np.split(np.asarray(table["reference_gaps"], dtype=float), np.cumsum(table["link_count"])[:-1])
    found = []
    closed = np.asarray(table["closed"], dtype=bool).tolist()
    for path, at, gap, ring in zip(np.split(bodies, ends), np.split(points, ends), gaps, closed, strict=False):
        if ring:
            path, at = np.append(path, path[0]), np.concatenate([at, at[:1]])
        centre = np.isnan(at[:, 0])
        offset = np.where(centre[:, None], 0.0, at)
        moved = Points(offset, (offset != 0.0).any(axis=1)) if offset.any() else None
        found.append(DescribedChain(path, np.where(centre, link_radius[path], 0.0), centre, gap, moved))
    return found


def joint_rows(scene: Mapping[str, Any]) -> int:
    """Number of interactions of the joints of a scene: they come after the links of its chains."""
    return int(scene["dimension"]) * len(scene["joints"]["law"]) if "joints" in scene else 0
