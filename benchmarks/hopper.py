"""A hopper from an STL file: Beverloo's law over three outlets, and tubes of N facets beside the cylinder wall.

**Outlets.** A funnel at 45 degrees under a tube, written as STL in millimetres and read by ``lmgcpy.read_mesh``, is filled
with spheres on a lid, which is then taken away. With the diameter D of the outlet and d of the grains
``W = C rho_b sqrt(g) (D - k d)^(5/2)`` (Beverloo, Leniger and van de Velde, 1961). So ``W^(2/5)`` is a straight line over D
which cuts the axis at ``k d``. The rate is the slope of the mass that is out over time, between the shares of
:data:`STEADY`. The exponent is that power of ``D - k d`` which fits the same rates best, with k = 1.4 as published.

**Facets.** A ball without friction goes once around in a tube of N facets, which has the section of a cylinder wall. It
meets N edges, and as contacts do not bounce each takes the part of the velocity across the next facet: the speed after a
turn is ``cos(2 pi / N)^N = 1 - 2 pi^2 / N + ...`` of the speed before. Its distance from the axis is off by the depth of
the polygon, of the order of ``(pi / N)^2`` of the radius.

    python benchmarks/hopper.py [outlets | facets]
"""

from __future__ import annotations

import math
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from table import report

import lmgcpy as lm

GRAIN = 4e-3
"""Mean diameter of the grains [m]."""
DENSITY, FRICTION, G = 2500.0, 0.5, 9.81
SPREAD = 0.1
"""Diameters are even between 1 - SPREAD and 1 + SPREAD of the mean."""
BIN = 18.0
"""Diameter of the tube, in grains."""
STEADY = 0.15, 0.6
"""Shares of the grains between which the rate is read."""
SIDES = 48
"""Facets around."""


def funnel(outlet: float, height: float, sides: int = SIDES) -> tuple[np.ndarray, np.ndarray]:
    """Points [m] and triangles of a cone at 45 degrees from an outlet at z = 0, diameters in [m], up to a tube. Its facets
    have the section of the round one."""
    angle = 2.0 * np.pi * np.arange(sides) / sides
    ring = np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle]) * section(sides)
    wide = 0.5 * BIN * GRAIN
    levels = [(0.5 * outlet, 0.0), (wide, wide - 0.5 * outlet), (wide, height)]
    points = np.concatenate([r * ring + (0.0, 0.0, z) for r, z in levels])
    return points, bands(sides, len(levels))


def section(sides: int) -> float:
    """Radius of the corners of a polygon with the area of a circle of radius 1."""
    return math.sqrt(2.0 * math.pi / sides / math.sin(2.0 * math.pi / sides))


def bands(sides: int, levels: int) -> np.ndarray:
    """Triangles between rings of corners, one above the other."""
    k = np.arange(sides)
    j = (k + 1) % sides
    one = np.concatenate([np.column_stack([k, j, j + sides]), np.column_stack([k, j + sides, k + sides])])
    return np.concatenate([one + sides * level for level in range(levels - 1)])


def write_stl(path: Path, points: np.ndarray, triangles: np.ndarray) -> None:
    """A text STL in millimetres."""
    lines = ["solid funnel"]
    for corners in 1e3 * points[triangles]:
        lines += ["facet normal 0 0 0", "outer loop", *(f"vertex {x:.7g} {y:.7g} {z:.7g}" for x, y, z in corners)]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid funnel", ""]))


def discharge(outlet: float, count: int, seed: int, step: float = 1e-3) -> list:
    """The rate of one hopper; ``outlet`` in grains."""
    rng, hole, begin = np.random.default_rng(seed), outlet * GRAIN, time.process_time()
    radii = 0.5 * GRAIN * rng.uniform(1.0 - SPREAD, 1.0 + SPREAD, count)
    pitch, wide = 1.02 * GRAIN * (1.0 + SPREAD), 0.5 * BIN * GRAIN
    grid = pitch * np.arange(-12, 13)
    places: list[tuple[float, float, float]] = []
    z = 0.6 * GRAIN
    while len(places) < count:
        free = min(0.5 * hole + z - 0.8 * GRAIN, wide - 0.6 * GRAIN)  # a cone at 45 degrees
        layer = [(x, y, z) for x in grid for y in grid if math.hypot(x, y) < free]
        places += [layer[k] for k in rng.permutation(len(layer))]
        z += pitch
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -G))
    with tempfile.TemporaryDirectory() as folder:
        write_stl(Path(folder) / "funnel.stl", *funnel(hole, z + GRAIN))
        scene.add(lm.read_mesh(Path(folder) / "funnel.stl", scale=1e-3))
    lid = scene.add(lm.plate([(-hole, -hole, 0), (hole, -hole, 0), (hole, hole, 0), (-hole, hole, 0)]))
    masses = DENSITY * 4.0 / 3.0 * np.pi * radii**3
    grains = scene.add_spheres(radii, np.array(places[:count]), masses=masses)
    for other in ("GRAIN", "WALL"):
        scene.see("GRAIN", other, lm.Coulomb(friction=FRICTION))
    solver = lm.AcceleratedGaussSeidel(tolerance=1e-2)
    sim = lm.Simulation(scene, time_step=step, solver=solver, on_unconverged="ignore").run(duration=0.3)
    lid.hide()
    rows = slice(grains[0].id, grains[0].id + count)
    left = np.zeros(count, dtype=bool)
    hidden = left.copy()
    times, out = [], []
    while left.sum() < (STEADY[1] + 0.02) * count and len(times) < 20000:
        sim.step()
        left |= sim.positions[rows, 2] < -2.0 * GRAIN
        times.append(sim.time)
        out.append(masses[left].sum())
        if len(times) % 50 == 0:  # together: a change of the scene costs more than a step
            for k in np.flatnonzero(left & ~hidden):
                grains[k].hide()
            hidden |= left
    share, times = np.array(out) / masses.sum(), np.array(times)
    part = (share > STEADY[0]) & (share < STEADY[1])
    half = (share > STEADY[0]) & (share < 0.5 * sum(STEADY)), (share >= 0.5 * sum(STEADY)) & (share < STEADY[1])
    rate, first, second = (np.polyfit(times[those], np.array(out)[those], 1)[0] for those in (part, *half))
    seconds = time.process_time() - begin
    row = [outlet, count, seed, f"{step:g}", f"{rate:.5g}", f"{first:.5g}", f"{second:.5g}", sim.steps]
    row += [sim.unconverged_steps, f"{seconds:.0f}"]
    print(*row, flush=True)
    return row


def law(rows: list[list]) -> list[list]:
    """The fits: k and C of the straight line, and the exponent with k = 1.4."""
    outlet, rate = (np.array([float(row[k]) for row in rows]) for k in (0, 4))
    bulk = 0.6 * DENSITY
    slope, cut = np.polyfit(outlet, rate**0.4, 1)
    scale = bulk * math.sqrt(G) * GRAIN**2.5
    power, (exponent, _) = slope * outlet + cut, np.polyfit(np.log(outlet - 1.4), np.log(rate), 1)
    error = float(np.abs(power**2.5 / rate - 1.0).max())
    return [[f"{-cut / slope:.2f}", f"{slope**2.5 / scale:.3f}", f"{error:.3f}", f"{exponent:.2f}"]]


def orbit(sides: int | None) -> list:
    """A ball once around in a tube of radius 0.1 m without friction and gravity, at 1 m/s."""
    scene, radius, ball = lm.Scene(dimension=3), 0.1, 0.01
    if sides is None:
        scene.add(lm.cylinder_wall(point=(0, 0, 0), axis=(0, 0, 1), radius=radius))
    else:
        scene.add(lm.mesh(*tube(radius, sides)))
    lowest = (0.0, ball - inner(radius, sides), 0.0)
    grain = scene.add(lm.sphere(radius=ball, position=lowest, mass=1.0, velocity=(1, 0, 0)))
    scene.see("GRAIN", "WALL", lm.Signorini())
    h, away = 2e-4, radius - ball
    sim = lm.Simulation(scene, time_step=h)
    turned, before = 0.0, math.atan2(grain.position[1], grain.position[0])
    speeds, radii = [], []
    while turned < 2.0 * math.pi:
        sim.step()
        now = math.atan2(grain.position[1], grain.position[0])
        turned, before = turned + (now - before) % (2.0 * math.pi), now
        speeds.append(float(np.linalg.norm(grain.velocity)))
        radii.append(math.hypot(*grain.position[:2]))
    expected = 1.0 if sides is None else math.cos(2.0 * math.pi / sides) ** sides
    off = float(np.abs(np.array(radii) / away - 1.0).max())
    return [sides or "cylinder", f"{speeds[-1]:.4f}", f"{expected:.4f}", f"{off:.2e}"]


def inner(radius: float, sides: int | None) -> float:
    """Distance of the facets from the axis [m]."""
    return radius if sides is None else radius * section(sides) * math.cos(math.pi / sides)


def tube(radius: float, sides: int, half: float = 0.5) -> tuple[np.ndarray, np.ndarray]:
    """A tube of facets, with the section of a round one, a facet lowest along y."""
    angle = 2.0 * np.pi * (np.arange(sides) + 0.5) / sides - 0.5 * np.pi
    ring = radius * section(sides) * np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
    up = np.array([0.0, 0.0, half])
    return np.concatenate([ring - up, ring + up]), bands(sides, 2)


if __name__ == "__main__":
    chosen = sys.argv[1] if len(sys.argv) > 1 else "all"
    if chosen in ("all", "facets"):
        counts = (16, 32, 64, 128, 200, None)
        header = ["facets", "speed after a turn [m/s]", "cos(2 pi/N)^N", "largest error of the distance from the axis"]
        report("hopper_facets", header, [orbit(sides) for sides in counts])
    if chosen in ("all", "outlets"):
        header = ["outlet [grains]", "grains", "seed", "step [s]", "rate [kg/s]", "of the first half", "of the second"]
        rows = [discharge(outlet, 3000, seed) for outlet in (6.0, 8.0, 11.0) for seed in range(3)]
        finer = [discharge(8.0, 3000, 0, 5e-4)]
        report("hopper_outlets", [*header, "steps", "unsolved", "processor [s]"], rows + finer)
        report("hopper_law", ["k", "C", "largest error", "exponent with k = 1.4"], law(rows))
