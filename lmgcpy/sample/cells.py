"""The names of the supports of a grain, and the lists of bodies by cells: the beds of all deposits share them.

A body that supports a grain is named by its index in the bed, the floor and the walls by the constants below.

``first`` holds the latest item of each cell, -1 for an empty cell; ``following`` holds the next item in the same cell, -1
at the end of the list. A cell is named by whatever indexes ``first``: row and column, a layer as well, or a hash.
"""

FLOOR = -1
LEFT = -2
RIGHT = -3
FRONT = -4
BACK = -5
NONE = -6

TOLERANCE = 1e-10
"""Overlap, as part of the finest radius, up to which two bodies count as touching."""


def cell_of(coordinate, size, count):
    """Layer, row or column of a coordinate [m] among ``count`` cells of a ``size`` [m]; outside, the nearest one."""
    if coordinate <= 0.0:
        return 0
    return min(int(min(coordinate / size, 1e9)), count - 1)


def put(first, following, cell, item):
    """Put an item into a cell."""
    following[item] = first[cell]
    first[cell] = item


def take_out(first, following, cell, item):
    """Take an item out of its cell."""
    if first[cell] == item:
        first[cell] = following[item]
        return
    before = first[cell]
    while following[before] != item:
        before = following[before]
    following[before] = following[item]
