"""Proximal masses: the claims of ``lmgcpy.solve.sweeps.light_bodies`` on small dense problems, solved independently."""

import numpy as np
import pytest
from scipy.optimize import nnls


def solve_convex(mass, free, H):
    """v that is least in ``1/2 (v - v_f).m (v - v_f)`` with ``H^T v >= 0``: impulses by non-negative least squares.

    Dual: the least ``|M^(-1/2) H r + M^(1/2) v_f|^2`` with r >= 0.
    """
    root = np.sqrt(mass)
    r, _ = nnls(H / root[:, None], -root * free, maxiter=10_000)
    return free + (H @ r) / mass


@pytest.mark.parametrize("ratio", [1.0, 1e2, 1e3])
@pytest.mark.parametrize("seed", range(5))
def test_moves_of_the_centre_contract(seed, ratio):
    """``|v_{j+1} - v*|^2_(2m+D) + |v_{j+1} - v_j|^2_D <= |v_j - v*|^2_D`` without friction, and the fixed point is
    the solution with the mass m. Eight bodies of 1 kg and eight of 1/ratio kg, 20 contacts between random pairs."""
    rng = np.random.default_rng(seed)
    mass = np.repeat([1.0, 1.0 / ratio], 8)
    swept = np.where(mass < 1.0, 0.25, mass)
    free = rng.standard_normal(16)
    H = np.zeros((16, 20))
    for k in range(20):
        c, a = rng.choice(16, 2, replace=False)
        H[c, k], H[a, k] = 1.0, -1.0
    exact = solve_convex(mass, free, H)
    D = swept - mass
    centre = np.zeros(16)
    before = D @ (centre - exact) ** 2
    for _ in range(40):
        shifted = (mass * free + D * centre) / swept
        v = solve_convex(swept, shifted, H)
        left = (2.0 * mass + D) @ (v - exact) ** 2 + D @ (v - centre) ** 2
        assert left <= before * (1.0 + 1e-7) + 1e-12  # round-off of the least squares
        centre, before = v, D @ (v - exact) ** 2
    shifted = (mass * free + D * exact) / swept
    assert solve_convex(swept, shifted, H) == pytest.approx(exact, abs=1e-7)


def test_a_mode_falls_by_what_it_takes_along():
    """One light body pushes a heavy one of mass S, or flies: the error of the centre falls by D/(D + S) in a move, S = m if
    it flies."""
    m, M = 0.01, 0.25
    for taken in (0.0, 1.0, 4.0):
        mass = np.array([m, max(taken, 1.0)])
        H = np.array([[-1.0], [1.0]]) if taken else np.zeros((2, 1))  # body 0 pushes body 1
        free = np.array([100.0, 0.0])
        exact = solve_convex(mass, free, H)
        swept = np.array([M, mass[1]])
        centre, D = np.zeros(2), swept - mass
        falls = []
        for _ in range(4):
            v = solve_convex(swept, (mass * free + D * centre) / swept, H)
            falls.append((v[0] - exact[0]) / (centre[0] - exact[0]))
            centre = v
        assert falls == pytest.approx([D[0] / (D[0] + m + taken)] * 4, rel=1e-6)
