"""Units of parameters and states, as powers of length, time and mass."""

from __future__ import annotations

import re
from typing import NamedTuple

from lmgcpy.errors import closest, shown

SYMBOLS = {
    "1": (0, 0, 0),
    "rad": (0, 0, 0),
    "K": (0, 0, 0),
    "m": (1, 0, 0),
    "s": (0, 1, 0),
    "kg": (0, 0, 1),
    "Hz": (0, -1, 0),
    "N": (1, -2, 1),
    "Pa": (-1, -2, 1),
    "J": (2, -2, 1),
    "W": (2, -3, 1),
}
"""Powers of (length, time, mass) of the symbols of units. Kelvin has none: temperatures are never scaled."""
SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")
TOKEN = re.compile(r"\s*(?:([A-Za-z]+|1)(?:\^(-?\d+(?:\.\d+)?))?|([/()]))")


class Dimensions(NamedTuple):
    """Powers of length, time and mass; ``areas`` counts the areas among the powers of metres (a volume counts once)."""

    length: float
    time: float
    mass: float
    areas: float

    def factor(self, length: float, time: float, mass: float) -> float:
        """Factor of a number of these dimensions, from the factors of lengths, times and masses."""
        return length**self.length * time**self.time * mass**self.mass

    def in_the_plane(self) -> Dimensions:
        """The dimensions in 2D: one metre of every area is the metre of depth."""
        return self._replace(length=self.length - self.areas, areas=0.0)


NONE = Dimensions(0.0, 0.0, 0.0, 0.0)


def dimensions(unit: str) -> Dimensions:
    """Dimensions of a unit such as "N s/m", "J/m^2", "1/s", "N/(m s)" or "-"; ValueError with a sentence otherwise.

    Spaces or ``*`` separate factors; ``/`` divides by one factor or by a parenthesis.
    """
    text = unit.strip().replace("**", "^").replace("*", " ").replace("·", " ")
    text = re.sub("[⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+", lambda match: "^" + match.group().translate(SUPERSCRIPTS), text)
    if text == "-":
        return NONE
    tokens: list[tuple[str, str, str]] = []
    position = 0
    while position < len(text):
        match = TOKEN.match(text, position)
        if match is None:
            raise ValueError(f"Unit {shown(unit)} cannot be read at {shown(text[position:])}: {HOW}")
        symbol, power, mark = match.groups(default="")
        tokens.append((symbol, power, mark))
        position = match.end()
    result, rest = _product(tokens, unit)
    if rest or not tokens:
        raise ValueError(f"Unit {shown(unit)} cannot be read: {HOW}")
    return result


HOW = 'write it in SI with powers as ^2, such as "N s/m", "J/m^2", "N/(m s)", and "-" for a pure number.'


def _product(tokens: list[tuple[str, str, str]], unit: str) -> tuple[Dimensions, list[tuple[str, str, str]]]:
    """The product at the beginning of the tokens, and the tokens after it."""
    total = NONE
    sign, divided = 1.0, False
    while tokens and tokens[0][2] != ")":
        symbol, power, mark = tokens[0]
        if mark == "/":
            if sign < 0.0:
                break
            sign, divided, tokens = -1.0, True, tokens[1:]
            continue
        if divided and sign > 0.0:
            raise ValueError(f"Unit {shown(unit)} has a factor after a division: write it before, or with parentheses.")
        if mark == "(":
            factor, tokens = _product(tokens[1:], unit)
            if not tokens:
                raise ValueError(f"Unit {shown(unit)} has a parenthesis that is not closed.")
        else:
            factor = _factor(symbol, float(power or 1.0), unit)
        total = Dimensions(*(a + sign * b for a, b in zip(total, factor, strict=True)))
        sign, tokens = 1.0, tokens[1:]
    if sign < 0.0:
        raise ValueError(f"Unit {shown(unit)} ends after a division: {HOW}")
    return total, tokens


def _factor(symbol: str, power: float, unit: str) -> Dimensions:
    if symbol not in SYMBOLS:
        raise ValueError(f"Unit {shown(unit)} holds '{symbol}', which is not known{closest(symbol, SYMBOLS)} Laws use SI.")
    if symbol == "m":
        areas = 0.0 if abs(power) < 2.0 else (1.0 if power > 0.0 else -1.0)
    else:
        areas = -power if symbol == "Pa" else 0.0
    length, time, mass = SYMBOLS[symbol]
    return Dimensions(power * length, power * time, power * mass, areas)
