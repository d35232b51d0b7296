"""A contactor made outside the package, as a user would: a straight segment with a radius (a capsule), against disks."""

from __future__ import annotations

import math

import lmgcpy as lm


class Segment(lm.Contactor):
    """Points within ``radius`` of the segment from (-half, 0) to (half, 0) in the frame of the contactor [m]."""

    KIND = "test-segment"

    def __init__(self, half: float, radius: float):
        self.half, self.radius = half, radius

    @property
    def shape(self):
        return (self.half, self.radius)

    @property
    def bounding_radius(self):
        return self.half + self.radius

    @property
    def area(self):
        return 4.0 * self.half * self.radius + math.pi * self.radius**2

    @property
    def second_moment(self):
        return 4.0 * self.half**3 * self.radius / 3.0  # slender


def disk_segment(position_c, shape_c, position_a, shape_a):
    """A disk and the nearest point of the segment's axis."""
    cosine, sine = math.cos(position_a[2]), math.sin(position_a[2])
    x, y = position_c[0] - position_a[0], position_c[1] - position_a[1]
    along = min(shape_a[0], max(-shape_a[0], cosine * x + sine * y))
    x, y = x - along * cosine, y - along * sine
    distance = math.sqrt(x * x + y * y)
    n = (-sine, cosine)
    if distance > 0.0:
        n = (x / distance, y / distance)
    gap = distance - shape_c[0] - shape_a[1]
    reach = shape_c[0] + 0.5 * gap
    return gap, n, (position_c[0] - reach * n[0], position_c[1] - reach * n[1])


lm.contact.register_pair("disk", "test-segment", disk_segment)
