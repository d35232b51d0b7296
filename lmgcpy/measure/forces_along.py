"""Contact forces along wires and threads, by the length of wire up to the place at which they act."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.errors import named_arguments
from lmgcpy.measure.moment import Moment, Source, moment
from lmgcpy.measure.table import Table

AT_NODE = 1e-9
"""Part of a link, from a node, within which a contact is at the node."""


@dataclass(frozen=True, repr=False)
class ForcesAlong(Table):
    """The c contacts that push on the beads and surfaces of all chains, chain after chain, along each of them."""

    chain: np.ndarray
    """Number of the chain, (c,)."""
    link: np.ndarray
    """Number of the link in its chain, (c,); of a contact at a node, one of the links beside it."""
    along: np.ndarray
    """Length of wire from the start of the chain to the foot of the contact on the axis [m], (c,)."""
    body: np.ndarray
    """Id of the bead, or of the nearest node of the thread, (c,)."""
    other: np.ndarray
    """Id of the other body, (c,)."""
    normal: np.ndarray
    """Normal forces [N], (c,), above 0."""
    tangential: np.ndarray
    """Sizes of the tangential forces [N], (c,)."""
    force_along: np.ndarray
    """Component along the wire, toward its last body, of the force on it [N], (c,)."""
    friction_along: np.ndarray
    """Part of ``force_along`` from the tangential force [N], (c,). The rest is zero on a thread between its nodes."""


@named_arguments
def forces_along(sim: Source, *, frame: int | None = None) -> ForcesAlong:
    """Contact forces along all chains, in the last step of a simulation or in the step of a ``frame`` of an open run.

    With the contact point at ``y`` from the centre of the bead or nearest node, and the normal n, the foot on the axis is
    at ``y - (n . y) n``: the centre of a round bead, and of a thread the place on its axis, as n is across the axis. The
    direction of the wire is the link's, at a node the direction from the node before it to the node after it. A contact of
    two wires counts for each. A contact of a net is on the edge that has the foot. :func:`facets` has the contacts of
    membranes.

    :func:`wire_links` has the tension T by the same ``chain`` and ``along``. With f the ``force_along`` per length,
    a straight wire at rest has ``dT/ds = -f``. Friction acts on the surface: a thread of radius r around a drum of radius R
    has ``dT/ds = -f R / (R + r)`` by the moment about the axis of the drum, and if all of it slides, f is mu times the
    normal force per length, so that the tensions of its ends are as ``exp(mu phi R / (R + r))`` (Euler, 1769, for r = 0).

    ``numpy.histogram(found.along, places, weights=found.normal)`` sums forces between places.

    A thread drawn over a floor:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> nodes = [scene.add(lm.point_mass(position=(0.1 * i, 0.01), mass=0.01)) for i in range(11)]
    >>> chain = scene.chain(nodes, lm.RigidWire(), surface=lm.Thread(radius=0.01))
    >>> floor = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    >>> scene.see("THREAD", "WALL", lm.Coulomb(friction=0.5))
    >>> end = nodes[-1].impose_velocity(x=0.1)
    >>> sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-9)).run(steps=20)
    >>> float(lm.measure.forces_along(sim).friction_along.sum().round(6))  # 0.5 of the weight of 1.1 N
    -0.55
    """
    return forces_of(moment(sim, frame, "forces_along"))


def forces_of(now: Moment) -> ForcesAlong:
    """The forces along the chains of a moment."""
    net, halves = now.net, _Halves.of(now)
    acting = np.flatnonzero((net.impulse[:, 0] > 0.0) & ~now.is_link)
    bodies = np.column_stack([net.candidate, net.antagonist])[acting]
    row, side = np.nonzero(halves.of_body[bodies, 0] >= 0)
    contact, body = acting[row], bodies[row, side]
    local, frames = net.force[contact], net.frame[contact]
    sign = np.where(side == 0, 1.0, -1.0)
    lever, n = net.lever[contact, side], frames[:, 0]
    chosen, reach = halves.nearest(body, lever - np.einsum("cd,cd->c", lever, n)[:, None] * n)
    between = reach > AT_NODE * halves.length[chosen]
    straight = halves.sign[chosen, None] * halves.direction[chosen]
    # n was across the link at the detection, and the link has turned since
    straight = _unit(straight - np.einsum("cd,cd->c", straight, n)[:, None] * n)
    tangent = np.where(between[:, None], straight, halves.chord[chosen])
    rub = sign[:, None] * np.einsum("ck,ckd->cd", local[:, 1:], frames[:, 1:])
    friction = np.einsum("cd,cd->c", rub, tangent)
    chain, along = halves.chain[chosen], halves.along[chosen] + halves.sign[chosen] * reach
    order = np.lexsort((along, chain))
    return ForcesAlong(
        chain=chain[order],
        link=halves.link[chosen][order],
        along=along[order],
        body=body[order],
        other=bodies[row, 1 - side][order],
        normal=local[order, 0],
        tangential=np.linalg.norm(rub, axis=1)[order],
        force_along=(sign * local[:, 0] * np.einsum("cd,cd->c", n, tangent) + friction)[order],
        friction_along=friction[order],
    )


@dataclass(frozen=True)
class _Halves:
    """Each link seen from both of its ends, if the end is a bead or a node of a thread; n bodies, h ends of links."""

    of_body: np.ndarray
    """Ends at each body, (n, k), -1 beyond the last one."""
    chain: np.ndarray
    link: np.ndarray
    along: np.ndarray
    """Length of wire up to the end [m], (h,)."""
    sign: np.ndarray
    """1 at the first end of a link, -1 at its last, (h,)."""
    direction: np.ndarray
    """From this end to the other, (h, d)."""
    length: np.ndarray
    """[m], (h,)."""
    chord: np.ndarray
    """Direction of the wire at this end, from the body before it to the body after it, (h, d)."""

    @classmethod
    def of(cls, now: Moment) -> _Halves:
        """The ends of the links of a moment."""
        count, d = now.positions.shape
        left_out = np.zeros(count, dtype=bool)
        for skin in now.skins:
            if skin["cells"].shape[1] == 3:
                left_out[skin["bodies"]] = ~now.shaped[skin["bodies"]]
        parts: dict[str, list[np.ndarray]] = {
            name: [] for name in ("body", "chain", "link", "along", "sign", "direction", "length", "chord")
        }
        for k, chain in enumerate(now.chains):
            course = chain.course(now.lattice, now.positions, now.rotations)
            branch = np.diff(course, axis=0)
            length = np.linalg.norm(branch, axis=1)
            place = np.concatenate([[0.0], np.cumsum(length)])
            closed = len(chain.path) > 1 and chain.path[0] == chain.path[-1]
            end = np.zeros((1, d))
            before = np.concatenate([branch[-1:] if closed else end, branch])
            after = np.concatenate([branch, branch[:1] if closed else end])
            chord = _unit(before + after)
            first, last = chain.bead[:-1] & ~left_out[chain.path[:-1]], chain.bead[1:] & ~left_out[chain.path[1:]]
            numbers = np.arange(len(branch))
            for mine, at, sign in ((first, np.s_[:-1], 1.0), (last, np.s_[1:], -1.0)):
                seen = chain.path[at], np.full(len(branch), k), numbers, place[at], np.full(len(branch), sign)
                for name, value in zip(parts, (*seen, sign * _unit(branch), length, chord[at]), strict=True):
                    parts[name].append(value[mine])
        empty = {"body": np.int64, "chain": np.int64, "link": np.int64}
        made = {
            name: np.concatenate([np.zeros((0, d) if name in ("direction", "chord") else 0, empty.get(name, float)), *part])
            for name, part in parts.items()
        }
        body = made.pop("body")
        order, uses = np.argsort(body, kind="stable"), np.bincount(body, minlength=count)
        of_body = np.full((count, max(1, int(uses.max(initial=0)))), -1)
        of_body[body[order], np.arange(len(body)) - (np.cumsum(uses) - uses)[body[order]]] = order
        return cls(of_body, **made)

    def nearest(self, body: np.ndarray, offset: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Of the links at bodies (c,) the one nearest to places at ``offset`` (c, d) from these: its end at the body, (c,),
        and how far along the link, from this end, the place is [m], (c,)."""
        chosen, reach, least = self.of_body[body, 0], np.zeros(len(body)), np.full(len(body), np.inf)
        for end in self.of_body[body].T if len(body) else ():
            along = np.clip(np.einsum("cd,cd->c", offset, self.direction[end]), 0.0, self.length[end])
            away = np.where(end >= 0, np.linalg.norm(offset - along[:, None] * self.direction[end], axis=1), np.inf)
            nearer = away < least
            chosen, reach = np.where(nearer, end, chosen), np.where(nearer, along, reach)
            least = np.minimum(least, away)
        return chosen, reach


def _unit(vectors: np.ndarray) -> np.ndarray:
    length = np.linalg.norm(vectors, axis=1)[:, None]
    return np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0.0)
