"""Pictures of the 2D samples of mechanical tests: particles, wire, force chains (figures 3 and 4 of the paper).

A test keeps particles and forces of some steps and no scene, so that its drawings are made here and not by
:func:`lmgcpy.view.compose.compose`. Colours, forces and everything after the drawing are the same.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from lmgcpy.view.boundary import edges
from lmgcpy.view.compose import PALE, Panel, force_tubes
from lmgcpy.view.drawing import BEAD, SAND, WIRE, Balls, Drawing, Paint, Tubes, in_space
from lmgcpy.view.film import Film
from lmgcpy.view.pictures import write_film
from lmgcpy.view.style import Camera

SIZE = (700, 700)
"""Largest size of a panel [pixels]. Two panels are read at 60 % of it, on a page or a screen."""

THIN = 0.12
"""Radius of a wire in radii of its beads, so that the beads are seen behind it."""


class ForceFrame(Protocol):
    """Particles and forces of a 2D test after a step; n particles, m forces."""

    @property
    def strain(self) -> float:
        """Crushing, as part of the height at the start."""
        ...

    @property
    def top_force(self) -> float:
        """Force on the upper platen [N]."""
        ...

    @property
    def positions(self) -> np.ndarray:
        """Positions of the particles [m], (n, 2)."""

    @property
    def walls(self) -> np.ndarray:
        """Left, right, bottom and top wall [m], (4,)."""

    @property
    def lines(self) -> np.ndarray:
        """Ends of the lines along which the forces act [m], (m, 2, 2)."""

    @property
    def forces(self) -> np.ndarray:
        """Normal forces, compression positive [N], (m,)."""

    @property
    def in_wire(self) -> np.ndarray:
        """Whether a force acts in a link, (m,) bool."""


class ParticleSample(Protocol):
    """A 2D sample in a box that starts at the origin; the first of its n particles are the beads."""

    @property
    def positions(self) -> np.ndarray:
        """Positions of the particles [m], (n, 2)."""

    @property
    def radii(self) -> np.ndarray:
        """Radii of the particles [m], (n,)."""

    @property
    def bead_count(self) -> int:
        """Number of beads."""
        ...

    @property
    def chains(self) -> Sequence[np.ndarray]:
        """Beads of each wire, as indices of ``positions``."""
        ...

    @property
    def box(self) -> np.ndarray:
        """Width and height of the box [m], (2,)."""


def draw_chains(
    path: str | os.PathLike,
    left: tuple[str, ForceFrame],
    right: tuple[str, ForceFrame],
    radii: np.ndarray,
    bead_count: int,
    *,
    size: tuple[int, int] = SIZE,
) -> Path:
    """Draw two frames with their forces side by side, at one scale of forces, into a PNG file (fig. 4).

    Each frame comes with its name. ``radii`` [m], (n,); the first ``bead_count`` particles are beads.
    """
    panels = [
        _panel(
            chains_drawing(frame, radii, bead_count),
            f"{name} at {100.0 * frame.strain:.1f} % crushing, {1e-3 * frame.top_force:.0f} kN/m on top",
        )
        for name, frame in (left, right)
    ]
    return write_film(Film(panels, size=size), Path(path))


def draw_sample(path: str | os.PathLike, sample: ParticleSample, *, size: tuple[int, int] = SIZE) -> Path:
    """Draw a sample into a PNG file, its wires through the beads."""
    title = f"{len(sample.radii)} particles, {sample.bead_count} of them beads of the wire"
    return write_film(Film([_panel(sample_drawing(sample), title)], size=size), Path(path))


def chains_drawing(frame: ForceFrame, radii: np.ndarray, bead_count: int) -> Drawing:
    """Pale particles below the forces of a frame."""
    legend: list[tuple[str, str]] = []
    ends = in_space(frame.lines)
    return Drawing(
        flat=True,
        balls=_particles(frame.positions, radii, bead_count, PALE),
        tubes=force_tubes(ends[:, 0], ends[:, 1], frame.forces, frame.in_wire, legend),
        grain=_mean_grain_radius(radii, bead_count),
        legend=legend,
        **_box(*frame.walls),
    )


def sample_drawing(sample: ParticleSample) -> Drawing:
    """Particles of a sample, and its wires."""
    points = in_space(sample.positions)
    a = np.concatenate([np.zeros(0, np.int64), *(chain[:-1] for chain in sample.chains)])
    b = np.concatenate([np.zeros(0, np.int64), *(chain[1:] for chain in sample.chains)])
    thickness = THIN * np.minimum(sample.radii[a], sample.radii[b])
    return Drawing(
        flat=True,
        balls=_particles(sample.positions, sample.radii, sample.bead_count, 1.0),
        tubes=[Tubes(points[a], points[b], thickness, Paint(WIRE))] if len(a) else [],
        grain=_mean_grain_radius(sample.radii, sample.bead_count),
        **_box(0.0, float(sample.box[0]), 0.0, float(sample.box[1])),
    )


def _panel(drawing: Drawing, title: str) -> Panel:
    camera = Camera.looking((0.0, 0.0, 1.0))
    return Panel([lambda: drawing], camera, dimension=2, title=title, shows_forces=True)


def _particles(positions: np.ndarray, radii: np.ndarray, bead_count: int, opacity: float) -> list[Balls]:
    everything = Balls(in_space(positions), np.asarray(radii), Paint(SAND), opacity, rim=True)
    bead = np.arange(len(positions)) < bead_count
    beads = Balls(everything.centres, everything.radii, Paint(BEAD), opacity, rim=True)
    return [everything.take(~bead), beads.take(bead)]


def _mean_grain_radius(radii: np.ndarray, bead_count: int) -> float:
    """Mean radius of the grains [m]; mean radius of the beads if there are no grains."""
    grains = radii[bead_count:]
    return float(np.mean(grains if len(grains) else radii))


def _box(left: float, right: float, bottom: float, top: float) -> dict[str, Any]:
    """Fields of a drawing that show the four walls."""
    corners = in_space(np.array([[left, bottom], [right, bottom], [right, top], [left, top]]))
    walls = list(np.stack([corners, np.roll(corners, -1, axis=0)], axis=1))
    return {"walls": walls, "lines": edges(walls)}
