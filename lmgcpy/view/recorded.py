"""Data of curves: what runs recorded, as the records of the mechanical tests hold it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from lmgcpy.io.run import Run
from lmgcpy.measure.stress import stress

PARTS = ("total", "sand", "wire")
"""Parts of the Weber stress: all interactions, contacts, links."""


class Tested(Protocol):
    """A mechanical test as curves show it; s steps, d dimensions. The records of the tests follow this protocol."""

    @property
    def law(self) -> str:
        """Law of the wire, "none" without a wire."""

    @property
    def strain(self) -> np.ndarray:
        """Crushing, (s,)."""

    @property
    def reaction(self) -> np.ndarray:
        """Support reaction [N], (s,)."""

    @property
    def size(self) -> np.ndarray:
        """Sizes of the box [m], (s, d)."""

    @property
    def stress(self) -> dict[str, np.ndarray]:
        """Weber stress of :data:`PARTS` [Pa], traction positive, (s, d, d) each."""

    def smooth(self, values: np.ndarray, width: float = ...) -> np.ndarray:
        """Running mean over ``width`` of strain along the first axis."""


@dataclass(frozen=True)
class RecordedTest:
    """A :class:`Tested` from a run file that observed "reactions", "size" and "stress"."""

    law: str
    strain: np.ndarray
    reaction: np.ndarray
    size: np.ndarray
    stress: dict[str, np.ndarray]

    def smooth(self, values: np.ndarray, width: float = 0.0025) -> np.ndarray:
        """Running mean over ``width`` of strain along the first axis."""
        return running_mean(self.strain, values, width)


def running_mean(strain: np.ndarray, values: np.ndarray, width: float) -> np.ndarray:
    """Mean over about ``width`` of ``strain`` along the first axis of ``values``."""
    if len(values) < 3 or strain[-1] == strain[0]:
        return values
    count = max(1, round(width / float(np.mean(np.diff(strain)))))
    sums = np.cumsum(np.concatenate([np.zeros((1, *values.shape[1:])), values]), axis=0)
    index = np.arange(len(values))
    low, high = np.maximum(index - count // 2, 0), np.minimum(index + count // 2 + 1, len(values))
    return (sums[high] - sums[low]) / (high - low).reshape(-1, *[1] * (values.ndim - 1))


def is_test(run: Run) -> bool:
    """Whether a run is one of the mechanical tests, which observe what curves need."""
    return {"reactions", "size", "stress"} <= set(run.observed) and len(run.history) > 0


def link_laws(run: Run) -> list[str]:
    """Names of the laws of the chains."""
    laws = run.scene["laws"]
    return list(dict.fromkeys(laws[k]["name"] for k in run.scene["chains"]["law"].tolist()))


def recorded_test(run: Run) -> RecordedTest:
    """The test that a run file holds; see :func:`is_test`."""
    size, sigma = run.observed["size"][:], run.observed["stress"][:]
    axis = "xyz".index(run.notes.get("axis", "xyz"[run.dimension - 1]))
    laws = link_laws(run)
    return RecordedTest(
        law=laws[0] if laws else "none",
        strain=1.0 - size[:, axis] / size[0, axis],
        reaction=run.observed["reactions"][:, 2 * axis],
        size=size,
        stress={part: sigma[:, k] for k, part in enumerate(PARTS)},
    )


def frames_with_forces(run: Run) -> list[int]:
    """Frames that end a step."""
    return [k for k, step in enumerate(run.steps.tolist()) if step > 0]


def stresses_by_frame(run: Run) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Times [s], (f,), and Weber stress of :data:`PARTS` [Pa], (f, d, d) each, of any run in a box of walls; ValueError
    without such a box."""
    frames, wires = frames_with_forces(run), link_laws(run)
    try:
        rows = [stress(run, frame=k) for k in frames]
    except ValueError as error:
        raise ValueError(
            f"The sample of '{run.path}' is not in a box between pairs of walls, so that its volume, hence its stress, is "
            "not known: ask for 'reaction', 'energy' or 'solver', or use lmgcpy.measure.stress(run, volume=...)."
        ) from error
    nothing = np.zeros((run.dimension, run.dimension))
    parts = {
        "total": [row["total"] for row in rows],
        "sand": [sum((row[law] for law in run.laws if law not in wires), nothing) for row in rows],
        "wire": [sum((row[law] for law in wires), nothing) for row in rows],
    }
    return run.times[frames], {name: np.array(part).reshape(-1, *nothing.shape) for name, part in parts.items()}


def wall_forces_by_frame(run: Run) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Times [s], (f,), and the normal force on each wall [N], (f,), by its name, of any run."""
    bodies = run.scene["bodies"]
    names = {wall: f"{bodies['colors'][bodies['color'][wall]]}, body {wall}" for wall in run.wall_normals}
    frames = frames_with_forces(run)
    forces: dict[str, list[float]] = {name: [] for name in names.values()}
    for k in frames:
        net = run.interactions(k)
        for wall, name in names.items():
            forces[name].append(float(net.force[(net.antagonist == wall) | (net.candidate == wall), 0].sum()))
    return run.times[frames], {name: np.array(values) for name, values in forces.items()}
