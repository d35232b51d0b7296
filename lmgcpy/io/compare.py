"""The first difference of two runs: its quantity, its time, and its size; and of two trees of dictionaries."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from lmgcpy.dynamics.interactions import InteractionView
from lmgcpy.errors import named_arguments, number, shown
from lmgcpy.io.run import Run

PARTS = ("gravity", "laws", "visibility", "chains", "joints", "conditions", "bodies", "turning", "contactors", "media")
"""Parts of a scene, in the order in which they are held against each other."""
ENERGIES = ("kinetic", "loads", "drives", "drag", "defect", "work", "stored")
SOLVER = ("iterations", "residual", "slip", "stretch", "made", "unbalanced", "status", "interactions")


@dataclass(frozen=True)
class Difference:
    """The first difference of two runs."""

    quantity: str
    """Name of the quantity that differs."""
    time: float
    """Time of the difference [s]; NaN if the runs differ as wholes."""
    step: int
    """Step at whose end the runs differ."""
    by: float
    """Largest difference, in the unit of the quantity."""
    relative: float
    """Largest difference relative to the largest value: at that time or, with a tolerance, in the two runs."""
    where: str = ""
    """The body, or the two values."""
    parameter: str = ""
    """The first option, law or number of the scene that was given differently, if any."""

    def __str__(self) -> str:
        when = f"at t = {self.time:g} s, step {self.step}" if np.isfinite(self.time) else "as wholes"
        size = f", by {self.by:.3g} ({self.relative:.2g} of the largest)" if np.isfinite(self.by) else ""
        cause = f"Their {self.parameter}. " if self.parameter else ""
        return f"{cause}They differ in {self.quantity} {when}{size}{f': {self.where}' if self.where else '.'}"

    def __repr__(self) -> str:
        return f"<Difference: {self}>"


@named_arguments
def compare(a: Run, b: Run, *, tolerance: float = 0.0) -> Difference | None:
    """The first difference of two runs, or None if they agree.

    ``tolerance`` is the allowed difference, relative to the largest value of the quantity in the two runs. With 0 the runs
    must agree to the last bit, and so must the iterations and residuals of the solver. Impulses are compared by the
    identity of their interactions. Clock times are not compared.
    """
    for run in (a, b):
        if not isinstance(run, Run):
            raise TypeError(f"compare takes two runs, which lmgcpy.io.open_run(path) opens, got {shown(run)}.")
    number(tolerance, "tolerance", minimum=0.0)
    for what, mine, other in (
        ("dimension", a.dimension, b.dimension),
        ("number of bodies", a.positions.shape[1], b.positions.shape[1]),
        ("laws", a.laws, b.laws),
    ):
        if mine != other:
            return Difference(what, np.nan, 0, np.nan, np.nan, f"{mine} and {other}.")
    parameter = _parameter(a, b)
    events = sorted([*_in_history(a, b, tolerance), *_in_frames(a, b, tolerance)], key=lambda found: (found[0], found[1]))
    if events:
        found = events[0][2]
        return replace(found, parameter=parameter) if parameter else found
    if list(a.observed) != list(b.observed):
        names = " and ".join(", ".join(run.observed) or "nothing" for run in (a, b))
        return Difference("the observed names", np.nan, 0, np.nan, np.nan, f"{names}; equal in the names of both.")
    for what, mine, other in (("steps", len(a.history), len(b.history)), ("frames", a.frame_count, b.frame_count)):
        if mine != other:
            return Difference(
                f"number of {what}",
                np.nan,
                0,
                np.nan,
                np.nan,
                f"{mine} and {other}; equal up to the shorter end.",
            )
    return None


def _parameter(a: Run, b: Run) -> str:
    """The first difference in the input of the runs: options, laws with their parameters, and the scene."""
    names = ("time_step", "theta", "solver", "solver_fields", "geometric_stiffness")
    given = []
    for run in (a, b):
        scene = run.scene
        options = {name: run.options[name] for name in names}
        given.append({"options": options, **{part: scene.get(part, {}) for part in PARTS}})
    for part in ("options", *PARTS):
        different = first_difference(given[0][part], given[1][part], part, ("in the first", "in the second"))
        if different:
            return different
    return ""


def _in_history(a: Run, b: Run, tolerance: float) -> Iterator[tuple[int, int, Difference]]:
    """The first difference of each column of the history and of each observation: (step, rank, difference)."""
    count = min(len(a.history), len(b.history))
    mine, other = a.history[:count], b.history[:count]
    kept = set(mine.dtype.names or ()) & set(other.dtype.names or ())  # older files have fewer columns
    names = [name for name in (*ENERGIES, *SOLVER) if name in kept]
    if tolerance > 0.0:  # the solver's columns depend on the path to the answer, and the defect is round-off
        names = [name for name in names if name not in (*SOLVER, "defect")]
    columns = [(f"{name} energy" if name in ("kinetic", "stored") else name, mine[name], other[name]) for name in names]
    columns = [("step", mine["step"], other["step"]), ("time", mine["time"], other["time"]), *columns]
    columns += [(name, a.observed[name][:count], b.observed[name][:count]) for name in a.observed if name in b.observed]
    for rank, (quantity, x, y) in enumerate(columns):
        if x.shape != y.shape:
            yield 0, 20 + rank, Difference(f"shape of {quantity}", np.nan, 0, np.nan, np.nan, f"{x.shape} and {y.shape}.")
            continue
        x, y = x.astype(float).reshape(count, -1), y.astype(float).reshape(count, -1)
        same = (x == y) | (np.isnan(x) & np.isnan(y))
        with np.errstate(invalid="ignore"):
            by = np.where(same, 0.0, np.abs(x - y)).max(axis=1, initial=0.0)
        largest = max(np.abs(values[np.isfinite(values)]).max(initial=0.0) for values in (x, y))
        wrong = ~(by <= tolerance * largest)  # NaN counts as wrong
        if wrong.any():
            k = int(np.argmax(wrong))
            yield int(mine["step"][k]), 20 + rank, _difference(quantity, mine[k], by[k], largest)


def _in_frames(a: Run, b: Run, tolerance: float) -> Iterator[tuple[int, int, Difference]]:
    """The first difference of the first frame that differs: (step, rank, difference)."""
    index_a, index_b = a._array("frames/index")[:], b._array("frames/index")[:]
    scale = dict.fromkeys(("positions", "rotations", "velocities", "spins", "impulses"), 0.0)
    for run in (a, b) if tolerance > 0.0 else ():
        for k in range(run.frame_count):
            for name in scale:
                values = run.interactions(k).impulse if name == "impulses" else getattr(run, name)[k]
                scale[name] = max(scale[name], float(np.abs(values).max(initial=0.0)))
    if tolerance > 0.0:  # rotations by round-off have no scale of their own: take a radian, and rolling at the top speed
        extent = a.scene["bodies"]["extent"]
        size = float(extent[np.isfinite(extent)].max(initial=0.0)) or 1.0
        scale["rotations"] = max(scale["rotations"], 1.0)
        scale["spins"] = max(scale["spins"], scale["velocities"] / size)
    for k in range(min(len(index_a), len(index_b))):
        here = index_a[k]
        if here["step"] != index_b[k]["step"]:
            yield int(here["step"]), 0, _difference("step of the frame", here, abs(here["step"] - index_b[k]["step"]), 1.0)
            return
        pairs: list[tuple[str, Any, Any]] = [
            (name, getattr(a, name)[k], getattr(b, name)[k]) for name in ("positions", "rotations", "velocities", "spins")
        ]
        net_a, net_b = a.interactions(k), b.interactions(k)
        if tolerance == 0.0 and _identities(net_a) != _identities(net_b):
            where = f"{len(net_a)} and {len(net_b)} of them."
            yield (
                int(here["step"]),
                5,
                Difference("interactions", float(here["time"]), int(here["step"]), np.nan, 0.0, where),
            )
            return
        pairs.append(("impulses", *_matched(net_a, net_b)))
        for rank, (name, x, y) in enumerate(pairs):
            if x.shape != y.shape:  # in one of two runs in space no body keeps a rotation
                where = f"of shape {x.shape} and {y.shape}."
                difference = Difference(name, float(here["time"]), int(here["step"]), np.nan, np.nan, where)
                yield int(here["step"]), rank, difference
                return
            by = np.abs(x - y)
            worst = float(by.max(initial=0.0))
            largest = max(scale[name], float(np.abs(x).max(initial=0.0)), float(np.abs(y).max(initial=0.0)))
            if not worst <= tolerance * largest:
                body = int(np.argmax(by.reshape(len(by), -1).max(axis=1)))
                where = f"body {body}." if name != "impulses" else ""
                yield int(here["step"]), rank, _difference(name, here, worst, largest, where)
                return


def _difference(quantity: str, row: Any, by: float, largest: float, where: str = "") -> Difference:
    relative = float(by / largest) if largest else np.inf
    return Difference(quantity, float(row["time"]), int(row["step"]), float(by), relative, where)


def _identities(net: InteractionView) -> list[tuple[str, int, int, int]]:
    """Law, candidate, antagonist, and the number of the interaction among the interactions with the same three."""
    seen: dict[tuple[str, int, int], int] = {}
    result = []
    for key in zip(net.law.tolist(), net.candidate.tolist(), net.antagonist.tolist(), strict=True):
        seen[key] = seen.get(key, -1) + 1
        result.append((*key, seen[key]))
    return result


def _matched(a: InteractionView, b: InteractionView) -> tuple[np.ndarray, np.ndarray]:
    """Impulses of both by the identity of their interactions; zero for an interaction that one of them lacks."""
    mine, other = _identities(a), _identities(b)
    if mine == other:
        return a.impulse, b.impulse
    keys = {key: i for i, key in enumerate(dict.fromkeys([*mine, *other]))}
    x, y = np.zeros((2, len(keys), a.impulse.shape[1]))
    x[[keys[key] for key in mine]] = a.impulse
    y[[keys[key] for key in other]] = b.impulse
    return x, y


def first_difference(there: Any, here: Any, where: str = "", sides: tuple[str, str] = ("there", "here")) -> str:
    """The first difference as a clause, "time_step is 0.1 there and 0.2 here"; empty if there is none."""
    if isinstance(there, list) and isinstance(here, list):
        there, here = dict(enumerate(there)), dict(enumerate(here))
    if isinstance(there, dict) and isinstance(here, dict):
        for name in sorted(here.keys() | there.keys(), key=str):
            what = f"{where} {name}".strip()
            if name not in there or name not in here:
                return f"there is {'no' if name not in there else 'a'} '{what}' in it"
            different = first_difference(there[name], here[name], what, sides)
            if different:
                return different
        return ""
    if isinstance(there, np.ndarray) or isinstance(here, np.ndarray):
        same = np.shape(there) == np.shape(here) and np.array_equal(there, here, equal_nan=True)
        return "" if same else _of_arrays(there, here, where, sides)
    return "" if there == here else f"'{where}' is {shown(there)} {sides[0]} and {shown(here)} {sides[1]}"


def _of_arrays(there: Any, here: Any, where: str, sides: tuple[str, str]) -> str:
    """The first number that differs, or the shapes."""
    if np.shape(there) != np.shape(here):
        return f"'{where}' has {len(np.atleast_1d(there))} rows {sides[0]} and {len(np.atleast_1d(here))} {sides[1]}"
    index = tuple(int(k) for k in np.argwhere(~((there == here) | ((there != there) & (here != here))))[0])
    numbers = f"{shown(there[index])} {sides[0]} and {shown(here[index])} {sides[1]}"
    return f"'{where}' is {numbers}, in row {index[0]}" if index else f"'{where}' is {numbers}"
