"""The contact network of a sample: coordination, rattlers, fabric."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.errors import named_arguments
from lmgcpy.measure.moment import Source, moment

CARRYING = 2
"""Least number of contacts through which a body carries a force on. A body with fewer contacts is a rattler."""


@dataclass(frozen=True)
class Network:
    """Contacts that carry force in a step, without links; d dimensions."""

    pairs: np.ndarray
    """Ids of candidate and antagonist of each contact between bodies that carry force, walls included, (c, 2)."""
    coordination: float
    """Mean number of contacts of a body that is no rattler, contacts at walls included; 0 if every body is a rattler."""
    coordination_with_rattlers: float
    """Mean number of contacts of all bodies with bounds and a shape, rattlers and the contacts of rattlers included."""
    rattlers: np.ndarray
    """Ids of the rattlers, the bodies that carry no force, (r,)."""
    fabric: np.ndarray
    """Mean of n (x) n over the contacts, of trace 1, (d, d); zero without contacts."""
    force_fabric: np.ndarray
    """The same, each contact counted by its normal force."""

    def __repr__(self) -> str:
        return (
            f"<Network of {len(self.pairs)} contacts: coordination {self.coordination:.3g}, {len(self.rattlers)} rattlers>"
        )


@named_arguments
def network(sim: Source, *, frame: int | None = None) -> Network:
    """The contact network in the last step of a simulation, or in the step of a ``frame`` of an open run.

    A contact counts if its normal impulse is above zero; of two bodies that touch at several points, as clumps do, each
    point counts. Bodies with fewer than two contacts are rattlers. Their contacts
    are left out, which may make rattlers of other bodies; this is repeated until no rattler has a contact. The measure is
    meant for samples that are pressed together: under gravity a body may rest on a single contact. Walls, and nodes of
    threads, nets and membranes that have no shape of their own, do not count as bodies, but contacts at them count.
    """
    now = moment(sim, frame, "network")
    net = now.net
    acting = (net.impulse[:, 0] > 0.0) & ~now.is_link
    pairs, normal, force = (
        np.column_stack([net.candidate, net.antagonist])[acting],
        net.normal[acting],
        net.force[acting, 0],
    )
    grain = np.isfinite(now.extent) & now.shaped
    every = np.bincount(pairs.ravel(), minlength=len(grain))[grain]
    while True:
        contacts = np.bincount(pairs.ravel(), minlength=len(grain))
        loose = grain & (contacts < CARRYING)
        kept = ~loose[pairs].any(axis=1)
        if kept.all():
            break
        pairs, normal, force = pairs[kept], normal[kept], force[kept]
    carrying = grain & ~loose
    return Network(
        pairs=pairs,
        coordination=float(contacts[carrying].mean()) if carrying.any() else 0.0,
        coordination_with_rattlers=float(every.mean()) if len(every) else 0.0,
        rattlers=np.flatnonzero(loose),
        fabric=np.einsum("ci,cj->ij", normal, normal) / max(len(normal), 1),
        force_fabric=np.einsum("c,ci,cj->ij", force, normal, normal) / (force.sum() or 1.0),
    )
