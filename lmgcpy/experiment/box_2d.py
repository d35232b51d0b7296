"""A rectangular box of four walls around a 2D sample: platens below and above, lateral walls left and right."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lmgcpy.errors import named_arguments, number, shown, whole
from lmgcpy.laws import Law
from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.sample.arguments import spheres
from lmgcpy.scene.body import Disk, Wall, disk, wall
from lmgcpy.scene.material import Material
from lmgcpy.scene.scene import Scene

if TYPE_CHECKING:
    from lmgcpy.dynamics.simulation import Simulation

GRAIN, PLATEN, LATERAL = "GRAIN", "PLATEN", "LATERAL"
WALLS = ("left", "right", "bottom", "top")


@named_arguments
@dataclass(frozen=True)
class Sample:
    """Particles in a box that starts at the origin; the first ``bead_count`` of them are the beads of a wire."""

    positions: np.ndarray
    """[m], (n, 2)."""
    radii: np.ndarray
    """[m], (n,)."""
    bead_count: int
    reference_gap: float
    """Greatest gap between consecutive beads [m]."""
    width: float
    height: float
    """Of the box [m]."""

    def __post_init__(self):
        positions, radii = spheres(self.positions, self.radii, 2, "the sample")
        object.__setattr__(self, "positions", positions)
        object.__setattr__(self, "radii", radii)
        whole(self.bead_count, "bead_count of the sample", maximum=len(radii))
        number(self.reference_gap, "reference_gap of the sample", unit="m")
        number(self.width, "width of the sample", above=0.0, unit="m")
        number(self.height, "height of the sample", above=0.0, unit="m")

    @property
    def diameter(self) -> float:
        """Mean diameter of the particles [m]."""
        return 2.0 * float(self.radii.mean())


class Box2D:
    """The scene of a sample in its box, without gravity; boundary conditions are the caller's.

    ``friction`` between particles, ``platen_friction`` at the platens; lateral walls are smooth. ``law`` links the beads
    of the wire, None leaves them grains like others; ``reference_gap``: "wire" takes the sample's, widened where a link
    is built longer, "built" the present gaps. The mass of a wall is a tenth of the sample's.
    """

    def __init__(
        self,
        sample: Sample,
        *,
        density: float,
        friction: float,
        platen_friction: float = 0.0,
        law: Law | None = None,
        reference_gap: str = "wire",
    ):
        if not isinstance(sample, Sample):
            raise TypeError(f"A box is for a Sample, such as lay_sample() makes, got {shown(sample)}.")
        self.scene = Scene(dimension=2)
        material = Material("sand", density=density)
        self.particles: list[Disk] = [
            self.scene.add(disk(radius=radius, position=position, material=material, color=GRAIN))
            for position, radius in zip(sample.positions, sample.radii, strict=True)
        ]
        self.mass = sum(particle.mass for particle in self.particles)
        share = 0.1 * self.mass
        add = self.scene.add
        self.bottom: Wall = add(wall(point=(0.0, 0.0), normal=(0, 1), color=PLATEN, mass=share))
        self.top: Wall = add(wall(point=(0.0, sample.height), normal=(0, -1), color=PLATEN, mass=share))
        self.left: Wall = add(wall(point=(0.0, 0.0), normal=(1, 0), color=LATERAL, mass=share))
        self.right: Wall = add(wall(point=(sample.width, 0.0), normal=(-1, 0), color=LATERAL, mass=share))
        self.scene.see(GRAIN, GRAIN, Coulomb(friction=friction))
        self.scene.see(GRAIN, PLATEN, Coulomb(friction=platen_friction))
        self.scene.see(GRAIN, LATERAL, Coulomb(friction=0.0))
        if law is not None:
            if sample.bead_count < 2:
                raise ValueError(f"A law links the beads of a wire, this sample has {sample.bead_count}: give law=None.")
            self._link(sample, law, reference_gap)

    def _link(self, sample: Sample, law: Law, reference_gap: str) -> None:
        beads = sample.positions[: sample.bead_count]
        radii = sample.radii[: sample.bead_count]
        built = np.linalg.norm(np.diff(beads, axis=0), axis=1) - radii[1:] - radii[:-1]
        # a relaxed wire is longer than its reference by what the solver's tolerance left
        reference = built if reference_gap == "built" else np.maximum(sample.reference_gap, built)
        self.scene.chain(self.particles[: sample.bead_count], law, reference_gap=reference)

    @property
    def width(self) -> float:
        """Present distance of the lateral walls [m]."""
        return float(self.right.position[0] - self.left.position[0])

    @property
    def height(self) -> float:
        """Present distance of the platens [m]."""
        return float(self.top.position[1] - self.bottom.position[1])

    def load_laterally(self, pressure: float) -> None:
        """Press the lateral walls inward by ``pressure`` [Pa] on their present height."""
        self.left.impose_force(x=lambda time: pressure * self.height)
        self.right.impose_force(x=lambda time: -pressure * self.height)

    def load_top(self, pressure: float) -> None:
        """Press the upper platen down by ``pressure`` [Pa] on its present width."""
        self.top.impose_force(y=lambda time: -pressure * self.width)

    def reactions(self, sim: Simulation) -> np.ndarray:
        """Normal force with which the particles push each of :data:`WALLS` outward in the last step [N], (4,)."""
        net = sim.interactions
        walls: list[Wall] = [getattr(self, name) for name in WALLS]
        return np.array([net.force[net.antagonist == wall.id, 0].sum() for wall in walls])

    def size(self, sim: Simulation) -> np.ndarray:
        """Present width and height [m], (2,)."""
        return np.array([self.width, self.height])

    def penetration(self, sim: Simulation) -> float:
        """Deepest overlap at a contact in the last step [m]."""
        net = sim.interactions
        return max(0.0, -float(net.gap[net.law == Coulomb.NAME].min(initial=0.0)))

    def sample(self, before: Sample) -> Sample:
        """The sample as it is now, moved so that its box starts at the origin."""
        origin = np.array([self.left.position[0], self.bottom.position[1]])
        positions = np.array([particle.position for particle in self.particles]) - origin
        return Sample(positions, before.radii, before.bead_count, before.reference_gap, self.width, self.height)


def characteristic_time(diameter: float, density: float, pressure: float) -> float:
    """``d sqrt(rho/p)``: the time in which the pressure moves a grain by its size [s]."""
    return float(diameter * np.sqrt(density / pressure))
