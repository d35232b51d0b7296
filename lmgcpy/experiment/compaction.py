"""Isotropic compaction of a 2D sample to a pressure: the relaxation that tightens the grains around the wire."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from lmgcpy.dynamics.simulation import Simulation
from lmgcpy.errors import named_arguments, number, shown, whole
from lmgcpy.experiment.box_2d import Box2D, Sample, characteristic_time
from lmgcpy.experiment.trial import carry_out
from lmgcpy.laws.rigid import RigidWire
from lmgcpy.measure.density import density as solid_fraction
from lmgcpy.solve.accelerated import AcceleratedGaussSeidel
from lmgcpy.solve.gauss_seidel import GaussSeidel

WINDOW = 50
"""Steps over which rest is judged."""


@dataclass(frozen=True)
class Compaction:
    """A compacted sample and how it came to rest."""

    sample: Sample
    steps: int
    at_rest: bool
    imbalance: float
    """Mean over the last window of |force on a wall / (pressure x its length) - 1|, the worst wall."""
    volume_change: float
    """Relative, over the last window."""
    solid_fraction: float
    """In a window one coarsest diameter from the walls."""
    penetration: float
    """Deepest overlap [m]."""
    mean_residual: float
    seconds: float


@named_arguments
def compact(
    sample: Sample,
    *,
    pressure: float,
    density: float,
    friction: float = 0.0,
    solver: AcceleratedGaussSeidel | GaussSeidel | None = None,
    max_steps: int = 800,
    file: str | os.PathLike | None = None,
    on_step: Callable[[int], None] | None = None,
    interrupted: Callable[[], bool] | None = None,
) -> Compaction:
    """Press lateral walls and lid by ``pressure`` [Pa] until the sample is at rest.

    Rest: over 50 steps no wall's force is off its load by more than 2 % in the mean, and the volume changes by less than
    3e-4. Without friction the sample becomes as dense as its grains allow; the wire is inextensible. The time step is a
    fifth of ``d sqrt(rho/p)``: with rigid grains the pressure sets the time scale and nothing else.

    ``file``, ``on_step`` and ``interrupted`` as in :func:`lmgcpy.experiment.trial.carry_out`.
    """
    number(pressure, "pressure", above=0.0, unit="Pa")
    whole(max_steps, "max_steps", minimum=1)
    if not isinstance(sample, Sample):
        raise TypeError(f"compact takes a Sample, such as lay_sample() makes, got {shown(sample)}.")
    box = Box2D(sample, density=density, friction=friction, law=RigidWire() if sample.bead_count > 1 else None)
    box.load_laterally(pressure)
    box.load_top(pressure)
    step = 0.2 * characteristic_time(sample.diameter, density, pressure)
    solver = solver or AcceleratedGaussSeidel(tolerance=1e-2, max_iterations=5000)
    sim = Simulation(box.scene, time_step=step, solver=solver, on_unconverged="ignore")

    def at_rest(rows: Mapping[str, np.ndarray]) -> bool:
        imbalance, volume_change = unrest(rows["reactions"], rows["size"], pressure)
        return imbalance < 0.02 and volume_change < 3e-4

    with carry_out(
        sim,
        steps=max_steps,
        observe={"reactions": box.reactions, "size": box.size, "penetration": box.penetration},
        every=WINDOW,
        notes={"experiment": "compaction", "pressure": pressure},
        rule=at_rest,
        window=WINDOW + 1,
        file=file,
        on_step=on_step,
        interrupted=interrupted,
    ) as run:
        history = run.history[:]
        rows = {name: column[-WINDOW - 1 :] for name, column in run.observed.items()}
    imbalance, volume_change = unrest(rows["reactions"], rows["size"], pressure)
    done = box.sample(sample)
    return Compaction(
        sample=done,
        steps=len(history),
        at_rest=at_rest(rows),
        imbalance=imbalance,
        volume_change=volume_change,
        solid_fraction=inner_solid_fraction(done),
        penetration=float(rows["penetration"][-1]),
        mean_residual=float(history["residual"].mean()),
        seconds=float(history["step_seconds"].sum()),
    )


def unrest(reactions: np.ndarray, size: np.ndarray, pressure: float) -> tuple[float, float]:
    """(imbalance, volume change) over the last rows of reactions [N], (w, 4), and size [m], (w, 2).

    Infinite before there are the rows of a window and one more.
    """
    if len(size) <= WINDOW:
        return np.inf, np.inf
    left, right, _, top = reactions.T
    width, height = size.T
    forces = np.stack([left / (pressure * height), right / (pressure * height), top / (pressure * width)], axis=1)
    imbalance = float(np.abs(forces[:-1].mean(axis=0) - 1.0).max())
    return imbalance, abs(float(width[-1] * height[-1] / (width[0] * height[0])) - 1.0)


def inner_solid_fraction(sample: Sample) -> float:
    """Solid fraction in a window one coarsest diameter from all walls."""
    margin = 2.0 * float(sample.radii.max())
    window = ((margin, margin), (sample.width - margin, sample.height - margin))
    return solid_fraction(sample.positions, sample.radii, window)
