"""Hard cases of contact: heavy on light, wedged and indeterminate, large on small."""

from __future__ import annotations

import math
import time as clock
from dataclasses import replace

import numpy as np
from case import Number, Result, Watch

import lmgcpy as lm

G = 9.81


def column(solver, long: bool) -> Result:
    """A column of 100 spheres carries a body of 1e4 times their mass together.

    Hard: Gauss-Seidel moves what a sphere carries by one sphere a sweep, and of the million-fold mass on top each
    visit takes a millionth. Number: the reaction of the floor is the weight, 100 m g + 1e6 m g, at the first step,
    cold, to 1e-6.
    """
    count, radius, mass = 100, 0.01, 1e-3
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -G))
    floor = scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    for i in range(count):
        scene.add(lm.sphere(radius=radius, position=(0.0, 0.0, (2 * i + 1) * radius), mass=mass))
    top = 10 * radius
    scene.add(lm.sphere(radius=top, position=(0.0, 0.0, 2 * count * radius + top), mass=1e4 * count * mass))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3), alert=0.1 * radius)
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3), alert=0.1 * radius)
    watch = Watch(lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore"))
    net = watch.step().interactions
    foot = float(net.force[(net.candidate == floor.id) | (net.antagonist == floor.id), 0].sum())
    weight = (1e4 + 1.0) * count * mass * G
    return watch.result(Number("foot reaction", abs(foot / weight - 1.0), 1e-6))


def from_ten_starts(watch: Watch, solver) -> Result:
    """Solve the first step of a scene at rest from its own start and from ten random ones within the cones.

    The starts are of up to a hundred times the weight's impulse. Velocities must vanish from all of them, in parts of g h;
    impulses may differ, by self-stresses that the friction holds, but not exceed ten times the largest start.
    """
    sim = watch.step()
    problem, h = sim.problem(), sim.time_step
    weight = -h * float(sim.model.weight.sum())
    rng = np.random.default_rng(0)
    slowest = residual = largest = seconds = 0.0
    for _ in range(10):
        guess = 100.0 * weight * rng.uniform(-1.0, 1.0, problem.guess.shape)
        guess[:, 0] = np.abs(guess[:, 0])
        guess[:, 1:] *= problem.mu[:, None] * guess[:, :1] / (100.0 * weight)
        begin = clock.process_time()
        solution = lm.solve(problem, solver=solver, guess=guess)
        seconds += clock.process_time() - begin
        residual = max(residual, solution.residual)
        slowest = max(slowest, float(np.abs(solution.velocities[solution.impulses[:, 0] > 0.0]).max()))
        largest = max(largest, float(np.abs(solution.impulses).max()) / (1e3 * weight))
    still = float(np.abs(sim.velocities).max())
    result = watch.result(Number("velocity", max(slowest, still) / (G * h), 1e-6), Number("impulse", largest, 1.0))
    return replace(result, residual=max(result.residual, residual), seconds=result.seconds + seconds)


def wedge(solver, long: bool) -> Result:
    """A disk hangs by friction in a narrow wedge of two walls.

    Hard: with a half-angle of 15 degrees, less than the angle of friction, 27 degrees, the disk holds any self-stress
    whatever: impulses are indeterminate and unbounded, and a start with a large one is as good as the right one.
    Numbers: see ``from_ten_starts``; at rest, whatever the start.
    """
    half, radius = math.radians(15.0), 0.1
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    scene.add(lm.disk(radius=radius, position=(0.0, radius / math.sin(half)), mass=1.0))
    for side in (1.0, -1.0):
        scene.add(lm.wall(point=(0, 0), normal=(side * math.cos(half), math.sin(half))))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.5))
    sim = lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore")
    return from_ten_starts(Watch(sim), solver)


def arch(solver, long: bool) -> Result:
    """A half-circle arch of eleven stones, each of four disks, between two fixed ones.

    Hard: every joint has two contacts with friction, 48 unknowns for the 33 freedoms of the stones. Thickness over
    radius is 0.4, far above the 0.11 at which such an arch falls (Heyman), and its friction 0.7, so that it stands.
    Numbers: see ``from_ten_starts``; at rest, whatever the start.
    """
    count, middle, half, corner = 11, 1.0, 0.2, 0.02
    turn = math.pi / count
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    for i in range(-1, count + 1):
        angle = (i + 0.5) * turn
        disks = []
        for r in (middle - half, middle + half):
            # faces lie on the joints' radii: the disks' centres are a corner's radius from them
            inset = 0.5 * turn - math.asin(corner / r)
            for side in (-1.0, 1.0):
                x, y = r * math.cos(angle + side * inset), r * math.sin(angle + side * inset)
                centre = middle * math.cos(angle), middle * math.sin(angle)
                disks.append((lm.DiskContactor(corner), (x - centre[0], y - centre[1])))
        stone = lm.RigidBody(disks, mass=1.0, inertia=0.02, position=centre, color="STONE")
        scene.add(stone)
        if i in (-1, count):
            stone.fix()
    scene.see("STONE", "STONE", lm.Coulomb(friction=0.7), alert=0.1 * corner)
    sim = lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore")
    return from_ten_starts(Watch(sim), solver)


def boulder(solver, long: bool) -> Result:
    """A boulder on three grains of a thousandth of its radius, among four hundred others on the floor.

    Hard: masses differ by 1e9, so that a grain between boulder and floor gives Gauss-Seidel a billionth a sweep;
    neighbours are to be found across three orders of size; and of a grain's velocity arithmetic leaves 1e-7 g h, with
    half the boulder's weight on it. Number: the three press the floor with the boulder's weight and their own, at the
    first step, cold, to 1e-6. (How the three share it, friction leaves open.)
    """
    large, small, density = 1.0, 1e-3, 2600.0
    material = lm.Material("rock", density=density)
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -G))
    floor = scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    ring = 2.5 * small
    feet = []
    for k in range(3):
        angle = 2.0 * math.pi * k / 3.0
        feet.append((ring * math.cos(angle), ring * math.sin(angle), small))
    for position in feet:
        scene.add(lm.sphere(radius=small, position=position, material=material))
    height = small + math.sqrt((large + small) ** 2 - ring**2)
    boulder = scene.add(lm.sphere(radius=large, position=(0.0, 0.0, height), material=material))
    for i in range(-10, 11):
        for j in range(-10, 11):
            if max(abs(i), abs(j)) > 2 and math.hypot(i, j) > 4:
                position = (3.0 * small * i, 3.0 * small * j, small)
                scene.add(lm.sphere(radius=small, position=position, material=material))
    law = lm.Coulomb(friction=0.3)
    scene.see("GRAIN", "GRAIN", law, alert=0.01 * small)
    scene.see("GRAIN", "WALL", law, alert=0.01 * small)
    watch = Watch(lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore"))
    net = watch.step().interactions
    of_floor = (net.candidate == floor.id) | (net.antagonist == floor.id)
    grain = np.where(net.candidate == floor.id, net.antagonist, net.candidate)
    reaction = float(net.force[of_floor & (grain <= 3), 0].sum())
    expected = G * (boulder.mass + 3.0 * scene.bodies[1].mass)
    return watch.result(Number("foot reaction", abs(reaction / expected - 1.0), 1e-6))
