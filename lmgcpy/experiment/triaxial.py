"""Triaxial compression of a 3D sample: imposed velocity on one platen, pressure on the four lateral walls."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.errors import AXES
from lmgcpy.experiment.compression import Compression, CompressionRecord
from lmgcpy.io.rows import Observe
from lmgcpy.io.run import Run


@dataclass(kw_only=True, repr=False)
class TriaxialRecord(CompressionRecord):
    """Measurements of a triaxial test, step by step. Pressures are positive, Weber stresses are traction positive."""

    axis: str
    """Axis along which the sample was compressed."""
    axial: np.ndarray
    """Mean pressure on the platens [Pa], (s,)."""
    lateral: np.ndarray
    """Mean pressures on the two pairs of lateral walls [Pa], (s, 2)."""
    volume_change: np.ndarray
    """Change of volume over the volume at the start, dilation positive, (s,)."""
    coordination: np.ndarray
    """Mean number of contacts of the particles that are no rattlers, (s,)."""
    fabric: np.ndarray
    """Mean of n (x) n over the contacts that carry force, (s, 3, 3)."""
    penetration: np.ndarray
    """Deepest overlap [m], (s,)."""

    @property
    def lateral_pressure(self) -> np.ndarray:
        """Mean pressure on the lateral walls [Pa], (s,)."""
        return self.lateral.mean(axis=1)

    @property
    def deviator(self) -> np.ndarray:
        """q: pressure on the platens minus pressure on the lateral walls [Pa], (s,)."""
        return self.axial - self.lateral_pressure

    @property
    def mean_pressure(self) -> np.ndarray:
        """p: a third of the pressure on the platens plus two thirds of that on the lateral walls [Pa], (s,)."""
        return (self.axial + 2.0 * self.lateral_pressure) / 3.0


class Triaxial(Compression):
    """A triaxial test: :class:`~lmgcpy.experiment.compression.Compression` of a 3D sample, along "x", "y" or "z".

    Linked beads are kept from rolling: beads finer than the grains would turn between them like the balls of a
    bearing, and the wire would slip through the sand at any friction.
    """

    NAME = "triaxial test"
    DIMENSION = 3
    BLOCK_SPIN = True

    def observed(self) -> Observe:
        """The quantities that are recorded at every step."""
        more = {"network": (self.box.network, self.box.network_names), "penetration": (self.box.penetration, "m")}
        return {**super().observed(), **more}

    def record(self, run: Run) -> TriaxialRecord:
        """The record of a run."""
        measured = self.measured(run)
        size, net = measured["size"], run.observed["network"][:]
        area = np.stack([np.prod(np.delete(size, k, axis=1), axis=1) for k in range(3)], axis=1)
        forces = run.observed["reactions"][:].reshape(-1, 3, 2).mean(axis=2)
        pressure = forces / area
        return TriaxialRecord(
            **measured,
            axis=AXES[self.axis],
            axial=pressure[:, self.axis],
            lateral=pressure[:, self.box.lateral],
            volume_change=np.prod(size, axis=1) / np.prod(self.start) - 1.0,
            coordination=net[:, 0],
            fabric=net[:, 2:].reshape(-1, 3, 3),
            penetration=run.observed["penetration"][:],
        )
