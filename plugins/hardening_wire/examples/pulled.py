"""One link pulled slowly, and a heavy wire of 100 beads hanging under three loads, against the analytic curves.

Prints what differs and writes hardening_wire.png into the folder given (default: here).
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from lmgcpy_law_hardening_wire import HardeningWire, elongation, tension
from matplotlib.figure import Figure

import lmgcpy as lm

LAW = HardeningWire(axial_rigidity=1e4, toe_rigidity=200.0, crimp=0.02)
GRAVITY = 9.81
LENGTH, MASS = 1.0, 2.0
"""Of the wire [m], and per metre of depth [kg]."""
LOADS = (0.0, 50.0, 200.0)
"""Hung on the wire [N]."""


def pull(greatest: float = 500.0, steps: int = 500) -> np.ndarray:
    """Elongation [m] and tension [N] of one link of 1 m whose load grows slowly, (steps, 2)."""
    scene = lm.Scene(dimension=2)
    a, b = (scene.add(lm.disk(radius=0.01, position=(x, 0.0), mass=0.1)) for x in (0.0, LENGTH))
    a.fix()
    scene.chain([a, b], LAW)
    h = 0.02
    b.impose_force(x=lambda t: greatest * t / (steps * h))
    sim = lm.Simulation(scene, time_step=h, theta=1.0, solver=lm.GaussSeidel(tolerance=1e-12))
    points = []
    for _ in range(steps):
        sim.step()
        points.append((b.position[0] - LENGTH, -sim.interactions.force[0, 0]))
    return np.array(points)


def hang(beads: int, load: float, law: lm.Law = LAW, steps: int = 400) -> tuple[np.ndarray, np.ndarray]:
    """Place along the wire [m] and strain of each link of a hanging wire at rest, and its end loaded, (links,) each."""
    links = beads - 1
    length, mass = LENGTH / links, MASS / links
    scene = lm.Scene(dimension=2, gravity=(0.0, -GRAVITY))
    wire = [scene.add(lm.disk(radius=0.1 * length, position=(0.0, -length * i), mass=mass)) for i in range(beads)]
    wire[0].fix()
    wire[-1].impose_force(y=lambda t: -load * min(1.0, t))
    scene.chain(wire, law)
    sim = lm.Simulation(scene, time_step=0.01, solver=lm.GaussSeidel(tolerance=1e-9))
    sim.run(steps=steps)
    lengths = -np.diff(sim.positions[:, 1])
    return length * (np.arange(links) + 0.5), lengths / length - 1.0


def hang_at_rest(beads: int, load: float, law: HardeningWire = LAW) -> np.ndarray:
    """The same strains from the balance of forces, (links,): link i carries the beads below it."""
    links = beads - 1
    carried = load + GRAVITY * MASS / links * (links - np.arange(links))
    length = LENGTH / links
    parameters = law.table(np.array([length]))[0]
    return np.array([elongation(force, parameters) for force in carried]) / length


def figure(points: np.ndarray, wires: list[tuple[float, np.ndarray, np.ndarray]]) -> Figure:
    """Force against elongation of one link, and strain along the wires."""
    page = Figure(figsize=(11.0, 4.4), layout="constrained")
    left, right = page.subplots(1, 2)
    parameters = LAW.table(np.array([LENGTH]))[0]
    e = np.linspace(0.0, points[:, 0].max(), 200)
    slack = (1.0 - LAW.toe_rigidity / LAW.axial_rigidity) * LAW.crimp * LENGTH
    left.plot(1e3 * e, [tension(one, parameters) for one in e], color="#1b4f9c", label="T(e)")
    left.plot(1e3 * points[::20, 0], points[::20, 1], "o", color="#b2182b", markersize=3, label="one link, pulled")
    straight = LAW.axial_rigidity / LENGTH * np.maximum(e - slack, 0.0)
    left.plot(
        1e3 * e, straight, color="grey", linewidth=0.8, linestyle="--", label="fibres straight, longer by (1 - k0/k1) d"
    )
    left.plot(1e3 * e, LAW.toe_rigidity / LENGTH * e, color="grey", linewidth=0.8, linestyle=":", label="toe, k0 e")
    left.set_xlabel("elongation [mm]")
    left.set_ylabel("tension [N]")
    left.legend(frameon=False)
    for (load, place, strain), color in zip(wires, ("#8c6d31", "#35978f", "#762a83"), strict=True):
        right.plot(100 * strain, place, "o", color=color, markersize=2.5, label=f"loaded by {load:g} N")
        right.plot(100 * hang_at_rest(len(strain) + 1, load), place, color=color, linewidth=0.8)
    right.invert_yaxis()
    right.set_xlabel("strain [%]")
    right.set_ylabel("place along the wire, from its top [m]")
    right.set_title("a wire of 100 beads and 20 N, hanging", fontsize="medium")
    right.legend(frameon=False, loc=(0.55, 0.4))
    return page


def main(folder: Path) -> None:
    points = pull()
    parameters = LAW.table(np.array([LENGTH]))[0]
    curve = np.array([tension(e, parameters) for e in points[:, 0]])
    print(f"one link: off the curve by at most {np.abs(points[:, 1] - curve).max():.1g} of {curve.max():.0f} N")
    wires = []
    for load in LOADS:
        place, strain = hang(100, load)
        wires.append((load, place, strain))
        off = np.abs(strain - hang_at_rest(100, load)).max()
        few = hang(10, load)[1].mean()
        print(
            f"wire loaded by {load:3g} N: longer by {100 * strain.mean():.2f} % with 100 beads, {100 * few:.2f} % with 10; "
            f"strains off by at most {off:.0e}"
        )
    figure(points, wires).savefig(folder / "hardening_wire.png", dpi=110)


if __name__ == "__main__":
    main(Path(sys.argv[1] if len(sys.argv) > 1 else "."))
