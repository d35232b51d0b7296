"""Isotropic compaction of a sample in a box or in a periodic cell: the relaxation that tightens grains around a wire."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.errors import named_arguments, number, shown, whole
from lmgcpy.experiment.box import Box, Sample, characteristic_time, usual_solver
from lmgcpy.experiment.periodic import PeriodicCell, PeriodicSample
from lmgcpy.experiment.recorded_run import carry_out
from lmgcpy.laws.rigid import RigidWire
from lmgcpy.measure.density import density as solid_fraction
from lmgcpy.simulation import Simulation
from lmgcpy.solve.problems.report import SOLVED, Report
from lmgcpy.solve.sweeps.solver import Solver

WINDOW = 50
"""Number of steps over which rest is judged."""
HEAVY = 4.0
"""Inertia of a cell in its compaction over the usual one: with that, loose grains move by more than half a radius in a
step."""


@dataclass(frozen=True)
class Defaults:
    """Options of a compaction that the user does not give."""

    experiment: str
    """Its name in the run file."""
    drag: float
    step: float
    """Time step over ``d sqrt(rho/p)``."""
    tolerance: float
    max_steps: int


DEFAULTS = {
    Box: Defaults("compaction", drag=0.0, step=0.2, tolerance=1e-2, max_steps=800),
    PeriodicCell: Defaults("periodic compaction", drag=0.3, step=0.1, tolerance=1e-3, max_steps=2000),
}


@dataclass(frozen=True)
class Unrest:
    """Four measures of motion over a window of steps; all are small at rest."""

    imbalance: float = np.inf
    """In a box the mean of ``|force on a wall / (pressure x its area) - 1|``, the worst of the loaded walls; in a cell the
    largest component of mean Weber stress less imposed stress, over the pressure."""
    volume_change: float = np.inf
    """Relative change of the volume."""
    force: float = np.inf
    """Mean resultant force on a particle, over p d^(D-1), the force of the pressure on a particle."""
    kinetic: float = np.inf
    """Mean kinetic energy of a particle, over p d^D, the work of the pressure on its volume."""
    balanced: float = 0.02
    """Bound of the imbalance: 0.02 in a box, 0.001 in a cell."""

    @property
    def is_rest(self) -> bool:
        """Whether each is below its bound."""
        return self.imbalance < self.balanced and self.volume_change < 3e-4 and self.force < 0.02 and self.kinetic < 1e-4


@dataclass(frozen=True)
class Compaction:
    """A compacted sample in d dimensions and how it came to rest; means are over the last 50 steps."""

    sample: Any
    """The compacted sample, of the kind that was given."""
    steps: int
    """Number of steps made."""
    at_rest: bool
    """Whether the sample came to rest within them."""
    unrest: Unrest
    """Measures of motion over the last 50 steps."""
    stress: np.ndarray
    """Mean stress [Pa], (d, d), traction positive: Weber's of a cell, the pressures on the loaded walls of a box."""
    solid_fraction: float
    """Of a box in a window one coarsest diameter from the walls; of a cell, or a box with clumps or fibres, as a whole."""
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
    unconverged: int
    """Number of steps that did not reach the tolerance."""
    seconds: float
    """Wall clock time of the steps [s]."""

    def __repr__(self) -> str:
        rest = "at rest" if self.at_rest else "not at rest"
        return f"<Compaction in {self.steps} steps, {rest}, solid fraction {self.solid_fraction:.3f}: {self.sample!r}>"


@named_arguments
def compact(
    sample: Sample | PeriodicSample,
    *,
    pressure: float,
    density: float = 2600.0,
    friction: float = 0.0,
    wire_friction: tuple[float, float] | None = None,
    drag: float | None = None,
    time_step: float | None = None,
    solver: Solver | None = None,
    max_steps: int | None = None,
    file: str | os.PathLike | None = None,
    on_step: Callable[[int], None] | None = None,
    interrupted: Callable[[], bool] | None = None,
) -> Compaction:
    """Press a sample from all sides by ``pressure`` [Pa] until it is at rest.

    The lateral walls and the lid of its box are pressed, or the edges of its periodic cell.

    It is at rest if, over 50 steps (D dimensions, p the pressure, d the mean diameter),

    * the mean force on each loaded wall differs from its load by less than 2 %, or in a cell each component of the mean
      Weber stress from the imposed stress by less than 0.1 % of the pressure;
    * the volume changes by less than 3e-4;
    * the mean resultant force on a particle is below 2 % of ``p d^(D-1)``;
    * the mean kinetic energy of a particle is below 1e-4 ``p d^D``.

    Without ``friction`` the sample becomes as dense as its grains allow; the wire is inextensible, and ``wire_friction`` is
    the friction of a thread as in a test. A cell yields in size
    and in shape, so that its stress becomes isotropic; the edge x keeps its direction, and the plane of x and y, so that
    the cell does not turn.

    With rigid grains the pressure alone sets the time scale ``d sqrt(rho/p)``. ``time_step`` [s] is by default a fifth of
    it in a box, a tenth in a cell. ``drag``: velocities decay by ``exp(-drag)`` in that time, by default 0 in a box and 0.3
    in a cell; without it, grains that are squeezed out hammer a wire of fine beads, which has no bending stiffness, until
    it is crumpled. ``max_steps`` is by default 800 in a box and 2000 in a cell.

    ``file``, ``on_step`` and ``interrupted`` as in :func:`lmgcpy.experiment.carry_out`.
    """
    number(pressure, "pressure", above=0.0, unit="Pa")
    number(friction, "friction", minimum=0.0)
    held = _held(sample, density, friction, wire_friction)
    held.press(pressure)
    usual = DEFAULTS[type(held)]
    steps = usual.max_steps if max_steps is None else whole(max_steps, "max_steps", minimum=1)
    drag = usual.drag if drag is None else number(drag, "drag", minimum=0.0)
    moment = characteristic_time(sample.diameter, density, pressure)
    options: dict[str, Any] = {
        "time_step": usual.step * moment if time_step is None else number(time_step, "time_step", above=0.0, unit="s"),
        "solver": solver or usual_solver(sample.dimension, usual.tolerance, max_iterations=5000),
        "on_unconverged": "ignore",
    }
    if drag > 0.0:
        sim: Simulation = DampedSimulation(held.scene, drag_time=moment / drag, **options)
    else:
        sim = Simulation(held.scene, **options)

    with carry_out(
        sim,
        steps=steps,
        observe=held.observed(),
        every=WINDOW,
        notes={"experiment": usual.experiment, "pressure": pressure, "drag": drag},
        rule=lambda rows: unrest(rows, pressure, held).is_rest,
        window=WINDOW + 1,
        file=file,
        on_step=on_step,
        interrupted=interrupted,
    ) as run:
        history = run.history[:]
        rows = {name: column[-WINDOW - 1 :] for name, column in run.observed.items()}
        unconverged = sum(word not in SOLVED for word in run.status)
    left = unrest(rows, pressure, held)
    coordination, rattlers, *fabric = rows["network"][-1]
    done: Any = held.sample(sample) if isinstance(sample, Sample) and isinstance(held, Box) else held.sample
    return Compaction(
        sample=done,
        steps=len(history),
        at_rest=left.is_rest,
        unrest=left,
        stress=held.mean_stress({name: column[-WINDOW:] for name, column in rows.items()}),
        solid_fraction=inner_solid_fraction(done) if isinstance(done, Sample) else done.solid_fraction,
        coordination=float(coordination),
        rattlers=float(rattlers),
        fabric=np.reshape(fabric, (sample.dimension, sample.dimension)),
        penetration=float(rows["penetration"][-1]),
        mean_residual=float(history["residual"].mean()),
        unconverged=unconverged,
        seconds=float(history["step_seconds"].sum()),
    )


def _held(sample: Any, density: float, friction: float, wire_friction: Any) -> Box | PeriodicCell:
    """The scene of a sample: its box, or its cell."""
    if isinstance(sample, PeriodicSample):
        if wire_friction is not None:
            raise ValueError("wire_friction is the friction of a smooth thread; a PeriodicSample has none.")
        return PeriodicCell(sample, density=density, friction=friction, heavy=HEAVY)
    if isinstance(sample, Sample):
        law = RigidWire() if sample.wires else None
        return Box(sample, density=density, friction=friction, wire_friction=wire_friction, law=law)
    raise TypeError(
        f"compact takes a Sample, as lay_sample() makes it, or a PeriodicSample of lay_periodic(), got {shown(sample)}."
    )


def unrest(rows: Mapping[str, np.ndarray], pressure: float, held: Box | PeriodicCell) -> Unrest:
    """Measures of motion from the last observed rows, a window and one more; infinite if there are fewer rows."""
    rows = {name: values[-WINDOW - 1 :] for name, values in rows.items()}
    if len(rows["unbalanced"]) <= WINDOW:
        return Unrest()
    d, count, diameter = held.dimension, len(held.particles), held.diameter
    if isinstance(held, Box):
        volume, first = np.prod(rows["size"], axis=1), 0
        loaded = [held.pressures(rows)[:-1, k, int(k == held.axis) :] / pressure for k in range(d)]  # all but the floor
        imbalance, balanced = np.abs(np.hstack(loaded).mean(axis=0) - 1.0).max(), Unrest.balanced
    else:
        volume, first = rows["volume"], 1
        imbalance, balanced = np.abs(rows["stress"][1:].mean(axis=0) / pressure + np.eye(d)).max(), 0.001
    return Unrest(
        imbalance=float(imbalance),
        volume_change=abs(float(volume[-1] / volume[0]) - 1.0),
        force=float(rows["unbalanced"][first:].mean()) / (pressure * diameter ** (d - 1)),
        kinetic=float(rows["kinetic"][first:].mean()) / (count * pressure * diameter**d),
        balanced=balanced,
    )


def inner_solid_fraction(sample: Sample) -> float:
    """Solid fraction in a window one coarsest diameter from all walls; of the whole box if there are clumps or fibres."""
    if sample.bodies:
        return sample.solid_volume / float(np.prod(sample.box))
    margin = 2.0 * float(sample.radii.max())
    low, high = np.full(sample.dimension, margin), sample.box - margin
    return solid_fraction(sample.positions, sample.radii, (low, high))


class DampedSimulation(Simulation):
    """Before every step all velocities decay by ``exp(-h / drag_time)``: the exact answer to a drag ``-(m / drag_time) v``.

    The drag does not act within the step, so that it does not change impulses at rest. ``drag_time`` [s].
    """

    _kept = 1.0
    """Part of the velocities that is left after a step."""

    def __init__(self, scene, *, drag_time: float, **options):
        super().__init__(scene, **options)
        self._kept = math.exp(-self.time_step / drag_time)

    def step(self) -> Report:
        """Make one step, see :meth:`lmgcpy.Simulation.step`."""
        before, steps = self.state.velocities.copy(), self.steps
        self.state.velocities *= self._kept
        try:
            return super().step()
        except BaseException:
            if self.steps == steps:  # else the step was made, and the error is about its result
                self.state.velocities[:] = before
            raise
