"""The parts of a column: sand in a square mould, a wire in layers across its height, and the ground below."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.errors import flag, named_arguments, number, whole
from lmgcpy.experiment.box import Sample
from lmgcpy.experiment.thread_course import along, thread_nodes
from lmgcpy.sample import bead_count, deposit, grading, wire_3d
from lmgcpy.sample.wires import DTEX

SAND_DENSITY = 2600.0
"""Density of the grains [kg/m^3]."""
THREAD_DENSITY = 1380.0
"""Density of the thread, polyester [kg/m^3]."""
SOLID_FRACTION = 0.6
"""Solid fraction of poured sand; it sizes the mould and defines the volume of sand to which the wire content refers."""
SPREAD = 0.2
"""Diameters of the grains are uniform between 1 - SPREAD and 1 + SPREAD times their mean: enough for disorder."""
SPACING = 0.5
"""Distance between the centres of two beads, in mean grain diameters: a link deviates by 1 % of a grain's diameter from
the arc around the grain that it replaces."""
GROUND_COVER = 0.8
"""Part of the ground that the glued grains cover."""


@dataclass(frozen=True)
class Mould:
    """A square mould, open above; its sand comes up to ``height``."""

    side: float
    """Side of its ground [m]."""
    height: float
    """Height of the sand at ``SOLID_FRACTION`` [m]."""

    @classmethod
    def of(cls, grain_volume: float, aspect: float) -> Mould:
        """The mould for grains of this volume [m^3] with an ``aspect`` height / radius."""
        volume = grain_volume / SOLID_FRACTION
        side = (volume * math.sqrt(math.pi) / aspect) ** (1.0 / 3.0)
        return cls(side, volume / side**2)

    @property
    def radius(self) -> float:
        """Radius of a circle of the same area [m]: the radius of the column."""
        return self.side / math.sqrt(math.pi)

    @property
    def axis(self) -> np.ndarray:
        """Middle of its ground (x, y) [m]."""
        return np.full(2, 0.5 * self.side)

    @property
    def volume(self) -> float:
        """Volume of the sand in it [m^3]."""
        return self.side**2 * self.height


@dataclass(frozen=True)
class Laid:
    """A column before it settles."""

    mould: Mould
    """The mould in which it lies."""
    sample: Sample
    """The particles, beads first; the box reaches to the highest grain."""
    diameter: float
    """Mean diameter of the grains [m]."""
    bead_radius: float
    """Radius of the beads, or of the thread [m], also without a wire: it sets the time step."""
    wire_length: float
    """Length of the wire as laid [m]."""
    wire_cut: bool
    """Whether the wire ended before its length was laid, as no space was left."""

    @property
    def content(self) -> float:
        """Wire content as laid: length times the mean grain diameter squared, over the volume of the sand [-]."""
        return self.wire_length * self.diameter**2 / self.mould.volume

    @property
    def linear_density(self) -> float:
        """Linear density of the wire [dtex]; 0 without one."""
        return math.pi * self.bead_radius**2 * THREAD_DENSITY / DTEX if self.sample.wires else 0.0

    @property
    def content_by_weight(self) -> float:
        """Mass of the wire over the mass of the sand [-]."""
        sand = SAND_DENSITY * 4.0 / 3.0 * math.pi * float(np.sum(self.sample.radii[self.sample.bead_count :] ** 3))
        return self.linear_density * DTEX * self.wire_length / sand

    def __repr__(self) -> str:
        return f"<Laid column of content {self.content:.3g}: {self.sample!r}>"


@named_arguments
def lay_column(
    *,
    grain_count: int = 1000,
    content: float = 0.0,
    aspect: float = 2.0,
    diameter: float = 5e-4,
    bead_diameter: float = 0.3,
    seed: int = 0,
    thread: bool = False,
    node_distance: float = 0.7,
) -> Laid:
    """Lay one wire from below upward in a square mould and deposit the grains around it; not yet settled.

    ``content`` of wire: its length times the mean grain ``diameter`` [m] squared, over the volume of the sand. ``aspect``:
    height of the sand over the radius of the circle that has the mould's area. ``bead_diameter`` in mean grain diameters.
    The grains and the mould do not depend on the content. The wire reaches up to the surface: it is laid twice, the
    second time as high as the deposit around the first one came. With ``thread`` it is smooth, see :class:`lmgcpy.Thread`,
    as thick as the beads whose course it follows, and has nodes at most ``node_distance`` mean grain diameters apart.

    Raises ValueError if the wire is too short to reach from the ground to the surface; a wire that finds no space for
    all its length is cut.
    """
    whole(grain_count, "grains", minimum=10)
    number(content, "content", minimum=0.0, maximum=10.0)
    number(aspect, "aspect", minimum=0.1, maximum=20.0)
    number(diameter, "diameter", above=0.0, unit="m")
    number(bead_diameter, "bead_diameter", minimum=0.05, maximum=0.45)  # beads further apart than their diameter
    whole(seed, "seed")
    flag(thread, "thread")
    number(node_distance, "node_distance", above=0.0)
    radii = sand(grain_count, diameter, seed)
    mould = Mould.of(4.0 / 3.0 * math.pi * float(np.sum(radii**3)), aspect)
    bead_radius, spacing = 0.5 * bead_diameter * diameter, SPACING * diameter
    interstice = spacing - 2.0 * bead_radius
    gaps: Any = interstice
    height, nodes, wire = mould.height, np.empty((0, 3)), None
    if content > 0.0:
        count = bead_count(length=content * mould.volume / diameter**2, spacing=spacing)
        if (count - 1) * spacing < 2.0 * height:
            raise ValueError(
                f"A wire content of {content:g} is too little for a column of {grain_count} grains: its {count - 1} links "
                f"are no longer than {(count - 1) * spacing / height:.1f} times its height. Take more wire or more grains."
            )
        for _ in range(2):
            wire = wire_3d(
                box=(mould.side, mould.side, height),
                bead_radius=bead_radius,
                interstice=interstice,
                bead_count=count,
                seed=seed,
            )
            nodes = course = wire.positions
            if thread:
                inside, apart = (mould.side, mould.side, height), node_distance * diameter
                (nodes,), gaps = thread_nodes(
                    [course], spacing=spacing, node_distance=apart, radius=bead_radius, box=inside
                )
                course = along(nodes, bead_radius)
            obstacles = (course, np.full(len(course), bead_radius))
            grains = deposit(radii, box=(mould.side, mould.side, None), obstacles=obstacles, seed=seed)
            height = float((grains[:, 2] + radii).max()) - 0.5 * diameter
    else:
        grains = deposit(radii, box=(mould.side, mould.side, None), seed=seed)
    top = float((grains[:, 2] + radii).max())
    box = np.array([mould.side, mould.side, top])
    if wire is None:
        return Laid(mould, Sample(grains, radii, (), interstice, box), diameter, bead_radius, 0.0, False)
    # a bead has the mass of a link; a node bears its part of the whole thread
    length = wire.length / len(nodes) if thread else spacing
    sample = Sample(
        positions=np.vstack([nodes, grains]),
        radii=np.concatenate([np.full(len(nodes), bead_radius), radii]),
        wires=(len(nodes),),
        reference_gap=gaps,
        box=box,
        bead_mass=math.pi * bead_radius**2 * THREAD_DENSITY * length,
        thread=thread,
    )
    return Laid(mould, sample, diameter, bead_radius, wire.length, wire.cut)


def sand(grain_count: int, diameter: float, seed: int) -> np.ndarray:
    """Radii of the grains [m], (n,)."""
    mean = 0.5 * diameter
    return grading(grain_count, minimum=(1.0 - SPREAD) * mean, maximum=(1.0 + SPREAD) * mean, dimension=3, seed=seed)


def glued_grains(mould: Mould, reach: float, diameter: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A rough ground: a layer of the sand's grains that are stuck to it, their tops at z = 0, around the mould's axis.

    Returns centres [m], (n, 3), and radii [m], (n,), of the grains within ``reach`` [m] of the axis.
    """
    mean_section = 0.25 * math.pi * diameter**2 * (1.0 + SPREAD**2 / 3.0)
    radii = sand(max(1, round(GROUND_COVER * (2.0 * reach) ** 2 / mean_section)), diameter, seed)
    places = deposit(radii, box=(2.0 * reach, None), seed=seed)
    inside = np.linalg.norm(places - reach, axis=1) <= reach
    radii = radii[inside]
    return np.column_stack([places[inside] - reach + mould.axis, -radii]), radii
