"""Stress of a granular sample by Weber's definition, in total and by interaction law (paper, section 3)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lmgcpy.errors import number

if TYPE_CHECKING:
    from lmgcpy.dynamics.simulation import Simulation


def stress(sim: Simulation, *, volume: float | None = None) -> dict[str, np.ndarray]:
    """``sigma = -(1/V) sum f (x) l`` over the interactions of the last step [Pa], traction positive.

    ``f`` is the force on the candidate, ``l`` the vector from the antagonist's centre to the candidate's; at a wall it
    starts, or ends, at the contact point. Returns ``{"total": (d, d), "<NAME>": (d, d), ...}``, one entry for each law
    that the scene knows.

    ``volume`` [m^3, per metre of depth in 2D]: by default that of the box between two pairs of opposite walls; a scene
    without them raises ValueError, which asks for it.
    """
    volume = box_volume(sim) if volume is None else number(volume, "volume", above=0.0)
    net = sim.interactions
    unbounded = ~np.isfinite(sim.model.extent)
    force = np.einsum("mk,mkd->md", net.force, net.frame)
    start = np.where(unbounded[net.antagonist, None], 0.0, net.lever[:, 1])
    end = np.where(unbounded[net.candidate, None], 0.0, net.lever[:, 0])
    branch = start - end
    dyads = -force[:, :, None] * branch[:, None, :] / volume
    names = [chain.law.NAME for chain in sim.model.chains] + [row.law.NAME for row in sim.model.rows]
    parts = {name: dyads[net.law == name].sum(axis=0) for name in dict.fromkeys(names)}
    return {"total": dyads.sum(axis=0), **parts}


def box_volume(sim: Simulation) -> float:
    """Volume of the box between the walls [m^3, per metre of depth in 2D]: the product of the distances between walls
    that face each other; ValueError unless there is one such pair in each direction, at right angles."""
    walls = [(normal, sim.positions[body]) for body, normal in sim.model.wall_normals.items()]
    pairs = [
        (n, abs(float(np.dot(n, q - p))))
        for i, (n, p) in enumerate(walls)
        for m, q in walls[i + 1 :]
        if np.allclose(n, -m, atol=1e-12)
    ]
    dimension = sim.model.dimension
    directions = np.array([n for n, _ in pairs]).reshape(-1, dimension)
    if len(pairs) != dimension or not np.allclose(directions @ directions.T, np.eye(dimension), atol=1e-9):
        raise ValueError(
            f"The volume of this sample is not that of a box: {len(pairs)} pairs of walls face each other where "
            f"{dimension} at right angles are needed. Give volume= [m^{dimension}]."
        )
    return float(np.prod([distance for _, distance in pairs]))


def principal(sigma: np.ndarray) -> np.ndarray:
    """Principal values of the symmetric part of a stress tensor, greatest (most tensile) first [Pa], (d,)."""
    return np.linalg.eigvalsh(0.5 * (sigma + sigma.T))[::-1]
