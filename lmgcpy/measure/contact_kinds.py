"""Contacts by the kinds of their bodies, grains, beads of wires or walls: numbers that push and that slide."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.errors import named_arguments, number
from lmgcpy.measure.contact_forces import ContactForces, contact_forces
from lmgcpy.measure.moment import Source, moment
from lmgcpy.measure.table import Table

KINDS = ("grain-grain", "grain-bead", "bead-bead", "wall")
SLIDING = 1e-6
"""A contact counts as sliding if its friction is within this share of ``mu f_n``. Solvers put the impulse of a sliding
contact on its cone to round-off, however loose their tolerance: in a test solved to 1e-2 the same contacts slide with a
share of 1e-12 and of 1e-4; with 1e-2 there are some 3 % more, which are close to sliding but stick."""


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
