"""Hard cases of taut wires: jerked, drawn over a drum, over a smooth one, over pegs."""

from __future__ import annotations

import contextlib
import itertools
import math
import warnings
from collections.abc import Iterator
from typing import Any

import numpy as np
from case import Number, Result, Watch, worst_of

import lmgcpy as lm

G = 9.81


def octaves(first: float, count: int) -> list[float]:
    """``count`` octaves of steps [s] from the first one downward, both ends included."""
    return [first / 2**k for k in range(count + 1)]


def order(steps: list[float], errors: list[float]) -> float:
    """The order of convergence: slope of the errors over the steps, both logarithmic, a straight line fitted to all."""
    return float(np.polyfit(np.log(steps), np.log(np.abs(errors)), 1)[0])


def order_of_changes(steps: list[float], values: list[float]) -> float:
    """The order by which values settle: their changes from one octave to the next fall as their errors do."""
    return order(steps[1:], list(np.diff(values)))


@contextlib.contextmanager
def coarse() -> Iterator[None]:
    """Leaves out what a run says of bodies that move too far for their contacts, where such steps belong to the scan."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", "In the step to", RuntimeWarning)
        yield


def only(*numbers: Number) -> Result:
    """Numbers of several runs together, which were counted already."""
    return Result(numbers, 0.0, 0.0, 0.0)


# ------------------------------------------------------------------------------------------------- a jerked wire


def dropped(solver, long: bool, **options: Any) -> Result:
    """A mass falls on a wire of twenty links and 0.202 m between supports 0.2 m apart; mass ratios of 1, 1e3 and 1e6.

    Hard: beads of 1 g between links under the jerk of a ton have s = 4 h^2 T/(m l) up to 1e6, where 4 is the limit of a
    normal taken at the start of the step: they zigzag, the wire stretches, and is pulled back with a blow. Numbers: the
    geometry lets the mass fall to sqrt(0.101^2 - 0.1^2) = 14.2 mm, where it arrives at v = 0.53 m/s and uses up slack at
    2 v sin(a) = 0.15 m/s, a being the angle of the halves, sin(a) = 0.14. The normals of the last step before that let a
    zigzag straighten, not more: so the wire grows by the slack that was left, at most that of a step, h 0.15 m/s, which is
    0.74 h/s of its length; first order in h, within 0.3, which is the scatter of a jerk. Beads of the mass's
    own size, thrown taut themselves, are no faster. It makes at most a hundredth of its energy in a
    step (``lmgcpy/dynamics/turning_stretch.py``), for the three steps that a jerk takes, and never more than it took.
    """
    results = []
    steps = octaves(2e-3, 7 if long else 4)
    for load in (1e-3, 1.0, 1e3):
        excess = []
        for h in steps:
            watch, longest = jerked(load, h, 0.075, solver, **options)
            excess.append(longest / 0.202 - 1.0)
            results.append(
                watch.result(
                    Number("length [h/s]", excess[-1] / h, 2.0 * math.sqrt(2.0 * G * 0.0142) * 0.1404 / 0.202),
                    Number("energy made", watch.energy, 0.03),
                    Number("gained", watch.gained, 1e-3),
                )
            )
        if load > 1e-3:
            results.append(only(Number("order below 1", 1.0 - order(steps, excess), 0.3)))
    return worst_of(results)


def jerked(load: float, h: float, duration: float, solver, **options: Any) -> tuple[Watch, float]:
    """Beads of 1 g and a load in the middle; how long the wire was at most [m]."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    for i in range(21):
        scene.add(lm.disk(radius=0.002, position=(0.01 * i, 0.0), mass=load if i == 10 else 1e-3))
    scene.bodies[0].fix()
    scene.bodies[-1].fix()
    scene.chain(scene.bodies, lm.RigidWire(), reference_gap=0.0101 - 0.004)
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
    longest = 0.0
    for _ in range(round(duration / h)):
        x = watch.step().positions
        longest = max(longest, float(np.linalg.norm(np.diff(x, axis=0), axis=1).sum()))
    return watch, longest


# ------------------------------------------------------------------------------------------- a line without slack


def straight(solver, long: bool, **options: Any) -> Result:
    """A rigid line of twenty links lies straight between two posts, as long as the span; its middle bead weighs as much as
    the others or 1e3 times that. Wires and rods, at steps of 4 to 0.25 ms. Long: 1e6 times at 4 to 1 ms, 2000 steps.

    Hard: no finite tension holds it. Every step halves its sag and doubles the tension, until the least eigenvalue of
    W, the square of the angles between links, is lost to round-off. Numbers: straight links hold nothing across, so
    that the beads fall by 2 g h^2 in two steps, and by g h^2 at most before they turn; the links lift them by that
    once, and make no more energy than it takes. Its stretch is in the end the square of the angles that are lost, 1e-15
    for equal beads, and as many times that as a bead is heavier, since W is rounded by its largest entries; 1e5 times
    are allowed, as errors add up along the line.
    """
    results = []
    for law in (lm.RigidWire, lm.RigidRod):
        for ratio, count in ((1.0, 4), (1e3, 4), (1e6, 2))[: 3 if long else 2]:
            for h in octaves(4e-3, count):
                scene = lm.Scene(dimension=2, gravity=(0.0, -G))
                for i in range(21):
                    mass = 0.01 * (ratio if i == 10 else 1.0)
                    scene.add(lm.disk(radius=0.002, position=(0.01 * i, 0.0), mass=mass))
                scene.bodies[0].fix()
                scene.bodies[-1].fix()
                scene.chain(scene.bodies, law())
                watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
                sag = 0.0
                for _ in range(2000 if long else 100):
                    sag = max(sag, -float(watch.step().positions[:, 1].min()))
                sim, fall = watch.sim, 3.0 * G * h**2
                excess = abs(float(np.linalg.norm(np.diff(sim.positions, axis=0), axis=1).sum()) / 0.2 - 1.0)
                results.append(
                    watch.result(
                        Number("sag [3 g h²]", sag / fall, 1.0),
                        Number("length [1e-10]", excess / 1e-10 / max(ratio / 1e3, 1.0), 1.0),
                        Number("energy made [of the fall]", sim.energy.made / (0.01 * (18 + ratio) * G * fall), 1.0),
                        Number("unsolved steps", float(sim.unconverged_steps), 0.0),
                    )
                )
    return worst_of(results)


# ------------------------------------------------------------------------------------------- wires over drums


DRUM, BEAD, SPACING = 0.1, 0.01, 0.0205
"""Radius of a drum and of a bead, and distance of beads [m]."""
RIM = DRUM + BEAD
TURN = 2.0 * math.asin(0.5 * SPACING / RIM)
"""Angle by which the wire turns at a bead on the drum."""


def capstan_ratio(friction: float) -> float:
    """Ratio of the tensions on both sides of half a turn, see ``wires.capstan``: one factor a bead, pi/TURN beads."""
    tangent = friction * math.tan(0.5 * TURN)
    return ((1.0 + tangent) / (1.0 - tangent)) ** (math.pi / TURN)


class Hoist:
    """A wire of beads over drums side by side, half a turn in all, with a block at each end; spin is blocked.

    ``ratio``: mean ratio of the end tensions over the second half of the run; ``acceleration``: of the first block
    downward, mean of the whole run [m/s^2]; ``peak``: largest tension in the second half [N]; ``lift``: mean vertical
    force of all drums on the wire in the second half [N]; ``weight`` of all that hangs [N].
    """

    def __init__(
        self,
        centres: list[tuple[float, float]],
        loads: tuple[float, float],
        friction: float,
        bead: float,
        h: float,
        duration: float,
        solver,
        **options: Any,
    ):
        scene = lm.Scene(dimension=2, gravity=(0.0, -G))
        for position in centres:
            scene.add(lm.disk(radius=DRUM, position=position, mass=1.0, color="DRUM")).fix()
        path = chords(centres, 14)
        last = len(path) - 1
        beads = []
        for i, position in enumerate(path):
            mass, color = {0: (loads[0], "END"), last: (loads[1], "END")}.get(i, (bead, "BEAD"))
            beads.append(scene.add(lm.disk(radius=BEAD, position=position, mass=mass, color=color)))
        scene.see("BEAD", "DRUM", lm.Coulomb(friction=friction))
        scene.chain(beads, lm.RigidWire(), block_spin=True)
        self.watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))
        self.weight = G * (sum(loads) + (last - 1) * bead)
        sim, steps = self.watch.sim, max(4, round(duration / h))
        ratios, lifts, self.peak = [], [], 0.0
        for k in range(steps):
            self.watch.step()
            if k >= steps // 2:
                net = sim.interactions
                tension = -net.force[:last, 0]
                ratios.append(tension[0] / tension[-1] if tension[-1] > 0.0 else math.inf)
                self.peak = max(self.peak, float(tension.max()))
                lifts.append(abs(float(np.einsum("ia,iad->id", net.force[last:], net.frame[last:])[:, 1].sum())))
        self.ratio = float(np.mean(ratios))
        self.lift = float(np.mean(lifts))
        self.acceleration = -float(sim.velocities[beads[0].id, 1]) / sim.time


def chords(centres: list[tuple[float, float]], side: int) -> np.ndarray:
    """Places of beads SPACING apart on a string over drums, from right to left; about ``side`` hang on both sides."""
    centres = sorted(centres, reverse=True)
    heading = [0.5 * math.pi]  # of the free spans
    for a, b in itertools.pairwise(centres):
        heading.append(math.atan2(b[1] - a[1], b[0] - a[0]) % (2.0 * math.pi))
    heading.append(1.5 * math.pi)
    arcs = []
    for i, (x, y) in enumerate(centres):
        angle = np.linspace(heading[i], heading[i + 1], 2000) - 0.5 * math.pi
        arcs.append(np.column_stack([x + RIM * np.cos(angle), y + RIM * np.sin(angle)]))
    string = np.concatenate(arcs)
    down = np.array([0.0, -SPACING * side])
    string = np.concatenate([string[:1] + down, string, string[-1:] + 1.1 * down])
    path, k = [string[0]], 0
    while k < len(string) - 1:
        a, b = string[k] - path[-1], string[k + 1] - path[-1]
        if b @ b < SPACING**2:
            k += 1
            continue
        d = b - a
        p, q, r = d @ d, a @ d, a @ a - SPACING**2  # |a + t d| = SPACING
        path.append(string[k] + (math.sqrt(q * q - p * r) - q) / p * d)
    return np.array(path)


def dragged(solver, long: bool, **options: Any) -> Result:
    """A weight of 12.6 kg drags a wire of beads of 0.1 g over a drum, against 5 kg and a friction of 0.25.

    Hard: s = 4 h^2 T/(m l) is 200 at h = 1e-3, and every tension depends on every friction before it. Numbers: the ratio
    rho of the end tensions is the capstan's, one factor a bead as in ``wires.capstan``, 2.1986 (e^(mu pi) is 2.1933),
    within 1 %, as beads come and go, half a bead in 17, and settles at first order, within 0.3; Newton's law of the two
    blocks gives the acceleration g (M1 - rho M2)/(M1 + rho M2) = 0.668 m/s^2, of which 1 % of rho is 3.4 %. Friction and
    wire each only take energy. Two solvers: sweeps leave most steps unsolved after seconds. Long: h to 2e-5 s, and beads
    of 1 g to 10 mg.
    """
    results = []
    ratio = capstan_ratio(0.25)
    for bead, steps in hoist_scan(long):
        ratios = []
        for h in steps:
            hoist = Hoist([(0.0, 0.0)], (12.6, 5.0), 0.25, bead, h, 0.1 if long else 0.04, solver, **options)
            ratios.append(hoist.ratio)
            heavy, light = 12.6 + 14 * bead, ratio * (5.0 + 14 * bead)
            expected = G * (heavy - light) / (heavy + light + 18 * bead)
            results.append(
                hoist.watch.result(
                    Number("tension ratio", abs(hoist.ratio / ratio - 1.0), 0.01),
                    Number("acceleration", abs(hoist.acceleration / expected - 1.0), 0.034),
                    Number("energy made", hoist.watch.energy, 1e-3),
                    Number("gained", hoist.watch.gained, 1e-3),
                )
            )
        if bead == 1e-4 and not long:
            results.append(only(Number("order below 1", 1.0 - order_of_changes(steps, ratios), 0.3)))
    return worst_of(results)


def atwood(solver, long: bool, **options: Any) -> Result:
    """Atwood's machine: 3 kg against 1 kg on a wire of beads of 0.1 g over a drum without friction.

    Hard: s = 60 at h = 1e-3, and without friction nothing but its tension holds the wire on the drum. Numbers: the end
    tensions are equal but for the inertia of the wire between, 1e-3, and the acceleration is g (M1 - M2)/(M1 + M2 + m),
    m being the mass of the wire, 4.90 m/s^2: both within 1e-3, for beads that come and go, and first order in h: 4 h/s,
    of the tensions 8 h/s.
    Two solvers and long form: as ``dragged``.
    """
    results = []
    for bead, steps in hoist_scan(long):
        for h in steps:
            hoist = Hoist([(0.0, 0.0)], (3.0, 1.0), 0.0, bead, h, 0.1 if long else 0.04, solver, **options)
            wire = (hoist.weight / G - 4.0) / 4.0
            expected = G * 2.0 / (4.0 * (1.0 + wire))
            results.append(
                hoist.watch.result(
                    Number("tension ratio [1e-3 + 8 h/s]", abs(hoist.ratio - 1.0) / (1e-3 + 4.0 * wire + 8.0 * h), 1.0),
                    Number("acceleration [1e-3 + 4 h/s]", abs(hoist.acceleration / expected - 1.0) / (1e-3 + 4.0 * h), 1.0),
                    Number("energy made", hoist.watch.energy, 1e-3),
                    Number("gained", hoist.watch.gained, 1e-3),
                )
            )
    return worst_of(results)


def hoist_scan(long: bool) -> list[tuple[float, list[float]]]:
    """Masses of beads [kg], with the steps [s] that they are run at."""
    if not long:
        return [(1e-4, octaves(2e-3, 4))]
    return [(1e-4, [*octaves(2e-3, 6), 2e-5]), *((bead, octaves(2e-3, 4)) for bead in (1e-3, 1e-5))]


def pegs(solver, long: bool, **options: Any) -> Result:
    """A wire over three pegs, the middle one raised, with equal blocks at its ends; friction 0.3, ratios of 1e3 to 1e6.

    Hard: spans between the pegs, which have nothing but their tension to hold them, of beads of 0.1 g under blocks of
    0.1 to 100 kg. Numbers: the blocks are equal and stay, so that the pegs bear the whole weight, within 1 %, for the
    wire in the spans that swings; no tension exceeds half the weight times e^(mu pi), the capstan's bound for half a turn
    in all. The energy is made relative to what gravity alone gives in a step, as nothing moves: 1 %.
    """
    results = []
    middle = [(-0.3, 0.0), (0.0, 0.08), (0.3, 0.0)]
    for load in (0.1, 1.0, 100.0) if long else (0.1, 100.0):
        for h in octaves(2e-3, 4):
            hoist = Hoist(middle, (load, load), 0.3, 1e-4, h, 0.08 if long else 0.02, solver, **options)
            watch = hoist.watch
            results.append(
                watch.result(
                    Number("lift", abs(hoist.lift / hoist.weight - 1.0), 0.01),
                    Number("tension", hoist.peak / (0.5 * hoist.weight * capstan_ratio(0.3)), 1.0),
                    Number("energy made", watch.energy, 1e-2),
                    Number("gained", watch.gained, 1e-2),
                )
            )
    return worst_of(results)
