"""Sand after Mohr and Coulomb: it yields on the plane of its greatest and its least principal stress.

With pressures ``p1 >= p2 >= p3``, the principal values of -sigma, the sand yields at ``p1 = N p3``. Friction and dilatancy
are given as for every :class:`~lmgcpy.continuum.Sand`, as q/p and as dilation per shear of a triaxial compression, in
which p2 = p3::

    yield       p1 = N p3,  N = (3 + 2 M)/(3 - M) = (1 + sin phi)/(1 - sin phi)
    flow        d e1 = (1 - D/3) dgamma,  d e2 = 0,  d e3 = -(1 + 2 D/3) dgamma
                d kappa = dgamma

e the compression of the plastic strain. If two principal stresses become equal, two planes yield and share the flow: along
the edge of compressions (p2 = p3) e2 and e3 together follow the rule of e3, along the edge of extensions (p1 = p2) e1 and
e2 together that of e1. So a triaxial compression gives the same digits as Drucker and Prager's sand; between unequal
lateral stresses this sand is weaker. The lost work ``p1 e1' + p3 e3'`` is not negative if D <= M, as
``N (1 - D/3) >= 1 + 2 D/3`` then. Returns follow de Souza Neto, Peric and Owen (Computational Methods for Plasticity,
2008, chapter 8), with the integral of D in the place of a constant dilatancy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from lmgcpy.continuum.sand import CLOSE, Sand, SandResponse, first_root
from lmgcpy.continuum.tensors import PAIRS, products_of, tensor_of
from lmgcpy.errors import named_arguments

SAME = 1e-12
"""Difference of two principal stresses over the largest of them below which their directions count as free."""


class FlowRegion(NamedTuple):
    """End of a return: a plane, or one of its edges."""

    most: np.ndarray
    """Parts of the principal directions in the compression of the flow, (3,)."""
    least: np.ndarray
    """Their parts in its extension, (3,)."""
    mean: np.ndarray
    """By which trial stresses are replaced by the mean of those that become equal, (3, 3)."""


def _region(most: tuple[float, ...], least: tuple[float, ...]) -> FlowRegion:
    ends = np.array(most), np.array(least)
    mean = np.eye(3)
    for end in ends:
        mean[end > 0.0] = end
    return FlowRegion(*ends, mean)


PLANE = _region((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
COMPRESSION = _region((1.0, 0.0, 0.0), (0.0, 0.5, 0.5))
EXTENSION = _region((0.5, 0.5, 0.0), (0.0, 0.0, 1.0))


STEEPEST = -1.5
"""Dilatancy at which nothing flows in the direction of the least pressure; below it the flow would lower this pressure, and
more than one stress would belong to a strain."""


@named_arguments
@dataclass(frozen=True, repr=False)
class MohrCoulomb(Sand):
    """Sand in 3D that yields at the ratio of its greatest and least principal stress. It takes the arguments of every
    :class:`~lmgcpy.continuum.Sand`. At small shear it contracts by at most 3/2 of the shear, even if ``dilation *
    turning`` is more. Raises ValueError for dimension 2, in which DruckerPrager is the same law."""

    steep: float = field(init=False, repr=False, compare=False)
    """The plastic shear up to which the contraction is limited."""

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.dimension == 2:
            raise ValueError("MohrCoulomb is a sand in 3D; in 2D DruckerPrager is the law of Mohr and Coulomb.")
        dilatancy, most, steep = super().dilatancy, self.peak_shear, 0.0  # M grows up to there
        if dilatancy(0.0) < STEEPEST:
            ends = dilatancy(most) > STEEPEST
            steep = brentq(lambda kappa: dilatancy(kappa) - STEEPEST, 0.0, most) if ends else math.inf
        object.__setattr__(self, "steep", steep)

    def dilatancy(self, kappa: float) -> float:
        """D, the dilation per plastic shear at the plastic shear kappa."""
        return super().dilatancy(kappa) if kappa >= self.steep else STEEPEST

    def dilated(self, kappa: float, gamma: float) -> float:
        """The dilation while the plastic shear grows from kappa by gamma, the integral of D."""
        if kappa >= self.steep:
            return super().dilated(kappa, gamma)
        limited = min(gamma, self.steep - kappa)
        return STEEPEST * limited + (super().dilated(self.steep, gamma - limited) if gamma > limited else 0.0)

    def respond(self, increment: np.ndarray, stress: np.ndarray, kappa: float) -> SandResponse:
        """The sand after an increment of strain (m,) from a stress (m,) [Pa] and a plastic shear kappa.

        The stress has the directions of the trial stress of an elastic step, as the sand is isotropic. The tangent
        is the exact derivative of the stress. If no pressure is left, the stress and the tangent are zero.
        """
        trial = stress + self.elastic @ increment
        values, vectors = np.linalg.eigh(tensor_of(-trial))
        t, axes = values[::-1], vectors[:, ::-1].T
        if t[0] <= self._ratio(kappa)[0] * t[2]:
            return SandResponse(trial, self.elastic, kappa)
        region, found = PLANE, self._return(PLANE, t, kappa)
        if found is None:
            region = COMPRESSION if t[1] - t[2] < t[0] - t[1] else EXTENSION
        elif not found[1][0] >= found[1][1] >= found[1][2]:
            region = COMPRESSION if found[1][1] < found[1][2] else EXTENSION
        if region is not PLANE:
            found = self._return(region, t, kappa)
        if found is None or found[1][2] < 0.0:  # the apex: all shear is lost
            start = region.mean @ t  # of the edge: 3/2 of the shear is the difference of the plastic strains
            lost = float(start[0] - start[2]) / (3.0 * self.shear_modulus)
            return SandResponse(np.zeros(6), np.zeros((6, 6)), kappa + lost)
        gamma, pressures = found
        basis = products_of(axes)
        tangent = basis.T @ self._tangent(region, t, pressures, kappa + gamma) @ basis
        return SandResponse(-pressures @ basis[:3], tangent, kappa + gamma)

    def _ratio(self, kappa: float) -> tuple[float, float]:
        """N, the ratio of p1 and p3 at which the sand yields, and its derivative by kappa."""
        M = self.friction(kappa)
        return (3.0 + 2.0 * M) / (3.0 - M), 9.0 / (3.0 - M) ** 2 * self.slope(kappa)

    def _return(self, region: FlowRegion, trial: np.ndarray, kappa: float) -> tuple[float, np.ndarray] | None:
        """The shear and the principal pressures at which ``r(gamma) = p1 - N p3`` vanishes, N at kappa + gamma, if the sand
        flows as in a region; nothing if no pressure is left.

        With the dilation V on the way, Lame's constant ``L = K - 2 G/3`` and the directions m, l of ``most`` and ``least``,
        ``p = trial + L V - 2 G (m (gamma - V/3) - l (gamma + 2 V/3))``. The interval ends where p1 is not above p3: at
        the shear at which both would be equal without V, doubled until it is so. On the way p3 may be below zero: a sand
        that contracts has less pressure at first than at the root.
        """
        G, lame = self.shear_modulus, self.bulk_modulus - 2.0 * self.shear_modulus / 3.0
        start = region.mean @ trial

        def pressures(gamma: float) -> np.ndarray:
            V = self.dilated(kappa, gamma)
            return start + lame * V - 2.0 * G * (region.most * (gamma - V / 3.0) - region.least * (gamma + 2.0 * V / 3.0))

        def residual(gamma: float) -> tuple[float, float]:
            p, rate, (N, slope) = pressures(gamma), self._rate(region, kappa + gamma), self._ratio(kappa + gamma)
            return p[0] - N * p[2], rate[0] - N * rate[2] - slope * p[2]

        high = float((start[0] - start[2]) / (2.0 * G * (region.most[0] + region.least[2])))
        while (end := pressures(high))[0] > end[2]:
            high *= 2.0
        gamma = first_root(residual, high, CLOSE * float(np.abs(trial).max()))
        return None if gamma is None else (gamma, pressures(gamma))

    def _rate(self, region: FlowRegion, kappa: float) -> np.ndarray:
        """Derivative of the principal pressures by the shear of a return."""
        D, G = self.dilatancy(kappa), self.shear_modulus
        flow = region.most * (1.0 - D / 3.0) - region.least * (1.0 + 2.0 * D / 3.0)
        return (self.bulk_modulus - 2.0 * G / 3.0) * D - 2.0 * G * flow

    def _tangent(self, region: FlowRegion, trial: np.ndarray, pressures: np.ndarray, kappa: float) -> np.ndarray:
        """The tangent in the principal directions, (6, 6), of a return that ends at ``kappa``.

        The derivative of the residual gives dgamma by the trial pressures. The directions turn with the
        trial stress: a shear strain of two directions has 2 G times the ratio of their differences of pressure after and
        before the return.
        """
        G, (N, slope), rate = self.shear_modulus, self._ratio(kappa), self._rate(region, kappa)
        by_trial = N * region.mean[2] - region.mean[0]
        by_trial /= rate[0] - N * rate[2] - slope * pressures[2]
        change = region.mean + np.outer(rate, by_trial)
        tangent = np.zeros((6, 6))
        tangent[:3, :3] = change @ self.elastic[:3, :3]
        for place, (i, j) in enumerate(PAIRS[3], start=3):
            apart = trial[i] - trial[j]
            same = abs(apart) <= SAME * np.abs(trial).max()
            turned = change[i, i] - change[i, j] if same else (pressures[i] - pressures[j]) / apart
            tangent[place, place] = 2.0 * G * turned
        return tangent
