"""A sample in a latex tube: its lateral stress is the pressure outside."""

import numpy as np
import lmgcpy as lm

p, R, H, r = 1e3, 0.03, 0.06, 0.004  # pressure [Pa], sizes of sample and grains [m]
scene = lm.Scene(dimension=3)
side = 2.1 * r
layer = side * np.stack(np.meshgrid(*2 * [np.arange(-3, 4)]), axis=-1).reshape(-1, 2)
layer = layer[np.linalg.norm(layer, axis=1) < R - 1.3 * r]
for z in np.arange(r, H - r, side):
    for x, y in layer:
        scene.add(lm.sphere(radius=r, position=(x, y, z), mass=1e-3))
scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
top = scene.add(lm.wall(point=(0, 0, H), normal=(0, 0, -1), mass=0.1))
top.impose_force(z=-p * np.pi * R**2)
tube = lm.sample.membrane_around(radius=R, height=H - 0.001, spacing=0.01)
places = tube.positions + [0.0, 0.0, 0.0005]  # its rims are round
nodes = [scene.add(lm.point_mass(position=at, mass=1e-4)) for at in places]
latex = lm.ElasticWire(stiffness=100.0)
scene.membrane(nodes, tube.cells, latex, radius=0.0005).impose_pressure(p)
for other in ("GRAIN", "WALL", "MEMBRANE"):
    scene.see("GRAIN", other, lm.Coulomb(friction=0.1))
scene.see("MEMBRANE", "WALL", lm.Signorini())
scene.drag(linear=0.5, bodies=[b for b in scene.bodies if b is not top])

sim = lm.Simulation(scene, time_step=2e-4).run(duration=0.3)
cells = lm.measure.facets(sim)
volume = (cells.area[:, None] * cells.normal * cells.position)[:, :2].sum() / 2.0
stress = lm.measure.stress(sim, volume=volume)["total"] / 1e3
lateral = -0.5 * (stress[0, 0] + stress[1, 1])
print(f"lateral stress {lateral:.3f} kPa, pressure {p / 1e3:.3f} kPa")
