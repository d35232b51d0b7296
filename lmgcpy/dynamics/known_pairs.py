"""Radii and masses of the bodies of each interaction, for laws that ask for them."""

from __future__ import annotations

import numpy as np

from lmgcpy.contact.detector import Group
from lmgcpy.contact.narrow_phase import Interactions
from lmgcpy.dynamics.model import Model
from lmgcpy.laws.pair import asks_for_pair


def known_pairs(groups: list[Group], interactions: Interactions, model: Model) -> np.ndarray:
    """Radii [m] and masses [kg] of candidates and antagonists, (m, 4); (0, 4) if no law of the scene asks.

    Only the rows of laws that ask, and of laws with rolling components, are filled.
    """
    d = model.dimension
    asking = [group for group in groups if group.stop > group.start and (asks_for_pair(group.law) or group.law.rows(d) > d)]
    if not asking:
        return np.zeros((0, 4))
    result = np.full((len(interactions.gap), 4), np.nan)
    for group in asking:
        part = slice(group.start, group.stop)
        bodies = np.column_stack([interactions.candidate[part], interactions.antagonist[part]])
        if group.chain is not None:
            result[part, :2] = model.radius[bodies]
        else:
            result[part, :2] = model.contactors.radius[group.pairs[interactions.slot[part] - group.first_slot]]
        result[part, 2:] = model.movable_mass[bodies]
    return result
