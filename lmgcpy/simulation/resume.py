"""A simulation made from a run file, at the end of the recorded run."""

from __future__ import annotations

import os
from typing import Any

from lmgcpy.errors import closest, named_arguments
from lmgcpy.io.observations import Observe
from lmgcpy.io.run import Run
from lmgcpy.io.take_up import go_on, run_to_go_on
from lmgcpy.scene.description import Functions, build, impose
from lmgcpy.scene.scene import Scene
from lmgcpy.simulation.simulation import Simulation
from lmgcpy.solve.solvers import BY_CLASS


@named_arguments
def resume(
    path: str | os.PathLike, *, functions: Functions | None = None, observe: Observe | None = None, solver: Any = None
) -> Simulation:
    """The simulation of a run file at its last checkpoint; its runs continue in the same file.

    No file can hold functions. ``functions`` gives the imposed functions of time, by id of the body and name of the
    component, ``{(3, "y"): f}``, and the function of gravity, ``{"gravity": f}``. ``observe`` gives the functions of the
    simulation that the run observes, by name. ``solver`` is needed if the run has a solver of another package; it may also
    replace the solver of the run. Statements between steps (``body.hide()``, ``body.fix("x")``, ``scene.gravity = ...``)
    are in the file and act again. If the run was killed, the steps after the last checkpoint are made again. With the same
    versions on one type of processor the result equals the result of an uninterrupted run to the last bit.

    Raises the errors of ``lmgcpy.io.open_run``, PermissionError for a read-only file, BlockingIOError for one that is being
    written, ValueError for a missing function, and LookupError for a law that is not registered.
    """
    with run_to_go_on(path) as run:
        given = run.options
        sim = Simulation(
            _scene(path, run, functions),
            time_step=given["time_step"],
            theta=given["theta"],
            solver=_solver(path, given) if solver is None else solver,
            on_unconverged=given["on_unconverged"],
            geometric_stiffness=given["geometric_stiffness"],
            overlap="ignore",  # the run warned of overlaps when it began
        )
        go_on(sim, run, observe)
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
