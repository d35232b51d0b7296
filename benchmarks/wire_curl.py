"""How far a laid wire keeps its direction, and how evenly it fills the sample, against its greatest turn.

Forty wires of 300 beads for each turn, as the default 2D study lays them. The order within a part is ``|mean exp(2 i
theta)|^2`` over the links in a sixteenth of the sample, over the 1/n that n independent links have in the mean; the
unevenness is the variance of the numbers of beads in the sixteenths over their mean.

    python benchmarks/wire_curl.py
"""

from __future__ import annotations

import numpy as np
from table import report

from lmgcpy.measure import wire_shape
from lmgcpy.sample import wire_2d

BOX, WIRES, PARTS = (0.68, 0.66), 40, 4
"""Sizes of the box of the default study [m], wires for each turn, parts along each axis."""
LEAST_LINKS = 3
"""Parts with fewer links say nothing of order."""


def order(positions: np.ndarray) -> tuple[float, float]:
    """Mean over the parts of ``|mean exp(2 i theta)|^2``, and of what independent links have."""
    links = np.diff(positions, axis=0)
    directions = np.exp(2j * np.arctan2(links[:, 1], links[:, 0]))
    cell = np.minimum((0.5 * (positions[1:] + positions[:-1]) / BOX * PARTS).astype(int), PARTS - 1)
    part = cell[:, 0] * PARTS + cell[:, 1]
    inside = [directions[part == k] for k in range(PARTS**2)]
    inside = [of_part for of_part in inside if len(of_part) >= LEAST_LINKS]
    return float(np.mean([abs(d.mean()) ** 2 for d in inside])), float(np.mean([1.0 / len(d) for d in inside]))


def main() -> None:
    rows = []
    for turn in (0.2, 0.6, 1.2, 2.0, 2.6):
        lengths, orders, uneven = [], [], []
        for seed in range(WIRES):
            wire = wire_2d(box=BOX, bead_radius=0.0075, interstice=0.02, bead_count=300, theta_max=turn, seed=seed)
            lengths.append(wire_shape(wire.positions).persistence_length / BOX[0])
            orders.append(order(wire.positions))
            counts = np.histogram2d(*wire.positions.T, bins=PARTS, range=[[0, size] for size in BOX])[0]
            uneven.append(counts.var() / counts.mean())
        ours, independent = np.mean(orders, axis=0)
        rows.append([turn, f"{np.median(lengths):.2f}", f"{ours / independent:.1f}", f"{np.mean(uneven):.2f}"])
    report("wire_curl", ["greatest turn [rad]", "persistence length / width", "order / independent", "unevenness"], rows)


if __name__ == "__main__":
    main()
