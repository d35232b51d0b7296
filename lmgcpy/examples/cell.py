"""Shear without walls, in a periodic cell: the drive works against the shear stress."""

import numpy as np
import lmgcpy as lm

length, rate = 0.16, 2.0  # [m], [1/s]
scene = lm.Scene(dimension=2)
radii = lm.sample.grading(60, minimum=0.005, maximum=0.010, seed=0)
places = lm.sample.scatter(radii, cell=(length, length), seed=0)
for radius, place in zip(radii, places, strict=True):
    scene.add(lm.disk(radius=radius, position=place, mass=2600 * np.pi * radius**2))
scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
cell = scene.periodic(x=length, y=length)
cell.impose_stress(xx=-1e5, yy=-1e5)

sim = lm.Simulation(scene, time_step=2e-4).run(duration=0.1)
cell.fix("xx")
cell.impose_rate(xy=rate)
sim.run(duration=0.02)
before, work = sim.energy.total_drives, 0.0
for _ in range(200):
    sim.step()
    shear = lm.measure.stress(sim)["total"][0, 1]
    work += cell.volume * shear * rate * sim.time_step
drive = sim.energy.total_drives - before
print(f"work of the drive {drive:.2f} J, volume x stress x strain {work:.2f} J")
