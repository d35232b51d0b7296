"""What a campaign gains by a second worker, and what its engine costs a case.

Twelve biaxial tests of 300 particles on one worker and on two, in turn; a thousand cases that do nothing, by a Dask cluster
and by processes of this machine. The results of one and of two workers are compared to the bit.

    python benchmarks/campaign.py [EMPTY CASES]
"""

from __future__ import annotations

import resource
import sys
import tempfile
import time
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import distributed
import numpy as np
from table import report

from lmgcpy.experiment import Campaign, Study2D

TURNS = 2


def nothing(site, number):
    """A case that does nothing."""
    return {"number": number}


def seconds(campaign: Campaign, workers: int, dask: bool) -> tuple[float, list]:
    """Time of a campaign by the clock, and its numbers and curves."""
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory())) / "campaign"
        begin = time.perf_counter()
        where: dict[str, Any] = {"workers": workers}
        if dask:
            options = {"n_workers": workers, "threads_per_worker": 1, "dashboard_address": "127.0.0.1:0"}
            cluster = stack.enter_context(distributed.LocalCluster(**options))
            where = {"client": stack.enter_context(distributed.Client(cluster, set_as_default=False))}
        results = campaign.run(folder, **where)
        took = time.perf_counter() - begin
    assert len(results.finished) == len(results.cases), [case.error for case in results.cases]
    return took, [(case.numbers, case.curves) for case in results.cases]


def same(one: list, other: list) -> bool:
    """Whether results are the same bits."""
    return all(
        a == b and all(np.array_equal(p[t][n], q[t][n]) for t in p for n in p[t])
        for (a, p), (b, q) in zip(one, other, strict=True)
    )


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    study = Study2D(grain_count=250, bead_count=50, laws=("rigid-wire",), strain=0.05, check_strain=0.0)
    tests = Campaign(study, over={"seed": range(12)})
    seconds(Campaign(study, over={"seed": [0]}), 1, True)  # compiles
    rows = []
    for dask in (True, False):
        times: dict[int, float] = {1: np.inf, 2: np.inf}
        bits = {}
        for _ in range(TURNS):
            for workers in times:
                took, bits[workers] = seconds(tests, workers, dask)
                times[workers] = min(times[workers], took)
        assert same(bits[1], bits[2]), "the bits depend on the workers"
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        empty, _ = seconds(Campaign(nothing, over={"number": range(count)}), 2, dask)
        grown = (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) / 1024
        row = ["Dask" if dask else "processes", *(f"{t:.1f}" for t in times.values())]
        row += [f"{times[1] / times[2]:.2f}", str(count), f"{1e3 * empty / count:.1f}", f"{grown:.0f}"]
        rows.append(row)
    header = ["workers by", "12 tests, 1 worker [s]", "2 workers [s]", "gain"]
    report("campaign", [*header, "empty cases", "each [ms]", "memory grown [MB]"], rows)
