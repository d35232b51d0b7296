"""Statements between the steps of a simulation: what is driven, loaded or free, which bodies are there, and gravity.

They are kept in the order in which they were made, with the step after which each was, so that a run that goes on from a
checkpoint goes through them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from lmgcpy.laws import Law

KINDS = DRIVEN, LOADED, FREE, HIDDEN, SHOWN, GRAVITY, REFERENCE, SEEN_LAW, LINK_LAW, NOTED = range(10)
"""Kinds of statements; the ``value`` is a velocity [m/s, rad/s], a force [N, N m], an acceleration [m/s^2], a gap [m], a
parameter of a law. NOTED is no statement: it notes the reference gaps that a function of time gives at a frame of a
file."""
OF_COMPONENTS = (DRIVEN, LOADED, FREE)
"""Kinds of statements that name a component of a body."""
OF_GAPS = (REFERENCE, NOTED)
OF_LAWS = (SEEN_LAW, LINK_LAW)
"""Kinds of statements that give a row of the visibility table, or a chain, other parameters: first one with the component
-1, then one for each parameter that the law was given."""


class Change(NamedTuple):
    """A statement."""

    step: int
    """Number of steps before it."""
    kind: int
    body: int
    """Row of the body, -1 for gravity; the chain whose reference gaps or law change; the row of the visibility table."""
    component: int
    """Component of the velocity, or axis of gravity; the link, -1 for all of a chain; the parameter of a law, in the order
    in which it declares them; -1 for none."""
    value: float


class Counts(NamedTuple):
    """Numbers of the bodies, links and parameters that statements can name."""

    bodies: int
    dimension: int
    links: Sequence[int]
    """Links of each chain."""
    seen_parameters: Sequence[int]
    """Parameters of the law of each row of the visibility table."""
    link_parameters: Sequence[int]
    """Parameters of the law of each chain."""


def law_values(law: Law) -> list[tuple[int, float]]:
    """Components and values of the statements that give a law."""
    given = [(k, float(value)) for k, value in enumerate(law.values.values()) if value is not None]
    return [(-1, 0.0), *given]


def gap_values(gaps: np.ndarray) -> list[tuple[int, float]]:
    """Components and values of the statements that give the reference gaps of a chain: one with component -1 if all are
    equal, else one for each link."""
    values = gaps.tolist()
    return [(-1, values[0])] if len(set(values)) == 1 else list(enumerate(values))


def laws_after(changes: Sequence[Change]) -> dict[tuple[int, int], dict[int, float]]:
    """Parameters by number that the last statements give to laws, by kind of statement and row or chain."""
    found: dict[tuple[int, int], dict[int, float]] = {}
    for change in changes:
        if change.kind in OF_LAWS:
            if change.component < 0:
                found[change.kind, change.body] = {}
            else:
                found[change.kind, change.body][change.component] = change.value
    return found


def as_rows(changes: list[Change]) -> np.ndarray:
    """Statements as an array, (c, 5)."""
    return np.array(changes, dtype=float).reshape(-1, len(Change._fields))


def from_rows(rows: np.ndarray, counts: Counts) -> list[Change]:
    """The statements of an array (c, 5); ValueError if one of them is impossible."""
    if rows.ndim != 2 or rows.shape[1] != len(Change._fields) or not np.isfinite(rows).all():
        raise ValueError("the statements between steps are no rows of five finite numbers")
    step, kind, body, component = rows[:, :4].astype(np.int64).T
    components = np.where(np.isin(kind, OF_COMPONENTS), 3 if counts.dimension == 2 else 6, counts.dimension)
    of_table = {SEEN_LAW: counts.seen_parameters, LINK_LAW: counts.link_parameters}
    tables = [(kind == of, have) for of, have in {**dict.fromkeys(OF_GAPS, counts.links), **of_table}.items()]
    of_body = ~np.isin(kind, (*OF_GAPS, *OF_LAWS, GRAVITY))
    of_component = np.isin(kind, (*OF_COMPONENTS, GRAVITY))
    sound = (rows[:, :4] == rows[:, :4].astype(np.int64)).all() and np.isin(kind, KINDS).all() and (step >= 0).all()
    sound &= bool((np.diff(step) >= 0).all())
    sound &= bool(((body >= 0) & (body < counts.bodies))[of_body].all())
    sound &= bool(((component >= 0) & (component < components))[of_component].all())
    for chosen, have in tables:
        sound &= bool(((body >= 0) & (body < len(have)))[chosen].all())
        if sound:
            most = np.asarray(have, dtype=np.int64)[body[chosen]]
            sound = bool(((component[chosen] >= -1) & (component[chosen] < most)).all())
    # a parameter of a law comes after the statement with component -1, or after another parameter
    later = np.flatnonzero(np.isin(kind, OF_LAWS) & (component >= 0))
    same = (rows[later, :3] == rows[later - 1, :3]).all() and (component[later] > component[later - 1]).all()
    if not (sound and same and (later > 0).all()):
        raise ValueError("a statement between steps names a step, body, component, link or parameter that does not exist")
    columns = step.tolist(), kind.tolist(), body.tolist(), component.tolist(), rows[:, 4].tolist()
    return [Change(*row) for row in zip(*columns, strict=True)]


def hidden_after(changes: list[Change], step: int, hidden: np.ndarray) -> np.ndarray:
    """Whether a body is hidden after ``step`` steps, (n,); ``hidden``: whether it was hidden at the start."""
    now = hidden.copy()
    for change in changes:
        if change.step <= step and change.kind in (HIDDEN, SHOWN):
            now[change.body] = change.kind == HIDDEN
    return now


def gaps_after(changes: list[Change], step: int, gaps: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Reference gaps of chains [m] after ``step`` steps; ``gaps``: the gaps at the start."""
    now = [of_chain.copy() for of_chain in gaps]
    for change in changes:
        if change.step <= step and change.kind in OF_GAPS:
            now[change.body][change.component if change.component >= 0 else slice(None)] = change.value
    return now
