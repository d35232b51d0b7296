"""A TexSol sample that loses its wire: crushed without wire, with one that cannot break, and with two that can.

Prints a table and writes brittle_wire.png into the folder given (default: here).
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from lmgcpy_law_brittle_wire import BrittleWire
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure

import lmgcpy as lm
from lmgcpy.experiment import Biaxial, BiaxialRecord, Sample, compact, lay_sample

PRESSURE, DENSITY = 1e5, 2600.0
RIGIDITY = 1e6
"""EA of all wires [N per metre of depth]."""
STRENGTHS = (12e3, 4e3)
"""Of the wires that can break [N per metre of depth]."""


@dataclass
class Crushing:
    """One biaxial test and how its wire went."""

    name: str
    record: BiaxialRecord
    broken: np.ndarray
    """Links broken after each step, (s,)."""
    tension: np.ndarray
    """Greatest tension of the wire in each step [N], (s,)."""
    test: Biaxial


def crush(name: str, sample: Sample, law: lm.Law | None, strain: float) -> Crushing:
    """Crush the sample by ``strain`` of its height and count the links that break."""
    test = Biaxial(sample, law, pressure=PRESSURE, density=DENSITY, inertial_number=2e-3)
    broken, tension = [], []

    def count(done: int) -> None:
        net = test.simulation.interactions
        links = net.law != "coulomb"
        broken.append(np.nansum(net.state["broken"]) if "broken" in net.state else 0.0)
        tension.append(0.0 - net.force[links, 0].min(initial=0.0))

    record = test.run(strain, frames=0, on_step=count)
    return Crushing(name, record, np.array(broken), np.array(tension), test)


def study(grains: int = 1000, beads: int = 180, strain: float = 0.1, seed: int = 0) -> list[Crushing]:
    """The four tests, on one compacted sample."""
    sample = compact(lay_sample(grains, beads, seed=seed), pressure=PRESSURE, density=DENSITY).sample
    tests = [crush("no wire", sample, None, strain)]
    tests.append(crush("unbreakable", sample, lm.ElasticWire(axial_rigidity=RIGIDITY), strain))
    for strength in STRENGTHS:
        law = BrittleWire(axial_rigidity=RIGIDITY, strength=strength)
        tests.append(crush(f"breaks at {1e-3 * strength:g} kN", sample, law, strain))
    return tests


def table(tests: list[Crushing]) -> str:
    """One line a test."""
    lines = ["wire              mean reaction  last third  greatest tension  links broken   (kN per metre of depth)"]
    for one in tests:
        reaction, last = one.record.reaction, len(one.record.reaction) // 3
        lines.append(
            f"{one.name:16s} {1e-3 * reaction.mean():11.0f} {1e-3 * reaction[-last:].mean():12.0f} "
            f"{1e-3 * one.tension.max():13.1f} {one.broken[-1]:13.0f}"
        )
    return "\n".join(lines)


def figure(tests: list[Crushing]) -> Figure:
    """Reaction and broken links against crushing, and the sample with the weakest wire at the end."""
    page = Figure(figsize=(12.0, 5.6), layout="constrained")
    left, right = page.subfigures(1, 2)
    curves, links = left.subplots(2, 1, sharex=True, height_ratios=[2, 1])
    for one, color in zip(tests, ("#8c6d31", "#1b4f9c", "#35978f", "#b2182b"), strict=True):
        percent = 100.0 * one.record.strain
        curves.plot(percent, 1e-3 * one.record.smooth(one.record.reaction, 0.005), color=color, label=one.name)
        links.plot(percent, one.broken, color=color)
    curves.set_ylabel("support reaction [kN/m]")
    curves.legend(frameon=False)
    links.set_ylabel("links broken")
    links.set_xlabel("crushing [%]")
    draw_sample(right.subplots(), tests[-1])
    return page


def draw_sample(axes, one: Crushing) -> None:
    """The sample as it is now: whole links by their tension, broken ones in red between the beads they have left."""
    sim, beads = one.test.simulation, one.test.bead_count
    count = len(one.test.box.particles)
    positions = sim.positions[:count]
    size = 2.0 * np.array([particle.radius for particle in one.test.box.particles])
    colors = np.where(np.arange(count) < beads, "#9ab7dd", "#e6dcc3").tolist()
    axes.add_collection(
        EllipseCollection(
            size, size, np.zeros(count), units="x", offsets=positions, offset_transform=axes.transData, facecolors=colors
        )
    )
    net = sim.interactions
    wire = net.law == "brittle-wire"
    ends = np.stack([sim.positions[net.antagonist[wire]], sim.positions[net.candidate[wire]]], axis=1)
    broken = net.state["broken"][wire] == 1.0
    width = 0.8 + 3.0 * -net.force[wire, 0] / one.test.law.strength
    whole = LineCollection(list(ends[~broken]), colors="#1b4f9c", linewidths=width[~broken], capstyle="round")
    axes.add_collection(whole)
    axes.add_collection(LineCollection(list(ends[broken]), colors="#b2182b", linewidths=1.2, linestyles=":"))
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.set_axis_off()
    axes.set_title(
        f"wire that {one.name} at {100 * one.record.strain[-1]:.0f} % crushing: {broken.sum()} of {len(broken)} links "
        "broken (dotted),\nthe others as thick as their tension",
        fontsize="medium",
    )


if __name__ == "__main__":
    found = study()
    print(table(found))
    figure(found).savefig(Path(sys.argv[1] if len(sys.argv) > 1 else ".") / "brittle_wire.png", dpi=110)
