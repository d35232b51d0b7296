"""Triaxial test in a latex membrane: the strength of a regular packing of spheres.

Spheres that do not turn stand in layers, each on four others (face-centred cubic),
between smooth platens in a membrane under the pressure p. Outside of the ends every
sphere slides on its eight neighbours when the packing fails: sigma_1 / sigma_3 = 2 (1 +
mu) / (1 - mu) (C. Thornton, Geotechnique 29, 1979). If the contacts have the slope
alpha, 45 degrees at the beginning, it is 2 tan(alpha) tan(alpha + phi). The stress of
the latex is left out.
"""

import numpy as np
import lmgcpy as lm

mu, p, d, n, layers = 0.3, 1e3, 0.01, 5, 7  # friction, [Pa], [m], spheres on a side
scene = lm.Scene(dimension=3)
for k in range(layers):
    row = d * (np.arange(n - k % 2) + 0.5 * (k % 2 + 1))
    for x, y in np.stack(np.meshgrid(row, row), axis=-1).reshape(-1, 2):
        at = (x, y, d * (0.5 + k / np.sqrt(2.0)))
        sphere = scene.add(lm.sphere(radius=0.5 * d, position=at, mass=1e-3))
        sphere.fix("spin_x", "spin_y", "spin_z")
high, thin = d * (1.0 + (layers - 1) / np.sqrt(2.0)), 3e-4  # [m], half the latex
scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
top = scene.add(lm.wall(point=(0, 0, high), normal=(0, 0, -1)))
side = n * d + 2 * thin
tall = high - 2 * thin
tube = lm.sample.membrane_around(box=(side, side), height=tall, spacing=0.006)
places = tube.positions + (-thin, -thin, thin)
nodes = [scene.add(lm.point_mass(position=at, mass=1e-4)) for at in places]
latex = lm.ElasticWire(stiffness=500.0)
scene.membrane(nodes, tube.cells, latex, radius=thin).impose_pressure(p)
scene.drag(linear=0.5, bodies=nodes)
scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=mu))
for one, other in ("GRAIN", "MEMBRANE"), ("GRAIN", "WALL"), ("MEMBRANE", "WALL"):
    scene.see(one, other, lm.Signorini())

sim = lm.Simulation(scene, time_step=2e-4, solver=lm.Auto(tolerance=1e-3))
sim.run(duration=0.02)
top.impose_velocity(z=-0.01)
for _ in range(3):
    sim.run(duration=0.02)
    cells = lm.measure.facets(sim)
    inside = (cells.area[:, None] * cells.normal * cells.position)[:, :2].sum() / 2.0
    stress = lm.measure.stress(sim, volume=inside)
    sand = np.diag(stress["total"] - stress["elastic-wire"])
    alpha = np.arcsin((top.position[2] - d) / ((layers - 1) * d))
    known = 2.0 * np.tan(alpha) * np.tan(alpha + np.arctan(mu))
    ratio = 2.0 * sand[2] / (sand[0] + sand[1])
    lateral = np.mean(np.diag(stress["total"])[:2]) / -p
    print(f"ratio {ratio:.3f}, Thornton {known:.3f}; lateral stress {lateral:.3f} p")
