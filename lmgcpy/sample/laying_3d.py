"""The compiled walk of :func:`lmgcpy.sample.wire_3d`: bead after bead by the rules of the paper's section 4."""

# no `from __future__ import annotations`: the fingerprint of a kernel reads the fields of the named tuples it takes
import math
from typing import NamedTuple

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.compiled.reference import by_reference
from lmgcpy.sample.cells import put, take_out

SKIRTED, REBOUNDED, SWITCHED = 1, 2, 4
"""Bits of a mark, one for each rule by which a bead was laid."""

AHEAD = 100
"""Number of links after which a wire that ends at the top is back at its planned height. With 10 links the height is held
three times as well, but phi_up varies twice as much and a box holds a sixth less wire."""

WIDE = 2.0 * math.pi / 3.0
"""Range [rad] of the random angle where a bead skirts the chain or rebounds."""

TRIALS = 200
"""Number of draws of a bead before its wire goes back."""

RETREAT_LENGTH = 30
"""Largest number of beads that are given up at once."""


@by_reference
class LayingRules(NamedTuple):
    """Parameters of the rules; lengths [m], angles [rad]."""

    link: float
    """Distance between the centres of consecutive beads."""
    theta_max: float
    phi_max: float
    raise_angle: float
    """Raise angle at the start, or NaN if the wire ends at the top."""
    switch: bool
    retreats: int
    """Number of times a wire may go back before it is cut."""


class SphereCells(NamedTuple):
    """Spheres [m] in cells; see :mod:`lmgcpy.sample.cells`. A hash names the cell, so that an empty box costs nothing."""

    positions: np.ndarray
    """Centres, (n, 3)."""
    radii: np.ndarray
    edge: float
    """Edge of a cell: twice the largest distance of two centres in contact. A bead looks into at most eight cells."""
    first: np.ndarray
    """Latest sphere of each hash, or -1; their number is a power of two."""
    following: np.ndarray
    """Next sphere of the same hash, or -1, (n,)."""


@kernel
def lay(positions, theta, phi, phi_up, marks, counts, lengths, radius, rules, obstacle_positions, obstacle_radii, rng):
    """Lay wires side by side, a bead of each in turn, from the first beads in ``positions``, (wires, beads, 3), on.

    Fills ``theta``, ``phi``, ``phi_up`` and ``marks``, (wires, beads), and ``counts``, (wires,): the beads of each.
    """
    wire_count, bead_count, _ = positions.shape
    beads = spheres(positions.reshape(-1, 3), np.full(wire_count * bead_count, radius), radius)
    obstacles = spheres(obstacle_positions, obstacle_radii, radius)
    for i in range(len(obstacle_radii)):
        enter(obstacles, i)
    for wire in range(wire_count):
        enter(beads, wire * bead_count)
        phi_up[wire, 0] = 0.0 if math.isnan(rules.raise_angle) else rules.raise_angle
        counts[wire] = 1
    planned_rises = (max(radius, lengths[2] - radius) - positions[:, 0, 2]) / max(1, bead_count - 1)
    retreats = np.zeros(wire_count, np.int64)
    for wanted in range(2, bead_count + 1):
        for wire in range(wire_count):
            while counts[wire] < wanted and retreats[wire] <= rules.retreats:
                n = counts[wire]
                bead = wire * bead_count + n
                found, x, y, z, theta[wire, n], phi[wire, n], phi_up[wire, n], marks[wire, n] = drawn_bead(
                    beads, obstacles, bead, theta[wire, n - 1], phi_up[wire, n - 1], bead_count - n,
                    planned_rises[wire], lengths, radius, rules, rng,
                )  # fmt: skip
                if found:
                    positions[wire, n, 0], positions[wire, n, 1], positions[wire, n, 2] = x, y, z
                    enter(beads, bead)
                    counts[wire] += 1
                    continue
                if retreats[wire] < rules.retreats:
                    counts[wire] = max(1, n - 1 - retreats[wire] % RETREAT_LENGTH)
                    for given_up in range(n - 1, counts[wire] - 1, -1):
                        leave(beads, wire * bead_count + given_up)
                retreats[wire] += 1


def drawn_bead(beads, obstacles, bead, theta_before, phi_up, links_left, planned_rise, lengths, radius, rules, rng):
    """Draw a bead that is free: (found, x, y, z, theta, phi, phi_up, mark).

    ``links_left``: number of this link and of the links after it. ``planned_rise``: rise of one link of a wire that ends at
    the top [m].
    """
    start = beads.positions[bead - 1]
    lowest, highest = radius, max(radius, lengths[2] - radius)
    to_top = math.isnan(rules.raise_angle)
    if to_top:
        # Mean rise of an upright link; over the draws the mean of sin(phi) is sin(phi_up) sin(phi_max)/phi_max.
        mean_rise = rules.link * (math.sin(rules.phi_max) / rules.phi_max if rules.phi_max > 0.0 else 1.0)
        ahead = min(AHEAD, links_left)
        # Raise angle that leads back to the planned height, ``ahead`` links on.
        aim = highest - (links_left - ahead) * planned_rise
        phi_up = math.asin(max(-1.0, min(1.0, (aim - start[2]) / (ahead * mean_rise))))
        # Below this height the beads that are left cannot reach the top.
        lowest = max(lowest, highest - rules.link - (links_left - 1) * mean_rise)
    phi_up_before = phi_up
    turn, tilt, mark = rules.theta_max, rules.phi_max, 0
    for _ in range(TRIALS):
        theta = theta_before + rng.uniform(-turn, turn)
        phi = phi_up + rng.uniform(-tilt, tilt)
        x = start[0] + rules.link * math.cos(phi) * math.cos(theta)
        y = start[1] + rules.link * math.cos(phi) * math.sin(theta)
        z = start[2] + rules.link * math.sin(phi)
        # Rebound at a lateral face, switch at the top or bottom, skirting at a bead or obstacle; else the bead is free.
        if x < radius or y < radius or x > lengths[0] - radius or y > lengths[1] - radius:
            turn = WIDE
            mark |= REBOUNDED
        elif z < lowest or z > highest:
            if rules.switch and not to_top:
                phi_up = abs(phi_up) if z < lowest else -abs(phi_up)
        elif meets(beads, x, y, z, radius, bead - 1) or meets(obstacles, x, y, z, radius, -1):
            tilt = WIDE
            mark |= SKIRTED
        else:
            if phi_up != phi_up_before:
                mark |= SWITCHED
            return True, x, y, z, theta, phi, phi_up, mark
    return False, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0


def spheres(positions, radii, radius):
    """Cells for spheres that a sphere of ``radius`` may meet; none is entered yet."""
    largest = radius
    for i in range(len(radii)):
        largest = max(largest, radii[i])
    hashes = 16
    while hashes < 2 * len(radii):
        hashes *= 2
    return SphereCells(
        positions, radii, 2.0 * (radius + largest), np.full(hashes, -1, np.int64), np.full(len(radii), -1, np.int64)
    )


def enter(those, i):
    """Enter sphere i into its cell."""
    x, y, z = those.positions[i]
    # The hash is not a function of its own: that takes 16 % more time for a wire of 5000 beads.
    h = hashed(cell(x, those.edge), cell(y, those.edge), cell(z, those.edge), those.first)
    put(those.first, those.following, h, i)


def leave(those, i):
    """Take sphere i out of its cell."""
    x, y, z = those.positions[i]
    h = hashed(cell(x, those.edge), cell(y, those.edge), cell(z, those.edge), those.first)
    take_out(those.first, those.following, h, i)


def meets(those, x, y, z, radius, but):
    """Whether a sphere at (x, y, z) meets any other than number ``but``."""
    edge = those.edge
    half = 0.5 * edge
    for k in range(cell(z - half, edge), cell(z + half, edge) + 1):
        for j in range(cell(y - half, edge), cell(y + half, edge) + 1):
            for i in range(cell(x - half, edge), cell(x + half, edge) + 1):
                other = those.first[hashed(i, j, k, those.first)]
                while other >= 0:
                    d_x = x - those.positions[other, 0]
                    d_y = y - those.positions[other, 1]
                    d_z = z - those.positions[other, 2]
                    reach = radius + those.radii[other]
                    if d_x * d_x + d_y * d_y + d_z * d_z < reach * reach and other != but:
                        return True
                    other = those.following[other]
    return False


def cell(x, edge):
    """Number of the cell of a coordinate, along one axis."""
    return math.floor(x / edge)


def hashed(i, j, k, first):
    """Hash of a cell; large primes keep neighbours apart."""
    return (i * 73856093 ^ j * 19349663 ^ k * 83492791) & (len(first) - 1)
