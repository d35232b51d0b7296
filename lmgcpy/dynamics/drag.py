"""Drag of a medium at rest, implicit within the step.

**Linear**, ``-c v``. Under forces F and impulses that are spread evenly over the step the motion of a body is known,

    v+ = e^-a v + (1 - e^-a) F/c = v + phi h/m (F - c v),    a = h c/m,  phi(a) = (1 - e^-a)/a,

so a body has the mobility phi/m in the step in place of 1/m, in free flight and in W (exponential time differencing:
Hochbruck, Ostermann 2010, Acta Numerica 19). A sinking body approaches ``F/c`` with the time constant m/c, exactly, at any
step; phi is 1 - a/2 for short steps and 1/a for long ones.

**Quadratic**, ``-k |v| v``, by backward Euler. Without impulses, with w the velocity that linear drag alone would leave and
``b = k h phi/m``,

    v+ (1 + b s) = w,    s = |v+| = (sqrt(1 + 4 b |w|) - 1)/(2 b),

a speed that approaches the equilibrium speed without passing it; first order in the step. Its mobility is
``phi/(m (1 + b s))``: impulses are answered with the drag at the speed s. A free flight without load is
``1/v+ = 1/v + k h/m`` to first order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Drag:
    """Coefficients of the drag on n bodies with k components of a velocity."""

    linear: np.ndarray
    """c by component [N s/m, N m s], (n, k)."""
    quadratic: np.ndarray
    """k of the translation [N s^2/m^2], (n,)."""
    dimension: int

    def fly(
        self, before: np.ndarray, force: np.ndarray, inverse_mass: np.ndarray, time_step: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Mobilities in the step [1/kg] and velocities without impulses, (n, k) each, from velocities, forces and inverse
        masses (n, k)."""
        a = time_step * self.linear * inverse_mass
        mobility = inverse_mass * np.where(a > 0.0, -np.expm1(-a) / np.where(a > 0.0, a, 1.0), 1.0)
        free = before + time_step * mobility * (force - self.linear * before)
        if self.quadratic.any():
            d = self.dimension
            b = time_step * self.quadratic * mobility[:, :d].max(axis=1)
            speed = np.linalg.norm(free[:, :d], axis=1)
            # b s, without cancellation
            slowed = 1.0 + 2.0 * b * speed / (1.0 + np.sqrt(1.0 + 4.0 * b * speed))
            mobility[:, :d] /= slowed[:, None]
            free[:, :d] = np.where(inverse_mass[:, :d] > 0.0, free[:, :d] / slowed[:, None], free[:, :d])
        return mobility, free
