"""How far a heap has run out and how high it still is, from its grains."""

from __future__ import annotations

import numpy as np

COVERED = 0.5
"""Least part of a ring of the ground that grains cover, seen from above, inside the front."""


def holding(share: float, coordinate: np.ndarray, mass: np.ndarray) -> float:
    """Smallest coordinate of a grain [m] up to which a ``share`` of the mass has its centres.

    ``coordinate``: distance from the axis, or height [m], and ``mass`` of the grains, (n,).
    """
    order = np.argsort(coordinate, kind="stable")
    held = np.cumsum(mass[order])
    # round-off of the sum must not ask for more than there is
    return float(coordinate[order][min(np.searchsorted(held, share * held[-1]), len(order) - 1)])


def front(distance: np.ndarray, radii: np.ndarray, ring: float) -> float:
    """Radius [m] out to which the ground is covered without a break.

    The ground is divided into rings of width ``ring`` [m] around the axis. A ring is covered if the cross-sections of the
    grains whose centres lie above it make up half its area; single grains that ran ahead do not count. The front
    lies between the last covered ring and the next, by linear interpolation of their covers. ``distance`` from the axis
    and ``radii`` [m], (n,).
    """
    number = (distance / ring).astype(np.int64)
    count = int(number.max()) + 2
    sections = np.bincount(number, weights=radii**2, minlength=count)
    cover = np.minimum(sections / (ring**2 * (2.0 * np.arange(count) + 1.0)), 1.0)
    first = int(np.argmax(cover < COVERED))  # it exists, as the outermost ring is empty
    if first == 0:
        return 0.0
    inner, outer = cover[first - 1], cover[first]
    return float(ring * (first - 0.5 + (inner - COVERED) / (inner - outer)))


def dry_run_out(aspect: float) -> float:
    """Run-out of dry sand, (front - radius) / radius, for an ``aspect`` height / radius.

    1.24 a up to a = 1.7 and 1.6 sqrt(a) beyond, measured on round columns of several materials on several grounds (Lube,
    Huppert, Sparks, Hallworth 2004, J. Fluid Mech. 508, 175-199).
    """
    return 1.24 * aspect if aspect < 1.7 else 1.6 * aspect**0.5
