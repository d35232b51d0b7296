"""Rolling and torsion friction of spheres against analytic answers, the plane, conservation laws and other solvers.

With the inertia ``I = k m R^2``, k = 2/5 of a sphere, the formulas are those of a disk (``test_rolling_friction``). Torsion
about the normal of a plane obeys ``k m R^2 dw/dt = -mu_z R N``: the spin falls by ``mu_z g/(k R)`` a second.
"""

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.contact.slabs import partition_from

pytestmark = pytest.mark.long  # half a minute to compile; the form of its rows and its law are in the default suite

G, RADIUS, K = 9.81, 0.1, 0.4
SAND = lm.Material("sand", density=2600.0)


def rolling(friction=0.5, rolling_friction=0.1, torsion_friction=None):
    return lm.RollingCoulomb(friction=friction, rolling_friction=rolling_friction, torsion_friction=torsion_friction)


def on_a_plane(law, *, slope=0.0, velocity=(0.0, 0.0), torsion=0.0, time_step=1e-3, turn=0.0, solver=None):
    """A sphere on an incline, rolling without slip; ``torsion``: its spin about the normal. The frame is turned about the
    normal by ``turn``, so that the motion is along no axis of the scene."""
    c, s = np.cos(turn), np.sin(turn)
    (x, y), down = velocity, G * np.sin(slope)
    scene = lm.Scene(dimension=3, gravity=(down * c, down * s, -G * np.cos(slope)))
    start = (c * x - s * y, s * x + c * y, 0.0)
    spin = (-start[1] / RADIUS, start[0] / RADIUS, torsion)
    scene.add(lm.sphere(radius=RADIUS, position=(0, 0, RADIUS), mass=2.0, velocity=start, spin=spin))
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    scene.see("GRAIN", "WALL", law)
    return lm.Simulation(scene, time_step=time_step, solver=solver or lm.GaussSeidel(tolerance=1e-10))


@pytest.mark.default_parameters(time_step=[8e-3], rolling_friction=[0.3])
@pytest.mark.parametrize("time_step", [8e-3, 4e-3, 2e-3, 1e-3])
@pytest.mark.parametrize("rolling_friction", [0.05, 0.3])
def test_a_sphere_rolls_to_rest(rolling_friction, time_step):
    """After v^2/(2 a) with a = mu_r g/(1 + k), exactly but for the last step, which it ends at rest: less than a h^2/2."""
    speed, a = 0.6, rolling_friction * G / (1 + K)
    sim = on_a_plane(rolling(rolling_friction=rolling_friction), velocity=(speed, 0.0), turn=0.7, time_step=time_step)
    sim.run(steps=int(speed / a / time_step) + 3)
    x, y = sim.positions[0, :2]
    assert np.hypot(x, y) == pytest.approx(speed**2 / (2 * a), abs=0.5 * a * time_step**2 + 1e-12)
    assert y == pytest.approx(np.tan(0.7) * x, abs=1e-12)
    assert np.abs(sim.velocities[0]).max() < 1e-12
    assert np.abs(sim.spins[0]).max() < 1e-11
    energy = 0.5 * (1 + K) * 2.0 * speed**2
    assert sim.energy.total_interactions["rolling-coulomb"] == pytest.approx(-energy, rel=1e-10)


@pytest.mark.default_parameters(rolling_friction=(0.1,))
@pytest.mark.parametrize("rolling_friction", [0.01, 0.1, 0.4])
def test_a_sphere_begins_to_roll_where_the_tangent_of_the_slope_is_the_rolling_friction(rolling_friction):
    law = rolling(friction=0.6, rolling_friction=rolling_friction)
    below = on_a_plane(law, slope=np.arctan(0.999 * rolling_friction), turn=0.4).run(steps=100)
    assert np.abs(below.velocities[0]).max() < 1e-12
    slope = np.arctan(1.1 * rolling_friction)
    above = on_a_plane(law, slope=slope, turn=0.4).run(steps=100)
    expected = 0.1 * G * (np.sin(slope) - rolling_friction * np.cos(slope)) / (1 + K)
    assert np.hypot(*above.velocities[0, :2]) == pytest.approx(expected, abs=1e-11)
    assert np.hypot(*above.spins[0, :2]) == pytest.approx(expected / RADIUS, abs=1e-10)


def test_a_sphere_slides_and_holds_or_slides_and_rolls():
    """Where it slides, g (sin(a) - mu cos(a)); the moment that turns it is what mu leaves, (mu - mu_r) N R, or none."""
    for slope, mu, mu_r in ((0.3, 0.1, 0.2), (0.9, 0.2, 0.05)):
        sim = on_a_plane(rolling(mu, mu_r), slope=slope, turn=1.1).run(steps=100)
        speed, spin = np.hypot(*sim.velocities[0, :2]), np.hypot(*sim.spins[0, :2])
        assert speed == pytest.approx(0.1 * G * (np.sin(slope) - mu * np.cos(slope)), abs=1e-11)
        assert spin * RADIUS == pytest.approx(0.1 * max(mu - mu_r, 0.0) / K * G * np.cos(slope), abs=1e-11)


@pytest.mark.default_parameters(time_step=[4e-3])
@pytest.mark.parametrize("time_step", [4e-3, 1e-3])
@pytest.mark.parametrize("torsion_friction", [0.02, None])
def test_a_spinning_sphere_comes_to_rest(torsion_friction, time_step):
    """After the time w k R/(mu_z g); by default mu_z = 2/3 mu mu_r, the moment of sliding on the face that mu_r stands for.
    It rolls meanwhile, and neither sees the other."""
    law = rolling(0.6, 0.1, torsion_friction)
    mu_z, w, speed = torsion_friction or 2 / 3 * 0.6 * 0.1, 3.0, 1.0
    time = w * K * RADIUS / (mu_z * G)
    sim = on_a_plane(law, velocity=(speed, 0.0), torsion=w, turn=0.3, time_step=time_step)
    steps = int(time / time_step)
    sim.run(steps=steps)
    assert sim.spins[0, 2] == pytest.approx(w - mu_z * G / (K * RADIUS) * steps * time_step, abs=1e-11)
    moment = sim.interactions.moment[0] / time_step
    weight = 2.0 * G
    assert moment[0] == pytest.approx(-mu_z * RADIUS * weight, rel=1e-12)
    assert np.hypot(*moment[1:]) == pytest.approx(0.1 * RADIUS * weight, rel=1e-12)
    assert np.hypot(*sim.velocities[0, :2]) == pytest.approx(speed - 0.1 * G / (1 + K) * steps * time_step, abs=1e-11)
    sim.run(steps=2)
    assert abs(sim.spins[0, 2]) < 1e-11


def test_in_one_plane_it_is_the_law_of_2d():
    """Spheres thrown at each other in the plane z = 0, spinning about z, and disks with their masses and inertias: the same
    paths to the tolerance of steps."""
    law, found = rolling(0.5, 0.2), []
    for dimension in (2, 3):
        rng = np.random.default_rng(4)
        scene = lm.Scene(dimension=dimension, gravity=(0.0, -G, 0.0)[:dimension])
        for k in range(8):
            x, y = 0.24 * (k % 3) + 0.03 * rng.random(), 0.12 + 0.24 * (k // 3)
            (u, v), spin, radius = rng.normal(size=2), 20 * rng.normal(), rng.uniform(0.07, 0.11)
            given = {"radius": radius, "mass": 1.0 + k, "inertia": K * (1.0 + k) * radius**2}
            if dimension == 2:
                scene.add(lm.disk(position=(x, y), velocity=(u, v), spin=spin, **given))
            else:
                scene.add(lm.sphere(position=(x, y, 0), velocity=(u, v, 0), spin=(0, 0, spin), **given))
        scene.add(lm.wall(point=(0.0,) * dimension, normal=(0.0, 1.0, 0.0)[:dimension]))
        scene.see("GRAIN", "GRAIN", law)
        scene.see("GRAIN", "WALL", law)
        sim = lm.Simulation(scene, time_step=2e-3, solver=lm.Newton(tolerance=1e-12)).run(steps=80)
        found.append((sim.positions[:, :2], sim.spins if dimension == 2 else sim.spins[:, 2], sim.interactions))
    (x, w, flat), (x_3d, w_3d, net) = found
    assert len(net) > 4
    assert np.abs(flat.moment).max() > 1e-3
    assert np.abs(x - x_3d).max() < 1e-9
    assert np.abs(w - w_3d).max() < 1e-8
    assert np.abs(net.moment[:, 0]).max() < 1e-15
    assert np.sort(np.linalg.norm(net.moment, axis=1)) == pytest.approx(np.sort(np.abs(flat.moment[:, 0])), abs=1e-9)


def heap(law, *, solver=None, seed=0, gravity=G, partner=None, ratio=1.0, time_step=2e-3, held=False, threads=1):
    """Spheres of several sizes in a tube, thrown down, spinning; every third has ``ratio`` times the density."""
    rng = np.random.default_rng(seed)
    scene = lm.Scene(dimension=3, gravity=(0.0, 0.0, -gravity))
    light, heavy = SAND, lm.Material("heavy", density=ratio * SAND.density)
    for k in range(18):
        place = 0.26 * (k % 3) + 0.02 * rng.random(), 0.26 * (k // 3 % 3) + 0.02 * rng.random(), 0.13 + 0.25 * (k // 9)
        start = {"velocity": rng.normal(size=3) - (0, 0, 1), "spin": 20 * rng.normal(size=3)}
        radius = rng.uniform(0.06, 0.115)
        scene.add(lm.sphere(radius=radius, position=place, material=light if k % 3 else heavy, **start))
    if held:
        scene.bodies[3].impose_velocity(x=0.0, spin_y=0.0)
        scene.bodies[8].impose_velocity(spin_x=1.0)
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    scene.add(lm.cylinder_wall(point=(0.27, 0.27, 0), axis=(0, 0, 1), radius=0.5))
    scene.see("GRAIN", "GRAIN", law)
    scene.see("GRAIN", "WALL", partner or law)
    solver = solver or lm.Newton(tolerance=1e-9)
    return lm.Simulation(scene, time_step=time_step, solver=solver, threads=threads)


@pytest.mark.default_parameters("1.0-Signorini()")
@pytest.mark.parametrize("partner", [None, lm.Coulomb(friction=0.3), lm.Signorini()], ids=repr)
@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e6])
def test_energy_closes_and_friction_takes_it(partner, ratio):
    """Over four octaves of time step. Without loads the work of all contacts is ``r . u+ - r . W r/2`` <= 0, to the
    solver's 1e-9 of energies of about ``ratio`` times 1e3 J; but on the wall of the tube it has ``r (e' - e)/(2 h)``, the
    change of what turning closes: a part (h v/a)^2 of some 1e-4 of a mJ. The identity of energies holds to round-off of
    them."""
    for time_step in (4e-3, 2e-3, 1e-3, 5e-4):
        sim = heap(rolling(0.5, 0.3), partner=partner, gravity=0.0, ratio=ratio, time_step=time_step)
        turned, start = 0.0, sim.energy.kinetic
        for _ in range(int(0.16 / time_step)):
            sim.step()
            assert abs(sim.energy.defect) < 1e-14 * start
            assert sum(sim.energy.interactions.values()) <= 1e-7 * start
            net = sim.interactions
            rolls = net.law == "rolling-coulomb"
            turned = max(turned, np.abs(net.moment[rolls]).max(initial=0.0))
            assert not net.moment[~rolls].any()
        assert sim.unconverged_steps == 0
        assert turned > 0.0


def test_moments_keep_angular_momentum():
    """Two spheres that meet off their line, spinning: momentum, and spin with orbit, stay to round-off; where friction of
    all three kinds is large their spins become one."""
    scene = lm.Scene(dimension=3)
    start = ((0.1, -0.11, 1.0, (3.0, 1.0, -2.0)), (0.2, 0.21, -1.0, (-5.0, 2.0, 4.0)))
    for radius, x, v, spin in start:
        scene.add(lm.sphere(radius=radius, position=(x, 0.3 * x, 0), material=SAND, velocity=(v, 0.01, 0.1), spin=spin))
    scene.see("GRAIN", "GRAIN", rolling(5.0, 50.0, 50.0))
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12))
    radius = np.array([0.1, 0.2])
    mass = SAND.density * 4 / 3 * np.pi * radius**3
    inertia = (K * mass * radius**2)[:, None]

    def momenta():
        orbit = np.cross(sim.positions, mass[:, None] * sim.velocities)
        return np.concatenate([mass @ sim.velocities, (orbit + inertia * sim.spins).sum(axis=0)])

    before = momenta()
    sim.run(steps=60)
    assert np.ptp(sim.spins, axis=0).max() < 1e-11
    assert momenta() == pytest.approx(before, abs=1e-12 * np.abs(before).max())


@pytest.mark.parametrize("held", [False, True])
def test_solvers_agree(held):
    """Also where bodies are held in some components, so that local blocks are full. Steps to a residual of 1e-8 or less of
    speeds of 3 m/s; the paths part by shocks no more than that times 60 steps."""
    one = heap(rolling(0.5, 0.2), held=held).run(steps=60)
    for solver in (lm.AcceleratedGaussSeidel(tolerance=1e-8), lm.Auto(tolerance=1e-8)):
        sim = heap(rolling(0.5, 0.2), held=held, solver=solver)
        sim.on_unconverged = "ignore"  # sweeps stagnate at residuals of some 1e-7 where a sphere is wedged
        other = sim.run(steps=60)
        assert np.abs(one.velocities - other.velocities).max() < 1e-5
        assert np.abs(one.spins - other.spins).max() < 1e-4
    assert one.unconverged_steps == 0
    assert abs(one.energy.defect) < 1e-12
    problem, impulses = one.problem(), one.last_step.problem.system.impulse
    assert problem.width == 6
    assert lm.residual(problem, impulses) < 2e-9  # the assembled W is that of the kernels
    for solver in (lm.Auto(tolerance=1e-9), lm.Newton(tolerance=1e-10)):
        solution = lm.solve(problem, solver=solver, guess=0.0 * impulses)
        assert solution.status == "converged"  # from nothing it may be another solution
        assert lm.residual(problem, solution.impulses) <= 1.1 * solver.tolerance


def test_a_full_block_is_solved_at_once():
    """One sphere that moves and turns about some axes only, on an incline beside all axes: the first sweep is the solution,
    to round-off, whether it sticks, slides, holds, rolls or twists. Held along x it
    jams where friction is so large that ``mu |W_nt| >= W_nn``: there is no solution then, and it is left out."""
    seen = set()
    for seed in range(40):
        rng = np.random.default_rng(seed)
        scene = lm.Scene(dimension=3, gravity=3.0 * rng.normal(size=3))
        normal = rng.normal(size=3)
        normal /= np.linalg.norm(normal)
        start = {"velocity": -0.5 * normal + 0.2 * rng.normal(size=3), "spin": 3 * rng.normal(size=3)}
        scene.add(lm.sphere(radius=RADIUS, position=RADIUS * normal, mass=2.0, **start))
        scene.bodies[0].impose_velocity(**({"x": 0.1}, {"spin_y": -2.0}, {"spin_y": 1.0, "spin_z": 0.5})[seed % 3])
        scene.add(lm.wall(point=(0, 0, 0), normal=normal))
        mu, mu_r, mu_z = 10.0 ** rng.uniform(-2, 1, size=3)
        scene.see("GRAIN", "WALL", rolling(mu, mu_r, mu_z))
        if seed % 3 == 0 and mu * abs(normal[0]) >= np.sqrt(1.0 - normal[0] ** 2):
            continue
        sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12)).run(steps=1)
        if not sim.interactions.impulse[:, 0].any():
            continue
        assert sim.report.status in ("converged", "round-off")
        assert sim.report.iterations <= 1
        (r,), (m,) = sim.interactions.impulse, sim.interactions.moment / RADIUS
        parts = ((np.hypot(*r[1:]), mu), (np.hypot(*m[1:]), mu_r), (abs(m[0]), mu_z))
        assert all(size <= share * r[0] * (1 + 1e-13) for size, share in parts)
        seen.add(tuple(bool(size < share * r[0] * (1 - 1e-9)) for size, share in parts))
    assert len(seen) >= 6


def test_without_rolling_friction_it_is_coulomb():
    """mu_r = mu_z = 0: the same steps as Coulomb's law, to the solver's tolerance."""
    one, other = heap(rolling(0.5, 0.0)), heap(lm.Coulomb(friction=0.5))
    one.run(steps=60)
    other.run(steps=60)
    assert np.abs(one.positions - other.positions).max() < 1e-8
    assert not one.interactions.moment.any()
    assert other.interactions.moment.shape[1] == 0
    assert other.problem().width == 3


def test_a_run_file_keeps_the_moments(tmp_path):
    """And a run that goes on from it has the bits of the whole run."""
    sim = heap(rolling(0.5, 0.2)).run(steps=70, record=str(tmp_path / "run.h5"), every=10)
    with lm.io.open_run(str(tmp_path / "run.h5")) as run:
        moment = run.interactions(-1).moment
    assert moment.shape[1] == 3
    assert np.array_equal(moment, sim.interactions.moment)
    again = lm.resume(str(tmp_path / "run.h5")).run(steps=10)
    whole = heap(rolling(0.5, 0.2)).run(steps=80)
    assert np.array_equal(again.velocities, whole.velocities)
    assert np.array_equal(again.interactions.moment, whole.interactions.moment)


def test_slabs_and_threads_roll_alike():
    """As in the plane: the same bits with any number of threads."""
    given = {"solver": lm.GaussSeidel(tolerance=1e-7)}
    plain = heap(rolling(0.5, 0.2), **given).run(steps=40)
    with partition_from(10):
        one, two = (heap(rolling(0.5, 0.2), threads=n, **given).run(steps=40) for n in (1, 2))
    assert len(one.last_step.problem.groups.phase) > 2
    assert np.array_equal(one.velocities, two.velocities)
    assert np.array_equal(one.interactions.moment, two.interactions.moment)
    assert np.abs(one.velocities - plain.velocities).max() < 1e-3
    assert abs(one.energy.defect) < 1e-12


def test_a_problem_that_rolls_is_not_written_as_one_that_does_not(tmp_path):
    problem = heap(rolling()).run(steps=60).problem()
    with pytest.raises(ValueError, match="A problem with rolling friction cannot be written: FCLIB's layout"):
        lm.io.fclib.write(problem, tmp_path / "problem.h5")
    with pytest.raises(ValueError, match="this problem has rolling components: say 'natural'"):
        lm.residual(problem, problem.guess, measure="fclib")
    assert lm.residual(problem, problem.guess, measure="slip") >= 0.0
