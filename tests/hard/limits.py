"""Hard cases at the limits: no solution, no friction or too much, too many rods, degenerate geometry, any unit."""

from __future__ import annotations

import math

import numpy as np
from case import Number, Result, Watch, worst_of
from wires import Lengths, momenta

import lmgcpy as lm

G = 9.81


def crushed(solver, long: bool) -> Result:
    """A column of ten disks between a fixed plate and one that comes down at an imposed velocity: no solution exists.

    Hard: impulses grow without bound and no matrix is regular; the wrong answers are an exception, a NaN, or
    "converged". Number: the approaches at the eleven contacts always sum to V. Where all act, e = u, and the least
    that |e| can be is V/sqrt(11), while doing nothing leaves e = V at one contact: no residual below 1/sqrt(11) can
    be honest. It is to be there, at most twice that; the status must not be "converged"; the worst interaction be
    named; all numbers finite.
    """
    count, radius, speed = 10, 0.1, 0.01
    scene = lm.Scene(dimension=2)
    for i in range(count):
        scene.add(lm.disk(radius=radius, position=(0.0, (2 * i + 1) * radius), mass=1.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.add(lm.wall(point=(0, 2 * count * radius), normal=(0, -1))).impose_velocity(y=-speed)
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore")
    watch = Watch(sim)
    watch.step()
    report, floor = sim.report, 1.0 / math.sqrt(count + 1)
    finite = all(np.isfinite(x).all() for x in (sim.positions, sim.velocities, sim.interactions.impulse))
    told = report.status != "converged" and report.worst is not None and report.worst.law == "coulomb"
    return watch.result(
        Number("below the least residual", max(0.0, 1.0 - report.residual / floor), 1e-9),
        Number("residual over the least", report.residual / floor, 2.0),
        Number("silent or not finite", float(not (finite and told)), 0.0),
    )


def slope(friction: float, degrees: float, solver) -> Result:
    """A flat sledge on twenty feet, on an incline: it slides at ``g (sin - mu cos)``, or it stays."""
    angle = math.radians(degrees)
    down, up = np.array([math.cos(angle), -math.sin(angle)]), np.array([math.sin(angle), math.cos(angle)])
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    plane = scene.add(lm.wall(point=(0, 0), normal=up))
    feet = [(lm.DiskContactor(0.01), tuple(x * down)) for x in np.linspace(-1.0, 1.0, 20)]
    sledge = scene.add(lm.RigidBody(feet, mass=3.0, inertia=1.0, position=0.01 * up, color="SLEDGE"))
    scene.see("SLEDGE", "WALL", lm.Coulomb(friction=friction))
    h, steps = 1e-3, 20
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore"))
    sim = watch.run(steps)
    expected = max(0.0, G * (math.sin(angle) - friction * math.cos(angle))) * h * steps
    moving = sim.velocities[sledge.id] - expected * down
    net = sim.interactions
    at_plane = (net.candidate == plane.id) | (net.antagonist == plane.id)
    pressed = net.force[at_plane, 0].sum() / (3.0 * G * math.cos(angle)) - 1.0
    return watch.result(
        Number("velocity", float(np.linalg.norm(moving)) / (G * h * steps), 1e-8), Number("reaction", abs(pressed), 1e-8)
    )


def friction_of_any_size(solver, long: bool) -> Result:
    """A sledge of twenty feet on inclines, with friction 0, 0.3 and 10.

    Hard: 40 impulses hold three freedoms, feet share an inertia that couples n and t (W_nt), and at mu = 10 a foot's
    friction is ten times its pressure. Numbers: it slides at g (sin - mu cos), or stays where tan <= mu, to 1e-8 of g
    t (without friction on 30 degrees; with 0.3 on 10 and on 30; with 10 on 80, tan = 5.7, and on 85, tan = 11.4); the
    plane presses it with m g cos, to 1e-8.
    """
    inclines = ((0.0, 30.0), (0.3, 10.0), (0.3, 30.0), (10.0, 80.0), (10.0, 85.0))
    return worst_of([slope(friction, degrees, solver) for friction, degrees in inclines])


def wheel(solver, long: bool) -> Result:
    """A wheel of rigid rods, a rim of twelve beads and six diameters through its hub, flung and spinning.

    Hard: closed chains, and 24 rods for the 23 freedoms of shape: one state of self-stress, W singular; chains cross
    at the hub and at the rim, so that no block holds all of it. Numbers, as a rigid body's turning stretches all rods
    by the same second order, 1 + (h omega)^2/2, which is compatible with itself: angular momentum about the origin
    and linear momentum to 1e-10; the rim's lengths within Pythagoras (see ``Lengths``) to 1e-8; and, as omega R^2 is
    kept, the rate of turning omega within (h omega)^2.
    """
    count, radius, spin, h = 12, 1.0, 3.0, 1e-3
    scene = lm.Scene(dimension=2)
    drift = np.array([0.5, -0.2])
    hub = scene.add(lm.disk(radius=0.01, position=(0.0, 0.0), mass=2.0, velocity=drift))
    rim = []
    for i in range(count):
        angle = 2.0 * math.pi * i / count
        out = np.array([math.cos(angle), math.sin(angle)])
        velocity = drift + spin * radius * np.array([-out[1], out[0]])
        rim.append(scene.add(lm.disk(radius=0.01, position=radius * out, mass=1.0, velocity=velocity)))
    scene.chain(rim, lm.RigidRod(), closed=True)
    for i in range(count // 2):
        scene.chain([rim[i], hub, rim[i + count // 2]], lm.RigidRod())
    sim = lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore")
    watch, lengths = Watch(sim), Lengths(sim, 1, count, 2.0 * radius * math.sin(math.pi / count))
    start = momenta(sim)
    for _ in range(5000 if long else 500):
        watch.step()
        lengths.enter()
    change = np.abs(momenta(sim) - start) / (np.linalg.norm(start[:2]), np.linalg.norm(start[:2]), abs(start[2]))
    arm = sim.positions[1:] - sim.positions[0]
    moving = sim.velocities[1:] - sim.velocities[0]
    turning = (arm[:, 0] * moving[:, 1] - arm[:, 1] * moving[:, 0]) / (arm**2).sum(axis=1)
    return watch.result(
        Number("momentum", float(change.max()), 1e-10),
        Number("length", lengths.excess, 1e-8),
        Number("spin", float(np.abs(turning / spin - 1.0).max()), (h * spin) ** 2),
    )


def rod_column(solver, long: bool) -> Result:
    """The accident of the paper's rods: a column of twenty-one stands in a sample and carries the lid.

    Hard: a straight column of rigid rods and the columns of grains that hold it share the load in many ways, and the
    paper's support reaction jumps where one takes it all; where rods and contacts meet in every body, sweeps are
    slow. Number: between frictionless walls the floor carries the load of the lid, its weight and all grains', to
    1e-6, at the first step, cold.
    """
    wide, high, radius, load = 9, 21, 0.01, 1e4
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    floor = scene.add(lm.wall(point=(0, 0), normal=(0, 1), color="PLATE"))
    for x, normal in ((0.0, (1, 0)), (2 * radius * wide, (-1, 0))):
        scene.add(lm.wall(point=(x, 0), normal=normal, color="SIDE"))
    lid = scene.add(lm.wall(point=(0, 2 * radius * high), normal=(0, -1), color="PLATE", mass=50.0))
    lid.impose_force(y=-load)
    column = []
    for j in range(high):
        for i in range(wide):
            position = (2 * i + 1) * radius, (2 * j + 1) * radius
            disk = scene.add(lm.disk(radius=radius, position=position, mass=1.0))
            if i == wide // 2:
                column.append(disk)
    scene.chain(column, lm.RigidRod())
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.5), alert=0.1 * radius)
    scene.see("GRAIN", "PLATE", lm.Coulomb(friction=0.5), alert=0.1 * radius)
    scene.see("GRAIN", "SIDE", lm.Coulomb(friction=0.0), alert=0.1 * radius)
    watch = Watch(lm.Simulation(scene, time_step=1e-4, solver=solver, on_unconverged="ignore"))
    net = watch.step().interactions
    foot = float(net.force[(net.candidate == floor.id) | (net.antagonist == floor.id), 0].sum())
    weight = load + wide * high * 1.0 * G
    return watch.result(Number("foot reaction", abs(foot / weight - 1.0), 1e-6))


def degenerate(solver, long: bool) -> Result:
    """Geometry that has no direction or no room, and scenes with nothing in them.

    Hard: a normal is 0/0, a list is empty, a sum has one term or forty. Numbers, each to 1e-9 of what it is measured
    by: two disks whose centres coincide stay where they are, and keep their momentum where they move; a disk that
    touches a floor at a gap of exactly zero presses it with its weight in the first step; two beads on a slack wire
    fly through each other, their centres meeting exactly at a detection, and keep their velocities; forty disks
    pressed against one body by F each touch it with F each; bodies out of reach and empty scenes make steps that are
    solved, with no interaction.
    """
    results = [coincident(solver), touching(solver), slack(solver), forty(solver)]
    for bodies in (0, 1, 2):
        for dimension in (2, 3):
            results.append(lonely(bodies, dimension, solver))
    return worst_of(results)


def coincident(solver) -> Result:
    """Two disks with one centre, moving apart, and two at rest."""
    scene = lm.Scene(dimension=2)
    apart = np.array([[0.3, 0.1], [-0.3, -0.1]])
    for velocity in apart:
        scene.add(lm.disk(radius=0.1, position=(1.0, 1.0), mass=1.0, velocity=velocity))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    # at theta = 1 the first detection is where the bodies start
    watch = Watch(lm.Simulation(scene, time_step=1e-3, theta=1.0, solver=solver, overlap="ignore"))
    sim = watch.step()
    kept = float(np.abs(sim.velocities.sum(axis=0)).max())
    finite = np.isfinite(sim.positions).all() and np.isfinite(sim.velocities).all()
    resting = lm.Scene(dimension=2)
    for _ in range(2):
        resting.add(lm.disk(radius=0.1, position=(1.0, 1.0), mass=1.0))
    resting.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    still = lm.Simulation(resting, time_step=1e-3, solver=solver, overlap="ignore").run(steps=3)
    return watch.result(
        Number("coincident", kept if finite else math.inf, 1e-9),
        Number("coincident at rest", float(np.abs(still.velocities).max()), 1e-9),
    )


def touching(solver) -> Result:
    """A disk on a floor at a gap of exactly zero."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    scene.add(lm.disk(radius=0.5, position=(0.0, 0.5), mass=2.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    watch = Watch(lm.Simulation(scene, time_step=1e-3, solver=solver))
    net = watch.step().interactions
    assert net.gap[0] == 0.0
    return watch.result(Number("zero gap", abs(float(net.force[0, 0]) / (2.0 * G) - 1.0), 1e-9))


def slack(solver) -> Result:
    """Two beads on a slack wire that meet, centre on centre, at the third detection."""
    scene = lm.Scene(dimension=2)
    h, speed = 0.125, 0.5  # powers of two: they meet exactly
    for side in (-1.0, 1.0):
        position = 2.5 * h * speed * side, 0.0
        scene.add(lm.disk(radius=0.01, position=position, mass=1.0, velocity=(-speed * side, 0.0)))
    scene.chain(scene.bodies, lm.RigidWire(), reference_gap=1.0)
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver))
    met = False
    for _ in range(6):
        net = watch.step().interactions
        met |= bool(net.gap[0] == -0.02)
    assert met
    off = watch.sim.velocities - np.array([[speed, 0.0], [-speed, 0.0]])
    return watch.result(Number("zero length", float(np.abs(off).max()), 1e-9))


def forty(solver) -> Result:
    """Forty disks pressed against one."""
    count, small, load = 40, 0.05, 7.0
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=1.0, position=(0.0, 0.0), mass=1.0, color="HUB"))
    for i in range(count):
        out = np.array([math.cos(2.0 * math.pi * i / count), math.sin(2.0 * math.pi * i / count)])
        disk = scene.add(lm.disk(radius=small, position=(1.0 + small) * out, mass=1.0))
        disk.impose_force(x=-load * out[0], y=-load * out[1])
    scene.see("GRAIN", "HUB", lm.Coulomb(friction=0.3))
    watch = Watch(lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore"))
    force = watch.step().interactions.force[:, 0]
    assert len(force) == count
    return watch.result(Number("forty on one", float(np.abs(force / load - 1.0).max()), 1e-9))


def lonely(bodies: int, dimension: int, solver) -> Result:
    """So many bodies, out of each other's reach."""
    scene = lm.Scene(dimension=dimension)
    make = lm.disk if dimension == 2 else lm.sphere
    for i in range(bodies):
        scene.add(make(radius=0.1, position=(10.0 * i, *(0.0,) * (dimension - 1)), mass=1.0))
    if bodies:
        scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    watch = Watch(lm.Simulation(scene, time_step=1e-3, solver=solver))
    sim = watch.run(3)
    solved = sim.report.status == "converged" and len(sim.interactions.gap) == 0
    return watch.result(Number("nothing there", 0.0 if solved else math.inf, 1e-9))


def heap(scale: float, steps: int, solver) -> tuple[Watch, np.ndarray, np.ndarray]:
    """A wire of twelve beads among ninety disks that fall on a floor, ``scale`` times as large."""
    rng = np.random.default_rng(1)
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    material = lm.Material("sand", density=2600.0)
    radius = 0.45 * scale
    for point, normal in (((0, 0), (0, 1)), ((-0.5 * scale, 0), (1, 0)), ((11.5 * scale, 0), (-1, 0))):
        scene.add(lm.wall(point=point, normal=normal))
    disks = []
    for j in range(8):
        for i in range(12):
            position = scale * np.array([i, 0.46 + 0.92 * j]) + scale * 0.02 * rng.uniform(-1.0, 1.0, 2)
            # velocities go with the root of the lengths, as gravity does not change
            velocity = 0.3 * math.sqrt(scale) * rng.normal(0.0, 1.0, 2)
            disks.append(scene.add(lm.disk(radius=radius, position=position, material=material, velocity=velocity)))
    scene.chain(disks[36:48], lm.RigidWire())
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    h = 5e-3 * math.sqrt(scale)
    watch = Watch(lm.Simulation(scene, time_step=h, solver=solver, on_unconverged="ignore"))
    sim = watch.run(steps)
    return watch, sim.positions / scale, sim.velocities / math.sqrt(scale)


def units(solver, long: bool) -> Result:
    """The same heap, with its wire, in metres, microns, inches and kilometres.

    Hard: any tolerance, gap or speed that hides a unit shows. Lengths times s, times and velocities times sqrt(s)
    under the same gravity, masses times s^2, is the same motion (Froude). Number: positions and velocities in those
    units after 40 steps, against the metre's, to 1e-10: a residual of 1e-12 with what the heap's slowest modes make
    of it, and rounding.
    """
    steps = 200 if long else 40
    watch, positions, velocities = heap(1.0, steps, solver)
    results = []
    for scale in (1e-6, 0.0254, 1e3):
        other, x, v = heap(scale, steps, solver)
        off = max(float(np.abs(x - positions).max()), float(np.abs(v - velocities).max()))
        results.append(other.result(Number("difference", off, 1e-10)))
    return worst_of([watch.result(), *results])
