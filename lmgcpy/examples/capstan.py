"""A thread around a drum: the ratio of its tensions is Euler's."""

import numpy as np
import lmgcpy as lm

mu, R, r, n = 0.3, 0.1, 0.002, 48  # friction, radii of drum and thread [m], segments
turn = np.pi / n
angle = np.linspace(np.pi, 0.0, n + 1)
arc = (R + r) / np.cos(0.5 * turn) * np.column_stack([np.cos(angle), np.sin(angle)])
step = np.array([0.0, 2.0 * (R + r) * np.tan(0.5 * turn)])
below = [arc[0] - k * step for k in (3, 2, 1)]
places = [*below, *arc, *(arc[-1] - k * step for k in (1, 2, 3))]
scene = lm.Scene(dimension=2)
nodes = [scene.add(lm.point_mass(position=at, mass=1e-5)) for at in places]
scene.chain(nodes, lm.RigidWire(), surface=lm.Thread(radius=r))
scene.add(lm.disk(radius=R, position=(0.0, 0.0), mass=1.0)).fix()
scene.see("GRAIN", "THREAD", lm.Coulomb(friction=mu))
nodes[0].fix("x").impose_force(y=-1.0)
nodes[-1].impose_velocity(x=0.0, y=-0.02)

solver = lm.Auto(tolerance=1e-8)
sim = lm.Simulation(scene, time_step=1e-3, solver=solver).run(steps=60)
tension = lm.measure.wire_links(sim).tension
euler = np.exp(mu * np.pi * R / (R + r))
print(f"ratio of the tensions {tension[-1] / tension[0]:.3f}, of Euler {euler:.3f}")
