"""All that the next step depends on, and the totals of the run so far: enough to go on bit for bit."""

from __future__ import annotations

from dataclasses import dataclass, fields, is_dataclass
from typing import Any

import numpy as np

from lmgcpy.contact.memory import Memory
from lmgcpy.dynamics.energy import Energy
from lmgcpy.errors import flag, number, shown, whole


@dataclass(frozen=True)
class Checkpoint:
    """A simulation between two steps, as copies; n bodies."""

    positions: np.ndarray
    """(x, y, angle) [m, m, rad], (n, 3); in 3D see ``lmgcpy/contact/positions.py``."""
    velocities: np.ndarray
    """[m/s, rad/s], (n, k); the spins of bodies that turn in space along their own axes."""
    left: np.ndarray
    """Velocities at the end of the last step, (n, k): those above may have been written since."""
    time: float
    """[s]."""
    time_step: float
    """Time step of the impulses [s]; a simulation with another one keeps the forces."""
    theta: float
    """theta of the predicted gaps."""
    steps: int
    """Number of steps so far."""
    unconverged_steps: int
    """Number of steps that the solver did not solve to its tolerance."""
    worst_residual: float
    """Largest residual of a step so far."""
    energy: Energy
    """Energies of the last step, and their totals."""
    memory: Memory
    """Impulses and states of the interactions, by identity."""
    predicted: np.ndarray
    """Gaps of the links by their laws at the end of the last step [m], (L,), NaN where not known."""
    changes: np.ndarray
    """Statements between steps so far, (c, 5): step, kind, body, component, value."""

    def __repr__(self) -> str:
        return f"<Checkpoint of {len(self.positions)} bodies at t = {self.time:g} s, step {self.steps}>"


REMEMBERED = ("identity", "impulse", "state")
"""Arrays with a row for every interaction that is remembered, which may be any number."""
UNKNOWN = ("predicted", "state")
"""Arrays in which NaN says that there is no number."""


def check(given: Any, like: Any, name: str = "The checkpoint's") -> None:
    """Hold a checkpoint against one of the simulation that is to go on from it; a sentence on what is wrong.

    Raises TypeError for another type, and ValueError for another shape and for impossible numbers.
    """
    for field in fields(like):
        value, other, what = getattr(given, field.name), getattr(like, field.name), f"{name} {field.name}"
        if is_dataclass(other):
            if type(value) is not type(other):
                raise TypeError(f"{what} must be of type {type(other).__name__}, got {shown(value)}.")
            check(value, other, f"{what}'s")
        elif isinstance(other, np.ndarray):
            _check_array(value, other, field.name, what)
        elif isinstance(other, dict):
            if not (isinstance(value, dict) and all(isinstance(law, str) for law in value)):
                raise TypeError(f"{what} must be numbers by name of law, got {shown(value)}.")
            for law, item in value.items():
                number(item, f"{what} of law '{law}'")
        elif field.type == "bool":
            flag(value, what)
        elif field.type == "int":
            whole(value, what)
        elif not (field.name == "worst_residual" and isinstance(value, float) and value == np.inf):
            at_least = 0.0 if field.name in ("time", "theta", "worst_residual", "reach") else -np.inf
            number(value, what, minimum=at_least, above=0.0 if field.name == "time_step" else -np.inf)
        if field.name in REMEMBERED and len(value) != len(given.identity):
            raise ValueError(f"{what} must have {len(given.identity)} rows as the identity has, got {len(value)}.")


def _check_array(value: Any, other: np.ndarray, field: str, what: str) -> None:
    if not (isinstance(value, np.ndarray) and value.dtype == other.dtype):
        raise TypeError(f"{what} must be an array of {other.dtype}, got {shown(value)}.")
    skip = 1 if field in (*REMEMBERED, "changes") else 0
    if value.ndim != other.ndim or value.shape[skip:] != other.shape[skip:]:
        if field == "predicted" and not value.size:  # none was kept
            return
        if field == "state" and value.shape[1:] == (other.shape[1] - 1,):  # nor predicted gaps of contacts
            return
        raise ValueError(
            f"{what} have a shape of {value.shape}, those of this scene of {other.shape}: give a checkpoint of this scene."
        )
    bad = np.isinf(value) if field in UNKNOWN else ~np.isfinite(value)
    if bad.any():
        raise ValueError(f"{what} hold numbers that are not finite: take an earlier checkpoint.")
