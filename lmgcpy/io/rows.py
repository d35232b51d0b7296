"""Rows of the tables of :mod:`lmgcpy.io.run_file`, collected step by step."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lmgcpy.errors import whole
from lmgcpy.io.observations import Observations
from lmgcpy.io.run_file.tables import INDEX, OBSERVED, history_type, interaction_type
from lmgcpy.solve.problems.report import STATUS

if TYPE_CHECKING:
    from lmgcpy.dynamics.stepper import Stepper


class Rows:
    """Rows that are not yet written: history and observations of every step, and a frame every ``every`` steps."""

    def __init__(self, every: int, observations: Observations):
        self.every = whole(every, "every", minimum=1)
        self.observations = observations
        self.latest: dict[str, np.ndarray] = {}
        """Observations after the last step."""
        self.begin([], 2, 0)

    def begin(self, laws: list[str], dimension: int, moments: int) -> None:
        """Begin a run without rows, with these laws and this number of moments of an interaction."""
        self.last_frame = -1
        self.laws = laws
        self.kind = interaction_type(dimension, moments)
        self.clear(0)

    def clear(self, interactions: int) -> None:
        """Forget the rows; ``interactions`` counts those that the table holds already."""
        self.history: list[tuple] = []
        self.observed: dict[str, list[np.ndarray]] = {name: [] for name in self.observations}
        self.index: list[tuple] = []
        self.positions: list[np.ndarray] = []
        self.velocities: list[np.ndarray] = []
        self.interactions: list[np.ndarray] = []
        self.bytes = 0
        self._interaction_count = interactions

    def end(self, sim: Stepper) -> None:
        """Make a frame of the last step, whatever ``every`` is."""
        if self.last_frame != sim.steps:
            self.frame(sim)

    def enter(self, sim: Stepper) -> None:
        """Add the rows of a completed step."""
        self.latest = self.observations.look(sim)
        for name, value in self.latest.items():
            self.observed[name].append(value)
        self.history.append(self._history(sim))
        self.bytes += 200 + sum(value.nbytes for value in self.latest.values())
        if sim.steps % self.every == 0:
            self.frame(sim)

    def frame(self, sim: Stepper) -> None:
        """Add a frame: the current state, and the interactions of the last step."""
        self.last_frame = sim.steps
        sim.scene.note_gaps()
        net = self._net(sim)
        self.index.append((sim.time, sim.steps, self._interaction_count, len(net)))
        self.positions.append(sim.state.positions.copy())
        self.velocities.append(np.array(sim.velocities_in_space))
        self.interactions.append(net)
        self._interaction_count += len(net)
        self.bytes += 2 * self.positions[-1].nbytes + net.nbytes

    def tables(self) -> dict[str, Any]:
        """The rows by the name of their table."""
        nothing = np.zeros(0, dtype=self.kind)
        return {
            "frames/index": np.array(self.index, dtype=INDEX),
            "frames/positions": self.positions,
            "frames/velocities": self.velocities,
            "interactions": np.concatenate(self.interactions or [nothing]),
            "history": np.array(self.history, dtype=history_type(len(self.laws))),
            **{OBSERVED + name: rows for name, rows in self.observed.items()},
        }

    def _history(self, sim: Stepper) -> tuple:
        report, energy = sim.report, sim.energy
        row: tuple[Any, ...] = (
            *(sim.steps, sim.time, report.iterations, report.residual, STATUS.index(report.status), report.interactions),
            *(report.seconds, report.step_seconds, report.slip, report.stretch, energy.made),
            *(energy.kinetic, energy.loads, energy.drives, energy.drag, energy.unbalanced),
            energy.defect,
        )
        if self.laws:
            work, stored = energy.interactions, energy.stored
            row += ([work.get(law, 0.0) for law in self.laws], [stored.get(law, 0.0) for law in self.laws])
        return row

    def _net(self, sim: Stepper) -> np.ndarray:
        view = sim.interactions
        net = np.zeros(len(view), dtype=self.kind)
        if not len(view):
            return net
        for code, law in enumerate(self.laws):
            net["law"][view.law == law] = code
        for name in ("candidate", "antagonist", "gap", "normal", "point", "impulse"):
            net[name] = getattr(view, name)
        if view.moment.shape[1]:
            net["moment"] = view.moment
        return net
