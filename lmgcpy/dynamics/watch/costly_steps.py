"""A step that costs far more than the others: it is reported once, while the run goes on."""

from __future__ import annotations

import itertools
import math

from lmgcpy.dynamics.watch import Said
from lmgcpy.solve.problems.report import Report

TIMES = 50.0
"""Sweeps of a costly step, in parts of their median over the steps of the run that needed any."""
LEAST = 1e8
"""Least number of impulses that a costly step solved for, some seconds of work: many sweeps of few contacts cost nothing.
(With a tenth of it the silo of the examples is reported: after a free fall of one or two sweeps a step its grains meet.)"""
STEPS = 20
"""Steps before the first that may be costly: a run that begins from no impulses has no usual step yet."""
OF_NEWTON = 50.0
"""Sweeps that cost about as much as one Newton step, which factorises a matrix."""
PARTS = 4
"""Parts of an octave that are counted apart."""
WIDEST = 32
"""Octaves of sweeps that are counted."""


class CostlySteps:
    """Counts the sweeps of the steps of a run by quarter octaves, from which it knows their median to 19 %."""

    def __init__(self, said: Said):
        self._said = said
        self._counts = (0,) * (PARTS * WIDEST)

    def after_step(self, report: Report, step: int, time: float) -> list[str]:
        """A sentence on the first step of the run that costs :data:`TIMES` the median; ``time``: of its end [s]."""
        sweeps = report.iterations + OF_NEWTON * report.factorisations
        if not sweeps > 0.0:
            return []
        sentences = []
        if sweeps * report.interactions >= LEAST and "costly step" not in self._said:
            median = self._median()
            if median > 0.0 and sweeps >= TIMES * median and self._said.first("costly step"):
                sentences.append(_sentence(report, sweeps / median, step, time))
        k = min(int(PARTS * math.log2(sweeps)), len(self._counts) - 1)
        self._counts = (*self._counts[:k], self._counts[k] + 1, *self._counts[k + 1 :])
        return sentences

    def _median(self) -> float:
        """Upper end of the quarter octave in which the median lies; 0 before there are :data:`STEPS` steps."""
        sums = list(itertools.accumulate(self._counts))
        if sums[-1] < STEPS:
            return 0.0
        return 2.0 ** ((next(k for k, count in enumerate(sums) if 2 * count >= sums[-1]) + 1) / PARTS)


def _sentence(report: Report, times: float, step: int, time: float) -> str:
    newton, usual = "", f"{float(format(times, '.2g')):.0f} times the work of a usual step of this run"
    if report.factorisations:
        newton = f" and {report.factorisations} Newton steps"
    worst = f" The worst interaction: {report.worst}: look at these bodies." if report.worst else ""
    return (
        f"Step {step}, to t = {time:g} s, took {report.iterations} sweeps{newton} over {report.interactions} interactions "
        f"in {report.step_seconds:.2g} s, some {usual}, and ended '{report.status}'.{worst} Bodies that "
        "overlap deeply, walls that crush what cannot yield, and very light bodies under heavy ones cost "
        "so much; a shorter time step or a smaller max_iterations of the solver limits it. (Said once.)"
    )
