"""Biaxial compression of a 2D sample (paper, section 3)."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from lmgcpy.errors import AXES
from lmgcpy.experiment.compression import Compression, CompressionRecord
from lmgcpy.io.run import Run


@dataclass(frozen=True)
class Frame:
    """The sample after one step."""

    strain: float
    """Crushing, as a fraction of the height at the start."""
    top_force: float
    """Force on the upper platen [N]."""
    positions: np.ndarray
    """Positions of the particles [m], (n, 2)."""
    walls: np.ndarray
    """Positions of the left, right, lower and upper wall [m], (4,)."""
    lines: np.ndarray
    """Both ends of each force line [m], (m, 2, 2)."""
    forces: np.ndarray
    """Normal force along each line, compression positive [N], (m,)."""
    in_wire: np.ndarray
    """Whether the line is a link, (m,) bool."""

    def __repr__(self) -> str:
        crushed = f"{100.0 * self.strain:.3g} % of crushing"
        return f"<Frame at {crushed}: {len(self.positions)} particles, {len(self.forces)} forces>"


@dataclass(kw_only=True, repr=False)
class BiaxialRecord(CompressionRecord):
    """Measurements of a biaxial test, step by step."""

    lateral: np.ndarray
    """Mean force on the lateral walls [N], (s,)."""
    frames: list[Frame] = field(default_factory=list)
    """The recorded frames, evenly spaced."""
    axis: str = "y"
    """Axis along which the sample was compressed."""

    @property
    def lateral_pressure(self) -> np.ndarray:
        """Mean pressure on the lateral walls [Pa], (s,)."""
        return self.lateral / self.size[:, AXES.index(self.axis)]

    @property
    def deviator(self) -> np.ndarray:
        """q: pressure on the lower platen minus pressure on the lateral walls [Pa], (s,)."""
        return self.reaction / self.size[:, 1 - AXES.index(self.axis)] - self.lateral_pressure


class Biaxial(Compression):
    """A biaxial test: :class:`~lmgcpy.experiment.compression.Compression` of a 2D sample. Beads are free to roll."""

    NAME = "biaxial test"
    DIMENSION = 2
    BLOCK_SPIN = False

    def record(self, run: Run) -> BiaxialRecord:
        """The record of a run, with its frames."""
        measured = self.measured(run)
        (k,) = self.box.lateral
        lateral = 0.5 * run.observed["reactions"][:, 2 * k : 2 * k + 2].sum(axis=1)
        strain, top = measured["strain"], measured["top_force"]
        frames = [self._frame(run, i, strain[step - 1], top[step - 1]) for i, step in enumerate(run.steps) if step > 0]
        return BiaxialRecord(**measured, lateral=lateral, frames=frames, axis=AXES[self.axis])

    def _frame(self, run: Run, k: int, strain: float, top_force: float) -> Frame:
        net, positions = run.interactions(k), run.positions[k]
        acting = net.force[:, 0] != 0.0
        antagonist, candidate = net.antagonist[acting], net.candidate[acting]
        count = len(self.box.particles)
        at_wall = (antagonist >= count)[:, None]
        start = np.where(at_wall, positions[candidate] + net.lever[acting, 0], positions[antagonist])
        return Frame(
            strain=float(strain),
            top_force=float(top_force),
            positions=positions[:count],
            walls=np.array([positions[wall.id][axis] for axis, pair in enumerate(self.box.walls) for wall in pair]),
            lines=np.stack([start, positions[candidate]], axis=1),
            forces=net.force[acting, 0],
            in_wire=np.zeros(int(acting.sum()), dtype=bool) if self.law is None else net.law[acting] == self.law.NAME,
        )
