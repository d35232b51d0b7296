"""An hourglass: the rate of flow does not depend on the height above the hole."""

import numpy as np
import lmgcpy as lm

width, hole = 0.1, 0.05  # [m]
scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
radii = lm.sample.grading(600, minimum=0.0025, maximum=0.0035, seed=0)
places = lm.sample.deposit(radii, box=(width, None), seed=0)
for radius, place in zip(radii, places, strict=True):
    scene.add(lm.disk(radius=radius, position=place, mass=2600 * np.pi * radius**2))
for x in np.arange(0.002, width, 0.004):
    if abs(x - 0.5 * width) > 0.5 * hole:
        scene.add(lm.disk(radius=0.004, position=(x, -0.004), mass=1.0)).fix()
scene.add(lm.wall(point=(0.0, 0.0), normal=(1, 0)))
scene.add(lm.wall(point=(width, 0.0), normal=(-1, 0)))
scene.add(lm.wall(point=(0.0, -0.3), normal=(0, 1)))
scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))

solver = lm.Auto(tolerance=1e-2)
sim, out = lm.Simulation(scene, time_step=5e-4, solver=solver), []
for _ in range(3):  # the first 0.1 s is the start, then two equal times
    sim.run(duration=0.15 if out else 0.1)
    out.append((sim.positions[:600, 1] < 0.0).sum())
first, second = np.diff(out)
print(f"grains out: {out[0]}; then, in 0.15 s each, {first} and {second}")
