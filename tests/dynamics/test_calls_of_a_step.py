"""How often Python calls a function in a step of a small scene: its cost beside the kernels, in numbers that no clock
disturbs.

Ten grains on a floor are at rest after 0.3 s, so that a step takes one sweep or two. It makes 312 calls, 22 of them of
kernels. In version 0.2.0 a step made 563 and took twice as long (``docs/benchmarks.md``, small scenes).
"""

from __future__ import annotations

import sys
from collections import Counter

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.compiled.kernel import INTERPRETED, Kernel

RADIUS = 0.01
MOST_CALLS, MOST_KERNELS = 340, 22

pytestmark = pytest.mark.skipif(INTERPRETED, reason="kernels that run as plain Python call functions of Python")


def heap(dimension: int, count: int, solver: lm.Solver) -> lm.Simulation:
    """Grains that lie side by side on a floor, after 0.3 s."""
    up = np.eye(dimension)[-1]
    scene = lm.Scene(dimension=dimension, gravity=tuple(-9.81 * up))
    grain = lm.disk if dimension == 2 else lm.sphere
    for i in range(count):
        scene.add(grain(radius=RADIUS, position=tuple(2.05 * RADIUS * i * np.eye(dimension)[0] + RADIUS * up), mass=1.0))
    scene.add(lm.wall(point=(0.0,) * dimension, normal=tuple(up)))
    for other in ("GRAIN", "WALL"):
        scene.see("GRAIN", other, lm.Coulomb(friction=0.3))
    return lm.Simulation(scene, time_step=1e-3, solver=solver).run(steps=300)


def calls_of_a_step(sim: lm.Simulation) -> Counter[str]:
    """Calls of functions in a step, by name; the least of five steps, as a step may make the list of neighbours anew."""

    def count(frame, event, function):
        if event == "call":
            calls[frame.f_code.co_qualname] += 1
        elif event == "c_call":
            calls["built-in"] += 1

    steps = []
    for _ in range(5):
        calls: Counter[str] = Counter()
        before = sys.getprofile()
        sys.setprofile(count)
        try:
            sim.step()
        finally:
            sys.setprofile(before)
        steps.append(calls)
    return min(steps, key=Counter.total)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_step_of_ten_grains_makes_few_calls(dimension):
    calls = calls_of_a_step(heap(dimension, 10, lm.Auto(tolerance=1e-4)))
    assert calls.total() <= MOST_CALLS
    assert calls[Kernel.__call__.__qualname__] <= MOST_KERNELS


@pytest.mark.parametrize("dimension", [2, 3])
def test_more_grains_make_no_more_calls(dimension):
    few, many = (calls_of_a_step(heap(dimension, count, lm.Auto(tolerance=1e-4))) for count in (10, 60))
    assert many.total() <= few.total() + 20


def test_auto_makes_few_calls_more_than_gauss_seidel():
    auto, plain = (calls_of_a_step(heap(2, 10, solver(tolerance=1e-4))) for solver in (lm.Auto, lm.GaussSeidel))
    assert auto.total() <= plain.total() + 15
