"""Wires in a box, bead after bead: the 3D pre-processor of the paper's section 4."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from lmgcpy import errors
from lmgcpy.errors import AXES
from lmgcpy.sample import arguments
from lmgcpy.sample.laying_3d import REBOUNDED, SKIRTED, SWITCHED, LayingRules, lay
from lmgcpy.sample.wires import Wires

BEAD_TO_GRAIN = 0.2
"""Diameter of a bead in parts of the smallest grain's (paper, section 4): larger beads make a rough wire."""

LONGEST_BOX = 1e6
"""Largest length of a box in radii of a bead, for which round-off of positions stays below 1e-9 of a radius."""

MOST_BEADS = 10**8
"""Largest number of beads of all wires."""


@errors.named_arguments
def wire_3d(
    *,
    box: Any,
    interstice: float,
    bead_count: int,
    bead_radius: float | None = None,
    grain_radii: Any = None,
    theta_max: float = 0.4,
    phi_max: float = 0.15,
    raise_angle: float | None = None,
    switch: bool = True,
    retreats: int = 10_000,
    start: Any = None,
    wires: int = 1,
    obstacles: Any = None,
    seed: Any = 0,
) -> Wires:
    """Wires laid in a box by the six rules of the paper's section 4; z is up.

    Bead n lies at the constant distance s = ``interstice`` + 2 ``bead_radius`` from bead n - 1, in the direction
    (cos phi_n cos theta_n, cos phi_n sin theta_n, sin phi_n) with::

        theta_n = theta_(n-1) + theta_random,   theta_random in [-theta_max, theta_max],
        theta_0 = 0,
        phi_n   = phi_up + phi_random,          phi_random   in [-phi_max, phi_max].

    Skirting: if the bead would intersect a bead or an obstacle, phi_random is drawn from [-2 pi/3, 2 pi/3]. Rebound: if it
    would leave a lateral face of the box, theta_random is drawn from [-2 pi/3, 2 pi/3]. Switch: if it would leave the top
    or the bottom, phi_up changes its sign, unless phi_up leads away from there already; ``switch=False`` makes a wire that
    never turns back. After each of these the bead is drawn anew, at most 200 times. If no free position is found, the wire
    gives up its last 1 to 30 beads and tries again. After ``retreats`` of these it is cut: see :attr:`Wires.cut_wires`,
    :attr:`Wires.lengths` and :attr:`Wires.ends`. ``retreats=0`` cuts the wire at once, as in the paper; a third of the
    wires of 5000 beads measured below then end early, mostly in a corner of the box, out of which a rebound of 2 pi/3 does
    not always lead. Links may cross each other: only beads have a volume.

    ``raise_angle`` is phi_up [rad]; the wire goes up and down as often as its length allows. ``None`` lays it once from
    below upward, as the Texsoleuse raises a bank, and puts its last bead within s of the top of the box. The planned
    height rises by the same amount for every link, and phi_up leads back to it m = 100 links ahead (or at the last bead)::

        sin(phi_up) = (planned height of bead n - 1 + m, less z_(n-1))
                      / (m s sin(phi_max)/phi_max).

    A constant phi_up would miss the top: the heights of the skirting beads, and of all the phi_random, add up.

    ``box``: its three lengths [m], from the origin. ``bead_radius``, ``interstice`` (surface to surface) [m]. Without
    ``bead_radius`` the beads are 20 % as large as the smallest of the grains, whose ``grain_radii`` [m] are a number or
    an array. ``bead_count``: beads of each wire. ``wires``: how many are laid, side by side, a bead of each in turn.
    ``start``: centres of the first beads [m], shape (3,) or (wires, 3); by default at the foot of the face x = 0, evenly
    along y. ``obstacles``: pair (positions, radii) [m] of spheres. Beads overlap nothing by more than round-off.

    Measured for beads of 1 mm, 2.5 mm apart, in a box of 0.1 x 0.1 x 0.2 m, raise_angle=None: 5000 beads are laid in
    3 ms and lie 3 mm (standard deviation) off the planned height, 40 000 beads (50 km/m³) in 40 ms and 12 mm; at some
    60 000 the box is full. 100 000 in a box of 0.5 m: 80 ms.

    The function raises ValueError or TypeError if an argument makes no sense. A wire that is cut is no error.
    """
    lengths = np.array(arguments.box(box, dimensions=(3,), open_top=False))
    radius = _bead_radius(bead_radius, grain_radii)
    arguments.refuse_unfit(tuple(lengths), radius, "a bead", widest=math.inf)
    _refuse_long_box(lengths, radius)
    interstice = errors.number(interstice, "interstice", minimum=0.0, unit="m")
    wire_count = errors.whole(wires, "wires", minimum=1, maximum=MOST_BEADS)
    each = errors.whole(bead_count, "bead_count", minimum=1, maximum=MOST_BEADS // wire_count)
    rules = LayingRules(
        link=interstice + 2.0 * radius,
        theta_max=errors.number(theta_max, "theta_max", minimum=0.0, maximum=math.pi, unit="rad"),
        phi_max=errors.number(phi_max, "phi_max", minimum=0.0, maximum=0.5 * math.pi, unit="rad"),
        raise_angle=math.nan
        if raise_angle is None
        else errors.number(raise_angle, "raise_angle", minimum=-0.5 * math.pi, maximum=0.5 * math.pi, unit="rad"),
        switch=errors.flag(switch, "switch"),
        retreats=errors.whole(retreats, "retreats"),
    )
    centres, obstacle_radii = arguments.obstacles(obstacles, 3)
    first = _first_beads(start, wire_count, lengths, radius)
    _refuse_overlaps(first, radius, centres, obstacle_radii)
    if raise_angle is None:
        _refuse_unreachable_top(first, each, lengths[2] - radius, rules)
    inside = ((centres + obstacle_radii[:, None] > 0.0) & (centres - obstacle_radii[:, None] < lengths)).all(axis=1)
    rng = arguments.generator(seed)

    positions = np.empty((wire_count, each, 3))
    positions[:, 0] = first
    theta, phi, phi_up = np.zeros((3, wire_count, each))
    marks = np.zeros((wire_count, each), np.int64)
    counts = np.empty(wire_count, np.int64)
    lay(
        positions, theta, phi, phi_up, marks, counts, lengths, radius, rules, centres[inside], obstacle_radii[inside], rng
    )  # fmt: skip
    laid = np.arange(each) < counts[:, None]
    return Wires(
        positions=positions[laid],
        radii=np.full(counts.sum(), radius),
        interstice=interstice,
        requested_count=wire_count * each,
        wire_count=wire_count,
        wire=np.repeat(np.arange(wire_count), counts),
        theta=theta[laid],
        phi=phi[laid],
        phi_up=phi_up[laid],
        skirted=(marks[laid] & SKIRTED) > 0,
        rebounded=(marks[laid] & REBOUNDED) > 0,
        switched=(marks[laid] & SWITCHED) > 0,
    )


def _bead_radius(bead_radius: Any, grain_radii: Any) -> float:
    if bead_radius is not None:
        return errors.number(bead_radius, "bead_radius", above=0.0, unit="m")
    if grain_radii is None:
        raise ValueError(
            "wire_3d needs bead_radius [m], or the grain_radii [m] of the sand: then a bead is 20 % of the smallest grain."
        )
    return BEAD_TO_GRAIN * float(arguments.radii(np.ravel(errors.numbers(grain_radii, "grain_radii")), "grain_radii").min())


def _refuse_long_box(lengths: np.ndarray, radius: float) -> None:
    axis = int(np.argmax(lengths))
    if lengths[axis] > LONGEST_BOX * radius:
        raise ValueError(
            f"the length of box along {AXES[axis]} is {lengths[axis]:g} m, more than {LONGEST_BOX:g} radii of a "
            f"bead ({radius:g} m): positions would not be exact. Are both in metres?"
        )


def _first_beads(start: Any, wire_count: int, lengths: np.ndarray, radius: float) -> np.ndarray:
    """Centres of the first beads [m], (wire_count, 3), in the box."""
    highest = np.maximum(radius, lengths - radius)
    if start is None:
        along = radius + (np.arange(wire_count) + 0.5) / wire_count * (highest[1] - radius)
        return np.column_stack((np.full(wire_count, radius), along, np.full(wire_count, radius)))
    first = np.atleast_2d(errors.numbers(start, "start"))
    if first.shape != (wire_count, 3):
        shape = f"({wire_count}, 3)" if wire_count > 1 else "(3,)"
        raise ValueError(f"start must have shape {shape}, got {errors.shown(start)}.")
    if (first < radius).any() or (first > highest).any():
        raise ValueError(f"start must leave a bead, of radius {radius:g} m, inside the box, got {errors.shown(start)}.")
    return first


def _refuse_overlaps(first: np.ndarray, radius: float, centres: np.ndarray, obstacle_radii: np.ndarray) -> None:
    """Refuse first beads that overlap: they are not drawn, so that they have to be free."""
    for number, position in enumerate(first):
        met = np.linalg.norm(first[:number] - position, axis=1) < 2.0 * radius * (1.0 - 1e-12)
        if met.any():
            raise ValueError(
                f"the first beads of wires {np.argmax(met)} and {number} overlap: give start= [m] or take fewer wires."
            )
        met = np.linalg.norm(centres - position, axis=1) < (radius + obstacle_radii) * (1.0 - 1e-12)
        if met.any():
            place = ", ".join(f"{x:g}" for x in position)
            raise ValueError(
                f"the first bead of wire {number}, at ({place}) m, overlaps obstacle {np.argmax(met)}: give another start= "
                "[m]."
            )


def _refuse_unreachable_top(first: np.ndarray, each: int, top: float, rules: LayingRules) -> None:
    """Refuse a wire with raise_angle=None that cannot reach the top: upright links rise by their length times the mean of
    cos(phi_random)."""
    rise = top - float(first[:, 2].min())
    reach = (each - 1) * rules.link * (math.sin(rules.phi_max) / rules.phi_max if rules.phi_max > 0.0 else 1.0)
    if rise > reach:
        raise ValueError(
            f"a wire of {each} beads reaches {reach:.3g} m up, the top of the box is {rise:.3g} m above its start: take "
            "more beads, or give the raise_angle [rad] instead of None."
        )
