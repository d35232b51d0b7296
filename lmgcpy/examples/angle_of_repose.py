"""Angle of repose: the slope on which a layer of disks just goes on flowing.

The layer lies on fixed disks and is periodic along the slope. A controller tilts
gravity until the layer has a small mean speed. The tangent of the mean slope is then
the friction tau / P = 0.25 + 1.1 I of disks of friction 0.4 (F. da Cruz and others,
Phys. Rev. E 72, 021309, 2005), with the inertial number I = 2.5 speed d / (H^1.5
sqrt(g)) of a layer of the height H. Here, as in the example simple-shear, it has 0.28
in place of 0.25.
"""

import numpy as np
import lmgcpy as lm

seed, d, wanted = 0, 0.01, 0.1  # -, mean size of the disks [m], mean speed [m/s]
radii = d * np.random.default_rng(seed).uniform(0.4, 0.6, 240)
length = 16 * d
places = lm.sample.deposit(radii, box=(length, None), seed=seed)
masses = 2600.0 * np.pi * radii**2
scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
disks = scene.add_disks(radii, places, masses=masses)
free = places[:, 1] > d
for k in np.flatnonzero(~free):
    disks[k].fix()  # the ground
scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.4))
scene.periodic(x=length)

sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-2))
turned, slopes = 0.3, []  # [rad]
for _ in range(600):  # 6 s
    speed = np.average(sim.velocities[:240, 0][free], weights=masses[free])
    turned += 0.02 * (wanted - speed)
    slope = turned + 0.5 * (wanted - speed)
    scene.gravity = 9.81 * np.array([np.sin(slope), -np.cos(slope)])
    sim.run(steps=10)
    slopes.append(slope)
angle = np.degrees(np.mean(slopes[150:]))
H = 2.0 * (np.average(sim.positions[:240, 1][free], weights=masses[free]) - d)
inertial = 2.5 * wanted * d / (H**1.5 * np.sqrt(9.81))
known = np.degrees(np.arctan(0.25 + 1.1 * inertial))
print(f"slope {angle:.1f} degrees, da Cruz {known:.1f} degrees")
