"""Oedometer: the earth pressure at rest of a regular packing of disks.

A lid loads rows of smooth disks between walls that do not give way. Disks in a row are
a little apart, and each stands on two others, on contacts at the angle theta to the
horizontal. These contacts bear the whole load, so that the walls are pushed with K0 = 1
/ tan(theta)^2 times the stress of the lid (P. W. Rowe, Proc. R. Soc. A 269, 1962,
without friction). Stresses are forces over the distances of the outermost centres.
"""

import numpy as np
import lmgcpy as lm

d, apart, columns, rows = 0.01, 0.0115, 8, 9  # size and distance of the disks [m]
theta, load = np.arccos(0.5 * apart / d), 1e3  # [rad], force on the lid [N/m]
width, height = (columns - 1) * apart, (rows - 1) * d * np.sin(theta)
scene = lm.Scene(dimension=2)
for row in range(rows):
    for x in apart * (np.arange(columns - row % 2) + 0.5 * (row % 2)):
        at = (x, row * d * np.sin(theta))
        scene.add(lm.disk(radius=0.5 * d, position=at, mass=0.2))
r = 0.5 * d
scene.add(lm.wall(point=(0, -r), normal=(0, 1)))
scene.add(lm.wall(point=(-r, 0), normal=(1, 0)))
side = scene.add(lm.wall(point=(width + r, 0), normal=(-1, 0)))
lid = scene.add(lm.wall(point=(0, height + r), normal=(0, -1), mass=1.0))
lid.impose_force(y=-load)
scene.see("GRAIN", "GRAIN", lm.Signorini())
scene.see("GRAIN", "WALL", lm.Signorini())

sim = lm.Simulation(scene, time_step=1e-4, solver=lm.Auto(tolerance=1e-8))
sim.run(duration=0.02)
lateral = lm.measure.reaction(sim, side).force[0] / height
K0 = lateral / (load / width)
print(f"K0 {K0:.4f}, Rowe {1.0 / np.tan(theta) ** 2:.4f}")
