"""Statements between the steps of a simulation: what is driven, loaded or free, which bodies are there, and gravity.

They are kept in the order in which they were made, with the step after which each was, so that a run that goes on from a
checkpoint goes through them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

KINDS = DRIVEN, LOADED, FREE, HIDDEN, SHOWN, GRAVITY, REFERENCE = range(7)
"""Kinds of statements; the ``value`` is a velocity [m/s, rad/s], a force [N, N m], an acceleration [m/s^2], a gap [m]."""
OF_COMPONENTS = (DRIVEN, LOADED, FREE)
"""Those that name a component of a body."""


class Change(NamedTuple):
    """A statement."""

    step: int
    """Number of steps before it."""
    kind: int
    body: int
    """Row of the body, -1 for gravity; the chain whose reference gaps change."""
    component: int
    """Component of the velocity, or axis of gravity; the link, -1 for all of a chain; -1 for none."""
    value: float


def as_rows(changes: list[Change]) -> np.ndarray:
    """Statements as an array, (c, 5)."""
    return np.array(changes, dtype=float).reshape(-1, len(Change._fields))


def from_rows(rows: np.ndarray, bodies: int, dimension: int, links: Sequence[int]) -> list[Change]:
    """The statements of an array (c, 5) for so many bodies, and chains of so many links; ValueError where one of them
    cannot be."""
    if rows.ndim != 2 or rows.shape[1] != len(Change._fields) or not np.isfinite(rows).all():
        raise ValueError("the statements between steps are no rows of five finite numbers")
    step, kind, body, component = rows[:, :4].astype(np.int64).T
    components = np.where(np.isin(kind, OF_COMPONENTS), 3 if dimension == 2 else 6, dimension)
    of_chain = kind == REFERENCE
    of_body, of_component = ~of_chain & (kind != GRAVITY), np.isin(kind, (*OF_COMPONENTS, GRAVITY))
    sound = (rows[:, :4] == rows[:, :4].astype(np.int64)).all() and np.isin(kind, KINDS).all() and (step >= 0).all()
    sound &= bool((np.diff(step) >= 0).all())
    sound &= bool(((body >= 0) & (body < bodies))[of_body].all())
    sound &= bool(((component >= 0) & (component < components))[of_component].all())
    sound &= bool(((body >= 0) & (body < len(links)))[of_chain].all())
    if sound:
        counts = np.asarray(links, dtype=np.int64)[body[of_chain]]
        sound = bool(((component[of_chain] >= -1) & (component[of_chain] < counts)).all())
    if not sound:
        raise ValueError("a statement between steps names a step, body, component or link that does not exist")
    columns = step.tolist(), kind.tolist(), body.tolist(), component.tolist(), rows[:, 4].tolist()
    return [Change(*row) for row in zip(*columns, strict=True)]


def hidden_after(changes: list[Change], step: int, hidden: np.ndarray) -> np.ndarray:
    """Which bodies are hidden after so many steps, (n,); ``hidden``: those that were so from the start."""
    now = hidden.copy()
    for change in changes:
        if change.step <= step and change.kind in (HIDDEN, SHOWN):
            now[change.body] = change.kind == HIDDEN
    return now


def gaps_after(changes: list[Change], step: int, gaps: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Reference gaps of chains [m] after so many steps; ``gaps``: those at the start."""
    now = [of_chain.copy() for of_chain in gaps]
    for change in changes:
        if change.step <= step and change.kind == REFERENCE:
            now[change.body][change.component if change.component >= 0 else slice(None)] = change.value
    return now
