"""Pull-out: a smooth strip is drawn from sand, against friction on both sides of it.

Two layers of grains press a strip over the length L, with the pressure p from above and
from below. It slides on both sides, so that the pull is 2 mu p L (F. Schlosser and V.
Elias, ASCE Symposium on Earth Reinforcement, 1978).
"""

import numpy as np
import lmgcpy as lm

seed, mu, p, L = 0, 0.2, 1e4, 0.2  # -, friction, pressure [N/m], length [m]
scene = lm.Scene(dimension=2)
nodes = [lm.point_mass(position=(0.01 * k, 0.0), mass=0.1) for k in range(31)]
for node in nodes:
    scene.add(node).fix("y")
thin = 0.0005  # half the strip [m]
scene.chain(nodes, lm.RigidRod(), surface=lm.Thread(radius=thin))
for way in (1, -1):
    radii = lm.sample.grading(150, minimum=0.003, maximum=0.005, seed=(seed, 1 + way))
    places = lm.sample.deposit(radii, box=(L, None), seed=seed) + (0.0, thin)
    end = (places[:, 1] + radii).max()
    lid = scene.add(lm.wall(point=(0.0, way * end), normal=(0, -way), mass=5.0))
    lid.impose_force(y=-way * p * L)
    scene.add_disks(radii, places * (1, way), masses=2600.0 * np.pi * radii**2)
for x, inward in ((0.0, 1.0), (L, -1.0)):
    scene.add(lm.wall(point=(x, 0.0), normal=(inward, 0.0)))
scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.5))
scene.see("GRAIN", "THREAD", lm.Coulomb(friction=mu))
scene.see("GRAIN", "WALL", lm.Signorini())

solver = lm.Auto(tolerance=1e-3)
sim = lm.Simulation(scene, time_step=5e-4, solver=solver).run(duration=0.2)
nodes[0].impose_velocity(x=-0.02)
sim.run(duration=0.1)
work, start = sim.energy.total_drives, nodes[0].position[0]
sim.run(duration=0.3)
pull = (sim.energy.total_drives - work) / (start - nodes[0].position[0])
print(f"pull {pull:.1f} N/m, 2 mu p L {2.0 * mu * p * L:.1f} N/m")
