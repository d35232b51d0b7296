"""What dispatch costs in 3D: sweeps over Coulomb contacts between spheres by lmgcpy's law and by a kernel written by hand.

Both sweep the same contacts of the same step the same number of times; results are compared before any time is believed.
Times are medians of alternating runs.

    python benchmarks/contact_update_3d.py
"""

from __future__ import annotations

import math
import time

import numba
import numpy as np
from contact_update import RUNS, sweep_by_law
from table import report

import lmgcpy as lm

SWEEPS = 200


@numba.njit(error_model="numpy")
def sweep_by_hand(candidate, antagonist, normal, tangent, arm, delassus, bias, mu, impulse, velocity, inverse_mass, sweeps):
    for _ in range(sweeps):
        for k in range(candidate.shape[0]):
            i = np.uintp(k)
            c = candidate[i]
            a = antagonist[i]
            n_x = normal[i, 0]
            n_y = normal[i, 1]
            n_z = normal[i, 2]
            t_x = tangent[i, 0]
            t_y = tangent[i, 1]
            t_z = tangent[i, 2]
            s_x = n_y * t_z - n_z * t_y
            s_y = n_z * t_x - n_x * t_z
            s_z = n_x * t_y - n_y * t_x
            arm_c = arm[i, 0]
            arm_a = arm[i, 1]
            v_x = velocity[c, 0] - velocity[a, 0]
            v_y = velocity[c, 1] - velocity[a, 1]
            v_z = velocity[c, 2] - velocity[a, 2]
            w_x = arm_c * velocity[c, 3] + arm_a * velocity[a, 3]
            w_y = arm_c * velocity[c, 4] + arm_a * velocity[a, 4]
            w_z = arm_c * velocity[c, 5] + arm_a * velocity[a, 5]
            w_n = delassus[i, 0]
            w_t = delassus[i, 1]
            r_n = impulse[i, 0]
            r_t = impulse[i, 1]
            r_s = impulse[i, 2]
            q_n = n_x * v_x + n_y * v_y + n_z * v_z - w_n * r_n + bias[i]
            q_t = t_x * v_x + t_y * v_y + t_z * v_z - (s_x * w_x + s_y * w_y + s_z * w_z) - w_t * r_t
            q_s = s_x * v_x + s_y * v_y + s_z * v_z + (t_x * w_x + t_y * w_y + t_z * w_z) - w_t * r_s
            new_n = 0.0
            new_t = 0.0
            new_s = 0.0
            if q_n < 0.0:
                new_n = -q_n / w_n
                limit = mu[i] * new_n
                length = math.sqrt(q_t * q_t + q_s * q_s) / w_t
                factor = -1.0 / w_t if length <= limit else -limit / (length * w_t)
                new_t = factor * q_t
                new_s = factor * q_s
            if new_n == r_n and new_t == r_t and new_s == r_s:
                continue
            impulse[i, 0] = new_n
            impulse[i, 1] = new_t
            impulse[i, 2] = new_s
            d_n = new_n - r_n
            d_t = new_t - r_t
            d_s = new_s - r_s
            d_x = n_x * d_n + t_x * d_t + s_x * d_s
            d_y = n_y * d_n + t_y * d_t + s_y * d_s
            d_z = n_z * d_n + t_z * d_t + s_z * d_s
            m_x = t_x * d_s - s_x * d_t
            m_y = t_y * d_s - s_y * d_t
            m_z = t_z * d_s - s_z * d_t
            velocity[c, 3] += inverse_mass[c, 3] * (arm_c * m_x)
            velocity[c, 4] += inverse_mass[c, 4] * (arm_c * m_y)
            velocity[c, 5] += inverse_mass[c, 5] * (arm_c * m_z)
            velocity[a, 3] += inverse_mass[a, 3] * (arm_a * m_x)
            velocity[a, 4] += inverse_mass[a, 4] * (arm_a * m_y)
            velocity[a, 5] += inverse_mass[a, 5] * (arm_a * m_z)
            velocity[c, 0] += inverse_mass[c, 0] * d_x
            velocity[c, 1] += inverse_mass[c, 1] * d_y
            velocity[c, 2] += inverse_mass[c, 2] * d_z
            velocity[a, 0] -= inverse_mass[a, 0] * d_x
            velocity[a, 1] -= inverse_mass[a, 1] * d_y
            velocity[a, 2] -= inverse_mass[a, 2] * d_z


def packing(swelling: float) -> lm.Simulation:
    """2197 spheres on a close-packed lattice in a box, a little too large (pressed) or too small (loose) for it."""
    rng = np.random.default_rng(0)
    scene = lm.Scene(dimension=3, gravity=(0.5, 0.2, -9.81))
    radius, side = 0.01, 13
    up = 2.0 * radius * math.sqrt(2.0 / 3.0)
    for k in range(side):
        for j in range(side):
            for i in range(side):
                x = 2.0 * radius * (i + 0.5 * ((j + k) % 2)) + radius
                y = radius * math.sqrt(3.0) * (j + (k % 2) / 3.0) + radius
                swollen = radius * (1.0 + swelling * rng.random())
                scene.add(lm.sphere(radius=swollen, position=(x, y, up * k + radius), mass=1.0))
    for axis in range(3):
        scene.add(lm.wall(point=(0, 0, 0), normal=np.eye(3)[axis]))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    solver = lm.GaussSeidel(tolerance=1e-3, max_iterations=200)
    return lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore").run(steps=10)


def compare(name: str, swelling: float) -> list:
    problem = packing(swelling)._last[0]
    s = problem.system
    bias, mu = (np.ascontiguousarray(column) for column in s.prepared.reshape(-1, 2).T)
    start = s.impulse.copy(), s.velocity.copy()

    def by_hand() -> None:
        arrays = (s.candidate, s.antagonist, s.normal, s.tangent, s.arm, s.delassus, bias, mu)
        sweep_by_hand(*arrays, s.impulse, s.velocity, s.inverse_mass, SWEEPS)

    ways = [by_hand, lambda: sweep_by_law(problem.groups, s, SWEEPS)]

    def run(way) -> float:
        s.impulse[:], s.velocity[:] = start
        begin = time.perf_counter()
        way()
        return time.perf_counter() - begin

    impulses = []
    for way in ways:
        run(way)
        impulses.append(s.impulse.copy())
    difference = float(np.abs(impulses[0] - impulses[1]).max() / np.abs(impulses[0]).max())
    assert difference < 1e-9, f"the kernels disagree by {difference:.1e}"
    times = np.array([[run(way) for way in ways] for _ in range(RUNS)])
    per_update = np.median(times, axis=0) / (SWEEPS * len(bias)) * 1e9
    active = float(np.mean(impulses[0][:, 0] > 0.0))
    ratio = float(np.median(times[:, 1] / times[:, 0]))
    return [name, len(bias), f"{active:.2f}", f"{difference:.1e}", *(f"{t:.1f}" for t in per_update), f"{ratio:.2f}"]


if __name__ == "__main__":
    header = ["scene", "contacts", "active part", "difference", "by hand [ns]", "lmgcpy's law [ns]", "ratio (goal 1.15)"]
    report("contact_update_3d", header, [compare("pressed", 0.01), compare("loose", -0.01)])
