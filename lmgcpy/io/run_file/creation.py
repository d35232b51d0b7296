"""Making the file of a new run, without frames."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from lmgcpy.dynamics.checkpoint import Checkpoint
from lmgcpy.io.hdf5 import in_memory
from lmgcpy.io.run_file.checkpoints import create_slot
from lmgcpy.io.run_file.commits import COMMIT
from lmgcpy.io.run_file.lock import FileLock
from lmgcpy.io.run_file.opening import FORMAT, VERSION
from lmgcpy.io.run_file.tables import GROWING, INDEX, OBSERVED, growing_tables, history_type, interaction_type
from lmgcpy.io.run_file.trees import write_group
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
        create_slots(file, checkpoint, laws)

    Path(path).write_bytes(in_memory(fill, LIBVER))


def create_slots(file: Any, checkpoint: Checkpoint, laws: int) -> None:
    """Make room for two checkpoints and two commits."""
    for slot in ("checkpoint/0", "checkpoint/1"):
        create_slot(file.create_group(slot), checkpoint, laws)
    file.create_dataset("tails", data=np.zeros((2, len(growing_tables(file)) + 2), dtype=np.int64))
    file.create_dataset("commits", data=np.zeros((2, len(COMMIT)), dtype=np.int64))
