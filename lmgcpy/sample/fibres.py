"""Short fibres and grains at random places in a box: a loose start without overlaps, for a compaction."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lmgcpy.contact.segments import feet, segment_distances
from lmgcpy.errors import named_arguments, number, shown, whole
from lmgcpy.laws.rigid import BallJoint
from lmgcpy.sample import arguments
from lmgcpy.scene.body_3d import Capsule, capsule, capsule_volume
from lmgcpy.scene.contactor import direction
from lmgcpy.scene.solid import Material

if TYPE_CHECKING:
    from lmgcpy.scene.chain import Chain
    from lmgcpy.scene.joint import Joint
    from lmgcpy.scene.scene import Scene

TRIES = 5000
"""Places that are tried for a fibre or a grain before the box is called full."""
MOST = 1000
"""Most segments of a fibre."""
QUARTER = 0.5 * math.pi
"""A quarter of a turn [rad]."""


@dataclass(frozen=True, eq=False, repr=False)
class Fibres:
    """Fibres, which are capsules, and grains among them, as :func:`lmgcpy.sample.fibres` lays them; m fibres, n grains."""

    positions: np.ndarray
    """Centres of the fibres [m], (m, 3)."""
    axes: np.ndarray
    """Unit vectors t along them, (m, 3)."""
    radius: float
    """Radius of a fibre [m]."""
    length: float
    """Distance between the centres of its ends [m]."""
    grains: np.ndarray
    """Centres of the grains [m], (n, 3), in the order of their radii."""
    content: float
    """Volume of the fibres over that of the grains: of as many whole fibres as come nearest to what was asked for."""

    @named_arguments
    def capsules(self, material: Material, *, segments: int = 1, color: str = "GRAIN") -> list[Capsule]:
        """The fibres as bodies, each in this number of ``segments`` of one length and mass, one after another from its
        lower end along t. :func:`join_segments` makes flexible fibres of them."""
        whole(segments, "segments of a fibre", minimum=1, maximum=MOST)
        if not isinstance(material, Material):
            raise TypeError(f"material of the fibres must be a lmgcpy.Material, got {shown(material)}.")
        mass = material.density * capsule_volume(self.radius, self.length) / segments
        places = (np.arange(segments) + 0.5) / segments - 0.5
        shape: dict[str, Any] = {"radius": self.radius, "length": self.length / segments, "color": color}
        shape |= {"material": material} if segments == 1 else {"mass": mass}
        return [
            capsule(position=x + part * self.length * t, axis=t, **shape)
            for x, t in zip(self.positions, self.axes, strict=True)
            for part in places
        ]

    def __repr__(self) -> str:
        of = f"{len(self.positions)} fibres of {self.length:.3g} m"
        return f"<Fibres: {of}, {100.0 * self.content:.3g} % of the volume of {len(self.grains)} grains>"


@named_arguments
def join_segments(scene: Scene, capsules: Sequence[Capsule], segments: int) -> list[Chain | Joint]:
    """Join ``capsules`` that were added to a ``scene``, one after another, to fibres of this number of ``segments``, by
    ball joints where the ends of their axes meet. The fibres bend freely; neighbours in a fibre do not collide."""
    from lmgcpy.scene.scene import Scene

    whole(segments, "segments of a fibre", minimum=1, maximum=MOST)
    if not isinstance(scene, Scene):
        raise TypeError(f"join_segments takes the scene that the capsules were added to, got {shown(scene)}.")
    if not isinstance(capsules, (list, tuple)) or not all(isinstance(one, Capsule) for one in capsules):
        raise TypeError(f"join_segments takes a list of capsules that were added to the scene, got {shown(capsules)}.")
    if len(capsules) % segments:
        raise ValueError(f"{len(capsules)} capsules make no whole fibres of {segments} segments: give all of each fibre.")
    law = BallJoint()
    joints: list[Chain | Joint] = []
    for k, (one, other) in enumerate(itertools.pairwise(capsules)):
        if (k + 1) % segments:
            ends = (0.0, 0.0, 0.5 * one.length), (0.0, 0.0, -0.5 * other.length)
            joints.append(scene.link(one, other, law, at=ends))
    return joints


@named_arguments
def fibres(
    radii: Any,
    *,
    content: float,
    radius: float,
    length: float,
    box: Any,
    orientation: Any = "random",
    spread: float | None = None,
    grain_volume: float | None = None,
    seed: Any = 0,
) -> Fibres:
    """Lay fibres and grains at random places in a closed box, without overlap.

    Random sequential addition: the fibres first, then the grains, the coarsest first, each at the first free one of places
    drawn evenly in the box. All distances are exact (between segments, and between points and segments). A fibre keeps the
    direction that was drawn for it, so that a crowded box or a wall does not change the distribution of directions.

    ``radii`` [m], (n,), of the grains. Of clumps they are the radii of the spheres around them (``scales * shape.extent``),
    and ``grain_volume`` [m^3] is the volume of all clumps together; by default it is that of the spheres.
    ``content``: volume of the fibres over that of the grains; a content by weight is this times the ratio of the densities.
    ``radius`` and ``length`` [m] of a fibre: a sphere swept along a segment, as in :func:`lmgcpy.capsule`.
    ``box``: its three lengths [m], from the origin.
    ``orientation`` of the fibres and their ``spread`` s [rad], from 0 to pi/2; t is a unit vector along a fibre:

    ============== =============================================================================== =======================
    "random"       all directions alike; takes no spread                                           <t (x) t> = I/3
    "horizontal"   directions evenly within an angle s, by default 0, of the plane of x and y      <t_z^2> = sin^2 s / 3
    (x, y, z)      directions evenly in a cone around this vector a, with the half angle s, by     <(t . a)^2> =
                   default 0                                                                       (1 + cos s + cos^2 s)/3
    ============== =============================================================================== =======================

    ``seed``: whatever ``numpy.random.default_rng`` takes. A box that is to be filled loosely has some four times the volume
    of the grains, more if fibres are many: each keeps grains out of the volume within a grain's radius around it. Raises
    ValueError if a fibre or a grain finds no place, and says how many did; ValueError or TypeError if an argument makes no
    sense.
    """
    sizes = arguments.radii(radii, least=0)
    lengths = np.array(arguments.box(box, dimensions=(3,), open_top=False))
    content = number(content, "content", minimum=0.0)
    radius = number(radius, "radius of the fibres", above=0.0, unit="m")
    length = number(length, "length of the fibres", above=0.0, unit="m")
    if grain_volume is None:
        solid = 4.0 / 3.0 * math.pi * float((sizes**3).sum())
    else:
        solid = number(grain_volume, "grain_volume", above=0.0, unit="m^3")
    if len(sizes):
        arguments.refuse_unfit(tuple(lengths), float(sizes.max()), "the coarsest grain")
    wanted = content * solid / capsule_volume(radius, length)
    if wanted * capsule_volume(radius, length) > float(np.prod(lengths)):
        raise ValueError(
            f"content is {content:g}: the fibres alone have a larger volume than the box. It is a volume over the volume "
            "of the grains, 0.01 for one per cent."
        )
    count = round(wanted)
    if content > 0.0 and count == 0:
        raise ValueError(
            f"content is {content:g}, which is {wanted:.2g} of a fibre among these grains: take a larger content, more "
            "grains, or thinner or shorter fibres."
        )
    rng = arguments.generator(seed)
    axes = _directions(count, orientation, spread, rng)
    room = lengths - length * np.abs(axes) - 2.0 * radius
    if (room < 0.0).any():
        axis = int(room.min(axis=0).argmin())
        raise ValueError(
            f"a fibre of length {length:g} m and radius {radius:g} m does not fit in the box, which is "
            f"{lengths[axis]:g} m wide along {'xyz'[axis]}: take a wider box, shorter fibres or another orientation."
        )
    centres, halves = np.empty((count, 3)), 0.5 * length * axes
    for k in range(count):
        for _ in range(TRIES):
            place = 0.5 * lengths + (rng.random(3) - 0.5) * room[k]
            if (segment_distances(place[None], halves[k, None], centres[:k], halves[:k]) >= 2.0 * radius).all():
                break
        else:
            raise ValueError(f"the box is full: {k} of {count} fibres found a place. Take a larger box or fewer fibres.")
        centres[k] = place
    grains = np.empty((len(sizes), 3))
    order = np.argsort(-sizes, kind="stable")
    for done, grain in enumerate(order):
        there = order[:done]
        near = (sizes[there] + sizes[grain]) ** 2
        for _ in range(TRIES):
            place = sizes[grain] + rng.random(3) * np.maximum(lengths - 2.0 * sizes[grain], 0.0)
            apart = grains[there] - place
            if (np.einsum("gd,gd->g", apart, apart) >= near).all() and (
                np.linalg.norm(place - feet(place, centres, halves), axis=1) >= radius + sizes[grain]
            ).all():
                break
        else:
            raise ValueError(
                f"the box is full: {done} of {len(sizes)} grains found a place among {count} fibres. Take a larger box, "
                "with at most 0.3 of it solid, less if there are many fibres."
            )
        grains[grain] = place
    return Fibres(centres, axes, radius, length, grains, count * capsule_volume(radius, length) / solid if count else 0.0)


def _directions(count: int, orientation: Any, spread: float | None, rng: np.random.Generator) -> np.ndarray:
    """Unit vectors, (count, 3), of the distributions that :func:`fibres` lists. All of them are even on a part of the
    sphere, on which the coordinate along an axis is even (Archimedes' hat-box theorem)."""
    wide = QUARTER if spread is None else number(spread, "spread", minimum=0.0, maximum=QUARTER, unit="rad")
    narrow = 0.0 if spread is None else wide
    if isinstance(orientation, str) and orientation == "random":
        if spread is not None:
            raise ValueError("orientation 'random' takes no spread: all directions are alike. Leave one of them out.")
        axis, low, high = np.array([0.0, 0.0, 1.0]), -1.0, 1.0
    elif isinstance(orientation, str) and orientation == "horizontal":
        axis, low, high = np.array([0.0, 0.0, 1.0]), -math.sin(narrow), math.sin(narrow)
    elif isinstance(orientation, str):
        raise ValueError(f"orientation must be 'random', 'horizontal' or a vector (x, y, z), got {shown(orientation)}.")
    else:
        axis, low, high = direction(orientation, "orientation of the fibres", 3), math.cos(narrow), 1.0
    along, around = rng.uniform(low, high, count), rng.uniform(0.0, 2.0 * math.pi, count)
    across = np.sqrt(np.maximum(1.0 - along**2, 0.0))
    # two vectors that complete the axis to a right-handed frame
    first = np.cross(axis, np.eye(3)[np.abs(axis).argmin()])
    first /= np.linalg.norm(first)
    second = np.cross(axis, first)
    t = along[:, None] * axis + (across * np.cos(around))[:, None] * first + (across * np.sin(around))[:, None] * second
    return t / np.linalg.norm(t, axis=1)[:, None]
