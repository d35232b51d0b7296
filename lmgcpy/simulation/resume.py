"""A run file becomes a simulation again: at the end of the recorded run, or as a new scene with the bodies of a frame."""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from lmgcpy.dynamics.changes import from_rows
from lmgcpy.errors import closest, file_path, named_arguments, shown, whole
from lmgcpy.io.rows import Observe
from lmgcpy.io.run import Run, open_run
from lmgcpy.io.take_up import go_on, go_on_elsewhere, other_options, run_to_go_on
from lmgcpy.scene.description import Functions, build, impose
from lmgcpy.scene.scene import Scene
from lmgcpy.simulation.simulation import Simulation
from lmgcpy.solve.solvers import BY_CLASS
from lmgcpy.writing import check_target


@named_arguments
def resume(
    path: str | os.PathLike,
    *,
    time_step: float | None = None,
    solver: Any = None,
    record: str | os.PathLike | None = None,
    functions: Functions | None = None,
    observe: Observe | None = None,
) -> Simulation:
    """The simulation of a run file at its last checkpoint; its runs continue in the same file, or in the file ``record``.

    No file can hold functions. ``functions`` gives the imposed functions of time, by id of the body and name of the
    component, ``{(3, "y"): f}``, and the function of gravity, ``{"gravity": f}``. ``observe`` gives the functions of the
    simulation that the run observes, by name. Statements between steps (``body.hide()``, ``body.fix("x")``,
    ``scene.gravity = ...``) are in the file and act again. If the run was killed, the steps after the last checkpoint are
    made again. With the same versions on one type of processor the result equals the result of an uninterrupted run to the
    last bit.

    With ``record`` the run goes on in a new file, and the file at ``path``, which is only read, keeps its end. The new file
    begins with the state of the checkpoint, its time and number of steps, and has the notes, the ``every`` and the
    ``flush`` of the old one; ``observe`` names what it observes. Such a run may have another ``time_step`` [s] and another
    ``solver``. It starts from the impulses and the states of laws (slip, wear, damage) of the checkpoint. With another
    time step the impulses are scaled to the same forces, and the first step takes no gap for one that its laws predicted
    (``lmgcpy/dynamics/turning_stretch.py``). ``solver`` is needed if the run has a solver of another package.

    Raises the errors of ``lmgcpy.io.open_run``, PermissionError for a read-only file, BlockingIOError for one that is being
    written, FileExistsError if there is a file ``record``, ValueError for a missing function and for other options without
    ``record``, and LookupError for a law that is not registered.
    """
    if record is not None:
        record = file_path(record, "record")
        check_target(record, force=False, name="record", instead="give another name")
    with run_to_go_on(path) if record is None else open_run(path) as run:
        given = run.options
        sim = Simulation(
            _scene(path, run, functions),
            time_step=given["time_step"] if time_step is None else time_step,
            theta=given["theta"],
            solver=_solver(path, given) if solver is None else solver,
            on_unconverged=given["on_unconverged"],
            geometric_stiffness=given["geometric_stiffness"],
            overlap="ignore",  # the run warned of overlaps when it began
        )
        other = other_options(sim, run) if record is None else ""
        if other and given["solver"] not in BY_CLASS and sim.time_step == given["time_step"]:
            other = ""  # the class of a solver of another package may have another name by now
        if other:
            raise ValueError(
                f"'{path}' cannot go on with other options, as a file holds one of each: {other}. Give it another file: "
                "lmgcpy.resume(path, record='another.h5', ...)."
            )
        if record is None:
            go_on(sim, run, observe)
        else:
            go_on_elsewhere(sim, run, record, observe)
    return sim


def _scene(path: str | os.PathLike, run: Run, functions: Functions | None) -> Scene:
    """The scene of a run. An error of the description is one of the file; an error of ``functions`` is one of the call."""
    description = run.scene
    try:
        scene = build(description)
    except (IndexError, KeyError, AttributeError, TypeError, ValueError, OverflowError, MemoryError) as error:
        raise ValueError(f"'{path}' holds no scene that can be built: {error}".rstrip(".") + ".") from error
    impose(scene, description, functions or {})
    return scene


def _solver(path: str | os.PathLike, options: dict[str, Any]) -> Any:
    name, fields = options["solver"], options["solver_fields"]
    if name not in BY_CLASS or fields is None:
        raise LookupError(
            f"The run of '{path}' was made with a solver '{name}'{closest(name, BY_CLASS)} Give it: "
            "lmgcpy.resume(path, solver=...)."
        )
    return BY_CLASS[name](**fields)


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
