"""Hard cases of wires: thrown taut, stiff and soft, drawn over a drum, swung for long."""

from __future__ import annotations

import math

import numpy as np
from case import Number, Result, Watch, worst_of

import lmgcpy as lm


class Lengths:
    """The links of a chain from detection to detection.

    From one detection to the next positions move by h v, whatever theta. A taut link of reference length l0 between
    centres has (l + h u_n) = l0 in the linear prediction, and what it turns comes on top by Pythagoras:

        l'^2 = (l + h u_n)^2 + (h u_t)^2 <= l0^2 + (h u_t)^2,    l' - l0 <= (h u_t)^2 / (2 l0),

    u_t being the velocity across the link: second order in h, whatever came before. ``excess``: the largest length
    beyond the root of that, in l0: an error of the solver, not of the scheme; ``stretch``: the largest l'/l0 - 1, which is
    the scheme's. ``first`` and ``last``: ids of the chain's bodies.
    """

    def __init__(self, sim: lm.Simulation, first: int, last: int, length: np.ndarray | float):
        self.sim, self.ids, self.length = sim, slice(first, last + 1), length
        self.excess = self.stretch = -math.inf
        self.predicted = self._vectors()

    def _vectors(self) -> np.ndarray:
        """Along the links at the next detection, (links, d) [m]."""
        sim = self.sim
        ahead = sim.positions[self.ids] + (1.0 - sim.theta) * sim.time_step * sim.velocities[self.ids]
        return np.diff(ahead, axis=0)

    def enter(self) -> None:
        """A step was made."""
        now = self._vectors()
        before = np.linalg.norm(self.predicted, axis=1)
        move = now - self.predicted
        along = np.einsum("id,id->i", move, self.predicted) / before
        across = np.maximum(np.einsum("id,id->i", move, move) - along**2, 0.0)
        lengths = np.linalg.norm(now, axis=1)
        self.excess = max(self.excess, float(((lengths - np.sqrt(self.length**2 + across)) / self.length).max()))
        self.stretch = max(self.stretch, float((lengths / self.length).max() - 1.0))
        self.predicted = now


def momenta(sim: lm.Simulation) -> np.ndarray:
    """Linear and angular momentum about the origin, of the motion of the centres."""
    mass = sim.model.mass[:, :1]
    x, p = sim.positions, mass * sim.velocities
    angular = np.atleast_1d(np.cross(x, p).sum(axis=0)) if x.shape[1] == 3 else [x[:, 0] @ p[:, 1] - x[:, 1] @ p[:, 0]]
    return np.concatenate([p.sum(axis=0), angular])


def thrown(solver, long: bool) -> Result:
    """A rigid wire of 1000 beads, wound to a helix, free in space, is thrown by a tip of a million beads' mass.

    Hard: W spans six orders of magnitude, and the blow of the tip must cross a thousand links within one step; one
    link at a time this takes some n^2 sweeps, and a tension that has not arrived lets the wire grow. Numbers: linear
    momentum, relative to the tip's, to 1e-10, as the impulses of a link are opposite; angular momentum to 1e-6: where the
    wire is taut it has geometric stiffness, whose impulses across links are couples, ``sum kappa l^2 (omega+ - omega)``,
    with ``sum kappa l^2 <= h^2 T L``, (h omega)^2 = 1e-5 of the moment of inertia of the tip, which makes T, at 3 rad/s;
    what it takes up with the tension it gives back with it, up to a tenth; no link longer than Pythagoras allows (see
    ``Lengths``) by more than 1e-8 of it; and that it did come taut: less than 1 % between its ends and its length.
    """
    count, spacing, slack, radius = 1000, 0.01, 0.03, 0.1
    # chords of a helix: 2 radius sin(turn/2) round and the rest along
    turn = 2.0 * math.asin(spacing * math.sqrt(1.0 - (1.0 - slack) ** 2) / (2.0 * radius))
    angle = turn * np.arange(count)
    helix = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), (1.0 - slack) * spacing * np.arange(count)])
    scene = lm.Scene(dimension=3)
    for position in helix[:-1]:
        scene.add(lm.sphere(radius=1e-3, position=position, mass=1e-3))
    scene.add(lm.sphere(radius=1e-3, position=helix[-1], mass=1e3, velocity=(1.0, 0.5, 3.0)))
    scene.chain(scene.bodies, lm.RigidWire(), reference_gap=spacing - 2e-3)
    sim = lm.Simulation(scene, time_step=1e-3, solver=solver)
    start = momenta(sim)
    watch, span = Watch(sim), 0.0
    watch.step()  # the blow, whose detection is where the bodies go as one (docs/nscd.md)
    lengths = Lengths(sim, 0, count - 1, spacing)
    for _ in range(2000 if long else 300):
        watch.step()
        lengths.enter()
        span = max(span, float(np.linalg.norm(sim.positions[-1] - sim.positions[0])))
    change = np.abs(momenta(sim) - start)
    scale = np.repeat([np.linalg.norm(start[:3]), np.linalg.norm(start[3:])], 3)
    return watch.result(
        Number("momentum", float((change / scale)[:3].max()), 1e-10),
        Number("angular momentum", float((change / scale)[3:].max()), 1e-6),
        Number("length", lengths.excess, 1e-8),
        Number("slack", 1.0 - span / (spacing * (count - 1)), 1e-2),
    )


def ramp(x: float) -> float:
    """From 0 to 1 over x in [0, 1], so smoothly that an oscillator of w x T = 100 is left with 1e-11 of its load.

    ``(1 + erf(10 (x - 1/2)))/2``: its spectrum at w is exp(-(w T / 20)^2) = exp(-25), and it begins and ends at
    erfc(5)/2 = 8e-13.
    """
    return 0.5 * math.erfc(5.0 - 10.0 * x)


def shaken(ratio: float, steps: int, solver) -> Result:
    """Eight beads on a wire of ``h^2 k/m = ratio``, hung zigzag and slack from a support shaken up and down at 5 g."""
    h, mass, spacing, radius, g = 1e-3, 1e-3, 0.02, 4e-3, 9.81
    scene = lm.Scene(dimension=2, gravity=(0.0, -g))
    for i in range(9):
        scene.add(lm.disk(radius=radius, position=(0.1 * spacing * (i % 2), -0.9 * spacing * i), mass=mass))
    turn = 2.0 * math.pi * 10.0
    support = scene.bodies[0].fix()
    support.impose_velocity(y=lambda t: 5.0 * g / turn * math.sin(turn * t))
    scene.chain(scene.bodies, lm.ElasticWire(stiffness=ratio * mass / h**2), reference_gap=spacing - 2.0 * radius)
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver))
    made, slack = np.empty(steps), np.empty(steps)
    for i in range(steps):
        net = watch.step().interactions
        made[i] = watch.made
        slack[i] = np.mean(net.impulse[:, 0] == 0.0)
    assert 0.0 < slack[steps // 2 :].mean() < 1.0  # slack and taut by turns, to the end
    trend = np.polyfit(np.linspace(0.0, 1.0, steps), made, 1)[0]
    return watch.result(Number("energy trend", float(trend / watch.turned), 0.0))


def loaded(ratio: float, count: int, solver) -> Result:
    """Beads of ``h^2 k/m = ratio`` hung straight, whose weight comes as slowly as :func:`ramp` asks."""
    h, mass, spacing, radius, g = 1e-3, 1e-3, 0.02, 4e-3, 9.81
    k = ratio * mass / h**2
    slowest = 2.0 * math.sin(math.pi / (4.0 * count + 2.0)) * math.sqrt(k / mass)  # of a chain that is free at its end
    steps = math.ceil(100.0 / min(1.0, h * slowest))
    scene = lm.Scene(dimension=2)
    for i in range(count + 1):
        scene.add(lm.disk(radius=radius, position=(0.0, -spacing * i), mass=mass))
    scene.bodies[0].fix()
    for bead in scene.bodies[1:]:
        bead.impose_force(y=lambda t: -mass * g * ramp(t / (h * steps)))
    scene.chain(scene.bodies, lm.ElasticWire(stiffness=k))
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver))
    sim = watch.run(steps + 100)
    weight = mass * g * np.arange(count, 0, -1.0)
    tension = -sim.interactions.force[:, 0]
    elongation = -np.diff(sim.positions[:, 1]) - spacing
    rounding = 2.0**-51 * (count * spacing + weight.sum() / k)
    off = np.maximum(np.abs(elongation - weight / k) - rounding, 0.0) * k / weight
    return watch.result(
        Number("tension", float(np.abs(tension / weight - 1.0).max()), 1e-9),
        Number("elongation", float(off.max()), 1e-9),
    )


RATIOS = (1e-4, 1e-2, 1.0, 1e2, 1e4, 1e7, 1e10)


def elastic(solver, long: bool) -> Result:
    """Elastic wires of ``h^2 k/m`` from 1e-4 to 1e10, shaken so that they are slack and taut by turns, 1e5 steps each.

    Hard: taken at the start of the step, the force explodes for h^2 k/m > 4, as the paper reports of its elastic
    laws; and between 1e-4 and 1e10 compliance first rules W and then drowns in it. Numbers: the energy that the wires
    made (their work and what they store) has a trend, a straight line fitted to all steps, that falls; three beads
    under a weight that comes slowly hang, each link with the tension of the weight below it and the static elongation
    ``weight / k``, to 1e-9 beside what positions are rounded by (at 1e10 the elongation is 3e-12 m, and they leave
    four digits of it). The short form hangs one bead.
    """
    steps, beads = (100_000, 3) if long else (600, 1)
    runs = [shaken(ratio, steps, solver) for ratio in RATIOS] + [loaded(ratio, beads, solver) for ratio in RATIOS]
    return worst_of(runs)


def capstan(solver, long: bool) -> Result:
    """A rigid wire is drawn slowly over a drum: bead by bead its tension rises by Coulomb's friction, mu up to 1; with
    beads of 10 g to 0.1 microgram under a load of 1 N.

    Hard: every tension depends on every friction before it, so that the error of a sweep travels a bead at a time and
    the operator is far from symmetric; a stop at small changes reads a wrong ratio, and with light beads a residual that
    is relative to what the load makes of them says nothing of friction. Number: with no spin, a bead at
    which the wire turns by a, between links at a/2 from the drum's tangent, has

        N = (T1 + T2) sin(a/2),    (T2 - T1) cos(a/2) = mu N,    T2/T1 = (1 + mu tan(a/2)) / (1 - mu tan(a/2)),

    hence that to the power n over n beads, at 1e-6. The first and the last bead of the wire lie on the same polygon
    but do not see the drum; one is loaded, the other drawn along its link, at v = 1e-5 m/s. What turns with the drum's
    curve costs m v^2 / (R a T) of N, 3e-11 here, and the two ends leave the polygon by v t, after three steps an angle of
    v t / l = 1e-7.
    """
    results = []
    for friction in (0.1, 0.3, 1.0):
        for law in (lm.RigidWire(), lm.RigidRod()):
            results.append(drawn(friction, law, 10, math.radians(18.0), 3, solver))
    for mass in (1e-4, 1e-7, 1e-10):
        results.append(drawn(0.3, lm.RigidWire(), 10, math.radians(18.0), 3, solver, mass))
    return worst_of(results)


def drawn(friction: float, law: lm.Law, count: int, turn: float, steps: int, solver, mass: float = 0.01) -> Result:
    """``count`` beads of a ``mass`` [kg] on a drum, between a loaded and a drawn one."""
    drum, bead, h, speed, load = 0.1, 0.005, 1e-4, 1e-5, 1.0
    rim = drum + bead
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=drum, position=(0.0, 0.0), mass=1.0, color="DRUM")).fix()
    beads = []
    for i in range(count + 2):
        angle = turn * i
        out, on = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
        end = i in (0, count + 1)
        beads.append(
            scene.add(
                lm.disk(radius=bead, position=rim * out, mass=mass, velocity=speed * on, color="END" if end else "BEAD")
            )
        )
    first = beads[1].position - beads[0].position
    last = beads[-1].position - beads[-2].position
    first, last = first / np.linalg.norm(first), last / np.linalg.norm(last)
    beads[0].impose_force(x=-load * first[0], y=-load * first[1])
    pace = speed * math.cos(0.5 * turn)
    beads[-1].impose_velocity(x=pace * last[0], y=pace * last[1])
    scene.see("BEAD", "DRUM", lm.Coulomb(friction=friction))
    scene.chain(beads, law, block_spin=True)
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore"))
    tension = -watch.run(steps).interactions.force[: count + 1, 0]
    tangent = friction * math.tan(0.5 * turn)
    expected = ((1.0 + tangent) / (1.0 - tangent)) ** count
    return watch.result(Number("tension ratio", abs(tension[-1] / tension[0] / expected - 1.0), 1e-6))


def whip(solver, long: bool) -> Result:
    """A chain of 20 rigid rods, tapered to a hundredth of its mass, is flung through space, 1e5 steps.

    Hard: what moves in the heavy end arrives in the light one a hundred times as fast, and whatever a step leaves of
    the lengths or of the momenta adds up. Numbers: angular momentum about the centre of mass, relative to the sum of
    its parts at the start, to 1e-10; lengths within Pythagoras (see ``Lengths``) to 1e-10.
    """
    rng = np.random.default_rng(3)
    count, spacing = 20, 0.1
    mass = np.geomspace(1.0, 0.01, count + 1)
    velocity = rng.normal(0.0, 0.5, (count + 1, 2))
    scene = lm.Scene(dimension=2)
    for i in range(count + 1):
        scene.add(lm.disk(radius=0.01, position=(spacing * i, 0.0), mass=mass[i], velocity=(0.0, velocity[i, 1])))
    scene.chain(scene.bodies, lm.RigidRod())
    sim = lm.Simulation(scene, time_step=2e-4, solver=solver)
    start = momenta(sim)[2]
    scale = float(np.abs(mass * sim.positions[:, 0] * sim.velocities[:, 1]).sum())
    watch, lengths = Watch(sim), Lengths(sim, 0, count, spacing)
    for _ in range(100_000 if long else 2000):
        watch.step()
        lengths.enter()
    return watch.result(
        Number("angular momentum", abs(momenta(sim)[2] - start) / scale, 1e-10),
        Number("length", lengths.excess, 1e-10),
    )


def pendulum(solver, long: bool) -> Result:
    """A pendulum of ten rigid rods, let go from the horizontal, 1e5 steps.

    Hard: it whips chaotically; with ``u_n = 0`` for a law its length would grow at every step and never come back.
    Numbers: lengths within Pythagoras (see ``Lengths``) to 1e-10; the angular momentum about the pivot is the impulse
    of the weights, ``sum h q_m x m g``, exactly, as the first link's force goes through the pivot: to 1e-10 of what
    the weights turn over.
    """
    count, spacing, h, g = 10, 0.1, 2e-4, 9.81
    scene = lm.Scene(dimension=2, gravity=(0.0, -g))
    for i in range(count + 1):
        scene.add(lm.disk(radius=0.01, position=(spacing * i, 0.0), mass=0.1))
    scene.bodies[0].fix()
    scene.chain(scene.bodies, lm.RigidRod())
    sim = lm.Simulation(scene, time_step=h, solver=solver)
    watch, lengths = Watch(sim), Lengths(sim, 0, count, spacing)
    given = turned = worst = 0.0
    for _ in range(100_000 if long else 2000):
        moment = -0.1 * g * float((sim.positions + 0.5 * h * sim.velocities)[1:, 0].sum())
        watch.step()
        lengths.enter()
        given += h * moment
        turned += h * abs(moment)
        worst = max(worst, abs(float(momenta(sim)[2]) - given))
    return watch.result(Number("angular momentum", worst / turned, 1e-10), Number("length", lengths.excess, 1e-10))
