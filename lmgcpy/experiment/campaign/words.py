"""Parameters in words, and names that end with a unit."""

from __future__ import annotations

import re
from typing import Any

import numpy as np


def in_words(value: Any) -> str:
    """A parameter in words, with all its digits; the values of a tuple are joined by "+"."""
    value = value.item() if isinstance(value, np.generic) else value
    if isinstance(value, (tuple, list)):
        return "+".join(map(in_words, value))
    if isinstance(value, float):
        short = f"{value:g}"
        return short if float(short) == value else repr(value)
    return str(value)


def name_and_unit(heading: str) -> tuple[str, str]:
    """The name and the unit of "peak deviator [Pa]"; the unit is empty if there is none."""
    found = re.fullmatch(r"(.*\S)\s*\[([^\[\]]+)\]", heading.strip())
    return (found[1], found[2]) if found else (heading, "")


def file_word(text: str) -> str:
    """A text as a part of the name of a file: at most 80 letters, digits and ``.+=_-``."""
    return re.sub(r"[^\w.+=-]+", "-", text, flags=re.ASCII).strip("-.")[:80]
