"""TexSol as a material point: sand and wire share the strain, and their stresses add.

A finite-element code calls :meth:`TexSol.material_point` at each of its points. It is pure: state in, state out.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from lmgcpy.continuum.sand import Sand
from lmgcpy.continuum.tensors import SIZE
from lmgcpy.continuum.wire import WireNetwork
from lmgcpy.errors import named_arguments, number, shown


class PointState(NamedTuple):
    """State of a material point. Its arrays are not to be changed."""

    strain: np.ndarray
    """Strain since the start [-], (m,), traction positive."""
    sand: np.ndarray
    """Stress of the sand [Pa], (m,)."""
    wire: np.ndarray
    """Stress of the wire [Pa], (m,)."""
    kappa: float
    """Plastic shear of the sand [-]."""
    slip: np.ndarray
    """Slip of each direction of the wire [-], (k,)."""

    @property
    def stress(self) -> np.ndarray:
        """Stress of both [Pa], (m,)."""
        return self.sand + self.wire

    def __repr__(self) -> str:
        pulls = "no wire" if not len(self.slip) else f"{len(self.slip)} directions of wire"
        return f"<PointState of {len(self.strain)} components: plastic shear {self.kappa:.3g}, {pulls}>"


class PointResponse(NamedTuple):
    """Response of a material point to an increment of strain."""

    stress: np.ndarray
    """[Pa], (m,)."""
    tangent: np.ndarray
    """Derivative of the stress by the increment of strain [Pa], (m, m)."""
    state: PointState
    """State at the end."""

    def __repr__(self) -> str:
        return f"<PointResponse of {len(self.stress)} components: stress, tangent and {self.state!r}>"


@named_arguments
@dataclass(frozen=True, eq=False, repr=False)
class TexSol:
    """A ``sand`` with a ``wire`` network; None: the sand alone. Raises TypeError or ValueError with a sentence."""

    sand: Sand
    wire: WireNetwork | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.sand, Sand):
            raise TypeError(f"sand must be a DruckerPrager or a MohrCoulomb, got {shown(self.sand)}.")
        if self.wire is not None:
            if not isinstance(self.wire, WireNetwork):
                raise TypeError(f"wire must be a WireNetwork or None, got {shown(self.wire)}.")
            if self.wire.dimension != self.sand.dimension:
                raise ValueError(f"The sand is of dimension {self.sand.dimension}, the wire of {self.wire.dimension}.")

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.sand.dimension

    def __repr__(self) -> str:
        return f"<TexSol: {self.sand!r}, {'no wire' if self.wire is None else repr(self.wire)}>"

    @named_arguments
    def start(self, pressure: float) -> PointState:
        """State without strain, in which the sand has the ``pressure`` [Pa] and no deviator.

        The wire has the stress of zero strain, which is none unless a slack is negative. A wire that would slip at once
        does so. Raises TypeError or ValueError if the pressure is no number above zero.
        """
        pressure = number(pressure, "pressure", above=0.0, unit="Pa")
        size = SIZE[self.dimension]
        zero = np.zeros(size)
        sand = -pressure * self.sand.unit
        if self.wire is None:
            return PointState(zero, sand, zero, 0.0, np.zeros(0))
        pulled = self.wire.respond(zero, np.zeros(len(self.wire.directions)), pressure)
        return PointState(zero, sand, pulled.stress, 0.0, pulled.slip)

    def material_point(self, increment: np.ndarray, state: PointState) -> PointResponse:
        """Stress, tangent and state after an increment of strain (m,), an array of floats in Mandel's notation.

        Nothing is kept or changed: a code may call it again with the state of the last step that converged. The tangent is
        the exact derivative of the stress by the increment, with the wire's slip by the pressure of the sand in it. It is
        symmetric for the wire alone, as sand is not associated. Arguments are not checked, for speed.
        """
        flowed = self.sand.respond(increment, state.sand, state.kappa)
        strain = state.strain + increment
        if self.wire is None:
            after = PointState(strain, flowed.stress, state.wire, flowed.kappa, state.slip)
            return PointResponse(flowed.stress, flowed.tangent, after)
        d = self.dimension
        pressure = -float(flowed.stress[:d].sum()) / d
        pulled = self.wire.respond(strain, state.slip, pressure)
        tangent = flowed.tangent + pulled.stiffness
        if pulled.slope is not None:
            tangent -= np.multiply.outer(pulled.slope, flowed.tangent[:d].sum(axis=0) / d)
        after = PointState(strain, flowed.stress, pulled.stress, flowed.kappa, pulled.slip)
        return PointResponse(flowed.stress + pulled.stress, tangent, after)
