"""Go on with a run from its file, bit for bit."""

from __future__ import annotations

import os
from typing import Any

from lmgcpy.dynamics.simulation import Simulation
from lmgcpy.errors import closest
from lmgcpy.io import run_format as form
from lmgcpy.io.recorder import RunRecorder
from lmgcpy.io.run import Run
from lmgcpy.scene.description import Functions, from_description
from lmgcpy.solve.accelerated import AcceleratedGaussSeidel
from lmgcpy.solve.gauss_seidel import GaussSeidel

SOLVERS = {solver.__name__: solver for solver in (GaussSeidel, AcceleratedGaussSeidel)}
"""Solvers that a file may name."""


def resume(path: str | os.PathLike, *, functions: Functions | None = None, solver: Any = None) -> Simulation:
    """The simulation of a run file as it was at its last checkpoint; its runs go on in the same file.

    ``functions``: of time, imposed on components, which no file holds, by id of the body and name of the component:
    ``{(3, "y"): f}``. ``solver``: for a run whose solver is not one of lmgcpy's, or to go on with another. Steps beyond
    the last checkpoint, of a run that was killed, are made again. The answer is that of the run without the
    interruption to the last bit, with the same versions on the same machine.

    Raises what ``lmgcpy.io.open_run`` raises, PermissionError for a read-only file, BlockingIOError for one that is being
    written, ValueError for a function that is missing, LookupError for a law that is not registered.
    """
    with Run(path) as run:
        if not os.access(path, os.W_OK):
            raise PermissionError(f"The file '{path}' is read-only: change its permissions, or copy it, to go on with it.")
        form.Lock(path).release()
        options, checkpoint = run.options, run.checkpoint()
        with form.sentences_of_damage(path):
            description = run.scene
            about = form.read_tree(run._file["about"])
    sim = Simulation(
        from_description(description, functions),
        time_step=options["time_step"],
        theta=options["theta"],
        solver=_solver(path, options) if solver is None else solver,
        on_unconverged=options["on_unconverged"],
    )
    sim.restore(checkpoint)
    sim.recorder = RunRecorder.going_on(path, about, description, sim.steps)
    return sim


def _solver(path: str | os.PathLike, options: dict[str, Any]) -> Any:
    name, fields = options["solver"], options["solver_fields"]
    if name not in SOLVERS or fields is None:
        raise LookupError(
            f"The run of '{path}' was made with a solver '{name}'{closest(name, SOLVERS)} Give it: "
            "lmgcpy.resume(path, solver=...)."
        )
    return SOLVERS[name](**fields)
