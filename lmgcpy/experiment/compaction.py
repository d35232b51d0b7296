"""Isotropic compaction of a sample to a pressure: the relaxation that tightens the grains around the wire."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.errors import named_arguments, number, shown, whole
from lmgcpy.experiment.box import Box, Sample, characteristic_time
from lmgcpy.experiment.damped import DampedSimulation
from lmgcpy.experiment.trial import carry_out
from lmgcpy.laws.rigid import RigidWire
from lmgcpy.measure.density import density as solid_fraction
from lmgcpy.simulation import Simulation
from lmgcpy.solve.sweeps.accelerated import AcceleratedGaussSeidel
from lmgcpy.solve.sweeps.solver import Solver

WINDOW = 50
"""Number of steps over which rest is judged."""


@dataclass(frozen=True)
class Unrest:
    """Four measures of motion over a window of steps; all are small at rest."""

    imbalance: float = np.inf
    """Mean of ``|force on a wall / (pressure x its area) - 1|``, the worst of the loaded walls."""
    volume_change: float = np.inf
    """Relative change of the volume."""
    force: float = np.inf
    """Mean resultant force on a particle, over p d^(D-1), the force of the pressure on a particle."""
    kinetic: float = np.inf
    """Mean kinetic energy of a particle, over p d^D, the work of the pressure on its volume."""

    @property
    def is_rest(self) -> bool:
        """Whether each is below its bound."""
        return self.imbalance < 0.02 and self.volume_change < 3e-4 and self.force < 0.02 and self.kinetic < 1e-4


@dataclass(frozen=True)
class Compaction:
    """A compacted sample in d dimensions and how it came to rest."""

    sample: Sample
    """The compacted sample."""
    steps: int
    """Number of steps made."""
    at_rest: bool
    """Whether the sample came to rest within them."""
    unrest: Unrest
    """Measures of motion over the last window."""
    solid_fraction: float
    """Solid fraction in a window one coarsest diameter from the walls."""
    coordination: float
    """Mean number of contacts of the particles that are no rattlers."""
    rattlers: float
    """Share of the grains that carry no force."""
    fabric: np.ndarray
    """Mean of n (x) n over the contacts, (d, d)."""
    penetration: float
    """Deepest overlap [m]."""
    mean_residual: float
    """Mean residual of the steps."""
    seconds: float
    """Wall clock time of the steps [s]."""

    def __repr__(self) -> str:
        rest = "at rest" if self.at_rest else "not at rest"
        return f"<Compaction in {self.steps} steps, {rest}, solid fraction {self.solid_fraction:.3f}: {self.sample!r}>"


@named_arguments
def compact(
    sample: Sample,
    *,
    pressure: float,
    density: float,
    friction: float = 0.0,
    drag: float = 0.0,
    time_step: float | None = None,
    solver: Solver | None = None,
    max_steps: int = 800,
    file: str | os.PathLike | None = None,
    on_step: Callable[[int], None] | None = None,
    interrupted: Callable[[], bool] | None = None,
) -> Compaction:
    """Press lateral walls and lid by ``pressure`` [Pa] until the sample is at rest.

    The sample is at rest if over 50 steps no wall's mean force differs from its load by more than 2 %, the volume changes
    by less than 3e-4, the mean resultant force on a particle is below 2 % of ``p d^(D-1)``, and its mean kinetic energy is
    below 1e-4 ``p d^D`` (D dimensions, d the mean diameter). Without ``friction`` the sample becomes as dense as its grains
    allow; the wire is inextensible. ``time_step`` [s] is by default a fifth of ``d sqrt(rho/p)``: with rigid grains the
    pressure alone sets the time scale. ``drag``: velocities decay by ``exp(-drag)`` in that time; without it, grains that
    are squeezed out hammer a wire of fine beads, which has no bending stiffness, until it is crumpled.

    ``file``, ``on_step`` and ``interrupted`` as in :func:`lmgcpy.experiment.carry_out`.
    """
    number(pressure, "pressure", above=0.0, unit="Pa")
    whole(max_steps, "max_steps", minimum=1)
    number(drag, "drag", minimum=0.0)
    if not isinstance(sample, Sample):
        raise TypeError(f"compact takes a Sample, such as lay_sample() makes, got {shown(sample)}.")
    box = Box(sample, density=density, friction=friction, law=RigidWire() if sample.wires else None)
    box.load_laterally(pressure)
    box.load_top(pressure)
    moment = characteristic_time(sample.diameter, density, pressure)
    options: dict[str, Any] = {
        "time_step": 0.2 * moment if time_step is None else number(time_step, "time_step", above=0.0, unit="s"),
        "solver": solver or AcceleratedGaussSeidel(tolerance=1e-2, max_iterations=5000),
        "on_unconverged": "ignore",
    }
    if drag > 0.0:
        sim: Simulation = DampedSimulation(box.scene, drag_time=moment / drag, **options)
    else:
        sim = Simulation(box.scene, **options)

    def judge(rows: Mapping[str, np.ndarray]) -> Unrest:
        return unrest({name: rows[name][-WINDOW - 1 :] for name in rows}, pressure, box)

    with carry_out(
        sim,
        steps=max_steps,
        observe={
            "reactions": box.reactions,
            "size": box.size,
            "penetration": box.penetration,
            "unbalanced": box.unbalanced,
            "kinetic": lambda sim: sim.energy.kinetic,
            "network": box.network,
        },
        every=WINDOW,
        notes={"experiment": "compaction", "pressure": pressure, "drag": drag},
        rule=lambda rows: judge(rows).is_rest,
        window=WINDOW + 1,
        file=file,
        on_step=on_step,
        interrupted=interrupted,
    ) as run:
        history = run.history[:]
        rows = {name: column[-WINDOW - 1 :] for name, column in run.observed.items()}
    left = judge(rows)
    done = box.sample(sample)
    coordination, rattlers, *fabric = rows["network"][-1]
    return Compaction(
        sample=done,
        steps=len(history),
        at_rest=left.is_rest,
        unrest=left,
        solid_fraction=inner_solid_fraction(done),
        coordination=coordination,
        rattlers=rattlers,
        fabric=np.reshape(fabric, (sample.dimension, sample.dimension)),
        penetration=float(rows["penetration"][-1]),
        mean_residual=float(history["residual"].mean()),
        seconds=float(history["step_seconds"].sum()),
    )


def unrest(rows: Mapping[str, np.ndarray], pressure: float, box: Box) -> Unrest:
    """Measures of motion from the last observed rows, a window and one more; infinite if there are fewer rows."""
    size, d = rows["size"], box.dimension
    if len(size) <= WINDOW:
        return Unrest()
    loads = []
    for k in range(d):
        area = np.prod(np.delete(size, k, axis=1), axis=1)
        force = rows["reactions"][:, 2 * k : 2 * k + 2]
        loaded = slice(1, 2) if k == box.axis else slice(0, 2)
        loads.append(force[:-1, loaded] / (pressure * area[:-1, None]))
    count, diameter = len(box.particles), box.diameter
    return Unrest(
        imbalance=float(np.abs(np.hstack(loads).mean(axis=0) - 1.0).max()),
        volume_change=abs(float(np.prod(size[-1]) / np.prod(size[0])) - 1.0),
        force=float(rows["unbalanced"].mean()) / (pressure * diameter ** (d - 1)),
        kinetic=float(rows["kinetic"].mean()) / (count * pressure * diameter**d),
    )


def inner_solid_fraction(sample: Sample) -> float:
    """Solid fraction in a window one coarsest diameter from all walls."""
    margin = 2.0 * float(sample.radii.max())
    low, high = np.full(sample.dimension, margin), sample.box - margin
    return solid_fraction(sample.positions, sample.radii, (low, high))
