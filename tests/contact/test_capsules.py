"""Capsules: their parts meet as the whole does, and they lie, roll, cross and strike as theory says."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import lmgcpy as lm
from lmgcpy.contact.contactor_pairs import rod_rod, sphere_rod, sphere_sphere

G = 9.81


def placed(position, rotation):
    return (*position, *rotation.as_quat())


def meetings(one, other):
    """(gap, normal from the other to the one, point) of all parts of two capsules (position, rotation, radius, half)."""
    ends = []
    for position, rotation, radius, half in (one, other):
        way = rotation.apply((0.0, 0.0, half))
        ends.append([(placed(position + sign * way, rotation), (radius,)) for sign in (1, -1)])
    rods = [(placed(position, rotation), (radius, 0.0, 0.0, half)) for position, rotation, radius, half in (one, other)]
    found = [sphere_sphere(*mine, *its) for mine in ends[0] for its in ends[1]]
    found += [sphere_rod(*mine, *rods[1]) for mine in ends[0]]
    found += [(gap, tuple(-x for x in n), p) for gap, n, p in (sphere_rod(*its, *rods[0]) for its in ends[1])]
    return [*found, rod_rod(*rods[0], *rods[1])]


def distance(one, other):
    """Distance of two segments by minimisation, less the radii."""
    (x, p, r, h), (y, q, s, k) = one, other
    a, b = p.apply((0, 0, h)), q.apply((0, 0, k))

    def square(at):
        return float(((x + at[0] * a - y - at[1] * b) ** 2).sum())

    starts = [(0.0, 0.0), (1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
    best = min(minimize(square, start, bounds=[(-1, 1)] * 2, tol=1e-15).fun for start in starts)
    return math.sqrt(best) - r - s


unit = st.floats(-1.0, 1.0)


@given(st.tuples(unit, unit, unit), st.integers(0, 10_000), st.floats(0.05, 1.0), st.floats(0.05, 1.0), st.booleans())
def test_the_nearest_parts_are_as_far_as_the_capsules(position, seed, half, other_half, parallel):
    turns = Rotation.random(2, random_state=seed)
    one = np.array(position), turns[0], 0.1, half
    other = np.zeros(3), turns[0] if parallel else turns[1], 0.07, other_half
    found = meetings(one, other)
    nearest = min(found, key=lambda answer: answer[0])
    assert nearest[0] == pytest.approx(distance(one, other), abs=2e-7)  # the minimiser's tolerance, squared
    for gap, normal, point in found:
        if math.isfinite(gap):  # each part tells of two balls, one in each capsule: none holds them farther apart
            assert np.linalg.norm(normal) == pytest.approx(1.0, abs=1e-12)
            for (x, turn, radius, length), sign in ((one, 1.0), (other, -1.0)):
                centre = np.array(point) + sign * (radius + 0.5 * gap) * np.array(normal)
                along = (centre - x) @ turn.apply((0, 0, 1))
                assert np.linalg.norm(centre - x - along * turn.apply((0, 0, 1))) < 1e-9
                assert abs(along) <= length * (1 + 1e-9)


def floor(*bodies, friction=0.3, gravity=(0, 0, -G), solver=None, time_step=1e-3, law=None):
    scene = lm.Scene(dimension=3, gravity=gravity)
    for body in bodies:
        scene.add(body)
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    law = lm.Coulomb(friction=friction) if law is None else law
    scene.see("GRAIN", "WALL", law)
    scene.see("GRAIN", "GRAIN", law)
    return lm.Simulation(scene, time_step=time_step, solver=solver)


def test_a_capsule_lies_on_its_ends():
    sim = floor(lm.capsule(radius=0.01, length=0.1, position=(0, 0, 0.01), axis=(1, 1, 0), mass=1.0))
    sim.run(steps=50)
    assert sim.interactions.force[:, 0] == pytest.approx([0.5 * G, 0.5 * G], rel=1e-6)
    assert np.abs(sim.velocities[0]).max() < 1e-9


@pytest.mark.default_parameters("0.001-3.0")
@pytest.mark.parametrize("mass", [1e-3, 3.0, 1e3])
@pytest.mark.parametrize("time_step", [1e-4, 1e-3, 4e-3])
def test_a_capsule_across_another_is_carried_where_they_cross(time_step, mass):
    """The upper one, at right angles across the lower one, with its centre above: one contact bears it."""
    lower = lm.capsule(radius=0.01, length=0.1, position=(0, 0, 0.01), axis=(1, 0, 0), mass=1.0)
    upper = lm.capsule(radius=0.02, length=0.1, position=(0.02, 0, 0.04), axis=(0, 1, 0), mass=mass)
    sim = floor(lower, upper, time_step=time_step, solver=lm.Newton(tolerance=1e-8))
    sim.run(steps=20)
    found = sim.interactions
    bears = found.force[:, 0] > 1e-3 * mass
    pair = bears & (found.candidate == 0) & (found.antagonist == 1)
    assert pair.sum() == 1
    assert found.force[pair, 0] == pytest.approx([mass * G], rel=1e-4)
    # the ends of the lower one share both weights by the levers
    ends = np.sort(found.force[bears & (found.antagonist == 2), 0])
    half, more = 0.5 * (1.0 + mass) * G, 0.2 * mass * G
    assert ends == pytest.approx(np.sort([half - more, half + more]), rel=1e-3)


@pytest.mark.default_parameters("0.0-0.0", "1e-06-0.013", "0.001-0.03")
@pytest.mark.parametrize("offset", [0.0, 0.013, 0.03])
@pytest.mark.parametrize("turn", [0.0, 1e-12, 1e-6, 1e-3])
def test_a_capsule_on_a_parallel_one_is_carried_by_two_points(offset, turn):
    """Nearly parallel ones too: the contact does not jump between them."""
    axis = (math.cos(turn), math.sin(turn), 0.0)
    lower = lm.capsule(radius=0.01, length=0.1, position=(0, 0, 0.01), axis=(1, 0, 0), mass=1.0).fix()
    upper = lm.capsule(radius=0.01, length=0.08, position=(offset, 0, 0.03), axis=axis, mass=1.0)
    sim = floor(lower, upper, friction=0.5)
    sim.run(steps=100)
    # at a turn of 1e-3 the ends are 4e-8 m apart, and it rocks on a point between them until they touch
    assert np.abs(sim.velocities[1]).max() < 5e-5
    assert np.abs(sim.spins[1]).max() < 2e-3
    pair = (sim.interactions.candidate == 0) & (sim.interactions.antagonist == 1)
    assert sim.interactions.force[pair, 0].sum() == pytest.approx(G, rel=1e-3)


@pytest.mark.default_parameters("0.001")
@pytest.mark.parametrize("time_step", [1e-4, 1e-3, 4e-3])
def test_a_capsule_rolls_down_like_a_cylinder(time_step):
    """Without sliding a = g sin / (1 + I / (m r^2)), here with both rounded ends."""
    lean = 0.2
    body = lm.capsule(radius=0.01, length=0.05, position=(0, 0, 0.01), axis=(0, 1, 0), mass=1.0)
    leaning, solver = (G * math.sin(lean), 0, -G * math.cos(lean)), lm.GaussSeidel(tolerance=1e-10)
    sim = floor(body, gravity=leaning, solver=solver, time_step=time_step).run(duration=0.2)
    fast = G * math.sin(lean) / (1.0 + body.inertia[2] / 1e-4) * sim.time
    assert body.velocity == pytest.approx((fast, 0.0, 0.0), abs=1e-6 * fast)
    assert body.spin == pytest.approx((0.0, fast / 0.01, 0.0), abs=1e-6 * fast / 0.01)


@pytest.mark.default_parameters("1.0-0.0-0.0", "1.0-0.05-1.0", "1.0-0.035-0.0", "1e-06-0.02-1.0")
@pytest.mark.parametrize("restitution", [0.0, 1.0])
@pytest.mark.parametrize("at", [0.0, 0.02, 0.035, 0.05])
@pytest.mark.parametrize("mass", [1e-6, 1e-3, 1.0, 1e3, 1e6])
def test_a_ball_strikes_a_resting_rod(restitution, at, mass):
    """Impulse (1 + e) v / (1/m + 1/M + a^2/I) at the distance a from its centre, on its end as well."""
    rod = lm.capsule(radius=0.01, length=0.1, position=(0, 0, 0), axis=(1, 0, 0), mass=2.0)
    ball = lm.sphere(radius=0.02, position=(at, 0, 0.03001), mass=mass, velocity=(0, 0, -1.0))
    scene = lm.Scene(dimension=3, gravity=(0, 0, 0))
    scene.add(rod), scene.add(ball)
    scene.see("GRAIN", "GRAIN", lm.Restitution(restitution=restitution, friction=0.0))
    sim = lm.Simulation(scene, time_step=1e-4)
    while not np.abs(sim.interactions.impulse).any():
        sim.step()
    given = (1.0 + restitution) / (1.0 / mass + 0.5 + at**2 / rod.inertia[0])
    assert sim.interactions.impulse[:, 0].sum() == pytest.approx(given, rel=1e-6)
    assert rod.velocity == pytest.approx((0, 0, -given / 2.0), rel=1e-6, abs=1e-9 * given)
    assert rod.spin == pytest.approx((0, at * given / rod.inertia[0], 0), rel=1e-6, abs=1e-9 * given)


@pytest.mark.long
@pytest.mark.parametrize("mass", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("time_step", [2.5e-4, 1e-3])
def test_a_capsule_rocks_at_its_period(time_step, mass):
    """Small swings of a capsule that rocks across a fixed one: theta'' (I + m s^2) = -m g theta (r - s), see below."""
    radius, reach = 0.05, 0.02
    lower = lm.capsule(radius=radius, length=0.4, position=(0, 0, 0), axis=(1, 0, 0), mass=1.0).fix()
    upper = lm.capsule(radius=reach, length=0.3, position=(0, 0, radius + reach), axis=(0, 1, 0), mass=mass)
    scene = lm.Scene(dimension=3, gravity=(0, 0, -G))
    scene.add(lower), scene.add(upper)
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=1.0))
    sim = lm.Simulation(scene, time_step=time_step, solver=lm.GaussSeidel(tolerance=1e-10))
    sim.state.velocities[1, 3] = 0.2  # about its own x axis, which is that of space
    crossings, before = [], 1.0
    while len(crossings) < 3:
        sim.step()
        now = float(upper.rotation.apply((0, 0, 1))[2])  # how far its axis leans
        if before < 0.0 <= now or before > 0.0 >= now:
            crossings.append(sim.time)
        before = now
    # a plank of half thickness s on a cylinder of radius r, that rolls: I + m s^2 against m g (r - s)
    expected = math.pi * math.sqrt((upper.inertia[0] / mass + reach**2) / (G * (radius - reach)))
    assert np.diff(crossings)[1:] == pytest.approx(expected, rel=0.02)  # swings of 0.06 rad: 1/16 of their square, and h


def test_capsules_in_a_file_come_back(tmp_path):
    material = lm.Material("polyester", 1380.0)
    start = {"radius": 0.01, "length": 0.1, "material": material}
    sim = floor(*(lm.capsule(position=(0.1 * k, 0, 0.1), axis=(1, k, 2), **start) for k in range(3)))
    path = tmp_path / "capsules.h5"
    sim.run(steps=100, record=path)
    again = lm.resume(path)
    assert [type(body).__name__ for body in again.scene.bodies] == ["Capsule"] * 3 + ["Wall"]
    assert again.scene.bodies[1].material == material
    sim.run(steps=50)
    again.run(steps=50)
    np.testing.assert_array_equal(sim.state.positions, again.state.positions)


@pytest.mark.parametrize(
    ("what", "sentence"),
    [
        ({"radius": -1.0}, "radius of a capsule must be above 0"),
        ({"length": 0.0}, "length of a capsule must be above 0"),
        ({"axis": (0, 0, 0)}, "axis of a capsule must not be zero"),
        ({"mass": None}, "needs a material= or a mass="),
        ({"rotation": (1.0, 1.0, 0.0, 0.0)}, "quaternion of length one"),
    ],
)
def test_impossible_capsules_are_refused(what, sentence):
    with pytest.raises((ValueError, TypeError), match=sentence):
        lm.capsule(**{"radius": 0.1, "length": 1.0, "position": (0, 0, 0), "mass": 1.0, **what})


def test_a_rod_without_ends_is_refused():
    """It would fall through walls, which only the balls at its ends meet."""
    rod = lm.RodContactor(0.01, (0, 0, 0.1))
    scene = lm.Scene(dimension=3)
    for ends in ([], [(lm.SphereContactor(0.01), (0, 0, 0.1))]):
        body = lm.RigidBody([rod, *ends], mass=1.0, inertia=1.0, position=(0, 0, 1), color="A")
        with pytest.raises(ValueError, match="without a sphere of its radius at its end"):
            scene.add(body)


def test_a_fibre_that_rolls_moves_as_its_surface_does():
    """A spin about its own axis moves its ends nowhere: no warning, and contacts are looked for where they can be."""
    fibre = lm.capsule(radius=1e-3, length=0.1, position=(0, 0, 1.0001e-3), axis=(0, 1, 0), mass=1e-3, spin=(0, 200.0, 0))
    sim = floor(fibre, friction=0.0)
    moves = sim._displacement_watch.measure(sim.state.velocities, sim.time_step)
    assert moves.travel < 1e-15  # of 2e-4 m that its surface moves along itself
    sim.run(steps=5)
    across = floor(lm.capsule(radius=1e-2, length=0.1, position=(0, 0, 1.0), axis=(0, 1, 0), mass=1.0, spin=(2.0, 0, 0)))
    assert across._displacement_watch.measure(across.state.velocities, 1e-3).travel == pytest.approx(1e-3 * 2.0 * 0.05)


@pytest.mark.parametrize("axis", [(1e-3, 0, -1), (1e-6, 1e-7, -1), (1e-12, 0, -1), (0, 0, -1), (0, 0, 1), (1, 2, -3)])
def test_an_axis_is_kept_to_the_last_digit(axis):
    body = lm.capsule(radius=0.1, length=1.0, position=(0, 0, 0), axis=axis, mass=1.0)
    np.testing.assert_allclose(body.rotation.apply((0, 0, 1)), np.array(axis) / np.linalg.norm(axis), rtol=0.0, atol=4e-16)


def tumbling_fibres():
    """Slender fibres that tumble among balls."""
    rng = np.random.default_rng(2)
    scene = lm.Scene(dimension=3, gravity=(0, 0, -G))
    for k in range(40):
        start = {"position": rng.uniform(0.02, 0.08, 3), "rotation": Rotation.random(random_state=k)}
        start |= {"velocity": rng.normal(scale=0.3, size=3), "spin": rng.normal(scale=30.0, size=3)}
        scene.add(lm.capsule(radius=5e-4, length=0.03, mass=1e-4, **start))
    scene.add_spheres(2e-3, rng.uniform(0.02, 0.08, (60, 3)), masses=1e-4)
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    options = {"overlap": "ignore", "on_unconverged": "ignore", "solver": lm.GaussSeidel(tolerance=1e-3)}
    return lm.Simulation(scene, time_step=2e-4, **options)


@pytest.mark.filterwarnings("ignore:In the step")  # fast ends of thin fibres
def test_the_list_leaves_out_rods_that_are_far_apart_and_no_contact(monkeypatch):
    """With the list of all pairs whose bounding spheres are near, every step is the same to the last bit."""
    short = tumbling_fibres().run(steps=60)
    monkeypatch.setattr("lmgcpy.contact.detector.within_reach", lambda pairs, *_: pairs)
    whole = tumbling_fibres().run(steps=60)
    np.testing.assert_array_equal(short.positions, whole.positions)
    np.testing.assert_array_equal(short.rotations, whole.rotations)
    assert whole._detector.rebuilds > 3
    assert len(short.interactions) == len(whole.interactions)
    listed = [sum(group.slots for group in sim._detector.groups) for sim in (short, whole)]
    assert listed[0] < 0.3 * listed[1]
