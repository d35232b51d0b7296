"""A moment of a simulation or of a run: what the measures of a sample read, the same of both."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.contact.lattice import Lattice
from lmgcpy.dynamics.stepper import Stepper
from lmgcpy.errors import shown, whole
from lmgcpy.measure.sources import ActingInteractions, RecordedRun, is_run
from lmgcpy.scene.description import describe, lattice_of

Source = Stepper | RecordedRun


@dataclass(frozen=True)
class Moment:
    """Bodies and interactions after a step; n bodies, d dimensions."""

    net: ActingInteractions
    positions: np.ndarray
    """[m], (n, d)."""
    extent: np.ndarray
    """Radius of the circle or sphere that holds each body [m], infinite for walls, (n,)."""
    wall_normals: dict[int, np.ndarray]
    lattice: Lattice | None
    """That of a periodic cell."""
    laws: list[str]
    """Names of the laws of the scene."""
    links: frozenset[str]
    """Names of those that act in chains."""
    source: Source

    @property
    def scene(self) -> Mapping[str, Any]:
        """The description of the scene."""
        return describe(self.source.scene) if isinstance(self.source, Stepper) else self.source.scene

    @property
    def is_link(self) -> np.ndarray:
        """Which interactions are links, (m,) bool."""
        return np.isin(self.net.law, list(self.links))


def moment(source: Any, frame: int | None, call: str) -> Moment:
    """The last step of a simulation, or the step that ended with a ``frame`` of an open run, by default the last.

    Raises TypeError with a sentence that names the ``call`` for anything else.
    """
    if isinstance(source, Stepper):
        if frame is not None:
            raise TypeError("frame is for run files: a simulation knows its last step only.")
        model = source.model
        links = [chain.law.NAME for chain in model.chains]
        laws = links + [row.law.NAME for row in model.rows]
        return Moment(
            source.interactions,
            source.positions,
            model.extent,
            model.wall_normals,
            model.lattice,
            laws,
            frozenset(links),
            source,
        )
    if not is_run(source):
        raise TypeError(
            f"{call} takes a simulation, the object that lmgcpy.Simulation(...) makes, or a run file that "
            f"lmgcpy.io.open_run opens, got {shown(source)}."
        )
    k = -1 if frame is None else whole(frame, "frame", minimum=-(2**62))
    table = source.scene["laws"]
    links = [table[code]["name"] for code in np.unique(source.scene["chains"]["law"]).tolist()]
    lattice = lattice_of(source.scene)
    given = source.interactions(k), source.positions[k], source.extent, source.wall_normals, lattice
    return Moment(*given, list(source.laws), frozenset(links), source)
