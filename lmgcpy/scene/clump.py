"""Clumps: rigid bodies of overlapping disks or spheres, with the mass of their union."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from lmgcpy.errors import named_arguments, number, numbers, shown, vector
from lmgcpy.scene.body import NO_CONDITIONS, RigidBody, StartRows, unit_quaternion
from lmgcpy.scene.contactor import Contactor, DiskContactor, SphereContactor
from lmgcpy.scene.many_bodies import of_each
from lmgcpy.scene.solid import Solid, ball_union, checked_balls, principal_axes

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


@dataclass(frozen=True)
class Clump:
    """The shape of a clump of n balls, from which bodies are made; :func:`lmgcpy.clump` finds it."""

    radii: np.ndarray
    """[m], (n,)."""
    offsets: np.ndarray
    """Centres of the balls from the centre of mass, along the axes of the body [m], (n, d)."""
    mass: float
    """[kg], per metre of depth in 2D."""
    inertia: Any
    """About the centre of mass [kg m^2]: a number in 2D, three about the axes of the body in 3D."""
    volume: float
    """Of the union [m^3], in 2D its area [m^2]."""
    centre: np.ndarray
    """Centre of mass in the coordinates in which the offsets were given [m], (d,)."""
    axes: Any = None
    """In 3D, the rotation (a scipy ``Rotation``) from the axes of the body, which are principal axes, to those of the
    offsets that were given."""

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.offsets.shape[1]

    @property
    def extent(self) -> float:
        """Radius of a circle or sphere around the centre of mass that holds the clump [m]."""
        return float((np.linalg.norm(self.offsets, axis=1) + self.radii).max())

    @named_arguments
    def at(
        self,
        position: Any,
        *,
        rotation: Any = None,
        scale: float = 1.0,
        color: str = "GRAIN",
        velocity: Any = None,
        spin: Any = None,
    ) -> RigidBody:
        """A body of this shape with its centre of mass at ``position`` [m].

        ``rotation`` turns the clump as it was given: an angle [rad], or in 3D a scipy ``Rotation`` or a unit quaternion.
        ``scale`` multiplies lengths. ``velocity`` [m/s] and ``spin`` [rad/s] are along the axes of space, by default at
        rest. (Conditions on ``spin_x`` … are about the own axes of the body, the columns of ``body.rotation.as_matrix()``.)
        """
        start = {name: given for name, given in (("velocity", velocity), ("spin", spin)) if given is not None}
        size = number(scale, "scale of a clump", above=0.0)
        position = vector(position, "position of a clump", self.dimension)
        if self.axes is not None:
            start["rotation"] = self.axes if rotation is None else as_rotation(rotation, "clump") * self.axes
        elif rotation is not None:
            start["rotation"] = rotation
        return RigidBody(
            self._contactors(size),
            mass=self.mass * size**self.dimension,
            inertia=self.inertia * size ** (self.dimension + 2),
            position=position,
            color=color,
            **start,
        )

    @named_arguments
    def point(self, place: Any, *, scale: float = 1.0) -> np.ndarray:
        """A ``place`` [m] in the coordinates of the offsets that were given, as the links of a body of this shape take it:
        from the centre of mass along the axes of the body, (d,); ``scale`` as of :meth:`at`."""
        away = vector(place, "place on a clump", self.dimension) - self.centre
        away = away if self.axes is None else self.axes.inv().apply(away)
        return number(scale, "scale of a clump", above=0.0) * away

    def _contactors(self, scale: float) -> list[tuple[Contactor, tuple[float, ...]]]:
        make = DiskContactor if self.dimension == 2 else SphereContactor
        sizes, offsets = (scale * self.radii).tolist(), (scale * self.offsets).tolist()
        return [(make(radius), tuple(offset)) for radius, offset in zip(sizes, offsets, strict=True)]

    def __repr__(self) -> str:
        kind = "disks" if self.dimension == 2 else "spheres"
        return f"<Clump of {len(self.radii)} {kind}: mass {self.mass:.4g} kg, extent {self.extent:.4g} m>"


def as_rotation(rotation: Any, what: str) -> Rotation:
    """A rotation in space from a scipy ``Rotation`` or a unit quaternion."""
    from scipy.spatial.transform import Rotation  # slow to import

    return Rotation.from_quat(unit_quaternion(rotation, what))


@named_arguments
def clump(radii: Any, offsets: Any, *, density: float, separate: bool = False) -> Clump:
    """The shape of a rigid clump of disks or spheres of ``radii`` [m], (n,), at ``offsets`` [m], (n, 2) or (n, 3).

    Mass, centre of mass and principal axes are those of the union, in which overlaps count once
    (``lmgcpy/scene/solid.py``); ``density`` in [kg/m^3]. ``Clump.at`` makes a body of it, and ``Scene.add_clumps``
    many. ``separate=True`` admits parts that do not touch each other.

    Raises TypeError or ValueError with a sentence for wrong radii or offsets, or if the parts do not touch.

    >>> import lmgcpy as lm
    >>> peanut = lm.clump([0.01, 0.01], [(0, 0, 0), (0.01, 0, 0)], density=2650)
    >>> round(peanut.mass, 5), peanut.centre.tolist()
    (0.01873, [0.005, 0.0, 0.0])
    >>> scene = lm.Scene(dimension=3, gravity=(0, 0, -9.81))
    >>> body = scene.add(peanut.at((0, 0, 0.1), rotation=(0, 0, 1, 0)))
    """
    given, at = checked_balls(radii, offsets, separate=separate)
    number(density, "density of a clump", above=0.0, unit="kg/m^3")
    return of_solid(given, at, ball_union(at, given), density)


def of_solid(radii: np.ndarray, offsets: np.ndarray, solid: Solid, density: float) -> Clump:
    """The clump of some balls with the mass and the inertia of a solid."""
    if not density * solid.volume > 0.0:
        raise ValueError(f"radii of a clump up to {radii.max():g} m leave it no mass: they are too small.")
    from_centre, axes, inertia = offsets - solid.centre, None, solid.inertia
    if offsets.shape[1] == 3:
        inertia, axes = principal_axes(np.asarray(solid.inertia))
        from_centre = axes.inv().apply(from_centre)
    return Clump(
        radii=radii,
        offsets=from_centre,
        mass=density * solid.volume,
        inertia=density * inertia,
        volume=solid.volume,
        centre=solid.centre,
        axes=axes,
    )


def make_clumps(
    shape: Any, positions: Any, *, rotations: Any, scales: Any, color: str, velocities: Any, spins: Any
) -> list[RigidBody]:
    """A body of a shape at each of the ``positions``; see :meth:`lmgcpy.Scene.add_clumps`."""
    if not isinstance(shape, Clump):
        raise TypeError(f"add_clumps takes a shape that lmgcpy.clump made, got {shown(shape)}.")
    d = shape.dimension
    place = numbers(positions, "positions of add_clumps", f"an array (n, {d}) [m]")
    if place.ndim != 2 or place.shape[1] != d:
        raise ValueError(f"positions of add_clumps must be of shape (n, {d}) [m], got {place.shape}.")
    count = len(place)
    turns = _of_each_rotation(rotations, shape, count)
    sizes = of_each(1.0 if scales is None else scales, "scales of add_clumps", (count,), "-")
    if not (sizes > 0.0).all():
        raise ValueError(f"scales of add_clumps must be above 0, got {sizes.min():g} in row {int(sizes.argmin())}.")
    if not isinstance(color, str) or not color:
        raise TypeError(f"color of add_clumps must be a word such as 'GRAIN', got {shown(color)}.")
    block = np.zeros((count, StartRows.WIDTH))
    block[:, :d], last = place, 3 + d
    block[:, 3:last] = of_each(velocities, "velocities of add_clumps", (count, d), "m/s")
    if d == 2:
        block[:, 2], block[:, last] = turns, of_each(spins, "spins of add_clumps", (count,), "rad/s")
    else:
        block[:, last : last + 3] = of_each(spins, "spins of add_clumps", (count, 3), "rad/s")
    made = [object.__new__(RigidBody) for _ in range(count)]
    contactors: dict[float, list] = {}  # bodies of one size share the list
    masses, powers = (shape.mass * sizes**d).tolist(), sizes ** (d + 2)
    for row, (body, size) in enumerate(zip(made, sizes.tolist(), strict=True)):
        if size not in contactors:
            contactors[size] = shape._contactors(size)
        body._block, body._row, body._state, body._id = block, row, None, -1
        body._color, body._hidden = color, False
        body._velocities = body._forces = NO_CONDITIONS
        inertia = shape.inertia * powers[row]
        vars(body).update(dimension=d, _contactors=contactors[size], _mass=masses[row], _inertia=inertia)
        if d == 3:
            body._quaternion = turns[row]
    return made


def _of_each_rotation(rotations: Any, shape: Clump, count: int) -> Any:
    """Angles or quaternions, one a body."""
    if shape.axes is None:
        return of_each(rotations, "rotations of add_clumps", (count,), "rad")
    if rotations is None:
        return np.tile(shape.axes.as_quat(), (count, 1))
    from scipy.spatial.transform import Rotation  # slow to import

    if not isinstance(rotations, Rotation):
        quaternions = of_each(rotations, "rotations of add_clumps", (count, 4), "-")
        lengths = np.linalg.norm(quaternions, axis=1)
        if not (np.abs(lengths - 1.0) < 1e-6).all():
            row = int(np.argmax(np.abs(lengths - 1.0)))
            raise ValueError(
                f"rotations of add_clumps must be quaternions of length one, got {shown(quaternions[row].tolist())} in row "
                f"{row}."
            )
        rotations = Rotation.from_quat(quaternions)
    turned = (rotations * shape.axes).as_quat()
    if turned.shape not in ((4,), (count, 4)):
        raise ValueError(f"rotations of add_clumps must be {count} or one, got {len(turned)}.")
    return np.broadcast_to(turned, (count, 4))

