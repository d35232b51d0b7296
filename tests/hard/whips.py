"""Hard cases of wires in free motion: falling on elastic ones, falling folded, cracking, spinning."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from case import Number, Result, Watch, worst_of
from taut import G, octaves, only, order, order_of_changes

import lmgcpy as lm


def bungee(solver, long: bool, **options: Any) -> Result:
    """10 kg on an elastic wire of 1 m and nine beads of 10 mg, EA of 1e3 and 1e4 N; it falls 0.5 m before it is taut.

    Hard: mass ratio of 1e6, folded zigzag, s of up to 1e6 where it comes taut. Number: with k = EA/L the energy
    m g (F + e) = k e^2/2 of a fall of F = 0.5 m until taut gives the depth L + e, e = m g/k + sqrt((m g/k)^2 + 2 F m g/k).
    The implicit step damps and makes it fall short: within the way h v of three steps, v = sqrt(2 g F) = 3.1 m/s, first
    order in h, within 0.3, for EA = 1e3. The wire gives back what it took, and at most a hundredth of the energy more.
    """
    return jumps((1e2, 1e3, 1e4) if long else (1e3, 1e4), octaves(4e-3, 5 if long else 4), solver, **options)


def stiff_bungee(solver, long: bool, **options: Any) -> Result:
    """As ``bungee``, EA of 1e6 N and 1e12 N, where the wire comes taut within a step.

    Hard: just before that the light beads are thrown about at 10 m/s. Their links stretch by Pythagoras, (h u_t)^2/(2 l)
    each, which costs the beads next to nothing; and the step in which all are taut pulls the sum of it back within h,
    heavy end and all: with velocities it made up to six times the energy. Numbers: the depth of the energy within 4 h v,
    the stretch that a bound on u_t leaves; and the wire, which cannot give what it did not take, gains nothing.
    """
    return jumps((1e6, 1e12), octaves(4e-3, 5 if long else 4), solver, **options)


def jumps(rigidities: tuple[float, ...], steps: list[float], solver, **options: Any) -> Result:
    """Depths by EA and step. A chain may make a hundredth of its energy in a step: for the three of a jerk 0.03."""
    results = []
    for rigidity in rigidities:
        errors = []
        for h in steps:
            watch, error = jumped(rigidity, 10.0, h, solver, **options)
            errors.append(error)
            way = h * math.sqrt(2.0 * G * 0.5)
            results.append(
                watch.result(
                    Number("depth [h v]", abs(error) / way, 4.0 if rigidity > 1e5 else 3.0),
                    Number("energy made", watch.energy, 0.03),
                    Number("gained", watch.gained, 1e-2),
                )
            )
        if rigidity == 1e3:
            results.append(only(Number("order below 1", 1.0 - order(steps, errors), 0.3)))
    return worst_of(results)


def jumped(rigidity: float, mass: float, h: float, solver, **options: Any) -> tuple[Watch, float]:
    """A jump to its lowest point; what was seen, and how much deeper than by the energy it went [m]."""
    length, slack, links = 1.0, 0.5, 10
    l = length / links
    across = math.sqrt(1.0 - slack**2) * l
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    for i in range(links + 1):
        position = (across * (i % 2), -slack * l * i)
        scene.add(lm.disk(radius=0.1 * l, position=position, mass=mass if i == links else 1e-5))
    scene.bodies[0].fix()
    scene.chain(scene.bodies, lm.ElasticWire(stiffness=rigidity / l), reference_gap=0.8 * l)
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
    fall, k = (1.0 - slack) * length, rigidity / length
    depth = length + mass * G / k + math.sqrt((mass * G / k) ** 2 + 2.0 * fall * mass * G / k)
    deepest, end = 0.0, math.sqrt(2.0 * fall / G) + 3.2 * math.sqrt(mass / k) + 10.0 * h
    while watch.sim.time < end:
        deepest = max(deepest, -float(watch.step().positions[-1, 1]))
    return watch, deepest - depth


def folded(solver, long: bool, **options: Any) -> Result:
    """A chain of 1 m hangs by both ends side by side; one end is let go. Rods, and wires.

    Hard: the fold runs down the chain and through ever fewer links, each of which turns over within a few steps. Numbers:
    a chain that keeps its energy has, when its tip has fallen by x, v^2 = g x (2 L - x)/(L - x): it falls faster than
    g, and reaches 0.9 L in 0.877 of the time of free fall (all of it in 0.847). One that loses what the fold stops falls
    freely, v^2 = 2 g x. The time lies between the two, and is later than the first by the link across the fold, which
    turns over but does not fall: 1.5 l/L of the time; the tip passes 0.9 L at 5/3 of the speed of free fall and more
    (by theory 2.3, less what the links that turn keep). Rods settle at second order in h, within 0.5; neither
    makes energy. Tension is small here: geometric stiffness changes nothing.
    """
    free, theory = math.sqrt(1.8 / G), falling_time(0.9)
    results = []
    scan = [(lm.RigidRod(), 41, 4), (lm.RigidWire(), 21, 4)]
    more = [(lm.RigidRod(), 81, 5), (lm.RigidWire(), 81, 5)]
    for law, links, count in [*scan, *more] if long else scan:
        steps, times = octaves(2e-3, count), []
        for h in steps:
            watch, time, speed = let_go(law, links, h, solver, **options)
            times.append(time / free)
            results.append(
                watch.result(
                    Number("earlier than by energy", (theory - time) / free, 0.0),
                    Number("later than free fall", time / free - 1.0, 0.0),
                    Number("free fall over speed", math.sqrt(1.8 * G) / speed, 0.6),
                    Number("energy made", watch.energy, 1e-2),
                    Number("gained", watch.gained, 1e-3),
                )
            )
        results.append(only(Number("late [l/L]", (times[-1] - theory / free) * links, 1.5)))
        if links == 41:
            results.append(only(Number("order below 2", 2.0 - order_of_changes(steps, times), 0.5)))
    return worst_of(results)


def falling_time(x: float) -> float:
    """Time [s] in which the tip of a folded chain of 1 m falls by x [m], energy kept."""
    # v^2 = g x (2 - x)/(1 - x); with x = y^2 the integrand dx/v has no pole
    y = (np.arange(20000) + 0.5) * math.sqrt(x) / 20000
    return float(np.sum(2.0 * np.sqrt((1.0 - y**2) / (G * (2.0 - y**2)))) * math.sqrt(x) / 20000)


def let_go(law: lm.Law, links: int, h: float, solver, **options: Any) -> tuple[Watch, float, float]:
    """What was seen, time [s] in which the tip falls by 0.9 m, and its speed there [m/s]."""
    l = 1.0 / links
    half = (links - 1) // 2
    depth = l * np.concatenate([np.arange(half + 1), np.arange(half, -1, -1)])
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    for i, y in enumerate(depth):
        scene.add(lm.disk(radius=0.1 * l, position=(l if i > half else 0.0, -y), mass=1.0 / len(depth)))
    scene.bodies[0].fix()
    scene.chain(scene.bodies, law)
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
    sim, before, fall = watch.sim, 0.0, 0.0
    while fall < 0.9 and sim.time < 0.6:
        watch.step()
        before, fall = fall, -float(sim.positions[-1, 1])
    speed = (fall - before) / h
    return watch, sim.time - (fall - 0.9) / speed, speed


def crack(solver, long: bool, **options: Any) -> Result:
    """A whip of 1 m lies folded, one arm at rest and held, the other at 1 m/s; uniform, and tapered to 1e-2 and 1e-6.

    Hard: all energy ends in the last link. Numbers: of a fold that runs down a whip, energy is kept in the arm that still
    moves, v = v0 sqrt(M(0)/M(x)), M(x) being the mass of that arm when the tip has moved by x: at x = 0.5, within 5 %, two
    links in 41, at the finest step; the tip is never faster than with all energy in it; its largest speed settles, the
    last of four octaves changes it by less than 5 %. Links make at most a hundredth of the energy
    in a step, and the coarsest make a few such, where the tip passes half a whip in a step: 0.05. Tension does little
    here but at the tip of the tapered whip.
    """
    results = []
    for taper in (1.0, 1e2, 1e6):
        steps, fastest = octaves(1.6e-2, 7 if long else 4), []
        for h in steps:
            watch, speed, half, bound, theory = cracked(taper, h, solver, **options)
            fastest.append(speed)
            results.append(
                watch.result(
                    Number("over all energy", speed / bound, 1.0),
                    Number("energy made", watch.energy, 0.05),
                    Number("gained", watch.gained, 1e-2),
                )
            )
        results.append(
            only(
                Number("speed halfway", abs(half / theory - 1.0), 0.05),
                Number("last octave", abs(fastest[-1] / fastest[-2] - 1.0), 0.05),
            )
        )
    return worst_of(results)


def cracked(taper: float, h: float, solver, **options: Any) -> tuple[Watch, float, float, float, float]:
    """What was seen; the tip's largest speed, that halfway, that with all energy in it, that halfway by theory."""
    links = 41
    l, half = 1.0 / links, 20
    at = l * np.concatenate([np.arange(half + 1), np.arange(half, -1, -1)])
    mass = 1e-3 * np.geomspace(1.0, 1.0 / taper, len(at))
    scene = lm.Scene(dimension=2)
    for i, x in enumerate(at):
        flies = i > half
        velocity = (1.0, 0.0) if flies else (0.0, 0.0)
        scene.add(lm.disk(radius=0.1 * l, position=(x, l if flies else 0.0), mass=mass[i], velocity=velocity))
    scene.bodies[0].fix()
    scene.chain(scene.bodies, lm.RigidWire())
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
    sim, whole = watch.sim, watch.sim.energy.kinetic
    way, speeds = [0.0], [1.0]
    while sim.time < 0.8:
        watch.step()
        way.append(float(sim.positions[-1, 0]))
        speeds.append(float(np.linalg.norm(sim.velocities[-1, :2])))
    first = next(i for i, x in enumerate(way) if x > 0.5)
    halfway = float(np.interp(0.5, way[first - 1 : first + 1], speeds[first - 1 : first + 1]))
    # at x the moving arm is (1 - x)/2 long
    lengths = l * (len(at) - 1 - np.arange(len(at)))
    moving = [mass[lengths < 0.5 * (1.0 - x)].sum() for x in (0.0, 0.5)]
    return watch, max(speeds), halfway, math.sqrt(2.0 * whole / mass[-1]), math.sqrt(moving[0] / moving[1])


def spinning(solver, long: bool, **options: Any) -> Result:
    """Two bodies on a wire of nine beads of 0.1 g turn about each other at 10 rad/s; mass ratios of 1, 1e4 and 1e6.

    Hard: under the heavy ends' tension s is up to 1e5, and whatever the wire takes at a step, 1e5 of them take 1e5 times.
    Numbers: geometric stiffness is an inertia that comes with the tension, at most (h omega)^2 of the moment of inertia
    of the ends: that of the angular momentum may be lost, once, and no more with time, second order in h within 0.3. A
    link gives back its second-order stretch, (h omega)^2/2 of its length, and no more: as much of the energy. Long: 1e5
    steps of 1 ms.
    """
    results = []
    for end in (1e-4, 1.0, 100.0):
        steps = octaves(8e-3, 4) if not long else [1e-3]
        losses = []
        for h in steps:
            watch, loss = turned(end, h, 100_000 if long else round(0.5 / h), solver, **options)
            losses.append(loss)
            square = (10.0 * h) ** 2
            results.append(
                watch.result(
                    Number("angular momentum [(h omega)^2]", loss / square, 1.0),
                    Number("energy made [(h omega)^2]", watch.energy / square, 1.0),
                    Number("gained [(h omega)^2]", watch.gained / square, 1.0),
                )
            )
        if end == 100.0 and not long:
            results.append(only(Number("order below 2", 2.0 - order(steps, losses), 0.3)))
    return worst_of(results)


def turned(end: float, h: float, steps: int, solver, **options: Any) -> tuple[Watch, float]:
    """What was seen, and the largest change of the angular momentum, in parts of it."""
    omega, length = 10.0, 0.02
    scene = lm.Scene(dimension=2)
    for i in range(11):
        x, mass = length * (i - 5), end if i in (0, 10) else 1e-4
        scene.add(lm.disk(radius=0.004, position=(x, 0.0), mass=mass, velocity=(0.0, omega * x)))
    scene.chain(scene.bodies, lm.RigidWire())
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
    sim, mass = watch.sim, watch.sim.model.mass[:, 0]

    def momentum() -> float:
        x, v = sim.positions, sim.velocities
        return float(mass @ (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]))

    start, worst = momentum(), 0.0
    for _ in range(steps):
        watch.step()
        worst = max(worst, abs(momentum() / start - 1.0))
    return watch, max(worst, 1e-16)
