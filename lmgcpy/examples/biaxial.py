"""A biaxial test in a membrane: friction bears more than the pressure."""

import numpy as np
import lmgcpy as lm

p, width, r = 1e3, 0.15, 0.001  # pressure [N/m], width and half a membrane [m]
radii = lm.sample.grading(100, minimum=0.006, maximum=0.009, seed=0)
places = lm.sample.deposit(radii, box=(width, None), seed=0)
height = (places[:, 1] + radii).max()
scene = lm.Scene(dimension=2)
scene.add_disks(radii, places, masses=2600 * np.pi * radii**2)
scene.add(lm.wall(point=(0.0, 0.0), normal=(0, 1)))
top = scene.add(lm.wall(point=(0.0, height), normal=(0, -1)))
latex, driven = lm.ElasticWire(stiffness=1e4), [top]
for x, way in ((-r, 1), (width + r, -1)):  # outside is to the left
    up = np.linspace(r, height - r, 25)[::way]
    nodes = [scene.add(lm.point_mass(position=(x, y), mass=0.2)) for y in up]
    scene.chain(nodes, latex, surface=lm.Thread(r)).impose_pressure(p)
    low, high = nodes[::24][::way]
    low.fix("y")
    driven.append(high)
for body in driven:
    body.impose_velocity(y=-0.05)
for one in ("GRAIN", "THREAD"):
    scene.see("GRAIN", one, lm.Coulomb(friction=0.5))
    scene.see(one, "WALL", lm.Signorini())

solver = lm.Auto(tolerance=1e-2)
sim = lm.Simulation(scene, time_step=5e-4, solver=solver).run(duration=0.14)
found = []
for _ in range(60):  # from 4 to 8 % of the height
    sim.run(steps=5)
    sides = lm.measure.facets(sim)
    area = (sides.area * sides.normal[:, 0] * sides.position[:, 0]).sum()
    stress = lm.measure.stress(sim, volume=area)["total"] / p
    found.append((-stress[0, 0], -stress[1, 1]))
lateral, axial = np.mean(found, axis=0)
print(f"stress over pressure: lateral {lateral:.3f}, axial {axial:.3f}")
