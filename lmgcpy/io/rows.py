"""Rows of the tables of :mod:`lmgcpy.io.run_file`, collected step by step, with the values of a user's functions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NoReturn

import numpy as np

from lmgcpy.dynamics.interactions import detection_positions
from lmgcpy.errors import closest, shown, whole
from lmgcpy.io.run_file.tables import INDEX, OBSERVED, history_type, interaction_type
from lmgcpy.solve.problems.report import STATUS

if TYPE_CHECKING:
    from lmgcpy.dynamics.stepper import Stepper

Function = Callable[[Any], Any]
Observe = Mapping[str, Function | tuple[Function, str | Sequence[str]]]
"""Functions of the simulation by name; each returns a number or an array of the same shape at every step. With the function
may come the unit of its values, ``(f, "N")``, or a name for each of them, ``(f, ["mean [N]", "greatest [N]"])``."""


def entries(of: str, axes: int, unit: str) -> list[str]:
    """Names of the entries of a tensor along the first ``axes`` axes: "fabric_xx [unit]", without brackets if there is no
    unit."""
    words, ending = "xyz"[:axes], f" [{unit}]" if unit else ""
    return [f"{of}_{a}{b}{ending}" for a in words for b in words]


def column_names(name: str, shape: Sequence[int], given: str | Sequence[str]) -> list[str]:
    """Names of the columns of an observation, one for each of its numbers: the given ones, or its name with the index, and
    with the given unit."""
    if not isinstance(given, str):
        return list(given)
    ending = f" [{given}]" if given else ""
    return [f"{name}[{','.join(map(str, index))}]{ending}" if index else name + ending for index in np.ndindex(*shape)]


class Observed(dict[str, Any]):
    """Observed values by name; LookupError with a sentence for an unknown name."""

    def __missing__(self, name: str) -> NoReturn:
        raise LookupError(f"Nothing was observed under the name {shown(name)}{closest(name, self)}")


class Observations:
    """Functions by name, and the type of the values of each, as a numpy type with its shape.

    ``types`` gives the types by name, from a file; without it :meth:`probe` finds them.
    """

    def __init__(self, functions: Observe, types: Mapping[str, np.dtype] | None = None):
        if not isinstance(functions, Mapping):
            raise TypeError(f"observe must be functions of the simulation by name, got {functions!r}.")
        self._functions: dict[str, Function] = {}
        self._given: dict[str, str | Sequence[str]] = {}
        for name, value in functions.items():
            function: Any = value
            given: Any = ""
            if isinstance(value, tuple) and len(value) == 2:
                function, given = value
            if not isinstance(name, str) or not name.isprintable() or name in ("", ".") or "/" in name:
                raise ValueError(f"observe: {name!r} cannot be a name; take a word such as 'reaction', without '/'.")
            if not callable(function):
                raise TypeError(f"observe['{name}'] must be a function of the simulation, got {function!r}.")
            words = [given] if isinstance(given, str) else given
            if not (isinstance(words, Iterable) and all(isinstance(word, str) and word.isprintable() for word in words)):
                raise TypeError(
                    f"observe['{name}'] may be a function and the unit of its values, (f, \"N\"), or a function and a name "
                    f"for each value, (f, [\"mean [N]\", \"greatest [N]\"]), got {shown(given)}."
                )
            self._functions[name] = function
            self._given[name] = given if isinstance(given, str) else list(given)
        self.types: dict[str, np.dtype] = dict(types or {})

    def probe(self, sim: Stepper) -> None:
        """Call every function once, before the first step, to find the type of its values.

        Raises ValueError with a sentence if a function fails, and TypeError if it returns no numbers.
        """
        for name, function in self._functions.items():
            try:
                value = np.asarray(function(sim))
            except Exception as error:
                raise ValueError(
                    f"observe['{name}'] fails before the first step, when lmgcpy asks for its shape: "
                    f"{type(error).__name__}: {error}. There may be no interactions yet; let it return NaN then."
                ) from error
            if value.dtype.kind not in "biuf" or not value.size:
                raise TypeError(
                    f"observe['{name}'] must return a number, or an array of numbers of the same shape at every step; "
                    f"before the first it returned {value.tolist()!r}."
                )
            self.types[name] = np.dtype((value.dtype, value.shape))
            given = self._given[name]
            if not isinstance(given, str) and len(given) != value.size:
                raise ValueError(
                    f"observe['{name}'] returns {value.size} numbers and has {len(given)} names for them: {shown(given)}. "
                    "Give one for each."
                )
        taken = [word for words in self.columns.values() for word in words]
        twice = next((word for word in taken if taken.count(word) > 1), None)
        if twice is not None:
            raise ValueError(f"observe names two columns '{twice}': give them different names.")

    @property
    def columns(self) -> dict[str, list[str]]:
        """Names of the columns of each observation, one for each of its numbers."""
        return {name: column_names(name, kind.shape, self._given[name]) for name, kind in self.types.items()}

    def look(self, sim: Stepper) -> dict[str, np.ndarray]:
        """The values now; ValueError if a shape or type differs from that before the first step."""
        row = {}
        for name, function in self._functions.items():
            value, kind = np.asarray(function(sim)), self.types[name]
            if value.shape != kind.shape or not np.can_cast(value.dtype, kind.base, "safe"):
                raise ValueError(
                    f"observe['{name}'] returned {value.dtype} of shape {value.shape} after step {sim.steps}, but its "
                    f"table is of {kind.base} of shape {kind.shape}: let it return the same type and shape at every step, "
                    "and before the first step (0.0, not 0)."
                )
            row[name] = value.astype(kind.base)
        return row

    def __iter__(self):
        return iter(self._functions)


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
        for name in ("candidate", "antagonist", "gap", "normal"):
            net[name] = getattr(view, name)
        # readers go back to the detection by the velocities of the frame and the scheme of the file, and divide by its time
        # step: so levers and forces are as in the step, also if velocities, time step or theta were set since
        step = sim.last_step
        assert step is not None
        detected, model = step.detected(sim.positions), step.model
        places = sim.positions[: len(detected)], sim.velocities[: len(detected)]
        read = detection_positions(*places, sim.theta, sim.time_step, model.cell)
        seen_from = np.where(np.isfinite(model.extent)[view.candidate], view.candidate, view.antagonist)
        net["point"] = view.point + (read - detected)[seen_from]
        same_force = sim.time_step / step.time_step
        net["impulse"] = same_force * view.impulse
        if view.moment.shape[1]:
            net["moment"] = same_force * view.moment
        return net
