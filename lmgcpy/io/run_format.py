"""The run file: its content, how it is opened, and how it survives the kill of its writer.

A run file is one HDF5 file (readable from HDF5 1.10 on). Nothing in it is ever executed:

    about, versions, options        JSON texts
    scene/...                       the description (:mod:`lmgcpy.scene.description`), arrays and JSON texts
    frames/index                    one row a frame: time, step, first interaction, number of interactions
    frames/positions, velocities    (frames, n, 3): x, y, angle; in 3D x, y, z, and velocities with three more spins
    interactions                    interactions of all frames, one after the other
    history                         one row a step: solver and energy
    observed/...                    one row a step: values of the user's functions
    checkpoint/0, checkpoint/1      the state from which the run continues, written in turn
    commits                         two rows, written in turn: the number of valid rows of each table
    tails                           two rows, written in turn: sums of the valid rows in the last chunk of each table

HDF5's single-writer-multiple-reader mode keeps the structure valid at any time: the operating system has the writes of a
killed process in their order. Written rows count as soon as a later row of ``commits`` is complete, which its checksum
shows; the same holds for checkpoints. A power cut can still damage the file, because nothing is forced to the disk.
"""

from __future__ import annotations

import errno
import logging
import os
import zlib
from collections.abc import Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lmgcpy.contact.memory import Memory
from lmgcpy.dynamics.checkpoint import Checkpoint
from lmgcpy.dynamics.energy import Energy
from lmgcpy.errors import shown
from lmgcpy.io.hdf5 import cut_off, data_sets, h5py, in_memory
from lmgcpy.io.run_trust import DamagedRows, check_structure, read_group, rows_of, tail_sum, write_group
from lmgcpy.io.unclosed_file import UnclosedFile, is_unclosed
from lmgcpy.io.untrusted import regular_file
from lmgcpy.writing import check_target as check_file
from lmgcpy.writing import replace_file

log = logging.getLogger("lmgcpy")

FORMAT = "lmgcpy run"
VERSION = 1
LIBVER = ("v110", "v110")
"""The oldest HDF5 with single-writer-multiple-reader files."""
CHUNK = 1 << 16
"""Approximate size of a chunk in bytes."""
WRONG = (OSError, RuntimeError, LookupError, ValueError, TypeError, AttributeError, OverflowError, MemoryError)
"""Exceptions that reading of damaged data may raise."""
GROWING = ("frames/index", "frames/positions", "frames/velocities", "interactions", "history")
"""Growing tables of every file; each observation adds one."""
OBSERVED = "observed/"
COMMIT = ("sequence", "frames", "interactions", "history", "closed", "checksum")

INDEX = np.dtype([("time", "f8"), ("step", "i8"), ("first", "i8"), ("count", "i8")])


def interaction_type(dimension: int) -> np.dtype:
    """Type of a row of ``interactions``: ids, code of the law, gap [m], normal, contact point [m], impulse [N s].

    The impulse is in the local frame.
    """
    vector = ("f8", (dimension,))
    return np.dtype(
        [
            ("candidate", "i4"),
            ("antagonist", "i4"),
            ("law", "i2"),
            ("gap", "f8"),
            ("normal", *vector),
            ("point", *vector),
            ("impulse", *vector),
        ]
    )


def history_type(law_count: int) -> np.dtype:
    """Type of a row of ``history``; energies in [J], ``work`` and ``stored`` by law."""
    fields: list[Any] = [("step", "i8"), ("time", "f8"), ("iterations", "i4"), ("residual", "f8"), ("status", "i1")]
    fields += [("interactions", "i4"), ("seconds", "f8"), ("step_seconds", "f8"), ("slip", "f8")]
    fields += [("stretch", "f8"), ("made", "f8")]
    fields += [(name, "f8") for name in ("kinetic", "loads", "drives", "defect")]
    return np.dtype(fields + [(name, "f8", (law_count,)) for name in ("work", "stored") if law_count])


def growing_tables(file: Any) -> list[str]:
    """Names of the tables that grow with the run."""
    return [*GROWING, *(OBSERVED + name for name in file.get(OBSERVED[:-1], ()))]


def table_types(file: Any, laws: list[str]) -> dict[str, np.dtype]:
    """Type and shape of the rows of each growing table. The number of velocity components gives the dimension."""
    bodies, components = file["frames/velocities"].shape[1:]
    if components not in (3, 6):
        raise ValueError(f"'frames/velocities' has {components} components, not 3 or 6")
    vectors = np.dtype(("f8", (bodies, 3))), np.dtype(("f8", (bodies, components)))
    kinds = INDEX, *vectors, interaction_type(2 if components == 3 else 3), history_type(len(laws))
    types = dict(zip(GROWING, kinds, strict=True))
    for name in growing_tables(file):
        if name not in types:
            kind = np.dtype((file[name].dtype, file[name].shape[1:]))
            if kind.base.kind not in "biuf":
                raise ValueError(f"'{name}' holds no numbers")
            types[name] = kind
    return types


# ----------------------------------------------------------------------------------------------------------- opening


def open_to_read(path: str | os.PathLike) -> Any:
    """The HDF5 file of a run, even one that is being written or whose writer was killed.

    Raises FileNotFoundError, IsADirectoryError, PermissionError or ValueError with a sentence.
    """
    path = regular_file(path, "a run file")
    if os.path.getsize(path) == 0:
        raise ValueError(f"'{path}' is empty: no lmgcpy run.")
    with open(path, "rb") as raw:
        head = raw.read(48)
    if head[:8] != b"\x89HDF\r\n\x1a\n":
        raise ValueError(f"'{path}' is no HDF5 file, hence no lmgcpy run.")
    # HDF5's shared mode does not check the end of the file
    closed = len(head) == 48 and head[8] in (2, 3) and head[11] == 0
    if len(head) < 48 or (closed and os.path.getsize(path) < int.from_bytes(head[28:36], "little")):
        raise ValueError(f"'{path}' is truncated: its end is missing. Take a complete copy.")
    try:
        if closed:
            _visit_chunks(path)
        file = h5py().File(UnclosedFile(path), "r") if is_unclosed(path, head) else _open_shared(path)
    except (OSError, RuntimeError, ValueError, KeyError) as error:
        raise ValueError(f"'{path}' is truncated or damaged: HDF5 cannot open it ({error}).") from error
    try:
        _check_format(path, file)
        with sentences_of_damage(path):
            check_structure(file)
    except BaseException:
        file.close()
        raise
    return file


def _visit_chunks(path: str | os.PathLike) -> None:
    """Read the index of all chunks. Damage there raises an error, while the shared mode would try again without end."""

    def look(name: str, item: Any) -> None:
        if getattr(item, "chunks", None):
            item.id.get_num_chunks()

    with h5py().File(path, "r", locking=False) as file:
        file.visititems(look)


def _open_shared(path: str | os.PathLike) -> Any:
    try:
        return h5py().File(path, "r", swmr=True, locking=False)
    except (OSError, ValueError):
        return h5py().File(path, "r", locking=False)  # files of other programs may not support the shared mode


def _check_format(path: str | os.PathLike, file: Any) -> None:
    with sentences_of_damage(path):
        written_by, version = file.attrs.get("format"), file.attrs.get("format_version")
    if not isinstance(written_by, str) or written_by != FORMAT or version is None:
        raise ValueError(f"'{path}' is an HDF5 file, but no lmgcpy run.")
    if not isinstance(version, (int, np.integer)) or version < 1:
        raise ValueError(
            f"'{path}' is of format version {shown(version)}, older than what lmgcpy reads (from 1 on): make the run anew."
        )
    if version > VERSION:
        raise ValueError(
            f"'{path}' is of format version {int(version)}; this lmgcpy reads up to {VERSION}: install a newer lmgcpy."
        )


@contextmanager
def sentences_of_damage(path: str | os.PathLike):
    """Turn the errors of HDF5, numpy and the checks on a damaged file into a ValueError with a sentence."""
    try:
        yield
    except DamagedRows as error:
        rows = ", ".join(f"{first} to {last}" for first, last in error.spans)
        raise ValueError(f"'{path}' is damaged: rows {rows} of a table cannot be read.") from error
    except WRONG as error:
        what = str(error.args[0] if error.args else type(error).__name__)
        if what.startswith(f"'{path}'"):
            raise
        raise ValueError(f"'{path}' is truncated or damaged: {what.rstrip('.')}.") from error


def open_to_append(path: str | os.PathLike) -> Any:
    """The file in writing mode, marked as shared at once; OSError if its last writer did not close it."""
    h5 = h5py()
    access = h5.h5p.create(h5.h5p.FILE_ACCESS)
    access.set_libver_bounds(h5.h5f.LIBVER_V110, h5.h5f.LIBVER_V110)
    access.set_file_locking(False, True)
    handle = h5.h5f.open(os.fsencode(path), h5.h5f.ACC_RDWR | h5.h5f.ACC_SWMR_WRITE, fapl=access)
    return h5.File(handle)


@contextmanager
def writing(path: str | os.PathLike):
    """The file in writing mode, closed at the end; if a write fails, the file stays unchanged."""
    file = open_to_append(path)
    held = data_sets(file)
    try:
        yield file
        file.flush()
    except BaseException:
        cut_off(file)
        raise
    finally:
        held.clear()
        file.close()


class Lock:
    """A lock that tells other writers that a file is being written. The system releases it when the process ends.

    Readers are not locked out.
    """

    def __init__(self, path: str | os.PathLike, name: str | os.PathLike | None = None):
        self._handle: int | None = None
        try:
            import fcntl
        except ImportError:
            return  # this system has no such locks
        self._handle = os.open(path, os.O_RDWR)
        try:
            fcntl.flock(self._handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
            fcntl.flock(self._handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
        except OSError as error:
            self.release()
            busy = BlockingIOError(
                f"The file '{name or path}' is being written by another run: wait for its end, or give another file."
            )
            busy.errno = errno.EAGAIN
            raise busy from error

    def release(self) -> None:
        """Release the lock, so that others can write."""
        if self._handle is not None:
            os.close(self._handle)
            self._handle = None


def is_being_written(path: str | os.PathLike) -> bool:
    """Whether a running process is writing the file."""
    try:
        Lock(path).release()
    except BlockingIOError:
        return True
    except OSError:
        return False  # nobody writes a read-only file
    return False


# ---------------------------------------------------------------------------------------------------------- creating


def check_target(path: str | os.PathLike, force: bool) -> None:
    """Raise unless a file may be made there: FileExistsError, FileNotFoundError, PermissionError, IsADirectoryError."""
    instead = f"give another name, force=True to replace it, or lmgcpy.resume('{path}') to go on with its run"
    check_file(path, force=force, name="record", instead=instead)
    if os.path.exists(path):
        Lock(path).release()


def create(
    path: str | os.PathLike,
    about: Mapping[str, Any],
    description: Mapping[str, Any],
    checkpoint: Checkpoint,
    observed: Mapping[str, np.dtype],
) -> None:
    """Make the file of a run without frames, and close it; ``observed`` gives the types of the observations by name."""
    dimension, bodies, laws = int(description["dimension"]), len(checkpoint.positions), len(about["laws"])

    def fill(file: Any) -> None:
        file.attrs["format"], file.attrs["format_version"] = FORMAT, VERSION
        write_group(file, "about", about)
        write_group(file, "scene", description)
        positions = np.dtype(("f8", (bodies, 3)))
        velocities = np.dtype(("f8", checkpoint.velocities.shape))
        kinds = INDEX, positions, velocities, interaction_type(dimension), history_type(laws)
        types = dict(zip(GROWING, kinds, strict=True))
        types.update({OBSERVED + name: kind for name, kind in observed.items()})
        for name, kind in types.items():
            rows = max(1, min(1024, CHUNK // kind.itemsize))
            layout = {"maxshape": (None, *kind.shape), "chunks": (rows, *kind.shape), "fletcher32": True}
            file.create_dataset(name, (0, *kind.shape), kind.base, **layout)
        _create_slots(file, checkpoint, laws)

    Path(path).write_bytes(in_memory(fill, LIBVER))


def _create_slots(file: Any, checkpoint: Checkpoint, laws: int) -> None:
    for slot in ("checkpoint/0", "checkpoint/1"):
        _create_slot(file.create_group(slot), checkpoint, laws)
    file.create_dataset("tails", data=np.zeros((2, len(growing_tables(file)) + 2), dtype=np.int64))
    file.create_dataset("commits", data=np.zeros((2, len(COMMIT)), dtype=np.int64))


def _create_slot(group: Any, checkpoint: Checkpoint, laws: int) -> None:
    for name in ("positions", "velocities"):
        group.create_dataset(name, data=np.zeros_like(getattr(checkpoint, name)))
    group.create_dataset("listed_at", data=np.zeros_like(checkpoint.memory.listed_at))
    group.create_dataset("predicted", data=np.zeros_like(checkpoint.predicted))
    group.create_dataset("energy", data=np.zeros(len(ENERGIES) + 3))
    group.create_dataset("energy_by_law", data=np.zeros((len(BY_LAW), laws)))
    group.create_dataset("reach", data=np.zeros(1))
    group.create_dataset("numbers", data=np.zeros(len(NUMBERS), dtype=np.int64))
    width = checkpoint.memory.impulse.shape[1]
    group.create_dataset("identity", (0, 3), "i8", maxshape=(None, 3), chunks=(1024, 3))
    group.create_dataset("impulse", (0, width), "f8", maxshape=(None, width), chunks=(1024, width))
    longest = checkpoint.memory.state.shape[1]
    growing = {"maxshape": (None, longest), "chunks": (1024, longest)} if longest else {}
    group.create_dataset("state", (0, longest), "f8", **growing)


# ----------------------------------------------------------------------------------------------------------- commits


@dataclass(frozen=True)
class Commit:
    """Numbers of valid rows of the growing tables; ``closed``: the writer ended normally, at the checkpoint."""

    sequence: int = 0
    frames: int = 0
    interactions: int = 0
    history: int = 0
    closed: bool = False

    def rows(self, table: str) -> int:
        """Number of valid rows of a growing table."""
        return self.history if table.startswith(OBSERVED) else getattr(self, table.split("/")[0])


def write_commit(file: Any, commit: Commit) -> None:
    """Write a commit over the older of the two, after the sums of the chunks that will be rewritten later."""
    if "tails" in file:  # older files have none
        sums = [tail_sum(file[name], commit.rows(name)) for name in growing_tables(file)]
        numbers = np.array([commit.sequence, *sums, 0], dtype=np.int64)
        numbers[-1] = zlib.crc32(numbers[:-1].tobytes())
        file["tails"][commit.sequence % 2] = numbers
        file["tails"].flush()
    row = np.array([*(int(getattr(commit, name)) for name in COMMIT[:-1]), 0], dtype=np.int64)
    row[-1] = zlib.crc32(row[:-1].tobytes())
    file["commits"][commit.sequence % 2] = row


def read_commit(file: Any) -> Commit:
    """The last complete commit; RuntimeError if there is none."""
    rows = np.asarray(file["commits"])
    if rows.shape != (2, len(COMMIT)) or rows.dtype != np.int64:
        raise ValueError(f"'commits' is of type {rows.dtype} and shape {rows.shape}")
    whole = [zlib.crc32(row[:-1].tobytes()) == row[-1] and row[0] > 0 for row in rows]
    if rows[np.logical_not(whole)].any():
        log.warning("The last commit of '%s' is damaged: the one before is taken.", file.filename)
    rows = rows[whole]
    if not len(rows):
        raise RuntimeError("it has no complete commit yet")
    numbers = rows[np.argmax(rows[:, 0])].tolist()
    return Commit(numbers[0], numbers[1], numbers[2], numbers[3], bool(numbers[4]))


def read_tails(file: Any, commit: Commit) -> dict[str, int]:
    """Sums of the valid rows in the last chunk of each growing table, by name; empty if the file has none."""
    if "tails" not in file:
        return {}
    names, numbers = growing_tables(file), np.asarray(file["tails"])[commit.sequence % 2].tolist()
    whole = len(numbers) == len(names) + 2 and zlib.crc32(np.array(numbers[:-1], dtype=np.int64).tobytes()) == numbers[-1]
    return dict(zip(names, numbers[1:-1], strict=True)) if whole and numbers[0] == commit.sequence else {}


# ------------------------------------------------------------------------------------------------------- checkpoints

ENERGIES = ("kinetic", "loads", "drives", "defect", "total_loads", "total_drives")
BY_LAW = ("interactions", "stored", "total_interactions")
COUNTS = ("sequence", "frames", "interactions", "history")
"""Fields of the commit that belongs to a checkpoint."""
REMEMBERED = ("identity", "impulse", "state")
"""Arrays with a row for each remembered interaction; ``state`` is empty unless a law of the scene keeps one."""
NUMBERS = (*COUNTS, "steps", "unconverged_steps", "memory", "listed", "rebuilds", "checksum")


def write_checkpoint(file: Any, checkpoint: Checkpoint, commit: Commit, laws: list[str]) -> None:
    """Write a checkpoint over the older of the two."""
    group = file[f"checkpoint/{commit.sequence % 2}"]
    arrays = _arrays(checkpoint, commit, laws)
    # older files have no column for the last energy, and no predicted gaps
    arrays["energy"] = arrays["energy"][: len(group["energy"])]
    arrays = {name: array for name, array in arrays.items() if name in group}
    arrays["numbers"][-1] = _checksum(arrays)
    for name, array in arrays.items():
        item = group[name]
        if not array.size:
            continue
        if name in REMEMBERED and len(item) < len(array):
            item.resize(len(array) + len(array) // 4, axis=0)
        item[: len(array)] = array


def _arrays(checkpoint: Checkpoint, commit: Commit, laws: list[str]) -> dict[str, np.ndarray]:
    energy, memory = checkpoint.energy, checkpoint.memory
    counts = [getattr(commit, name) for name in COUNTS]
    numbers = *counts, checkpoint.steps, checkpoint.unconverged_steps, len(memory.identity), memory.listed, memory.rebuilds
    values = [getattr(energy, name) for name in ENERGIES]
    by_law = [[getattr(energy, name).get(law, np.nan) for law in laws] for name in BY_LAW]
    return {
        "positions": checkpoint.positions,
        "velocities": checkpoint.velocities,
        "listed_at": memory.listed_at,
        "predicted": checkpoint.predicted,
        "identity": memory.identity,
        "impulse": memory.impulse,
        "state": memory.state,
        "energy": np.array([*values, checkpoint.time, checkpoint.worst_residual, energy.made]),
        "energy_by_law": np.array(by_law, dtype=float).reshape(len(BY_LAW), len(laws)),
        "reach": np.array([memory.reach]),
        "numbers": np.array([*(int(n) for n in numbers), 0], dtype=np.int64),
    }


def _checksum(arrays: Mapping[str, np.ndarray]) -> int:
    total = 0
    for name in sorted(arrays):
        array = arrays[name][:-1] if name == "numbers" else arrays[name]
        total = zlib.crc32(np.ascontiguousarray(array).tobytes(), total)
    return total


def read_checkpoint(file: Any, laws: list[str]) -> tuple[Checkpoint, Commit]:
    """The last complete checkpoint and its commit; RuntimeError if there is none."""
    best: tuple[Checkpoint, Commit] | None = None
    for slot in ("0", "1"):
        group = file["checkpoint"][slot]
        arrays = {name: np.asarray(item) for name, item in group.items()}
        numbers = dict(zip(NUMBERS, arrays["numbers"].tolist(), strict=True))
        for name in REMEMBERED:
            arrays[name] = arrays[name][: max(0, numbers["memory"])]
        commit = Commit(*(numbers[name] for name in COUNTS))
        whole = commit.sequence > 0 and _checksum(arrays) == numbers["checksum"]
        if whole and (best is None or commit.sequence > best[1].sequence):
            best = _checkpoint(arrays, numbers, laws), commit
    if best is None:
        raise RuntimeError("it has no complete checkpoint to go on from")
    return best


def _checkpoint(arrays: Mapping[str, np.ndarray], numbers: Mapping[str, int], laws: list[str]) -> Checkpoint:
    values = dict(zip((*ENERGIES, "time", "worst", "made"), arrays["energy"].tolist(), strict=False))
    time, worst = values.pop("time"), values.pop("worst")
    by_law = {
        name: {law: float(value) for law, value in zip(laws, row, strict=True) if not np.isnan(value)}
        for name, row in zip(BY_LAW, arrays["energy_by_law"], strict=True)
    }
    return Checkpoint(
        positions=arrays["positions"],
        velocities=arrays["velocities"],
        time=time,
        steps=numbers["steps"],
        unconverged_steps=numbers["unconverged_steps"],
        worst_residual=worst,
        energy=Energy(**values, **by_law),  # type: ignore[arg-type]
        memory=Memory(
            identity=arrays["identity"],
            impulse=arrays["impulse"],
            state=arrays["state"].reshape(len(arrays["identity"]), arrays["state"].shape[1]),
            listed=bool(numbers["listed"]),
            listed_at=arrays["listed_at"],
            reach=float(arrays["reach"][0]),
            rebuilds=numbers["rebuilds"],
        ),
        predicted=arrays.get("predicted", np.zeros(0)),
    )


# ---------------------------------------------------------------------------------------------------------- mending


def mend(path: str | os.PathLike, laws: list[str]) -> Lock:
    """Replace a file whose writer was killed by a copy that ends at the last checkpoint and can be written again.

    The file is replaced only when the copy is complete. Returns the lock on the new file.
    """
    copied = f"{os.fspath(path)}.mending"
    try:
        with open_to_read(path) as file:
            with sentences_of_damage(path):
                checkpoint, commit = read_checkpoint(file, laws)
                trees = {name: read_group(file, name) for name in ("about", "scene")}
                marks = dict(file.attrs.items())

            def begin(copy: Any) -> None:
                for name, value in marks.items():
                    copy.attrs[name] = value
                for name, tree in trees.items():
                    write_group(copy, name, tree)
                for name in growing_tables(file):
                    table = file[name]
                    copy.create_dataset(
                        name,
                        (0, *table.shape[1:]),
                        table.dtype,
                        maxshape=table.maxshape,
                        chunks=table.chunks,
                        fletcher32=True,
                    )
                _create_slots(copy, checkpoint, len(laws))

            Path(copied).write_bytes(in_memory(begin, LIBVER))
            with writing(copied) as copy:
                sums = read_tails(file, commit)
                for name in growing_tables(file):
                    _copy_rows(path, file[name], copy[name], commit.rows(name), sums.get(name))
                write_checkpoint(copy, checkpoint, commit, laws)
                write_commit(copy, commit)
        lock = Lock(copied, path)
        replace_file(copied, path)
    except BaseException:
        with suppress(OSError):
            os.remove(copied)
        raise
    return lock


def _copy_rows(path: str | os.PathLike, source: Any, target: Any, rows: int, tail: int | None) -> None:
    target.resize(rows, axis=0)
    block = 64 * source.chunks[0]
    for first in range(0, rows, block):
        part = slice(first, min(first + block, rows))
        with sentences_of_damage(path):
            values = rows_of(source, part, rows, field=None, tail=tail)
        target[part] = values
