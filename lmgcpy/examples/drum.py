"""A rotating drum: its torque carries the grains' weight, which hangs to one side."""

import numpy as np
import lmgcpy as lm

turn, R, r = 1.0, 0.1, 0.005  # spin [rad/s], radii of drum and grains [m]
scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
angles = np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False)
ring = [(lm.DiskContactor(r), R * np.array([np.cos(a), np.sin(a)])) for a in angles]
drum = scene.add(
    lm.RigidBody(ring, mass=1.0, inertia=0.01, position=(0.0, 0.0), color="DRUM")
)
drum.fix("x", "y")
drum.impose_velocity(spin=turn)
grid = 2.1 * r * np.arange(-8, 9)
places = [(x, y) for x in grid for y in grid[:9]]
places = [place for place in places if np.hypot(*place) < R - 2 * r]
for place in places:
    scene.add(lm.disk(radius=r, position=place, mass=0.2))
scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.5))
scene.see("GRAIN", "DRUM", lm.Coulomb(friction=0.5))

solver = lm.Auto(tolerance=1e-2)
sim = lm.Simulation(scene, time_step=1e-3, solver=solver).run(duration=0.5)
work, lever = sim.energy.total_drives, []
for _ in range(200):
    sim.run(steps=5)
    lever.append(sim.positions[1:, 0].mean())
torque = (sim.energy.total_drives - work) / (1.0 * turn)
weight = 9.81 * 0.2 * len(places)
print(f"torque {torque:.4f} N, weight x lever {weight * np.mean(lever):.4f} N")
