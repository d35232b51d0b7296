"""Bodies that are driven into each other. No impulse can keep two bodies apart of which neither yields along the normal of
their contact: detection leaves such pairs out, as no law could act, and they overlap.

Such overlaps are looked for if a body is driven by a velocity other than zero and sees another one that is held or driven,
at the cost of a detection of these bodies. Other scenes do not pay for it.
"""

from __future__ import annotations

from copy import copy

import numpy as np

from lmgcpy.contact.detector import Detector
from lmgcpy.contact.foreign_pairs import NarrowPhaseError
from lmgcpy.contact.frames import cross_rows
from lmgcpy.contact.interactions import Interactions
from lmgcpy.contact.positions import in_own_axes
from lmgcpy.dynamics.model import Model
from lmgcpy.dynamics.watch import Said

DEEPER = 0.01
"""Part of the smaller radius by which two bodies may be driven into each other before the run warns. (Bodies that are
driven side by side round a corner gain and lose a thousandth by the error of steps of 0.05 rad.)"""


class DrivenOverlaps:
    """The pairs of a simulation that no impulse keeps apart, and by how much they overlap."""

    def __init__(self, model: Model, positions: np.ndarray, said: Said):
        self._said = said
        self._pairs, self._least = np.zeros(0, np.int64), np.zeros(0)
        """Pairs that overlapped after the last step, ascending, and their least overlap since they do [m]."""
        self.look_at(model, positions)

    def look_at(self, model: Model, positions: np.ndarray) -> None:
        """Go on with another model, or at other positions of its bodies, (n, 3): bodies that overlap there were not driven
        into each other."""
        self._model, self._detector = model, None
        stuck, moving = held_and_driven(model)
        if not may_meet(model, stuck, moving):
            self._pairs, self._least = np.zeros(0, np.int64), np.zeros(0)
            return
        # with a mobility, pairs with a body that is driven are not left out
        mobility = np.repeat(moving[:, None].astype(float), model.mass.shape[1], axis=1)
        self._detector = Detector(model.contactors, model.rows, [], mobility, model.dimension, model.apart, model.lattice)
        self._detector.hide(~stuck)
        pairs, depth, _ = self._overlaps(positions)
        self._least = np.minimum(self._before(pairs, depth), depth)
        self._pairs = pairs

    def after_step(self, positions: np.ndarray, time: float) -> list[str]:
        """A sentence for each pair of colours whose bodies were driven into each other for the first time, in the step that
        ended at these positions (n, 3) and this ``time`` [s]."""
        if self._detector is None:
            return []
        pairs, depth, radius = self._overlaps(positions)
        self._least = np.minimum(self._before(pairs, np.zeros(len(pairs))), depth)
        self._pairs = pairs
        table, sentences = self._model.contactors, []
        deeper = (depth - self._least) / radius
        for k in np.argsort(-deeper, kind="stable").tolist():
            if not deeper[k] > DEEPER:
                break
            one, other = divmod(int(pairs[k]), len(table.body))
            first, second = sorted((table.color[one], table.color[other]))
            if not self._said.first(f"driven: {first!r} and {second!r}"):
                continue
            bodies = " and ".join(f"body {table.body[j]} ('{table.color[j]}')" for j in (one, other))
            sentences.append(
                f"In the step to t = {time:g} s {bodies} overlap by {depth[k]:.3g} m, {100.0 * depth[k] / radius[k]:.3g} % "
                "of the smaller radius: along the normal of their contact both are driven or held, so that no impulse "
                "keeps them apart. End the drive, drive one of them by a force, or give them colours that do not see each "
                "other. (Said once of each pair of colours.)"
            )
        return sentences

    def _before(self, pairs: np.ndarray, otherwise: np.ndarray) -> np.ndarray:
        """Least overlaps of pairs [m], (p,), so far; ``otherwise``: the result for pairs that did not overlap."""
        if not len(self._pairs):
            return otherwise
        at = np.minimum(np.searchsorted(self._pairs, pairs), len(self._pairs) - 1)
        return np.where(self._pairs[at] == pairs, self._least[at], otherwise)

    def _overlaps(self, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Pairs of contactors that overlap and that nothing keeps apart, as one number each, ascending; their overlaps [m];
        the smaller radii [m]; (p,) each."""
        assert self._detector is not None
        detector, table = copy(self._detector), self._model.contactors  # a copy, as a step that fails goes back
        try:
            found = detector.detect(positions, 0.0)
        except NarrowPhaseError as error:
            raise RuntimeError(f"Among bodies that are driven or held {error}.") from error.__cause__
        self._detector = detector
        deep = (found.gap < 0.0) & (yields(found, self._model.inverse_mass, positions) == 0.0)
        chosen = np.concatenate([np.zeros((0, 2), np.int32), *(group.pairs for group in detector.groups)])
        pairs = chosen[found.slot[deep]].astype(np.int64)
        number = pairs[:, 0] * len(table.body) + pairs[:, 1]
        order = np.argsort(number, kind="stable")
        radius = table.radius[pairs].min(axis=1, initial=np.inf)
        return number[order], -found.gap[deep][order], radius[order]


def held_and_driven(model: Model) -> tuple[np.ndarray, np.ndarray]:
    """Whether a body is held or driven along an axis, and whether such a body is driven by a velocity other than zero, (n,)
    bool each. In a periodic cell that may deform, held bodies move with the cell."""
    d = model.dimension
    stuck = (model.inverse_mass[:, :d] == 0.0).any(axis=1) & ~model.hidden
    moving = np.zeros(len(stuck), dtype=bool)
    moving[[drive.body for drive in model.velocities if callable(drive.value) or drive.value != 0.0]] = True
    if model.cell is not None:
        edges = model.cell.lattice.rows
        stuck[edges] = False
        if moving[edges].any() or model.cell.yields(model.inverse_mass):
            moving |= model.bounded
    return stuck, moving & stuck


def may_meet(model: Model, stuck: np.ndarray, moving: np.ndarray) -> bool:
    """Whether the visibility table lets a body that is ``moving`` (n,) see another one that is ``stuck`` (n,)."""
    if not moving.any():
        return False
    table, color = model.contactors, np.array(model.contactors.color, dtype=str)
    bounded = np.isfinite(table.bounding_radius)
    drives, holds = moving[table.body], stuck[table.body]
    for row in model.rows:
        for one, other in ((row.candidate, row.antagonist), (row.antagonist, row.candidate)):
            here, there = drives & (color == one), holds & (color == other)
            both = (here.any() and (there & bounded).any()) or ((here & bounded).any() and there.any())
            if both and len(np.unique(table.body[here | there])) > 1:
                return True
    return False


def yields(found: Interactions, inverse_mass: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """``W_nn`` [1/kg] of contacts, (m,), with the inverse masses of the bodies (n, k) at their positions; zero if neither
    body yields along the normal."""
    c, a = found.candidate, found.antagonist
    d = found.normal.shape[1]
    square = found.normal**2
    on_c, on_a = ((square * inverse_mass[ids, :d]).sum(axis=1) for ids in (c, a))
    if len(found.corner):  # of elements, the bodies at the corners with their weights
        weight = found.weight[:, :: d + 1]
        of_corners = (weight**2 * (square[:, None] * inverse_mass[found.corner, :d]).sum(axis=2)).sum(axis=1)
        on_c = np.where((weight > 0.0).any(axis=1), of_corners, on_c)
        on_a = np.where((weight < 0.0).any(axis=1), of_corners, on_a)
    normal = on_c + on_a
    if len(found.lateral):  # levers of clusters in the plane
        turns = found.lateral[: len(c)] ** 2 * inverse_mass[np.column_stack([c, a]), d]
        normal = normal + turns.sum(axis=1)
    if len(found.lever):
        both = np.column_stack([c, a])
        lever = found.lever.reshape(-1, 2, 3)
        moment = cross_rows(lever, found.normal[:, None])
        if positions.shape[1] > 3:
            moment = in_own_axes(positions[both, 3:], moment)
        moment[np.abs(moment) <= 2.0**-49 * np.abs(lever).max(axis=2, keepdims=True)] = 0.0  # rounding alone
        normal = normal + (moment**2 * inverse_mass[both, d:]).sum(axis=(1, 2))
    return normal
