"""A thread around a cylinder, as a helix: Euler's ratio of the tensions."""

import numpy as np
import lmgcpy as lm

mu, R, r, n, pitch = 0.3, 0.1, 2e-4, 48, 0.5  # radii [m], segments, pitch [rad]
turn = 2.0 * np.pi / n
angle = turn * np.arange(-3, n + 4)
on = np.clip(angle, 0.0, 2.0 * np.pi)
past = angle - on  # beyond the turn both ends go straight on
rho = (R + r) / np.cos(0.5 * turn)
x, y = np.cos(on) - past * np.sin(on), np.sin(on) + past * np.cos(on)
places = rho * np.column_stack([x, y, np.tan(pitch) * angle])
scene = lm.Scene(dimension=3)
nodes = [scene.add(lm.point_mass(position=at, mass=1e-3)) for at in places]
scene.chain(nodes, lm.RigidWire(), surface=lm.Thread(radius=r))
axis = {"position": (0.0, 0.0, 0.0), "axis": (0.0, 0.0, 1.0)}
scene.add(lm.capsule(radius=R, length=2.0, mass=1.0, **axis)).fix()
scene.see("GRAIN", "THREAD", lm.Coulomb(friction=mu))
first, last = places[0] - places[1], places[-1] - places[-2]
nodes[0].impose_force(**dict(zip("xyz", first / np.linalg.norm(first))))
nodes[-1].impose_velocity(**dict(zip("xyz", 0.02 * last / np.linalg.norm(last))))

solver = lm.Auto(tolerance=1e-8)
sim = lm.Simulation(scene, time_step=1e-3, solver=solver).run(steps=60)
tension = lm.measure.wire_links(sim).tension
euler = np.exp(mu * 2.0 * np.pi * np.cos(pitch))
print(f"ratio of the tensions {tension[-1] / tension[0]:.3f}, of Euler {euler:.3f}")
