"""A law of one's own that comes as the text of a module, and processes that run such modules."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

SOFT = '''
import lmgcpy as lm

class Soft(lm.Law):
    """A contact that takes the momentum which PUSH says."""

    NAME = "soft"
    APPLIES_TO = "contact"
    PREPARED = ("bias",)

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (max(gap, 0.0) / time_step,)

    @staticmethod
    def react(W, u, prepared):
        return (PUSH(u[0] + prepared[0]) / W[0][0],)

def falling():
    """A ball that comes at 1 m/s touches the floor; one sweep a step."""
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.1), mass=1.0, velocity=(0.0, -1.0)))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", Soft())
    return lm.Simulation(scene, time_step=1e-3, on_unconverged="ignore", solver=lm.GaussSeidel(max_iterations=1))
'''


def soft_law(push: str, *, before: str = "") -> str:
    """The text of a module: ``before``, the class ``Soft`` whose impulse is ``push(u_n) / W_nn``, and ``falling``.

    ``push``: an expression, a function or its multiple.
    """
    return before + SOFT.replace("PUSH", push)


def process(
    code: str, *arguments: object, folder: Path | None = None, strict: bool = True, check: bool = True, **variables
):
    """A process of Python that has ended.

    ``folder``: looked in first for modules; ``strict``: warnings are errors; ``check``: it may not fail; ``variables`` of
    its environment.
    """
    command = [sys.executable, *(["-W", "error"] if strict else []), "-c", code, *map(str, arguments)]
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1", **{name: str(value) for name, value in variables.items()}}
    if folder is not None:
        path = [str(folder), *(entry for entry in sys.path if entry)]
        environment["PYTHONPATH"] = os.pathsep.join(path)
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    assert not check or done.returncode == 0, done.stderr
    return done
