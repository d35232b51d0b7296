"""A step written out once more in plain numpy with full matrices: what the kernels are compared with.

It starts from what a user sees of a simulation (frames, levers, gaps) and never calls a kernel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

import lmgcpy as lm


@dataclass(frozen=True)
class DenseStep:
    """The local problem ``u = free + W r`` of one step; two rows an interaction, normal first, m interactions."""

    H: np.ndarray
    """From impulses to momentum, (3 n, 2 m)."""
    W: np.ndarray
    """Delassus operator [1/kg], (2 m, 2 m)."""
    free: np.ndarray
    """Free relative velocities [m/s], (2 m,)."""
    before: np.ndarray
    """Relative velocities at the start of the step [m/s], (2 m,)."""

    def normal(self):
        """(W, free) of the normal components alone."""
        return self.W[::2, ::2], self.free[::2]


def lever_matrix(view: lm.Simulation, body_count: int) -> np.ndarray:
    """H from the frames and the levers of the interactions, (3 n, 2 m)."""
    H = np.zeros((3 * body_count, 2 * len(view)))
    for i in range(len(view)):
        for side, body in ((1.0, view.candidate[i]), (-1.0, view.antagonist[i])):
            x, y = view.lever[i, 0 if side > 0 else 1]
            for k in range(2):
                axis = view.frame[i, k]
                H[3 * body : 3 * body + 2, 2 * i + k] += side * axis
                H[3 * body + 2, 2 * i + k] += side * (x * axis[1] - y * axis[0])
    return H


def free_velocity(sim: lm.Simulation, before: np.ndarray) -> np.ndarray:
    """v + h M^-1 F with loads at the middle of the step just made, driven components at its end, (n, 3)."""
    model, h = sim.model, sim.time_step
    force = model.weight.copy()
    for load in model.forces:
        force[load.body, load.component] += load.at(sim.time - 0.5 * h)
    velocity = before + h * model.inverse_mass * force
    for drive in model.velocities:
        velocity[drive.body, drive.component] = drive.at(sim.time)
    return velocity


def dense_step(sim: lm.Simulation, before: np.ndarray) -> DenseStep:
    """The problem of the step just made; ``before``: velocities (x, y, spin) at its start, (n, 3)."""
    H = lever_matrix(sim.interactions, len(before))
    W = H.T @ (sim.model.inverse_mass.ravel()[:, None] * H)
    return DenseStep(H, W, H.T @ free_velocity(sim, before).ravel(), H.T @ before.ravel())


def state_velocities(sim: lm.Simulation) -> np.ndarray:
    """(v_x, v_y, spin) of all bodies, a copy, (n, 3)."""
    return np.column_stack([sim.velocities, sim.spins])


def wire_impulses(W: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """r of ``0 <= -(velocity + W r)  _|_  -r >= 0``: min 1/2 r.W r + r.velocity over r <= 0, as a least-squares problem.

    With W = L L^T and x = -r it is min |L^T x - L^-1 velocity|^2 over x >= 0, which Lawson and Hanson's active set solves
    in finitely many steps.
    """
    L = np.linalg.cholesky(W)
    x, _ = nnls(L.T, np.linalg.solve(L, velocity), maxiter=100 * len(W))
    return -x
