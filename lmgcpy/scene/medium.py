"""The medium in which bodies move, and its drag on each of them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from lmgcpy.dynamics.drag import Drag
from lmgcpy.errors import number, shown
from lmgcpy.scene.body import Body, Round

RESISTANCE = {2: 1.0, 3: 0.44}
"""Coefficient of resistance of a body that moves fast: of a cylinder across its axis, a metre of it, and of a sphere,
between Reynolds numbers of some 1e3 and 1e5."""


@dataclass(frozen=True)
class Medium:
    """A statement ``scene.drag``; the numbers are its arguments."""

    bodies: tuple[int, ...] | None
    """Ids of the bodies, or None for all bodies with bounds."""
    rate: float = 0.0
    linear: float = 0.0
    quadratic: float = 0.0
    turning: float = 0.0
    viscosity: float = 0.0
    density: float = 0.0


COEFFICIENTS = tuple(field.name for field in fields(Medium))[1:]
UNITS = ("1/s", "N s/m", "N s^2/m^2", "N m s", "Pa s", "kg/m^3")


def medium(bodies: Any, known: Sequence[Body], dimension: int, given: dict[str, Any]) -> Medium:
    """A statement from its arguments; TypeError and ValueError with a sentence."""
    values = {
        name: number(given[name], f"{name} of a drag", minimum=0.0, unit=unit)
        for name, unit in zip(COEFFICIENTS, UNITS, strict=True)
    }
    if not any(values.values()):
        raise TypeError("drag needs a coefficient, for example drag(linear=0.1).")
    if dimension == 2 and values["viscosity"] > 0.0:
        raise ValueError("A disk in a viscous fluid has no drag of Stokes (his paradox): give linear= and turning= in 2D.")
    if bodies is None:
        return Medium(None, **values)
    if isinstance(bodies, (str, Body)) or not isinstance(bodies, Iterable):
        raise TypeError(f"drag takes a list of bodies, or None for all, got {shown(bodies)}.")
    members = list(bodies)
    for body in members:
        if not isinstance(body, Body) or not (0 <= body.id < len(known) and known[body.id] is body):
            raise ValueError(f"drag takes bodies of the scene, got {shown(body)}.")
    return Medium(tuple(body.id for body in members), **values)


def described(media: Sequence[Medium]) -> dict[str, np.ndarray]:
    """Statements as arrays: coefficients (s, 6), number of bodies of each, -1 of all, and their ids one after another."""
    return {
        "coefficients": np.array([[getattr(each, name) for name in COEFFICIENTS] for each in media]),
        "count": np.array([-1 if each.bodies is None else len(each.bodies) for each in media], dtype=np.int64),
        "bodies": np.array([body for each in media for body in each.bodies or ()], dtype=np.int64),
    }


def media_of(table: Mapping[str, np.ndarray], count: int) -> list[Medium]:
    """The statements of a description with this many bodies; ValueError if its fields do not fit together."""
    sizes, ids, numbers = (np.asarray(table[name]) for name in ("count", "bodies", "coefficients"))
    own = np.maximum(sizes, 0)
    sound = numbers.shape == (len(sizes), len(UNITS)) and np.isfinite(numbers).all() and (numbers >= 0.0).all()
    if not sound or own.sum() != len(ids) or ((ids < 0) | (ids >= count)).any():
        raise ValueError("the drags of the scene do not fit together")
    members = np.split(ids, np.cumsum(own)[:-1]) if len(sizes) else []
    return [
        Medium(None if size < 0 else tuple(each.tolist()), **dict(zip(COEFFICIENTS, row.tolist(), strict=True)))
        for size, each, row in zip(sizes.tolist(), members, numbers, strict=True)
    ]


def drag_of(media: Sequence[Medium], bodies: Sequence[Body], mass: np.ndarray, bounded: np.ndarray) -> Drag | None:
    """The drag on all bodies, of masses and inertias (n, k); ``bounded``: those that statements without bodies mean."""
    if not media:
        return None
    (count, k), d = mass.shape, 2 if mass.shape[1] == 3 else 3
    linear, quadratic = np.zeros((count, k)), np.zeros(count)
    finite = np.where(np.isfinite(mass), mass, 0.0)
    for each in media:
        rows = np.flatnonzero(bounded) if each.bodies is None else np.array(each.bodies, dtype=np.int64)
        linear[rows] += each.rate * finite[rows]
        linear[rows, :d] += each.linear
        linear[rows, d:] += each.turning
        quadratic[rows] += each.quadratic
        if each.viscosity > 0.0 or each.density > 0.0:
            for i in rows.tolist():
                if not isinstance(bodies[i], Round):
                    raise ValueError(
                        f"{bodies[i]!r} is no disk or sphere, and its drag in a fluid is not known: name the bodies of a "
                        "drag, and give those of other shapes linear= and quadratic=."
                    )
            radius = np.array([bodies[i].link_radius for i in rows.tolist()])
            linear[rows, :d] += (6.0 * np.pi * each.viscosity * radius)[:, None]
            linear[rows, d:] += (8.0 * np.pi * each.viscosity * radius**3)[:, None]
            section = 2.0 * radius if d == 2 else np.pi * radius**2
            quadratic[rows] += 0.5 * RESISTANCE[d] * each.density * section
    return Drag(linear, quadratic, d)
