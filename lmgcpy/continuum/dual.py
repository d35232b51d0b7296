"""The strain that makes a stress in a network of wires: the Legendre transform of a sum of half parabolas.

``sup over eps of (sigma . eps - psi(eps))`` is reached wherever it is finite, as psi is convex and piecewise quadratic.
Its points are those where ``psi'(eps) = sigma``. They are found by Newton steps with an exact search along each step:
psi along a line is a piecewise parabola as well, whose least point lies between two of its kinks.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import nnls

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
