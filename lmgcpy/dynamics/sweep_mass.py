"""The mass with which a body is swept: its own, or more if it is light and squeezed between heavy ones.

:mod:`lmgcpy.solve.sweeps.light_bodies` says how a solver uses it.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.contact.interactions import Interactions
from lmgcpy.dynamics.model import Model

HEAVY = 32.0
"""A body is heavy beside another one that it touches if its mass is at least this number of times as large. Below that,
sweeps with momentum converge sooner by themselves."""
SHARE, OF_NODE = 0.25, 0.02
"""Mass in the sweep, in parts of the heaviest body touched: of a body, and of a node of a thread, which bears a contact
together with its neighbour. (Sweeps a step of samples of 400 grains with a rigid thread whose nodes are 1/85, 1/130 and
1/255 of a grain: 184, 239, 415 with 0.02; 282, 285, 545 with their own mass; 387, 475, 3259 with 0.1, and there one step in
four was not solved.)"""
TIGHT = 1e-6
"""Up to this tolerance of a solver, bodies are swept with their own mass: for the last digits Newton steps cost less."""
ROUNDS = 3
"""Rounds of a step in which light bodies that stay out of balance are given back their own mass in the sweep."""
PASSES = 2
"""Passes over the pairs: a body may be heavy only because it is swept with a larger mass."""


def pairs_that_meet(interactions: Interactions, first: int) -> tuple[np.ndarray, np.ndarray]:
    """Bodies that meet in the interactions from row ``first`` on: candidates and antagonists, or with an element on a side
    the bodies at its corners."""
    c, a = interactions.candidate[first:], interactions.antagonist[first:]
    corner, count = interactions.corner[first:], interactions.corner.shape[1]
    if not count or not len(corner):
        return c, a
    sign = interactions.weight[first:, :: interactions.weight.shape[1] // count]
    of_c, of_a = [c], [a]
    for k in range(count):
        for mine, others, here in ((of_c, of_a, sign[:, k] > 0.0), (of_a, of_c, sign[:, k] < 0.0)):
            mine.append(corner[here, k])
            others.append((a if mine is of_c else c)[here])
    return np.concatenate(of_c), np.concatenate(of_a)


def sweep_mass(model: Model, interactions: Interactions, tolerance: float, own: np.ndarray) -> np.ndarray | None:
    """M / m of each body (n,), None if all are 1; ``tolerance``: of the solver; ``own``: bodies that
    are swept with their own mass all the same, (n,) bool.

    A body is between heavy ones if it may touch two of them, or one if it is in a chain as well. A node of a thread or
    membrane is not if it may touch one: one ball on a membrane touches many nodes, which all yield, and with their own mass
    a step takes 13 sweeps, with a larger one 11 000. (On a thread what is left of the balance of its nodes is 3 % of the
    weight of a ball that hangs in it, as their load is the tension; with their own mass a hundredth of that.) A wall, and a
    body that is held, can squeeze but gives no mass: it needs no momentum.
    """
    if tolerance <= TIGHT or model.spread < HEAVY:
        return None
    mass = model.movable_mass
    first = sum(chain.link_count for chain in model.links)
    c, a = pairs_that_meet(interactions, first)
    ends, others = np.concatenate([c, a]), np.concatenate([a, c])
    swept = mass.copy()
    share = np.where(model.threaded, OF_NODE, SHARE)
    drawn = model.linked & ~model.nodes
    for _ in range(PASSES):
        heavy = (swept[others] >= HEAVY * mass[ends]) & np.isfinite(mass[ends])
        end, other = ends[heavy], others[heavy]
        # two contacts with one heavy body, as a clump may have, squeeze nothing
        distinct = np.unique(end.astype(np.int64) * len(mass) + other) // len(mass)
        squeezed = np.bincount(distinct, minlength=len(mass)) + drawn > 1
        heaviest = np.zeros(len(mass))
        gives = model.bounded[other] & np.isfinite(swept[other])
        np.maximum.at(heaviest, end[gives], swept[other[gives]])
        swept = np.where(squeezed, np.maximum(mass, share * heaviest), mass)
    more = np.divide(swept, mass, out=np.ones_like(mass), where=np.isfinite(mass) & ~own)
    return more if (more > 1.0).any() else None
