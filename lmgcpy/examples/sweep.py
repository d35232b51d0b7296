"""A sweep over a parameter: a disk slides or rolls down a slope."""

import math
import lmgcpy as lm


def run(friction, angle=math.pi / 4):
    """Acceleration of a disk on a slope [m/s^2]."""
    gravity = (9.81 * math.sin(angle), -9.81 * math.cos(angle))
    scene = lm.Scene(dimension=2, gravity=gravity)
    disk = scene.add(lm.disk(radius=0.1, position=(0.0, 0.1), mass=1.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    lm.Simulation(scene, time_step=1e-3).run(duration=0.5)
    return disk.velocity[0] / 0.5


for friction in (0.0, 0.1, 0.2, 0.3, 0.4, 0.8):
    sliding = 9.81 * (1.0 - friction) * math.sqrt(0.5)
    rolling = 9.81 * 2 / 3 * math.sqrt(0.5)  # from a friction of tan(45 degrees)/3 on
    print(f"{friction:.1f}  {run(friction):.4f}  {max(sliding, rolling):.4f}")
