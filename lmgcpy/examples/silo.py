"""A silo: its walls bear a part of the weight, and the base the rest, by Janssen.

The base goes down slowly, so that the grains slide along the walls and mobilise their
whole friction mu. H. A. Janssen (Z. VDI 39, 1895) found the force on the base as a part
of the weight: (L / H) (1 - exp(-H / L)), with the height H of the grains and the length
L = width / (2 mu K); K is the ratio of the horizontal to the vertical stress.
"""

import numpy as np
import lmgcpy as lm

seed, width, mu, count = 0, 0.07, 0.3, 500  # -, [m], friction of the walls
radii = lm.sample.grading(count, minimum=0.002, maximum=0.003, seed=seed)
places = lm.sample.deposit(radii, box=(width, None), seed=seed)
masses = 2600.0 * np.pi * radii**2
scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
scene.add_disks(radii, places, masses=masses)
for x, inward in ((0.0, 1.0), (width, -1.0)):
    scene.add(lm.wall(point=(x, 0.0), normal=(inward, 0.0), color="SIDE"))
base = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0), color="BASE"))
scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.5))
scene.see("GRAIN", "SIDE", lm.Coulomb(friction=mu))
scene.see("GRAIN", "BASE", lm.Signorini())

sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-2))
sim.run(duration=0.3)
base.impose_velocity(y=-0.02)
sim.run(duration=0.3)
borne, ratio = [], []
for _ in range(70):  # 14 mm, some three grains
    sim.run(steps=10)
    stress = lm.measure.stress(sim, volume=1.0)["total"]
    borne.append(-lm.measure.reaction(sim, base).force[1])
    ratio.append(stress[0, 0] / stress[1, 1])
share, K = np.mean(borne) / (9.81 * masses.sum()), np.mean(ratio)
centre = np.average(sim.positions[:count, 1], weights=masses)
H, L = 2.0 * (centre - base.position[1]), width / (2.0 * mu * K)
janssen = L / H * (1.0 - np.exp(-H / L))
print(f"K {K:.2f}; the base bears {share:.3f} of the weight, Janssen {janssen:.3f}")
