"""A hopper of triangles: grains run through it, and a tray bears their weight."""

import numpy as np
import lmgcpy as lm

n = 16
angle = 2.0 * np.pi * np.arange(n) / n
ring = np.column_stack([np.cos(angle), np.sin(angle), 0.0 * angle])
rings = [0.012 * ring, 0.05 * ring + (0, 0, 0.05), 0.05 * ring + (0, 0, 0.12)]
k, j = np.arange(n), (np.arange(n) + 1) % n
below = np.concatenate([np.column_stack(t) for t in ((k, j, j + n), (k, j + n, k + n))])
scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -9.81))
hopper = lm.mesh(np.concatenate(rings), np.concatenate([below, below + n]))
scene.add(hopper)
box = [(-0.06, -0.06), (0.06, -0.06), (0.06, 0.06), (-0.06, 0.06)]
low, high = [(x, y, -0.1) for x, y in box], [(x, y, -0.03) for x, y in box]
tray = [scene.add(lm.plate(low, color="TRAY"))]
for one, other in zip(range(4), (1, 2, 3, 0)):
    corners = [low[one], low[other], high[other], high[one]]
    tray.append(scene.add(lm.plate(corners, color="TRAY")))
grid = 0.0085 * np.arange(-3, 4)
level = [(x, y) for x in grid for y in grid if x * x + y * y < 5e-4]
places = [(x, y, 0.06 + z) for x, y in level for z in grid[3:]]
scene.add_spheres(0.004, places, masses=1e-3)
for other in ("GRAIN", "WALL", "TRAY"):
    scene.see("GRAIN", other, lm.Coulomb(friction=0.2))

sim = lm.Simulation(scene, time_step=5e-4, solver=lm.Auto(tolerance=1e-2))
sim.run(duration=1.2)
left = (sim.positions[-len(places) :, 2] > 0.0).sum()
net, ids = sim.interactions, [body.id for body in tray]
up = (net.force * net.frame[:, :, 2]).sum(axis=1)  # on the candidate
borne = up[np.isin(net.antagonist, ids)].sum() - up[np.isin(net.candidate, ids)].sum()
weight = 9.81e-3 * (len(places) - left)
print(f"{left} grains are left; the tray bears {borne:.3f} N of {weight:.3f} N")
