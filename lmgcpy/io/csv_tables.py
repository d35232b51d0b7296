"""Export of a run as CSV tables."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from lmgcpy.errors import named_arguments, shown
from lmgcpy.io.run import Run
from lmgcpy.writing import make_folder, write_table

BODY = {
    2: ("x [m]", "y [m]", "angle [rad]", "v_x [m/s]", "v_y [m/s]", "spin [rad/s]"),
    3: (
        *("x [m]", "y [m]", "z [m]", "v_x [m/s]", "v_y [m/s]", "v_z [m/s]"),
        *("spin_x [rad/s]", "spin_y [rad/s]", "spin_z [rad/s]"),
    ),
}
"""Columns of the table of bodies, by dimension."""
ROTATION = ("q_x", "q_y", "q_z", "q_w")
"""Columns after the position if bodies keep a rotation in space."""
@named_arguments
def export_csv(run: Run, folder: str | os.PathLike, *, force: bool = False) -> list[Path]:
    """Write ``bodies.csv``, ``interactions.csv`` and ``history.csv`` into a folder; returns their paths.

    A run with observations gives ``observed.csv`` too. Raises FileExistsError if the folder is not empty, unless ``force``.
    """
    if not isinstance(run, Run):
        raise TypeError(f"export_csv takes a run, which lmgcpy.io.open_run(path) opens, got {shown(run)}.")
    target = folder_for(folder, force)
    written = [
        _write(target / "bodies.csv", ("frame", "step", "time [s]", "body", *_body_columns(run)), _bodies(run)),
        _write(target / "interactions.csv", interaction_columns(run.dimension), _net(run)),
        _write_columns(target / "history.csv", run.history_columns),
    ]
    if run.observed:
        rows = run.history[:]
        about = {"step": rows["step"], "time [s]": rows["time"]}
        written.append(_write_columns(target / "observed.csv", {**about, **run.observed_columns}))
    return written


def folder_for(folder: str | os.PathLike, force: bool) -> Path:
    """The folder, made if it does not exist; FileExistsError if it is not empty, unless ``force``."""
    target = make_folder(folder)
    if any(target.iterdir()) and not force:
        raise FileExistsError(f"The folder '{folder}' is not empty: give another, or force (--force) to write there.")
    return target


def interaction_columns(dimension: int) -> tuple[str, ...]:
    """Names of the columns of the table of interactions."""
    axes, local_axes = "xyz"[:dimension], "nts"[:dimension]
    named = [f"n_{k}" for k in axes] + [f"{k} [m]" for k in axes]
    named += [f"impulse_{k} [N s]" for k in local_axes] + [f"force_{k} [N]" for k in local_axes]
    return ("frame", "step", "time [s]", "law", "candidate", "antagonist", "gap [m]", *named)


def _write(path: Path, head: tuple[str, ...], rows: Iterable[Iterable[Any]]) -> Path:
    write_table(path, head, rows)
    return path


def _write_columns(path: Path, columns: dict[str, np.ndarray]) -> Path:
    return _write(path, tuple(columns), zip(*(column.tolist() for column in columns.values()), strict=True))


def _body_columns(run: Run) -> tuple[str, ...]:
    columns = BODY[run.dimension]
    return (*columns[:3], *ROTATION, *columns[3:]) if run.dimension == 3 and run.rotations.shape[2] else columns


def _bodies(run: Run) -> Iterable[list[Any]]:
    for frame, (step, time) in enumerate(zip(run.steps.tolist(), run.times.tolist(), strict=True)):
        columns = run.positions[frame], run.rotations[frame], run.velocities[frame], run.spins[frame]
        count = len(columns[0])
        for body, numbers in enumerate(np.hstack([column.reshape(count, -1) for column in columns]).tolist()):
            yield [frame, step, time, body, *numbers]


def _net(run: Run) -> Iterable[list[Any]]:
    for frame, (step, time) in enumerate(zip(run.steps.tolist(), run.times.tolist(), strict=True)):
        net = run.interactions(frame)
        columns = net.law, net.candidate, net.antagonist, net.gap, net.normal, net.point, net.impulse, net.force
        for law, c, a, gap, n, p, r, f in zip(*(column.tolist() for column in columns), strict=True):
            yield [frame, step, time, law, c, a, gap, *n, *p, *r, *f]
