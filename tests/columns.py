"""A column of disks, which few sweeps do not solve."""

import lmgcpy as lm


def column(count: int, radius: float) -> lm.Scene:
    """Disks of 1 kg, one on the other on a floor, in contact."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    for k in range(count):
        scene.add(lm.disk(radius=radius, position=(0.0, radius + 2.0 * radius * k), mass=1.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    return scene


def unsolved(count: int, radius: float, kind: type[lm.Simulation] = lm.Simulation, **options) -> lm.Simulation:
    """Its simulation, with a solver of two sweeps a step that does not reach its tolerance."""
    solver = lm.GaussSeidel(tolerance=1e-12, max_iterations=2)
    return kind(column(count, radius), time_step=2e-3, solver=solver, **options)
