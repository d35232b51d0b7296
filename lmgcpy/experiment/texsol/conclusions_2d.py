"""Conclusions of the 2D study from its records (paper, section 3)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from lmgcpy.experiment.biaxial import BiaxialRecord, Frame


def stiffening(wire: BiaxialRecord, sand: BiaxialRecord, strains: Sequence[float]) -> list[tuple[float, float]]:
    """(crushing, reaction with the wire / reaction of the sand) at the given crushing, to the end of the shorter test."""
    found = []
    for strain in strains:
        if strain <= min(wire.strain[-1], sand.strain[-1]) + 1e-3:
            there = [np.interp(strain, record.strain, record.smooth(record.reaction, 0.005)) for record in (wire, sand)]
            found.append((strain, float(there[0] / there[1])))
    return found


def column(rod: BiaxialRecord, wire: BiaxialRecord, factor: float = 2.0) -> tuple[float | None, float]:
    """(crushing at which the rods' mean reaction first exceeds ``factor`` times the wire's, greatest ratio of the two). The
    crushing is None if the reaction never exceeds it over 0.5 % of crushing without a break.
    """
    strain = rod.strain[rod.strain <= wire.strain[-1]]
    of_wire = np.interp(strain, wire.strain, wire.smooth(wire.reaction))
    ratio = rod.smooth(rod.reaction)[: len(strain)] / of_wire
    above = ratio > factor
    for k in np.flatnonzero(above):
        if above[(strain >= strain[k]) & (strain <= strain[k] + 0.005)].all():
            return float(strain[k]), float(ratio.max())
    return None, float(ratio.max())


def frames_of_column(rod: BiaxialRecord, wire: BiaxialRecord) -> tuple[Frame, Frame] | None:
    """The last frame before the rods' reaction jumps, and the frame of the greatest load after it; None without a jump."""
    where, _ = column(rod, wire)
    earlier = [frame for frame in rod.frames if where is not None and frame.strain < where]
    later = [frame for frame in rod.frames if where is not None and frame.strain >= where]
    return (earlier[-1], max(later, key=lambda frame: frame.top_force)) if earlier and later else None


def compression_in_links(record: BiaxialRecord) -> tuple[float, float]:
    """(share, crushing): the greatest :func:`compressed_share` of the frames, and where."""
    return max([(0.0, 0.0), *((compressed_share(frame), frame.strain) for frame in record.frames)])


def compressed_share(frame: Frame) -> float:
    """Part of the vertical Weber stress that comes from links in compression, over the load on top; 0 without a load."""
    x0, x1, y0, y1 = frame.walls
    chosen = frame.in_wire & (frame.forces > 0.0)
    branch = frame.lines[chosen, 1] - frame.lines[chosen, 0]
    length = np.linalg.norm(branch, axis=1)
    carried = float(np.sum(frame.forces[chosen] * branch[:, 1] ** 2 / length)) / ((x1 - x0) * (y1 - y0))
    total = frame.top_force / (x1 - x0)
    return carried / total if total > 0.0 else 0.0


def frames_at_equal_force(wire: BiaxialRecord, sand: BiaxialRecord) -> tuple[Frame, Frame]:
    """A frame of each test, at the same force on top to 1 %.

    Of all such pairs it is the most crushed one; if there is none, the pair whose forces differ least.
    """
    force = [np.array([frame.top_force for frame in record.frames]) for record in (wire, sand)]
    strain = [np.array([frame.strain for frame in record.frames]) for record in (wire, sand)]
    apart = np.abs(force[0][:, None] - force[1][None]) / np.maximum(force[0][:, None], force[1][None])
    crushed = strain[0][:, None] + strain[1][None]
    rank = np.where(apart <= 0.01, crushed, -apart)
    i, j = np.unravel_index(int(np.argmax(rank)), rank.shape)
    return wire.frames[i], sand.frames[j]
