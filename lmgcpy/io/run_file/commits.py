"""Commits: how many rows of each table are valid; and checkpoints: the state from which a run goes on."""

from __future__ import annotations

import logging
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.contact.memory import Memory
from lmgcpy.dynamics.checkpoint import Checkpoint
from lmgcpy.dynamics.energy import Energy
from lmgcpy.io.run_file.tables import OBSERVED, growing_tables, tail_sum
from lmgcpy.io.run_file.trees import read_tree

log = logging.getLogger("lmgcpy")

COMMIT = ("sequence", "frames", "interactions", "history", "closed", "checksum")

ENERGIES = ("kinetic", "loads", "drives", "defect", "total_loads", "total_drives")
LAST_ENERGIES = ("time", "worst", "made", "by_hand", "total_by_hand")
"""Numbers that follow them; older files have fewer."""
BY_LAW = ("interactions", "stored", "total_interactions", "dissipated", "total_dissipated", "made_by_law")
COUNTS = ("sequence", "frames", "interactions", "history")
"""Fields of the commit that belongs to a checkpoint."""
REMEMBERED = ("identity", "impulse", "state")
"""Arrays with a row for each remembered interaction; ``state`` is empty unless a law of the scene keeps one."""
NUMBERS = (*COUNTS, "steps", "unconverged_steps", "memory", "listed", "rebuilds", "checksum")


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


def create_slot(group: Any, checkpoint: Checkpoint, laws: int) -> None:
    """Make room for a checkpoint."""
    for name in ("positions", "velocities", "left"):
        group.create_dataset(name, data=np.zeros_like(getattr(checkpoint, name)))
    group.create_dataset("listed_at", data=np.zeros_like(checkpoint.memory.listed_at))
    group.create_dataset("predicted", data=np.zeros_like(checkpoint.predicted))
    group.create_dataset("energy", data=np.zeros(len(ENERGIES) + len(LAST_ENERGIES)))
    group.create_dataset("energy_by_law", data=np.zeros((len(BY_LAW), laws)))
    group.create_dataset("reach", data=np.zeros(1))
    group.create_dataset("numbers", data=np.zeros(len(NUMBERS), dtype=np.int64))
    width = checkpoint.memory.impulse.shape[1]
    group.create_dataset("identity", (0, 3), "i8", maxshape=(None, 3), chunks=(1024, 3))
    group.create_dataset("impulse", (0, width), "f8", maxshape=(None, width), chunks=(1024, width))
    longest = checkpoint.memory.state.shape[1]
    growing = {"maxshape": (None, longest), "chunks": (1024, longest)} if longest else {}
    group.create_dataset("state", (0, longest), "f8", **growing)
    group.create_dataset("changes", (0, 5), "f8", maxshape=(None, 5), chunks=(64, 5))


def write_checkpoint(file: Any, checkpoint: Checkpoint, commit: Commit, laws: list[str]) -> None:
    """Write a checkpoint over the older of the two."""
    group = file[f"checkpoint/{commit.sequence % 2}"]
    arrays = _arrays(checkpoint, commit, laws)
    # older files have no room for the last energies and velocities, and none for predicted gaps of links or contacts
    arrays["state"] = arrays["state"][:, : group["state"].shape[1]]
    for name in ("energy", "energy_by_law"):
        arrays[name] = arrays[name][: len(group[name])]
    arrays = {name: array for name, array in arrays.items() if name in group}
    arrays["numbers"][-1] = _checksum(arrays)
    if "changes" in group:
        group["changes"].resize(len(checkpoint.changes), axis=0)
    elif len(checkpoint.changes):
        raise RuntimeError("a file of lmgcpy 0.1 cannot keep statements between steps: record into another one")
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
        "left": checkpoint.left,
        "listed_at": memory.listed_at,
        "predicted": checkpoint.predicted,
        "identity": memory.identity,
        "impulse": memory.impulse,
        "state": memory.state,
        "energy": np.array(
            [*values, checkpoint.time, checkpoint.worst_residual, energy.made, energy.by_hand, energy.total_by_hand]
        ),
        "energy_by_law": np.array(by_law, dtype=float).reshape(len(BY_LAW), len(laws)),
        "reach": np.array([memory.reach]),
        "changes": checkpoint.changes,
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
    options = read_tree(file["about"])["options"]
    for slot in ("0", "1"):
        group = file["checkpoint"][slot]
        arrays = {name: np.asarray(item) for name, item in group.items()}
        numbers = dict(zip(NUMBERS, arrays["numbers"].tolist(), strict=True))
        for name in REMEMBERED:
            arrays[name] = arrays[name][: max(0, numbers["memory"])]
        commit = Commit(*(numbers[name] for name in COUNTS))
        whole = commit.sequence > 0 and _checksum(arrays) == numbers["checksum"]
        if whole and (best is None or commit.sequence > best[1].sequence):
            best = _checkpoint(arrays, numbers, laws, options), commit
    if best is None:
        raise RuntimeError("it has no complete checkpoint to go on from")
    return best


def _checkpoint(
    arrays: Mapping[str, np.ndarray], numbers: Mapping[str, int], laws: list[str], options: Mapping[str, Any]
) -> Checkpoint:
    values = dict(zip((*ENERGIES, *LAST_ENERGIES), arrays["energy"].tolist(), strict=False))
    time, worst = values.pop("time"), values.pop("worst")
    by_law = {
        name: {law: float(value) for law, value in zip(laws, row, strict=True) if not np.isnan(value)}
        for name, row in zip(BY_LAW, arrays["energy_by_law"], strict=False)  # older files have fewer
    }
    return Checkpoint(
        positions=arrays["positions"],
        velocities=arrays["velocities"],
        left=arrays.get("left", arrays["velocities"]),
        time=time,
        time_step=options["time_step"],
        theta=options["theta"],
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
        changes=arrays.get("changes", np.zeros((0, 5))),
    )
