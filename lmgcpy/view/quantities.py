"""Quantities of bodies and of links that colours show: values, units and colour maps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lmgcpy.view.snapshot import Forces, Snapshot

Limits = tuple[float, float]

LAYERS = 12
"""Number of bands of colour for layers."""


@dataclass(frozen=True)
class Quantity:
    """A quantity and its colours. The ``scale`` goes from the smallest to the largest value ("range"), starts at 0
    ("zero"), or reaches as far to both sides of 0 ("both"). ``bands`` is the number of colours, 0 for a smooth scale.
    ``outliers`` is the part of the values that may lie beyond the ends of the scale; they have the colour of the end."""

    label: str
    colormap: str
    scale: str = "range"
    bands: int = 0
    outliers: float = 0.0

    def limits(self, values: np.ndarray) -> Limits:
        """Ends of the colour scale for these values."""
        if not len(values):
            return 0.0, 0.0
        if self.scale == "range":
            return float(values.min()), float(values.max())
        high = float(np.quantile(np.abs(values), 1.0 - self.outliers))
        return (-high if self.scale == "both" else 0.0), high

    def colors(self, values: np.ndarray, limits: Limits) -> np.ndarray:
        """RGB of each value, (k, 3) uint8."""
        low, high = limits
        share = (values - low) / (high - low) if high > low else np.zeros(len(values))
        return (255.0 * self.map()(np.clip(share, 0.0, 1.0))[:, :3] + 0.5).astype(np.uint8)

    def map(self):
        """The matplotlib colour map."""
        from matplotlib import colormaps

        whole = colormaps[self.colormap]
        return whole.resampled(self.bands) if self.bands else whole


SPEED = Quantity("speed [m/s]", "viridis", "zero", outliers=0.01)
SPIN = Quantity("spin [rad/s]", "coolwarm", "both", outliers=0.01)
SPIN_IN_SPACE = Quantity("spin [rad/s]", "viridis", "zero", outliers=0.01)
ROTATION = Quantity("angle turned [rad]", "coolwarm", "both", outliers=0.01)
COORDINATION = Quantity("contacts that push", "YlGnBu", "zero")
RADIUS = Quantity("radius [m]", "cividis")
LAYER = Quantity("height at the start [m]", "Spectral_r", "range", LAYERS)
LENGTH = Quantity("length of wire [m]", "plasma", "zero")
TENSION = {2: Quantity("tension [N/m]", "plasma", "zero"), 3: Quantity("tension [N]", "plasma", "zero")}


def speed(snap: Snapshot) -> tuple[Quantity, np.ndarray]:
    """Speeds of the bodies [m/s], (n,)."""
    return SPEED, np.linalg.norm(snap.velocities, axis=1)


def spin(snap: Snapshot) -> tuple[Quantity, np.ndarray]:
    """Angular velocities [rad/s], in 3D their absolute values, (n,)."""
    if snap.dimension == 2:
        return SPIN, snap.spins
    return SPIN_IN_SPACE, np.linalg.norm(snap.spins, axis=1)


def rotation(snap: Snapshot) -> tuple[Quantity, np.ndarray]:
    """Angles turned since the start [rad], (n,); ValueError in 3D."""
    if snap.dimension == 3:
        raise ValueError("grains cannot be 'rotation' in 3D, where it is no angle: ask for 'spin'.")
    return ROTATION, snap.rotations - snap.scene["bodies"]["position"][:, 2]


def coordination(snap: Snapshot) -> tuple[Quantity, np.ndarray]:
    """Number of contacts of each body that push, walls included, (n,)."""
    forces = acting(snap, "grains='coordination'")
    contacts = slice(snap.link_count, None)
    pushing = forces.normal[contacts] > 0.0
    pairs = np.column_stack([forces.candidate, forces.antagonist])[contacts][pushing]
    return COORDINATION, np.bincount(pairs.ravel(), minlength=len(snap.positions)).astype(float)


def radius(snap: Snapshot) -> tuple[Quantity, np.ndarray]:
    """Radii of the circles that hold the bodies [m], (n,)."""
    return RADIUS, snap.scene["bodies"]["extent"]


def layer(snap: Snapshot) -> tuple[Quantity, np.ndarray]:
    """Heights of the bodies at the start [m], (n,)."""
    return LAYER, snap.start[:, -1]


GRAINS: dict[str, Callable[[Snapshot], tuple[Quantity, np.ndarray]]] = {
    "speed": speed,
    "spin": spin,
    "rotation": rotation,
    "coordination": coordination,
    "radius": radius,
    "layer": layer,
}
"""Quantities of bodies by their name."""


def arc_length(snap: Snapshot) -> tuple[Quantity, np.ndarray]:
    """Length of wire up to the middle of each link, chain by chain [m], (l,)."""
    courses = snap.courses
    lengths = [np.linalg.norm(np.diff(course, axis=0), axis=1) for course in courses]
    return LENGTH, np.concatenate([np.cumsum(length) - 0.5 * length for length in lengths] or [np.zeros(0)])


def tension(snap: Snapshot) -> tuple[Quantity, np.ndarray]:
    """Tensions of the links [N], zero where they push, (l,)."""
    return TENSION[snap.dimension], np.maximum(-acting(snap, "wires='tension'").link, 0.0)


def height_laid(snap: Snapshot) -> tuple[Quantity, np.ndarray]:
    """Heights of the middles of the links at the start [m], (l,)."""
    heights = [snap.start[chain.path, -1] for chain in snap.chains]
    return LAYER, np.concatenate([0.5 * (h[1:] + h[:-1]) for h in heights] or [np.zeros(0)])


WIRES: dict[str, Callable[[Snapshot], tuple[Quantity, np.ndarray]]] = {
    "length": arc_length,
    "tension": tension,
    "layer": height_laid,
}
"""Quantities of links by their name."""


def acting(snap: Snapshot, what: str) -> Forces:
    """The forces of a snapshot; ValueError if no step was made yet."""
    if snap.forces is None:
        raise ValueError(f"{what} shows the forces of a step, and none was made yet: run a Simulation of the scene first.")
    return snap.forces
