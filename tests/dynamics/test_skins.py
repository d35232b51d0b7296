"""Surfaces between bodies: threads, nets and membranes, held against kinematics, conservation laws and theory."""

import numpy as np
import pytest
import suites
from drum import over_a_drum, ratio_of_tensions

import lmgcpy as lm
from lmgcpy.contact.features import ASIDE
from lmgcpy.contact.positions import in_space
from lmgcpy.contact.segments import segment_distances
from lmgcpy.dynamics.rotation import turn_freely

ROD = lm.ElasticRod(stiffness=1.0)


def grain(d, radius, position, mass=2.0):
    return (lm.disk if d == 2 else lm.sphere)(radius=radius, position=position, mass=mass)


def thread(scene, places, color="THREAD", radius=0.1, law=ROD, mass=1.0):
    """A thread whose nodes have different masses."""
    nodes = [scene.add(lm.point_mass(position=p, mass=mass * (1.0 + 0.3 * k))) for k, p in enumerate(places)]
    return scene.chain(nodes, law, surface=lm.Thread(radius, color=color))


def ball_on_segment(d):
    scene = lm.Scene(dimension=d)
    thread(scene, [(0.0,) * d, (1.0, 0.1, 0.1)[:d]])
    scene.add(grain(d, 0.2, (0.37, 0.33) if d == 2 else (0.37, 0.2, 0.25)))
    return scene


def ball_at_joint(d):
    scene = lm.Scene(dimension=d)
    thread(scene, [(-1.0, -0.5, 0.2)[:d], (0.0,) * d, (1.2, -0.7, 0.1)[:d]])
    scene.add(grain(d, 0.2, (0.02, 0.29, 0.03)[:d]))
    return scene


def ball_at_end(d):
    scene = lm.Scene(dimension=d)
    thread(scene, [(0.0,) * d, (1.0, 0.1, 0.1)[:d]])
    scene.add(grain(d, 0.2, (-0.25, 0.13) if d == 2 else (-0.25, 0.1, 0.1)))
    return scene


def tip_on_line(d):
    scene = lm.Scene(dimension=2)
    thread(scene, [(0, 0), (1, 0.1)])
    thread(scene, [(0.4, 0.23), (0.5, 1)], "GRAIN")
    return scene


def crossing(d):
    scene = lm.Scene(dimension=3)
    thread(scene, [(0, 0, 0), (1, 0.1, 0.1)])
    thread(scene, [(0.4, -0.5, 0.2), (0.5, 0.6, 0.28)], "GRAIN")
    return scene


def capsule_across(d):
    scene = lm.Scene(dimension=3)
    thread(scene, [(0, 0, 0), (1, 0.1, 0.1)])
    scene.add(lm.capsule(radius=0.1, length=1.0, position=(0.5, 0, 0.24), axis=(0.2, 1, 0.1), mass=3.0))
    return scene


def ball_on_membrane(d):
    scene = lm.Scene(dimension=3)
    places = [(0, 0, 0), (1, 0.1, 0.1), (0.2, 1, -0.1)]
    nodes = [scene.add(lm.point_mass(position=p, mass=1.0 + k)) for k, p in enumerate(places)]
    scene.membrane(nodes, [[0, 1, 2]], ROD, radius=0.1, color="THREAD")
    scene.add(grain(3, 0.2, (0.4, 0.3, 0.3)))
    return scene


def clump_on_segment(d):
    scene = lm.Scene(dimension=3)
    thread(scene, [(0, 0, 0), (1, 0.1, 0.1)])
    shape = lm.clump([0.2, 0.2], [(-0.2, 0, 0), (0.15, 0.1, 0)], density=3.0)
    scene.add(shape.at(position=(0.3, 0.1, 0.3), rotation=(0.5, 0.5, 0.5, 0.5)))
    return scene


SCENES = [
    *((make, d) for make in (ball_on_segment, ball_at_joint, ball_at_end) for d in (2, 3)),
    *((tip_on_line, 2), (crossing, 3), (capsule_across, 3), (ball_on_membrane, 3), (clump_on_segment, 3)),
]
DEFAULT = (ball_on_segment, ball_on_membrane)
"""A ball on a segment and on a triangle; each pair of contactors takes the compiler some seconds."""


def one_contact(make, d):
    """A simulation after a step that moves nothing, its problem, the row of its contact, and random velocities."""
    scene = make(d)
    scene.see("GRAIN", "THREAD", lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=1e-12, overlap="ignore")
    sim.step()
    (row,) = np.flatnonzero(sim.interactions.law == "coulomb")
    return sim, sim.last_step[0], row, np.random.default_rng(3).standard_normal(sim.state.velocities.shape)


@pytest.mark.default_parameters(make=DEFAULT)
@pytest.mark.parametrize(("make", "d"), SCENES)
def test_the_form_is_the_rows_of_h_and_gives_momentum_to_no_one(make, d):
    _, problem, row, velocities = one_contact(make, d)
    s, H = problem.system, problem.interaction_matrix().toarray()
    # ten roundings of numbers of size one
    np.testing.assert_allclose(H @ velocities.ravel(), problem.relative_velocities(velocities).ravel(), atol=4e-15)
    s.impulse[:] = 0.0
    s.impulse[row] = np.random.default_rng(4).standard_normal(d)
    momentum = problem.momentum()
    np.testing.assert_allclose(H.T @ s.impulse.ravel(), momentum.ravel(), atol=4e-15)
    W = (H @ np.diag(s.inverse_mass.ravel()) @ H.T)[d * row : d * row + d, d * row : d * row + d]
    block = np.diag(s.delassus[row])
    block[0, 1] = s.coupling[row]
    if d == 3:
        block[0, 2], block[1, 2] = s.shear[row]
    np.testing.assert_allclose(np.triu(W), block, atol=1e-14)
    np.testing.assert_allclose(momentum[:, :d].sum(axis=0), 0.0, atol=2e-15)


@pytest.mark.default_parameters(make=DEFAULT)
@pytest.mark.parametrize(("make", "d"), SCENES)
def test_the_gap_grows_with_the_normal_velocity(make, d):
    sim, problem, row, velocities = one_contact(make, d)
    way, gaps = 1e-6, []
    for step in (way, 0.0):
        positions, turning = sim.state.positions.copy(), velocities.copy()
        positions[:, :d] += step * velocities[:, :d]
        if d == 2:
            positions[:, 2] += step * velocities[:, 2]
        elif len(sim.model.turning):
            turn_freely(sim.model.turning, step, positions, turning, sim.model.mass, sim.model.inverse_mass)
        gaps.append(sim._detector.detect(positions, 0.0, 1.0).gap[row])
    normal = problem.relative_velocities(velocities)[row, 0]
    assert gaps[0] - gaps[1] == pytest.approx(way * normal, abs=3e-5 * way)  # the second derivative, times half the way


@pytest.mark.default_parameters(make=DEFAULT)
@pytest.mark.parametrize(("make", "d"), SCENES)
def test_angular_momentum_is_kept_but_for_the_torsion_of_a_segment_in_space(make, d):
    sim, problem, row, _ = one_contact(make, d)
    s, x = problem.system, sim.positions
    s.impulse[:] = 0.0
    s.impulse[row] = r = np.random.default_rng(4).standard_normal(d)
    p = problem.momentum()
    if d == 2:
        aside = ASIDE * np.linalg.norm(r) if make in (tip_on_line, ball_at_end) else 0.0  # nodes are seen so far off
        assert (x[:, 0] * p[:, 1] - x[:, 1] * p[:, 0] + p[:, 2]).sum() == pytest.approx(0.0, abs=2e-15 + aside)
        return
    spins = p[:, 3:].copy()
    for b in sim.model.turning:
        spins[b] = in_space(sim.state.positions[b, 3:], spins[b])
    lost = (np.cross(x, p[:, :3]) + spins).sum(axis=0)
    if make is ball_on_segment:  # rho r_b about the axis e, of the impulse r on the ball at the distance rho from the axis
        frame, lever = sim.interactions.frame[row], sim.interactions.lever[row, 1]  # from a node, on the axis as well
        axis = x[1] / np.linalg.norm(x[1])
        moment = np.cross(lever, r @ frame)
        np.testing.assert_allclose(lost, axis * (axis @ moment), atol=2e-15)
        assert np.linalg.norm(lost) > 0.01  # there is one
    elif make is ball_on_membrane:
        np.testing.assert_allclose(lost, 0.0, atol=2e-15)


def drawn_through(d, friction, *, mass=1e-6, time_step=1e-3, pairs=12, seed=0, steps=60):
    """Force that draws a straight thread through pairs of grains, over the force of all grains on it, step by step."""
    rng, force, radius = np.random.default_rng(seed), 1.0, 5e-4
    scene = lm.Scene(dimension=d)
    across, held = ("y", ("x", "spin")) if d == 2 else ("z", ("x", "y", "spin_x", "spin_y", "spin_z"))
    places = np.zeros((pairs + 6, d))
    places[:, 0] = 0.01 * np.arange(pairs + 6)
    chain = thread(scene, places, radius=radius, law=lm.RigidWire(), mass=mass)
    for x in 0.01 * (np.arange(3, pairs + 3) + rng.uniform(-0.4, 0.4, pairs)):
        for side in (1.0, -1.0):
            at = np.zeros(d)
            at[0], at[-1] = x, side * (0.005 + radius)
            scene.add(grain(d, 0.005, at, 1e-3)).fix(*held).impose_force(**{across: -side * force})
    scene.see("GRAIN", "THREAD", lm.Coulomb(friction=friction))
    chain.bodies[-1].impose_velocity(**{"x": 0.02, across: 0.0})
    chain.bodies[0].impose_force(x=-0.5)  # a tail that is slack would swing
    if d == 3:
        for node in chain.bodies:
            node.fix("y")
    sim = lm.Simulation(scene, time_step=time_step, solver=lm.Auto(tolerance=1e-8))
    tensions = []
    for _ in range(steps):
        sim.step()
        tensions.append(-sim.interactions.force[sim.interactions.law == "rigid-wire", 0][-1])
    assert sim.unconverged_steps == 0
    return (np.array(tensions) - 0.5) / (2.0 * pairs * force)


@pytest.mark.default_parameters("0.2-2")
@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("friction", [0.0, 0.2, 0.5])
def test_a_straight_thread_is_held_by_the_friction_that_was_given(d, friction):
    apparent = drawn_through(d, friction)[20:]  # the first steps bring all of it to the speed of its end
    np.testing.assert_allclose(apparent, friction, atol=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("time_step", [2.5e-4, 5e-4, 2e-3, 4e-3])
@pytest.mark.parametrize("mass", [1e-9, 1e-7, 1e-5, 1e-3])
def test_so_it_is_at_any_step_and_mass(time_step, mass):
    # pairs of grains that pinch a light segment would turn it over (1e-6: a force of 111 times that of the grains) without
    # the stiffness of pinched segments
    steps = max(60, round(0.2 / 0.02 * 0.05 / 50 / time_step))
    apparent = drawn_through(2, 0.2, mass=mass, time_step=time_step, steps=steps)[steps // 2 :]
    np.testing.assert_allclose(apparent, 0.2, atol=1e-6)


def on_a_wire(d, at, nodes=11, mass=1e-3, time_step=1e-3):
    """A ball that rests on a taut elastic thread at a part of its span; the simulation, the thread, the ball."""
    scene = lm.Scene(dimension=d, gravity=(0.0,) * (d - 1) + (-10.0,))
    places = np.zeros((nodes, d))
    places[:, 0] = np.linspace(0.0, 1.0, nodes)
    chain = thread(scene, places, radius=0.002, law=lm.ElasticWire(stiffness=4e4), mass=mass)
    chain.reference_gap = chain.reference_gap - 0.01 / (nodes - 1)
    chain.bodies[0].fix()
    chain.bodies[-1].fix()
    place = np.zeros(d)
    place[0], place[-1] = at, 0.022
    held = ("x", "spin") if d == 2 else ("x", "y", "spin_x", "spin_y", "spin_z")
    ball = scene.add(grain(d, 0.02, place, 0.5)).fix(*held)
    scene.see("GRAIN", "THREAD", lm.Signorini())
    scene.drag(linear=8.0, bodies=[ball])
    scene.drag(linear=0.5, bodies=chain.bodies)
    return lm.Simulation(scene, time_step=time_step, solver=lm.Auto(tolerance=1e-9)), chain, ball


@pytest.mark.long
@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("at", [0.45, 0.537, 0.25, 0.701])
def test_a_ball_rests_on_a_taut_thread_wherever_it_touches(d, at):
    """Statics of the polygon: the two parts of the thread are straight, their tensions balance the ball and are those of
    the law."""
    sim, _, ball = on_a_wire(d, at)
    sim.run(duration=1.8)
    net = sim.interactions
    tension = -net.force[net.law == "elastic-wire", 0]
    up = sim.positions[:, -1]
    # beside the segment that bears the ball, and on it, each part is straight with one slope
    slopes = np.diff(up[:11]) / np.diff(sim.positions[:11, 0])
    bears = int(at / 0.1)
    left, right = slopes[: max(bears, 1)], slopes[min(bears + 1, 9) :]
    weight = 0.5 * 10.0
    own = 1e-3 * (1.0 + 0.3 * np.arange(11)) * 10.0
    assert np.abs(ball.velocity).max() < 2e-5
    vertical = tension * slopes / np.sqrt(1.0 + slopes**2)
    # the vertical force of a part changes by the weight of each node that hangs on it
    np.testing.assert_allclose(np.diff(vertical)[: max(bears - 1, 0)], own[1 : max(bears, 1)], atol=2e-5)
    # it still creeps, at 1e-5 m/s against the drag
    assert vertical[-1] - vertical[0] == pytest.approx(weight + own[1:-1].sum(), abs=3e-4)
    # moments about the left end: the support on the right bears its share of the ball
    share = (weight * at + (own[1:-1] * sim.positions[1:10, 0]).sum()) / sim.positions[10, 0]
    assert vertical[-1] == pytest.approx(share, rel=2e-3)  # the sag moves the horizontal forces by none of it
    assert left.max() < 0.0 < right.min()


def eulers_ratio(friction, angle, part):
    """Ratio of the tensions of a thread without bending stiffness that slides around a drum by an ``angle`` [rad].

    The friction acts on its surface, its radius r away from its axis: this couple is borne by a force Q across the axis.
    With the curvature c of the axis, the pressure q of the drum over c, and ``part = r c``, balance gives
    ``dT/dphi = mu q - Q``, ``q = T - dQ/dphi`` and ``Q = part mu q``. So T grows by ``e^(k phi)`` with
    ``k (1 + part mu k) = (1 - part) mu``.
    """
    k = friction * (1.0 - part)
    for _ in range(20):
        k = friction * (1.0 - part) / (1.0 + part * friction * k)
    return np.exp(k * angle)


@pytest.mark.default_parameters("2")
@pytest.mark.parametrize("d", [2, 3])
def test_a_thread_over_a_fixed_drum_has_eulers_ratio_of_tensions(d):
    """Without the polygon's correction: contacts are on the segments, and tend to it as they get shorter."""

    def ratio(count):
        sim = over_a_drum(d, count, friction=0.3, mass=1e-3, tolerance=1e-8)
        found = ratio_of_tensions(sim)
        assert sim.positions[-1, 0] == 0.0
        return found

    # the thread slides by 0.02 m, and the place of the contacts on the segments with it: the mean over two segments
    exact = eulers_ratio(0.3, np.pi, 2.0 / 102.0)
    assert ratio(12) == pytest.approx(exact, rel=0.015)
    assert ratio(48) == pytest.approx(exact, rel=0.004)


@pytest.mark.long
@pytest.mark.parametrize(
    ("count", "mass", "time_step", "error"),
    [(12, 1e-3, 1e-3, 0.015), (24, 1e-3, 1e-3, 0.005), (24, 1e-6, 1e-3, 0.005), (24, 1e-3, 4e-3, 0.005)],
)
def test_a_thread_over_a_thread_has_eulers_ratio_of_tensions(count, mass, time_step, error):
    """A thin thread is drawn over a thick one that is held: edges against edges."""
    scene = lm.Scene(dimension=3)
    thick, radius, dphi = 0.05, 2e-3, np.pi / count
    for node in thread(scene, [(0, -0.5, 0), (0, 0.5, 0)], color="BAR", radius=thick).bodies:
        node.fix()
    rho = (thick + radius) / np.cos(0.5 * dphi)
    angle, below = np.linspace(np.pi, 0.0, count + 1), -2.0 * rho * np.sin(0.5 * dphi) * np.arange(4, 0, -1)
    arc = rho * np.column_stack([np.cos(angle), 0.0 * angle, np.sin(angle)])
    down = np.column_stack([np.zeros((4, 2)), below])
    places = np.concatenate([arc[0] + down, arc, arc[-1] + down[::-1]])
    nodes = [scene.add(lm.point_mass(position=place, mass=mass)).fix("y") for place in places]
    scene.chain(nodes, lm.RigidWire(), surface=lm.Thread(radius))
    scene.see("BAR", "THREAD", lm.Coulomb(friction=0.3))
    nodes[0].fix("x").impose_force(z=-1.0)
    nodes[-1].impose_velocity(z=-0.02, x=0.0)
    sim = lm.Simulation(scene, time_step=time_step, solver=lm.Auto(tolerance=1e-8))
    steps = round(0.15 / time_step)
    found = ratio_of_tensions(sim, steps=steps, from_step=steps // 3)
    assert found == pytest.approx(eulers_ratio(0.3, np.pi, radius / (thick + radius)), rel=error)
    assert sim.unconverged_steps == 0


@pytest.mark.long
@pytest.mark.parametrize("time_step", [5e-4, 2e-3])
def test_two_rings_of_thread_that_are_linked_hold_a_load(time_step):
    """They hang in each other, and one is drawn down: it does not go through the other, which bears the load."""
    scene, count, size, radius, load = lm.Scene(dimension=3), 16, 0.1, 0.004, 2.0
    angle = 2.0 * np.pi * np.arange(count) / count
    flat = [np.column_stack([np.cos(angle), 0.0 * angle, np.sin(angle)]) * size, None]
    flat[1] = flat[0][:, [1, 0, 2]]
    rings = []
    for places, shift in zip(flat, ((0.0, 0.0, 0.7 * size), (0.003, 0.002, -0.7 * size)), strict=True):
        nodes = [scene.add(lm.point_mass(position=place + shift, mass=1e-2)) for place in places]
        rings.append(scene.chain(nodes, lm.RigidWire(), closed=True, surface=lm.Thread(radius)).bodies)
    rings[0][count // 4].fix()
    rings[1][3 * count // 4].impose_force(z=lambda t: -load * min(t / 0.3, 1.0))
    scene.see("THREAD", "THREAD", lm.Coulomb(friction=0.3))
    scene.drag(linear=0.5)
    sim = lm.Simulation(scene, time_step=time_step).run(duration=1.5)
    net = sim.interactions
    upper, lower = net.candidate < count, net.antagonist >= count
    between = (net.law == "coulomb") & (upper != ~lower)
    assert between.any()
    sign = np.where(upper[between], -1.0, 1.0)
    lifted = (sign[:, None, None] * net.force[between][:, :, None] * net.frame[between]).sum(axis=(0, 1))
    assert lifted[2] == pytest.approx(load, rel=2e-2)
    heights = sim.positions[:, 2]
    assert heights[:count].min() < heights[count:].max() - 2.0 * radius
    assert sim.unconverged_steps == 0


@pytest.mark.long
@pytest.mark.parametrize("pitch", [0.2, 0.5])
@pytest.mark.parametrize("count", [12, 24, 48])
def test_a_helix_on_a_cylinder_has_eulers_ratio_over_its_turning(count, pitch):
    """One turn at a ``pitch`` [rad] to the plane across the axis turns by ``2 pi cos(pitch)``, and a helix is as straight
    as the cylinder lets it be, so that friction acts along it. The error is the polygon's, of second order."""
    scene, drum, radius, friction = lm.Scene(dimension=3), 0.1, 2e-3, 0.3
    dphi = 2.0 * np.pi / count
    rho = (drum + radius) / np.cos(0.5 * dphi)
    angle = dphi * np.arange(count + 1)
    arc = np.column_stack([rho * np.cos(angle), rho * np.sin(angle), rho * np.tan(pitch) * (angle - np.pi)])

    def straight_on(way, turn):
        return np.array([[np.cos(turn), -np.sin(turn), 0], [np.sin(turn), np.cos(turn), 0], [0, 0, 1]]) @ way

    begin, end = straight_on(arc[0] - arc[1], -0.5 * dphi), straight_on(arc[-1] - arc[-2], 0.5 * dphi)
    k = np.arange(1, 5)[:, None]
    places = np.concatenate([(arc[0] + k * begin)[::-1], arc, arc[-1] + k * end])
    chain = thread(scene, places, radius=radius, law=lm.RigidWire(), mass=1e-3)
    scene.add(lm.capsule(radius=drum, length=2.0, position=(0, 0, 0), axis=(0, 0, 1), mass=1.0)).fix()
    scene.see("GRAIN", "THREAD", lm.Coulomb(friction=friction))
    chain.bodies[0].impose_force(**dict(zip("xyz", begin / np.linalg.norm(begin), strict=True)))
    chain.bodies[-1].impose_velocity(**dict(zip("xyz", 0.02 * end / np.linalg.norm(end), strict=True)))
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-8))
    found = ratio_of_tensions(sim)
    exact = eulers_ratio(friction, 2.0 * np.pi * np.cos(pitch), np.cos(pitch) ** 2 * radius / (drum + radius))
    assert found == pytest.approx(exact, rel=1.5 * dphi**2)
    assert sim.unconverged_steps == 0


@pytest.mark.scaled
@pytest.mark.default_parameters("2")
@pytest.mark.parametrize("d", [2, 3])
def test_impulse_gap_and_normal_are_continuous_as_a_ball_goes_along_a_thread(d):
    """A ball under a constant force slides along a held, bent thread without friction."""
    scene = lm.Scene(dimension=d)
    angle = np.linspace(-0.4, 0.4, 9)
    flat = np.column_stack([np.sin(angle), np.cos(angle) - 1.0])
    places = flat if d == 2 else np.insert(flat, 1, 0.0, axis=1)
    for node in thread(scene, places, radius=0.01).bodies:
        node.fix()
    start = np.zeros(d)
    start[0], start[-1] = -0.2, np.cos(0.2) - 1.0 + 0.061
    vertical = "y" if d == 2 else "z"
    ball = scene.add(grain(d, 0.05, start, 1.0)).impose_force(**{vertical: -10.0})
    ball.impose_velocity(x=0.4)
    scene.see("GRAIN", "THREAD", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3)
    counts, normals, impulses, gaps = [], [], [], []
    for _ in range(suites.size(450, long=1000)):  # four of the eight segments
        sim.step()
        net = sim.interactions
        here = np.flatnonzero((net.law == "signorini") & (net.impulse[:, 0] > 0.0))
        counts.append(len(here))
        if len(here):
            normals.append(net.normal[here].mean(axis=0))
            impulses.append(net.impulse[here, 0].sum())
            gaps.append(net.gap[here[0]])
    assert set(counts[40:]) <= {1}
    # a normal turns over a joint of 0.1 rad on an arc of 0.06 m, at 0.4 m/s by 6.7e-3 rad a step
    assert np.abs(np.diff(normals[40:], axis=0)).max() < 1e-2
    assert np.abs(np.diff(gaps[40:])).max() < 1e-5
    # centrifugal force over a joint, m v^2 / (R + r): 2.7 N of 10 N, less where the normal slants
    assert 0.6 < np.min(impulses[40:]) / 1e-2 < 1.2
    assert np.max(impulses[40:]) / 1e-2 < 1.2


def test_a_ring_under_pressure_has_the_tension_of_a_hoop():
    """2D: T = p R cos(dphi/2) of the polygon, whose corners bear ``p L cos(dphi/2)`` by ``2 T sin(dphi/2)``."""
    count, pressure, scene = 24, 50.0, lm.Scene(dimension=2)
    angle = -2.0 * np.pi * np.arange(count) / count  # clockwise: the normals point outward
    nodes = [scene.add(lm.point_mass(position=(np.cos(a), np.sin(a)), mass=0.01)) for a in angle]
    ring = scene.chain(nodes, lm.RigidWire(), closed=True, surface=lm.Thread(0.01))
    ring.skin.impose_pressure(-pressure)
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-10)).run(steps=20)
    length = 2.0 * np.sin(np.pi / count)
    tension = pressure * length * np.cos(np.pi / count) / (2.0 * np.sin(np.pi / count))
    np.testing.assert_allclose(-sim.interactions.force[:, 0], tension, rtol=1e-8)
    np.testing.assert_allclose(sim.velocities, 0.0, atol=1e-9)


def ball_of_triangles(level=1):
    """Points and triangles of an icosahedron on the unit sphere, each triangle cut into four, ``level`` times; outward."""
    g = 0.5 * (1.0 + np.sqrt(5.0))
    points = np.array([(a * u, b * v, 0.0) for u in (1, -1) for v in (1, -1) for a, b in [(1.0, g)]])
    points = np.concatenate([np.roll(points, k, axis=1) for k in range(3)])
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    near = np.abs(apart - 2.0) < 1e-9
    cells = [(i, j, k) for i in range(12) for j in range(i) for k in range(j) if near[i, j] and near[j, k] and near[i, k]]
    cells = np.array(cells)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    for _ in range(level):
        sides = np.sort(cells[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
        edges, which = np.unique(sides, axis=0, return_inverse=True)
        middle = points[edges].mean(axis=1)
        a, b, c = (len(points) + which.reshape(-1, 3)).T
        i, j, k = cells.T
        cells = np.concatenate([np.column_stack(rows) for rows in ((i, a, c), (a, j, b), (c, b, k), (a, b, c))])
        points = np.concatenate([points, middle / np.linalg.norm(middle, axis=1, keepdims=True)])
    corners = points[cells]
    inward = (np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) * corners[:, 0]).sum(axis=1) < 0.0
    cells[inward] = cells[inward][:, ::-1]
    return points, cells


def test_pressure_on_a_closed_membrane_does_the_work_of_its_volume():
    """``-p dV`` at the mean velocity, by the energy balance; neither momentum nor angular momentum."""
    points, cells = ball_of_triangles()
    scene = lm.Scene(dimension=3)
    nodes = [scene.add(lm.point_mass(position=p * (1.0, 0.8, 1.1), mass=0.01 * (1 + k % 3))) for k, p in enumerate(points)]
    membrane = scene.membrane(nodes, cells, lm.ElasticRod(stiffness=50.0), radius=0.01)
    membrane.impose_pressure(lambda t: 5.0 * np.sin(40.0 * t))
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-12))
    mass, volumes, work = sim.model.mass[:, :1], [], 0.0
    for _ in range(30):
        before, then = sim.positions.copy(), sim.time
        sim.step()
        p = 5.0 * np.sin(40.0 * (then + 0.5e-3))
        corners = [x[cells] for x in (before, sim.positions)]
        volume = [(np.cross(c[:, 0], c[:, 1]) * c[:, 2]).sum() / 6.0 for c in corners]
        work -= p * (volume[1] - volume[0])
        volumes.append(volume[1])
    # the forces are those in the middle of the step, where the volume has its slope to second order
    assert sim.energy.total_loads == pytest.approx(work, rel=1e-4)
    assert np.ptp(volumes) > 0.01
    np.testing.assert_allclose((mass * sim.velocities).sum(axis=0), 0.0, atol=1e-13)
    np.testing.assert_allclose((mass * np.cross(sim.positions, sim.velocities)).sum(axis=0), 0.0, atol=1e-12)


def test_forces_on_many_bodies_are_those_on_each():
    made = []
    for together in (True, False):
        scene = lm.Scene(dimension=2)
        beads = [scene.add(lm.disk(radius=0.1, position=(i, 0.0), mass=1.0 + i)) for i in range(4)]
        forces = np.arange(8.0).reshape(4, 2)
        if together:
            scene.impose_forces(beads[:2], lambda t, given=forces: given[:2] * (1.0 + t))
            scene.impose_forces(beads[2:], forces[2:])
        else:
            for bead, (x, y), grows in zip(beads, forces, (1, 1, 0, 0), strict=True):
                bead.impose_force(x=lambda t, x=x, g=grows: x * (1.0 + g * t), y=lambda t, y=y, g=grows: y * (1.0 + g * t))
        made.append(lm.Simulation(scene, time_step=1e-3).run(steps=20))
    np.testing.assert_array_equal(made[0].positions, made[1].positions)
    assert made[0].energy.total_loads == pytest.approx(made[1].energy.total_loads, rel=1e-14)


def test_forces_on_what_is_held_are_refused():
    scene = lm.Scene(dimension=2)
    press = scene.add(lm.wall_segment((0, 0), (1, 0), mass=1.0))
    with pytest.raises(ValueError, match="is held, so that forces do not move it: load it by its impose_force"):
        scene.impose_forces([press], (0.0, 1.0))


@pytest.mark.default_parameters("3")
@pytest.mark.parametrize("d", [2, 3])
def test_a_run_with_surfaces_is_resumed_bit_for_bit_and_comes_back_from_its_file(tmp_path, d):
    sim, chain, _ = on_a_wire(d, 0.537)
    sim.run(steps=40, record=tmp_path / "whole.h5")
    half, _, _ = on_a_wire(d, 0.537)
    half.run(steps=20, record=tmp_path / "half.h5")
    again = lm.resume(tmp_path / "half.h5").run(steps=20)
    np.testing.assert_array_equal(again.positions, sim.positions)
    np.testing.assert_array_equal(again.velocities, sim.velocities)
    scene = lm.Scene.from_run(tmp_path / "whole.h5")
    assert scene.skins[0].radius == 0.002
    assert scene.chains[0].skin is scene.skins[0]
    np.testing.assert_array_equal(scene.skins[0].cells, chain.skin.cells)
    assert isinstance(scene.bodies[3], lm.PointMass)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:In the step")  # a node moves by half of its radius
@pytest.mark.parametrize("d", [2, 3])
def test_a_scene_at_its_start_takes_a_checkpoint_of_a_thread_that_was_drawn_out(d):
    """From 0.1 m to 0.5 m: a ball beside its end is far from the segment of the start. The list of neighbours is made anew
    with the segment of the time of the list, so that it has the pair whose contact the checkpoint remembers."""

    def drawn_out():
        scene, flat = lm.Scene(dimension=d), (0.0,) * (d - 2)
        nodes = [
            scene.add(lm.point_mass(position=(0.05 * way, 0.0, *flat), velocity=(5.0 * way, 0.0, *flat), mass=1.0))
            for way in (-1, 1)
        ]
        scene.chain(nodes, lm.ElasticWire(stiffness=1.0), surface=lm.Thread(0.01))
        scene.add(grain(d, 0.02, (0.2, 0.029, *flat), mass=0.1))
        scene.see("GRAIN", "THREAD", lm.Coulomb(friction=0.3))
        return lm.Simulation(scene, time_step=1e-3)

    whole, again = drawn_out().run(steps=40), drawn_out()
    assert whole.interactions.law.tolist() == ["elastic-wire", "coulomb"]
    again.restore(whole.checkpoint())
    whole.run(steps=20)
    again.run(steps=20)
    np.testing.assert_array_equal(again.positions, whole.positions)
    np.testing.assert_array_equal(again.velocities, whole.velocities)


@pytest.mark.default_parameters("2")
@pytest.mark.parametrize("d", [2, 3])
def test_a_thread_that_a_run_has_crushed_comes_back_from_its_file(tmp_path, d):
    """Nodes nearer to each other than the thickness are refused in a scene that is written, not in one that a run left."""
    scene, flat = lm.Scene(dimension=d), (0.0,) * (d - 1)
    nodes = [scene.add(lm.point_mass(position=(0.1 * k, *flat), velocity=(-k, *flat), mass=1.0)) for k in range(3)]
    scene.chain(nodes, lm.ElasticWire(stiffness=1.0), surface=lm.Thread(0.03))
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=60, record=tmp_path / "run.h5")
    assert 0.03 < sim.positions[1, 0] - sim.positions[0, 0] < 0.05
    again = lm.Simulation(lm.Scene.from_run(tmp_path / "run.h5"), time_step=1e-3).run(steps=10)
    whole = lm.resume(tmp_path / "run.h5").run(steps=10)
    np.testing.assert_array_equal(again.positions, whole.positions)


def test_functions_of_time_of_pressures_and_forces_are_asked_for_again(tmp_path):
    def made():
        scene = lm.Scene(dimension=2)
        nodes = [scene.add(lm.point_mass(position=p, mass=1.0)) for p in [(0, 0), (1, 0), (0.5, 1)]]
        scene.chain(nodes, lm.RigidWire(), closed=True, surface=lm.Thread(0.01)).skin.impose_pressure(np.sin)
        scene.impose_forces(nodes, lambda t: (t, 0.0))
        return lm.Simulation(scene, time_step=1e-3)

    made().run(steps=10, record=tmp_path / "run.h5")
    with pytest.raises(ValueError, match=r"\(\"pressure\", 0\): f, \(\"forces\", 0\): f"):
        lm.resume(tmp_path / "run.h5")
    functions = {("pressure", 0): np.sin, ("forces", 0): lambda t: (t, 0.0)}
    again = lm.resume(tmp_path / "run.h5", functions=functions).run(steps=10)
    np.testing.assert_array_equal(again.positions, made().run(steps=20).positions)


@pytest.mark.parametrize(
    ("d", "mass", "time_step"),
    [
        (2, 1e-3, 1e-3),
        *(pytest.param(d, m, h, marks=pytest.mark.long) for d in (2, 3) for m in (1e-6, 1.0) for h in (1e-4, 4e-3)),
    ],
)
def test_a_thread_is_tied_to_a_point_of_a_body_by_a_joint(d, mass, time_step):
    """A plate of 2 kg with the centre of mass at 0 hangs on threads at x = -0.3 and 0.2 m: by moments they bear 8 and 12 N,
    and the weights of their nodes."""
    scene = lm.Scene(dimension=d, gravity=(0.0,) * (d - 1) + (-10.0,))

    def at(x, y):
        return (x, *[0.0] * (d - 2), y)

    make, inertia = (lm.DiskContactor, 0.1) if d == 2 else (lm.SphereContactor, (0.01, 0.1, 0.1))
    balls = [(make(0.05), at(x, 0.0)) for x in (-0.3, 0.3)]
    plate = scene.add(lm.RigidBody(balls, mass=2.0, inertia=inertia, position=at(0.0, 0.0), color="PLATE"))
    for x in (-0.3, 0.2):
        nodes = [scene.add(lm.point_mass(position=at(x, 0.1 * k), mass=mass)) for k in range(6)]
        scene.chain(nodes, lm.RigidWire(), surface=lm.Thread(0.01))
        nodes[-1].fix()
        scene.link(plate, nodes[0], lm.BallJoint(), at=(at(x, 0.0), None))
    scene.see("PLATE", "THREAD", lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=time_step, solver=lm.Auto(tolerance=1e-8)).run(steps=60)
    net = sim.interactions
    lowest = -net.force[net.law == "rigid-wire", 0][[0, 5]]
    assert lowest == pytest.approx([8.0 + 10.0 * mass, 12.0 + 10.0 * mass], rel=1e-7)
    assert not (net.law == "coulomb").any()


@pytest.mark.long
def test_a_net_catches_a_ball_that_beads_would_let_through():
    """A ball of radius 0.06 m fits between the nodes of a mesh of 0.1 m, but not between its segments: it rests on four."""
    scene = lm.Scene(dimension=3, gravity=(0, 0, -10.0))
    n = 5
    places = [(0.1 * i, 0.1 * j, 0.0) for i in range(n) for j in range(n)]
    nodes = [scene.add(lm.point_mass(position=p, mass=0.01)) for p in places]
    edges = [(i * n + j, i * n + j + 1) for i in range(n) for j in range(n - 1)]
    edges += [(i * n + j, i * n + j + n) for i in range(n - 1) for j in range(n)]
    net = scene.net(nodes, edges, lm.ElasticWire(stiffness=5e3), surface=lm.Thread(0.002))
    for node in nodes:
        if {node.position[0], node.position[1]} & {0.0, 0.1 * (n - 1)}:
            node.fix()
    ball = scene.add(lm.sphere(radius=0.06, position=(0.15, 0.15, 0.05), mass=0.1))
    scene.drag(linear=2.0, bodies=[ball, *nodes])
    scene.see("GRAIN", "THREAD", lm.Coulomb(friction=0.5))
    sim = lm.Simulation(scene, time_step=1e-3).run(duration=1.0)
    assert len(net.chains) < len(edges) / 3
    assert sum(len(chain.bodies) - 1 for chain in net.chains) == len(edges)
    assert ball.position[2] > 0.0
    assert (sim.interactions.law == "coulomb").sum() == 4
    forces = sim.interactions
    lifted = (forces.force[:, :, None] * forces.frame)[forces.law == "coulomb"].sum(axis=1)
    np.testing.assert_allclose(lifted.sum(axis=0), (0, 0, 1.0), atol=1e-2)


@pytest.mark.default_parameters("0.2")
@pytest.mark.parametrize("push", [0.0, 0.2, -0.2])
def test_a_slack_thread_that_folds_does_not_go_through_itself(push):
    """The link between two segments that meet has a node of each, so that no contact on it is seen: the node at its end is
    met from the side of the other segment."""
    scene = lm.Scene(dimension=3)
    places = np.array([(0, 0, 0), (1, 0, 0), (1.1, 0, 0.3), (0.2, 0.05, 0.3)])
    nodes = [scene.add(lm.point_mass(position=place, mass=1.0)) for place in places]
    for node in nodes[:2]:
        node.fix()
    for node in nodes[2:]:
        node.impose_force(x=push, z=-1.0)
    scene.chain(nodes, lm.RigidWire(), reference_gap=[1.0, 0.5, 1.0], surface=lm.Thread(0.05))
    scene.see("THREAD", "THREAD", lm.Coulomb(friction=0.3))
    sim, apart = lm.Simulation(scene, time_step=4e-3), []
    for _ in range(600):
        sim.step()
        middle, half = 0.5 * (sim.positions[1:] + sim.positions[:-1]), 0.5 * np.diff(sim.positions, axis=0)
        apart.append(segment_distances(middle[:1], half[:1], middle[2:], half[2:])[0])
    assert min(apart) < 0.101
    # 0.002 without the contact; contacts are those of the middle of a step
    assert min(apart) > 0.0995
    assert sim.positions[2, 2] < -0.3  # it slides off, around the end of the other one
    assert sim.unconverged_steps == 0


BAD = {
    "nodes closer than the thread is thick": (
        lambda s: thread(s, [(0, 0), (0.15, 0), (1, 0)]),
        "Cell 0 of a surface, between .* has nodes 0.15 m apart, closer than its thickness of 0.2 m",
    ),
    "no thread": (
        lambda s: s.chain([s.add(lm.point_mass(position=(i, 0), mass=1.0)) for i in range(2)], ROD, surface=0.1),
        "surface must be a lmgcpy.Thread",
    ),
    "points off the centres": (
        lambda s: s.chain(
            [(s.add(lm.disk(radius=0.1, position=(i, 0), mass=1.0)), (0.0, 0.1)) for i in range(2)],
            ROD,
            surface=lm.Thread(0.01),
        ),
        r"goes through centres of bodies.*tie both by scene.link\(body, node, lmgcpy.BallJoint\(\), at=\(point, None\)\)",
    ),
    "a membrane in 2D": (lambda s: s.membrane([], [[0, 1, 2]], ROD, radius=0.1), "in 2D take a chain"),
    "a corner twice": (
        lambda s: s.net([s.add(lm.point_mass(position=(i, 0), mass=1.0)) for i in range(2)], [[0, 1], [1, 1]], ROD),
        r"Row 1 of the edges of a net is \[1.0, 1.0\]",
    ),
    "an edge twice": (
        lambda s: s.net([s.add(lm.point_mass(position=(i, 0), mass=1.0)) for i in range(2)], [[0, 1], [1, 0]], ROD),
        "Two edges of a net join the same bodies",
    ),
}


@pytest.mark.parametrize("case", BAD)
def test_surfaces_that_cannot_be_are_refused_with_a_sentence(case):
    make, words = BAD[case]
    scene = lm.Scene(dimension=2)
    with pytest.raises((TypeError, ValueError), match=words):
        make(scene)
    assert scene.skins == []


def test_slack_nodes_of_a_settled_chain_may_be_closer_than_the_thread_is_thick():
    scene = lm.Scene(dimension=2)
    nodes = [scene.add(lm.point_mass(position=(0.15 * i, 0), mass=1.0)) for i in range(2)]
    chain = scene.chain(nodes, lm.RigidWire(), reference_gap=0.3, surface=lm.Thread(0.1), settled=True)
    lm.Simulation(scene, time_step=1e-3).run(steps=3)
    assert scene.skins == [chain.skin]


TRIANGLES = {
    "a line": ([[0, 1, 2], [0, 1, 3]], "Triangle 1 of a membrane, between .*, has a height of 0 m, less than its thick"),
    "flat": (
        [[0, 1, 2], [0, 4, 1], [1, 4, 3], [0, 5, 4]],
        r"Triangle 3 of a membrane, between .* and .* and .*, has a height of 0.019 m, less than its thickness of 0.02 m: "
        "leave it out, move a body, or take a smaller radius",
    ),
    "the same twice": ([[0, 1, 2], [2, 0, 1]], r"Triangle 0 of a membrane, \[0, 1, 2\], is there 2 times"),
    "the same twice, with a neighbour": (
        [[0, 1, 2], [2, 1, 3], [2, 0, 1]],
        r"Triangle 0 of a membrane, \[0, 1, 2\], is there 2 times: leave one",
    ),
    "three at an edge": (
        [[0, 1, 2], [0, 1, 3], [1, 0, 4]],
        r"3 triangles of a surface, 0, 1, 2, meet at the edge of its corners \[0, 1\], and two are the most",
    ),
    "a body in none": ([[0, 1, 2], [0, 4, 1]], r"body 3, .* is in none of the triangles of a membrane"),
}


@pytest.mark.parametrize("case", TRIANGLES)
def test_membranes_that_cannot_be_are_refused_with_a_sentence(case):
    cells, words = TRIANGLES[case]
    scene = lm.Scene(dimension=3)
    places = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (2, 0, 0), (0, -1, 0), (-0.019, -0.5, 0)]
    count = len(places) if "none" in case else 1 + np.max(cells)
    nodes = [scene.add(lm.point_mass(position=p, mass=1.0)) for p in places[:count]]
    with pytest.raises(ValueError, match=words):
        scene.membrane(nodes, cells, ROD, radius=0.01)
    assert scene.skins == scene.chains == []


@pytest.mark.parametrize("d", [2, 3])
def test_a_pressure_acts_on_one_side_of_a_surface_or_is_refused(d):
    """Two cells side by side whose normals are on one side, and on different sides."""
    places = [(0, 0), (1, 0), (2, 0)] if d == 2 else [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, -1, 0)]
    right, wrong = ([[0, 1], [1, 2]], [[0, 1], [2, 1]]) if d == 2 else ([[0, 1, 2], [0, 3, 1]], [[0, 1, 2], [0, 1, 3]])
    for cells in (right, wrong):
        scene = lm.Scene(dimension=d)
        nodes = [scene.add(lm.point_mass(position=p, mass=1.0)) for p in places]
        made = scene.net(nodes, cells, ROD, surface=lm.Thread(0.01)) if d == 2 else None
        made = scene.membrane(nodes, cells, ROD, radius=0.01) if d == 3 else made
        if cells is right:
            assert made.impose_pressure(3.0).skin.pressure == 3.0
        else:
            with pytest.raises(ValueError, match="normals of the cells 0 and 1 of a surface are on different sides"):
                made.impose_pressure(3.0)
            assert made.skin.pressure is None


def test_a_chain_with_a_surface_takes_a_pressure_and_one_without_is_told():
    scene = lm.Scene(dimension=2)
    nodes = [scene.add(lm.point_mass(position=(k, 0), mass=1.0)) for k in range(4)]
    chain = scene.chain(nodes[:2], ROD, surface=lm.Thread(0.1))
    assert chain.impose_pressure(2.0) is chain
    assert chain.skin.pressure == 2.0
    with pytest.raises(TypeError, match=r"without a surface has no side .* surface=lmgcpy.Thread\(radius\)"):
        scene.chain(nodes[2:], ROD).impose_pressure(2.0)


def test_a_thread_in_space_has_no_side_for_a_pressure():
    scene = lm.Scene(dimension=3)
    surface = thread(scene, [(0, 0, 0), (1, 0, 0)]).skin
    with pytest.raises(TypeError, match="has no side"):
        surface.impose_pressure(1.0)


SOLID = {
    "a disk": lambda: lm.disk(radius=0.1, position=(0, 0), mass=1.0),
    "a wall": lambda: lm.wall(point=(0, 0, 0), normal=(0, 0, 1), mass=1.0),
    "a segment": lambda: lm.wall_segment((0, 0), (1, 0), mass=1.0),
    "a plate": lambda: lm.plate([(0, 0, 0), (1, 0, 0), (0, 1, 0)], mass=1.0),
    "a mesh": lambda: lm.mesh([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(0, 1, 2)]),
    "a node": lambda: lm.point_mass(position=(0, 0), mass=1.0),
}


@pytest.mark.parametrize("case", SOLID)
def test_a_body_takes_no_pressure_and_says_so(case):
    with pytest.raises(TypeError, match=r"^<.* m> takes no pressure: .* Load it with impose_force, by the pressure times"):
        SOLID[case]().impose_pressure(1.0)


def test_the_stress_of_a_thread_between_plates_is_their_pressure_and_its_tension():
    """A thread under tension that grains press from both sides: along it the stress is T L / V, across it the forces of
    the grains times their distance."""
    scene = lm.Scene(dimension=2)
    chain = thread(scene, [(0.1 * i, 0.0) for i in range(6)], radius=0.01, law=lm.RigidWire(), mass=1.0)
    chain.bodies[0].impose_force(x=-3.0)
    chain.bodies[-1].fix("x")
    for x in (0.13, 0.28, 0.41):
        for side in (1.0, -1.0):
            scene.add(grain(2, 0.05, (x, side * 0.06), 1.0)).fix("x", "spin").impose_force(y=-2.0 * side)
    scene.see("GRAIN", "THREAD", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-10)).run(steps=3)
    stress = lm.measure.stress(sim, volume=1.0)
    assert stress["rigid-wire"][0, 0] == pytest.approx(3.0 * 0.5, rel=1e-9)
    # from the foot on the axis to the centre of the grain, on both sides
    assert stress["signorini"][1, 1] == pytest.approx(-3 * 2.0 * 0.12, rel=1e-9)
    np.testing.assert_allclose([stress["total"][0, 1], stress["total"][1, 0], stress["signorini"][0, 0]], 0.0, atol=1e-9)


def grounds(d):
    """Floors at height 0, by name."""
    if d == 2:
        return {"wall": lm.wall(point=(0, 0), normal=(0, 1)), "segment": lm.wall_segment((-2, 0), (2, 0), radius=0.0)}
    square = [(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)]
    return {"wall": lm.wall(point=(0, 0, 0), normal=(0, 0, 1)), "plate": lm.plate(square)}


@pytest.mark.default_parameters("2-wall")
@pytest.mark.parametrize(("d", "ground"), [(2, "wall"), (2, "segment"), (3, "wall"), (3, "plate")])
def test_a_thread_falls_on_what_bounds_a_scene_and_lies_there(d, ground):
    scene = lm.Scene(dimension=d, gravity=(0.0,) * (d - 1) + (-10.0,))
    places = np.zeros((9, d))
    places[:, 0] = np.linspace(-0.4, 0.4, 9)
    places[:, -1] = 0.05 + 0.02 * np.sin(9.0 * places[:, 0])
    chain = thread(scene, places, radius=0.01, law=lm.RigidWire(), mass=0.01)
    scene.add(grounds(d)[ground])
    scene.see("THREAD", "WALL", lm.Coulomb(friction=0.5))
    scene.see("THREAD", "THREAD", lm.Coulomb(friction=0.5))
    sim = lm.Simulation(scene, time_step=1e-3).run(duration=0.4)
    assert sim.unconverged_steps == 0
    np.testing.assert_allclose(sim.positions[: len(chain.bodies), -1], 0.01, atol=1e-5)
    net = sim.interactions
    weight = 10.0 * sum(node.mass for node in chain.bodies)
    lifted = (net.force[:, :, None] * net.frame)[net.law == "coulomb"].sum(axis=(0, 1))[-1]
    assert lifted == pytest.approx(weight, rel=1e-3)


@pytest.mark.long
def test_a_membrane_bears_a_ball_by_the_tensions_along_its_edges():
    """A ball rests on a flat square membrane that is held at its rim: its weight is on the rim's nodes."""
    scene, n = lm.Scene(dimension=3, gravity=(0, 0, -10.0)), 5
    nodes = [scene.add(lm.point_mass(position=(0.1 * i, 0.1 * j, 0.0), mass=1e-3)) for i in range(n) for j in range(n)]
    cells = []
    for i in range(n - 1):
        for j in range(n - 1):
            k = i * n + j
            cells += [(k, k + n, k + 1), (k + 1, k + n, k + n + 1)]
    scene.membrane(nodes, cells, lm.ElasticRod(stiffness=200.0), radius=0.002)
    inside = [node for node in nodes if {node.position[0], node.position[1]}.isdisjoint({0.0, 0.1 * (n - 1)})]
    for node in nodes:
        if node not in inside:
            node.fix()
    ball = scene.add(lm.sphere(radius=0.05, position=(0.213, 0.197, 0.06), mass=0.2)).fix("x", "y")
    scene.drag(linear=3.0, bodies=[ball])
    scene.drag(linear=0.1, bodies=inside)
    scene.see("GRAIN", "MEMBRANE", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3).run(duration=2.0)
    net = sim.interactions
    touching = net.law == "signorini"
    lifted = (net.force[:, :1] * net.normal)[touching].sum(axis=0)
    assert lifted[2] == pytest.approx(2.0, rel=2e-3)
    rim = np.array([node.id for node in nodes if node not in inside])
    pull = np.zeros(3)
    for ids, sign in ((net.candidate, 1.0), (net.antagonist, -1.0)):
        on_rim = np.isin(ids, rim) & ~touching
        pull += sign * (net.force[:, :1] * net.normal)[on_rim].sum(axis=0)
    own = 10.0 * 1e-3 * len(inside)
    assert pull[2] == pytest.approx(-(2.0 + own), rel=1e-2)  # links pull the rim down; some triangles at it bear the ball
    assert sim.unconverged_steps == 0


def deflection_of_a_square(x, y, a, b, count=300):
    """Green's function of ``-(w_xx + w_yy) = 1`` on the unit square, zero on its sides, for a load at (a, b)."""
    m, q = np.pi * np.arange(1, count + 1)[:, None], np.pi * np.arange(1, count + 1)[None]
    return 4.0 * np.sum(np.sin(m * x) * np.sin(m * a) * np.sin(q * y) * np.sin(q * b) / (m * m + q * q))


@pytest.mark.long
@pytest.mark.parametrize("loaded", ["pressure", "ball"])
def test_a_taut_membrane_sags_as_the_membrane_equation_says(loaded):
    """A square membrane of side 1 m under S = 100 N/m, as all straight links have the tension S l and the diagonals none.

    The nodes have the sag of the five-point formula for ``S (w_xx + w_yy) = -q``, to the part of 1e-3 by which slopes of
    1e-3 and what is left of the motion change it. This differs from the equation by l^2: the middle sags by
    0.07367 p/S under a pressure p, and by Green's function under a ball, less near the ball.
    """
    n, S, stiffness, pressure, weight = 8, 100.0, 2e4, 0.5, 0.05
    side = 1.0 / n
    scene = lm.Scene(dimension=3)
    places = np.array([(i * side, j * side, 0.0) for i in range(n + 1) for j in range(n + 1)])
    nodes = [scene.add(lm.point_mass(position=place, mass=1e-3)) for place in places]
    square = [(n + 1) * i + j for i in range(n) for j in range(n)]
    cells = np.array([t for a in square for t in ((a, a + n + 1, a + n + 2), (a, a + n + 2, a + 1))])
    edges = np.unique(np.sort(cells[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    length = np.linalg.norm(places[edges[:, 0]] - places[edges[:, 1]], axis=1)
    straight = length < 1.2 * side
    gaps = np.where(straight, length - S * side / stiffness, length)
    made = scene.membrane(nodes, cells, lm.ElasticRod(stiffness=stiffness), radius=0.005, reference_gap=gaps)
    np.testing.assert_array_equal(made.edges, edges)
    inside = [node for node in nodes if min(node.position[:2]) > 0.0 and max(node.position[:2]) < 1.0]
    for node in nodes:
        if node not in inside:
            node.fix()
    scene.drag(linear=0.35, bodies=inside)
    free = np.array([node.id for node in inside])
    load, at = np.zeros(len(places)), np.array([0.44, 0.53])
    if loaded == "pressure":
        made.impose_pressure(pressure)  # all nodes inside have six triangles of l^2/2
        load[free] = pressure * side**2
    else:
        ball = scene.add(lm.sphere(radius=0.02, position=(*at, 0.025), mass=0.02))
        ball.fix("x", "y", "spin_x", "spin_y", "spin_z").impose_force(z=-weight)
        scene.drag(linear=2.0, bodies=[ball])
        scene.see("GRAIN", "MEMBRANE", lm.Signorini())
        i, j = np.floor(at / side).astype(int)
        u, v = at / side - (i, j)
        first = (n + 1) * i + j  # the triangle above the diagonal if v > u
        corners, parts = ([0, n + 2, 1], [1 - v, u, v - u]) if v > u else ([0, n + 1, n + 2], [1 - u, u - v, v])
        load[first + np.array(corners)] = weight * np.array(parts)
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-7)).run(duration=0.25)
    stiff = np.zeros((len(places), len(places)))
    for a, b in edges[straight]:
        stiff[[a, b], [a, b]] += S
        stiff[[a, b], [b, a]] -= S
    sag, right = -sim.positions[free, 2], np.linalg.solve(stiff[np.ix_(free, free)], load[free])
    np.testing.assert_allclose(sag, right, atol=2e-3 * right.max())
    if loaded == "pressure":
        assert sag.max() == pytest.approx(0.07367 * pressure / S, rel=0.02)
    else:
        for x, y in ((0.25, 0.25), (0.75, 0.25), (0.75, 0.75), (0.25, 0.75)):
            (k,) = np.flatnonzero(np.linalg.norm(places[free, :2] - (x, y), axis=1) < 1e-9)
            assert sag[k] == pytest.approx(weight / S * deflection_of_a_square(x, y, *at), rel=0.08)
    assert sim.unconverged_steps == 0


@pytest.mark.long
@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("at", [0.5, 0.263])
def test_a_taut_thread_sags_as_the_string_equation_says(d, at):
    """Under a weight W at x a string of length L and tension T sags by ``W x (L - x)/(T L)``; a polygon is straight over
    the segment that has the weight, and sags there by ``W a b/(T l)`` less, for the distances a and b from its nodes. The
    tension of 40 N rises by 1e-5 of it."""
    scene, n, tension, weight, stiffness = lm.Scene(dimension=d), 10, 40.0, 0.05, 4e4
    places = np.zeros((n + 1, d))
    places[:, 0] = np.linspace(0.0, 1.0, n + 1)
    law = lm.ElasticWire(stiffness=stiffness)
    nodes = [scene.add(lm.point_mass(position=place, mass=1e-3)) for place in places]
    gap = 1.0 / n - tension / stiffness
    scene.chain(nodes, law, surface=lm.Thread(0.002), reference_gap=gap)
    for node in (nodes[0], nodes[-1]):
        node.fix()
    place = np.zeros(d)
    place[0], place[-1] = at, 0.022
    ball = scene.add(grain(d, 0.02, place, 5e-3))
    ball.fix(*("xyz"[: d - 1]), *(("spin",) if d == 2 else ("spin_x", "spin_y", "spin_z")))
    ball.impose_force(**{"xyz"[d - 1]: -weight})
    scene.drag(linear=1.8, bodies=[ball])
    scene.drag(linear=0.3, bodies=nodes)
    scene.see("GRAIN", "THREAD", lm.Signorini())
    lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-8)).run(duration=0.3)
    a = at % (1.0 / n)
    sag = weight / tension * (at * (1.0 - at) - a * (1.0 / n - a) * n)
    assert 0.022 - ball.position[-1] == pytest.approx(sag, rel=1e-3)
    assert abs(ball.velocity[-1]) < 1e-5 * sag / 1e-3


def test_rolling_friction_on_a_thread_is_refused():
    scene = lm.Scene(dimension=2)
    thread(scene, [(0, 0), (1, 0)])
    scene.add(grain(2, 0.1, (0.5, 0.5)))
    scene.see("GRAIN", "THREAD", lm.RollingCoulomb(friction=0.3, rolling_friction=0.1))
    with pytest.raises(ValueError, match="has rolling friction, and 'THREAD' is a thread or membrane"):
        lm.Simulation(scene, time_step=1e-3)


@pytest.mark.parametrize("back", [False, True])
def test_a_bead_does_not_meet_the_segments_of_a_node_from_which_a_link_keeps_it(back):
    """Whichever way the thread runs: a segment stands for both of its nodes."""
    scene = lm.Scene(dimension=2)
    places = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]
    chain = thread(scene, places[::-1] if back else places)
    end = next(node for node in chain.bodies if node.position[0] == 0.0)
    bead = scene.add(grain(2, 0.3, (0.2, 0.35)))
    scene.chain([end, bead], ROD, neighbours_collide=False)
    scene.add(grain(2, 0.3, (1.5, 0.35)))
    scene.see("GRAIN", "THREAD", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3, overlap="ignore")
    sim.step()
    (row,) = np.flatnonzero(sim.interactions.law == "signorini")
    assert bead.id not in (sim.interactions.candidate[row], sim.interactions.antagonist[row])


def test_gaps_of_a_net_are_one_or_one_an_edge():
    scene = lm.Scene(dimension=3)
    nodes = [scene.add(lm.point_mass(position=(k, 0, 0), mass=1.0)) for k in range(3)]
    bad = ({"reference_gap": [1.0] * 3}, r"one an edge, \(2,\), got \(3,\)"), ({"neighbours_collide": 2}, "unless it")
    for wrong, words in bad:
        with pytest.raises((TypeError, ValueError), match=words):
            scene.net(nodes, [[0, 1], [1, 2]], ROD, surface=lm.Thread(0.1), **wrong)
    assert scene.skins == scene.chains == []


def test_a_net_with_a_link_that_cannot_be_is_not_there():
    """The links of a net are several chains: one of the last is off its reference, and the net is refused as a whole."""
    scene = lm.Scene(dimension=3)
    nodes = [scene.add(lm.point_mass(position=(k % 3, k // 3, 0), mass=1.0)) for k in range(9)]
    edges = [[k, k + 1] for k in range(9) if k % 3 < 2] + [[k, k + 3] for k in range(6)]
    for last in range(12):
        gaps = np.where(np.arange(12) == last, 0.5, 1.0)
        with pytest.raises(ValueError, match="would pull it right with a blow"):
            scene.net(nodes, edges, lm.RigidWire(), surface=lm.Thread(0.1), reference_gap=gaps)
        assert scene.skins == scene.chains == []


def test_the_colour_of_points_is_not_one_of_a_surface():
    scene = lm.Scene(dimension=2)
    thread(scene, [(0, 0), (1, 0)])
    scene.add(grain(2, 0.1, (0.5, 0.5)))
    scene.see("GRAIN", "NODE", lm.Signorini())
    with pytest.raises(ValueError, match=r"points without a shape.*Known: GRAIN, THREAD"):
        lm.Simulation(scene, time_step=1e-3)


@pytest.mark.parametrize(
    ("answer", "kind", "words"),
    [
        (lambda t: 1.0 / 0.0, RuntimeError, "The function of time imposed as a pressure at t = 0.0005 s failed with"),
        (lambda t: np.nan, FloatingPointError, "What is imposed as a pressure at t = 0.0005 s must be"),
        (lambda t: "high", TypeError, "What is imposed as a pressure at t = 0.0005 s must be"),
    ],
)
def test_a_pressure_that_fails_is_named(answer, kind, words):
    scene = lm.Scene(dimension=2)
    thread(scene, [(0, 0), (1, 0)]).skin.impose_pressure(answer)
    with pytest.raises(kind, match=words):
        lm.Simulation(scene, time_step=1e-3).step()


def surface(kind, d):
    """A straight held thread along x, or a flat held membrane or net, with nodes 0.1 m apart."""
    scene = lm.Scene(dimension=d)
    if kind == "thread":
        places = [(0.1 * i, 0.0, 0.0)[:d] for i in range(9)]
    else:
        places = [(0.1 * i, 0.1 * j, 0.0) for i in range(5) for j in range(5)]
    nodes = [scene.add(lm.point_mass(position=place, mass=1.0)).fix() for place in places]
    across = [(k, k + 5) for k in range(20)] + [(k, k + 1) for k in range(24) if k % 5 < 4]
    squares = [k for k in range(20) if k % 5 < 4]
    if kind == "thread":
        scene.chain(nodes, ROD, surface=lm.Thread(0.01, color="THREAD"))
    elif kind == "net":
        scene.net(nodes, across, lm.ElasticWire(stiffness=1.0), surface=lm.Thread(0.01, color="THREAD"))
    else:
        corners = [(k, k + 5, k + 6) for k in squares] + [(k, k + 6, k + 1) for k in squares]
        scene.membrane(nodes, corners, lm.ElasticWire(stiffness=1.0), radius=0.01, color="THREAD")
    return scene


@pytest.mark.parametrize("place", [(0.1, 0.1), (0.2, 0.2), (0.1 + 0.2, 0.1), (0.3, 0.0), (0.2, 0.25), (0.0, 0.0)])
@pytest.mark.parametrize(("kind", "d"), [("thread", 2), ("thread", 3), ("net", 3), ("membrane", 3)])
def test_a_ball_exactly_over_a_node_has_one_contact(kind, d, place):
    """As a symmetric scene has it. Law and node shared the place up to rounding: a law that pulls held twice."""
    x, y = place if kind != "thread" else (place[0], 0.0)
    scene = surface(kind, d)
    make = lm.disk if d == 2 else lm.sphere
    scene.add(make(radius=0.05, position=(x, 0.06) if d == 2 else (x, y, 0.06), mass=1.0))
    scene.see("GRAIN", "THREAD", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3)
    sim.step()
    found = sim.interactions
    assert np.count_nonzero((found.law == "signorini") & (np.abs(found.gap) < 1e-9)) == 1
