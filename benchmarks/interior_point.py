"""An interior point method on jammed steps, beside sweeps: why there is none among the solvers.

With ``x = (mu r_n, r_t)`` and ``z = (u_n / mu + |u_t|, u_t)`` Coulomb's law is ``x o z = 0`` in the second-order
cone, and a step is ``z = W x + q + s e_0`` with ``s = |u_t|`` (de Saxce and Feng 1998). A Newton step with Nesterov
and Todd's scaling G, ``G x = G^-1 z``, and Mehrotra's predictor and corrector, solves

    (W + A G^2) dx = ...,    A = 1 - kappa e_0 tau^T,    tau = u_t / |u_t|.

``kappa = 0`` holds the dilation s, which makes the step convex (Acary, Cadoux, Lemarechal, Malick 2011; Acary,
Armand, Nguyen, Shpakovych 2023), and moves it by a part of ``|u_t| - s`` afterwards; ``kappa = 1`` is Newton's method
in s as well. Between the two lies an implicit step of ``ds/dt = |u_t| - s`` of length ``T = kappa / (1 - kappa)``,
which is controlled by the length of the steps that stay in the cones: where the way has a fold they become short, and
T with them.

python benchmarks/interior_point.py [SPHERES [SAMPLES [FACTORISATIONS]]]
"""

from __future__ import annotations

import sys
import time as clock

import numpy as np
import scipy.sparse as sparse
from jammed import FRICTIONS, isotropic
from scipy.sparse.linalg import splu
from table import report

import lmgcpy as lm

BACK = 0.99
"""Part of the way to the edge of the cones that a step takes."""
SHORT, LONG, SHRINK, STRETCH, LEAST = 0.3, 0.6, 0.3, 1.5, 0.02
"""T shrinks after shorter steps and stretches after longer ones."""
LEVELS = (1e-2, 1e-3, 1e-4, 1e-6)


def determinant(x: np.ndarray) -> np.ndarray:
    size = np.linalg.norm(x[:, 1:], axis=1)
    return (x[:, 0] - size) * (x[:, 0] + size)


def product(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Jordan product."""
    return np.column_stack([(x * y).sum(axis=1), x[:, :1] * y[:, 1:] + y[:, :1] * x[:, 1:]])


def quotient(x: np.ndarray, b: np.ndarray) -> np.ndarray:
    """y of ``x o y = b``."""
    first = (x[:, 0] * b[:, 0] - (x[:, 1:] * b[:, 1:]).sum(axis=1)) / determinant(x)
    return np.column_stack([first, (b[:, 1:] - first[:, None] * x[:, 1:]) / x[:, :1]])


def scaling(x: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """G and its inverse, (m, d, d)."""
    size_x, size_z = np.sqrt(determinant(x)), np.sqrt(determinant(z))
    mirrored = x / size_x[:, None] * np.r_[1.0, -np.ones(x.shape[1] - 1)]
    unit = z / size_z[:, None]
    half = 1.0 + (x * z).sum(axis=1) / (size_x * size_z)
    w = (unit + mirrored) / np.sqrt(2.0 * half)[:, None]
    G = np.zeros((*x.shape, x.shape[1]))
    G[:, 0, :], G[:, 1:, 0] = w, w[:, 1:]
    turned = np.einsum("ia,ib->iab", w[:, 1:], w[:, 1:]) / (1.0 + w[:, 0])[:, None, None]
    G[:, 1:, 1:] = np.eye(x.shape[1] - 1) + turned
    inverse = G.copy()
    inverse[:, 0, 1:] *= -1.0
    inverse[:, 1:, 0] *= -1.0
    eta = np.sqrt(size_z / size_x)[:, None, None]
    return eta * G, inverse / eta


def longest(x: np.ndarray, dx: np.ndarray) -> float:
    """Largest part of a step that stays in the cones."""
    a, c = dx[:, 0] ** 2 - (dx[:, 1:] ** 2).sum(axis=1), determinant(x)
    b = x[:, 0] * dx[:, 0] - (x[:, 1:] * dx[:, 1:]).sum(axis=1)
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    with np.errstate(all="ignore"):
        reach = np.where(b < 0.0, c / (root - b), -(b + root) / a)
        reach = np.where((b * b >= a * c) & (reach > 0.0), reach, np.inf)
        axis = np.where(dx[:, 0] < 0.0, -x[:, 0] / dx[:, 0], np.inf)
    return float(min(reach.min(), axis.min(), 1.0 / BACK))


def interior_point(problem: lm.Problem, most: int) -> list[float]:
    """Least residual after so many factorisations, from no impulses; contacts with friction alone."""
    m, d = problem.guess.shape
    scale = np.ones((m, d))
    scale[:, 0] = 1.0 / problem.mu
    D = sparse.diags_array(scale.ravel())
    mean, q = problem.W.diagonal().mean(), scale * problem.q.reshape(m, d)
    W = (D @ problem.W @ D).tocsr() / mean
    unit = np.linalg.norm(q) / np.sqrt(m)
    q = q / unit
    nothing = np.linalg.norm(problem.errors(np.zeros((m, d))))
    one = np.tile(np.eye(d)[0], (m, 1))
    x, z, s, T = one.copy(), one.copy(), np.zeros(m), 0.5
    pointer, index = np.arange(m + 1), np.arange(m)
    least = [np.inf]
    for _ in range(most):
        gap, sliding = (x * z).sum() / m, np.linalg.norm(z[:, 1:], axis=1)
        kappa = T / (1.0 + T)
        off = (W @ x.ravel()).reshape(m, d) + q - z + (s + kappa * (sliding - s))[:, None] * one
        G, inverse = scaling(x, z)
        A = np.tile(np.eye(d), (m, 1, 1))
        A[:, 0, 1:] -= kappa * z[:, 1:] / np.maximum(sliding, 1e-300)[:, None]
        square = G @ G
        own = sparse.bsr_array((A @ square, index, pointer), shape=W.shape).tocsr()
        options = {"SymmetricMode": True}
        lu = splu((W + own).tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=1e-3, options=options)
        scaled = np.einsum("iab,ib->ia", G, x)

        def step(right: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            known = np.einsum("iab,ib->ia", G, right)  # noqa: B023
            dx = lu.solve((np.einsum("iab,ib->ia", A, known) - off).ravel()).reshape(m, d)  # noqa: B023
            return dx, known - np.einsum("iab,ib->ia", square, dx)  # noqa: B023

        # predictor, then corrector; the gap waits while the dilation is far from the sliding velocity
        dx, dz = step(-scaled)
        length = min(1.0, longest(x, dx), longest(z, dz))
        ahead = ((x + length * dx) * (z + length * dz)).sum() / m
        centring = 1.0 if np.linalg.norm(sliding - s) > np.sqrt(m * gap) else np.clip((ahead / gap) ** 3, 0.03, 1.0)
        second = product(np.einsum("iab,ib->ia", G, dx), np.einsum("iab,ib->ia", inverse, dz))
        dx, dz = step(quotient(scaled, centring * gap * one - product(scaled, scaled) - second))
        length = min(1.0, BACK * longest(x, dx), BACK * longest(z, dz))
        along = (z[:, 1:] * dz[:, 1:]).sum(axis=1) / np.maximum(sliding, 1e-300)
        s += length * kappa * (along + sliding - s)
        x += length * dx
        z += length * dz
        T = max(SHRINK * T, LEAST) if length < SHORT else STRETCH * T if length > LONG else T
        least.append(min(least[-1], float(np.linalg.norm(problem.errors(x * scale * unit / mean)) / nothing)))
    return least


def main(spheres: int, samples: int, most: int) -> None:
    rows = []
    for friction in FRICTIONS:
        for seed in range(samples):
            problem = isotropic(spheres, friction, seed)
            begin = clock.process_time()
            least = interior_point(problem, most)
            seconds = clock.process_time() - begin
            after = [next((str(k) for k, value in enumerate(least) if value <= level), "-") for level in LEVELS]
            sweeps = lm.AcceleratedGaussSeidel(tolerance=LEVELS[-1], max_iterations=2)
            lm.solve(problem, solver=sweeps)  # loads the kernels
            sweeps = lm.AcceleratedGaussSeidel(tolerance=LEVELS[-1], max_iterations=10_000)
            begin = clock.process_time()
            swept = lm.solve(problem, solver=sweeps, guess=np.zeros_like(problem.guess))
            swept_in = clock.process_time() - begin
            rows.append([spheres, friction, seed, *after, f"{least[-1]:.0e}", f"{seconds:.1f}"])
            rows[-1] += [f"{swept.residual:.0e}", f"{swept_in:.1f}"]
            print(*rows[-1], file=sys.stderr, flush=True)
    levels = [f"factorisations to {level:.0e}" for level in LEVELS]
    header = ["spheres", "friction", "seed", *levels, "least residual", "processor seconds"]
    report("interior_point", [*header, "of sweeps", "their seconds"], rows)


if __name__ == "__main__":
    given = [int(word) for word in sys.argv[1:]]
    main(*given, *(200, 2, 100)[len(given) :])
