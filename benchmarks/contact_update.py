"""What dispatch costs: a sweep over Coulomb contacts through the law's plug-in interface, against one written by hand.

Both sweep the same contacts of the same step the same number of times; the results must agree to round-off, and are
compared before any time is believed. The kernel by hand has the law written into it and takes the same care with memory
and indices. Times are medians of alternating runs.

    python benchmarks/contact_update.py
"""

from __future__ import annotations

import time

import numba
import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.jit import kernel
from lmgcpy.solve.gauss_seidel import call
from lmgcpy.solve.system import Groups, System

SWEEPS = 400
RUNS = 15


@numba.njit(error_model="numpy")
def sweep_by_hand(candidate, antagonist, normal, arm, delassus, bias, mu, impulse, velocity, inverse_mass, sweeps):
    for _ in range(sweeps):
        for k in range(candidate.shape[0]):
            i = np.uintp(k)
            c = candidate[i]
            a = antagonist[i]
            n_x = normal[i, 0]
            n_y = normal[i, 1]
            v_x = velocity[c, 0] - velocity[a, 0]
            v_y = velocity[c, 1] - velocity[a, 1]
            u_n = n_x * v_x + n_y * v_y
            u_t = n_x * v_y - n_y * v_x - arm[i, 0] * velocity[c, 2] - arm[i, 1] * velocity[a, 2]
            w_n = delassus[i, 0]
            w_t = delassus[i, 1]
            r_n = impulse[i, 0]
            r_t = impulse[i, 1]
            q_n = u_n - w_n * r_n + bias[i]
            new_n = 0.0
            new_t = 0.0
            if q_n < 0.0:
                new_n = -q_n / w_n
                limit = mu[i] * new_n
                new_t = min(limit, max(-limit, -(u_t - w_t * r_t) / w_t))
            if new_n == r_n and new_t == r_t:
                continue
            impulse[i, 0] = new_n
            impulse[i, 1] = new_t
            d_n = new_n - r_n
            d_t = new_t - r_t
            d_x = n_x * d_n - n_y * d_t
            d_y = n_y * d_n + n_x * d_t
            velocity[c, 0] += inverse_mass[c, 0] * d_x
            velocity[c, 1] += inverse_mass[c, 1] * d_y
            velocity[a, 0] -= inverse_mass[a, 0] * d_x
            velocity[a, 1] -= inverse_mass[a, 1] * d_y
            velocity[c, 2] -= inverse_mass[c, 2] * arm[i, 0] * d_t
            velocity[a, 2] -= inverse_mass[a, 2] * arm[i, 1] * d_t


@kernel
def sweep_by_law(groups: Groups, s: System, sweeps):
    for _ in range(sweeps):
        for g in range(groups.start.shape[0]):
            call(groups.sweep[g], groups.start[g], groups.stop[g], groups.offset[g], s)


def packing(swelling: float) -> lm.Simulation:
    """2025 disks on a triangular lattice in a box, a little too large (pressed) or too small (loose) for it."""
    rng = np.random.default_rng(0)
    scene = lm.Scene(dimension=2, gravity=(0.5, -9.81))
    radius, side = 0.01, 45
    for j in range(side):
        for i in range(side):
            position = (2 * radius * (i + 0.5 * (j % 2)) + radius, 1.74 * radius * j + radius)
            scene.add(lm.disk(radius=radius * (1.0 + swelling * rng.random()), position=position, mass=1.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.add(lm.wall(point=(0, 0), normal=(1, 0)))
    scene.add(lm.wall(point=(2 * radius * (side + 0.5), 0), normal=(-1, 0)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    return lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-4, max_iterations=1000)).run(steps=20)


def compare(name: str, swelling: float) -> list:
    problem, _ = packing(swelling)._last
    s = problem.system
    bias, mu = (np.ascontiguousarray(column) for column in s.prepared.reshape(-1, 2).T)
    start = s.impulse.copy(), s.velocity.copy()

    def run(by_hand: bool) -> float:
        s.impulse[:], s.velocity[:] = start
        begin = time.perf_counter()
        if by_hand:
            arrays = (s.candidate, s.antagonist, s.normal, s.arm, s.delassus, bias, mu)
            sweep_by_hand(*arrays, s.impulse, s.velocity, s.inverse_mass, SWEEPS)
        else:
            sweep_by_law(problem.table, s, SWEEPS)
        return time.perf_counter() - begin

    run(False)
    by_law = s.impulse.copy()
    run(True)
    difference = float(np.abs(by_law - s.impulse).max() / np.abs(by_law).max())
    assert difference < 1e-9, f"the two kernels disagree by {difference:.1e}"
    times = np.array([(run(False), run(True)) for _ in range(RUNS)])
    per_update = np.median(times, axis=0) / (SWEEPS * len(bias)) * 1e9
    active = float(np.mean(by_law[:, 0] > 0.0))
    ratio = float(np.median(times[:, 0] / times[:, 1]))
    return [name, len(bias), f"{active:.2f}", f"{difference:.1e}", *(f"{t:.1f}" for t in per_update), f"{ratio:.2f}"]


if __name__ == "__main__":
    header = ["scene", "contacts", "active part", "difference", "by law [ns]", "by hand [ns]", "ratio (goal 1.15)"]
    report("contact_update", header, [compare("pressed", 0.01), compare("loose", -0.01)])
