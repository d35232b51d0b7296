"""What a scene becomes when it is compiled: a frozen model, and a state that steps through time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lmgcpy.contact.tables import ChainTable, ContactorTable, VisibilityRow
from lmgcpy.errors import number, shown


@dataclass(frozen=True)
class Drive:
    """A velocity imposed on one component of a body, or a force on it: a number or a function of time."""

    body: int
    component: int
    value: float | Callable[[float], float]

    def at(self, time: float) -> float:
        """Value at a time [s].

        Raises RuntimeError where a user's function fails, TypeError where it gives no number, and FloatingPointError
        where that is not finite.
        """
        if not callable(self.value):
            return self.value
        try:
            given = self.value(time)
        except Exception as error:
            raise RuntimeError(f"The function of time {self._where(time)} failed with {shown(error)}: mend it.") from error
        try:
            return number(given, f"What is {self._where(time)}")
        except ValueError as error:
            raise FloatingPointError(str(error)) from error

    def _where(self, time: float) -> str:
        return f"imposed on component {('x', 'y', 'spin')[self.component]} of body {self.body} at t = {time:g} s"


@dataclass(frozen=True)
class Model:
    """Frozen description of a scene; n bodies, d dimensions, components (x, y, spin) in 2D."""

    dimension: int
    mass: np.ndarray
    """Mass or inertia by component [kg, kg m^2], (n, 3); infinite where no mass was needed."""
    inverse_mass: np.ndarray
    """Its inverse, zero where the component is driven, (n, 3)."""
    radius: np.ndarray
    """From the centre to the surface along a link [m], (n,); zero for what is no disk."""
    extent: np.ndarray
    """Radius of a circle around the centre that holds the body [m], infinite for walls, (n,)."""
    wall_normals: dict[int, np.ndarray]
    """Outward normals of the walls by row of the body, (d,)."""
    weight: np.ndarray
    """Force of gravity by component [N], (n, 3)."""
    contactors: ContactorTable
    rows: list[VisibilityRow]
    chains: list[ChainTable]
    velocities: list[Drive]
    """Imposed velocities."""
    forces: list[Drive]
    """Imposed forces."""
    start: State
    """Where everything is at the beginning."""


@dataclass
class State:
    """Positions (x, y, angle) [m, m, rad] and velocities [m/s, m/s, rad/s], both (n, 3), and the time [s]."""

    positions: np.ndarray
    velocities: np.ndarray
    time: float = 0.0

    def copy(self) -> State:
        """An independent copy."""
        return State(self.positions.copy(), self.velocities.copy(), self.time)
