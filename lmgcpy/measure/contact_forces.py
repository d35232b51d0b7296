"""Forces of the contacts that carry some: their distribution and the mobilised friction."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.errors import named_arguments, number, whole
from lmgcpy.measure.moment import Moment, Source, moment
from lmgcpy.measure.table import Table


@dataclass(frozen=True, repr=False)
class ContactForces(Table):
    """The c contacts that push, without links; d dimensions."""

    pairs: np.ndarray
    """Ids of candidate and antagonist, (c, 2)."""
    law: np.ndarray
    """Names of the laws, (c,)."""
    direction: np.ndarray
    """Normals from the antagonist to the candidate, (c, d)."""
    normal: np.ndarray
    """Normal forces [N], (c,), above 0."""
    tangential: np.ndarray
    """Sizes of the tangential forces [N], (c,)."""
    friction: np.ndarray
    """Coefficients of friction of the laws, (c,); NaN of a law without a parameter ``friction``."""

    @property
    def relative(self) -> np.ndarray:
        """Normal forces over their mean, (c,)."""
        return self.normal / self.normal.mean() if len(self) else self.normal

    @property
    def mobilised(self) -> np.ndarray:
        """Part of the friction that is mobilised, ``|f_t| / (mu f_n)``, (c,): 1 if a contact slides; NaN without
        friction."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.friction > 0.0, self.tangential / (self.friction * self.normal), np.nan)

    @named_arguments
    def distribution(self, bins: int = 30, *, largest: float = 6.0) -> tuple[np.ndarray, np.ndarray]:
        """P(f), f the normal force over its mean: centres of ``bins`` bins from 0 to ``largest``, and the density there,
        (bins,) each. The integral of P is the share of the contacts below ``largest``. If these are all contacts, the mean
        of f is 1."""
        edges = np.linspace(0.0, number(largest, "largest", above=0.0), whole(bins, "bins", minimum=1) + 1)
        counts, _ = np.histogram(self.relative, edges)
        return 0.5 * (edges[1:] + edges[:-1]), counts / (max(len(self), 1) * np.diff(edges))


@named_arguments
def contact_forces(sim: Source, *, frame: int | None = None) -> ContactForces:
    """Forces of the contacts that push, in the last step of a simulation or in the step of a ``frame`` of an open run."""
    now = moment(sim, frame, "contact_forces")
    net = now.net
    acting = (net.impulse[:, 0] > 0.0) & ~now.is_link
    force = net.force[acting]
    pairs, law = np.column_stack([net.candidate, net.antagonist])[acting], net.law[acting]
    return ContactForces(
        pairs=pairs,
        law=law,
        direction=net.normal[acting],
        normal=force[:, 0],
        tangential=np.linalg.norm(force[:, 1:], axis=1),
        friction=friction_of(now, pairs, law),
    )


def friction_of(now: Moment, pairs: np.ndarray, law: np.ndarray) -> np.ndarray:
    """Coefficients of friction of contacts, (c,), from their pairs of bodies (c, 2) and the names of their laws (c,). They
    are looked up by the colours of the pair in the visibility table, as several rows may have laws of the same name. A node
    of a thread or membrane has the colour of the surface, and its own if it has a shape; if two fit, the
    answer is NaN."""
    colors, friction = now.colors, np.full(len(pairs), np.nan)
    taken, sure = set(), np.ones(len(pairs), dtype=bool)
    none = np.zeros(len(now.extent), dtype=bool)
    for row in now.scene["visibility"]:
        kind, names = now.scene["laws"][row["law"]], frozenset((row["candidate"], row["antagonist"]))
        if (kind["name"], names) in taken:  # of two rows of the same colours, in older files, the first decided
            continue
        taken.add((kind["name"], names))
        one, other = (colors.get(row[side], none)[pairs] for side in ("candidate", "antagonist"))
        same = (law == kind["name"]) & ((one[:, 0] & other[:, 1]) | (one[:, 1] & other[:, 0]))
        coefficient = kind["parameters"].get("friction")
        if coefficient is None:
            continue
        sure[same] &= np.isnan(friction[same]) | (friction[same] == coefficient)
        friction[same] = coefficient
    return np.where(sure, friction, np.nan)
