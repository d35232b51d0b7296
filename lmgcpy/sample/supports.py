"""Names of the supports of a grain: a body by its index in the bed, the floor and the walls by these constants."""

FLOOR = -1
LEFT = -2
RIGHT = -3
FRONT = -4
BACK = -5
NONE = -6

TOLERANCE = 1e-10
"""Overlap, as part of the finest radius, up to which two bodies count as touching."""
