"""What a law may know of the two bodies of an interaction."""

from __future__ import annotations

from typing import NamedTuple


class Pair(NamedTuple):
    """The two bodies of an interaction, the last argument of the functions of laws of interface version 2.

    The radii of a contact are those of the two contactors, infinite for walls; a foreign contactor has that of a circle or
    sphere around it. The radii of a link go from the centres to the surfaces. Masses are infinite for bodies that cannot be
    moved.
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


def pair_of(radii: tuple[float, float], masses: tuple[float, float], time: float) -> Pair:
    """The pair with these numbers. An effective value is the other one where one is infinite, and 0 where one is 0."""
    return Pair(effective(*radii), effective(*masses), radii, masses, time)


def effective(one: float, other: float) -> float:
    """``1/(1/one + 1/other)``, for two numbers of at least 0 that may be infinite."""
    smaller, larger = min(one, other), max(one, other)
    return smaller / (1.0 + smaller / larger) if smaller > 0.0 else 0.0
