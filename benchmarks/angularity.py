"""Strength and angle of repose of grains that are less and less like spheres: docs/fibres.md.

A grain is four equal spheres around the corners of a tetrahedron, of the volume of the sphere that it replaces. Its shape
parameter is eta = 1 - R_in/R_out, of the largest sphere around its centre that it holds and the smallest that holds it: 0
for a sphere. Saint-Cyr and others (CEGEO, Europhysics Letters 98, 44008, 2012) sheared disks, polygons and aggregates in
the plane: strength grows with eta, with nearly the same trend for all shapes, and the solid fraction of dense samples grows
with eta at first and declines later on.

Triaxial tests are those of fibres.py. For the angle of repose a deposit in a box with smooth side walls is tilted by
60 degrees; grains flow until the surface is inclined by the angle of repose against the horizontal.

    python benchmarks/angularity.py [SEEDS [GRAINS]]
"""

from __future__ import annotations

import math
import sys
import time
import warnings

import numpy as np
from fibres import crushed, dense, strengths, words
from table import report

import lmgcpy as lm
from lmgcpy.experiment import lay_grains

CORNERS = np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)]) / math.sqrt(3.0)
OFFSETS = (0.0, 0.35, 0.7)
"""Distance of the spheres from the centre, over their radius."""
DENSITY, DIAMETER, FRICTION = 2600.0, 1e-3, 0.4
GRAVITY, TILT, DURATION, STEP = 9.81, math.radians(60.0), 0.3, 5e-4
"""Of the tilting [m/s^2, rad, s, s]; as long again is allowed for flowing on at the last angle."""
LENGTH, WIDTH = 10.0, 4.0
"""Of the box that is tilted, over the diameter."""


def eta(offset: float) -> float:
    """Shape parameter of four unit spheres at this distance a from the centre.

    R_out = 1 + a. Opposite a sphere the surface is the point where the other three meet, whose centres are seen from there
    under the cosine 1/3: R_in = a/3 + sqrt(1 - 8 a^2/9).
    """
    return 1.0 - (offset / 3.0 + math.sqrt(1.0 - 8.0 * offset**2 / 9.0)) / (1.0 + offset)


def grain(offset: float) -> lm.Clump | None:
    """The shape of the grains; None for spheres."""
    if offset == 0.0:
        return None
    return lm.clump([1.0] * 4, offset * CORNERS, density=DENSITY)


def repose(offset: float, grains: int, seed: int) -> float:
    """Angle of repose [degrees].

    Under a plane surface of slope s over a floor of length L the centre of mass of a body of mean depth H lies s L^2/(12 H)
    from the middle, as high as H/2 + s^2 L^2/(24 H). So both coordinates of the centre of mass give s and H, and nobody
    has to say where the surface is.
    """
    length, width = LENGTH * DIAMETER, WIDTH * DIAMETER
    laid = lay_grains(grains, shape=grain(offset), seed=seed)
    stone = lm.Material("stone", DENSITY)
    loose = list(laid.bodies) or [
        lm.sphere(radius=r, position=x, material=stone) for r, x in zip(laid.radii, laid.positions, strict=True)
    ]

    def gravity(time: float) -> tuple[float, float, float]:
        angle = TILT * min(1.0, time / DURATION)
        return GRAVITY * math.sin(angle), 0.0, -GRAVITY * math.cos(angle)

    scene = lm.Scene(dimension=3, gravity=gravity)
    deposit = lm.sample.deposit_bodies(loose, box=(length, width, None), friction=0.2, seed=seed)
    bodies = [scene.add(body) for body in deposit]
    for axis, size in enumerate((length, width)):
        for end, sign in ((0.0, 1.0), (size, -1.0)):
            color = "END" if axis == 0 else "SIDE"
            scene.add(lm.wall(point=end * np.eye(3)[axis], normal=sign * np.eye(3)[axis], color=color))
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1), color="END"))
    for other in ("GRAIN", "END"):
        scene.see("GRAIN", other, lm.Coulomb(friction=FRICTION))
    scene.see("GRAIN", "SIDE", lm.Coulomb(friction=0.0))
    solver = lm.AcceleratedGaussSeidel(tolerance=1e-2, max_iterations=2000)
    sim = lm.Simulation(scene, time_step=STEP, solver=solver, on_unconverged="ignore").run(duration=2.0 * DURATION)
    mass = np.array([body.mass for body in bodies])
    x, _, z = np.average(sim.positions[: len(bodies)], axis=0, weights=mass)
    # z = H/2 + s^2 L^2/(24 H) with s = 12 H (x - L/2)/L^2
    depth = z / (0.5 + 6.0 * (x / length - 0.5) ** 2)
    slope = 12.0 * depth * (x - 0.5 * length) / length**2
    assert abs(slope) * length < 2.0 * depth, "the floor is bare: the formula does not hold"
    return math.degrees(TILT - math.atan(slope))


def case(offset: float, grains: int, seed: int) -> list:
    """A row of the table of runs."""
    begin = time.process_time()
    done = dense(lay_grains(grains, shape=grain(offset), seed=seed))
    record = crushed(done.sample)
    solid = done.sample.solid_volume / float(np.prod(done.sample.box))
    found = [solid, done.coordination, *strengths(record), repose(offset, grains, seed)]
    unsolved, overlap = done.unconverged + record.unconverged, record.penetration.max() / DIAMETER
    told = [f"{value:.4g}" for value in found]
    spent = time.process_time() - begin
    return [f"{eta(offset):.2f}", seed, *told, done.at_rest, unsolved, f"{overlap:.1e}", f"{spent:.0f}"]


def tables(runs: list[list]) -> None:
    """Print and write the runs, and their means with intervals."""
    rows = []
    for shape in dict.fromkeys(run[0] for run in runs):
        numbers = np.array([run[2:9] for run in runs if run[0] == shape], dtype=float)
        solid, contacts, peak, late, _, dilation, angle = numbers.T
        # sin phi = (sigma_1 - sigma_3)/(sigma_1 + sigma_3), sigma_3 = 100 kPa
        friction = [np.degrees(np.arcsin(q / (q + 200.0))) for q in (peak, late)]
        told = (peak, friction[0], late, friction[1], dilation, angle)
        rows.append([shape, len(numbers), words(solid, ".3f"), words(contacts, ".2f"), *map(words, told)])
    header = ["eta", "seed", "solid fraction", "coordination", "peak deviator [kPa]", "late [kPa]", "peak q/p"]
    header += ["dilation [%]", "repose [deg]", "at rest", "unsolved steps", "overlap / d", "processor [s]"]
    report("angularity_runs", header, runs)
    header = ["eta", "samples", "solid fraction", "coordination", "peak deviator [kPa]", "angle at the peak [deg]"]
    report("angularity", [*header, "late [kPa]", "late angle [deg]", "dilation [%]", "angle of repose [deg]"], rows)


def main(seeds: int = 5, grains: int = 200) -> None:
    """All cases, one after the other."""
    tables([case(offset, grains, seed) for offset in OFFSETS for seed in range(seeds)])


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # single bodies move fast now and then; overlaps are in the table
    main(*map(int, sys.argv[1:]))
