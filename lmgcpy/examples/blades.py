"""A drum of plates with blades, in space: its torque carries the grains' weight."""

import numpy as np
import lmgcpy as lm

turn, n = 3.0, 24  # spin [rad/s], number of plates of the drum
angle = 2.0 * np.pi * np.arange(n) / n
ring = np.column_stack([np.cos(angle), 0.0 * angle, np.sin(angle)])
across = np.array([0.0, 0.02, 0.0])
points = np.concatenate([0.1 * ring - across, 0.1 * ring + across])
k, j = np.arange(n), (np.arange(n) + 1) % n
sides = [*zip(k, j, j + n), *zip(k, j + n, k + n)]
scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -9.81))
parts = [lm.mesh(points, sides, centre=(0, 0, 0))]
for out in ring[::6]:  # four blades, from the wall inward
    corners = [0.1 * out - across, 0.1 * out + across]
    corners += [0.07 * out + across, 0.07 * out - across]
    parts.append(lm.plate(corners, radius=0.001, centre=(0, 0, 0)))
for part in parts:
    scene.add(part).impose_velocity(spin_y=turn)
for way in (-1.0, 1.0):
    scene.add(lm.wall(point=way * across, normal=(0, -way, 0)))
grid = 0.017 * np.arange(-2, 3)
places = [(x, y, z) for x in grid for y in (-0.0085, 0.0085) for z in grid - 0.02]
grains = scene.add_spheres(0.008, places, masses=5e-3)
scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))

sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-2))
sim.run(duration=0.6)
work, lever = sim.energy.total_drives, []
for _ in range(120):
    sim.run(steps=5)
    lever.append(-np.mean([grain.position[0] for grain in grains]))
torque = (sim.energy.total_drives - work) / (turn * 0.6)
weight = 9.81 * 5e-3 * len(grains)
print(f"torque {torque:.4f} N m, weight x lever {weight * np.mean(lever):.4f} N m")
