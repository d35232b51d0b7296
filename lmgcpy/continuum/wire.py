"""The wire network of the local model (Villard): every direction is a wire that follows the strain and only pulls.

With N_k the vector of ``n_k (x) n_k``, the energy per volume is a sum of half parabolas, so it is convex and has a
continuous gradient::

    psi(eps) = 1/2 L EA sum_k w_k <n_k.eps.n_k - slack_k>_+^2    [J/m^3]
    sigma    = L EA sum_k w_k <...>_+ N_k                        [Pa]
    tangent  = L EA sum_k w_k H(...) N_k N_k^T                   [Pa]

The sand holds the wire: with an ``anchorage`` the tension of a wire is at most chi p, p the pressure of the sand, and a
wire that would pull more slips. chi is a number, or grows with the mean slip of all wires. See docs/continuum.md.

**The strain that makes a stress** is the Legendre transform of psi: ``sup over eps of (sigma . eps - psi(eps))`` is
reached wherever it is finite, as psi is convex and piecewise quadratic. Its points are those where ``psi'(eps) = sigma``.
They are found by Newton steps with an exact search along each step: psi along a line is a piecewise parabola as well,
whose least point lies between two of its kinks.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import nnls

from lmgcpy.continuum.directions import Directions
from lmgcpy.continuum.spans import Spans
from lmgcpy.continuum.tensors import SIZE
from lmgcpy.errors import is_infinite, named_arguments, number, numbers, read_only, shown


class WireResponse(NamedTuple):
    """Response of the wire to a strain, with the derivatives that a tangent needs."""

    stress: np.ndarray
    """[Pa], (m,)."""
    stiffness: np.ndarray
    """Derivative of the stress by the strain at constant pressure of the sand [Pa], (m, m), symmetric."""
    slope: np.ndarray | None
    """Derivative of the stress by the pressure of the sand, (m,); None if no wire slips."""
    slip: np.ndarray
    """Slip of each direction at the end [-], (k,)."""

    def __repr__(self) -> str:
        slips = "none slips" if self.slope is None else "some slip"
        return f"<WireResponse of {len(self.slip)} directions, {slips}>"


@named_arguments
@dataclass(frozen=True, eq=False, repr=False)
class GrowingAnchorage:
    """An anchorage that grows as the wires slip: linear between points, and constant before the first and after the last.

    ``slip`` (n,): mean slip of the wires, each by its part of the length [-], growing; ``strength`` (n,): chi there, the
    greatest tension over the pressure of the sand [m^2], in 2D [m], which does not fall. Raises TypeError or ValueError
    with a sentence.
    """

    slip: Any
    strength: Any

    def __post_init__(self) -> None:
        slip = numbers(self.slip, "slip", "mean slips of the wires")
        strength = numbers(self.strength, "strength", "one number for each slip")
        if slip.ndim != 1 or not len(slip) or (np.diff(slip) <= 0.0).any() or slip[0] < 0.0:
            raise ValueError(f"slip must be growing numbers of at least zero, got {shown(self.slip)}.")
        if strength.shape != slip.shape or not strength[0] > 0.0 or (np.diff(strength) < 0.0).any():
            raise ValueError(
                f"strength must be {len(slip)} numbers above zero that do not fall, got {shown(self.strength)}."
            )
        object.__setattr__(self, "slip", read_only(slip))
        object.__setattr__(self, "strength", read_only(strength))

    def piece(self, slip: float) -> tuple[float, float, float]:
        """chi at a mean slip, its derivative on the side of larger slips, and the slip at which this derivative ends."""
        after = int(np.searchsorted(self.slip, slip, side="right"))
        if after == 0:
            return float(self.strength[0]), 0.0, float(self.slip[0])
        if after == len(self.slip):
            return float(self.strength[-1]), 0.0, math.inf
        (start, end), (low, high) = self.slip[after - 1 : after + 1].tolist(), self.strength[after - 1 : after + 1].tolist()
        slope = (high - low) / (end - start)
        return low + slope * (slip - start), slope, end

    def __repr__(self) -> str:
        first, last = self.strength[[0, -1]]
        return f"<GrowingAnchorage from {first:.3g} to {last:.3g} at a mean slip of {self.slip[-1]:.3g}>"


@named_arguments
@dataclass(frozen=True, eq=False, repr=False)
class WireNetwork:
    """Wires of all ``directions``, with the same axial rigidity.

    ``length`` L: length of wire per volume [m/m^3], in 2D per area [m/m^2]; ``axial_rigidity`` EA [N], in 2D per metre of
    depth as all forces; ``directions``: their :class:`~lmgcpy.continuum.directions.Directions`, or the
    :class:`~lmgcpy.continuum.spans.Spans` that share a tension; ``slack``: strain at which
    a wire begins to pull, a number or one for each direction, negative if it pulls from the start; ``anchorage`` chi:
    greatest tension over the pressure of the sand [m^2], in 2D [m], a number or a :class:`GrowingAnchorage`; infinite:
    wires do not slip.

    Raises TypeError or ValueError with a sentence.
    """

    length: float
    axial_rigidity: float
    directions: Directions | Spans
    slack: Any = 0.0
    anchorage: float | GrowingAnchorage = math.inf
    products: np.ndarray = field(init=False)
    """N, the vectors of n (x) n, (k, m)."""
    stiffnesses: np.ndarray = field(init=False)
    """L EA w_k [Pa], (k,)."""

    def __post_init__(self) -> None:
        if not isinstance(self.directions, (Directions, Spans)):
            raise TypeError(
                f"directions must be Directions, such as isotropic(3) makes, or Spans, got {shown(self.directions)}."
            )
        put = object.__setattr__
        put(self, "length", number(self.length, "length", above=0.0, unit="m/m^d"))
        put(self, "axial_rigidity", number(self.axial_rigidity, "axial_rigidity", above=0.0, unit="N"))
        slack = numbers(self.slack, "slack", "a number or one for each direction")
        if slack.shape not in ((), (len(self.directions),)):
            raise ValueError(
                f"slack must be a number or one for each of the {len(self.directions)} directions, got shape {slack.shape}."
            )
        put(self, "slack", np.full(len(self.directions), slack) if slack.shape == () else slack)
        if not isinstance(self.anchorage, GrowingAnchorage) and not is_infinite(self.anchorage):
            put(self, "anchorage", number(self.anchorage, "anchorage", above=0.0, unit="m^2 (in 2D m)"))
        put(self, "products", self.directions.products)
        put(self, "stiffnesses", self.length * self.axial_rigidity * self.directions.weights)

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.directions.dimension

    @cached_property
    def _weighted(self) -> np.ndarray:
        """Rows ``L EA w_k N_k``, transposed, (m, k)."""
        return np.ascontiguousarray((self.products * self.stiffnesses[:, None]).T)

    def __repr__(self) -> str:
        if isinstance(self.anchorage, GrowingAnchorage):
            held = f", {self.anchorage!r}"
        else:
            held = "" if self.anchorage == math.inf else f", anchorage {self.anchorage:.3g}"
        return (
            f"<WireNetwork of {self.length:.3g} m/m^{self.dimension}, EA {self.axial_rigidity:.3g} N, "
            f"{len(self.directions)} directions{held}>"
        )

    def elongation(self, strain: Any) -> np.ndarray:
        """``n.eps.n - slack`` of each direction for a strain (m,), shape (k,): a wire pulls if it is above zero."""
        return self.products @ self._vector(strain, "strain") - self.slack

    def energy(self, strain: Any) -> float:
        """psi [J/m^3] at a strain (m,), without slip."""
        return 0.5 * float(self.stiffnesses @ np.maximum(self.elongation(strain), 0.0) ** 2)

    def stress(self, strain: Any) -> np.ndarray:
        """Gradient of psi [Pa], (m,), at a strain (m,), without slip."""
        return self._weighted @ np.maximum(self.elongation(strain), 0.0)

    def tangent(self, strain: Any) -> np.ndarray:
        """Derivative of the stress [Pa], (m, m), at a strain (m,), without slip. It is symmetric and has no negative
        eigenvalue. At the strain at which a wire begins to pull, it is the derivative on the slack side."""
        return (self._weighted * (self.elongation(strain) > 0.0)) @ self.products

    def tensions(self, strain: Any, slip: Any = 0.0) -> np.ndarray:
        """Tension ``EA <n.eps.n - slack - slip>_+`` of each direction [N], (k,)."""
        return self.axial_rigidity * np.maximum(self.elongation(strain) - slip, 0.0)

    def respond(self, strain: np.ndarray, slip: np.ndarray, pressure: float) -> WireResponse:
        """The wire at a strain (m,), after the ``slip`` (k,) at the start of the increment, in sand of ``pressure`` [Pa].

        ``T = EA <n.eps.n - slack - slip>_+``; if this exceeds chi p, the wire slips until it equals chi p. Slip only grows,
        and in an increment the wire loses ``L w T dslip >= 0`` to friction. A chi that grows with the mean slip m is taken
        at the end of the increment. With the wires S that slip, ``V = L EA sum_S w N``, ``W = sum_S w`` and chi' its
        slope, ``dm = V.deps / (L EA) - W d(chi p) / EA``, so that the stress of S changes by ::

            V d(chi p) / EA = (chi' p / (L EA^2) V V.deps + chi V / EA dp) / (1 + R)
            R = chi' p W / EA
        """
        stretch = self.products @ strain
        stretch -= self.slack
        if self.anchorage == math.inf:
            np.maximum(stretch, 0.0, out=stretch)
            return WireResponse(self._weighted @ stretch, (self._weighted * (stretch > 0.0)) @ self.products, None, slip)
        stretch -= slip
        compliance = max(pressure, 0.0) / self.axial_rigidity  # stretch at which T = chi p, over chi
        chi, growth = self._held(stretch, float(self.directions.weights @ slip), compliance)
        ceiling = chi * compliance
        excess = stretch - ceiling
        slipping = excess > 0.0
        if not slipping.any():
            np.maximum(stretch, 0.0, out=stretch)
            return WireResponse(self._weighted @ stretch, (self._weighted * (stretch > 0.0)) @ self.products, None, slip)
        held = np.clip(stretch, 0.0, ceiling)
        elastic = (stretch > 0.0) & ~slipping
        stiffness = (self._weighted * elastic) @ self.products
        # a slipping wire pulls with chi p, whatever its own strain
        slope = self._weighted @ slipping
        rate = compliance * growth
        shared = 1.0 / (1.0 + rate * float(self.directions.weights @ slipping))
        stiffness += np.multiply.outer(slope, shared * rate / (self.length * self.axial_rigidity) * slope)
        slope *= shared * chi / self.axial_rigidity if pressure > 0.0 else 0.0
        return WireResponse(self._weighted @ held, stiffness, slope, slip + np.maximum(excess, 0.0))

    def _held(self, stretch: np.ndarray, slipped: float, compliance: float) -> tuple[float, float]:
        """chi at the mean slip m at the end of an increment, and its derivative by m.

        ``stretch`` (k,): stretches less the slips before it; ``slipped``: their mean; ``compliance``: p / EA. m is the root
        of ``g(m) = m - slipped - sum_k w_k <stretch_k - chi(m) p / EA>_+``. g grows and, on each piece of chi, is concave:
        Newton's steps from its start do not pass the root, and end after as many steps as wires cease to slip.
        """
        if not isinstance(self.anchorage, GrowingAnchorage):
            return self.anchorage, 0.0
        weights, mean = self.directions.weights, slipped
        while True:
            chi, growth, end = self.anchorage.piece(mean)
            excess = stretch - chi * compliance
            slipping = excess > 0.0
            value = mean - slipped - float(weights @ np.maximum(excess, 0.0))
            new = mean - value / (1.0 + growth * compliance * float(weights @ slipping))
            if new >= end:
                mean = end
            elif new > mean * (1.0 + 1e-15):
                mean = new
            else:  # also for NaN
                return chi, growth

    def dissipation(self, strain: Any, slip_before: np.ndarray, slip_after: np.ndarray) -> float:
        """``L sum_k w_k T_k dslip_k`` of an increment that ends at ``strain`` [J/m^3]."""
        tensions = self.tensions(strain, slip_after)
        return self.length * float(self.directions.weights @ (tensions * (slip_after - slip_before)))

    def dual_energy(self, stress: Any) -> float:
        """Legendre transform ``psi*(sigma) = sup over eps of (sigma . eps - psi(eps))`` [J/m^3] of a stress (m,) [Pa].

        It is ``min sum_k t_k^2 / (2 L EA w_k) + slack_k t_k`` over tensions per area ``t_k >= 0`` with ``sum_k t_k N_k =
        sigma``: infinite if the wires cannot make the stress, that is, outside of the cone of the N_k. Slip is zero.
        """
        sigma = self._vector(stress, "stress")
        strain = dual_strain(self.products, self.stiffnesses, self.slack, sigma)
        return math.inf if strain is None else float(sigma @ strain) - self.energy(strain)

    def strain(self, stress: Any) -> np.ndarray:
        """Strain (m,) at which the network has the stress (m,) [Pa], if there is exactly one: gradient of psi*.

        Raises ValueError if the wires cannot make the stress, or if the wires that pull leave a strain free.
        """
        sigma = self._vector(stress, "stress")
        strain = dual_strain(self.products, self.stiffnesses, self.slack, sigma)
        if strain is None:
            raise ValueError(
                f"The wires cannot make the stress {shown(sigma.tolist())}: they only pull, in their directions."
            )
        stiff = np.linalg.eigvalsh(self.tangent(strain))
        if not stiff[0] > 1e-10 * self.stiffnesses.sum():
            raise ValueError(
                "The stress does not determine the strain: the wires that pull leave one free, their tangent is singular."
            )
        return strain

    def _vector(self, value: Any, name: str) -> np.ndarray:
        given = numbers(value, name, f"{SIZE[self.dimension]} components")
        if given.shape != (SIZE[self.dimension],):
            raise ValueError(
                f"{name} must be {SIZE[self.dimension]} components in Mandel's notation in {self.dimension}D, "
                f"got shape {given.shape}."
            )
        return given


MOST_STEPS = 500
"""Largest number of Newton steps."""
CLOSE = 1e-11
"""Residual over the stress that ends them."""
IN_CONE = 1e-9
"""Largest distance from the cone over the stress of a stress that counts as one of the cone."""
SHIFT = 1e-12
"""Number added to the diagonal of the tangent, over the stiffness of all wires: a strain that no wire resists stays."""


def dual_strain(products: np.ndarray, stiffnesses: np.ndarray, slack: np.ndarray, stress: np.ndarray) -> np.ndarray | None:
    """A strain (m,) with ``sum_k c_k <N_k.eps - slack_k>_+ N_k = stress``, c_k the ``stiffnesses`` [Pa]; None if there is
    none.

    Raises ArithmeticError if Newton steps do not find it.
    """
    used = stiffnesses > 0.0
    products, stiffnesses, slack = products[used], stiffnesses[used], slack[used]
    size = float(np.linalg.norm(stress))
    if size == 0.0:  # psi may be zero at no strain if wires pull from the start, so that the steps below must search
        size = float(stiffnesses @ np.maximum(-slack, 0.0))
    elif nnls(products.T, stress / size)[1] > IN_CONE:
        return None
    strain = np.zeros(products.shape[1])
    shift = SHIFT * stiffnesses.sum() * np.eye(len(strain))
    for _ in range(MOST_STEPS):
        stretch = products @ strain - slack
        gradient = (stiffnesses * np.maximum(stretch, 0.0)) @ products - stress
        if np.linalg.norm(gradient) <= CLOSE * size:
            return strain
        pulling = stiffnesses * (stretch > 0.0)
        step = np.linalg.solve((products.T * pulling) @ products + shift, -gradient)
        strain = strain + _least_point(stretch, products @ step, stiffnesses, float(stress @ step)) * step
    raise ArithmeticError(f"The strain of the wires was not found in {MOST_STEPS} Newton steps.")


def _least_point(stretch: np.ndarray, rate: np.ndarray, stiffnesses: np.ndarray, work: float) -> float:
    """The x > 0 at which ``sum_k c_k <stretch_k + x rate_k>_+^2 / 2 - x work`` is least.

    Its derivative is piecewise linear and does not fall: the kinks are sorted, and the zero lies between two of them.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        kinks = np.where(rate != 0.0, -stretch / rate, -1.0)
    ahead = np.flatnonzero(kinks > 0.0)
    order = ahead[np.argsort(kinks[ahead])]
    pulls = (stretch > 0.0) | ((stretch == 0.0) & (rate > 0.0))
    change = np.where(rate > 0.0, 1.0, -1.0)[order]
    # derivative value(x) + slope x on each piece
    value = np.concatenate([[0.0], np.cumsum(change * (stiffnesses * rate * stretch)[order])])
    slope = np.concatenate([[0.0], np.cumsum(change * (stiffnesses * rate * rate)[order])])
    value += float((stiffnesses * rate * stretch)[pulls].sum()) - work
    slope += float((stiffnesses * rate * rate)[pulls].sum())
    ends = np.concatenate([kinks[order], [np.inf]])
    starts = np.concatenate([[0.0], kinks[order]])
    with np.errstate(divide="ignore", invalid="ignore"):
        zeros = np.where(slope > 0.0, -value / slope, np.inf)
    found = np.flatnonzero(zeros <= ends * (1.0 + 1e-12))
    at = int(found[0]) if len(found) else len(starts) - 1
    return float(max(zeros[at], starts[at])) if np.isfinite(zeros[at]) else 1.0
