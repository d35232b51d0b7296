"""A simulation made from a run file, as it was where the file ends."""

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
    """The simulation of a run file as it was at its last checkpoint; its runs go on in the same file.

    ``functions``: of time, imposed on components, which no file holds, by id of the body and name of the component:
    ``{(3, "y"): f}``; ``observe``: the functions of the simulation that the run observes, by name. ``solver``: for a run
    whose solver is not one of lmgcpy's, or to go on with another. Steps beyond the last checkpoint, of a run that was
    killed, are made again. The answer is that of the run without the interruption to the last bit, with the same
    versions on the same machine.

    Raises what ``lmgcpy.io.open_run`` raises, PermissionError for a read-only file, BlockingIOError for one that is being
    written, ValueError for a function that is missing, LookupError for a law that is not registered.
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
            overlap="ignore",  # of the scene's start, which was told when the run began
        )
        go_on(sim, run, observe)
    return sim


def _scene(path: str | os.PathLike, run: Run, functions: Functions | None) -> Scene:
    """The scene of a run; what cannot be one is the file's fault, what functions lack is not."""
    description = run.scene
    try:
        scene = build(description)
    except (IndexError, KeyError, AttributeError, TypeError, ValueError, OverflowError, MemoryError) as error:
        raise ValueError(f"'{path}' holds no scene that can be built: {error}".rstrip(".") + ".") from error
    impose(scene, description["conditions"], functions or {})
    return scene


def _solver(path: str | os.PathLike, options: dict[str, Any]) -> Any:
    name, fields = options["solver"], options["solver_fields"]
    if name not in BY_CLASS or fields is None:
        raise LookupError(
            f"The run of '{path}' was made with a solver '{name}'{closest(name, BY_CLASS)} Give it: "
            "lmgcpy.resume(path, solver=...)."
        )
    return BY_CLASS[name](**fields)
