"""Isotropic compaction of a 2D sample to a pressure: the relaxation that tightens the grains around the wire."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from lmgcpy.dynamics.simulation import Simulation
from lmgcpy.experiment.box_2d import Box2D, Sample, characteristic_time
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


def compact(
    sample: Sample,
    *,
    pressure: float,
    density: float,
    friction: float = 0.0,
    solver: AcceleratedGaussSeidel | GaussSeidel | None = None,
    max_steps: int = 800,
    on_step: Callable[[int], None] | None = None,
) -> Compaction:
    """Press lateral walls and lid by ``pressure`` [Pa] until the sample is at rest.

    Rest: over 50 steps no wall's force is off its load by more than 2 % in the mean, and the volume changes by less than
    3e-4. Without friction the sample becomes as dense as its grains allow; the wire is inextensible. The time step is a
    fifth of ``d sqrt(rho/p)``: with rigid grains the pressure sets the time scale and nothing else.
    """
    box = Box2D(sample, density=density, friction=friction, law=RigidWire() if sample.bead_count > 1 else None)
    box.load_laterally(pressure)
    box.load_top(pressure)
    step = 0.2 * characteristic_time(sample.diameter, density, pressure)
    sim = Simulation(
        box.scene, time_step=step, solver=solver or AcceleratedGaussSeidel(tolerance=1e-2, max_iterations=5000)
    )
    forces = np.zeros((max_steps, 3))
    volumes = np.zeros(max_steps)
    residuals = []
    at_rest = False
    imbalance = volume_change = np.inf
    for k in range(max_steps):
        residuals.append(sim.step().residual)
        reactions = box.reactions(sim)
        height, width = box.height, box.width
        forces[k] = (
            reactions["left"] / (pressure * height),
            reactions["right"] / (pressure * height),
            reactions["top"] / (pressure * width),
        )
        volumes[k] = width * height
        if on_step:
            on_step(k + 1)
        if k >= WINDOW:
            imbalance = float(np.abs(forces[k - WINDOW : k].mean(axis=0) - 1.0).max())
            volume_change = abs(volumes[k] / volumes[k - WINDOW] - 1.0)
            if imbalance < 0.02 and volume_change < 3e-4:
                at_rest = True
                break
    done = box.sample(sample)
    contacts = sim.interactions.gap[sim.interactions.law == "coulomb"]
    return Compaction(
        sample=done,
        steps=sim.steps,
        at_rest=at_rest,
        imbalance=imbalance,
        volume_change=volume_change,
        solid_fraction=inner_solid_fraction(done),
        penetration=max(0.0, -float(contacts.min(initial=0.0))),
        mean_residual=float(np.mean(residuals)),
    )


def inner_solid_fraction(sample: Sample) -> float:
    """Solid fraction in a window one coarsest diameter from all walls."""
    margin = 2.0 * float(sample.radii.max())
    window = ((margin, margin), (sample.width - margin, sample.height - margin))
    return solid_fraction(sample.positions, sample.radii, window)
