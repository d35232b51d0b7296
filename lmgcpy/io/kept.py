"""A run kept in memory: a recorder without a file, read like one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lmgcpy.io import run_format as form
from lmgcpy.io.observations import Observations, Observe, Observed
from lmgcpy.io.rows import Rows, detection_positions
from lmgcpy.io.run import RunInteractions

if TYPE_CHECKING:
    from lmgcpy.dynamics.stepper import Stepper


class KeptRun:
    """The history and the observations of every step, and a frame ``every`` so many steps.

    What it shows has the names, the shapes and the bits of what :class:`lmgcpy.io.Run` shows.
    """

    def __init__(self, *, every: int, observe: Observe):
        self._rows = Rows(every, Observations(observe))
        self._begun = False
        self._theta = self._time_step = 0.0

    # ----------------------------------------------------------------------------------------------------- a recorder

    @property
    def latest(self) -> dict[str, np.ndarray]:
        """What was observed after the last step, by name."""
        return self._rows.latest

    def start(self, sim: Stepper) -> None:
        """A run begins."""
        if self._begun:
            return
        self._begun = True
        self._theta, self._time_step = sim.theta, sim.time_step
        self._rows.observations.probe(sim)
        laws = [chain.law.NAME for chain in sim.model.chains] + [row.law.NAME for row in sim.model.rows]
        self._rows.begin(list(dict.fromkeys(laws)), sim.model.dimension)
        self._rows.frame(sim)

    def enter(self, sim: Stepper) -> None:
        """A step was made."""
        self._rows.enter(sim)

    def finish(self, sim: Stepper) -> None:
        """The run ends between two steps."""

    def abandon(self) -> None:
        """A step failed half-way."""

    def how_to_go_on(self) -> str:
        """A sentence for who was interrupted."""
        return "Interrupted; there is no file to go on from."

    # ------------------------------------------------------------------------------------------------------- like a run

    def __enter__(self) -> KeptRun:
        return self

    def __exit__(self, *exception: object) -> None:
        pass

    def __repr__(self) -> str:
        return f"<run kept in memory: {len(self._rows.history)} steps, {len(self._rows.index)} frames>"

    @property
    def history(self) -> np.ndarray:
        """A row a step, (s,)."""
        return np.array(self._rows.history, dtype=form.history_type(len(self._rows.laws)))

    @property
    def observed(self) -> dict[str, np.ndarray]:
        """Observations by name, (s, ...) each."""
        types = self._rows.observations.types
        return Observed({name: np.array(rows, dtype=types[name].base) for name, rows in self._rows.observed.items()})

    @property
    def steps(self) -> np.ndarray:
        """Steps made before the frames, (f,)."""
        return np.array([step for _, step, _, _ in self._rows.index])

    @property
    def positions(self) -> list[np.ndarray]:
        """Positions of the bodies [m], (n, d) a frame."""
        return [positions[:, : self._rows.dimension] for positions in self._rows.positions]

    def interactions(self, frame: int) -> RunInteractions:
        """Links and candidates within alert of the step that ended with the frame."""
        rows, d = self._rows, self._rows.dimension
        positions, velocities = rows.positions[frame][:, :d], rows.velocities[frame][:, :d]
        detected = detection_positions(positions, velocities, self._theta, self._time_step)
        return RunInteractions.of(rows.interactions[frame], rows.laws, detected, self._time_step)
