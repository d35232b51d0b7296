"""A vertical cut in a column of grains: it runs out without cohesion, falls in lumps with some, and stands with more.

Prints a table and writes cohesive.png into the folder given (default: here).
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from lmgcpy_law_cohesive import Cohesive
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure

import lmgcpy as lm

WIDTH, COUNT, DENSITY, GRAVITY, FRICTION = 0.2, 400, 2600.0, 9.81, 0.4
ADHESIONS = (0.0, 40.0, 100.0)
"""Of the contacts [N per metre of depth]."""


def column(radii: np.ndarray, positions: np.ndarray, law: lm.Law, *, cut: bool) -> lm.Simulation:
    """Grains between two walls, or with the right one taken away."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -GRAVITY))
    sand = lm.Material("sand", density=DENSITY)
    for radius, position in zip(radii, positions, strict=True):
        scene.add(lm.disk(radius=radius, position=position, material=sand))
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0, 1)))
    scene.add(lm.wall(point=(0.0, 0.0), normal=(1, 0)))
    if not cut:
        scene.add(lm.wall(point=(WIDTH, 0.0), normal=(-1, 0)))
    scene.see("GRAIN", "GRAIN", law)
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=FRICTION))
    solver = lm.AcceleratedGaussSeidel(tolerance=1e-2, max_iterations=20_000)
    return lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore")


@dataclass
class Cut:
    """A column after its wall was taken away."""

    adhesion: float
    radii: np.ndarray
    start: np.ndarray
    sim: lm.Simulation

    @property
    def toe(self) -> float:
        """How far the foot has come out [m]."""
        return float((self.sim.positions[: len(self.radii), 0] + self.radii).max()) - WIDTH

    @property
    def bonds(self) -> np.ndarray:
        """Ends of the bonds that hold anything [m], (bonds, 2, 2)."""
        net = self.sim.interactions
        held = (net.state["bonded"] == 1.0) & (self.adhesion > 0.0)
        return np.stack([self.sim.positions[net.candidate[held]], self.sim.positions[net.antagonist[held]]], axis=1)


def study(count: int = COUNT, steps: int = 600, adhesions: tuple[float, ...] = ADHESIONS) -> list[Cut]:
    """Deposit, settle between the walls, and take one away, once for each adhesion."""
    radii = lm.sample.grading(count, minimum=0.005, maximum=0.008, by="diameter", seed=2)
    laid = lm.sample.deposit(radii, box=(WIDTH, None), seed=2)
    settled = column(radii, laid, lm.Coulomb(friction=0.2), cut=False).run(steps=1500)
    start = settled.positions[:count].copy()
    cuts = []
    for adhesion in adhesions:
        law = Cohesive(adhesion=adhesion, friction=FRICTION, reach=2e-4)
        cuts.append(Cut(adhesion, radii, start, column(radii, start, law, cut=True).run(steps=steps)))
    return cuts


def estimate(cut: Cut) -> float:
    """Adhesion [N] at which the column should just stand, for the order of magnitude.

    Rumpf: contacts of coordination Z and force c make an isotropic disk packing of solid fraction phi as strong in
    tension as phi Z c/(pi d). With the friction of the contacts for that of the packing, the cohesion is tan times
    that, and a vertical cut stands up to the height H = 4 cohesion/(rho phi g) tan(45 deg + angle/2).
    """
    d = 2.0 * float(cut.radii.mean())
    height = float((cut.start[:, 1] + cut.radii).max())
    fraction = math.pi * float((cut.radii**2).sum()) / (WIDTH * height)
    coordination = 4.0
    angle = math.atan(FRICTION)
    cohesion = height * DENSITY * fraction * GRAVITY / (4.0 * math.tan(math.pi / 4.0 + angle / 2.0))
    return cohesion / FRICTION * math.pi * d / (fraction * coordination)


def table(cuts: list[Cut]) -> str:
    """One line a column."""
    lines = [f"it should stand from about {estimate(cuts[0]):.0f} N on"]
    lines += ["adhesion [N]   foot out by [mm]   bonds left   steps not solved to 1 %"]
    for cut in cuts:
        lines.append(f"{cut.adhesion:9.0f} {1e3 * cut.toe:17.1f} {len(cut.bonds):13d} {cut.sim.unconverged_steps:16d}")
    return "\n".join(lines)


def figure(cuts: list[Cut]) -> Figure:
    """The columns side by side, their bonds as lines."""
    page = Figure(figsize=(12.0, 2.5), layout="constrained")
    for axes, cut in zip(page.subplots(1, len(cuts), sharey=True), cuts, strict=True):
        count, size = len(cut.radii), 2.0 * cut.radii
        grains = {"units": "x", "offset_transform": axes.transData}
        positions = cut.sim.positions[:count]
        axes.add_collection(
            EllipseCollection(size, size, np.zeros(count), offsets=positions, facecolors="#d9cba3", **grains)
        )
        axes.add_collection(LineCollection(list(cut.bonds), colors="#b2182b", linewidths=0.9))
        axes.plot([0.0, 0.0, 0.8], [0.4, 0.0, 0.0], color="black", linewidth=1.2)
        axes.plot([WIDTH, WIDTH], [0.0, 0.37], color="grey", linewidth=0.6, linestyle=":")
        axes.set_title(f"adhesion {cut.adhesion:g} N: {len(cut.bonds)} bonds after {cut.sim.time:.1f} s", fontsize="medium")
        axes.set_aspect("equal")
        axes.set_xlim(-0.02, 0.8)
        axes.set_ylim(-0.01, 0.41)
        axes.set_axis_off()
    return page


if __name__ == "__main__":
    found = study()
    print(table(found))
    figure(found).savefig(Path(sys.argv[1] if len(sys.argv) > 1 else ".") / "cohesive.png", dpi=110)
