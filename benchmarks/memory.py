"""Memory of a dense sample of spheres, a particle with its contacts: what the process has grown by since before the scene.

Scene, objects of Python and the arrays of ten steps are counted; "at rest" after them, "at the most" within them. Each
count in a process of its own.

    python benchmarks/memory.py
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys

COUNTS = (10_000, 100_000)


def resident() -> int:
    """Bytes of memory that the process holds now."""
    with open("/proc/self/statm") as numbers:
        return int(numbers.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def measure(count: int) -> list:
    import gc

    from step_cost_3d import dense

    import lmgcpy as lm

    def run(spheres: int) -> lm.Simulation:
        solver = lm.GaussSeidel(max_iterations=10)
        options = {"solver": solver, "on_unconverged": "ignore", "overlap": "ignore"}
        return lm.Simulation(dense(spheres), time_step=2e-4, **options).run(steps=10)

    run(6000)  # kernels, with slabs
    gc.collect()
    before = resident()
    sim = run(count)
    gc.collect()
    most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    contacts = sim.report.interactions / count
    return [count, f"{contacts:.1f}", f"{(resident() - before) / count:.0f}", f"{(most - before) / count:.0f}"]


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(*measure(int(sys.argv[1])))
    else:
        from table import report

        header = ["spheres", "interactions a sphere", "at rest [B a sphere] (goal 2000)", "at the most [B a sphere]"]
        children = [subprocess.run([sys.executable, __file__, str(n)], capture_output=True, check=True) for n in COUNTS]
        report("memory", header, [child.stdout.decode().split() for child in children])
