"""Every feature of a scene beside every other: the balance of energy closes, and a run goes on from its file bit for bit.

What two features cannot do together is refused with a sentence: ``REFUSED``.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import lmgcpy as lm

STEPS, H = 12, 1e-3
SIDE = 1.0


class Scene:
    """A scene of six grains that features change, and what is done to it after a step."""

    def __init__(self, dimension):
        self.dimension, self.law, self.periodic, self.bead_mass = dimension, lm.Coulomb(friction=0.3), None, 0.1
        self.after = []
        self.scene = lm.Scene(dimension=dimension, gravity=[0.0] * (dimension - 1) + [-9.81])
        self.make = lm.disk if dimension == 2 else lm.sphere
        rng = np.random.default_rng(0)
        self.grains = [
            self.scene.add(self.make(radius=0.05, position=self.at(0.1 + 0.13 * k, 0.3), mass=1.0, velocity=v))
            for k, v in enumerate(rng.normal(size=(6, dimension)))
        ]

    def at(self, x, y):
        return [x] + [0.5] * (self.dimension - 2) + [y]

    def beads(self, y, count=5):
        """A row of beads to be linked."""
        alike = {"radius": 0.02, "mass": self.bead_mass, "color": "BEAD", "velocity": self.at(0.0, 0.5)}
        return [self.scene.add(self.make(position=self.at(0.1 + 0.1 * k, y), **alike)) for k in range(count)]

    def simulation(self):
        """Walls or a cell come last."""
        scene = self.scene
        if self.periodic is not None:
            self.periodic(scene.periodic(**dict.fromkeys("xyz"[: self.dimension], SIDE)))
        else:
            floor = [0.0] * (self.dimension - 1) + [1.0]
            scene.add(lm.wall(point=self.at(0.0, 0.2), normal=floor))
        for color in ("GRAIN", "BEAD") if scene.chains else ("GRAIN",):
            scene.see("GRAIN", color, self.law)
            if self.periodic is None:
                scene.see(color, "WALL", self.law)
        options = {"time_step": H, "solver": lm.Auto(tolerance=1e-8), "on_unconverged": "ignore", "overlap": "ignore"}
        return lm.Simulation(scene, **options)


def wire(s):
    s.scene.chain(s.beads(0.45), lm.RigidWire())


def closed(s):
    s.scene.chain(s.beads(0.6, 8), lm.ElasticRod(stiffness=1e4), closed=True)


def relaxing(s):
    s.scene.chain(s.beads(0.7), lm.RigidRod(), reference_gap=0.055, relaxation=0.008)


def winch(s):
    chain = s.scene.chain(s.beads(0.8), lm.ElasticWire(stiffness=1e4))
    s.after.append((2, lambda sim: setattr(sim.scene.chains[s.scene.chains.index(chain)], "reference_gap", 0.055)))


def light(s):
    s.bead_mass = 1e-4
    s.scene.chain(s.beads(0.375), lm.RigidWire())


def cluster(s):
    pair = [(lm.DiskContactor(0.03), (-0.02, 0.0)), (lm.DiskContactor(0.03), (0.02, 0.0))]
    s.scene.add(lm.RigidBody(pair, mass=1.0, inertia=1e-3, position=(0.9, 0.3), rotation=0.3, color="GRAIN"))


def cylinder(s):
    drum = s.scene.add(lm.cylinder_wall(point=(0.5, 0.5, 0.5), axis=(0, 1, 0), radius=0.6, color="DRUM"))
    drum.impose_velocity(spin_y=1.0)
    s.scene.see("GRAIN", "DRUM", s.law)


def restitution(s):
    s.law = lm.Restitution(restitution=0.5)


def rolling(s):
    s.law = lm.RollingCoulomb(friction=0.3, rolling_friction=0.05)


def held_cell(s):
    s.periodic = lambda cell: cell.impose_rate(xz=1.0) if s.dimension == 3 else cell.impose_rate(xy=1.0)


def yielding_cell(s):
    s.periodic = lambda cell: cell.impose_stress(xx=-10.0)


def drag(s):
    s.scene.drag(linear=0.5, quadratic=0.1)


def driven(s):
    s.grains[0].impose_velocity(x=0.3)
    s.grains[1].impose_force(x=5.0)


def hidden(s):
    s.grains[2].hide()
    s.after.append((4, lambda sim: sim.scene.bodies[2].show()))


def tilted(s):
    down = np.zeros(s.dimension)
    down[0] = 2.0
    s.after.append((3, lambda sim: setattr(sim.scene, "gravity", down)))


FEATURES = {
    f.__name__: f
    for f in (
        *(wire, closed, relaxing, winch, light, cluster, cylinder, restitution, rolling),
        *(held_cell, yielding_cell, drag, driven, hidden, tilted),
    )
}
ONLY = {"cluster": 2, "cylinder": 3}
ONE_OF = ({"restitution", "rolling"}, {"held_cell", "yielding_cell"})
REFUSED = {
    # walls and drums must look the same from every image
    frozenset({"cylinder", "held_cell"}): "periodic",
    frozenset({"cylinder", "yielding_cell"}): "periodic",
}
PAIRS = [
    (d, one, two)
    for d in (2, 3)
    for one, two in itertools.combinations(FEATURES, 2)
    if {ONLY.get(one, d), ONLY.get(two, d)} == {d} and not any({one, two} <= each for each in ONE_OF)
]
DEFAULT = {(2, "closed", "yielding_cell"), (2, "wire", "drag"), (2, "winch", "hidden"), (2, "light", "drag")}


def run(s, sim, first, last, record=None):
    """Steps ``first`` to ``last`` with what is done after each."""

    def on_step(sim):
        for step, act in s.after:
            if sim.steps == step:
                act(sim)

    sim.run(steps=last - first, record=record, on_step=on_step)
    return sim


def built(d, one, two):
    s = Scene(d)
    # the law first, as walls of features take it
    for name in sorted((one, two), key=lambda name: name not in ("restitution", "rolling", "light")):
        FEATURES[name](s)
    return s


@pytest.mark.filterwarnings("ignore:In the step")
@pytest.mark.filterwarnings("ignore:Until t =")
@pytest.mark.parametrize(
    ("d", "one", "two"), [pytest.param(*p, marks=() if p in DEFAULT else pytest.mark.long) for p in PAIRS]
)
def test_a_pair_of_features(d, one, two, tmp_path):
    words = REFUSED.get(frozenset({one, two}))
    s = built(d, one, two)
    if words is not None:
        with pytest.raises(ValueError, match=words):
            run(s, s.simulation(), 0, STEPS)
        return
    sim = s.simulation()
    sizes = []

    def energies(sim):
        e = sim.energy
        sizes.append((abs(e.defect), abs(e.kinetic) + abs(e.loads) + sum(map(abs, e.interactions.values()))))

    s.after += [(k, energies) for k in range(1, STEPS + 1)]
    run(s, sim, 0, STEPS)
    assert np.isfinite(sim.positions).all()
    defect, size = np.array(sizes).T
    assert (defect <= 1e-12 * size.max()).all(), defect
    again = built(d, one, two)
    path = tmp_path / "run.h5"
    run(again, again.simulation(), 0, 6, path)
    run(again, lm.resume(path), 6, STEPS)
    with lm.io.open_run(path) as recorded:
        np.testing.assert_array_equal(recorded.positions[-1], sim.positions)
        np.testing.assert_array_equal(recorded.velocities[-1], sim.velocities)
    measured = lm.measure.stress(sim, volume=1.0)
    assert all(np.isfinite(part).all() for part in measured.values())
