"""A contactor of one's own: a disk rolls down a plank at 2/3 g sin(slope)."""

import math
import lmgcpy as lm


class Plank(lm.Contactor):
    """Points of the upper side of a plank, from -half to half [m]."""

    KIND = "plank"

    def __init__(self, half):
        self.half = half

    @property
    def shape(self):
        return (self.half,)

    bounding_radius = property(lambda self: self.half)
    area = property(lambda self: 2e-3 * self.half)
    second_moment = property(lambda self: 2e-3 * self.half**3 / 3)
    outline = property(lambda self: [[(-self.half, 0.0), (self.half, 0.0)]])


def disk_on_plank(position_c, shape_c, position_a, shape_a):
    """Between a disk and the nearest point of the plank's side."""
    c, s = math.cos(position_a[2]), math.sin(position_a[2])
    x, y = position_c[0] - position_a[0], position_c[1] - position_a[1]
    along = min(shape_a[0], max(-shape_a[0], c * x + s * y))
    x, y = x - along * c, y - along * s
    distance = math.sqrt(x * x + y * y)
    n = (x / distance, y / distance) if distance > 0.0 else (-s, c)
    gap = distance - shape_c[0]
    arm = shape_c[0] + 0.5 * gap
    return gap, n, (position_c[0] - arm * n[0], position_c[1] - arm * n[1])


lm.contact.register_pair("disk", "plank", disk_on_plank)

slope = math.radians(20.0)
scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
start = {"position": (0.0, 0.0), "rotation": slope, "color": "PLANK"}
scene.add(lm.RigidBody([Plank(1.0)], mass=1.0, inertia=1.0, **start)).fix()
above = (-0.1 * math.sin(slope), 0.1 * math.cos(slope))
disk = scene.add(lm.disk(radius=0.1, position=above, mass=1.0))
scene.see("GRAIN", "PLANK", lm.Coulomb(friction=0.5))
sim = lm.Simulation(scene, time_step=1e-3).run(duration=0.5)
speed = math.hypot(*disk.velocity)
print(f"speed {speed:.4f}, rolling: {2 / 3 * 9.81 * math.sin(slope) * 0.5:.4f} m/s")
