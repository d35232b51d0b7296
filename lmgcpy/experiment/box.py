"""A sample in its box, in 2D and 3D: two walls across each axis, platens across one and lateral walls across the others."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from lmgcpy.errors import AXES, flag, named_arguments, number, numbers, shown, whole
from lmgcpy.io.rows import Observe, entries
from lmgcpy.laws import Law
from lmgcpy.laws.coulomb import Coulomb
from lmgcpy.measure.contacts import network
from lmgcpy.sample.arguments import spheres
from lmgcpy.sample.fibres import join_segments
from lmgcpy.scene.body import Body, RigidBody, Wall, wall
from lmgcpy.scene.body_3d import Capsule, body_volume, capsule_volume, placed
from lmgcpy.scene.scene import Scene
from lmgcpy.scene.skin import Thread, point_mass
from lmgcpy.scene.solid import Material
from lmgcpy.solve.sweeps.accelerated import AcceleratedGaussSeidel
from lmgcpy.solve.sweeps.solver import MOST_FORCE

if TYPE_CHECKING:
    from lmgcpy.simulation import Simulation

GRAIN, THREAD, PLATEN, LATERAL = "GRAIN", "THREAD", "PLATEN", "LATERAL"


@named_arguments
@dataclass(frozen=True)
class Sample:
    """Particles in a box that starts at the origin, in d dimensions; the first of them are the beads of wires.

    ``positions`` and ``radii`` are those of beads, disks and spheres, n of them."""

    positions: np.ndarray
    """[m], (n, d)."""
    radii: np.ndarray
    """[m], (n,)."""
    wires: tuple[int, ...]
    """Number of beads of each wire, wire after wire; empty for sand alone."""
    reference_gap: Any
    """Greatest gap between consecutive beads [m]: a number, or a number for each link of all wires."""
    box: np.ndarray
    """Sizes of the box [m], (d,)."""
    bead_mass: float | None = None
    """Mass of a bead [kg]; None: the mass of a grain of its size."""
    bodies: Sequence[Body] = ()
    """Clumps and capsules in their places, in 3D, which come after the beads and spheres; each keeps its own mass."""
    segments: int = 1
    """Number of capsules that ball joints join to one fibre, one after another among the ``bodies``."""
    thread: bool = False
    """Whether the wires are smooth threads: what is said of beads holds for nodes, points that have a mass and no shape.
    Their ``radii`` are the radius of the surface between them, and ``reference_gap`` is their greatest distance."""

    def __post_init__(self):
        box = numbers(self.box, "box of the sample", "its 2 or 3 sizes [m]")
        if box.shape not in ((2,), (3,)):
            raise ValueError(f"box of the sample must be its 2 or 3 sizes [m], got {shown(self.box)}.")
        positions, radii = spheres(self.positions, self.radii, len(box), "the sample")
        for axis, size in zip(AXES, box, strict=False):
            number(size, f"size of the box of the sample along {axis}", above=0.0, unit="m")
        if not isinstance(self.wires, (tuple, list)):
            raise TypeError(f"wires of the sample must be a tuple, the beads of each, got {shown(self.wires)}.")
        wires = tuple(whole(beads, "beads of one of the wires of the sample", minimum=2) for beads in self.wires)
        whole(sum(wires), "beads of all wires of the sample", maximum=len(radii))
        gaps, links = numbers(self.reference_gap, "reference_gap of the sample"), sum(wires) - len(wires)
        if gaps.shape not in ((), (links,)):
            wanted = f"a number, or one for each of its {links} links"
            raise ValueError(f"reference_gap of the sample must be {wanted}, got {shown(self.reference_gap)}.")
        if self.bead_mass is not None:
            number(self.bead_mass, "bead_mass of the sample", above=0.0, unit="kg")
        if not isinstance(self.bodies, (tuple, list)) or not all(isinstance(body, RigidBody) for body in self.bodies):
            raise TypeError(f"bodies of the sample must be a list of clumps and capsules, got {shown(self.bodies)}.")
        if self.bodies and len(box) == 2:
            raise ValueError("bodies of the sample turn in space, and its box has two sizes: give it three.")
        whole(self.segments, "segments of the fibres of the sample", minimum=1)
        if len(self.capsules) % self.segments:
            given = f"segments of the fibres of the sample is {self.segments}"
            raise ValueError(f"{given}: it does not divide {len(self.capsules)} capsules.")
        if flag(self.thread, "thread of the sample") and len(box) == 2:
            raise ValueError("thread of the sample is a smooth wire in space, and its box has two sizes: give it three.")
        kept = {"positions": positions, "radii": radii, "wires": wires, "box": box, "bodies": tuple(self.bodies)}
        for name, value in kept.items():
            object.__setattr__(self, name, value)

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return len(self.box)

    @property
    def capsules(self) -> list[Capsule]:
        """The capsules among the bodies."""
        return [body for body in self.bodies if isinstance(body, Capsule)]

    @property
    def bead_count(self) -> int:
        """Number of beads of all wires."""
        return sum(self.wires)

    @property
    def chains(self) -> list[np.ndarray]:
        """Indices of the beads of each wire, in the order of the wire."""
        ends = np.cumsum(self.wires, dtype=np.int64)
        return [np.arange(end - beads, end) for end, beads in zip(ends, self.wires, strict=True)]

    @property
    def width(self) -> float:
        """Size of the box along x [m]."""
        return float(self.box[0])

    @property
    def height(self) -> float:
        """Size of the box along its last axis [m]."""
        return float(self.box[-1])

    @property
    def diameter(self) -> float:
        """Mean diameter of the particles [m], of a clump that of a sphere of its volume.

        Beads finer than every grain do not count, as they lie in the pores, and fibres count only if there are no grains.
        """
        clumps = [body_volume(body) for body in self.bodies if not isinstance(body, Capsule)]
        grains = np.append(self.radii[self.bead_count :], np.cbrt(0.75 / np.pi * np.array(clumps)))
        if not len(grains) and self.bodies:
            return 2.0 * float(np.cbrt(0.75 / np.pi * np.mean([body_volume(body) for body in self.bodies])))
        beads = self.radii[: self.bead_count]
        fine = len(grains) and (self.thread or beads.max(initial=0.0) < grains.min())
        return 2.0 * float((grains if fine else np.append(beads, grains)).mean())

    @property
    def link_gaps(self) -> list[np.ndarray]:
        """The reference gap of each link [m], wire by wire."""
        counts = [beads - 1 for beads in self.wires]
        gaps = np.broadcast_to(np.asarray(self.reference_gap, dtype=float), (sum(counts),))
        return np.split(gaps, np.cumsum(counts)[:-1]) if counts else []

    @property
    def link_lengths(self) -> list[np.ndarray]:
        """Greatest distance of the centres of consecutive beads [m], wire by wire."""
        thick = [0.0 if self.thread else self.radii[chain[1:]] + self.radii[chain[:-1]] for chain in self.chains]
        return [gaps + radii for gaps, radii in zip(self.link_gaps, thick, strict=True)]

    @property
    def wire_length(self) -> float:
        """Length of all wires, drawn taut [m]."""
        return float(sum(lengths.sum() for lengths in self.link_lengths))

    @property
    def solid_volume(self) -> float:
        """Volume of all particles [m^3], in 2D per metre of depth; what balls of a clump share counts once, and so do the
        ends of capsules in a straight fibre."""
        own = np.pi * self.radii**2 if self.dimension == 2 else 4.0 / 3.0 * np.pi * self.radii**3
        if self.thread and self.wires:  # a cylinder
            own[: self.bead_count] = np.pi * self.radii[0] ** 2 * self.wire_length / self.bead_count
        joined = (1.0 - 1.0 / self.segments) * sum(capsule_volume(body.radius, 0.0) for body in self.capsules)
        return float(own.sum()) + sum(body_volume(body) for body in self.bodies) - joined

    def __repr__(self) -> str:
        of = "one wire" if len(self.wires) == 1 else f"{len(self.wires)} wires"
        what = "nodes" if self.thread else "beads"
        wires = f", {self.bead_count} of them {what} of {of}" if self.wires else ""
        box = " x ".join(f"{size:.3g}" for size in self.box)
        count = len(self.radii) + len(self.bodies)
        fibres = len(self.capsules) // self.segments
        fibrous = f", {fibres} of them fibres" if fibres else ""
        count -= fibres * (self.segments - 1)
        return f"<Sample in {self.dimension}D: {count} particles{wires}{fibrous}, in a box of {box} m>"


def half_axis(capsule: Body) -> np.ndarray:
    """Vector from the centre of a capsule to the centre of its upper end [m], (3,)."""
    assert isinstance(capsule, Capsule)
    return capsule.rotation.apply((0.0, 0.0, 0.5 * capsule.length))


class SampleScene:
    """A sample as a scene without gravity, and what is measured of it; the base of :class:`Box` and of a periodic cell."""

    bead_count = 0
    """Number of beads; they come first."""
    nodes = 0
    """Number of beads that are nodes of a thread."""

    def __init__(self, sample: Any):
        self.dimension, self.diameter = sample.dimension, sample.diameter
        self.scene = Scene(dimension=sample.dimension)
        self.particles: list = []

    def add_particles(self, radii: np.ndarray, positions: np.ndarray, density: float, masses: float | None = None) -> None:
        """Add particles to the scene."""
        add = self.scene.add_disks if self.dimension == 2 else self.scene.add_spheres
        self.particles += add(radii, positions, material=Material("sand", density=density), color=GRAIN, masses=masses)

    def penetration(self, sim: Simulation) -> float:
        """Deepest overlap at a contact in the last step [m]."""
        net = sim.interactions
        return max(0.0, -float(net.gap[net.law == Coulomb.NAME].min(initial=0.0)))

    def unbalanced(self, sim: Simulation) -> float:
        """Mean over the particles, nodes left out, of the resultant force of their interactions [N]."""
        # a contact on a thread names its nearest node, and moves others, too
        net, count = sim.interactions, len(sim.positions)
        force = np.einsum("mk,mkd->md", net.force, net.frame)
        resultant = [np.bincount(net.candidate, f, count) - np.bincount(net.antagonist, f, count) for f in force.T]
        return float(np.linalg.norm(resultant, axis=0)[self.nodes : len(self.particles)].mean())

    def network(self, sim: Simulation) -> np.ndarray:
        """Contact network of the last step: coordination, share of rattlers among the grains, fabric, (2 + d^2,).

        Beads are held by their wire and do not count as rattlers.
        """
        net = network(sim)
        grains = len(self.particles) - self.bead_count
        loose = int((net.rattlers >= self.bead_count).sum())
        return np.array([net.coordination, loose / max(1, grains), *net.fabric.ravel()])

    @property
    def network_names(self) -> list[str]:
        """Names of the numbers of :meth:`network`."""
        return ["coordination", "share of rattlers", *entries("fabric", self.dimension, "")]


class Box(SampleScene):
    """The scene of a sample in its box, without gravity; the caller sets the boundary conditions.

    The platens stand across ``axis``, by default the last one. ``friction`` acts between particles, ``platen_friction`` at
    the platens; the lateral walls are smooth. ``wire_friction`` acts on a thread: against grains and against itself, by
    default ``friction``. ``law`` links the beads of each wire; if None, beads are grains like the others, and a thread is
    left out. ``reference_gap``: "wire" takes the sample's reference gap, or the present gap if a link is longer; "built"
    takes the present gaps. ``block_spin`` keeps linked beads from rolling; beads that can roll do, and the wire slips
    through the sand as if there were no friction. The mass of a wall is a tenth of the mass of the sample.
    """

    def __init__(
        self,
        sample: Sample,
        *,
        density: float,
        friction: float,
        platen_friction: float = 0.0,
        wire_friction: tuple[float, float] | None = None,
        law: Law | None = None,
        reference_gap: str = "wire",
        block_spin: bool = False,
        axis: int | None = None,
    ):
        if not isinstance(sample, Sample):
            raise TypeError(f"A box is for a Sample, such as lay_sample() makes, got {shown(sample)}.")
        pair = _friction_of_wire(wire_friction, sample.thread, friction)
        super().__init__(sample)
        d = self.dimension
        self.axis = d - 1 if axis is None else axis
        self.lateral = [k for k in range(d) if k != self.axis]
        """Axes across which the lateral walls stand."""
        beads = sample.bead_count
        if not sample.thread:
            self.bead_count = beads
            self.add_particles(sample.radii[:beads], sample.positions[:beads], density, sample.bead_mass)
        elif law is not None:
            self.bead_count = self.nodes = beads
            mass = sample.bead_mass
            if mass is None:
                mass = density * np.pi * float(sample.radii[0]) ** 2 * sample.wire_length / beads
            self.particles += [self.scene.add(point_mass(position=x, mass=mass)) for x in sample.positions[:beads]]
        self.add_particles(sample.radii[beads:], sample.positions[beads:], density)
        for body in sample.bodies:
            twin = placed(body, body.position)
            twin.color = GRAIN
            self.particles.append(self.scene.add(twin))
        if sample.segments > 1:
            join_segments(self.scene, [body for body in self.particles if isinstance(body, Capsule)], sample.segments)
        self.mass = sum(particle.mass for particle in self.particles)
        self.walls: list[tuple[Wall, Wall]] = [None] * d  # type: ignore[list-item]
        """The lower and the upper wall across each axis."""
        for k in (self.axis, *self.lateral):
            self.walls[k] = self._add_walls(k, float(sample.box[k]), PLATEN if k == self.axis else LATERAL)
        self.scene.see(GRAIN, GRAIN, Coulomb(friction=friction))
        self.scene.see(GRAIN, PLATEN, Coulomb(friction=platen_friction))
        self.scene.see(GRAIN, LATERAL, Coulomb(friction=0.0))
        if self.nodes:
            against_grains, against_itself = pair
            self.scene.see(GRAIN, THREAD, Coulomb(friction=against_grains))
            self.scene.see(THREAD, THREAD, Coulomb(friction=against_itself))
            self.scene.see(THREAD, PLATEN, Coulomb(friction=platen_friction))
            self.scene.see(THREAD, LATERAL, Coulomb(friction=0.0))
        if law is not None:
            if not sample.wires:
                raise ValueError("A law links the beads of a wire, this sample has none: give law=None.")
            self._link(sample, law, reference_gap, block_spin)

    def _add_walls(self, axis: int, size: float, color: str) -> tuple[Wall, Wall]:
        normal = np.eye(self.dimension)[axis]
        share = 0.1 * self.mass
        low = self.scene.add(wall(point=np.zeros(self.dimension), normal=normal, color=color, mass=share))
        return low, self.scene.add(wall(point=size * normal, normal=-normal, color=color, mass=share))

    def _link(self, sample: Sample, law: Law, reference_gap: str, block_spin: bool) -> None:
        for chain, gaps in zip(sample.chains, sample.link_gaps, strict=True):
            beads, radii = sample.positions[chain], sample.radii[chain]
            built = np.linalg.norm(np.diff(beads, axis=0), axis=1)
            if not sample.thread:
                built -= radii[1:] + radii[:-1]
            # a relaxed wire is longer than its reference by an error within the solver's tolerance
            reference = built if reference_gap == "built" else np.maximum(gaps, built)
            members = [self.particles[bead] for bead in chain]
            surface = Thread(float(radii[0]), color=THREAD) if sample.thread else None
            held = block_spin and not sample.thread  # nodes do not turn
            self.scene.chain(
                members, law, reference_gap=reference, surface=surface, block_spin=held, settled=sample.thread
            )

    # ------------------------------------------------------------------------------------------------------- the walls

    @property
    def sizes(self) -> np.ndarray:
        """Present distances of opposite walls [m], (d,)."""
        return np.array([high.position[k] - low.position[k] for k, (low, high) in enumerate(self.walls)])

    def area(self, axis: int) -> float:
        """Present area of a wall across the axis [m^2], in 2D its length [m]."""
        return float(np.prod(np.delete(self.sizes, axis)))

    def load_laterally(self, pressure: float) -> None:
        """Press the lateral walls inward by ``pressure`` [Pa] on their present area."""
        for k in self.lateral:
            low, high = self.walls[k]
            self._load(low, k, pressure)
            self._load(high, k, -pressure)

    def load_top(self, pressure: float) -> None:
        """Press the upper platen down by ``pressure`` [Pa] on its present area."""
        self._load(self.walls[self.axis][1], self.axis, -pressure)

    def press(self, pressure: float) -> None:
        """Press lateral walls and upper platen by ``pressure`` [Pa]."""
        self.load_laterally(pressure)
        self.load_top(pressure)

    def drive_top(self, speed: Callable[[float], float]) -> None:
        """Move the upper platen down at a ``speed`` [m/s], a function of time [s]."""
        self.walls[self.axis][1].impose_velocity(**{AXES[self.axis]: lambda time: -speed(time)})

    def _load(self, wall: Wall, axis: int, pressure: float) -> None:
        wall.impose_force(**{AXES[axis]: lambda time: pressure * self.area(axis)})

    # ------------------------------------------------------------------------------------------------ what is observed

    def reactions(self, sim: Simulation) -> np.ndarray:
        """Normal force with which the particles push each wall outward in the last step [N], (2 d,): the lower and the
        upper wall across x, then across y …"""
        net = sim.interactions
        return np.array([net.force[net.antagonist == wall.id, 0].sum() for pair in self.walls for wall in pair])

    def size(self, sim: Simulation) -> np.ndarray:
        """Present sizes of the box [m], (d,)."""
        return self.sizes

    def observed(self) -> Observe:
        """The quantities that a compaction records at every step."""
        return {
            "reactions": (self.reactions, self.reaction_names),
            "size": (self.size, self.size_names),
            "penetration": (self.penetration, "m"),
            "unbalanced": (self.unbalanced, "N"),
            "kinetic": (lambda sim: sim.energy.kinetic, "J"),
            "network": (self.network, self.network_names),
        }

    @property
    def reaction_names(self) -> list[str]:
        """Names of the numbers of :meth:`reactions`."""
        return [f"reaction_{axis}_{side} [N]" for axis in AXES[: self.dimension] for side in ("lower", "upper")]

    @property
    def size_names(self) -> list[str]:
        """Names of the numbers of :meth:`size`."""
        return [f"size_{axis} [m]" for axis in AXES[: self.dimension]]

    def pressures(self, rows: Mapping[str, np.ndarray]) -> np.ndarray:
        """Recorded forces on the walls over their recorded area [Pa], (s, d, 2): lower and upper wall across each axis."""
        size = rows["size"]
        area = np.stack([np.prod(np.delete(size, k, axis=1), axis=1) for k in range(self.dimension)], axis=1)
        return rows["reactions"].reshape(-1, self.dimension, 2) / area[:, :, None]

    def mean_stress(self, rows: Mapping[str, np.ndarray]) -> np.ndarray:
        """Mean pressures on the loaded walls of recorded rows, as a stress [Pa], (d, d), traction positive."""
        mean = self.pressures(rows).mean(axis=0)
        return -np.diag([mean[k, 1] if k == self.axis else mean[k].mean() for k in range(self.dimension)])

    def sample(self, before: Sample) -> Sample:
        """The sample in its present state, moved so that its box starts at the origin."""
        origin = np.array([low.position[k] for k, (low, _) in enumerate(self.walls)])
        spheres, turning = self.particles[: len(before.radii)], self.particles[len(before.radii) :]
        positions = np.array([particle.position for particle in spheres]).reshape(-1, self.dimension) - origin
        bodies = [placed(body, body.position - origin) for body in turning]
        if before.segments > 1:  # joints are open by the errors of a step, which a scene refuses
            capsules = [k for k, body in enumerate(bodies) if isinstance(body, Capsule)]
            for j, (k, following) in enumerate(itertools.pairwise(capsules), start=1):
                if j % before.segments:
                    one, other = bodies[k], bodies[following]
                    end, start = (body.position + sign * half_axis(body) for body, sign in ((one, 1.0), (other, -1.0)))
                    bodies[following] = placed(other, other.position + (end - start))
        return replace(before, positions=positions, box=self.sizes, bodies=bodies)


def _friction_of_wire(given: Any, thread: bool, friction: float) -> tuple[float, float]:
    """Coefficients of friction of a thread, against grains and against itself."""
    pair = wire_frictions(given)
    if pair is not None and not thread:
        raise ValueError("wire_friction is the friction of a smooth thread; beads have the friction of the grains.")
    return (friction, friction) if pair is None else pair


def wire_frictions(given: Any) -> tuple[float, float] | None:
    """Two coefficients of friction as the user gives them, or None."""
    if given is None:
        return None
    pair = numbers(given, "wire_friction", "two numbers, against grains and against itself")
    if pair.shape != (2,):
        raise ValueError(f"wire_friction must be two numbers, against grains and against itself, got {shown(given)}.")
    return number(pair[0], "wire_friction", minimum=0.0), number(pair[1], "wire_friction", minimum=0.0)


def characteristic_time(diameter: float, density: float, pressure: float) -> float:
    """``d sqrt(rho/p)``: the time in which the pressure moves a grain by its size [s]."""
    return float(diameter * np.sqrt(density / pressure))


FORCE = 1e-3
"""Error of a force, in parts of the load of its bodies, up to which the steps of a compaction are solved.

In steps of a fifth of ``d sqrt(rho/p)`` an error f of the force ``p d^2`` of a contact makes two spheres overlap by about
``2 h^2 p f / (pi rho d / 6) = 0.15 f d`` more in each step, and contact laws do not take that back. So errors add up over a
test, while the platen moves by ``0.2 I d`` a step for each layer of grains, I the inertial number: f is to be no more than
I. The residual does not see this in small samples: it is relative to what the loads of the walls would do, and in a small
sample these loads are a large part of all forces (docs/step_and_tolerance.md)."""


MOMENTUM = {2: AcceleratedGaussSeidel.momentum, 3: 0.9}
"""Bound of the momentum of sweeps by dimension.

In space steps may stall with the solver's own 0.97: the steps of a test of 2000 spheres take 140 sweeps with 0.9, and 1082
with 0.97, as three of 51 are not solved in 20 000. With a taut wire they stall at a residual of 0.05."""


def usual_solver(
    dimension: int, tolerance: float = 1e-2, force: float = FORCE, max_iterations: int = 20_000
) -> AcceleratedGaussSeidel:
    """The solver of compactions and tests, unless another is given."""
    return AcceleratedGaussSeidel(
        tolerance=tolerance,
        force=min(force, MOST_FORCE),
        max_iterations=max_iterations,
        momentum=MOMENTUM[dimension],
    )
