"""A column of sand, with or without wire: poured into a mould, settled, released from it."""

from __future__ import annotations

import itertools
import math
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from lmgcpy.errors import named_arguments, number, shown
from lmgcpy.experiment.box import THREAD
from lmgcpy.experiment.column.sample import SAND_DENSITY, Laid, glued_grains
from lmgcpy.experiment.recorded_run import carry_out
from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.laws.rigid import RigidWire
from lmgcpy.scene.body import Body, wall
from lmgcpy.scene.scene import Scene
from lmgcpy.scene.skin import Thread, point_mass
from lmgcpy.scene.solid import Material
from lmgcpy.simulation import Simulation
from lmgcpy.solve.problems.report import SOLVED
from lmgcpy.solve.sweeps.accelerated import AcceleratedGaussSeidel
from lmgcpy.solve.sweeps.gauss_seidel import GaussSeidel

GRAVITY = 9.81
GRAIN, GROUND, MOULD = "GRAIN", "GROUND", "MOULD"
REST = 1e-3
"""Kinetic energy over weight times mean grain diameter below which a column is at rest, if it stays so for half a
time unit: a mean speed of 4 % of the speed after a fall by a radius, or 7 % of a diameter in that time."""
LEAST, POUR, RELEASE = 2.0, 4.0, 8.0
"""Least duration of a release, and greatest durations of pour and release, in time units."""
COVERED = 0.5
"""Least part of a ring of the ground that grains cover, seen from above, inside the front."""
FRAMES = 16
"""Number of frames of a release of the greatest duration."""


@dataclass(frozen=True)
class ColumnState:
    """Positions and velocities of the n particles of a column, beads or nodes first."""

    positions: np.ndarray
    """Positions [m], (n, 3)."""
    velocities: np.ndarray
    """Velocities [m/s], (n, 3)."""
    spins: np.ndarray
    """Angular velocities [rad/s], (n, 3)."""

    def __repr__(self) -> str:
        return f"<ColumnState of {len(self.positions)} particles>"


@dataclass(frozen=True)
class Course:
    """The record of a pour or a release of s steps."""

    time: np.ndarray
    """Time since its start [s], (s,)."""
    spread: np.ndarray
    """Radii that hold 95 % and 99 % of the grains' mass, and the front [m], (s, 3)."""
    height: np.ndarray
    """Level below which 99 % of the grains' mass lies, and top of the highest grain, over the ground [m], (s, 2)."""
    motion: np.ndarray
    """Kinetic energy over weight times mean grain diameter, (s,)."""
    tension: np.ndarray
    """Greatest and mean tension of the links [N], (s, 2)."""
    residual: np.ndarray
    """Residual of the solver, (s,)."""
    iterations: np.ndarray
    """Number of sweeps, (s,)."""
    status: list[str]
    """Status of the solver after each step."""
    end: ColumnState
    """State of the particles after the last step."""
    at_rest: bool
    """Whether the column came to rest."""
    seconds: float
    """Wall clock time of the steps [s]."""

    @property
    def unconverged(self) -> int:
        """Number of steps that did not reach the tolerance."""
        return sum(word not in SOLVED for word in self.status)

    def __repr__(self) -> str:
        rest = "at rest" if self.at_rest else "still moving"
        return f"<Course of {len(self.time)} steps to t = {self.time[-1] if len(self.time) else 0.0:.3g} s, {rest}>"


class SandColumn:
    """The scene of a column on its rough ground, in its mould or out of it, from a state or as laid.

    The ground is a plane with grains glued to it, out to ``reach`` [m] from the axis: on a bare plane spheres roll for
    ever. Grains, wire and ground have the same ``friction``; the mould is smooth, so that it bears no weight. Beads do not
    spin: free ones would roll, and the wire would slip through the sand as if there were no friction.
    """

    def __init__(
        self, laid: Laid, *, friction: float, reach: float, mould: bool, state: ColumnState | None = None, seed: int = 0
    ):
        if not isinstance(laid, Laid):
            raise TypeError(f"A column is of what lay_column() lays, got {shown(laid)}.")
        sample = laid.sample
        self.laid = laid
        self.grains = slice(sample.bead_count, len(sample.radii))
        self.scene = Scene(dimension=3, gravity=(0.0, 0.0, -GRAVITY))
        start = state or ColumnState(sample.positions, np.zeros_like(sample.positions), np.zeros_like(sample.positions))
        self._add_particles(start)
        self._add_ground(glued_grains(laid.mould, reach, laid.diameter, seed))
        law, particles = Coulomb(friction=friction), [GRAIN, THREAD] if sample.thread else [GRAIN]
        for one, other in itertools.combinations_with_replacement(particles, 2):
            self.scene.see(one, other, law)
        for one in particles:
            self.scene.see(one, GROUND, law)
        if mould:
            self._add_mould(laid.mould.side)
            for one in particles:
                self.scene.see(one, MOULD, Coulomb(friction=0.0))
        self._masses = np.array([body.mass for body in self.scene.bodies[: len(sample.radii)]])
        self._link_count = max(sample.bead_count - 1, 0)

    def _add_particles(self, start: ColumnState) -> None:
        sample, sand = self.laid.sample, Material("sand", density=SAND_DENSITY)
        add = self.scene.add_spheres
        bodies: list[Body] = []
        at, moving, spinning = start.positions, start.velocities, start.spins
        mass, wire = sample.bead_mass, slice(sample.bead_count)
        if sample.thread:
            assert mass is not None
            bodies += [
                self.scene.add(point_mass(position=x, velocity=v, mass=mass))
                for x, v in zip(at[wire], moving[wire], strict=True)
            ]
        for part, material, masses in ((wire, None, mass), (self.grains, sand, None))[sample.thread :]:
            if len(at[part]):
                given = {"velocities": moving[part], "spins": spinning[part], "masses": masses}
                bodies += add(sample.radii[part], at[part], material=material, color=GRAIN, **given)
        for beads, lengths, gaps in zip(sample.chains, sample.link_lengths, sample.link_gaps, strict=True):
            between = np.linalg.norm(np.diff(start.positions[beads], axis=0), axis=1)
            # the tolerance leaves links slightly too long; shortening them in one step would be a shock
            reference = gaps + np.maximum(0.0, between - lengths)
            surface = Thread(float(sample.radii[beads[0]]), color=THREAD) if sample.thread else None
            self.scene.chain(
                [bodies[i] for i in beads],
                RigidWire(),
                reference_gap=reference,
                surface=surface,
                block_spin=not sample.thread,
                settled=True,
            )

    def _add_ground(self, glued: tuple[np.ndarray, np.ndarray]) -> None:
        places, radii = glued
        for grain in self.scene.add_spheres(radii, places, masses=1.0, color=GROUND):
            grain.fix()
        self.scene.add(wall(point=(0.0, 0.0, -0.5 * self.laid.diameter), normal=(0, 0, 1), color=GROUND))

    def _add_mould(self, side: float) -> None:
        for point, normal in (
            ((0, 0, 0), (1, 0, 0)),
            ((side, 0, 0), (-1, 0, 0)),
            ((0, 0, 0), (0, 1, 0)),
            ((0, side, 0), (0, -1, 0)),
        ):
            self.scene.add(wall(point=point, normal=normal, color=MOULD))

    # --------------------------------------------------------------------------------------------------- measurements

    def spread(self, sim: Simulation) -> np.ndarray:
        """Present value of :attr:`Course.spread`."""
        distance = np.linalg.norm(sim.positions[self.grains, :2] - self.laid.mould.axis, axis=1)
        mass = self._masses[self.grains]
        radii = self.laid.sample.radii[self.grains]
        held = [holding(share, distance, mass) for share in (0.95, 0.99)]
        return np.array([*held, front(distance, radii, self.laid.diameter)])

    def height(self, sim: Simulation) -> np.ndarray:
        """Present value of :attr:`Course.height`."""
        z, radii = sim.positions[self.grains, 2], self.laid.sample.radii[self.grains]
        return np.array([holding(0.99, z, self._masses[self.grains]), float((z + radii).max())])

    def motion(self, sim: Simulation) -> float:
        """Present value of :attr:`Course.motion`."""
        speeds = sim.velocities[: len(self._masses)]
        kinetic = 0.5 * float(self._masses @ np.sum(speeds**2, axis=1))
        return kinetic / (float(self._masses.sum()) * GRAVITY * self.laid.diameter)

    def tension(self, sim: Simulation) -> np.ndarray:
        """Present value of :attr:`Course.tension`."""
        pull = -sim.interactions.force[: self._link_count, 0]  # links come first
        return np.array([pull.max(), pull.mean()]) if len(pull) else np.zeros(2)

    def state(self, sim: Simulation) -> ColumnState:
        """State of the particles, copied."""
        n = len(self._masses)
        return ColumnState(sim.positions[:n].copy(), sim.velocities[:n].copy(), sim.spins[:n].copy())

    def __repr__(self) -> str:
        particles, bodies = len(self._masses), len(self.scene.bodies)
        return f"<SandColumn of content {self.laid.content:.3g}: {particles} particles, {bodies} bodies>"


@named_arguments
def let_go(
    column: SandColumn,
    *,
    duration: float,
    least: float = 0.0,
    travel: float = 0.5,
    solver: AcceleratedGaussSeidel | GaussSeidel | None = None,
    frames: int = FRAMES,
    name: str = "column",
    file: str | os.PathLike | None = None,
    on_step: Callable[[int], None] | None = None,
    interrupted: Callable[[], bool] | None = None,
) -> Course:
    """Let a column move until it is at rest, for at least ``least`` [s] and at most ``duration`` [s].

    In one step a grain that has fallen through the whole height moves by ``travel`` radii of a bead. The column is at rest
    if for half a time unit the kinetic energy stays below a thousandth of weight times mean grain diameter. ``frames``:
    number of frames in ``duration``. ``name``: name of the run in its notes. ``file``, ``on_step`` and ``interrupted`` as
    in :func:`lmgcpy.experiment.carry_out`.
    """
    number(duration, "duration", above=0.0, unit="s")
    number(least, "least", minimum=0.0, maximum=duration, unit="s")
    step, window = time_step(column.laid, travel), half_a_unit(column.laid, travel)
    sim = Simulation(
        column.scene,
        time_step=step,
        solver=solver or AcceleratedGaussSeidel(tolerance=1e-2, max_iterations=200),
        on_unconverged="ignore",
        overlap="ignore",  # the tolerance of the pour leaves some
    )
    count = max(1, math.ceil(duration / step))

    def at_rest(rows: Mapping[str, np.ndarray]) -> bool:
        motion = rows["motion"]
        return sim.steps * step >= least and len(motion) >= window and float(motion[-window:].max()) < REST

    with carry_out(
        sim,
        steps=count,
        observe={
            "spread": (column.spread, ["radius of 95 % of the sand [m]", "radius of 99 % of the sand [m]", "front [m]"]),
            "height": (column.height, ["height of 99 % of the sand [m]", "highest grain [m]"]),
            "motion": column.motion,
            "tension": (column.tension, ["greatest tension [N]", "mean tension [N]"]),
        },
        every=max(1, count // frames),
        notes={"experiment": name},
        rule=at_rest,
        window=window,
        file=file,
        on_step=on_step,
        interrupted=interrupted,
    ) as run:
        history, status = run.history[:], run.status.tolist()
        rows = {name: column[:] for name, column in run.observed.items()}
    return Course(
        time=history["time"],
        residual=history["residual"],
        iterations=history["iterations"],
        status=status,
        end=column.state(sim),
        at_rest=at_rest(rows),
        seconds=float(history["step_seconds"].sum()),
        **rows,
    )


def time_unit(laid: Laid) -> float:
    """Time unit sqrt(H/g) [s], H the height of the sand in the mould: the same with wire and without."""
    return math.sqrt(laid.mould.height / GRAVITY)


def time_step(laid: Laid, travel: float) -> float:
    """Time step [s]; see :func:`let_go`."""
    number(travel, "travel", above=0.0, maximum=10.0)
    return travel * laid.bead_radius / math.sqrt(2.0 * GRAVITY * float(laid.sample.box[2]))


def half_a_unit(laid: Laid, travel: float) -> int:
    """Number of steps in half a time unit, over which rest is judged."""
    return max(1, math.ceil(0.5 * time_unit(laid) / time_step(laid, travel)))


# ------------------------------------------------------------------------------------------------- how far it has run out


def holding(share: float, coordinate: np.ndarray, mass: np.ndarray) -> float:
    """Smallest coordinate of a grain [m] up to which a ``share`` of the mass has its centres.

    ``coordinate``: distance from the axis, or height [m], and ``mass`` of the grains, (n,).
    """
    order = np.argsort(coordinate, kind="stable")
    held = np.cumsum(mass[order])
    # round-off of the sum must not ask for more than there is
    return float(coordinate[order][min(np.searchsorted(held, share * held[-1]), len(order) - 1)])


def front(distance: np.ndarray, radii: np.ndarray, ring: float) -> float:
    """Radius [m] out to which the ground is covered without a break.

    The ground is divided into rings of width ``ring`` [m] around the axis. A ring is covered if the cross-sections of the
    grains whose centres lie above it make up half its area; single grains that ran ahead do not count. The front
    lies between the last covered ring and the next, by linear interpolation of their covers. ``distance`` from the axis
    and ``radii`` [m], (n,).
    """
    number = (distance / ring).astype(np.int64)
    count = int(number.max()) + 2
    sections = np.bincount(number, weights=radii**2, minlength=count)
    cover = np.minimum(sections / (ring**2 * (2.0 * np.arange(count) + 1.0)), 1.0)
    first = int(np.argmax(cover < COVERED))  # it exists, as the outermost ring is empty
    if first == 0:
        return 0.0
    inner, outer = cover[first - 1], cover[first]
    return float(ring * (first - 0.5 + (inner - COVERED) / (inner - outer)))


def dry_run_out(aspect: float) -> float:
    """Run-out of dry sand, (front - radius) / radius, for an ``aspect`` height / radius.

    1.24 a up to a = 1.7 and 1.6 sqrt(a) beyond, measured on round columns of several materials on several grounds (Lube,
    Huppert, Sparks, Hallworth 2004, J. Fluid Mech. 508, 175-199).
    """
    return 1.24 * aspect if aspect < 1.7 else 1.6 * aspect**0.5
