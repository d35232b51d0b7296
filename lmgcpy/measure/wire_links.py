"""The links of all wires: their positions, directions, slack and tensions."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.errors import named_arguments
from lmgcpy.measure.moment import Moment, Source, moment
from lmgcpy.measure.table import Table


@dataclass(frozen=True, repr=False)
class WireLinks(Table):
    """The l links of all chains, chain after chain, each from its first body to its last; d dimensions."""

    chain: np.ndarray
    """Number of the chain, (l,)."""
    pairs: np.ndarray
    """Ids of candidate and antagonist, (l, 2)."""
    along: np.ndarray
    """Length of wire from the start of the chain up to the middle of the link [m], (l,)."""
    position: np.ndarray
    """Middle of the link [m], (l, d)."""
    direction: np.ndarray
    """Unit vectors from the antagonist to the candidate, (l, d); zero where the two coincide."""
    length: np.ndarray
    """Distance between the centres [m], (l,)."""
    reference_length: np.ndarray
    """Reference gap and both radii [m], (l,)."""
    slack: np.ndarray
    """``(reference length - length) / reference length``, (l,): the strain at which a slack link begins to pull; negative
    for a link that is stretched."""
    tension: np.ndarray
    """Tension, a push negative [N], (l,); NaN before the first step."""

    @property
    def stretch(self) -> np.ndarray:
        """``(length - reference length) / reference length``, (l,): the opposite of the slack."""
        return -self.slack

    @property
    def taut(self) -> np.ndarray:
        """Whether the link pulls, (l,) bool."""
        return self.tension > 0.0


@named_arguments
def wire_links(sim: Source, *, frame: int | None = None) -> WireLinks:
    """The links of all chains after the last step of a simulation, or at a ``frame`` of an open run; empty without chains.

    Lengths and directions are taken at the end of the step, tensions are means over the step. While a chain relaxes to its
    reference (``relaxation=``), the reference length is the one at the end of the relaxation.

    A load of 10 N on a wire of two links:

    >>> import lmgcpy as lm
    >>> scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    >>> beads = [scene.add(lm.disk(radius=0.01, position=(0.0, -0.1 * i), mass=0.5)) for i in range(3)]
    >>> hook = beads[0].fix()
    >>> chain = scene.chain(beads, lm.RigidWire())
    >>> sim = lm.Simulation(scene, time_step=1e-3).run(steps=10)
    >>> lm.measure.wire_links(sim).tension.round(9)
    array([10.,  5.])
    """
    return links_of(moment(sim, frame, "wire_links"))


def links_of(now: Moment) -> WireLinks:
    """The links of a moment."""
    chain, pairs = chain_pairs(now)
    courses = [one.course(now.lattice, now.positions, now.rotations) for one in now.chains]
    branch = np.concatenate([np.zeros((0, now.positions.shape[1])), *(np.diff(course, axis=0) for course in courses)])
    places = [one.places(now.positions, now.rotations)[:-1] for one in now.chains]
    begin = np.concatenate([np.zeros((0, now.positions.shape[1])), *places])
    length = np.linalg.norm(branch, axis=1)
    radius = np.concatenate([np.zeros(0), *(one.radius[:-1] + one.radius[1:] for one in now.chains)])
    reference = now.reference_gaps + radius
    force = now.net.force[: len(pairs), 0] if len(now.net) else np.full(len(pairs), np.nan)
    return WireLinks(
        chain=chain,
        pairs=pairs,
        along=_middles(length, chain),
        position=begin + 0.5 * branch,
        direction=np.divide(branch, length[:, None], out=np.zeros_like(branch), where=length[:, None] > 0.0),
        length=length,
        reference_length=reference,
        slack=1.0 - length / reference,
        tension=0.0 - force,  # slack: 0, not -0
    )


def pulling_links(now: Moment) -> WireLinks:
    """The links of a moment; ValueError if there was no step yet, and so no tension."""
    links = links_of(now)
    if np.isnan(links.tension).any():
        raise ValueError("There is no step yet, and so no tension: run the simulation first, or take a later frame.")
    return links


def chain_pairs(now: Moment) -> tuple[np.ndarray, np.ndarray]:
    """Chain of each link, (l,), and ids of its candidate and antagonist, (l, 2), from the description of the scene: the
    links come first among the interactions, in this order."""
    pairs = [np.column_stack([one.path[1:], one.path[:-1]]) for one in now.chains]
    number = np.repeat(np.arange(len(pairs)), [len(of_chain) for of_chain in pairs])
    return number, np.concatenate([np.zeros((0, 2), dtype=np.int64), *pairs])


def _middles(length: np.ndarray, chain: np.ndarray) -> np.ndarray:
    """Length of wire up to the middle of each link [m], (l,), counted anew in each chain."""
    end = np.cumsum(length)
    first = np.searchsorted(chain, np.arange(chain[-1] + 1 if len(chain) else 0))
    start = np.concatenate([[0.0], end])[first]
    return end - 0.5 * length - start[chain]
