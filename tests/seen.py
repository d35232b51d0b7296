"""Scenes of which one knows what a picture must show, and what pixels show."""

from __future__ import annotations

import numpy as np

import lmgcpy as lm
from lmgcpy.view.drawing import rgb

SIDE = 1.0


def wire_in_a_box(*, overlap=0.0, stretch=1.0):
    """A wire of five beads across a cubic box, and two grains above it that overlap by a part of their radius."""
    scene = lm.Scene(dimension=3)
    beads = [
        scene.add(lm.sphere(radius=0.02, position=(0.1 + 0.2 * i, 0.5, 0.3), mass=1.0, color="BEAD")) for i in range(5)
    ]
    radius = 0.1
    apart = (2.0 - overlap) * radius
    for x in (0.3, 0.3 + apart):
        scene.add(lm.sphere(radius=radius, position=(x, 0.5, 0.7), mass=1.0))
    for k in range(3):
        normal = np.eye(3)[k]
        scene.add(lm.wall(point=(0, 0, 0), normal=normal))
        scene.add(lm.wall(point=SIDE * normal, normal=-normal))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    scene.chain(beads, lm.ElasticWire(stiffness=1.0), reference_gap=0.2 / stretch - 0.04)
    return scene


def hanging(count=3, dimension=2, weight=1.0):
    """A chain of equal beads of a weight [N] below a fixed one, after one step at rest: the tension of link i is that of
    the ``count - i`` beads below it."""
    scene = lm.Scene(dimension=dimension, gravity=(*(0.0,) * (dimension - 1), -10.0))
    make = lm.disk if dimension == 2 else lm.sphere
    zero = (0.0,) * (dimension - 1)
    bodies = [scene.add(make(radius=0.1, position=(*zero, -float(i)), mass=0.1 * weight)) for i in range(count + 1)]
    bodies[0].fix()
    scene.chain(bodies, lm.RigidWire())
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12))
    sim.step()
    return sim


def pile(count=3, dimension=2):
    """A column of equal balls of 1 N on a floor, after one step at rest: the contact below ball i carries ``count - i``."""
    scene = lm.Scene(dimension=dimension, gravity=(*(0.0,) * (dimension - 1), -10.0))
    make = lm.disk if dimension == 2 else lm.sphere
    zero = (0.0,) * (dimension - 1)
    for i in range(count):
        scene.add(make(radius=0.5, position=(*zero, 0.5 + i), mass=0.1))
    scene.add(lm.wall(point=(*np.add(zero, 0.7), 0.0), normal=(*zero, 1.0)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12))
    sim.step()
    return sim


def pixels(path):
    """An image, (height, width, 3) of uint8."""
    from PIL import Image

    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"))


def like(image, color, within=20):
    """Where an image has a colour, to ``within`` of 255 in each part, (height, width) bool."""
    return (np.abs(image.astype(int) - rgb(color).astype(int)) <= within).all(axis=2)


def reddish(image):
    """Where it is red, however lit."""
    red, green, blue = (image[..., k].astype(int) for k in range(3))
    return (red > 90) & (green < red // 3) & (blue < red // 3)
