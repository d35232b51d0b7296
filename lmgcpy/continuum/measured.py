"""A compression of sand as it was measured, ready to be fitted."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.continuum.tensors import SIZE
from lmgcpy.errors import AXES, named_arguments, numbers, one_of


@named_arguments
@dataclass(frozen=True, eq=False, repr=False)
class MeasuredCompression:
    """Biaxial (d = 2) or triaxial (d = 3) compression from an isotropic state, in s moments of growing crushing.

    ``axis``: the one that was compressed, "x", "y" or "z"; ``strain`` (s, d): logarithmic strains of the sample along the
    axes, zero at the start; ``stress`` (s, d): normal stresses along the axes [Pa]. Both are traction positive.

    Raises TypeError or ValueError for other shapes, for fewer than 20 moments, or if a mean pressure is not above zero.
    """

    axis: str
    strain: Any
    stress: Any

    def __post_init__(self) -> None:
        strain = numbers(self.strain, "strain", "logarithmic strains (s, d)")
        stress = numbers(self.stress, "stress", "normal stresses (s, d) [Pa]")
        if strain.ndim != 2 or strain.shape[1] not in SIZE:
            raise ValueError(f"strain must be of shape (s, 2) or (s, 3), got {strain.shape}.")
        if stress.shape != strain.shape:
            raise ValueError(f"stress must have the shape of strain, {strain.shape}, got {stress.shape}.")
        if len(strain) < 20:
            raise ValueError(f"A fit takes at least 20 moments of a compression, got {len(strain)}.")
        one_of(self.axis, "axis", AXES[: strain.shape[1]])
        object.__setattr__(self, "strain", strain)
        object.__setattr__(self, "stress", stress)
        if not self.pressure.min() > 0.0:
            where = int(np.argmin(self.pressure))
            raise ValueError(f"The mean pressure must be above zero, in moment {where} it is {self.pressure[where]:g} Pa.")
        if not self.crushing.max() > 0.0:
            raise ValueError(f"strain along the axis '{self.axis}' is never below zero: compression is negative.")

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.strain.shape[1]

    @property
    def crushing(self) -> np.ndarray:
        """Strain along the axis, compression positive, (s,)."""
        return -self.strain[:, AXES.index(self.axis)]

    @property
    def volume_change(self) -> np.ndarray:
        """Trace of the strain, dilation positive, (s,)."""
        return self.strain.sum(axis=1)

    @property
    def pressure(self) -> np.ndarray:
        """p, the mean of all sides [Pa], (s,)."""
        return -self.stress.mean(axis=1)

    @property
    def deviator(self) -> np.ndarray:
        """q: pressure along the axis less the mean pressure across it [Pa], (s,)."""
        place = AXES.index(self.axis)
        return np.delete(self.stress, place, axis=1).mean(axis=1) - self.stress[:, place]

    def __repr__(self) -> str:
        return (
            f"<MeasuredCompression along {self.axis} in {self.dimension}D: {len(self.strain)} moments to "
            f"{100.0 * self.crushing.max():.3g} %>"
        )
