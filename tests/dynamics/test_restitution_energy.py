"""Restitution makes no energy, whatever meets, and what it leaves at rest stays at rest."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lmgcpy as lm
from lmgcpy.laws.coulomb import react_in_plane, react_in_space

EXACT = lm.GaussSeidel(tolerance=1e-12, max_iterations=20_000)


def work_of_contacts(sim: lm.Simulation) -> np.ndarray:
    """Normal and tangential work of each contact in the last step [J], (m, 2)."""
    problem = sim.last_step.problem
    work = 0.5 * problem.system.impulse * (problem.data.before + problem.data.after)
    return np.column_stack([work[:, 0], work[:, 1:].sum(axis=1)])


def crowd(seed: int, dimension: int, density: float, coefficients, friction: float, clusters: bool) -> lm.Scene:
    """Bodies of masses three decades apart that fly, spin and overlap anyhow, in three colours with a law for each pair."""
    rng = np.random.default_rng(seed)
    scene = lm.Scene(dimension=dimension, gravity=(0.0, -9.81) if dimension == 2 else (0.0, 0.0, -9.81))
    count, radius = 14, 0.1
    size = 2.0 * radius * count ** (1.0 / dimension) / density
    for i in range(count):
        place, color = rng.uniform(0.0, size, dimension), "AB"[i % 2]
        mass, velocity = 10.0 ** rng.uniform(-1.5, 1.5), rng.normal(size=dimension)
        if dimension == 3:
            spin = 10.0 * rng.normal(size=3)
            scene.add(lm.sphere(radius=radius, position=place, mass=mass, velocity=velocity, spin=spin, color=color))
        elif clusters:
            two = [(lm.DiskContactor(0.5 * radius), (s * radius, 0.0)) for s in (-1.0, 1.0)]
            given = {"rotation": rng.uniform(0.0, 6.0), "velocity": velocity, "spin": 10.0 * rng.normal(), "color": color}
            scene.add(lm.RigidBody(two, mass=mass, inertia=0.4 * mass * radius**2, position=place, **given))
        else:
            spin = 10.0 * rng.normal()
            scene.add(lm.disk(radius=radius, position=place, mass=mass, velocity=velocity, spin=spin, color=color))
    floor = {2: {"point": (0.0, 0.1), "normal": (0.0, 1.0)}, 3: {"point": (0.0, 0.0, 0.1), "normal": (0.0, 0.0, 1.0)}}
    scene.add(lm.wall(**floor[dimension]))
    pairs = ("A", "A"), ("B", "B"), ("A", "B"), ("A", "WALL"), ("B", "WALL")
    for (one, other), e in zip(pairs, coefficients, strict=True):
        scene.see(one, other, lm.Restitution(restitution=e, friction=friction))
    return scene


@given(
    seed=st.integers(0, 10_000),
    dimension=st.sampled_from((2, 3)),
    density=st.sampled_from((0.7, 1.0, 1.5)),
    coefficients=st.tuples(*[st.sampled_from((0.0, 0.5, 0.9, 1.0))] * 5),
    friction=st.sampled_from((0.0, 0.3, 1.0)),
    clusters=st.booleans(),
    time_step=st.sampled_from((1e-6, 1e-4, 1e-3)),
)
def test_no_contact_makes_energy(seed, dimension, density, coefficients, friction, clusters, time_step):
    """Contact by contact: ``r_n (u_n^- + u_n^+) <= 0`` and ``r_t . (u_t^- + u_t^+) <= 0``, in each of three steps, with
    loads and with coefficients side by side. What the solver leaves of a law, tolerance 1e-12 of some 10 m/s, and the
    rounding of 1e4 sweeps, is 1e-9 of the kinetic energy at most."""
    scene = crowd(seed, dimension, density, coefficients, friction, clusters)
    sim = lm.Simulation(scene, time_step=time_step, solver=EXACT, overlap="ignore", on_unconverged="ignore")
    for _ in range(3):
        before = sim.energy.kinetic
        sim.step()
        if sim.report.solved:
            assert work_of_contacts(sim).max(initial=0.0) <= 1e-9 * before


def corner(seed: int, decades: float) -> lm.Simulation:
    """Three spinning disks that overlap by a hair in a corner, of masses over ``decades``."""
    rng, radius = np.random.default_rng(seed), 0.1
    near = radius - 1e-6
    third = (2.0 * near, (1.0 + math.sqrt(3.0)) * near) if seed % 2 == 0 else (near, 3.0 * near)
    scene = lm.Scene(dimension=2)
    for place in ((near, near), (3.0 * near, near), third):
        mass, velocity, spin = 10.0 ** rng.uniform(-0.5 * decades, 0.5 * decades), rng.normal(size=2), 10.0 * rng.normal()
        scene.add(lm.disk(radius=radius, position=place, mass=mass, velocity=velocity, spin=spin))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.add(lm.wall(point=(0, 0), normal=(1, 0)))
    law = lm.Restitution(restitution=rng.uniform(0.0, 1.0), friction=10.0 ** rng.uniform(-1.0, math.log10(3.0)))
    scene.see("GRAIN", "GRAIN", law)
    scene.see("GRAIN", "WALL", law)
    solver = lm.Auto(tolerance=1e-9)
    return lm.Simulation(scene, time_step=1e-6, overlap="ignore", on_unconverged="ignore", solver=solver)


@pytest.mark.default_parameters("273-6.0", "285-6.0", "647-0.0", "852-0.0")
@pytest.mark.parametrize(
    ("seed", "decades"),
    [
        *((seed, 6.0) for seed in (6, 93, 132, 167, 171, 178, 210, 273, 285, 287, 297, *range(1000, 1100))),
        *((seed, 0.0) for seed in (647, 852, *range(1000, 1100))),
    ],
)
def test_slips_that_turn_round_at_several_contacts_are_found(seed, decades):
    """Each of the first eleven and two shocks has one solution (found by trying all 6^6 statuses). Sweeps go in circles
    about it, and Newton steps with friction at the end 0 of S alone did not find it."""
    sim = corner(seed, decades)
    before = sim.energy.kinetic
    sim.step()
    assert sim.report.solved
    assert sim.energy.kinetic <= before * (1.0 + 1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_newton_steps_resist_what_the_law_resists(dimension):
    """Coulomb's law with the coefficient and slip of ``resisted`` has the impulse of ``react``, but in space beside S."""
    rng, seen = np.random.default_rng(0), [0, 0, 0]
    react = react_in_plane if dimension == 2 else react_in_space
    for _ in range(400):
        a, slip, (w, friction) = rng.normal(size=dimension), rng.normal(size=2), np.exp(rng.normal(size=2))
        a[0], slip[dimension - 1 :] = abs(a[0]), 0.0
        prepared = (0.0, friction, *slip)
        (mu,), across = lm.Restitution.resisted(np.array(prepared)[:, None], a[:, None], np.array([w]))
        W, u = np.diag(np.full(dimension, w)).tolist(), (-w * a).tolist()
        moved = [u[0], *(u[1:] + across[:, 0])]
        case = 2 if mu == 0.0 else int(across.any())
        seen[case] += 1
        if dimension == 2 or case < 2:
            assert lm.Restitution.react(W, u, prepared) == pytest.approx(react(W, *moved, mu), abs=1e-12)
    assert min(seen) > 30


@pytest.mark.parametrize("time_step", [1e-3, 1e-4, 1e-6])
@pytest.mark.parametrize("e", [0.0, 0.5, 0.9, 1.0])
def test_an_opening_contact_takes_no_part(e, time_step):
    """Three equal disks in a row, overlapping by a hair, at 1, 0 and 0.5 m/s: the first two collide, and the third parts
    from the second at 0.5 m/s, which is as fast as the second becomes if e = 0 and slower if e is more.

    The pair alone: v_1 = (1 - e)/2, v_2 = (1 + e)/2. With e <= 0.9 the third contact approaches then by less than 0.5 m/s,
    which is what it was opened by: no impulse. (With e min(u-, 0) it pushed, and the energy grew by 13 % at e = 1.)
    """
    scene = lm.Scene(dimension=2)
    for x, v in ((0.0, 1.0), (0.199, 0.0), (0.398, 0.5)):
        scene.add(lm.disk(radius=0.1, position=(x, 0.0), mass=1.0, velocity=(v, 0.0)))
    scene.see("GRAIN", "GRAIN", lm.Restitution(restitution=e))
    sim = lm.Simulation(scene, time_step=time_step, solver=EXACT)
    sim.step()
    assert sim.velocities[:, 0] == pytest.approx([0.5 * (1.0 - e), 0.5 * (1.0 + e), 0.5], abs=1e-12)


@pytest.mark.parametrize(
    "solver", [lm.Auto(tolerance=1e-4), EXACT, lm.Newton(tolerance=1e-10)], ids=["Auto", "GaussSeidel", "Newton"]
)
def test_a_row_of_disks_that_touch_keeps_its_energy(solver):
    """Newton's cradle as laid, gaps zero to round-off, e = 1, 100 steps: at a tolerance of 1e-4 the energy is kept to
    1e-3. (It grew from 0.4999 to 0.616 J in one step.)"""
    scene = lm.Scene(dimension=2)
    for x, v in [(-0.21, 1.0), *((0.2 * i, 0.0) for i in range(5))]:
        scene.add(lm.disk(radius=0.1, position=(x, 0.0), mass=1.0, velocity=(v, 0.0)))
    scene.see("GRAIN", "GRAIN", lm.Restitution(restitution=1.0))
    sim = lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore")
    for _ in range(100):
        sim.step()
        assert sim.energy.kinetic == pytest.approx(0.5, abs=5e-4)


def shock_of_a_rod(e, friction, angle, slip, offset=0.0):
    """Kinetic energy after the shock of a slanting rod with a floor over that before; a floor that moves by ``offset``."""
    half, radius = 0.1, 0.005
    inertia = (2.0 * half) ** 2 / 12.0
    ends = [(lm.DiskContactor(radius), (s * half, 0.0)) for s in (-1.0, 1.0)]
    scene = lm.Scene(dimension=2)
    place = (0.0, half * math.sin(angle) + radius - 1e-9)
    rod = lm.RigidBody(ends, mass=1.0, inertia=inertia, position=place, rotation=angle, velocity=(slip, -1.0), color="ROD")
    scene.add(rod)
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("ROD", "WALL", lm.Restitution(restitution=e, friction=friction))
    sim = lm.Simulation(scene, time_step=1e-7)
    before = sim.energy.kinetic
    sim.step()
    return sim.energy.kinetic / before


@pytest.mark.default_parameters(e=(0.8, 1.0), friction=(0.3, 1.0))
@pytest.mark.parametrize("e", [0.0, 0.5, 0.8, 0.9, 1.0])
@pytest.mark.parametrize("friction", [0.1, 0.3, 0.5, 1.0, 2.0])
def test_friction_off_the_centre_gains_nothing(e, friction):
    """Kane and Levinson's example: with Newton's and Coulomb's laws a slanting rod gained up to 19 %."""
    for degrees in (10, 30, 40, 60, 80):
        for slip in (-3.0, -0.5, 0.5, 3.0):
            assert shock_of_a_rod(e, friction, math.radians(degrees), slip) <= 1.0 + 1e-12


@pytest.mark.long
@pytest.mark.parametrize("time_step", [4e-3, 1e-3, 2.5e-4])
@pytest.mark.parametrize("e", [0.0, 0.5, 0.9])
def test_a_ball_comes_to_rest_and_stays(e, time_step):
    """A ball that slides and bounces on a floor ends at rest on it, for good: it bears m g, to the last digits, and stays
    in its place to the rounding of a position. Bounces of 0.1 m/s take 2 v/(g (1 - e)) = 0.2 s at e = 0.9, 800 steps at
    most of the 2000; then the closed contact loses a factor e at least every other step."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    ball = scene.add(lm.disk(radius=0.1, position=(0.0, 0.1), mass=2.0, velocity=(0.3, -0.1)))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Restitution(restitution=e, friction=0.4))
    ball.fix("spin")
    sim = lm.Simulation(scene, time_step=time_step, solver=EXACT, on_unconverged="ignore").run(steps=2000)
    place = ball.position.copy()
    sim.run(steps=200)
    assert ball.position == pytest.approx(place, abs=1e-12)
    assert place[1] == pytest.approx(0.1, abs=0.1 * time_step)
    assert sim.interactions.force[0] == pytest.approx([2.0 * 9.81, 0.0], rel=1e-6, abs=1e-6)


def test_a_block_wedged_between_two_laws_has_a_solution():
    """A disk that leaves one fixed wall for another, both closed, with different coefficients: at most its speed comes
    back.

    With e min(u-, 0) for opening contacts one wall asked for u+ >= e v and the other for u+ <= 0, which impulses without
    bound could not do."""
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0, velocity=(1.0, 0.0)))
    scene.add(lm.wall(point=(-0.0999, 0), normal=(1, 0), color="LEFT"))
    scene.add(lm.wall(point=(0.0999, 0), normal=(-1, 0), color="RIGHT"))
    scene.see("GRAIN", "LEFT", lm.Restitution(restitution=0.9))
    scene.see("GRAIN", "RIGHT", lm.Restitution(restitution=0.5))
    sim = lm.Simulation(scene, time_step=1e-6, solver=EXACT, overlap="ignore")
    speeds = [sim.run(steps=1) and abs(sim.velocities[0, 0]) for _ in range(10)]
    assert sim.unconverged_steps == 0
    assert speeds == pytest.approx(np.cumprod([0.5, 0.9] * 5), rel=1e-6)


class Hasty(lm.Restitution):
    """Newton's law with min(u-, 0), which says that it dissipates."""

    NAME = "hasty-restitution"
    PREPARED = ("bias", "friction")
    KEEPS_GAP = False
    resisted = None

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        friction, e = parameters
        return (math.inf if gap > 0.0 else e * min(velocity[0], 0.0), friction)

    @staticmethod
    def react(W, u, prepared):
        return (max(0.0, -(u[0] + prepared[0]) / W[0][0]),)


@pytest.mark.parametrize(("e", "told"), [(1.0, True), (0.9, True), (0.5, False)])
def test_the_watch_tells_a_law_that_makes_some_energy(e, told):
    """13 and 3 % of the energy are told, with the name of the law; at e = 0.5 the three disks lose energy."""
    scene = lm.Scene(dimension=2)
    for x, v in ((0.0, 1.0), (0.199, 0.0), (0.398, 0.5)):
        scene.add(lm.disk(radius=0.1, position=(x, 0.0), mass=1.0, velocity=(v, 0.0)))
    scene.see("GRAIN", "GRAIN", Hasty(restitution=e))
    sim = lm.Simulation(scene, time_step=1e-4, solver=EXACT)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        sim.step()
    assert any("'hasty-restitution' have made" in str(warning.message) for warning in caught) == told


def test_the_watch_tells_a_law_whose_energy_another_takes():
    """The three disks again, while a fourth falls on sand far away and loses more than they make."""
    scene = lm.Scene(dimension=2)
    for x, v in ((0.0, 1.0), (0.199, 0.0), (0.398, 0.5)):
        scene.add(lm.disk(radius=0.1, position=(x, 0.0), mass=1.0, velocity=(v, 0.0)))
    scene.add(lm.disk(radius=0.1, position=(5.0, 0.0995), mass=1.0, velocity=(0.0, -1.0), color="OTHER"))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "GRAIN", Hasty(restitution=1.0))
    scene.see("OTHER", "WALL", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-4, solver=EXACT)
    with pytest.warns(RuntimeWarning, match="'hasty-restitution' have made"):
        sim.step()
    assert sim.energy.made == 0.0
