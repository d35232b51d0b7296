"""Anchorage of a wire in the sand: contact forces along it, bead by bead, and the slip of its beads through the sand."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.contact.lattice import Lattice, chain_course
from lmgcpy.errors import named_arguments, whole
from lmgcpy.measure.contacts import SLIDING, contact_forces, sliding
from lmgcpy.measure.moment import Moment, Source, moment, motion
from lmgcpy.measure.strain import edges_then_and_now, strain_of
from lmgcpy.measure.table import Table
from lmgcpy.measure.wire_links import links_of

SURROUNDING = {2: 8, 3: 16}
"""Grains around a bead to whose displacements an affine field is fitted, by dimension."""


@dataclass(frozen=True, repr=False)
class WireContacts(Table):
    """The b beads of all chains, chain after chain, and the contacts that push on them."""

    chain: np.ndarray
    """Number of the chain, (b,)."""
    body: np.ndarray
    """Ids, (b,)."""
    along: np.ndarray
    """Length of wire from the start of the chain [m], (b,)."""
    to_end: np.ndarray
    """Length of wire to the nearer end of the chain [m], (b,); infinite in closed chains."""
    length: np.ndarray
    """Length of wire that belongs to the bead, half of its links [m], (b,)."""
    taut: np.ndarray
    """Whether a link of the bead pulls, (b,) bool."""
    contacts: np.ndarray
    """Number of contacts with bodies of no chain, walls included, (b,)."""
    sliding: np.ndarray
    """Number of these contacts that slide, (b,)."""
    normal: np.ndarray
    """Sum of the normal forces of all contacts of the bead [N], (b,)."""
    limit: np.ndarray
    """``sum mu f_n``: the greatest friction that these contacts can give [N], (b,)."""
    force_along: np.ndarray
    """Component of the sum of the contact forces along the wire, toward its last bead [N], (b,)."""
    friction_along: np.ndarray
    """Part of ``force_along`` from tangential forces [N], (b,); the rest is from grains before or behind the bead."""

    @property
    def sliding_share(self) -> float:
        """Share of the contacts of beads with bodies of no chain that slide; NaN without contacts."""
        return _ratio(self.sliding, self.contacts)

    @property
    def force_per_length(self) -> float:
        """Mean of ``|force_along|`` per length of taut wire [N/m], its anchorage. Forces on neighbouring beads may oppose
        each other, so that the resultant over a length is less: see :attr:`TautRuns.anchorage`."""
        return _ratio(np.abs(self.force_along[self.taut]), self.length[self.taut])

    @property
    def friction_per_length(self) -> float:
        """Mean of ``|friction_along|`` per length of taut wire [N/m]."""
        return _ratio(np.abs(self.friction_along[self.taut]), self.length[self.taut])

    @property
    def limit_per_length(self) -> float:
        """Greatest friction per length of taut wire, the mean of ``sum mu f_n`` [N/m]."""
        return _ratio(self.limit[self.taut], self.length[self.taut])


@named_arguments
def wire_contacts(sim: Source, *, frame: int | None = None, tolerance: float = SLIDING) -> WireContacts:
    """Contacts of the beads, in the last step of a simulation or in the step of a ``frame`` of an open run.

    The wire's direction at a bead is the direction from the bead before it to the bead after it. At rest the contacts
    change the tension along the wire: ``T_after - T_before = -force_along``, up to the turn of the wire at the bead and
    its weight. A contact slides if ``|f_t| >= (1 - tolerance) mu f_n``. A contact on a thread counts at the nearest node;
    :func:`forces_along` has the place of each.
    """
    now = moment(sim, frame, "wire_contacts")
    forces, bead = contact_forces(sim, frame=frame), now.beads
    acting = (now.net.impulse[:, 0] > 0.0) & ~now.is_link
    local, frames = now.net.force[acting], now.net.frame[acting]
    pushes = local[:, :1] * frames[:, 0]
    rubs = np.einsum("ck,ckd->cd", local[:, 1:], frames[:, 1:])
    count, d = now.positions.shape
    with_others = ~bead[forces.pairs].all(axis=1)
    mu = np.where(np.isnan(forces.friction), 0.0, forces.friction)

    def of_bodies(values: np.ndarray) -> np.ndarray:
        """Sums over the contacts of each body, (n,)."""
        return sum(np.bincount(forces.pairs[:, side], weights=values, minlength=count) for side in (0, 1))  # type: ignore[return-value]

    push, rub = np.zeros((2, count, d))
    for total, part in ((push, pushes), (rub, rubs)):
        np.add.at(total, forces.pairs[:, 0], part)
        np.add.at(total, forces.pairs[:, 1], -part)
    line = _beads(now, now.positions)
    body, along_wire = line["body"], line.pop("direction")
    friction = np.einsum("bd,bd->b", rub[body], along_wire)
    return WireContacts(
        **line,
        contacts=of_bodies(with_others.astype(float))[body].astype(np.int64),
        sliding=of_bodies((with_others & sliding(forces, tolerance)).astype(float))[body].astype(np.int64),
        normal=of_bodies(forces.normal)[body],
        limit=of_bodies(mu * forces.normal)[body],
        force_along=np.einsum("bd,bd->b", push[body], along_wire) + friction,
        friction_along=friction,
    )


@dataclass(frozen=True, repr=False)
class BeadSlip(Table):
    """The b beads of all chains, chain after chain, and their displacements relative to the sand; d dimensions."""

    chain: np.ndarray
    """Number of the chain, (b,)."""
    body: np.ndarray
    """Ids, (b,)."""
    along: np.ndarray
    """Length of wire from the start of the chain at the beginning [m], (b,)."""
    to_end: np.ndarray
    """Length of wire to the nearer end of the chain [m], (b,); infinite in closed chains."""
    from_mean: np.ndarray
    """Displacement less the displacement by the mean strain of the grains at the bead [m], (b, d)."""
    from_neighbours: np.ndarray
    """Displacement less the affine field fitted to the displacements of the nearest grains [m], (b, d); NaN in scenes with
    too few grains."""
    along_mean: np.ndarray
    """Component of ``from_mean`` along the wire [m], (b,)."""
    along_neighbours: np.ndarray
    """Component of ``from_neighbours`` along the wire [m], (b,): how far the wire has slipped through the sand."""


@named_arguments
def bead_slip(sim: Source, *, frame: int | None = None, since: Any = 0, neighbours: int | None = None) -> BeadSlip:
    """Displacements of the beads relative to the sand around them.

    ``since`` and ``frame`` as in :func:`mean_strain`. ``from_mean`` subtracts the fit of one gradient to all grains (the
    bodies of no chain). ``from_neighbours`` subtracts the fit of an affine field to the ``neighbours`` nearest grains, by
    default 8 in 2D and 16 in 3D; in a periodic cell images count. An affine field gives zero in both, to round-off. The
    second one contains the scatter of the fit: amid n grains that scatter by s independently of each other its error is
    some ``s sqrt(1/n)``.

    Raises ValueError if there are fewer than d + 1 grains.
    """
    now, moved = moment(sim, frame, "bead_slip"), motion(sim, frame, since, "bead_slip")
    d = now.positions.shape[1]
    nearest = whole(SURROUNDING[d] if neighbours is None else neighbours, "neighbours", minimum=d + 1)
    fitted = strain_of(now, moved, kind="grains")
    line = _beads(now, moved.begin)
    body, direction = line["body"], line.pop("direction")
    places, displaced = moved.begin[body], (moved.end - moved.begin)[body]
    from_mean = displaced - fitted.at(places)
    x, u = fitted.position, (moved.end - moved.begin)[fitted.body]
    if now.lattice is None:
        from_neighbours = displaced - _surroundings(places, x, u, nearest)
    else:
        edges = edges_then_and_now(now.lattice, moved.begin, moved.end, fitted.gradient)
        at, away = _in_the_cell(now.lattice, edges, places, displaced)
        from_neighbours = away - _surroundings(at, *_with_images(edges, *_in_the_cell(now.lattice, edges, x, u)), nearest)
    return BeadSlip(
        chain=line["chain"],
        body=body,
        along=line["along"],
        to_end=line["to_end"],
        from_mean=from_mean,
        from_neighbours=from_neighbours,
        along_mean=np.einsum("bd,bd->b", from_mean, direction),
        along_neighbours=np.einsum("bd,bd->b", from_neighbours, direction),
    )


def _in_the_cell(
    lattice: Lattice, edges: tuple[np.ndarray, np.ndarray], x: np.ndarray, u: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Places (m, d) of the images that lay in the periodic cell, and their displacements, (m, d)."""
    before, after = edges
    shift = np.floor(lattice.reduced(x, before))
    return x - shift @ before, u - shift @ (after - before)


def _with_images(edges: tuple[np.ndarray, np.ndarray], x: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Positions x and displacements u of the bodies, and of their images in all neighbouring cells."""
    before, after = edges
    shifts = [np.array(shift, dtype=float) for shift in itertools.product((-1, 0, 1), repeat=len(before))]
    return np.vstack([x + s @ before for s in shifts]), np.vstack([u + s @ (after - before) for s in shifts])


def _surroundings(places: np.ndarray, x: np.ndarray, u: np.ndarray, count: int) -> np.ndarray:
    """Displacements at places (b, d) of affine fields fitted to the displacements u of the nearest grains x, (b, d)."""
    from scipy.spatial import cKDTree  # takes as long to import as the rest of lmgcpy

    if len(x) < count or not len(places):
        return np.full(places.shape, np.nan)
    _, near = cKDTree(x).query(places, k=count)
    dx = x[near] - places[:, None]
    size = np.abs(dx).max(axis=(1, 2), keepdims=True)
    design = np.concatenate([np.ones((*near.shape, 1)), dx / np.where(size > 0.0, size, 1.0)], axis=2)
    # the fit at the bead is its constant: the first row of the pseudo-inverse weighs the grains
    return np.einsum("bk,bkd->bd", np.linalg.pinv(design)[:, 0], u[near])


def _beads(now: Moment, positions: np.ndarray) -> dict[str, np.ndarray]:
    """Columns of the beads, chain after chain, at positions (n, d): chain, body, along, to_end, length, taut, direction."""
    links, d = links_of(now), positions.shape[1]
    columns: dict[str, list[np.ndarray]] = {
        name: [] for name in ("chain", "body", "along", "to_end", "length", "taut", "direction")
    }
    first = 0
    for k, path in enumerate(chain.path for chain in now.chains):
        course = chain_course(now.lattice, positions, path)
        count, closed = len(path) - 1, len(path) > 1 and path[0] == path[-1]
        branch = np.diff(course, axis=0)
        length, pulls = np.linalg.norm(branch, axis=1), links.taut[first : first + count]
        first += count
        place = np.concatenate([[0.0], np.cumsum(length)])
        if closed:
            body, neighbours = path[:-1], np.concatenate([course[:1] - branch[-1:], course])
            own, taut = 0.5 * (length + np.roll(length, 1)), pulls | np.roll(pulls, 1)
            place, to_end = place[:-1], np.full(count, np.inf)
        else:
            body, neighbours = path, np.concatenate([course[:1], course, course[-1:]])
            own = 0.5 * (np.append(length, 0.0) + np.append(0.0, length))
            taut = np.append(pulls, False) | np.append(False, pulls)
            to_end = np.minimum(place, place[-1] - place)
        chord = neighbours[2:] - neighbours[:-2]
        size = np.linalg.norm(chord, axis=1)[:, None]
        direction = np.divide(chord, size, out=np.zeros_like(chord), where=size > 0.0)
        for name, values in zip(columns, (np.full(len(body), k), body, place, to_end, own, taut, direction), strict=True):
            columns[name].append(values)
    empty = {"chain": np.int64, "body": np.int64, "taut": bool}
    return {
        name: np.concatenate([np.zeros((0, d) if name == "direction" else 0, dtype=empty.get(name, float)), *values])
        for name, values in columns.items()
    }


def _ratio(above: np.ndarray, below: np.ndarray) -> float:
    """Sum over sum; NaN over nothing."""
    total = float(below.sum())
    return float(above.sum()) / total if total else float("nan")
