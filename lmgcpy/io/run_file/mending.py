"""Mending a run file whose writer was killed."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path
from typing import Any

from lmgcpy.io.hdf5 import in_memory
from lmgcpy.io.run_file.checked_rows import rows_of, sentences_of_damage
from lmgcpy.io.run_file.checkpoints import read_checkpoint, write_checkpoint
from lmgcpy.io.run_file.commits import read_tails, write_commit
from lmgcpy.io.run_file.creation import LIBVER, create_slots
from lmgcpy.io.run_file.lock import FileLock
from lmgcpy.io.run_file.opening import open_to_read, writing
from lmgcpy.io.run_file.tables import growing_tables
from lmgcpy.io.run_file.trees import read_group, write_group
from lmgcpy.writing import replace_file


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
                create_slots(copy, checkpoint, len(laws))

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
