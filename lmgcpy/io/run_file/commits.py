"""Commits: how many rows of each table are valid."""

from __future__ import annotations

import logging
import zlib
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.io.run_file.checked_rows import tail_sum
from lmgcpy.io.run_file.tables import OBSERVED, growing_tables

log = logging.getLogger("lmgcpy")

COMMIT = ("sequence", "frames", "interactions", "history", "closed", "checksum")


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
