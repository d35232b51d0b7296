"""Materials of bodies."""

from __future__ import annotations

from dataclasses import dataclass

from lmgcpy.errors import named_arguments, number, shown


@named_arguments
@dataclass(frozen=True)
class Material:
    """A material with a ``name`` and a ``density`` [kg/m^3]."""

    name: str
    density: float

    def __post_init__(self):
        if not isinstance(self.name, str) or not self.name:
            raise TypeError(f"The name of a material must be a word, got {shown(self.name)}.")
        density = number(self.density, f"density of material '{self.name}'", above=0.0, unit="kg/m^3")
        object.__setattr__(self, "density", density)
