"""What lmgcpy's own threads gain over numba's ``prange``: sweeps over one frozen step of a dense sample by both.

Both do the same tasks of the same phases by the same compiled kernels and must leave the same bits; ``prange`` cuts the
tasks of a phase into equal parts, one a thread. Runs take turns, and every sweep is timed by itself: the least time comes
near that of an idle machine, the median tells what waiting for each other costs on a busy one. The last column is what
the compiler takes for the loop. numba's threading layer is that of ``NUMBA_THREADING_LAYER``.

    NUMBA_THREADING_LAYER=workqueue python benchmarks/prange.py
"""

from __future__ import annotations

import time

import numba
import numpy as np
from llvmlite import ir
from numba.extending import intrinsic
from table import report
from threads import deposit, simulation

import lmgcpy as lm
from lmgcpy.compiled.by_address import ROOM, call_work
from lmgcpy.compiled.kernel import OPTIONS, Kernel
from lmgcpy.solve.sweeps.light_bodies import no_light_bodies
from lmgcpy.solve.sweeps.sweep import SWEEP, sweep_groups, work
from lmgcpy.solve.sweeps.team import Crew, Job, Team, lay, work_address

COUNTS = (10_000, 50_000)
SWEEPS = 5
RUNS = 150


@intrinsic
def cycles(typing_context):
    """The processor's own count of time."""

    def generate(context, builder, signature, arguments):
        count = ir.FunctionType(ir.IntType(64), [])
        return builder.call(builder.module.declare_intrinsic("llvm.readcyclecounter", fnty=count), [])

    return numba.int64(), generate


def sweep_by_team(team: Team, stamps):
    stamps[0] = cycles()
    for k in range(1, stamps.shape[0]):
        sweep_groups(team)
        stamps[k] = cycles()
    return 0, 0


def sweep_by_prange(phase, address, job, stamps):
    stamps[0] = cycles()
    for k in range(1, stamps.shape[0]):
        for f in range(phase.shape[0] - 1):
            for task in numba.prange(phase[f], phase[f + 1]):
                call_work(address, SWEEP, task, job)
        stamps[k] = cycles()


by_team = Kernel(sweep_by_team)
by_prange = numba.njit(parallel=True, **OPTIONS)(sweep_by_prange)


def compile_seconds(dispatcher) -> str:
    begin = time.perf_counter()
    dispatcher.compile((numba.int64[::1], numba.int64, numba.int64, numba.int64[::1]))
    return f"{time.perf_counter() - begin:.2f}"


def nanoseconds_a_cycle() -> float:
    count = numba.njit(lambda: cycles())
    count()
    begin, first = time.perf_counter(), count()
    time.sleep(0.2)
    return 1e9 * (time.perf_counter() - begin) / (count() - first)


def measure(count: int) -> list[list]:
    sim = simulation(deposit, (3, count, "at random"), slabs=True)
    sim.solver = lm.GaussSeidel(tolerance=1e-2, max_iterations=50)
    problem = sim.run(steps=20)._last[0]
    groups, s, task = problem.groups, problem.system, work
    start, none = (s.impulse.copy(), s.velocity.copy()), np.zeros(0)
    step = groups, s, start[1], start[0], no_light_bodies(s.velocity.shape[1])
    shared = np.zeros((len(groups.task), 4)), np.zeros(1), np.zeros(4), np.zeros(8)
    job = Job._make([*step, *[none] * 7, *shared, 1])
    place = np.empty(ROOM, dtype=np.int64)
    address = work_address(task, job, lay(job, place.ctypes.data))
    stamps = np.zeros(SWEEPS + 1, dtype=np.int64)

    def run(name: str, threads: int) -> np.ndarray:
        s.impulse[:], s.velocity[:] = start
        numba.set_num_threads(threads)
        if name == "prange":
            by_prange(groups.phase, address, place.ctypes.data, stamps)
        else:
            Crew(task, step, False, threads).run(by_team, (1.0, 1.0, 1.0), (stamps,))
        return np.diff(stamps)

    ways = [(name, threads) for threads in (1, 2) for name in ("team", "prange")]
    bits = {(run(*way), s.impulse.tobytes())[1] for way in ways}
    assert len(bits) == 1, "the bits depend on who does the tasks"
    times = np.concatenate([np.stack([run(*way) for way in ways], axis=1) for _ in range(RUNS)])
    times = times * nanoseconds_a_cycle() / len(s.candidate)
    rows = []
    for k, way in enumerate(ways):
        row = [count, len(s.candidate), *way]
        for of_all in (times.min(axis=0), np.median(times, axis=0)):
            row += [f"{of_all[k]:.1f}", f"{of_all[k] / of_all[k - k % 2]:.2f}"]
        rows.append(row)
    return rows


if __name__ == "__main__":
    plain = compile_seconds(numba.njit(**OPTIONS)(sweep_by_prange))
    parallel = compile_seconds(by_prange)
    rows = [row for count in COUNTS for row in measure(count)]
    header = ["spheres", "interactions", "by", "threads", "an interaction and sweep, least [ns]", "team = 1"]
    header += ["median [ns]", "team = 1", "layer", "compile [s]"]
    told = {"team": ["", plain], "prange": [numba.threading_layer(), parallel]}
    report("prange", header, [[*row, *told[row[2]]] for row in rows])
