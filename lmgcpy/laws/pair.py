"""What a law may know of the two bodies of an interaction."""

from __future__ import annotations

from typing import NamedTuple


class Pair(NamedTuple):
    """The two bodies of an interaction, the last argument of the functions of laws of interface version 2.

    Of a contact, radii are those of the two contactors (of foreign ones that of a circle or sphere around them), infinite
    for walls; of a link they go from the centres to the surfaces. Masses are infinite for bodies that cannot be moved.
    """

    radius: float
    """Effective radius [m]: ``1/radius = 1/radii[0] + 1/radii[1]``."""
    mass: float
    """Effective mass [kg], the same of the masses."""
    radii: tuple[float, float]
    """Of the candidate and of the antagonist [m]."""
    masses: tuple[float, float]
    """Of the candidate and of the antagonist [kg]."""
    time: float
    """Time at the start of the step [s]."""


def pair_of(radii: tuple[float, float], masses: tuple[float, float], time: float) -> Pair:
    """The pair with these numbers. An effective value is the other one where one is infinite, and 0 where one is 0."""
    return Pair(effective(*radii), effective(*masses), radii, masses, time)


def effective(one: float, other: float) -> float:
    """``1/(1/one + 1/other)``, for two numbers of at least 0 that may be infinite."""
    smaller, larger = min(one, other), max(one, other)
    return smaller / (1.0 + smaller / larger) if smaller > 0.0 else 0.0
