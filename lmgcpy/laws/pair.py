"""The data of the two bodies of an interaction that a law may use."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

TAKE_PAIR = ("prepare", "initial", "commit", "energy", "dissipation")
"""Functions of a law each of which may take a last argument ``pair``."""


class Pair(NamedTuple):
    """The two bodies of an interaction: the last argument of functions of laws that take one named ``pair``.

    In a contact the radii are the radii of the two contactors, infinite for walls; a contactor of a plug-in has the radius
    of its bounding circle or sphere. In a link they are the distances from the centres to the surfaces. Masses are infinite
    for bodies that cannot be moved.
    """

    radius: float
    """Effective radius [m]: ``1/radius = 1/radii[0] + 1/radii[1]``."""
    mass: float
    """Effective mass [kg]: ``1/mass = 1/masses[0] + 1/masses[1]``."""
    radii: tuple[float, float]
    """Radii of candidate and antagonist [m]."""
    masses: tuple[float, float]
    """Masses of candidate and antagonist [kg]."""
    time: float
    """Time at the start of the step [s]."""


@cache
def takes_pair(function: Callable | None) -> bool:
    """Whether a function of a law takes ``pair``, as its signature says."""
    return function is not None and "pair" in inspect.signature(function).parameters


def asks_for_pair(law: Any) -> bool:
    """Whether a function of a law takes ``pair``."""
    return any(takes_pair(getattr(law, name)) for name in TAKE_PAIR)


def as_asked(function: Callable, pair: Pair) -> tuple[Pair, ...]:
    """The last arguments of a function of a law: ``(pair,)`` if it takes the pair, ``()`` if not."""
    return (pair,) if takes_pair(function) else ()


def pair_of(radii: tuple[float, float], masses: tuple[float, float], time: float) -> Pair:
    """The pair with these numbers. If one value is infinite, the effective value is the other; if one is 0, it is 0."""
    return Pair(effective(*radii), effective(*masses), radii, masses, time)


def effective(one: float, other: float) -> float:
    """``1/(1/one + 1/other)``, for two numbers of at least 0 that may be infinite."""
    smaller, larger = min(one, other), max(one, other)
    return smaller / (1.0 + smaller / larger) if smaller > 0.0 else 0.0
