"""Sand whose mobilised friction hardens, softens and dilates: what all sands share, and Drucker and Prager's.

With the pressure ``p = -tr sigma / d`` and the deviator ``q = c |dev sigma|``, c = sqrt(3/2) in 3D and sqrt2 in 2D, q is
the difference of the principal stresses of a triaxial or biaxial test. In 2D it is the law of Mohr and Coulomb, with
``sin phi = M/2``; in 3D triaxial compression it has ``M = 6 sin phi / (3 - sin phi)``. ::

    yield       q = M(kappa) p
    flow        d eps_p = dgamma (c s/|s| + D/d 1),  d kappa = dgamma
    friction    M = M_c (1 - exp(-kappa/a)) + B (kappa/b) exp(1 - kappa/b)
    dilatancy   D = beta (M - M_d)

so that ``q dgamma`` is the work of shear and ``D dgamma`` the dilation. Taylor's rule is beta = 1. The work that is lost,
``p (M - D) dgamma``, is not negative where ``D <= M``.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from lmgcpy.continuum.tensors import check_dimension, identity
from lmgcpy.errors import named_arguments, number, read_only

SHAPE = {2: math.sqrt(2.0), 3: math.sqrt(1.5)}
"""c, the deviator over the length of the deviatoric stress, by dimension."""
STEEPEST = {2: 2.0, 3: 3.0}
"""M at which the lateral stress of a compression would vanish, by dimension."""
MOST_STEPS = 200
CLOSE = 4e-15
"""Residual of the yield condition over the trial deviator at which the return has ended."""
PIECES = 32
"""Pieces of the interval in which a return is looked for where its end has no other sign."""


class SandResponse(NamedTuple):
    """Response of the sand to an increment of strain."""

    stress: np.ndarray
    """[Pa], (m,)."""
    tangent: np.ndarray
    """Derivative of the stress by the increment of strain [Pa], (m, m); not symmetric if the sand flows."""
    kappa: float
    """Plastic shear at the end [-]."""

    def __repr__(self) -> str:
        return f"<SandResponse of {len(self.stress)} components: plastic shear {self.kappa:.3g}>"


@dataclass(frozen=True, repr=False)
class Sand(ABC):
    """Cohesionless sand in ``dimension`` 2 or 3: its friction and dilatancy by the plastic shear.

    ``critical`` M_c: q/p at large shear; ``hardening`` a: plastic shear at which 63 % of it is mobilised; ``peak`` B:
    greatest part of the peak in q/p, at the plastic shear ``peak_shear`` b; ``dilation`` beta and ``turning`` M_d:
    dilatancy per q/p, and the q/p at which contraction turns into dilation; ``bulk_modulus`` K and ``shear_modulus`` G
    [Pa]. A sand of rigid grains is not elastic: K and G, some 1000 times the pressure, approximate rigid grains, and
    results must not depend on them.

    If ``beta (M_c + B - M_d) <= M_c + B``, the sand never gains work: M lies between 0 and M_c + B, and D - M is linear in
    M, not positive at M = 0 and, by this condition, not at M_c + B. With beta <= 1 it always holds. Raises TypeError or
    ValueError with a sentence if it does not hold, or if M_c + B reaches 2 (2D) or 3 (3D): a compressed sand would then
    need no support.
    """

    dimension: int
    critical: float
    hardening: float
    peak: float
    peak_shear: float
    dilation: float
    turning: float
    bulk_modulus: float
    shear_modulus: float
    unit: np.ndarray = field(init=False, repr=False, compare=False)
    """The unit tensor, (m,)."""
    elastic: np.ndarray = field(init=False, repr=False, compare=False)
    """Elastic tangent [Pa], (m, m)."""
    _bulk: np.ndarray = field(init=False, repr=False, compare=False)
    """Its part for changes of volume [Pa], (m, m)."""
    _shear: np.ndarray = field(init=False, repr=False, compare=False)
    """Its part for shear [Pa], (m, m)."""

    def __post_init__(self) -> None:
        put = object.__setattr__
        put(self, "dimension", check_dimension(self.dimension))
        for name in ("critical", "peak", "dilation", "turning"):
            put(self, name, number(getattr(self, name), name, minimum=0.0))
        for name in ("hardening", "peak_shear"):
            put(self, name, number(getattr(self, name), name, above=0.0))
        for name in ("bulk_modulus", "shear_modulus"):
            put(self, name, number(getattr(self, name), name, above=0.0, unit="Pa"))
        greatest = self.critical + self.peak
        if greatest >= STEEPEST[self.dimension]:
            raise ValueError(
                f"critical + peak must be below {STEEPEST[self.dimension]:g} in {self.dimension}D, got {greatest:g}: the "
                "sand would carry a deviator without lateral pressure."
            )
        if self.dilation * (greatest - self.turning) > greatest * (1.0 + 1e-12):
            raise ValueError(
                f"dilation {self.dilation:g} is too large: where q/p is critical + peak = {greatest:g} the sand would "
                f"dilate by {self.dilation * (greatest - self.turning):g}, more than q/p, and gain work. Take at most 1."
            )
        unit = identity(self.dimension)
        put(self, "unit", unit)
        put(self, "_bulk", self.bulk_modulus * np.outer(unit, unit))
        put(self, "_shear", 2.0 * self.shear_modulus * (np.eye(len(unit)) - np.outer(unit, unit) / self.dimension))
        put(self, "elastic", read_only(self._bulk + self._shear))  # it is given out as a tangent

    def __repr__(self) -> str:
        return (
            f"<{type(self).__name__} in {self.dimension}D: q/p {self.critical:.3g} at large shear, "
            f"peak {self.peak:.3g} above it>"
        )

    def friction(self, kappa: float) -> float:
        """M, the q/p that is mobilised at the plastic shear kappa."""
        part = kappa / self.peak_shear
        return self.critical * -math.expm1(-kappa / self.hardening) + self.peak * part * math.exp(1.0 - part)

    def dilatancy(self, kappa: float) -> float:
        """D, the dilation per plastic shear at the plastic shear kappa."""
        return self.dilation * (self.friction(kappa) - self.turning)

    def slope(self, kappa: float) -> float:
        """dM/dkappa."""
        part = kappa / self.peak_shear
        first = self.critical / self.hardening * math.exp(-kappa / self.hardening)
        return first + self.peak / self.peak_shear * (1.0 - part) * math.exp(1.0 - part)

    def dilated(self, kappa: float, gamma: float) -> float:
        """The dilation while the plastic shear grows from kappa by gamma, the integral of D."""
        a, b, part = self.hardening, self.peak_shear, gamma / self.peak_shear
        start = kappa / b
        # differences of the integral of M that keep their digits if gamma is small
        area = self.critical * (gamma + a * math.exp(-kappa / a) * math.expm1(-gamma / a))
        falls = math.expm1(-part) + part * math.exp(-part) + start * math.expm1(-part)
        area -= self.peak * b * math.exp(1.0 - start) * falls
        return self.dilation * (area - self.turning * gamma)

    def invariants(self, stress: np.ndarray) -> tuple[float, float]:
        """Pressure p and deviator q of a stress (m,) [Pa]."""
        pressure = -float(stress[: self.dimension].sum()) / self.dimension
        shear = stress + pressure * self.unit
        return pressure, SHAPE[self.dimension] * math.sqrt(float(shear @ shear))

    @abstractmethod
    def respond(self, increment: np.ndarray, stress: np.ndarray, kappa: float) -> SandResponse:
        """The sand after an increment of strain (m,) from a stress (m,) [Pa] and a plastic shear kappa."""


@named_arguments
@dataclass(frozen=True, repr=False)
class DruckerPrager(Sand):
    """Sand that yields at ``q = M p``, whatever the intermediate principal stress. It takes the arguments of
    every :class:`~lmgcpy.continuum.Sand`."""

    def respond(self, increment: np.ndarray, stress: np.ndarray, kappa: float) -> SandResponse:
        """The sand after an increment of strain (m,) from a stress (m,) [Pa] and a plastic shear kappa.

        The direction of the flow and the friction are taken at the end of the increment, so that the increment of shear is
        the first root of the yield condition. The dilation is the integral of D: where the direction does not turn, as in a
        compression, increments make no error. The tangent is the exact derivative of this stress. If no pressure is left,
        the stress and the tangent are zero.
        """
        c, G, K, d = SHAPE[self.dimension], self.shear_modulus, self.bulk_modulus, self.dimension
        trial = stress + self.elastic @ increment
        pressure = -float(trial[:d].sum()) / d
        shear = trial + pressure * self.unit
        length = math.sqrt(float(shear @ shear))
        if c * length <= self.friction(kappa) * pressure:
            return SandResponse(trial, self.elastic, kappa)
        gamma = self._return(c * length, pressure, kappa)
        if gamma is None:  # the apex: all shear is lost
            zero = np.zeros(len(trial))
            return SandResponse(zero, np.zeros_like(self.elastic), kappa + length / (2.0 * G * c))
        end = kappa + gamma
        M, D, slope = self.friction(end), self.dilatancy(end), self.slope(end)
        left = 1.0 - 2.0 * G * c * gamma / length
        normal = shear / length
        pressure += K * self.dilated(kappa, gamma)
        # dgamma = rate . deps, from the derivative of the yield condition
        stiff = 2.0 * G * c * c + slope * pressure + M * K * D
        rate = (2.0 * G * c / stiff) * normal + (M * K / stiff) * self.unit
        tangent = self._bulk + left * self._shear
        tangent += np.multiply.outer(normal, 2.0 * G * (1.0 - left) * normal - 2.0 * G * c * rate)
        tangent -= np.multiply.outer(self.unit, K * D * rate)
        return SandResponse(left * shear - pressure * self.unit, tangent, end)

    def _return(self, deviator: float, pressure: float, kappa: float) -> float | None:
        """The first root of ``r(gamma) = q_tr - 2 c^2 G gamma - M (p_tr + K V)``, with M at kappa + gamma and V the
        dilation on the way there; None if no pressure is left.

        r is above zero at gamma = 0. At ``q_tr/(2 c^2 G)``, where q vanishes, r = -M p: below zero if a pressure is left.
        """
        K, soft = self.bulk_modulus, 2.0 * SHAPE[self.dimension] ** 2 * self.shear_modulus

        def residual(gamma: float) -> tuple[float, float]:
            end = kappa + gamma
            M, p = self.friction(end), pressure + K * self.dilated(kappa, gamma)
            return deviator - soft * gamma - M * p, -soft - self.slope(end) * p - M * K * self.dilatancy(end)

        return first_root(residual, deviator / soft, CLOSE * max(deviator, pressure))


def first_root(residual: Callable[[float], tuple[float, float]], high: float, close: float) -> float | None:
    """The first root between 0 and ``high`` of a residual that is above zero at 0; with its derivative it is the result of
    ``residual``. None if there is none. It may be ``close`` to zero, at ``high`` as well.

    If the residual at ``high`` is above zero, a root is searched piece by piece. A Newton step that leaves the interval, or
    does not halve it, is replaced by a step to its middle.
    """
    low = 0.0
    if residual(high)[0] > close:
        ends = [high * (i + 1) / PIECES for i in range(PIECES)]
        found = [end for end in ends if residual(end)[0] <= 0.0]
        if not found:
            return None
        low, high = found[0] - high / PIECES, found[0]
    gamma, last = low, math.inf
    for _ in range(MOST_STEPS):
        value, derivative = residual(gamma)
        if abs(value) <= close:
            break
        low, high = (gamma, high) if value > 0.0 else (low, gamma)
        step = -value / derivative if derivative != 0.0 else math.inf
        new = gamma + step
        if not low < new < high or abs(step) > 0.5 * last:
            new = 0.5 * (low + high)
        if new in (low, high):  # round-off
            break
        gamma, last = new, abs(new - gamma)
    return gamma
