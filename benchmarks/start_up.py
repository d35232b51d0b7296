"""What a user waits for before the first step: processes from start to end, least of several in turn.

python benchmarks/start_up.py
"""

from __future__ import annotations

import os
import statistics
import subprocess
import sys
import tempfile
import time

from table import report

RUNS = 7
STEP = """
import numpy as np
import lmgcpy as lm
from lmgcpy.experiment.biaxial import Biaxial
from lmgcpy.experiment.box import Sample

positions = np.array([(x if y % 2 == 0 else 9 - x, y) for y in range(10) for x in range(10)]) * 0.02 + 0.01
sample = Sample(positions, np.full(100, 0.0099), (15,), 0.001, (0.2, 0.2))
Biaxial(sample, lm.RigidWire(), friction=0.4, pressure=1e5, density=2600.0).run(1e-9, frames=0)
"""
"""The first step of a biaxial test: 85 grains, 15 beads of an inextensible wire, four walls."""
TEN = """
from lmgcpy.compiled.ahead import ahead
import lmgcpy as lm

ahead.is_over = {alone}
scene = lm.Scene(dimension={d}, gravity=(*[0.0] * ({d} - 1), -9.81))
make = lm.disk if {d} == 2 else lm.sphere
for i in range(10):
    scene.add(make(radius=0.01, mass=1.0, position=(0.021 * (i % 3), *[0.0] * ({d} - 2), 0.011 + 0.021 * (i // 3))))
scene.add(lm.wall(point=[0.0] * {d}, normal=(*[0.0] * ({d} - 1), 1.0)))
for other in ("GRAIN", "WALL"):
    scene.see("GRAIN", other, lm.Coulomb(friction=0.3))
lm.Simulation(scene, time_step=1e-3).step()
"""
"""The first step of ten grains on a floor, by two processes that compile, or by one alone."""
MEANWHILE = """
import time
begin = time.perf_counter()
{ten}
print(time.perf_counter() - begin)
from lmgcpy.compiled.meanwhile import meanwhile
meanwhile.wait()
"""
"""The same as plain Python, while the kernels are compiled; prints its time."""
COLD = 3
"""Runs with an empty cache; the median counts."""


def seconds(code: str, cache: str) -> float:
    """Time of a process that runs the code."""
    begin = time.perf_counter()
    first = {"LMGCPY_CACHE_DIR": cache, "LMGCPY_COMPILE_FIRST": "1"}
    subprocess.run([sys.executable, "-c", code], check=True, env={**os.environ, **first})
    return time.perf_counter() - begin


def seconds_of_plain_python(code: str, cache: str) -> float:
    """Time until the first step of the code is made while its kernels are compiled."""
    usual = {name: value for name, value in os.environ.items() if name != "LMGCPY_COMPILE_FIRST"}
    command = [sys.executable, "-c", MEANWHILE.format(ten=code)]
    done = subprocess.run(command, check=True, env={**usual, "LMGCPY_CACHE_DIR": cache}, capture_output=True, text=True)
    return float(done.stdout)


def main() -> None:
    with tempfile.TemporaryDirectory() as cache:
        first = seconds(STEP, cache)
        codes = {"import numba": "import numba", "import lmgcpy": "import lmgcpy", "first step, cache filled": STEP}
        times: dict[str, list[float]] = {name: [] for name in codes}
        for _ in range(RUNS):
            for name, code in codes.items():
                times[name].append(seconds(code, cache))
    rows = [[name, f"{min(measured):.2f}"] for name, measured in times.items()]
    rows.append(["first step, cache empty", f"{first:.1f}"])
    ways = [(False, "two processes compile", seconds), (True, "one process alone", seconds)]
    ways.append((False, "plain Python meanwhile", seconds_of_plain_python))
    for d, name in ((2, "disks"), (3, "spheres")):
        for alone, how, measure in ways:
            cold = []
            for _ in range(COLD):
                with tempfile.TemporaryDirectory() as cache:
                    cold.append(measure(TEN.format(alone=alone, d=d), cache))
            rows.append([f"first step of ten {name}, cache empty, {how}", f"{statistics.median(cold):.1f}"])
    for options in ("--dimension 2", "--dimension 3", ""):
        with tempfile.TemporaryDirectory() as cache:
            warm = seconds(f"from lmgcpy.cli import main; main(['warmup', *'{options}'.split()])", cache)
        rows.append([f"lmgcpy warmup {options}, cache empty".replace(" ,", ","), f"{warm:.1f}"])
    report("start_up", ["process", "time [s]"], rows)


if __name__ == "__main__":
    main()
