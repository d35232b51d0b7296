"""Biaxial and triaxial tests in a flexible membrane beside tests between rigid walls: docs/threads.md.

The same dense samples of disks or spheres, relaxed without friction, are crushed along the last axis between smooth
platens: once with the pressure on rigid walls, once on a membrane, a chain on each side in 2D, triangles all around in 3D,
with wires along their edges. The rims of the membrane are clamped to the platens. It sinks into the pores of the surface
first; the change of volume counts from there. The axial stress is the force on the platens over the area in the membrane.

    python benchmarks/membrane.py [SEEDS [GRAINS]]
"""

from __future__ import annotations

import sys
import time
import warnings

import numpy as np
from fibres import DENSITY, PRESSURE, crushed, dense, words
from table import report

import lmgcpy as lm
from lmgcpy.dynamics.loads import area_vectors
from lmgcpy.experiment import Biaxial, Sample, characteristic_time, lay_grains

FRICTION, INERTIAL_NUMBER, STRAIN, SETTLING = 0.4, 2e-3, 0.12, 100
STIFFNESS = 5.0
"""Force per length of the latex at a strain of one, over the pressure times the mean diameter."""
THICKNESS, SPACING = 0.1, 0.8
"""Of the latex, and distance of its nodes, in mean diameters."""
LATEX = 1000.0
"""Density [kg/m^3]."""


def laid_in_plane(count: int, seed: int) -> Sample:
    """Disks of the same sizes as the spheres, at random places."""
    radii = lm.sample.grading(count, minimum=0.4e-3, maximum=0.6e-3, by="diameter", dimension=2, seed=seed)
    cell = np.full(2, np.sqrt(np.pi * float((radii**2).sum()) / 0.4))
    positions = lm.sample.scatter(radii, cell=cell, seed=seed) + radii.max()
    return Sample(positions, radii, wires=(), reference_gap=0.0, box=cell + 2.0 * radii.max())


def latex(scene: lm.Scene, sample: Sample) -> tuple[list, np.ndarray]:
    """The membrane around a sample: its nodes, and its cells with the normals outward."""
    d, pitch, height = len(sample.box), SPACING * sample.diameter, sample.box[-1]
    radius = 0.5 * THICKNESS * sample.diameter
    if d == 3:
        made = lm.sample.membrane_around(box=sample.box[:2] + 2.0 * radius, height=height, spacing=pitch)
        places, cells = made.positions - [radius, radius, 0.0], made.cells
    else:
        up = np.linspace(0.0, height, 1 + int(np.ceil(height / pitch)))
        sides = [np.column_stack([np.full(len(up), x), up]) for x in (-radius, sample.box[0] + radius)]
        places = np.concatenate([sides[0], sides[1][::-1]])  # outside lies to the left
        start = np.flatnonzero(np.diff(places[:, 0]) == 0.0)
        cells = np.column_stack([start, start + 1])
    mass = LATEX * THICKNESS * sample.diameter * pitch ** (d - 1)
    nodes = [scene.add(lm.point_mass(position=x, mass=mass)) for x in places]
    # in 3D wires in a square bear the force E t of their width at a strain of one: E t [N/m] for a wire as long as wide
    law = lm.ElasticWire(stiffness=STIFFNESS * PRESSURE * sample.diameter / (1.0 if d == 3 else pitch))
    if d == 3:
        scene.membrane(nodes, cells, law, radius=radius).impose_pressure(PRESSURE)
        return nodes, cells
    half = len(nodes) // 2
    for part in (nodes[:half], nodes[half:]):
        chain = scene.chain(part, law, surface=lm.Thread(radius, color="MEMBRANE"))
        chain.skin.impose_pressure(PRESSURE)
    return nodes, cells


def volume_within(corners: np.ndarray, height: float) -> float:
    """Volume between the platens and the cells of the membrane, by the divergence of the place across the axis."""
    d = corners.shape[2]
    return float((area_vectors(corners) * corners.mean(axis=1))[:, : d - 1].sum()) / (d - 1)


def in_membrane(sample: Sample) -> tuple[np.ndarray, np.ndarray, np.ndarray, int, int]:
    """Strain, deviator [Pa] and change of volume, step by step, (s,) each; unsolved steps; and grains that have left."""
    d, height = len(sample.box), float(sample.box[-1])
    tick = characteristic_time(sample.diameter, DENSITY, PRESSURE)
    scene, sand = lm.Scene(dimension=d), lm.Material("sand", density=DENSITY)
    add = scene.add_disks if d == 2 else scene.add_spheres
    grains = add(sample.radii, sample.positions, material=sand)
    up = np.eye(d)[-1]
    low = scene.add(lm.wall(point=np.zeros(d), normal=up, color="PLATEN"))
    high = scene.add(lm.wall(point=height * up, normal=-up, color="PLATEN"))
    nodes, cells = latex(scene, sample)
    rows = np.array([node.id for node in nodes])
    places = np.array([node.position for node in nodes])
    along = "xyz"[d - 1]
    rims = [node for node, x in zip(nodes, places, strict=True) if x[-1] in (0.0, places[:, -1].max())]
    for node in rims:
        node.fix()
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=FRICTION))
    scene.see("GRAIN", "PLATEN", lm.Coulomb(friction=0.0))
    scene.see("GRAIN", "MEMBRANE", lm.Coulomb(friction=FRICTION))
    solver = lm.AcceleratedGaussSeidel(tolerance=3e-3, max_iterations=3000)
    sim = lm.Simulation(scene, time_step=0.08 * tick, solver=solver)
    high.fix()
    sim.run(steps=SETTLING)
    speed = -INERTIAL_NUMBER / tick * height
    for body in (high, *(node for node in rims if node.position[-1] > 0.0)):
        body.impose_velocity(**{along: speed})
    told = []
    while not told or told[-1][0] < STRAIN:
        sim.step()
        net, now = sim.interactions, float(high.position[-1])
        on_platen = np.isin(net.antagonist, (low.id, high.id)) & (net.law == "coulomb")
        volume = volume_within(sim.positions[rows][cells], now)
        axial = 0.5 * float(net.force[on_platen, 0].sum()) * now / volume
        told.append((-np.log(now / height), axial - PRESSURE, volume))
    strain, deviator, volumes = np.array(told).T
    x, around = sim.positions[: len(grains), : d - 1], sim.positions[rows, : d - 1]
    lost = ~((x > around.min(axis=0)) & (x < around.max(axis=0))).all(axis=1)
    return strain, deviator, volumes / volumes[0] - 1.0, sim.unconverged_steps, int(lost.sum())


def between_walls(sample: Sample):
    """The record of a test between rigid walls."""
    if len(sample.box) == 3:
        return crushed(sample)
    solver = lm.AcceleratedGaussSeidel(tolerance=3e-3, max_iterations=3000)
    step = 0.08 * characteristic_time(sample.diameter, DENSITY, PRESSURE)
    options = {"friction": FRICTION, "inertial_number": INERTIAL_NUMBER, "solver": solver, "time_step": step}
    return Biaxial(sample, pressure=PRESSURE, density=DENSITY, **options).run(STRAIN, frames=0)


def figures(strain: np.ndarray, deviator: np.ndarray, dilation: float) -> list[float]:
    """Peak of the running mean over 1 %, mean beyond 8 % [kPa], change of volume at the end [%]."""
    window = max(1, round(0.01 * len(strain) / strain[-1]))
    smooth = np.convolve(deviator, np.ones(window) / window, mode="valid")
    return [smooth.max() / 1e3, deviator[strain > 0.08].mean() / 1e3, 100.0 * dilation]


def case(d: int, seed: int, grains: int) -> list[list]:
    """Two rows of the table of runs."""
    done = dense(lay_grains(grains, seed=seed) if d == 3 else laid_in_plane(grains, seed))
    begin = time.process_time()
    record = between_walls(done.sample)
    change = np.prod(record.size[-1]) / np.prod(done.sample.box) - 1.0
    told = figures(record.strain, record.deviator, float(change))
    rows = [[d, "rigid walls", seed, *told, record.unconverged, 0, time.process_time() - begin]]
    begin = time.process_time()
    strain, deviator, changes, unsolved, lost = in_membrane(done.sample)
    told = figures(strain, deviator, changes[-1])
    rows.append([d, "membrane", seed, *told, unsolved, lost, time.process_time() - begin])
    print(*rows, sep="\n", file=sys.stderr, flush=True)
    return rows


def main(seeds: int = 5, grains: int = 400) -> None:
    """All cases, one after the other."""
    runs = [row for d in (2, 3) for seed in range(seeds) for row in case(d, seed, grains)]
    header = ["dimension", "lateral boundary", "seed", "peak deviator [kPa]", "late [kPa]", "dilation [%]"]
    told = [[*run[:3], *(f"{value:.4g}" for value in run[3:6]), *run[6:8], f"{run[8]:.0f}"] for run in runs]
    report("membrane_runs", [*header, "unsolved steps", "grains lost", "processor [s]"], told)
    rows = []
    for d, name in dict.fromkeys((run[0], run[1]) for run in runs):
        numbers = np.array([run[3:6] for run in runs if (run[0], run[1]) == (d, name)]).T
        rows.append([f"{d}D", name, seeds, *map(words, numbers)])
    report("membrane", ["dimension", "lateral boundary", "samples", *header[3:]], rows)


if __name__ == "__main__":
    warnings.simplefilter("ignore")  # light nodes between pores move fast now and then; losses are in the table
    main(*map(int, sys.argv[1:]))
