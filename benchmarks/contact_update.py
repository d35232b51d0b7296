"""What dispatch costs: sweeps over Coulomb contacts by lmgcpy's law, by a plug-in's, and by a kernel written by hand.

All sweep the same contacts of the same step the same number of times; the results must agree to round-off, and are
compared before any time is believed. The kernel by hand has the law written into it and takes the same care with memory
and indices. The plug-in's law is a stranger's text of the same law, with a state that nobody reads. Times are medians of
alternating runs.

    python benchmarks/contact_update.py
"""

from __future__ import annotations

import time

import numba
import numpy as np
from table import report

import lmgcpy as lm
from lmgcpy.compiled.by_address import call
from lmgcpy.compiled.kernel import kernel
from lmgcpy.solve.kernels.system import Groups, System

SWEEPS = 400
RUNS = 15


class Stranger(lm.Law):
    """Coulomb's law as someone else would write it who knows that disks have no coupling; it counts its steps."""

    NAME = "stranger"
    APPLIES_TO = "contact"
    PREPARED = ("bias", "friction")
    KEEPS_GAP = True
    friction = lm.Parameter("-", minimum=0.0)
    age = lm.State("-", "steps")

    def rows(self, dimension: int) -> int:
        return dimension

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        if gap > 0.0:
            return (gap / time_step, parameters[0])
        back = min((reference_gap - gap) / time_step, -2.0 * velocity[0])  # of overlap that turning made
        return (-max(back, 0.0), parameters[0])

    @staticmethod
    def react(W, u, prepared):
        bias, friction = prepared
        closing = -(u[0] + bias)
        if closing <= 0.0:
            return (0.0, 0.0)
        pressure = closing / W[0][0]
        shear = -u[1] / W[1][1]
        return (pressure, min(max(shear, -friction * pressure), friction * pressure))

    @staticmethod
    def commit(gap, reference_gap, velocity, impulse, time_step, parameters, state):
        return (state[0] + 1.0,)


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


def packing(swelling: float, law: lm.Law) -> lm.Simulation:
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
    scene.see("GRAIN", "GRAIN", law)
    scene.see("GRAIN", "WALL", law)
    solver = lm.GaussSeidel(tolerance=1e-4, max_iterations=1000)
    return lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore").run(steps=20)


def compare(name: str, swelling: float) -> list:
    problem, plugged = (packing(swelling, law)._last[0] for law in (lm.Coulomb(friction=0.3), Stranger(friction=0.3)))
    s = problem.system
    assert np.array_equal(s.prepared, plugged.system.prepared)
    bias, mu = (np.ascontiguousarray(column) for column in s.prepared.reshape(-1, 2).T)
    start = s.impulse.copy(), s.velocity.copy()

    def by_hand() -> None:
        arrays = (s.candidate, s.antagonist, s.normal, s.arm, s.delassus, bias, mu)
        sweep_by_hand(*arrays, s.impulse, s.velocity, s.inverse_mass, SWEEPS)

    ways = [by_hand, lambda: sweep_by_law(problem.groups, s, SWEEPS), lambda: sweep_by_law(plugged.groups, s, SWEEPS)]

    def run(way) -> float:
        s.impulse[:], s.velocity[:] = start
        begin = time.perf_counter()
        way()
        return time.perf_counter() - begin

    impulses = []
    for way in ways:
        run(way)
        impulses.append(s.impulse.copy())
    difference = max(float(np.abs(impulses[0] - other).max() / np.abs(impulses[0]).max()) for other in impulses[1:])
    assert difference < 1e-9, f"the kernels disagree by {difference:.1e}"
    times = np.array([[run(way) for way in ways] for _ in range(RUNS)])
    per_update = np.median(times, axis=0) / (SWEEPS * len(bias)) * 1e9
    active = float(np.mean(impulses[0][:, 0] > 0.0))
    ratios = [float(np.median(times[:, i] / times[:, j])) for i, j in ((1, 0), (2, 0), (2, 1))]
    return [
        *(name, len(bias), f"{active:.2f}", f"{difference:.1e}"),
        *(f"{t:.1f}" for t in per_update),
        *(f"{ratio:.2f}" for ratio in ratios),
    ]


if __name__ == "__main__":
    header = ["scene", "contacts", "active part", "difference", "by hand [ns]", "lmgcpy's law [ns]", "plug-in [ns]"]
    header += ["lmgcpy / hand (goal 1.15)", "plug-in / hand (goal 1.15)", "plug-in / lmgcpy (goal 1.10)"]
    report("contact_update", header, [compare("pressed", 0.01), compare("loose", -0.01)])
