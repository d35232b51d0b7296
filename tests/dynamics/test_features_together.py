"""Every feature of a scene beside every other: the balance of energy closes, and a run goes on from its file bit for bit.

What two features cannot do together is refused with a sentence: ``REFUSED``. The page ``docs/features.md`` shows the pairs
that are tested here, in the words of the functions of this file.
"""

from __future__ import annotations

import itertools
import warnings
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from segment import Segment

import lmgcpy as lm

PAGE = Path(__file__).parents[2] / "docs" / "features.md"

STEPS, H = 12, 1e-3
SIDE = 1.0


class Scene:
    """A scene of six grains that features change, and what is done to it after a step."""

    def __init__(self, dimension):
        self.dimension, self.law, self.periodic, self.bead_mass = dimension, lm.Coulomb(friction=0.3), None, 0.1
        self.after, self.functions = [], {}
        self.scene = lm.Scene(dimension=dimension, gravity=[0.0] * (dimension - 1) + [-9.81])
        self.make = lm.disk if dimension == 2 else lm.sphere
        rng = np.random.default_rng(0)
        self.grains = [
            self.scene.add(self.make(radius=0.05, position=self.at(0.1 + 0.105 * k, 0.3), mass=1.0, velocity=v))
            for k, v in enumerate(rng.normal(size=(6, dimension)))
        ]

    def at(self, x, y):
        return [x] + [0.5] * (self.dimension - 2) + [y]

    def beads(self, y, count=5):
        """A row of beads to be linked, whose links are pulled, and a grain that falls on the row."""
        self.scene.add(self.make(radius=0.03, position=self.at(0.3, y + 0.051), mass=1.0, velocity=self.at(0.1, -1.0)))
        alike = {"radius": 0.02, "mass": self.bead_mass, "color": "BEAD"}
        return [
            self.scene.add(self.make(position=self.at(0.1 + 0.1 * k, y), velocity=self.at(0.3 * (-1) ** k, -0.5), **alike))
            for k in range(count)
        ]

    def simulation(self):
        """Walls or a cell come last."""
        scene = self.scene
        if self.periodic is not None:
            self.periodic(scene.periodic(**dict.fromkeys("xyz"[: self.dimension], SIDE)))
        else:
            floor = [0.0] * (self.dimension - 1) + [1.0]
            scene.add(lm.wall(point=self.at(0.0, 0.247), normal=floor))
        for color in sorted({"GRAIN", "BEAD"} & {body.color for body in scene.bodies}, reverse=True):
            scene.see("GRAIN", color, self.law)
            if self.periodic is None:
                scene.see(color, "WALL", self.law)
        options = {"time_step": H, "solver": lm.Auto(tolerance=1e-8), "on_unconverged": "ignore", "overlap": "ignore"}
        return lm.Simulation(scene, **options)


def wire(s):
    """a rigid wire"""
    s.scene.chain(s.beads(0.42), lm.RigidWire())


def closed(s):
    """a closed chain of elastic rods"""
    s.scene.chain(s.beads(0.53, 8), lm.ElasticRod(stiffness=1e4), closed=True)


def relaxing(s):
    """rigid rods that relax to their length"""
    s.scene.chain(s.beads(0.64), lm.RigidRod(), reference_gap=0.055, relaxation=0.008)


def winch(s):
    """an elastic wire that is drawn in"""
    chain = s.scene.chain(s.beads(0.75), lm.ElasticWire(stiffness=1e4))
    s.after.append((2, lambda sim: setattr(sim.scene.chains[s.scene.chains.index(chain)], "reference_gap", 0.055)))


def timed(s):
    """a rigid wire whose gap is a function of time"""
    s.functions["chain", len(s.scene.chains)] = f = lambda time: 0.06 - time
    s.scene.chain(s.beads(0.86), lm.RigidWire(), reference_gap=f)


def light(s):
    """a rigid wire 10 000 times lighter than grains"""
    s.bead_mass = 1e-4
    s.scene.chain(s.beads(0.373), lm.RigidWire())


def clump(s, x, y, angle=0.3, color="GRAIN"):
    """Two balls side by side, the points of their ends, and the mass 1."""
    d = s.dimension
    make = lm.DiskContactor if d == 2 else lm.SphereContactor
    away = np.eye(d)[0] * 0.02
    start = {"position": s.at(x, y), "color": color}
    if d == 2:
        start |= {"inertia": 1e-3, "rotation": angle}
    else:
        start |= {"inertia": (5e-4, 1e-3, 1.1e-3), "rotation": (0.0, -np.sin(0.5 * angle), 0.0, np.cos(0.5 * angle))}
    return s.scene.add(lm.RigidBody([(make(0.03), -away), (make(0.03), away)], mass=1.0, **start)), -away, away


def cluster(s):
    """clusters of disks, clumps of spheres"""
    clump(s, 0.735, 0.31)


def capsule(s):
    """capsules"""
    s.scene.add(lm.capsule(radius=0.03, length=0.04, mass=1.0, position=s.at(0.735, 0.31), axis=s.at(1.0, 0.3)))


def points(s):
    """a wire that ends at points of bodies"""
    first, last = clump(s, 0.1, 0.95, color="BEAD"), clump(s, 0.6, 0.95, -0.8, color="BEAD")
    first[0].velocity[:] = s.at(-1.0, 0.5)
    s.scene.chain([(first[0], first[2]), *s.beads(0.91)[1:4], (last[0], last[1])], lm.RigidRod())


def joints(s):
    """ball joints"""
    first, _, end = clump(s, 0.1, 0.82, 0.0, color="BEAD")
    second, begin, _ = clump(s, 0.14, 0.82, 0.0, color="BEAD")
    second.velocity[:] = s.at(0.0, 2.0)
    s.scene.link(first, second, lm.BallJoint(), at=(end, begin))


def cylinder(s):
    """a drum that turns"""
    drum = s.scene.add(lm.cylinder_wall(point=(0.5, 0.5, 0.5), axis=(0, 1, 0), radius=0.5, color="DRUM"))
    drum.impose_velocity(spin_y=1.0)
    s.scene.add(lm.sphere(radius=0.05, position=(0.947, 0.5, 0.5), mass=1.0, velocity=(1.0, 0.0, 0.0)))
    s.scene.see("GRAIN", "DRUM", s.law)


def foreign(s):
    """a contactor of one's own"""
    body = lm.RigidBody([Segment(0.2, 0.02)], mass=1.0, inertia=1e-2, position=(0.3, 0.2285), color="SEGMENT")
    s.scene.add(body).fix()
    s.scene.see("GRAIN", "SEGMENT", s.law)


def surface(s):
    """a plate or polyline that turns"""
    if s.dimension == 2:
        plate = lm.wall_segment((0.05, 0.237), (0.1, 0.237), (0.15, 0.237), radius=0.01, color="PLATE")
        s.scene.add(plate).impose_velocity(spin=0.5)
        s.scene.see("GRAIN", "PLATE", s.law)
        return
    corners = [(x, y, 0.237) for x, y in ((0.05, 0.45), (0.15, 0.45), (0.15, 0.55), (0.05, 0.55))]
    s.scene.add(lm.plate(corners, radius=0.01, color="PLATE")).impose_velocity(spin_y=0.5)
    s.scene.see("GRAIN", "PLATE", s.law)


def smooth(s):
    """a thread with a surface"""
    nodes = [s.scene.add(lm.point_mass(position=s.at(0.1 + 0.08 * k, 0.75), mass=0.05)) for k in range(5)]
    nodes[1].velocity[:] = s.at(-0.3, -0.5)
    s.scene.chain(nodes, lm.ElasticRod(stiffness=1e4), surface=lm.Thread(0.01))
    s.scene.add(s.make(radius=0.03, position=s.at(0.3, 0.791), mass=1.0, velocity=s.at(0.1, -1.0)))
    s.scene.see("GRAIN", "THREAD", s.law)


def restitution(s):
    """restitution"""
    s.law = lm.Restitution(restitution=0.5)


def rolling(s):
    """rolling friction"""
    s.law = lm.RollingCoulomb(friction=0.3, rolling_friction=0.05)


def held_cell(s):
    """a periodic cell at a rate"""
    s.periodic = lambda cell: cell.impose_rate(xz=1.0) if s.dimension == 3 else cell.impose_rate(xy=1.0)


def yielding_cell(s):
    """a periodic cell under a stress"""
    s.periodic = lambda cell: cell.impose_stress(xx=-10.0)


def other_law(s):
    """friction and stiffness that are set between steps"""

    def set_laws(sim):
        sim.scene.set_law("GRAIN", "GRAIN", type(s.law)(**{**s.law.values, "friction": 0.9}))
        for chain in sim.scene.chains:
            if "stiffness" in chain.law.values:
                chain.law = type(chain.law)(stiffness=2e4)

    s.after.append((4, set_laws))


def drag(s):
    """drag of a medium"""
    s.scene.drag(linear=0.5, quadratic=0.1)


def driven(s):
    """driven and loaded bodies"""
    s.grains[0].impose_velocity(x=0.3)
    s.grains[1].impose_force(x=5.0)


def hidden(s):
    """a body that is hidden and shown"""
    s.grains[2].hide()
    s.after.append((4, lambda sim: sim.scene.bodies[2].show()))


def tilted(s):
    """gravity that changes"""
    down = np.zeros(s.dimension)
    down[0] = 2.0
    s.after.append((3, lambda sim: setattr(sim.scene, "gravity", down)))


FEATURES = {
    f.__name__: f
    for f in (
        *(wire, closed, relaxing, winch, timed, light, points, joints, cluster, capsule, cylinder, foreign),
        *(surface, smooth),
        *(restitution, rolling),
        *(held_cell, yielding_cell, other_law, drag, driven, hidden, tilted),
    )
}
ONLY = {"capsule": 3, "cylinder": 3, "foreign": 2}
ONE_OF = ({"restitution", "rolling"}, {"held_cell", "yielding_cell"})
REFUSED = {  # walls and drums must look the same from every image
    frozenset({"cylinder", "held_cell"}): "periodic",
    frozenset({"cylinder", "yielding_cell"}): "periodic",
    frozenset({"smooth", "rolling"}): "rolling friction",
}
TOLD = {  # light beads are thrown off or jerked, too fast for the step
    frozenset({"light", "restitution"}): "moves by|overlap by",
    frozenset({"light", "points"}): "a jerk without rebound",
}
PAIRS = [
    (d, one, two)
    for d in (2, 3)
    for one, two in itertools.combinations(FEATURES, 2)
    if {ONLY.get(one, d), ONLY.get(two, d)} == {d} and not any({one, two} <= each for each in ONE_OF)
]
DEFAULT = {(2, "closed", "yielding_cell"), (2, "winch", "hidden"), (2, "light", "drag"), (2, "points", "joints")}


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
    acted = set()
    sizes = []

    def energies(sim):
        e = sim.energy
        net = sim.interactions
        acted.update(net.law[net.impulse.any(axis=1)].tolist())
        sizes.append((abs(e.defect), abs(e.kinetic) + abs(e.loads) + sum(map(abs, e.interactions.values()))))

    s.after += [(k, energies) for k in range(1, STEPS + 1)]
    told = TOLD.get(frozenset({one, two}))
    with nullcontext() if told is None else pytest.warns(RuntimeWarning, match=told):
        run(s, sim, 0, STEPS)
    links = [*s.scene.chains, *s.scene.joints]
    assert acted == {s.law.NAME, *(one.law.NAME for one in links)}  # or it would show nothing
    assert np.isfinite(sim.positions).all()
    defect, size = np.array(sizes).T
    assert (defect <= 1e-12 * size.max()).all(), defect
    again = built(d, one, two)
    path = tmp_path / "run.h5"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # what was told above
        run(again, again.simulation(), 0, 6, path)
        run(again, lm.resume(path, functions=again.functions), 6, STEPS)
    with lm.io.open_run(path) as recorded:
        np.testing.assert_array_equal(recorded.positions[-1], sim.positions)
        np.testing.assert_array_equal(recorded.velocities[-1], sim.velocities)
    measured = lm.measure.stress(sim, volume=1.0)
    assert all(np.isfinite(part).all() for part in measured.values())


def table():
    """What holds for each pair, as the page shows it: rows and columns are the features in their order."""
    names = list(FEATURES)
    lines = [
        "| | feature | " + " | ".join(map(str, range(1, len(names)))) + " |",
        "|---|---" + "|---" * (len(names) - 1) + "|",
    ]
    for k, one in enumerate(names):
        words = [_holds(one, other) for other in names[:k]] + [""] * (len(names) - 1 - k)
        lines.append(f"| {k + 1} | {FEATURES[one].__doc__} | " + " | ".join(words) + " |")
    return "\n".join(lines)


def _holds(one, other):
    pair = {one, other}
    if any(pair <= each for each in ONE_OF):
        return "–"
    dimensions = [d for d in (2, 3) if (d, other, one) in PAIRS]
    if not dimensions:
        return "–"
    word = "refused" if frozenset(pair) in REFUSED else "told" if frozenset(pair) in TOLD else "right"
    return word if len(dimensions) == 2 or word != "right" else f"in {dimensions[0]}D"


def test_the_page_shows_these_pairs():
    """If it does not, put what :func:`table` gives on the page."""
    assert table() in PAGE.read_text(encoding="utf-8"), f"\n{table()}"
