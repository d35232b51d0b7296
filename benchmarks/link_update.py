"""What dispatch costs in wires: visits of an elastic wire's block, and sweeps over its links one at a time, by lmgcpy's
law, by a plug-in's, and by kernels written by hand.

All start from the same step of the same taut, unevenly stretched chain; results are compared before any time is
believed. The block by hand is the same semi-smooth Newton method with the law written into it.

    python benchmarks/link_update.py
"""

from __future__ import annotations

import time

import numba
import numpy as np
from contact_update import sweep_by_law
from table import report

import lmgcpy as lm

LINKS = 2000
VISITS = 40
RUNS = 15


class Stranger(lm.Law):
    """An elastic wire as someone else would write it."""

    NAME = "stranger-wire"
    APPLIES_TO = "link"
    PREPARED = ("excess", "softness")
    stiffness = lm.Parameter("N/m", above=0.0)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return ((gap - reference_gap) / time_step, 1.0 / (time_step**2 * parameters[0]))

    @staticmethod
    def react(W, u, prepared):
        excess, softness = prepared
        return (min(-(u[0] + excess) / (W[0][0] + softness), 0.0),)

    @staticmethod
    def slope(W, u, prepared):
        if u[0] + prepared[0] <= 0.0:
            return ((0.0,),)
        return ((-1.0 / (W[0][0] + prepared[1]),),)


@numba.njit(error_model="numpy")
def push(i, d, candidate, antagonist, normal, velocity, inverse_mass):
    c = candidate[i]
    a = antagonist[i]
    d_x = normal[i, 0] * d
    d_y = normal[i, 1] * d
    velocity[c, 0] += inverse_mass[c, 0] * d_x
    velocity[c, 1] += inverse_mass[c, 1] * d_y
    velocity[a, 0] -= inverse_mass[a, 0] * d_x
    velocity[a, 1] -= inverse_mass[a, 1] * d_y


@numba.njit(error_model="numpy")
def stretch(i, candidate, antagonist, normal, velocity):
    c = candidate[i]
    a = antagonist[i]
    v_x = velocity[c, 0] - velocity[a, 0]
    v_y = velocity[c, 1] - velocity[a, 1]
    return normal[i, 0] * v_x + normal[i, 1] * v_y


@numba.njit(error_model="numpy")
def links_by_hand(candidate, antagonist, normal, delassus, bias, compliance, impulse, velocity, inverse_mass, sweeps):
    for _ in range(sweeps):
        for k in range(candidate.shape[0]):
            i = np.uintp(k)
            w = delassus[i, 0]
            if w == 0.0:
                continue
            r = impulse[i, 0]
            u = stretch(i, candidate, antagonist, normal, velocity) - w * r
            new = min(0.0, -(u + bias[i]) / (w + compliance[i]))
            if new != r:
                impulse[i, 0] = new
                push(i, new - r, candidate, antagonist, normal, velocity, inverse_mass)


@numba.njit(error_model="numpy")
def residual_by_hand(candidate, antagonist, normal, delassus, bias, compliance, impulse, velocity, work, light):
    merit = 0.0
    changed = False
    for k in range(candidate.shape[0]):
        i = np.uintp(k)
        w = light * delassus[i, 0]
        if w == 0.0:
            work[0, i] = 0.0
            work[1, i] = 0.0
            continue
        r = impulse[i, 0]
        free = stretch(i, candidate, antagonist, normal, velocity) - w * r + bias[i]
        new = 0.0
        gradient = 0.0
        if free > 0.0:
            gradient = -1.0 / (w + compliance[i])
            new = free * gradient
        work[0, i] = new - r
        if abs(gradient - work[1, i]) > 1e-9 * abs(gradient) or (gradient == 0.0 and abs(new - r) > 1e-9 * abs(new)):
            changed = True
        work[1, i] = gradient
        merit += (w * (new - r)) ** 2 + 0.0 * gradient
    return merit, changed


@numba.njit(error_model="numpy")
def block_by_hand(
    candidate, antagonist, normal, delassus, coupling, bias, compliance, impulse, velocity, inverse_mass, work, light
):
    count = candidate.shape[0]
    merit, _ = residual_by_hand(candidate, antagonist, normal, delassus, bias, compliance, impulse, velocity, work, light)
    enough = 1e-24 * merit
    for _ in range(30):
        if merit <= enough:
            break
        above = 0.0
        for k in range(count):
            gradient = work[1, k]
            lower = -gradient * coupling[k - 1] if k > 0 else 0.0
            diagonal = 1.0 - (1.0 - light) * gradient * delassus[k, 0]
            pivot = diagonal - lower * above
            if not abs(pivot) > 1e-14 * abs(diagonal):
                return
            below = work[0, k - 1] if k > 0 else 0.0
            work[0, k] = (work[0, k] - lower * below) / pivot
            above = -gradient * coupling[k] / pivot if k < count - 1 else 0.0
            work[2, k] = above
        for k in range(count - 2, -1, -1):
            work[0, k] -= work[2, k] * work[0, k + 1]
        for k in range(count):
            i = np.uintp(k)
            d = work[0, i]
            if d != 0.0:
                impulse[i, 0] += d
                push(i, d, candidate, antagonist, normal, velocity, inverse_mass)
        before = merit
        merit, changed = residual_by_hand(
            candidate, antagonist, normal, delassus, bias, compliance, impulse, velocity, work, light
        )
        if not changed and not merit < 0.1 * before:
            break


def wire(law: lm.Law, wire_blocks: bool):
    """A step of a wire hanging between two fixed beads, its links stretched at random by up to a tenth."""
    rng = np.random.default_rng(0)
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    x = np.concatenate([[0.0], np.cumsum(rng.uniform(0.9, 1.1, LINKS))])
    beads = [scene.add(lm.disk(radius=0.2, position=(at, 0.0), mass=rng.uniform(0.5, 1.5))) for at in x]
    beads[0].fix()
    beads[-1].fix()
    scene.chain(beads, law, reference_gap=0.6)
    solver = lm.GaussSeidel(tolerance=1e-12, max_iterations=1, wire_blocks=wire_blocks)
    sim = lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore").run(steps=1)
    return sim.last_step[0], sim.last_step[0].free_velocity


def compare(name: str, blocks: bool) -> list:
    stiffness = 1e5
    (problem, free), (plugged, _) = (
        wire(law, blocks) for law in (lm.ElasticWire(stiffness=stiffness), Stranger(stiffness=stiffness))
    )
    s = problem.system
    bias, compliance = (np.ascontiguousarray(column) for column in s.prepared.reshape(-1, 2).T)
    work = np.zeros(s.scratch.shape[::-1])
    pairs = s.candidate, s.antagonist, s.normal, s.delassus

    def by_hand() -> None:
        if blocks:
            block_by_hand(*pairs, s.coupling, bias, compliance, s.impulse, s.velocity, s.inverse_mass, work, 2.0**-20)
        else:
            links_by_hand(*pairs, bias, compliance, s.impulse, s.velocity, s.inverse_mass, 20)

    sweeps = 1 if blocks else 20
    ways = [by_hand, lambda: sweep_by_law(problem.groups, s, sweeps), lambda: sweep_by_law(plugged.groups, s, sweeps)]

    def run(way) -> float:
        total = 0.0
        for _ in range(VISITS):
            s.impulse[:], s.velocity[:], s.scratch[:], work[:] = 0.0, free, 0.0, 0.0
            begin = time.perf_counter()
            way()
            total += time.perf_counter() - begin
        return total

    impulses = []
    for way in ways:
        run(way)
        impulses.append(s.impulse.copy())
    scale = float(np.abs(impulses[0]).max())
    difference = max(float(np.abs(impulses[0] - other).max()) / scale for other in impulses[1:])
    assert difference < 1e-9, f"the kernels disagree by {difference:.1e}"
    times = np.array([[run(way) for way in ways] for _ in range(RUNS)])
    per_update = np.median(times, axis=0) / (VISITS * sweeps * LINKS) * 1e9
    ratios = [float(np.median(times[:, i] / times[:, j])) for i, j in ((1, 0), (2, 0), (2, 1))]
    taut = float(np.mean(impulses[0][:, 0] < 0.0))
    return [
        *(name, LINKS, f"{taut:.2f}", f"{difference:.1e}"),
        *(f"{t:.1f}" for t in per_update),
        *(f"{ratio:.2f}" for ratio in ratios),
    ]


if __name__ == "__main__":
    header = ["update", "links", "taut part", "difference", "by hand [ns]", "lmgcpy's law [ns]", "plug-in [ns]"]
    header += ["lmgcpy / hand (goal 1.15)", "plug-in / hand (goal 1.15)", "plug-in / lmgcpy (goal 1.10)"]
    report("link_update", header, [compare("one block", True), compare("one link at a time", False)])
