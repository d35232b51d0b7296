"""Reading of a run file as arrays."""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from copy import deepcopy
from dataclasses import fields, is_dataclass
from functools import cached_property
from typing import Any

import numpy as np

from lmgcpy.contact.lattice import Lattice
from lmgcpy.dynamics.cell import CellMotion
from lmgcpy.dynamics.changes import Change, Counts, from_rows, gaps_after, hidden_after
from lmgcpy.dynamics.checkpoint import Checkpoint
from lmgcpy.dynamics.interactions import InteractionView, detection_positions
from lmgcpy.errors import file_path, named_arguments, shown, whole
from lmgcpy.io.rows import Observed, column_names
from lmgcpy.io.run_file.commits import read_checkpoint, read_commit, read_tails
from lmgcpy.io.run_file.opening import open_to_read
from lmgcpy.io.run_file.tables import OBSERVED, DamagedRows, check_table, rows_of, sentences_of_damage, table_types
from lmgcpy.io.run_file.trees import check_about, check_digest, read_group, read_tree
from lmgcpy.scene.contactor import PlaneContactor, WallContactor
from lmgcpy.scene.description import lattice_of
from lmgcpy.solve.problems.report import SOLVED_CODES, STATUS
from lmgcpy.writing import dataframe

log = logging.getLogger("lmgcpy")

UNITS = {
    "time": "s",
    "seconds": "s",
    "step_seconds": "s",
    **dict.fromkeys(("made", "kinetic", "loads", "drives", "drag", "unbalanced", "defect"), "J"),
}
"""Units of the columns of the history."""


def _interactions_of(
    net: np.ndarray, laws: list[str], detected: np.ndarray, time_step: float, lattice: Lattice | None
) -> InteractionView:
    """Interactions from rows of the file; ``detected`` are the positions of the bodies at the detection [m], (n, d);
    ``lattice``: of a periodic cell, in which the antagonist is the nearest image."""
    candidate, antagonist = net["candidate"].astype(np.int64), net["antagonist"].astype(np.int64)
    from_candidate, from_antagonist = (net["point"] - detected[bodies] for bodies in (candidate, antagonist))
    if lattice is not None:
        from_antagonist = lattice.shortened(from_antagonist, lattice.edges(detected))
    return InteractionView(
        law=np.array(laws or [""])[net["law"]],
        candidate=candidate,
        antagonist=antagonist,
        gap=net["gap"],
        normal=net["normal"],
        point=net["point"],
        lever=np.stack([from_candidate, from_antagonist], axis=1),
        impulse=net["impulse"],
        force=net["impulse"] / time_step,
        moment=net["moment"] if "moment" in (net.dtype.names or ()) else np.zeros((len(net), 0)),
    )


class FileArray:
    """An array in the file. Indexing it, or passing it to numpy, reads the requested part."""

    def __init__(self, read: Callable[[Any], np.ndarray], shape: tuple[int, ...], dtype: np.dtype):
        self._read = read
        self.shape = shape
        self.dtype = dtype

    @property
    def ndim(self) -> int:
        """Number of axes."""
        return len(self.shape)

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, key: Any) -> Any:
        first, *rest = key if isinstance(key, tuple) else (key,)
        if isinstance(first, (int, np.integer)):
            if not -len(self) <= first < len(self):
                raise IndexError(f"There are {len(self)} entries, {first} is none of them.")
            first = int(first) % len(self)
        elif isinstance(first, slice):
            start, stop, stride = first.indices(len(self))
            first = slice(start, max(start, stop), stride) if stride > 0 else np.arange(start, stop, stride)
        else:
            first = np.arange(len(self))[first]
        if isinstance(first, np.ndarray):  # HDF5 cannot read rows in any order
            part = self._read(slice(0, len(self)))[first]
        else:
            part = self._read(first)
        return part[(*([] if np.ndim(first) == 0 and not isinstance(first, slice) else [slice(None)]), *rest)]

    def __iter__(self) -> Iterator[Any]:
        return (self[i] for i in range(len(self)))

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> np.ndarray:
        return np.asarray(self[:], dtype=dtype)

    def __repr__(self) -> str:
        return f"<{self.dtype} array of shape {self.shape}, in the file>"



def _parts(name: str, value: Any) -> Iterator[tuple[str, np.ndarray]]:
    """The numbers in a value by name; in a dictionary or object each part has its own."""
    if is_dataclass(value):
        value = {field.name: getattr(value, field.name) for field in fields(value)}
    elif hasattr(value, "_asdict"):
        value = value._asdict()
    if isinstance(value, Mapping):
        for key, part in value.items():
            yield from _parts(f"{name}.{key}" if name else str(key), part)
    elif isinstance(value, tuple) and any(np.ndim(part) for part in value):
        for k, part in enumerate(value):
            yield from _parts(f"{name}.{k}", part)
    elif value is not None:
        array = np.asarray(value)
        if array.dtype.kind in "biuf":
            yield name, array


@named_arguments
class Run:
    """A run file, even one that is being written; it has f frames, s steps, n bodies, d dimensions, L laws.

    It is a context manager. It shows the content of the file at the time of opening or of the last refresh.
    """

    def __init__(self, path: str | os.PathLike):
        self.path = file_path(path, "path")
        self._file: Any = None
        self.refresh()

    def refresh(self) -> Run:
        """Read the content of the file again; returns the run."""
        self.close()
        self._scene_is_sound = False
        self.__dict__.pop("_statements", None)
        self._file = open_to_read(self.path)
        try:
            with sentences_of_damage(self.path):
                self._about = read_group(self._file, "about")
                check_about(self._about, list(self._file.get(OBSERVED[:-1], ())))
                self._commit = read_commit(self._file)
                for name, kind in table_types(self._file, self.laws).items():
                    check_table(self._file, name, kind, self._commit.rows(name))
                self._tails = {} if self.closed else read_tails(self._file, self._commit)
                self.dimension = 2 if self._file["frames/velocities"].shape[2] == 3 else 3
                fields = self._file["interactions"].dtype.fields
                self.moments = fields["moment"][0].shape[0] if "moment" in fields else 0
        except BaseException:
            self.close()
            raise
        return self

    def close(self) -> None:
        """Close the file. Arrays that were read stay valid."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def __enter__(self) -> Run:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    # -------------------------------------------------------------------------------------------------------- frames

    def _table(self, name: str) -> Any:
        if self._file is None:
            raise ValueError(f"'{self.path}' was closed: open it again with lmgcpy.io.open_run.")
        return self._file[name]

    def _array(self, name: str, part: Any = ...) -> FileArray:
        table = self._table(name)
        if isinstance(part, str):
            kind = table.dtype[part]
            shape = (self._commit.rows(name), *kind.shape)
            return FileArray(lambda key: self._rows(name, key, part), shape, kind.base)
        shape = (self._commit.rows(name), *table.shape[1:])
        if part is ...:
            return FileArray(lambda key: self._rows(name, key), shape, table.dtype)
        shape = (shape[0], *np.broadcast_to(0.0, shape[1:])[part].shape)
        return FileArray(lambda key: self._rows(name, key)[(..., *part[1:])], shape, table.dtype)

    def _rows(self, name: str, key: Any, field: str | None = None) -> np.ndarray:
        """Rows of a growing table, by an index or a slice with both ends; ValueError names damaged frames or steps."""
        table, rows = self._table(name), self._commit.rows(name)
        with sentences_of_damage(self.path):
            try:
                return rows_of(table, key, rows, field=field, tail=self._tails.get(name))
            except DamagedRows as error:
                raise ValueError(
                    f"'{self.path}' is damaged: {self._named(name, error.spans)} of '{name}' cannot be read, as a checksum "
                    "is wrong there; the rest of the file can."
                ) from error

    def _named(self, name: str, spans: list[tuple[int, int]]) -> str:
        """The rows of a table in words, as frames or steps."""
        what = "frames" if name.startswith("frames/") else "steps"
        if name == "interactions":
            what, index = "frames", self._array("frames/index")[:]
            end = index["first"] + index["count"]
            frames = [np.flatnonzero((index["first"] <= last) & (end > first)) for first, last in spans]
            spans = [(int(those[0]), int(those[-1])) for those in frames if len(those)]
        return what + " " + ", ".join(f"{first} to {last}" if last > first else f"{first}" for first, last in spans)

    @property
    def frame_count(self) -> int:
        """Number of frames."""
        return self._commit.frames

    @property
    def times(self) -> np.ndarray:
        """Times of the frames [s], (f,)."""
        return self._array("frames/index", "time")[:]

    @property
    def steps(self) -> np.ndarray:
        """Number of steps made before each frame, (f,)."""
        return self._array("frames/index", "step")[:]

    @property
    def positions(self) -> FileArray:
        """Positions of the bodies [m], (f, n, d)."""
        return self._array("frames/positions", np.s_[:, : self.dimension])

    @property
    def velocities(self) -> FileArray:
        """Velocities of the bodies [m/s], (f, n, d)."""
        return self._array("frames/velocities", np.s_[:, : self.dimension])

    @property
    def rotations(self) -> FileArray:
        """Angles of rotation [rad], (f, n). In 3D quaternions (q_x, q_y, q_z, q_w), (f, n, 4); (f, n, 0) if no body keeps a
        rotation."""
        return self._array("frames/positions", np.s_[:, 2] if self.dimension == 2 else np.s_[:, 3:])

    @property
    def spins(self) -> FileArray:
        """Angular velocities [rad/s], (f, n), in 3D along the axes of space, (f, n, 3)."""
        return self._array("frames/velocities", np.s_[:, 2] if self.dimension == 2 else np.s_[:, 3:])

    def interactions(self, frame: int) -> InteractionView:
        """Links, and all contacts within alert, of the step that ended with the frame; a negative ``frame`` counts from
        the end."""
        index = self._array("frames/index")[frame]
        first, count = int(index["first"]), int(index["count"])
        theta, h = self.options["theta"], self.options["time_step"]
        with sentences_of_damage(self.path):
            if first < 0 or count < 0 or first + count > self._commit.interactions:
                raise ValueError(f"frame {frame} is said to have interactions {first} to {first + count - 1}")
            net = self._rows("interactions", slice(first, first + count))
            lattice = self._lattice
            cell = None if lattice is None else CellMotion.of(lattice, self.extent)
            detected = detection_positions(self.positions[frame], self.velocities[frame], theta, h, cell)
            for name, most in (("law", len(self.laws)), ("candidate", len(detected)), ("antagonist", len(detected))):
                if count and not (net[name].min() >= 0 and net[name].max() < most):
                    raise ValueError(f"an interaction of frame {frame} has a {name} that is not there")
            return _interactions_of(net, self.laws, detected, h, lattice)

    # ------------------------------------------------------------------------------------------------------- history

    @property
    def history(self) -> FileArray:
        """Rows of the steps, (s,): step, time, iterations, residual, status (code), interactions, seconds, slip, stretch,
        made and energies. Older files lack some columns."""
        return self._array("history")

    @property
    def status(self) -> np.ndarray:
        """Status of the solver at the end of each step, a word, (s,)."""
        codes = self._array("history", "status")[:]
        with sentences_of_damage(self.path):
            if ((codes < 0) | (codes >= len(STATUS))).any():
                raise ValueError("a status in 'history' is none that there is")
            return np.array(STATUS)[codes]

    @property
    def unconverged_steps(self) -> int:
        """Number of steps that the solver did not solve to its tolerance or to round-off."""
        return int((~np.isin(self._array("history", "status")[:], SOLVED_CODES)).sum())

    @property
    def energy(self) -> dict[str, Any]:
        """Energies at each step [J]: "kinetic", "loads", "drives", "drag", "unbalanced", "defect" (s,); "work" and "stored"
        by law.

        :class:`lmgcpy.dynamics.energy.Energy` defines them. Older files have no "drag" and no "unbalanced".
        """
        history = self.history[:]
        names = ("kinetic", "loads", "drives", "drag", "unbalanced", "defect")
        energy: dict[str, Any] = {name: history[name] for name in names if name in history.dtype.names}
        for name in ("work", "stored"):
            energy[name] = {law: history[name][:, i] for i, law in enumerate(self.laws)}
        return energy

    @property
    def observed(self) -> dict[str, FileArray]:
        """Values of the functions of ``observe`` after each step, by name, (s, ...) each."""
        return Observed({name: self._array(OBSERVED + name) for name in self._about.get("observed", ())})

    def to_dataframe(self) -> Any:
        """A pandas.DataFrame with a row for each step: the history, with names and units as in ``history.csv``, and the
        observed values.

        Raises ImportError with a sentence if pandas is missing.
        """
        return dataframe({**self.history_columns, **self.observed_columns})

    @property
    def history_columns(self) -> dict[str, np.ndarray]:
        """The history by name and unit, "kinetic [J]", (s,) each."""
        rows = self.history[:]
        names = rows.dtype.names or ()
        columns = {name: rows[name] for name in names if name not in ("work", "stored")}
        columns["status"] = np.array(STATUS)[columns["status"]]
        columns = {f"{name} [{UNITS[name]}]" if name in UNITS else name: values for name, values in columns.items()}
        for name in ("work", "stored"):
            if name in names:
                columns |= {f"{name}:{law} [J]": rows[name][:, k] for k, law in enumerate(self.laws)}
        return columns

    @property
    def observed_columns(self) -> dict[str, np.ndarray]:
        """The observed values, (s,) each, by the names and units that ``observe`` gave; a number in an array without a name
        has its index, "places[0,1]"."""
        names = self._about.get("columns", {})  # older files have none
        found = {}
        for name, column in self.observed.items():
            values = column[:].reshape(len(column), -1)
            for k, word in enumerate(names.get(name) or column_names(name, column.shape[1:], "")):
                found[word] = values[:, k]
        return found

    def series(
        self, measure: Callable[..., Any], *arguments: Any, frames: Iterable[int] | None = None, **options: Any
    ) -> dict[str, np.ndarray]:
        """A measure over time: ``measure(run, *arguments, frame=k, **options)`` of each frame k, or of ``frames``.

        The names are "frame", "time" [s], and "value" for a number or an array, or for a measure with several parts the
        names of these, "force" and "by_law.coulomb" for instance; arrays (f, ...) have a row a frame. Parts that are no
        numbers are left out. Raises ValueError if a part does not have the same shape in all frames, such as a number for
        each contact.

        ``run.series(lm.measure.reaction, "PLATEN")["force"][:, 2]`` is the vertical force on a platen over time.
        """
        if not callable(measure):
            raise TypeError(f"series takes a function such as lmgcpy.measure.stress, got {shown(measure)}.")
        numbers = range(self.frame_count) if frames is None else [whole(k, "frames", minimum=-(2**62)) for k in frames]
        count = self.frame_count
        rows = [k + count if k < 0 else k for k in numbers]
        columns: dict[str, list[np.ndarray]] = {}
        for k in rows:
            for name, value in _parts("", measure(self, *arguments, frame=k, **options)):
                columns.setdefault(name or "value", []).append(value)
        found: dict[str, np.ndarray] = {"frame": np.array(rows, dtype=np.int64), "time": self.times[rows]}
        for name, values in columns.items():
            if len(values) < len(rows) or len({value.shape for value in values}) > 1:
                raise ValueError(
                    f"'{name}' has not the same shape in all frames, so that it is no series: give series a function "
                    "of your own, f(run, frame=k), that makes a number of it."
                )
            found[name] = np.array(values)
        return found

    # --------------------------------------------------------------------------------------------------- description

    @property
    def scene(self) -> dict[str, Any]:
        """The scene as arrays and words: bodies, contactors, materials, visibility table, chains. A copy at each call."""
        self._table("scene")  # a closed file says so
        return deepcopy(self._description)

    @cached_property
    def _description(self) -> dict[str, Any]:
        """The scene, read once: no step changes it, and frames ask for it one by one."""
        with sentences_of_damage(self.path):
            return read_tree(self._sound_scene())

    @cached_property
    def _lattice(self) -> Lattice | None:
        """The periodic cell of the scene."""
        return lattice_of(self._description)

    def _sound_scene(self) -> Any:
        """The group of the scene; its digest is checked at the first call."""
        group = self._table("scene")
        if not self._scene_is_sound:
            check_digest(self._file, "scene")
            self._scene_is_sound = True
        return group

    @property
    def extent(self) -> np.ndarray:
        """Bounding radius of each body around its position [m], (n,); infinite for walls."""
        with sentences_of_damage(self.path):
            return self._sound_scene()["bodies/extent"][:].reshape(self._file["frames/positions"].shape[1])

    @property
    def wall_normals(self) -> dict[int, np.ndarray]:
        """Outward normals of the walls, (d,) each, by id of the body."""
        flat = (WallContactor.KIND, PlaneContactor.KIND)
        with sentences_of_damage(self.path):
            table = read_tree(self._sound_scene()["contactors"])
            kinds = zip(table["body"].tolist(), table["kind"].tolist(), table["shape"], strict=True)
            return {body: shape[: self.dimension] for body, kind, shape in kinds if table["kinds"][kind] in flat}

    @property
    def laws(self) -> list[str]:
        """Names of the laws."""
        return self._about["laws"]

    @property
    def options(self) -> dict[str, Any]:
        """Time step, theta, solver and its fields, number of steps between frames.

        In an older file without geometric stiffness it is off, so that the run continues without it.
        """
        return {"geometric_stiffness": False, **self._about["options"]}

    @property
    def notes(self) -> dict[str, Any]:
        """Notes that were recorded with the run."""
        return self._about.get("notes", {})

    @property
    def versions(self) -> dict[str, str]:
        """Versions of the software on which the numbers depend."""
        return self._about["versions"]

    @property
    def created(self) -> str:
        """Time at which the file was made."""
        return self._about["created"]

    @property
    def closed(self) -> bool:
        """Whether the writer ended normally."""
        return self._commit.closed

    def hidden(self, frame: int, *, in_step: bool = False) -> np.ndarray:
        """Whether a body was hidden after the step of a frame, or ``in_step``, before statements that followed it, (n,)
        bool."""
        bodies = self._description["bodies"]
        start = np.array(bodies.get("hidden", np.zeros(len(bodies["mass"]), dtype=bool)), dtype=bool)
        if not self._statements:
            return start
        return hidden_after(self.statements_before(frame) if in_step else self._statements, int(self.steps[frame]), start)

    def reference_gaps(self, frame: int) -> np.ndarray:
        """Reference gaps of the links of all chains at a frame [m], (l,)."""
        chains = self._description["chains"]
        gaps = np.split(np.asarray(chains["reference_gaps"], dtype=float), np.cumsum(chains["link_count"])[:-1])
        gaps = gaps if len(chains["link_count"]) else []
        return np.concatenate([np.zeros(0), *gaps_after(self._statements, int(self.steps[frame]), gaps)])

    def statements_before(self, frame: int) -> list[Change]:
        """Statements between the steps before the step of a frame."""
        step = int(self.steps[frame])
        return [change for change in self._statements if change.step < step]

    @cached_property
    def _statements(self) -> list[Change]:
        """Statements between the steps so far."""
        with sentences_of_damage(self.path):
            checkpoint, _ = read_checkpoint(self._file, self.laws)
            scene = self._description
            parameters = [len(law["parameters"]) for law in scene["laws"]]
            counts = Counts(
                bodies=len(checkpoint.positions),
                dimension=self.dimension,
                links=scene["chains"]["link_count"],
                seen_parameters=[parameters[row["law"]] for row in scene["visibility"]],
                link_parameters=[parameters[law] for law in scene["chains"]["law"]],
            )
            return from_rows(checkpoint.changes, counts)

    def checkpoint(self) -> Checkpoint:
        """The last checkpoint, from which the run can continue."""
        self._table("checkpoint")
        with sentences_of_damage(self.path):
            checkpoint, commit = read_checkpoint(self._file, self.laws)
        if self.closed and commit.sequence < self._commit.sequence:
            log.warning(
                "The last checkpoint of '%s' is damaged: that of step %d is taken, and later steps are made again.",
                *(self.path, checkpoint.steps),
            )
        return checkpoint

    def __repr__(self) -> str:
        if self._file is None:
            return f"<Run '{self.path}', closed>"
        bodies = self._file["frames/positions"].shape[1]
        return (
            f"<Run '{self.path}': {bodies} bodies, {self._commit.history} steps, {self.frame_count} frames"
            f"{'' if self.closed else ', not closed by its writer'}>"
        )


@named_arguments
def open_run(path: str | os.PathLike) -> Run:
    """Open a run file for reading, even one that is being written.

    Raises FileNotFoundError, PermissionError, IsADirectoryError, and ValueError if the file is no run file, damaged, or
    from a newer lmgcpy.
    """
    return Run(path)
