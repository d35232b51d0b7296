"""Making the file of a new run, without frames, and making a file whose writer was killed anew."""

from __future__ import annotations

import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from lmgcpy.dynamics.checkpoint import Checkpoint
from lmgcpy.io.hdf5 import in_memory
from lmgcpy.io.run_file.commits import COMMIT, create_slot, read_checkpoint, read_tails, write_checkpoint, write_commit
from lmgcpy.io.run_file.opening import FORMAT, VERSION, open_to_read, writing
from lmgcpy.io.run_file.tables import (
    GROWING,
    INDEX,
    OBSERVED,
    growing_tables,
    history_type,
    interaction_type,
    rows_of,
    sentences_of_damage,
)
from lmgcpy.io.run_file.trees import read_group, write_group
from lmgcpy.writing import FileLock, replace_file
from lmgcpy.writing import check_target as check_file

LIBVER = ("v110", "v110")
"""The oldest HDF5 with single-writer-multiple-reader files."""
CHUNK = 1 << 16
"""Approximate size of a chunk in bytes."""


def check_target(path: str | os.PathLike, force: bool) -> None:
    """Raise unless a file may be made there: FileExistsError, FileNotFoundError, PermissionError, IsADirectoryError."""
    instead = f"give another name, force=True to replace it, or lmgcpy.resume('{path}') to go on with its run"
    check_file(path, force=force, name="record", instead=instead)
    if os.path.exists(path):
        FileLock(path).release()


def create(
    path: str | os.PathLike,
    about: Mapping[str, Any],
    description: Mapping[str, Any],
    checkpoint: Checkpoint,
    observed: Mapping[str, np.dtype],
) -> None:
    """Make the file of a run without frames, and close it; ``observed`` gives the types of the observations by name."""
    dimension, laws = int(description["dimension"]), len(about["laws"])

    def fill(file: Any) -> None:
        file.attrs["format"], file.attrs["format_version"] = FORMAT, VERSION
        write_group(file, "about", about)
        write_group(file, "scene", description)
        positions = np.dtype(("f8", checkpoint.positions.shape))
        velocities = np.dtype(("f8", checkpoint.velocities.shape))
        moments = checkpoint.memory.impulse.shape[1] - dimension
        kinds = INDEX, positions, velocities, interaction_type(dimension, moments), history_type(laws)
        types = dict(zip(GROWING, kinds, strict=True))
        types.update({OBSERVED + name: kind for name, kind in observed.items()})
        for name, kind in types.items():
            rows = max(1, min(1024, CHUNK // kind.itemsize))
            layout = {"maxshape": (None, *kind.shape), "chunks": (rows, *kind.shape), "fletcher32": True}
            file.create_dataset(name, (0, *kind.shape), kind.base, **layout)
        _create_slots(file, checkpoint, laws)

    Path(path).write_bytes(in_memory(fill, LIBVER))


def _create_slots(file: Any, checkpoint: Checkpoint, laws: int) -> None:
    """Make room for two checkpoints and two commits."""
    for slot in ("checkpoint/0", "checkpoint/1"):
        create_slot(file.create_group(slot), checkpoint, laws)
    file.create_dataset("tails", data=np.zeros((2, len(growing_tables(file)) + 2), dtype=np.int64))
    file.create_dataset("commits", data=np.zeros((2, len(COMMIT)), dtype=np.int64))


def mend(path: str | os.PathLike, laws: list[str]) -> FileLock:
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
        lock = FileLock(copied, path)
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
