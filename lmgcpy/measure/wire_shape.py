"""The shape of a wire: over what length it keeps its direction, and whether its links prefer one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.errors import named_arguments, numbers, shown
from lmgcpy.writing import html_of_fields


@dataclass(frozen=True)
class WireShape:
    """Two measures of the shape of wires, in d dimensions."""

    persistence_length: float
    """Length over which the mean cosine of the turn falls to 1/e [m]; infinite for straight wires, 0 if the mean cosine of
    the turn from link to link is not positive."""
    anisotropy: float
    """Greatest less smallest principal value of the mean of t (x) t over the links, t their unit directions: 0 if no
    direction is preferred, 1 if all links are parallel. In 2D it is ``|mean exp(2 i theta)|``."""

    def __repr__(self) -> str:
        return f"<WireShape: persistence length {self.persistence_length:.3g} m, anisotropy {self.anisotropy:.3f}>"

    def _repr_html_(self) -> str:
        return html_of_fields(self)


@named_arguments
def wire_shape(positions: Any, chains: Sequence[Any] | None = None) -> WireShape:
    """Measure wires whose beads are at ``positions`` [m], (n, d).

    ``chains``: indices of the beads of each wire, in its order; None: one wire through all of them. A chain whose links of
    length b turn independently by angles of mean cosine c keeps the part ``c^k = exp(-k b / l_p)`` of its direction over k
    links, so that its persistence length is ``l_p = -b / ln c`` (Kratky and Porod 1949). c and b are means over the wires.

    Raises ValueError if no wire has three beads, or if two consecutive beads coincide.
    """
    points = numbers(positions, "positions", "an array (n, d) [m]")
    if points.ndim != 2:
        raise ValueError(f"positions must be an array (n, d) [m], got {shown(positions)}.")
    wires = [np.arange(len(points))] if chains is None else [_indices(chain, len(points)) for chain in _sequence(chains)]
    links = [np.diff(points[wire], axis=0) for wire in wires if len(wire) > 2]
    if not links:
        raise ValueError(
            "The shape of a wire can be measured from three beads on; no wire of these positions and chains has as many."
        )
    lengths = [np.linalg.norm(link, axis=1) for link in links]
    if min(length.min() for length in lengths) == 0.0:
        raise ValueError("positions of two consecutive beads of a wire are the same: their link has no direction.")
    units = [link / length[:, None] for link, length in zip(links, lengths, strict=True)]
    cosine = float(np.mean(np.concatenate([np.sum(unit[1:] * unit[:-1], axis=1) for unit in units])))
    spacing = float(np.mean(np.concatenate(lengths)))
    all_units = np.concatenate(units)
    principal = np.linalg.eigvalsh(all_units.T @ all_units / len(all_units))
    return WireShape(_persistence(spacing, cosine), float(principal[-1] - principal[0]))


def _sequence(chains: Any) -> list[Any]:
    if isinstance(chains, (str, bytes)) or not isinstance(chains, (Sequence, np.ndarray)):
        raise TypeError(f"chains must be a list of the indices of the beads of each wire, got {shown(chains)}.")
    return list(chains)


def _indices(chain: Any, count: int) -> np.ndarray:
    """The beads of a wire among ``count`` positions."""
    given = numbers(chain, "each of the chains", "the indices of the beads of a wire")
    beads = given.astype(np.int64)
    if given.ndim != 1 or (beads != given).any() or ((beads < 0) | (beads >= count)).any():
        raise ValueError(f"Each of the chains must be the indices of its beads, from 0 to {count - 1}, got {shown(chain)}.")
    return beads


def _persistence(spacing: float, cosine: float) -> float:
    """``-b / ln c`` [m]."""
    if cosine <= 0.0:
        return 0.0
    return math.inf if cosine >= 1.0 else -spacing / math.log(cosine)
