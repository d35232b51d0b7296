"""A box under a given pressure: loads that follow the lengths of the walls."""

import numpy as np
import lmgcpy as lm

pressure, size = 1e4, 0.2  # [Pa], [m]
scene = lm.Scene(dimension=2)
radii = lm.sample.grading(150, minimum=0.005, maximum=0.010, seed=0)
places = lm.sample.deposit(radii, box=(size, None), seed=0)
for radius, place in zip(radii, places, strict=True):
    scene.add(lm.disk(radius=radius, position=place, mass=2600 * np.pi * radius**2))
scene.add(lm.wall(point=(0.0, 0.0), normal=(1, 0)))
scene.add(lm.wall(point=(0.0, 0.0), normal=(0, 1)))
top = (places[:, 1] + radii).max()
right = scene.add(lm.wall(point=(size, 0.0), normal=(-1, 0), mass=1.0))
lid = scene.add(lm.wall(point=(0.0, top), normal=(0, -1), mass=1.0))
right.impose_force(x=lambda t: -pressure * lid.position[1])
lid.impose_force(y=lambda t: -pressure * right.position[0])
scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
scene.see("GRAIN", "WALL", lm.Signorini())

sim = lm.Simulation(scene, time_step=1e-3).run(duration=1.0)
sigma = lm.measure.stress(sim)["total"]
print(f"stress [Pa]: xx {sigma[0, 0]:.0f}, yy {sigma[1, 1]:.0f}, xy {sigma[0, 1]:.0f}")
