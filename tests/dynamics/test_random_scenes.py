"""What must hold of any scene: drawn ones, grains thrown about in a box with a wire among them, in plane and space.

Steps are solved to 1e-11. What compares two runs is drawn without friction, where velocities are unique, and is compared
to 1e-6 of the speeds after twenty steps, in which collisions magnify a difference by some decades.
"""

from __future__ import annotations

import numpy as np
import pytest
import suites
from hypothesis import given, settings
from hypothesis import strategies as st

import lmgcpy as lm

STEPS, TIME_STEP = 20, 2e-3
CLOSE = 1e-6
LINKS = {"none": None, "wire": lm.RigidWire(), "rod": lm.RigidRod(), "elastic": lm.ElasticWire(stiffness=1e3)}
THROWN = {
    "seed": st.integers(0, 10_000),
    "dimension": st.sampled_from([2, 3]),
    "grains": st.integers(1, 12),
    "link": st.sampled_from(sorted(LINKS)),
}
RUBBING = st.sampled_from([0.0, 0.3, 1.0])


def thrown(seed, dimension, grains, link, friction=0.0, *, turn=None, order=None, box=True):
    """(simulation, its round bodies): four beads and some grains on a jittered lattice of 0.25 m, at some 1.5 m/s.

    ``turn`` (d, d): all that has a direction is turned by it; ``order``: in which the bodies are added; ``box``: whether
    there are walls, and gravity.
    """
    rng = np.random.default_rng(seed)
    turn = np.eye(dimension) if turn is None else turn
    gravity = rng.normal(0.0, 10.0, dimension)
    scene = lm.Scene(dimension=dimension, gravity=turn @ gravity if box else np.zeros(dimension))
    make = lm.disk if dimension == 2 else lm.sphere
    cells = np.stack(np.meshgrid(*[np.arange(4)] * dimension, indexing="ij"), axis=-1).reshape(-1, dimension)
    beads = cells[:4]  # in a row
    rest = rng.permutation(len(cells) - 4)[:grains] + 4
    bodies = []
    for k, cell in enumerate(np.concatenate([beads, cells[rest]])):
        place = 0.25 * (cell + 0.5) + rng.uniform(-0.005, 0.005, dimension)
        spin = rng.normal(0.0, 5.0, None if dimension == 2 else 3)
        bodies.append(
            make(
                radius=rng.uniform(0.1, 0.12),
                position=turn @ place,
                mass=10.0 ** rng.uniform(-1.0, 1.0),
                velocity=turn @ rng.normal(0.0, 1.5, dimension),
                spin=spin if dimension == 2 else turn @ spin,
                color="BEAD" if k < 4 else "GRAIN",
            )
        )
    for k in range(len(bodies)) if order is None else order:
        scene.add(bodies[k])
    if box:
        for normal in np.concatenate([np.eye(dimension), -np.eye(dimension)]):
            scene.add(lm.wall(point=turn @ np.where(normal < 0.0, 1.0, 0.0), normal=turn @ normal))
    pairs = [("GRAIN", "GRAIN"), ("GRAIN", "BEAD"), ("BEAD", "BEAD")]
    for pair in pairs + box * [("GRAIN", "WALL"), ("BEAD", "WALL")]:
        scene.see(*pair, lm.Coulomb(friction=friction), alert=0.1)
    if LINKS[link] is not None:
        scene.chain(bodies[:4], LINKS[link])
    sim = lm.Simulation(scene, time_step=TIME_STEP, solver=lm.Auto(tolerance=1e-11), on_unconverged="stop")
    return sim, bodies


def rotation(seed: int, dimension: int) -> np.ndarray:
    """A random proper rotation, (d, d)."""
    matrix = np.linalg.qr(np.random.default_rng(seed).normal(size=(dimension, dimension)))[0]
    return matrix * np.sign(np.linalg.det(matrix)) if dimension == 3 else matrix @ np.diag([1.0, np.linalg.det(matrix)])


def moments(sim, bodies, dimension):
    """(mass, inertia, positions, velocities, spins as vectors of space) of the bodies, one a row."""
    mass, inertia = (np.array([getattr(body, name) for body in bodies]) for name in ("mass", "inertia"))
    ids = [body.id for body in bodies]
    spins = sim.spins[ids]
    if dimension == 2:
        spins = np.column_stack([np.zeros((len(ids), 2)), spins])
    return mass, inertia, in_space(sim.positions[ids]), in_space(sim.velocities[ids]), spins


def in_space(vectors):
    return np.pad(vectors, ((0, 0), (0, 3 - vectors.shape[1])))


def kinetic(sim, bodies, dimension):
    mass, inertia, _, v, w = moments(sim, bodies, dimension)
    return 0.5 * float(mass @ (v**2).sum(axis=1) + inertia @ (w**2).sum(axis=1))


@pytest.mark.scaled
def test_bodies_meet_and_wires_are_taut():
    """The properties below would be cheap where nothing acts: in the mean over scenes both act in a third of the steps."""
    scenes = suites.size(8, long=30)
    acting = {"coulomb": 0, "rigid-wire": 0}
    for seed in range(scenes):
        sim, _ = thrown(seed, 2 + seed % 2, 8, "wire", 0.3)
        for _ in range(STEPS):
            sim.step()
            net = sim.interactions
            for law in acting:
                acting[law] += bool((net.impulse[net.law == law, 0] != 0.0).any())
    assert min(acting.values()) > 0.3 * scenes * STEPS, acting


@given(**THROWN, friction=RUBBING)
def test_the_energy_identity_closes(seed, dimension, grains, link, friction):
    """Kinetic energy by hand: its change is the work of gravity, by hand, and of impulses, by law."""
    sim, bodies = thrown(seed, dimension, grains, link, friction)
    for _ in range(STEPS):
        before, start = kinetic(sim, bodies, dimension), moments(sim, bodies, dimension)[3]
        sim.step()
        mass, _, _, end, _ = moments(sim, bodies, dimension)
        weight = TIME_STEP * float(mass @ (0.5 * (start + end) @ in_space(np.array([sim.scene.gravity]))[0]))
        works = sim.energy.interactions
        scale = before + abs(weight) + sum(map(abs, works.values()))
        assert kinetic(sim, bodies, dimension) - before == pytest.approx(weight + sum(works.values()), abs=1e-12 * scale)


@given(**THROWN, friction=RUBBING)
def test_gaps_and_cones_after_every_step(seed, dimension, grains, link, friction):
    """No contact goes further into another body than it was, contacts push and wires pull, friction is in its cone and
    against the sliding: of every interaction, from its gap and impulse and the velocities of its bodies, by hand."""
    sim, bodies = thrown(seed, dimension, grains, link, friction)
    for _ in range(STEPS):
        sim.step()
        net = sim.interactions
        contact, r = net.law == "coulomb", net.impulse
        u = relative_velocity(sim, net, bodies, dimension)
        left = 1e-7 * max(1.0, np.abs(u).max(initial=0.0))  # of speeds of some metres a second
        share = 1e-7 * max(1.0, np.abs(r).max(initial=0.0))
        end = net.gap + TIME_STEP * u[:, 0]
        assert (end[contact] >= np.minimum(net.gap[contact], 0.0) - TIME_STEP * left).all()
        assert (r[contact, 0] >= -share).all()
        rubbed = np.linalg.norm(r[:, 1:], axis=1)
        assert (rubbed[contact] <= friction * r[contact, 0] + share).all()
        assert (np.einsum("ij,ij->i", r[contact, 1:], u[contact, 1:]) <= left * share / 1e-7).all()
        if link == "wire":
            assert (r[~contact, 0] <= share).all()


def relative_velocity(sim, net, bodies, dimension):
    """Of the candidate at the middle of each gap, in the frame of the interaction, (m, d); walls are at rest."""
    radius = np.zeros(len(sim.positions))
    for body in bodies:
        radius[body.id] = body.extent
    spins = sim.spins if dimension == 3 else np.column_stack([np.zeros((len(sim.spins), 2)), sim.spins])
    contact = net.law == "coulomb"
    velocity = np.zeros((len(net.gap), 3))
    for ids, sign, side in ((net.candidate, 1.0, -1.0), (net.antagonist, -1.0, 1.0)):
        arm = np.where(contact, radius[ids] + 0.5 * net.gap, 0.0)[:, None] * side * in_space(net.normal)
        velocity += sign * (in_space(sim.velocities[ids]) + np.cross(spins[ids], arm))
    return np.einsum("mij,mj->mi", net.frame, velocity[:, :dimension])


@given(**THROWN, friction=RUBBING)
def test_momentum_is_kept_without_walls(seed, dimension, grains, link, friction):
    """Linear and angular momentum to round-off: both levers of a contact go to one point, the middle of its gap."""
    sim, bodies = thrown(seed, dimension, grains, link, friction, box=False)
    mass, inertia, x, v, w = moments(sim, bodies, dimension)
    linear, angular = mass @ v, (np.cross(x, mass[:, None] * v) + inertia[:, None] * w).sum(axis=0)
    size = float(mass @ np.linalg.norm(v, axis=1))
    sim.run(steps=STEPS)
    mass, inertia, x, v, w = moments(sim, bodies, dimension)
    assert mass @ v == pytest.approx(linear, abs=1e-12 * size)
    turned = (np.cross(x, mass[:, None] * v) + inertia[:, None] * w).sum(axis=0)
    assert turned == pytest.approx(angular, abs=1e-12 * size)  # positions are of a metre


@settings(max_examples=suites.size(8, long=30))
@given(**THROWN, angle=st.integers(0, 1000))
def test_directions_do_not_matter(seed, dimension, grains, link, angle):
    turn = rotation(angle, dimension)
    plain, turned = (thrown(seed, dimension, grains, link, turn=t)[0].run(steps=STEPS) for t in (np.eye(dimension), turn))
    assert turned.velocities == pytest.approx(plain.velocities @ turn.T, abs=CLOSE)


@settings(max_examples=suites.size(8, long=30))
@given(**THROWN, shuffle=st.integers(0, 1000))
def test_the_order_of_the_bodies_does_not_matter(seed, dimension, grains, link, shuffle):
    order = np.random.default_rng(shuffle).permutation(grains + 4)
    runs = [thrown(seed, dimension, grains, link, order=o) for o in (None, order)]
    plain, shuffled = (np.array([body.velocity for body in bodies]) for sim, bodies in runs if sim.run(steps=STEPS))
    assert shuffled == pytest.approx(plain, abs=CLOSE)
