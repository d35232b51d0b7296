"""What contacts leave out when their normals turn within a step: heavy bodies on light ones, by mass ratio and step.

The normal of a contact is that of the detection, as that of a link; but links have geometric stiffness and contacts have
none. Scenes in which a load presses light bodies: where normals turn against the motion (convex on convex: a pressed
grain is an inverted pendulum), where they turn with it (a ball in a groove: a pendulum), and where they do not turn
(rollers). By scene, mass ratio and step: ``s = h r_n / (m d)``, the largest of all contacts and steps, r_n the impulse, m
the lighter mass and d the distance of the centres (in the groove, of the ball from the axis); the energy that contacts
made, the largest rise of their work, in parts of what was turned over; the largest overlap in radii of the light bodies;
and a number that should not depend on the step.

    python benchmarks/contact_turning.py [--short]
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
from table import report

import lmgcpy as lm

sys.path.insert(0, str(Path(__file__).parent.parent / "tests" / "hard"))

from case import Watch

G = 9.81
RADIUS = 0.01
LIGHT = 1e-3
RATIOS = (1.0, 1e2, 1e4, 1e6)
STEPS = (4e-3, 2e-3, 1e-3, 5e-4, 2.5e-4, 1.25e-4)


def simulation(scene: lm.Scene, h: float) -> Watch:
    return Watch(lm.Simulation(scene, time_step=h, solver=lm.Auto(tolerance=1e-8), on_unconverged="ignore"))


def plate_in_plane(ratio: float, friction: float, h: float) -> tuple[Watch, Callable[[], float]]:
    """A plate comes down on sixty light disks of different size in a box; number: its height at the end [radii]."""
    rng = np.random.default_rng(0)
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.add(lm.wall(point=(0, 0), normal=(1, 0)))
    scene.add(lm.wall(point=(24.0 * RADIUS, 0), normal=(-1, 0)))
    for j in range(6):
        for i in range(10):
            radius = RADIUS * rng.uniform(0.7, 1.0)
            position = ((2.2 * i + 1.5 + 0.6 * (j % 2)) * RADIUS, (2.1 * j + 1.1) * RADIUS)
            scene.add(lm.disk(radius=radius, position=position, mass=LIGHT))
    plate = lm.wall(point=(0, 13.0 * RADIUS), normal=(0, -1), mass=ratio * LIGHT)
    scene.add(plate).impose_force(y=-ratio * LIGHT * G)
    law = lm.Coulomb(friction=friction)
    scene.see("GRAIN", "GRAIN", law)
    scene.see("GRAIN", "WALL", law)
    watch = simulation(scene, h)
    return watch, lambda: float(watch.sim.positions[plate.id, 1]) / RADIUS


def boulder_in_space(ratio: float, friction: float, h: float) -> tuple[Watch, Callable[[], float]]:
    """A boulder comes down on fifty light spheres in a box; number: its height at the end [radii]."""
    rng = np.random.default_rng(0)
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -G))
    side = 11.0 * RADIUS
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    for axis in range(2):
        for far in (False, True):
            point, normal = np.zeros(3), np.zeros(3)
            point[axis], normal[axis] = far * side, -1.0 if far else 1.0
            scene.add(lm.wall(point=point, normal=normal))
    for k in range(2):
        for j in range(5):
            for i in range(5):
                radius = RADIUS * rng.uniform(0.8, 1.0)
                position = np.array([2.1 * i + 1.3, 2.1 * j + 1.3, 2.1 * k + 1.1]) * RADIUS
                scene.add(lm.sphere(radius=radius, position=position, mass=LIGHT))
    large = 4.0 * RADIUS
    position = (0.5 * side + 0.1 * RADIUS, 0.5 * side, 9.0 * RADIUS)
    boulder = scene.add(lm.sphere(radius=large, position=position, mass=ratio * LIGHT))
    law = lm.Coulomb(friction=friction)
    scene.see("GRAIN", "GRAIN", law)
    scene.see("GRAIN", "WALL", law)
    watch = simulation(scene, h)
    return watch, lambda: float(watch.sim.positions[boulder.id, 2]) / RADIUS


def groove(ratio: float, friction: float, h: float) -> tuple[Watch, Callable[[], float]]:
    """A plate on two light spheres in a hollow half-cylinder of ten radii; number: the largest angle from its bottom, in
    parts of that at the start, 0.1."""
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -G))
    bore, start = 10.0 * RADIUS, 0.1
    reach = bore - RADIUS
    scene.add(lm.cylinder_wall(point=(0, 0, 0), axis=(0, 1, 0), radius=bore, color="BORE"))
    balls = []
    for y in (-0.1, 0.1):
        position = (reach * np.sin(start), y, -reach * np.cos(start))
        balls.append(scene.add(lm.sphere(radius=RADIUS, position=position, mass=LIGHT)).id)
    plate = lm.wall(point=(0, 0, RADIUS - reach * np.cos(start)), normal=(0, 0, -1), mass=ratio * LIGHT, color="PLATE")
    scene.add(plate).impose_force(z=-ratio * LIGHT * G)
    law = lm.Coulomb(friction=friction)
    scene.see("GRAIN", "BORE", law)
    scene.see("GRAIN", "PLATE", law)
    watch = simulation(scene, h)
    largest = [0.0]

    def number() -> float:
        x = watch.sim.positions[balls]
        largest[0] = max(largest[0], float(np.abs(np.arctan2(x[:, 0], -x[:, 2])).max()) / start)
        return largest[0]

    return watch, number


def rollers(ratio: float, friction: float, h: float) -> tuple[Watch, Callable[[], float]]:
    """A plate at 0.2 m/s on five light rollers; number: its speed at the end, in parts of that at which they roll."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    speed = 0.2
    scene.add(lm.wall(point=(0, 0), normal=(0, 1), color="FLOOR"))
    for i in range(5):
        position, spin = (4.0 * i * RADIUS, RADIUS), -0.5 * speed / RADIUS
        scene.add(lm.disk(radius=RADIUS, position=position, mass=LIGHT, velocity=(0.5 * speed, 0.0), spin=spin))
    plate = lm.wall(point=(0, 2.0 * RADIUS), normal=(0, -1), mass=ratio * LIGHT, color="PLATE")
    scene.add(plate).impose_force(x=0.0, y=-ratio * LIGHT * G)
    plate.velocity[0] = speed
    law = lm.Coulomb(friction=friction)
    scene.see("GRAIN", "FLOOR", law)
    scene.see("GRAIN", "PLATE", law)
    watch = simulation(scene, h)
    return watch, lambda: float(watch.sim.velocities[plate.id, 0]) / speed


SCENES = [
    ("plate on disks", plate_in_plane, (0.0, 0.3), 0.3),
    ("boulder on spheres", boulder_in_space, (0.0, 0.3), 0.3),
    ("balls in a groove", groove, (0.0, 0.3), 0.5),
    ("plate on rollers", rollers, (0.3,), 0.3),
]


def measure(make: Callable, ratio: float, friction: float, h: float, duration: float) -> list:
    watch, number = make(ratio, friction, h)
    sim, turning, overlap, value = watch.sim, 0.0, 0.0, 0.0
    mass = sim.model.mass[:, 0]
    driven = sim.model.inverse_mass[:, : sim.model.dimension].max(axis=1) == 0.0
    weight = np.where(driven, np.inf, mass)
    extent = np.where(np.isfinite(sim.model.extent), sim.model.extent, 0.0)
    for _ in range(round(duration / h)):
        watch.step()
        net = sim.interactions
        value = number()
        if len(net):
            distance = np.maximum(extent[net.candidate] + extent[net.antagonist], RADIUS)
            if make is groove:
                distance = np.full(len(net), 9.0 * RADIUS)
            lighter = np.minimum(weight[net.candidate], weight[net.antagonist])
            turning = max(turning, float((h * net.impulse[:, 0] / (lighter * distance)).max()))
            overlap = max(overlap, -float(net.gap.min()) / RADIUS)
    # nothing may move: then the energy that loads give in a step from rest is the measure, as it is for gravity
    thrust = 0.5 * ratio * LIGHT * (G * h) ** 2
    made = watch.energy * watch.turned / max(watch.turned, thrust)
    return [turning, made, overlap, value, sim.unconverged_steps, watch.seconds]


def main(short: bool) -> None:
    rows = []
    for name, make, frictions, duration in SCENES:
        for friction in frictions:
            for ratio in RATIOS:
                for h in STEPS[1:4] if short else STEPS:
                    with warnings.catch_warnings(record=True) as told:
                        warnings.simplefilter("always", RuntimeWarning)
                        s, energy, overlap, value, bad, seconds = measure(make, ratio, friction, h, duration)
                    row = [name, f"{friction:g}", f"{ratio:.0e}", f"{h:g}", f"{s:.2g}", f"{energy:.1e}", f"{overlap:.3f}"]
                    late = any("seen late" in str(warning.message) for warning in told)
                    rows.append([*row, f"{value:.4f}", "yes" if late else "no", bad, f"{seconds:.1f}"])
                    print(rows[-1], file=sys.stderr, flush=True)
    header = ["scene", "friction", "mass ratio", "h [s]", "s", "energy made", "overlap [radii]", "number"]
    header += ["told that it moves too far", "steps not solved", "seconds"]
    report("contact_turning", header, rows)


if __name__ == "__main__":
    main("--short" in sys.argv[1:])
