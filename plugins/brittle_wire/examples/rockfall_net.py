"""A rock falls into a net whose wires break: what the net absorbs, and what its links have taken one by one.

Prints a table and writes rockfall_net.png into the folder given (default: here).
"""

from __future__ import annotations

import sys
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from lmgcpy_law_brittle_wire import BrittleWire

import lmgcpy as lm

SIDE, MESH, WIRE = 4.0, 0.25, 0.005
"""Side of the net, width of its meshes, radius of its wires [m]."""
RADIUS, MASS = 0.4, 500.0
"""Of the rock [m], [kg]."""
RIGIDITY, STRENGTH = 2e6, 2e4
"""EA of the wires [N], and the tension at which they break [N]."""
SPEEDS = (4.0, 8.0, 16.0)
"""With which the rock meets the net [m/s]."""


@dataclass
class Fall:
    """What one rock did."""

    speed: float
    sim: lm.Simulation
    broken: int
    """Number of broken links."""
    released: float
    """Work of the wires less the energy that they store [J]: what breaking links let go, their own ``F^2/2k`` and the
    energy of all links of their row, which fly apart, and what a step takes of vibrations that it does not resolve."""
    stored: float
    """In the whole links at the end [J]."""
    lost: float
    """Work of friction and of the blows between rock, wires and nodes [J]."""
    taken: float
    """Kinetic energy of the rock at first, plus the work of gravity, less the kinetic energy of all at the end [J]."""

    @property
    def stopped(self) -> bool:
        """Whether the net holds the rock."""
        return bool(self.sim.velocities[-1, 2] >= 0.0)


def fall(speed: float, time_step: float = 2e-4, duration: float = 0.4) -> Fall:
    """Let a rock fall into the middle of the net, until it is stopped, is through, or the time is over."""
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -9.81))
    made = lm.sample.net(size=(SIDE, SIDE), mesh=MESH)
    mass = 2.0 * MESH * np.pi * WIRE**2 * 7850.0
    nodes = [scene.add(lm.point_mass(position=x, mass=mass)) for x in made.positions]
    for node, rim in zip(nodes, made.rim, strict=True):
        if rim:
            node.fix()
    law = BrittleWire(axial_rigidity=RIGIDITY, strength=STRENGTH)
    scene.net(nodes, made.cells, law, surface=lm.Thread(WIRE))
    # a little off the middle, so that it does not fall on a node
    place = (0.5 * SIDE + 0.3 * MESH, 0.5 * SIDE + 0.2 * MESH, RADIUS + 2.0 * WIRE)
    rock = scene.add(lm.sphere(radius=RADIUS, position=place, mass=MASS, velocity=(0.0, 0.0, -speed)))
    scene.see("GRAIN", "THREAD", lm.Coulomb(friction=0.4))
    sim = lm.Simulation(scene, time_step=time_step, solver=lm.Auto(tolerance=1e-6))
    start, work = 0.5 * MASS * speed**2, 0.0
    while sim.time < duration and rock.velocity[2] < 0.0 and rock.position[2] > -0.5 * SIDE:
        sim.step()
        work += sim.energy.loads
    net, energy = sim.interactions, sim.energy
    state = net.state["broken"][net.law == "brittle-wire"]
    stored = energy.stored.get("brittle-wire", 0.0)
    total = energy.total_interactions
    return Fall(
        speed,
        sim,
        broken=int(np.nansum(state)),
        released=-total["brittle-wire"] - stored,
        stored=stored,
        lost=-total["coulomb"],
        taken=start + work - energy.kinetic,
    )


def main(folder: Path) -> None:
    """The table and the picture."""
    row = 0.5 * STRENGTH**2 / RIGIDITY * SIDE
    print(f"A link breaks with {row * MESH / SIDE:.0f} J, a row of the net at its strength stores {row:.0f} J.")
    print("speed [m/s]  rock [kJ]  net took [kJ]  broken  released [kJ]  stored [kJ]  blows, friction [kJ]")
    falls = [fall(speed) for speed in SPEEDS]
    for one in falls:
        energies = (0.5 * MASS * one.speed**2, one.taken, one.released, one.stored, one.lost)
        rock, taken, released, stored, lost = (1e-3 * energy for energy in energies)
        told = f"{one.speed:11.1f} {rock:10.2f} {taken:14.2f} {one.broken:7d} {released:14.2f} {stored:12.2f} {lost:21.2f}"
        print(told, "  held" if one.stopped else "  through")
    lm.view.render(falls[0].sim, folder / "rockfall_net.png", wires="tension")


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # broken ends fly by more than the thickness of a wire in a step
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
