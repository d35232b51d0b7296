"""A rectangular box of four walls around a 2D sample: platens below and above, lateral walls left and right."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from lmgcpy.laws import Law
from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.scene.body import Disk, Wall, disk, wall
from lmgcpy.scene.material import Material
from lmgcpy.scene.scene import Scene

if TYPE_CHECKING:
    from lmgcpy.dynamics.simulation import Simulation

GRAIN, PLATEN, LATERAL = "GRAIN", "PLATEN", "LATERAL"


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

    def reactions(self, sim: Simulation) -> dict[str, float]:
        """Normal force with which the particles push each wall outward in the last step [N]."""
        net = sim.interactions
        named = {"bottom": self.bottom, "top": self.top, "left": self.left, "right": self.right}
        return {name: float(net.force[net.antagonist == body.id, 0].sum()) for name, body in named.items()}

    def sample(self, before: Sample) -> Sample:
        """The sample as it is now, moved so that its box starts at the origin."""
        origin = np.array([self.left.position[0], self.bottom.position[1]])
        positions = np.array([particle.position for particle in self.particles]) - origin
        return Sample(positions, before.radii, before.bead_count, before.reference_gap, self.width, self.height)


def characteristic_time(diameter: float, density: float, pressure: float) -> float:
    """``d sqrt(rho/p)``: the time in which the pressure moves a grain by its size [s]."""
    return float(diameter * np.sqrt(density / pressure))
