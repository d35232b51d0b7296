"""A scene with a bit of everything, for tests of what must hold in any step."""

from __future__ import annotations

import math

import numpy as np

import lmgcpy as lm

LAWS = {
    "coulomb": lm.Coulomb(friction=0.5),
    "restitution": lm.Restitution(friction=0.3, restitution=0.6),
    "rigid-wire": lm.RigidWire(),
    "rigid-rod": lm.RigidRod(),
    "elastic-wire": lm.ElasticWire(axial_rigidity=200.0),
    "voigt-rod": lm.VoigtRod(stiffness=500.0, viscosity=3.0),
}
"""The laws in it, by name."""


def mixed_scene(seed: int = 0) -> lm.Scene:
    """Grains, dumbbells, an inextensible wire, a rod, an elastic wire and a ring of dampers thrown into a box.

    Its floor shakes, its right wall is pushed in by a force, one grain is held in x, one is driven round.
    """
    rng = np.random.default_rng(seed)
    scene = lm.Scene(dimension=2, gravity=(1.0, -9.81))
    places = [(0.3 * (i % 8) + 0.15, 0.3 * (i // 8) + 0.2) for i in range(48)]
    disks = []
    for x, y in places[:40]:
        radius = rng.uniform(0.07, 0.13)
        mass = math.pi * radius**2 * 100.0
        start = {"velocity": rng.normal(0.0, 1.5, 2), "spin": rng.normal(0.0, 5.0)}
        disks.append(scene.add(lm.disk(radius=radius, position=(x, y), mass=mass, **start)))
    for x, y in places[40:44]:
        contactors = [(lm.DiskContactor(0.06), (-0.07, 0.0)), (lm.DiskContactor(0.07), (0.06, 0.0))]
        start = {"rotation": rng.uniform(0.0, 6.0), "velocity": rng.normal(0.0, 1.5, 2), "spin": rng.normal(0.0, 5.0)}
        scene.add(lm.RigidBody(contactors, mass=3.0, inertia=0.02, position=(x, y), color="GRAIN", **start))
    disks[3].fix("x")
    disks[20].impose_velocity(spin=lambda t: 10.0 * math.sin(5.0 * t))
    disks[21].impose_force(x=lambda t: 30.0 * math.cos(7.0 * t), spin=0.3)
    scene.add(lm.wall(point=(0, 0), normal=(0, 1))).impose_velocity(y=lambda t: 0.3 * math.cos(20.0 * t), x=0.1)
    scene.add(lm.wall(point=(0, 0), normal=(1, 0)))
    scene.add(lm.wall(point=(2.4, 0), normal=(-1, 0.05), mass=20.0)).impose_force(x=-40.0)
    scene.see("GRAIN", "GRAIN", LAWS["coulomb"])
    scene.see("WALL", "GRAIN", LAWS["restitution"])
    scene.chain(disks[8:16], LAWS["rigid-wire"])
    scene.chain(disks[24:27], LAWS["rigid-rod"])
    scene.chain(disks[32:38], LAWS["elastic-wire"])
    scene.chain([disks[i] for i in (18, 19, 28, 27)], LAWS["voigt-rod"], closed=True)
    return scene
