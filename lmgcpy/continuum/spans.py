"""Spans of wire that share one tension: they extend the local model to wires that slip along themselves.

A wire in sand transmits its tension along itself as far as the sand lets it. If the sand follows its mean strain, a span
of wire with the directions t(s) stretches by ``N : eps``, with the mean ``N = (1/l) int t (x) t ds`` over the span: parts
that are shortened give way to parts that are lengthened. So in the sums of :class:`~lmgcpy.continuum.wire.WireNetwork` a
span replaces a direction, and N replaces ``n (x) n``: the energy stays convex and the tangent symmetric. Spans of one link
give the local model, spans of whole wires the model of a wire without friction. Stress is still local: the sample is one
material point, larger than a span.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.continuum.tensors import dimension_of, dyads
from lmgcpy.errors import named_arguments, number, numbers, shown


@named_arguments
@dataclass(frozen=True, eq=False, repr=False)
class Spans:
    """Spans of wire, and the share of the wire's length that each represents.

    ``products``: N of each, vectors in Mandel's notation of trace 1 (k, m); ``weights``: (k,), scaled to the sum 1. Raises
    TypeError or ValueError for other shapes, for negative weights or weights that are all zero.
    """

    products: np.ndarray
    weights: np.ndarray

    def __post_init__(self) -> None:
        products = numbers(self.products, "products", "vectors in Mandel's notation (k, m)")
        weights = numbers(self.weights, "weights", "one number for each span")
        if products.ndim != 2 or not len(products):
            raise ValueError(f"products must be of shape (k, 3) or (k, 6), got {products.shape}.")
        d = dimension_of(products.shape[1])
        if np.abs(products[:, :d].sum(axis=1) - 1.0).max() > 1e-9:
            raise ValueError("products must have trace 1, as means of n (x) n have.")
        if weights.shape != (len(products),) or (weights < 0.0).any() or not weights.sum() > 0.0:
            raise ValueError(
                f"weights must be {len(products)} numbers of at least zero, not all zero, got {shown(weights)}."
            )
        object.__setattr__(self, "products", products)
        object.__setattr__(self, "weights", weights / weights.sum())

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return dimension_of(self.products.shape[1])

    def __len__(self) -> int:
        return len(self.weights)

    def __repr__(self) -> str:
        parts = ", ".join(f"{value:.3g}" for value in (self.weights @ self.products)[: self.dimension])
        return f"<Spans: {len(self)} in {self.dimension}D, mean squares of the components {parts}>"


@named_arguments
def spans_of(units: Any, lengths: Any, span: float, chain: Any = None) -> Spans:
    """A span of the length ``span`` [m] around each link of wires; the whole wire if it is shorter.

    ``units``: directions of the links in their order along the wires (l, d); ``lengths``: lengths of the links [m], (l,);
    ``chain``: numbers of their wires, (l,), None if all belong to one wire. At the ends of a wire spans keep their length
    and lie to one side of the link. ``span`` 0 is the link alone. Raises TypeError or ValueError with a sentence.
    """
    directions = numbers(units, "units", "directions of links (l, d)")
    size = numbers(lengths, "lengths", "lengths of links [m]")
    width = number(span, "span", minimum=0.0, unit="m")
    if directions.ndim != 2 or directions.shape[1] not in (2, 3) or not len(directions):
        raise ValueError(f"units must be directions of shape (l, 2) or (l, 3), got {directions.shape}.")
    if size.shape != (len(directions),) or not size.min() > 0.0:
        raise ValueError(f"lengths must be {len(directions)} numbers above zero, got {shown(lengths)}.")
    wires = np.zeros(len(size), dtype=np.int64) if chain is None else numbers(chain, "chain", "numbers of the wires")
    if wires.shape != size.shape:
        raise ValueError(f"chain must be one number for each of the {len(size)} links, got shape {wires.shape}.")
    length = np.linalg.norm(directions, axis=1)
    if not length.min() > 0.0:
        raise ValueError(f"units must not be zero, but number {int(np.argmin(length))} is: it has no direction.")
    parts = dyads(directions / length[:, None])
    products = np.empty_like(parts)
    for wire in np.unique(wires):
        mine = wires == wire
        products[mine] = _means(parts[mine], size[mine], width)
    return Spans(products, size)


def _means(parts: np.ndarray, size: np.ndarray, width: float) -> np.ndarray:
    """Means of parts (l, m) over a width of wire around the middle of each link."""
    ends = np.concatenate([[0.0], np.cumsum(size)])
    total = np.vstack([np.zeros(parts.shape[1]), np.cumsum(parts * size[:, None], axis=0)])
    middle = 0.5 * (ends[1:] + ends[:-1])
    half = np.clip(0.5 * width, 0.5 * size, 0.5 * ends[-1])
    first = np.clip(middle - half, 0.0, ends[-1] - 2.0 * half)
    last = first + 2.0 * half
    # the integral of the directions along the wire is linear within a link
    between = [np.stack([np.interp(at, ends, column) for column in total.T], axis=1) for at in (first, last)]
    return (between[1] - between[0]) / (2.0 * half)[:, None]
