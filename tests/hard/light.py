"""Hard cases of light wires between heavy bodies: squeezed, drawn through a pack, pulled apart, wound up by a ball."""

from __future__ import annotations

import dataclasses
import itertools
import math
from typing import Any

import numpy as np
from case import Number, Result, Watch, worst_of
from taut import coarse, octaves

import lmgcpy as lm

RATIOS = (1.0, 1e2, 1e4, 1e6)
"""Masses of the heavy bodies over that of a bead."""
RADIUS, SPACING = 0.01, 0.05
"""Of a bead, and of the beads of a wire [m]."""
COUNT, FRICTION, SQUEEZE = 20, 0.4, 100.0
"""Beads of a wire, their friction, and the force that presses on each of them from either side [N]."""
HELD = FRICTION * SQUEEZE * 2.0
"""What friction holds on a bead [N]."""
SPEED = 0.01
"""Of a wire that is drawn [m/s]."""


def vector(dimension: int, x: float, y: float) -> tuple[float, ...]:
    """A vector in the plane of the wire and of what presses on it."""
    return (x, y) if dimension == 2 else (x, 0.0, y)


def squeezed_wire(ratio: float, law: lm.Law, dimension: int, *, rows: bool = False) -> tuple[lm.Scene, list[lm.Body]]:
    """A wire, each bead of which is pressed by a grain of 1 kg from above and one from below, and its beads.

    Grains are held but across the wire; in ``rows`` they touch their neighbours, and the last one a wall, and nothing else
    holds them along it; the wire moves.
    """
    scene = lm.Scene(dimension=dimension)
    make = lm.disk if dimension == 2 else lm.sphere
    press = "xyz"[dimension - 1]
    grain_radius = 0.5 * SPACING if rows else 0.02
    beads = []
    for i in range(COUNT):
        at = SPACING * i
        velocity = vector(dimension, SPEED if rows else 0.0, 0.0)
        place = vector(dimension, at, 0.0)
        beads.append(scene.add(make(radius=RADIUS, position=place, velocity=velocity, mass=1.0 / ratio, color="BEAD")))
        for side in (1, -1):
            place = vector(dimension, at, side * (RADIUS + grain_radius))
            grain = scene.add(make(radius=grain_radius, position=place, mass=1.0, color="GRAIN"))
            spins = ("spin",) if dimension == 2 else ("y", "spin_x", "spin_y", "spin_z")
            grain.fix(*spins, *(() if rows else ("x",)))
            grain.impose_force(**{press: -SQUEEZE * side})
    scene.chain(beads, law, block_spin=True)
    scene.see("BEAD", "GRAIN", lm.Coulomb(friction=FRICTION))
    if rows:
        end = vector(dimension, SPACING * (COUNT - 0.5), 0.0)
        scene.add(lm.wall(point=end, normal=vector(dimension, -1.0, 0.0), color="WALL"))
        scene.see("GRAIN", "GRAIN", lm.Signorini())
        scene.see("GRAIN", "WALL", lm.Signorini())
    return scene, beads


def watched(scene: lm.Scene, h: float, solver, tolerance: float, **options: Any) -> Watch:
    """A simulation with this tolerance."""
    solver = dataclasses.replace(solver, tolerance=tolerance)
    return Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore", **options))


def squeezed(solver, long: bool, **options: Any) -> Result:
    """A wire of twenty beads, each pressed by 100 N between two grains, friction 0.4, is pulled at one end with 0.5, 0.9,
    1.1 and 1.5 of what friction holds. Wires, rods, elastic wires; plane and space; grains of 1 to 1e6 times a bead's mass,
    to 1e4 times if it slides; 1 ms to 62 us; tolerances of 1e-2 and 1e-4. Long: all of these with each other.

    Hard: the error of a heavy grain's force is many times what moves a bead, and friction hangs on it. (Judged by residual
    and slip, the wire that holds came off by 5 radii in ten steps that had all converged.) Numbers: below 1 nothing moves,
    but for an elastic wire, whose links are longer by up to their tension over 1e9 N/m, 3e-3 radii in all: 2e-3 radii
    otherwise. Above 1 Newton's law gives all beads h (F - n 2 mu N)/(n m) in the first step. Forces may be off by a
    hundredth of what bodies bear, in both contacts of a bead, so that this is within 0.2 of itself at 1.1 and 0.04 at 1.5.
    """
    scan = [
        (ratio, law, dimension, h, tolerance)
        for ratio in RATIOS
        for law in (lm.RigidWire(), lm.RigidRod(), lm.ElasticWire(stiffness=1e9))
        for dimension in (2, 3)
        for h in octaves(1e-3, 4)
        for tolerance in (1e-2, 1e-4)
    ]
    results = []
    for ratio, law, dimension, h, tolerance in scan if long else scan[::11]:
        elastic = law.NAME == "elastic-wire"
        for pull in (0.5, 0.9):
            scene, beads = squeezed_wire(ratio, law, dimension)
            beads[-1].impose_force(x=pull * HELD * COUNT)
            watch = watched(scene, h, solver, tolerance, **options)
            start = watch.sim.positions.copy()
            way = abs(watch.run(10).positions - start).max() / RADIUS
            stretch = 3e-3 if elastic else 0.0
            results.append(
                watch.result(
                    Number("way [2e-3 R]", way / (2e-3 + stretch), 1.0),
                    Number("unsolved steps", float(watch.sim.unconverged_steps), 0.0),
                )
            )
        if not elastic and ratio < 1e6:
            results += [slides(ratio, law, dimension, h, tolerance, pull, solver, **options) for pull in (1.1, 1.5)]
    return worst_of(results)


def torn_off(solver, long: bool, **options: Any) -> Result:
    """The wire of ``squeezed`` with grains of 1e6 times a bead's mass, pulled with 1.1 and 1.5 of what friction holds.

    Hard: what is left over for the beads makes them fly, at kilometres a second, and a sweep that gives them the mass of
    a quarter of a grain moves them by 4e-6 of that. Number: the first speed, as there.
    """
    scan = [(1.1, 1e-3, 1e-2), (1.5, 6.25e-5, 1e-4)]
    if long:
        scan = [(pull, h, tolerance) for pull in (1.1, 1.5) for h in octaves(1e-3, 4) for tolerance in (1e-2, 1e-4)]
    return worst_of([slides(1e6, lm.RigidWire(), 2, h, tol, pull, solver, **options) for pull, h, tol in scan])


def slides(
    ratio: float, law: lm.Law, dimension: int, h: float, tolerance: float, pull: float, solver, **options: Any
) -> Result:
    """The speeds of the beads after a step."""
    scene, beads = squeezed_wire(ratio, law, dimension)
    beads[-1].impose_force(x=pull * HELD * COUNT)
    watch = watched(scene, h, solver, tolerance, **options)
    with coarse():
        watch.step()
    speed = h * (pull - 1.0) * HELD * ratio
    off = max(abs(bead.velocity[0] / speed - 1.0) for bead in beads)
    return watch.result(
        Number("speed [0.02 F over the net force]", off * (pull - 1.0) / 0.02, 1.0),
        Number("unsolved steps", float(watch.sim.unconverged_steps), 0.0),
    )


def through_pack(solver, long: bool, **options: Any) -> Result:
    """A wire moves at 10 mm/s between two rows of touching grains, each pressed on its bead by 100 N, and is drawn on by
    its last bead for ten steps; beads of the grains' mass, of 1e-2, 1e-4, 1e-6 of it; 1 ms to 62 us. Long: tolerances of
    1e-3, 1e-4, 1e-6.

    Hard: as ``squeezed``, and the rows are held by a wall behind their last grains alone. Numbers: a bead that is ahead of
    its grains by x leans by a, sin(a) = x/(R + r), and where N presses across the wire friction takes N tan(atan(mu) - a)
    along it, whatever the bead weighs. So the wire behind the drawn bead pulls with 2 (n - 1) times that, and each row
    pushes the wall with n times that, at the x of the middle of the step. Every grain of a row hands on the error of its
    two contacts, up to the tolerance each: within 40 tolerances, and 0.005 for N, as grains come down by a x.
    """
    return drawn(solver, (1e-3, 1e-4, 1e-6) if long else (1e-4,), **options)


def through_pack_roughly(solver, long: bool, **options: Any) -> Result:
    """The wire of ``through_pack`` to a tolerance of 1e-2.

    Hard: e(0) is what the presses give to grains, 0.1 m/s at 1 ms, so that a hundredth of it, over all, is the speed of the
    wire: grains may go along with it, whatever beads weigh, and nothing slides. Numbers: as there, within 0.4.
    """
    return drawn(solver, (1e-2,), **options)


def drawn(solver, tolerances: tuple[float, ...], **options: Any) -> Result:
    """The pull and the push of the rows, over ratios and steps."""
    results = []
    for ratio, h, tolerance in itertools.product(RATIOS, octaves(1e-3, 4), tolerances):
        scene, beads = squeezed_wire(ratio, lm.RigidWire(), 2, rows=True)
        beads[-1].impose_velocity(x=SPEED)
        watch = watched(scene, h, solver, tolerance, **options)
        wall, last = scene.bodies[-1].id, beads[-1].id
        off = []
        for step in range(10):
            lean = math.asin(SPEED * h * (step + 0.5) / (RADIUS + 0.5 * SPACING))
            takes = 2.0 * SQUEEZE * math.tan(math.atan(FRICTION) - lean)
            net = watch.step().interactions
            pull = -net.force[(net.candidate == last) & (net.law == "rigid-wire"), 0].sum()
            push = net.force[net.antagonist == wall, 0].sum()
            off.append((pull / takes / (COUNT - 1) - 1.0, push / takes / COUNT - 1.0))
        pull, push = np.abs(off).max(axis=0) / (0.005 + 40.0 * tolerance)
        results.append(
            watch.result(
                Number("pull [0.005 + 40 tolerances]", float(pull), 1.0),
                Number("push on the wall [0.005 + 40 tolerances]", float(push), 1.0),
                Number("unsolved steps", float(watch.sim.unconverged_steps), 0.0),
            )
        )
    return worst_of(results)


def pulled_apart(solver, long: bool, **options: Any) -> Result:
    """A bead between two grains of 1 kg, linked to both, which are pulled apart with 1 N and 3 N; wires and rods; the bead
    in line, or beside it by a tenth of a link. Long: tolerances of 1e-2 to 1e-8.

    Hard: the bead, of 1 to 1e-6 of a grain, bears what moves both; from beside the line it whips, at h^2 T/(m l) up to
    3e2. Numbers: in line all move with a = 2 N/(2 M + m), and the links bear 1 N + M a and 3 N - M a, within 1e-6 from the
    first step on. From either place the momentum after ten steps, or 0.1 s, is that of the loads; links make a hundredth of
    the energy in a step at most, for the three steps of a jerk, and never more than they took.
    """
    results = []
    for ratio in RATIOS:
        for law in (lm.RigidWire(), lm.RigidRod()):
            for h in octaves(4e-3, 4):
                for tolerance in (1e-2, 1e-4, 1e-8) if long else (1e-8,):
                    results.append(apart(ratio, law, 0.0, 10, h, solver, tolerance, **options))
                    results.append(apart(ratio, law, 0.1, round(0.1 / h), h, solver, tolerance, **options))
    return worst_of(results)


def apart(
    ratio: float, law: lm.Law, aside: float, steps: int, h: float, solver, tolerance: float, **options: Any
) -> Result:
    """What so many steps make of it."""
    scene = lm.Scene(dimension=2)
    bodies = [
        scene.add(lm.disk(radius=0.02, position=(-0.1, 0.0), mass=1.0)),
        scene.add(lm.disk(radius=0.02, position=(0.0, 0.1 * aside), mass=1.0 / ratio)),
        scene.add(lm.disk(radius=0.02, position=(0.1, 0.0), mass=1.0)),
    ]
    bodies[0].impose_force(x=-1.0)
    bodies[2].impose_force(x=3.0)
    scene.chain(bodies, law)
    watch = watched(scene, h, solver, tolerance, **options)
    mass = np.array([1.0, 1.0 / ratio, 1.0])
    a = 2.0 / mass.sum()
    expected = np.array([1.0 + a, 3.0 - a])
    found = [-watch.step().interactions.force[:2, 0] / expected - 1.0 for _ in range(steps)]
    momentum = float(mass @ watch.sim.velocities[:, 0]) / (2.0 * watch.sim.time) - 1.0
    return watch.result(
        *([] if aside else [Number("tension in line", float(np.abs(found).max()), 1e-6)]),
        Number("momentum", abs(momentum), 1e-9),
        Number("energy made", watch.energy, 0.03),
        Number("gained", watch.gained, 1e-3),
    )


def tetherball(solver, long: bool, **options: Any) -> Result:
    """A ball of 1 kg at 1 m/s winds its wire of twenty links round a post, until five of them lie on it; beads of 1e-2 and
    1e-6 of the ball; 16 to 1 ms. Long: 1e-4 as well, tolerances of 1e-4 and 1e-8.

    Hard: the tension v^2/l of the ball goes through beads that lie on the post and others that do not, at
    s = 4 h^2 T/(m l) up to 1e5, and each bead comes to rest on the post in a blow. Numbers: the pull is across the ball's
    way, so that it keeps its speed, less what beads lose, half their mass over its, and what the turning of the free length
    l in a step leaves of the direction, h v/l; its angular momentum about the last bead on the post is v l. It turns about
    that bead by the angle 2 asin(s/2R) of a link s on the rim R from bead to bead, by half of that for the first, so that
    the time is the sum of these angles times l/v, within h a bead, as blows come at the end of a step. The chain is too
    long by what it turns in a step, (h v/l)^2/2, at most.
    """
    results = []
    for ratio in (1e2, 1e4, 1e6) if long else (1e2, 1e6):
        for h in octaves(16e-3, 4):
            for tolerance in (1e-4, 1e-8) if long else (1e-6,):
                with coarse():
                    results.append(wound(ratio, watched(tether(ratio), h, solver, tolerance, **options)))
    return worst_of(results)


POST, ROPE_BEAD, LINK, LINKS = 0.05, 0.004, 0.02, 20
"""Radii of post and beads, length of a link [m], links."""
RIM = POST + ROPE_BEAD


def tether(ratio: float) -> lm.Scene:
    """The wire leaves the post along y, with the ball at its end."""
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=POST, position=(0.0, 0.0), mass=1.0, color="POST")).fix()
    beads = []
    for i in range(LINKS + 1):
        tip = i == LINKS
        velocity = (-i / LINKS, 0.0)
        at = {"position": (RIM, LINK * i), "velocity": velocity, "color": "BALL" if tip else "BEAD"}
        beads.append(scene.add(lm.disk(radius=ROPE_BEAD, mass=1.0 if tip else 1.0 / ratio, **at)))
    beads[0].fix()
    scene.chain(beads, lm.RigidWire(), block_spin=True)
    scene.see("BEAD", "POST", lm.Signorini())
    return scene


def wound(ratio: float, watch: Watch) -> Result:
    """Until the wire has turned so far that a quarter of it lies on the post."""
    sim, h = watch.sim, watch.sim.time_step
    turn = 2.0 * math.asin(0.5 * LINK / RIM)
    laid = LINKS // 4
    angles = np.array([0.5 * turn, *[turn] * (laid - 1)])
    free = LINK * (LINKS - np.arange(laid))
    expected = float(angles @ free)
    direction = turned = 0.0
    longest = speed = 0.0
    while turned < angles.sum() and sim.time < 2.0 * expected:
        watch.step()
        x, y = sim.positions[-1] - sim.positions[-2]
        now = math.atan2(-x, y)
        turned += (now - direction + math.pi) % (2.0 * math.pi) - math.pi
        direction = now
        lengths = np.linalg.norm(np.diff(sim.positions[1:], axis=0), axis=1)
        longest = max(longest, float(lengths.sum()) / (LINK * LINKS) - 1.0)
        speed = max(speed, abs(float(np.linalg.norm(sim.velocities[-1])) - 1.0))
    late = sim.time - (turned - angles.sum()) * free[-1] - expected
    lost = 0.5 * LINKS / ratio
    return watch.result(
        Number("late [h a bead]", abs(late) / (h * laid + lost * expected), 1.0),
        Number("speed [beads and h v/l]", speed / (lost + h / free[-1]), 1.0),
        Number("length [(h v/l)²/2]", longest / (0.5 * (h / free[-1]) ** 2 + 1e-9), 1.0),
        Number("energy made", watch.energy, 1e-2),
        Number("gained", watch.gained, 1e-3),
        Number("unsolved steps", float(sim.unconverged_steps), 0.0),
    )
