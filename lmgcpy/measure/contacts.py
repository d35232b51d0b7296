"""Contacts of a sample: forces and mobilised friction, numbers by the kinds of their bodies, and the contact network."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.errors import named_arguments, number, whole
from lmgcpy.measure.moment import Moment, Source, moment
from lmgcpy.measure.table import Table
from lmgcpy.writing import html_of_fields

KINDS = ("grain-grain", "grain-bead", "bead-bead", "wall")
SLIDING = 1e-6
"""A contact counts as sliding if its friction is within this share of ``mu f_n``. Solvers put the impulse of a sliding
contact on its cone to round-off, however loose their tolerance: in a test solved to 1e-2 the same contacts slide with a
share of 1e-12 and of 1e-4; with 1e-2 there are some 3 % more, which are close to sliding but stick."""

CARRYING = 2
"""Least number of contacts through which a body carries a force on. A body with fewer contacts is a rattler."""


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
    for candidate, antagonist, name, parameters in now.contact_laws:
        names = frozenset((candidate, antagonist))
        if (name, names) in taken:  # of two rows of the same colours, in older files, the first decided
            continue
        taken.add((name, names))
        one, other = (colors.get(color, none)[pairs] for color in (candidate, antagonist))
        same = (law == name) & ((one[:, 0] & other[:, 1]) | (one[:, 1] & other[:, 0]))
        coefficient = parameters.get("friction")
        if coefficient is None:
            continue
        sure[same] &= np.isnan(friction[same]) | (friction[same] == coefficient)
        friction[same] = coefficient
    return np.where(sure, friction, np.nan)


@dataclass(frozen=True, repr=False)
class ContactKinds(Table):
    """The four kinds of contacts that push: two grains, a grain and a bead, two beads, and any body and a wall.

    Beads are the bodies of chains, grains all others with bounds; links are no contacts.
    """

    kind: np.ndarray
    """Words, (4,)."""
    contacts: np.ndarray
    """Number of contacts that push, (4,)."""
    normal: np.ndarray
    """Their mean normal force [N], (4,); NaN without any, as all means."""
    sliding_share: np.ndarray
    """Share of the contacts with friction that slide, (4,)."""
    mobilised: np.ndarray
    """Mean of ``|f_t| / (mu f_n)`` over the contacts with friction, (4,)."""


@named_arguments
def contact_kinds(sim: Source, *, frame: int | None = None, tolerance: float = SLIDING) -> ContactKinds:
    """Contacts by kind, in the last step of a simulation or in the step of a ``frame`` of an open run.

    A contact slides if ``|f_t| >= (1 - tolerance) mu f_n``. A contact without friction counts neither as sliding nor as
    sticking.
    """
    now = moment(sim, frame, "contact_kinds")
    forces = contact_forces(sim, frame=frame)
    bead, wall = now.beads[forces.pairs].sum(axis=1), ~np.isfinite(now.extent)[forces.pairs].all(axis=1)
    kind = np.where(wall, KINDS.index("wall"), bead)
    slides, mobilised = sliding(forces, tolerance), forces.mobilised
    rubs = ~np.isnan(mobilised)
    chosen = [kind == k for k in range(len(KINDS))]
    return ContactKinds(
        kind=np.array(KINDS),
        contacts=np.array([int(those.sum()) for those in chosen]),
        normal=np.array([_mean(forces.normal[those]) for those in chosen]),
        sliding_share=np.array([_mean(slides[those & rubs]) for those in chosen]),
        mobilised=np.array([_mean(mobilised[those & rubs]) for those in chosen]),
    )


def sliding(forces: ContactForces, tolerance: float = SLIDING) -> np.ndarray:
    """Whether each contact slides, (c,) bool; False for contacts without friction."""
    return forces.mobilised >= 1.0 - number(tolerance, "tolerance", minimum=0.0, maximum=1.0)


def _mean(values: np.ndarray) -> float:
    return float(values.mean()) if len(values) else float("nan")


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

    def _repr_html_(self) -> str:
        return html_of_fields(self)


@named_arguments
def network(sim: Source, *, frame: int | None = None) -> Network:
    """The contact network in the last step of a simulation, or in the step of a ``frame`` of an open run.

    A contact counts if its normal impulse is above zero; of two bodies that touch at several points, as clumps do, each
    point counts. Bodies with fewer than two contacts are rattlers. Their contacts
    are left out, which may make rattlers of other bodies; this is repeated until no rattler has a contact. The measure is
    meant for samples that are pressed together: under gravity a body may rest on a single contact. Walls, and nodes of
    threads, nets and membranes that have no shape of their own, do not count as bodies, but contacts at them count. Hidden
    bodies do not count.
    """
    now = moment(sim, frame, "network")
    net = now.net
    acting = (net.impulse[:, 0] > 0.0) & ~now.is_link
    pairs, normal, force = (
        np.column_stack([net.candidate, net.antagonist])[acting],
        net.normal[acting],
        net.force[acting, 0],
    )
    grain = now.bounded & now.shaped
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
