"""Using a sample again: settled once, then tilted."""

import numpy as np
import lmgcpy as lm

radii = lm.sample.grading(150, minimum=0.004, maximum=0.006, seed=0)


def box(places, tilt, friction):
    """The grains in a box that is tilted by an angle [rad]."""
    gravity = 9.81 * np.array([np.sin(tilt), -np.cos(tilt)])
    scene = lm.Scene(dimension=2, gravity=gravity)
    for radius, place in zip(radii, places, strict=True):
        mass = 2600 * np.pi * radius**2
        scene.add(lm.disk(radius=radius, position=place, mass=mass))
    for point, normal in (((0, 0), (0, 1)), ((0, 0), (1, 0)), ((0.2, 0), (-1, 0))):
        scene.add(lm.wall(point=point, normal=normal))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=friction))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    return lm.Simulation(scene, time_step=1e-3)


laid = lm.sample.deposit(radii, box=(0.2, None), seed=0)
box(laid, tilt=0.0, friction=0.5).run(duration=0.5, record="settled.h5", every=100)
with lm.io.open_run("settled.h5") as run:
    settled = run.positions[-1][: len(radii)]
for degrees in (0, 40):
    sim = box(settled, tilt=np.radians(degrees), friction=0.5).run(duration=0.2)
    way = np.linalg.norm(sim.positions[: len(radii)] - settled, axis=1)
    print(f"tilted by {degrees} degrees: grains move by {1e3 * way.mean():.3f} mm")
