"""A scene from a frame of a run: a sample that is prepared once is tested many times."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from lmgcpy.dynamics.changes import from_rows
from lmgcpy.errors import shown, whole
from lmgcpy.io.run import Run, open_run
from lmgcpy.scene.description import Functions, build, impose
from lmgcpy.scene.scene import Scene


def scene_of_run(path: str | os.PathLike, step: int | None, functions: Functions | None) -> Scene:
    """See :meth:`lmgcpy.Scene.from_run`."""
    with open_run(path) as run:
        frame = frame_of_step(run, step)
        description, changes = at_frame(run, frame), run.checkpoint().changes
        try:
            scene = build(description, settled=True)
            changes_so_far = from_rows(changes, scene.counts)
        except (IndexError, KeyError, AttributeError, TypeError, ValueError, OverflowError, MemoryError) as error:
            raise ValueError(f"'{path}' holds no scene that can be built: {error}".rstrip(".") + ".") from error
        impose(scene, description, functions or {})
        scene.take([change for change in changes_so_far if change.step <= run.steps[frame]])
    return scene


def frame_of_step(run: Run, step: int | None) -> int:
    """The frame of a step, the last one for None; ValueError names the nearest steps that have one."""
    if run.frame_count == 0:
        raise ValueError(f"There is no frame in '{run.path}' yet: wait until the run has written its first.")
    if step is None:
        return run.frame_count - 1
    steps, wanted = np.asarray(run.steps), whole(step, "step", minimum=0)
    found = np.flatnonzero(steps == wanted)
    if len(found) == 0:
        near = sorted({int(steps[steps < wanted].max(initial=steps[0])), int(steps[steps > wanted].min(initial=steps[-1]))})
        raise ValueError(
            f"'{run.path}' has no frame of step {shown(wanted)}; the nearest are of {' and '.join(map(str, near))}."
        )
    return int(found[-1])


def at_frame(run: Run, frame: int) -> dict[str, Any]:
    """The description of the scene with the positions and velocities of a frame, and links as far drawn in as then."""
    description, d = dict(run.scene), run.dimension
    position = run.positions[frame]
    velocity = np.column_stack([run.velocities[frame], run.spins[frame]])
    if d == 2:
        position = np.column_stack([position, run.rotations[frame]])
    elif "turning" in description:
        turning = description["turning"]
        description["turning"] = {**turning, "rotation": run.rotations[frame][turning["body"]]}
    description["bodies"] = {**description["bodies"], "position": position, "velocity": velocity}
    chains = description["chains"]
    left = np.maximum(np.asarray(chains["relaxation"], dtype=float) - float(run.times[frame]), 0.0)
    description["chains"] = {**chains, "relaxation": left}
    return description


Scene._from_run = staticmethod(scene_of_run)
