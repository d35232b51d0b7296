"""A warning if the step damps waves of a taut wire that it resolves.

If ``s = 4 h^2 T/(m l) > 2``, links have geometric stiffness, which resists bending of the wire
(``geometric_stiffness.py``). Waves that the step cannot resolve are gone within a step, as they should be. A slow wave of
the same wire, of a frequency w with ``h w << 1``, loses amplitude by the factor ``exp(-pi alpha h w)`` in each period, with
``alpha = 1 - 2/s``. This looks like friction.

With the velocities v across the wire, relative to the line between its ends, of a single mode

    w^2 = v . K v / v . M v,      v . C v / v . M v = alpha (h w)^2,

whatever its phase: ``K = sum (T/l) b b^T`` and ``C = sum kappa b b^T``, with b the map from velocities to the relative
velocity across a link. A motion is a standing wave if v is reversed half a period later, and is back after a whole period.
The motion of a wire among grains, or of one that is being laid, is none.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from lmgcpy.dynamics.geometric_stiffness import LinkStiffness
from lmgcpy.dynamics.model import Model
from lmgcpy.dynamics.step_problem import StepProblem
from lmgcpy.dynamics.watch.displacements import rounded_down
from lmgcpy.dynamics.watch.said import Said

EVERY = 16
"""New waves are looked for once in this number of steps."""
RESOLVED = 0.5
"""Largest ``h w`` of a wave that a step resolves, twelve steps a period."""
LOST = 0.02
"""Part of its amplitude that a wave may lose in a period before the run warns."""
FAINT = 1e-5
"""Least amplitude of a wave, in parts of the length of a link."""
ALIKE = 0.8
"""Cosine of the angle between two fields of velocities, weighted by mass, from which on they are the same."""


class Wave(NamedTuple):
    """A motion that may be a standing wave."""

    chain: int
    start: float
    """Time at which it was seen [s]."""
    frequency: float
    """w [rad/s]."""
    lost: float
    """Part of its amplitude that it loses in a period."""
    velocity: np.ndarray
    """Velocities of the beads across the wire at that time [m/s], (b, d)."""
    turned: bool = False
    """Whether it was reversed half a period later."""


class DampedWaves:
    """Looks for damped waves until the first one was reported."""

    def __init__(self, model: Model, said: Said):
        self._said = said
        self._steps = 0
        self._waves: tuple[Wave, ...] = ()
        self.look_at(model)

    def look_at(self, model: Model) -> None:
        """Go on with a model that has changed."""
        self._chains = [chain.bodies for chain in model.chains]
        self._cuts = np.cumsum([0, *(chain.link_count for chain in model.chains)])
        self._mass = model.free_mass[:, : model.dimension]
        self._waves = ()

    def after_step(self, problem: StepProblem, links: LinkStiffness, time: float) -> list[str]:
        """A sentence on the first wave that the step damps; ``time``: of the end of the step [s]."""
        stiffness = problem.system.geometric
        if "wave" in self._said or not len(stiffness):
            return []
        self._steps += 1
        kept = []
        for wave in self._waves:
            due = wave.start + (1.0 if wave.turned else 0.5) * 2.0 * math.pi / wave.frequency
            if time < due:
                kept.append(wave)
                continue
            now, mass = self._across(problem, wave.chain), self._mass[self._chains[wave.chain]]
            size = math.sqrt(float((mass * now * now).sum() * (mass * wave.velocity * wave.velocity).sum()))
            if (1.0 if wave.turned else -1.0) * float((mass * now * wave.velocity).sum()) <= ALIKE * size:
                continue
            if wave.turned and self._said.first("wave"):
                return [self._sentence(problem, links, wave, time)]
            kept.append(wave._replace(turned=True))
        if self._steps % EVERY == 0:
            seen = {wave.chain for wave in kept}
            stiff = np.logical_or.reduceat(stiffness > 0.0, self._cuts[:-1])
            for chain in (k for k in np.flatnonzero(stiff).tolist() if k not in seen):
                across = self._across(problem, chain)
                frequency, lost = self._seen(problem, links, chain, across)
                if 0.0 < problem.data.time_step * frequency < RESOLVED and lost > LOST:
                    kept.append(Wave(chain, time, frequency, lost, across))
        self._waves = tuple(kept)
        return []

    def _across(self, problem: StepProblem, chain: int) -> np.ndarray:
        """Velocities of the beads of a chain across it, relative to the line between its ends [m/s], (b, d)."""
        bodies = self._chains[chain]
        velocity = problem.system.velocity[bodies, : problem.dimension]
        share = np.linspace(0.0, 1.0, len(bodies))[:, None]
        normal = problem.system.normal[self._cuts[chain] : self._cuts[chain + 1]]
        return without(velocity - (1.0 - share) * velocity[0] - share * velocity[-1], np.concatenate([normal, normal[-1:]]))

    def _seen(self, problem: StepProblem, links: LinkStiffness, chain: int, across: np.ndarray) -> tuple[float, float]:
        """Frequency [rad/s] of the motion, and the part of its amplitude that it loses in a period."""
        part, h, d = slice(self._cuts[chain], self._cuts[chain + 1]), problem.data.time_step, problem.dimension
        system, data = problem.system, problem.data
        inertia = float((self._mass[self._chains[chain]] * across * across).sum())
        tension = np.maximum(-system.impulse[part, 0], 0.0) / h
        bent = without(np.diff(across, axis=0), system.normal[part])
        length = data.gap[part] + links.radius_sum[part]
        stiff = float((tension / length * (bent * bent).sum(axis=1)).sum())
        if not (inertia > 0.0 and stiff > 0.0):
            return 0.0, 0.0
        frequency = math.sqrt(stiff / inertia)
        if np.sqrt((across * across).sum(axis=1).max()) < FAINT * frequency * float(length.min()):
            return 0.0, 0.0
        answered = data.after[part, 1:d] - system.carried[part]
        damped = float((system.geometric[part] * (answered * answered).sum(axis=1)).sum())
        return frequency, -math.expm1(-math.pi * damped / inertia / (h * frequency))

    def _sentence(self, problem: StepProblem, links: LinkStiffness, wave: Wave, time: float) -> str:
        part, h = slice(self._cuts[wave.chain], self._cuts[wave.chain + 1]), problem.data.time_step
        s = float(links.resolution(problem.system.impulse, problem.data.gap, h)[part].max())
        first, last = (int(self._chains[wave.chain][at]) for at in (0, -1))
        return (
            f"Until t = {time:g} s a wave of the wire from body {first} to body {last}, of a period of "
            f"{2.0 * math.pi / wave.frequency:.3g} s, loses {100.0 * wave.lost:.2g} % of its amplitude in each: the step "
            f"is long for its beads, s = 4 h^2 T/(m l) = {s:.3g}, and geometric stiffness damps from 2 on. A time step of "
            f"{rounded_down(h * math.sqrt(2.0 / s))} s damps no wave. (Said once.)"
        )


def without(vectors: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Vectors (k, d) less their parts along unit normals (k, d)."""
    return vectors - (vectors * normal).sum(axis=1)[:, None] * normal
