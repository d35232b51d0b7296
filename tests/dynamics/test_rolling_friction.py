"""Rolling friction against analytic answers, conservation laws and other solvers.

With the inertia ``I = k m R^2`` (k = 1/2 of a disk) and the moment ``|m| <= mu_r R N``, a body that rolls on a plane
without slipping obeys, about its contact point, ``(1 + k) m R^2 dw/dt = -mu_r R N``: it slows down by ``mu_r g/(1 + k)``.
"""

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.contact.slabs import partition_from

G, RADIUS = 9.81, 0.1
SAND = lm.Material("sand", density=2600.0)


def on_a_plane(law, *, slope=0.0, velocity=0.0, time_step=1e-3, solver=None, **options):
    """A disk on an incline, rolling along it without slip."""
    scene = lm.Scene(dimension=2, gravity=(G * np.sin(slope), -G * np.cos(slope)))
    spin = -velocity / RADIUS
    scene.add(lm.disk(radius=RADIUS, position=(0, RADIUS), material=SAND, velocity=(velocity, 0), spin=spin))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", law)
    return lm.Simulation(scene, time_step=time_step, solver=solver or lm.GaussSeidel(tolerance=1e-10), **options)


def rolling(friction=0.5, rolling_friction=0.1):
    return lm.RollingCoulomb(friction=friction, rolling_friction=rolling_friction)


@pytest.mark.default_parameters("0.05-0.004")
@pytest.mark.parametrize("time_step", [4e-3, 1e-3])
@pytest.mark.parametrize("rolling_friction", [0.05, 0.1, 0.3])
def test_a_disk_rolls_to_rest(rolling_friction, time_step):
    """After v^2/(2 a) with a = mu_r g/(1 + 1/2). Positions are exact, as the force is constant and theta = 1/2, but for the
    last step, in which it stops from a velocity v <= a h: that is off by less than h v/2."""
    speed, a = 0.6, rolling_friction * G / 1.5
    sim = on_a_plane(rolling(rolling_friction=rolling_friction), velocity=speed, time_step=time_step)
    sim.run(steps=int(speed / a / time_step) + 3)
    assert sim.positions[0, 0] == pytest.approx(speed**2 / (2 * a), abs=0.5 * a * time_step**2 + 1e-12)
    assert abs(sim.velocities[0, 0]) < 1e-12
    assert abs(sim.spins[0]) < 1e-11
    # all its energy went into the contact
    energy = 0.75 * SAND.density * np.pi * RADIUS**2 * speed**2
    assert sim.energy.total_interactions["rolling-coulomb"] == pytest.approx(-energy, rel=1e-10)


@pytest.mark.parametrize("rolling_friction", [0.01, 0.1, 0.4])
def test_a_disk_begins_to_roll_where_the_tangent_of_the_slope_is_the_rolling_friction(rolling_friction):
    """About the contact point gravity turns by m g R sin(a), and the moment resists up to mu_r R m g cos(a). Beyond, it
    rolls with ``g (sin(a) - mu_r cos(a))/(1 + k)``."""
    law = rolling(friction=0.6, rolling_friction=rolling_friction)
    below = on_a_plane(law, slope=np.arctan(0.999 * rolling_friction)).run(steps=100)
    assert np.abs(below.velocities[0]).max() < 1e-12
    slope = np.arctan(1.1 * rolling_friction)
    above = on_a_plane(law, slope=slope).run(steps=100)
    expected = 0.1 * G * (np.sin(slope) - rolling_friction * np.cos(slope)) / 1.5
    assert above.velocities[0, 0] == pytest.approx(expected, abs=1e-11)
    assert above.spins[0] == pytest.approx(-expected / RADIUS, abs=1e-10)


def test_a_disk_slides_without_turning_where_it_holds():
    """mu < tan(a), and the moment mu N R of friction is below mu_r N R: g (sin(a) - mu cos(a)), no spin."""
    slope = 0.3
    sim = on_a_plane(rolling(friction=0.1, rolling_friction=0.2), slope=slope).run(steps=100)
    assert sim.velocities[0, 0] == pytest.approx(0.1 * G * (np.sin(slope) - 0.1 * np.cos(slope)), abs=1e-11)
    assert abs(sim.spins[0]) < 1e-12


def test_a_disk_slides_and_rolls():
    """mu_r < mu < what sticking takes: it slides, and the moment that turns it is what mu leaves, (mu - mu_r) N R."""
    slope, mu, mu_r = 0.8, 0.2, 0.05
    sim = on_a_plane(rolling(mu, mu_r), slope=slope).run(steps=100)
    assert sim.velocities[0, 0] == pytest.approx(0.1 * G * (np.sin(slope) - mu * np.cos(slope)), abs=1e-11)
    assert -sim.spins[0] * RADIUS == pytest.approx(0.1 * 2 * (mu - mu_r) * G * np.cos(slope), abs=1e-11)


def heap(law, *, solver=None, seed=0, partner=None, gravity=G, ratio=1.0, time_step=2e-3):
    """Disks of several sizes that fall onto a plane and onto each other, spinning, with gravity; every third has ``ratio``
    times the density."""
    heavy = lm.Material("heavy", density=ratio * SAND.density)
    rng = np.random.default_rng(seed)
    scene = lm.Scene(dimension=2, gravity=(0.0, -gravity))
    for k in range(12):
        place = 0.26 * (k % 4) + 0.02 * rng.random(), 0.13 + 0.25 * (k // 4)
        velocity, spin = tuple(rng.normal(size=2)), 20 * rng.normal()
        radius = rng.uniform(0.06, 0.115)
        material = SAND if k % 3 else heavy
        scene.add(lm.disk(radius=radius, position=place, material=material, velocity=velocity, spin=spin))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "GRAIN", law)
    scene.see("GRAIN", "WALL", partner or law)
    return lm.Simulation(scene, time_step=time_step, solver=solver or lm.GaussSeidel(tolerance=1e-7))


@pytest.mark.parametrize("partner", [None, lm.Coulomb(friction=0.3), lm.Signorini()], ids=repr)
def test_energy_closes_and_rolling_friction_takes_it(partner):
    """The identity of energies holds to round-off of energies of about 1e3 J, with laws of two and of one component beside
    it; and without loads, which contacts of a step may give back, their work is never above zero, to the solver's 1e-7."""
    sim = heap(rolling(0.5, 0.3), partner=partner, gravity=0.0)
    turned = 0.0
    for _ in range(150):
        sim.step()
        assert abs(sim.energy.defect) < 1e-11
        assert sum(sim.energy.interactions.values()) <= 1e-7
        net = sim.interactions
        rolls = net.law == "rolling-coulomb"
        turned = max(turned, np.abs(net.moment[rolls]).max(initial=0.0))
        assert not net.moment[~rolls].any()
    assert turned > 0.0


def test_moments_keep_angular_momentum():
    """Two disks that meet turning alike: what one loses the other gains, spin and orbit together, and their spins are one
    where rolling friction is large."""
    scene = lm.Scene(dimension=2)
    bodies = [
        scene.add(lm.disk(radius=r, position=(x, 0.0), material=SAND, velocity=(v, 0.01), spin=w))
        for r, x, v, w in ((0.1, -0.11, 1.0, 3.0), (0.2, 0.21, -1.0, -5.0))
    ]
    scene.see("GRAIN", "GRAIN", rolling(1.0, 50.0))
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12))
    mass = np.array([SAND.density * np.pi * r**2 for r in (0.1, 0.2)])
    inertia = 0.5 * mass * np.array([0.1, 0.2]) ** 2

    def angular():
        x, v = sim.positions, sim.velocities
        return (mass * (x[:, 0] * v[:, 1] - x[:, 1] * v[:, 0]) + inertia * sim.spins).sum()

    before = angular()
    sim.run(steps=60)
    assert np.ptp(sim.spins) < 1e-12
    assert angular() == pytest.approx(before, abs=1e-13 * inertia.sum() * 5.0 / 1e-3)
    assert len(bodies) == 2


@pytest.mark.parametrize("solver", [lm.AcceleratedGaussSeidel(tolerance=1e-10), lm.Auto(tolerance=1e-8)], ids=repr)
def test_solvers_agree(solver):
    """Steps to a residual of 1e-8 or less of speeds of 1 m/s; the paths part by shocks no more than that times 60 steps."""
    one, other = heap(rolling(0.5, 0.2)), heap(rolling(0.5, 0.2), solver=solver)
    one.run(steps=60)
    other.run(steps=60)
    assert other.unconverged_steps == 0
    assert np.abs(one.velocities - other.velocities).max() < 1e-5
    assert np.abs(one.spins - other.spins).max() < 1e-4


def test_without_rolling_friction_it_is_coulomb():
    """mu_r = 0: the same steps as Coulomb's law, to the solver's tolerance."""
    one, other = heap(rolling(0.5, 0.0)), heap(lm.Coulomb(friction=0.5))
    one.run(steps=60)
    other.run(steps=60)
    assert np.abs(one.positions - other.positions).max() < 1e-8
    assert not one.interactions.moment.any()
    assert other.interactions.moment.shape[1] == 0


def test_a_run_file_keeps_the_moments(tmp_path):
    """And a run that goes on from it has the bits of the whole run."""
    sim = heap(rolling(0.5, 0.2)).run(steps=70, record=str(tmp_path / "run.h5"), every=10)
    with lm.io.open_run(str(tmp_path / "run.h5")) as run:
        assert np.array_equal(run.interactions(-1).moment, sim.interactions.moment)
    again = lm.resume(str(tmp_path / "run.h5")).run(steps=10)
    whole = heap(rolling(0.5, 0.2)).run(steps=80)
    assert np.array_equal(again.velocities, whole.velocities)
    assert np.array_equal(again.interactions.moment, whole.interactions.moment)


@pytest.mark.default_parameters(ratio=[1e6])
@pytest.mark.parametrize("ratio", [1.0, 1e3, 1e6])
def test_energy_is_never_made(ratio):
    """Over four octaves of time step and six decades of mass ratio, as in space (``test_rolling_in_space``)."""
    for time_step in (4e-3, 2e-3, 1e-3, 5e-4):
        sim = heap(rolling(0.5, 0.3), gravity=0.0, solver=lm.Newton(tolerance=1e-9), ratio=ratio, time_step=time_step)
        start = sim.energy.kinetic
        for _ in range(int(0.16 / time_step)):
            sim.step()
            assert abs(sim.energy.defect) < 1e-14 * start
            assert sum(sim.energy.interactions.values()) <= 1e-10 * start
        assert sim.unconverged_steps == 0
        assert sim.energy.kinetic < 0.995 * start


@pytest.mark.default_parameters("Coulomb(friction=0.3)")
@pytest.mark.parametrize("partner", [None, lm.Coulomb(friction=0.3), lm.Signorini()], ids=repr)
def test_a_step_that_rolls_is_a_problem(partner):
    """Its W and q are those of the kernels, and it can be solved alone, by sweeps and by Newton steps."""
    sim = heap(rolling(0.5, 0.2), solver=lm.Newton(tolerance=1e-11), partner=partner).run(steps=150)
    problem, impulses = sim.problem(), sim.last_step[0].system.impulse
    assert problem.width == 3
    assert lm.residual(problem, impulses) < 2e-11
    assert np.abs(problem.velocities(impulses)[:, 2]).max() > 1e-3  # some roll
    for solver in (lm.GaussSeidel(tolerance=1e-8), lm.Newton(tolerance=1e-11)):
        solution = lm.solve(problem, solver=solver, guess=0.0 * impulses)
        assert solution.status == "converged"
        assert lm.residual(problem, solution.impulses) <= 1.1 * solver.tolerance


def test_newton_solves_what_sweeps_leave():
    """Twelve disks that come to rest on each other: sweeps drift along self-stresses of their many rolling impulses, and
    some steps stagnate at 1e-11, where Newton steps solve all of them."""
    sweeps = heap(rolling(0.5, 0.2), solver=lm.GaussSeidel(tolerance=1e-11))
    with pytest.warns(RuntimeWarning):
        sweeps.run(steps=150)
    newton = heap(rolling(0.5, 0.2), solver=lm.Newton(tolerance=1e-11)).run(steps=150)
    assert sweeps.unconverged_steps > 0
    assert newton.unconverged_steps == 0


@pytest.mark.filterwarnings("ignore:Step")
def test_newton_takes_a_scene_where_nothing_rolls_in_a_step():
    """The disk that rolls never comes down; contacts of two rows are beside it in arrays with room for three."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    for k in range(6):
        scene.add(lm.disk(radius=RADIUS, position=(0.001 * (k % 2), RADIUS * (1 + 2 * k)), material=SAND))
    scene.add(lm.disk(radius=RADIUS, position=(9.0, 50.0), material=SAND, color="FAR"))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    scene.see("FAR", "WALL", rolling())
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Newton(tolerance=1e-12, max_iterations=200))
    sim.run(steps=3)
    assert sim.report.solved
    assert sim.report.factorisations > 0


@pytest.mark.long
@pytest.mark.parametrize("solver", [lm.GaussSeidel(tolerance=1e-10), lm.Newton(tolerance=1e-10)], ids=repr)
def test_rolling_beads_of_a_wire(solver):
    """A taut elastic wire with links that have geometric stiffness lies on disks that roll: both kinds of rows in one step,
    and in its problem."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    beads = [scene.add(lm.disk(radius=0.02, position=(0.1 * k, 0.321), mass=1e-3, color="BEAD")) for k in range(6)]
    for body in (beads[0], beads[-1]):
        body.fix()
    for k in range(4):
        start = {"velocity": (0.3, -0.2), "spin": 3.0 * k}
        scene.add(lm.disk(radius=0.1, position=(0.1 + 0.25 * k, 0.45), mass=5.0, **start))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.chain(beads, lm.ElasticWire(stiffness=1e5))
    for pair in (("GRAIN", "GRAIN"), ("GRAIN", "BEAD"), ("GRAIN", "WALL"), ("BEAD", "WALL")):
        scene.see(*pair, rolling(0.5, 0.2))
    sim = lm.Simulation(scene, time_step=1e-3, solver=solver)
    stiff = rolled = 0
    for _ in range(60):
        sim.step()
        problem, impulses = sim.problem(), sim.last_step[0].system.impulse
        assert lm.residual(problem, impulses) < 1e-8
        both = bool((problem.geometric > 0.0).any()) and bool((sim.interactions.moment != 0.0).any())
        stiff += bool((problem.geometric > 0.0).any())
        rolled += both
        if both and rolled % 10 == 1:
            solution = lm.solve(problem, solver=solver)
            assert solution.status in ("converged", "round-off")
            assert lm.residual(problem, solution.impulses) < 1e-9
    assert sim.unconverged_steps == 0
    assert stiff > 0
    assert rolled > 0


def dumbbell(x, y, **start):
    """Disks of radius 0.2 m on either side of the centre of mass, so that normals pass beside it."""
    contactors = [(lm.DiskContactor(0.2), (-0.4, 0.0)), (lm.DiskContactor(0.2), (0.6, 0.0))]
    return lm.RigidBody(contactors, mass=1.5, inertia=0.2, position=(x, y), color="RED", **start)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:Step")  # on both disks it rests with four more unknowns than it has equations
@pytest.mark.parametrize("angle", [0.3, 1.2])
def test_a_contact_beside_the_centre_is_solved_at_once(angle):
    """One interaction with a full local block: its first sweep is the solution, to round-off; the moment is at its bound.

    R is the radius of the disk that touches, 0.2 m."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    scene.add(dumbbell(0.0, 1.0, rotation=angle, velocity=(1.0, -2.0), spin=4.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("RED", "WALL", rolling(0.4, 0.1))
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-13))
    pushed = 0
    for _ in range(600):
        sim.step()
        net = sim.interactions
        if (net.impulse[:, 0] > 0.0).sum() == 1 and len(net) == 1:
            assert sim.report.iterations <= 1
            assert abs(net.moment[0, 0]) <= 0.1 * 0.2 * net.impulse[0, 0] * (1.0 + 1e-14)
            pushed += 1
    assert pushed > 3


@pytest.mark.long
def test_off_centre_contacts_keep_momenta():
    """Two spinning dumbbells that collide dozens of times: 500 steps of ten operations on terms below 20 in SI units."""
    scene = lm.Scene(dimension=2)
    scene.add(dumbbell(-0.9, 0.1, rotation=0.7, velocity=(2.0, 0.3), spin=3.0))
    scene.add(dumbbell(0.9, -0.1, rotation=-0.4, velocity=(-2.0, 0.2), spin=-1.0))
    scene.see("RED", "RED", rolling(0.6, 0.3))
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-10))

    def momenta():
        (x, y), v = sim.positions.T, sim.velocities
        return np.array([*1.5 * v.sum(axis=0), (1.5 * (x * v[:, 1] - y * v[:, 0]) + 0.2 * sim.spins).sum()])

    before, turned = momenta(), 0.0
    for _ in range(500):
        sim.step()
        turned += np.abs(sim.interactions.moment).sum()
    assert turned > 0.01
    assert momenta() == pytest.approx(before, abs=1e-11)


@pytest.mark.long
def test_slabs_and_threads_roll_alike():
    """Partitioned, with held walls that threads share: the same bits with any number of threads, and without slabs another
    order of the sweep, hence the same to what the tolerance of 1e-7 makes of speeds of a few m/s in 40 steps."""

    def box(threads):
        rng = np.random.default_rng(1)
        scene = lm.Scene(dimension=2, gravity=(0.0, -G))
        for x, y in np.ndindex(12, 6):
            radius, start = rng.uniform(0.08, 0.1), {"velocity": tuple(rng.normal(size=2)), "spin": 5 * rng.normal()}
            scene.add(lm.disk(radius=radius, position=(0.21 * x, 0.1 + 0.21 * y), material=SAND, **start))
        scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
        scene.add(lm.wall(point=(-0.11, 0), normal=(1, 0)))
        scene.see("GRAIN", "GRAIN", rolling(0.5, 0.2))
        scene.see("GRAIN", "WALL", rolling(0.3, 0.1))
        return lm.Simulation(scene, time_step=2e-3, solver=lm.GaussSeidel(tolerance=1e-7), threads=threads)

    plain = box(1).run(steps=40)
    with partition_from(20):
        one, two = box(1).run(steps=40), box(2).run(steps=40)
    assert len(one.last_step.problem.groups.phase) > 2
    assert np.array_equal(one.velocities, two.velocities)
    assert np.array_equal(one.interactions.moment, two.interactions.moment)
    assert np.abs(one.velocities - plain.velocities).max() < 1e-3
    assert abs(one.energy.defect) < 1e-10
