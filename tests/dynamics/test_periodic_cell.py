"""A periodic cell: images, the motion with the mean flow, and the stress that it yields to."""

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.dynamics.cell import convection

AXES = "xyz"


def grain(dimension):
    return lm.disk if dimension == 2 else lm.sphere


def loose(dimension, count, shifts=None, friction=0.3, seed=0):
    """A scene and its cell of ``count``^d grains that do not touch, and move at random; each may be shifted by edges."""
    rng = np.random.default_rng(seed)
    scene = lm.Scene(dimension=dimension)
    size = 0.01 * count
    sand = lm.Material("sand", density=2600.0)
    for k, index in enumerate(np.ndindex(*(count,) * dimension)):
        position = 0.01 * (np.array(index) + 0.5)
        if shifts is not None:
            position += size * shifts[k]
        radius, velocity = 0.0049 * rng.uniform(0.7, 1.0), rng.normal(0.0, 0.3, dimension)
        scene.add(grain(dimension)(radius=radius, position=position, material=sand, velocity=velocity))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=friction))
    return scene, scene.periodic(**dict.fromkeys(AXES[:dimension], size))


def pressed(dimension, count, pressure, rate=0.0, **options):
    """The same, pressed, and sheared along x at a rate [1/s]."""
    scene, cell = loose(dimension, count, **options)
    cell.impose_stress(**{axis + axis: -pressure for axis in AXES[:dimension]})
    if rate:
        cell.impose_rate(xy=rate)
    return scene, cell


# ---------------------------------------------------------------------------------------------------------- the motion


@pytest.mark.default_parameters(time_step=[0.02])
@pytest.mark.parametrize("time_step", [0.02, 0.01, 0.005, 0.0025, 0.00125])
@pytest.mark.parametrize("theta", [0.5, 0.8])
def test_free_flight_in_simple_shear_is_straight(time_step, theta):
    """Seen from outside a body on which no force acts keeps its velocity ``v + G x``: x(t) = x0 + (v0 + G x0) t, whatever
    the step, as G^2 = 0 and the scheme is exact then; to the rounding of 800 steps."""
    scene = lm.Scene(dimension=2)
    start, velocity = np.array([0.3, 0.8]), np.array([0.4, -0.5])
    body = scene.add(lm.disk(radius=0.01, position=start, velocity=velocity, mass=1.0))
    scene.periodic(x=1.0, y=1.0).impose_rate(xy=2.0)
    sim = lm.Simulation(scene, time_step=time_step, theta=theta).run(duration=1.0)
    flow = np.array([[0.0, 2.0], [0.0, 0.0]])
    assert body.position == pytest.approx(start + velocity + flow @ start, abs=1e-12)
    assert body.velocity + flow @ body.position == pytest.approx(velocity + flow @ start, abs=1e-12)
    assert sim.energy.kinetic == pytest.approx(0.5 * float(body.velocity @ body.velocity))


@pytest.mark.default_parameters("4.0-0.5-2")
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("turn", [0.05, 0.5, 1.0, 1.9])
@pytest.mark.parametrize("ratio", [1.0, 4.0])
def test_speeds_do_not_grow_in_a_cell_that_spins(dimension, turn, ratio):
    """Of dv/dt = -G v with ``G = ((0, -a), (b, 0))`` the quantity ``b v_x^2 + a v_y^2`` is kept, to rounding, at any angle
    a step. (An explicit step multiplies it with ``1 + h^2 a b``.)"""
    h = 1e-2
    scene = lm.Scene(dimension=dimension)
    body = lm.disk if dimension == 2 else lm.sphere
    velocity = np.array([0.3, -0.4, 0.2][:dimension])
    thrown = scene.add(body(radius=0.01, position=np.full(dimension, 0.5), velocity=velocity, mass=1.0))
    a, b = turn / h / np.sqrt(ratio), turn / h * np.sqrt(ratio)
    scene.periodic(**dict.fromkeys("xyz"[:dimension], 1.0)).impose_rate(xy=-a, yx=b)
    sim = lm.Simulation(scene, time_step=h)
    angle = 0.0
    for _ in range(100):
        sim.step()
        angle += 2.0 * np.arctan(0.5 * turn)
        assert b * thrown.velocity[0] ** 2 + a * thrown.velocity[1] ** 2 == pytest.approx(b * 0.09 + a * 0.16, rel=1e-11)
        assert abs(sim.energy.defect) < 1e-12
    # in the scaled plane it turns by the angle of the midpoint rule, against the cell
    x, y = velocity[0], velocity[1] / np.sqrt(ratio)
    turned = x * np.cos(angle) + y * np.sin(angle)
    assert thrown.velocity[0] == pytest.approx(turned, abs=1e-11)
    assert dimension == 2 or thrown.velocity[2] == velocity[2]


@pytest.mark.long
@pytest.mark.parametrize("turn", [0.0, 1e-3, 1e-2])
@pytest.mark.parametrize("ratio", [1.0, 1e2, 1e4, 1e6])
def test_a_gas_of_heavy_and_light_disks_keeps_its_energy_in_a_cell_that_spins(ratio, turn):
    """Elastic disks in a cell that turns as a rigid body: shocks and ``dv/dt = -G v`` keep ``sum m v^2/2`` at any mass
    ratio. Shocks see the velocity before it turns in their step, so that this is of first order in the angle a step (0.7
    of it at most, over some shocks a disk); without turning it is kept to what the solver leaves at a residual of 1e-10."""
    h, side = 1e-3, 1.0
    scene = lm.Scene(dimension=2)
    rng = np.random.default_rng(0)
    for k in range(16):
        place = 0.25 * np.array([k % 4, k // 4]) + 0.125 - 0.5
        mass = 1.0 if k % 2 else 1.0 / ratio
        scene.add(lm.disk(radius=0.1, position=place, velocity=rng.normal(size=2), mass=mass))
    scene.see("GRAIN", "GRAIN", lm.Restitution(restitution=1.0))
    scene.periodic(x=side, y=side).impose_rate(xy=-turn / h, yx=turn / h)
    sim = lm.Simulation(scene, time_step=h, solver=lm.Auto(tolerance=1e-10))
    start, shocks = sim.energy.kinetic, 0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # far from the centre bodies move by more than their radius
        for _ in range(200):
            sim.step()
            shocks += int(sim.interactions.impulse.any(axis=1).sum())
            assert sim.report.solved
            assert abs(sim.energy.defect) <= 1e-12 * start
    assert shocks > 20
    assert sim.energy.kinetic == pytest.approx(start, rel=1e-8 + 2.0 * turn)


@pytest.mark.parametrize(
    "rate", [{"xy": 3.0}, {"xx": -2.0, "yy": 1.0}, {"xy": 2.0, "yx": 2.0}, {"xx": 1.0, "xy": 5.0, "yy": 1.0}, {}], ids=str
)
def test_flows_that_do_not_turn_are_explicit_as_they_were(rate):
    """Their G has real eigenvalues, a shear across the axes up to rounding."""
    gradient = np.zeros((2, 2))
    for name, value in rate.items():
        gradient["xy".index(name[0]), "xy".index(name[1])] = value
    assert convection(gradient, 0.1) is gradient
    for angle in np.linspace(0.1, 3.0, 20):
        along, across = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        shear = 7.0 * np.outer(along, across)
        assert convection(shear, 0.1) is shear


def test_bodies_at_rest_in_the_mean_flow_move_as_the_edges_do():
    """With v = 0 a position obeys dx/dt = G x, as an edge does: both keep the same coordinates in parts of the edges."""
    scene = lm.Scene(dimension=3)
    at = np.array([0.2, 0.7, 0.9])
    body = scene.add(lm.sphere(radius=0.01, position=at, mass=1.0))
    cell = scene.periodic(x=1.0, y=1.0, z=1.0)
    cell.impose_rate(xx=-0.3, yy=0.2, xz=0.1)
    lm.Simulation(scene, time_step=0.01).run(steps=60)
    assert np.linalg.solve(cell.edges.T, body.position) == pytest.approx(at, abs=1e-12)


def test_a_cell_that_is_sheared_on_keeps_its_volume_and_leans_little():
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.01, position=(0.5, 0.5), mass=1.0))
    cell = scene.periodic(x=1.0, y=1.0)
    cell.impose_rate(xy=1.0)
    sim = lm.Simulation(scene, time_step=0.01)
    for _ in range(15):
        sim.run(steps=10)
        assert cell.volume == pytest.approx(1.0, rel=1e-12)
        assert abs(cell.edges[1, 0]) <= 0.61
    assert cell.wrapped([[0.5, 0.5 + 1.0]])[0, 1] == pytest.approx(0.5)


def test_a_stress_alone_accelerates_the_gradient_by_volume_over_inertia():
    """One step from rest without contacts: G = h V sigma / I."""
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.01, position=(0.5, 0.5), mass=1.0))
    cell = scene.periodic(x=2.0, y=1.0, inertia=4.0)
    cell.impose_stress(xx=-10.0, xy=6.0)
    sim = lm.Simulation(scene, time_step=1e-3)
    sim.step()
    assert cell.rate == pytest.approx(1e-3 * 2.0 / 4.0 * np.array([[-10.0, 6.0], [0.0, 0.0]]), rel=1e-12)
    assert sim.energy.loads == pytest.approx(0.5 * 4.0 * float((cell.rate**2).sum()), rel=1e-12)


# -------------------------------------------------------------------------------------------------------- conservation


@pytest.mark.parametrize("dimension", [2, 3])
def test_momentum_is_conserved_in_a_cell_that_is_held(dimension):
    """Impulses across a face act on both bodies. Bound: rounding of some 1000 impulses of the size of the momentum."""
    scene, _ = loose(dimension, 4 if dimension == 2 else 3)
    sim = lm.Simulation(scene, time_step=1e-3)
    mass = np.array([body.mass for body in scene.bodies[:-dimension]])
    before = mass @ sim.velocities[:-dimension]
    met = 0
    for _ in range(40):
        sim.step()
        met += int((sim.interactions.impulse[:, 0] > 0.0).sum())
    scale = float(mass @ np.abs(sim.velocities[:-dimension]).sum(axis=1))
    assert met > 20
    assert np.abs(mass @ sim.velocities[:-dimension] - before).max() < 1e-13 * scale


@pytest.mark.default_parameters("0.0004-2")
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("time_step", [4e-4, 2e-4, 1e-4, 5e-5, 2.5e-5])
def test_the_energy_identity_closes_with_the_work_of_stress_and_shear(dimension, time_step):
    """T+ - T- = works of the imposed stress, of what drives the shear, and of contacts, to rounding. The drive works
    against Weber's stress and the inertia of the grains: ``-h sum (f (x) l + m v (x) v) : G`` over its component xy."""
    scene, cell = pressed(dimension, 4 if dimension == 2 else 3, 1e3, rate=5.0)
    sim = lm.Simulation(scene, time_step=time_step, on_unconverged="ignore")
    mass, turned = np.array([body.mass for body in scene.bodies[:-dimension]]), 0.0
    for _ in range(60):
        before, rate = sim.velocities[:-dimension].copy(), cell.rate
        sim.step()
        assert abs(sim.energy.defect) < 1e-12 * sim.energy.turned
        net, mean = sim.interactions, 0.5 * (rate + cell.rate)
        force = np.einsum("mk,mkd->md", net.force, net.frame)
        branch = net.lever[:, 1] - net.lever[:, 0]
        drive = -float(force[:, 0] @ branch[:, 1]) * mean[0, 1]
        # what the mean flow takes from the grains, less what the components that yield get of it
        flow, now = before @ rate.T, 0.5 * (before + sim.velocities[:-dimension])
        inertia = -float(mass @ (flow * now).sum(axis=1))
        inertia += sum(float(mass @ before[:, k] ** 2) * mean[k, k] for k in range(dimension))
        assert sim.energy.drives == pytest.approx(time_step * (drive + inertia), abs=1e-12 * sim.energy.turned)
        turned = max(turned, abs(drive))
    assert turned > 0.0
    assert sim.energy.total_loads > 0.0
    assert sim.energy.total_interactions["coulomb"] < 0.0


@pytest.mark.default_parameters("2")
@pytest.mark.parametrize("dimension", [2, 3])
def test_which_images_are_given_does_not_matter(dimension):
    """Every body shifted by its own whole number of edges: the same motion, but for the rounding of their positions, which
    30 steps of shocks may enlarge a thousandfold."""
    count = 4 if dimension == 2 else 3
    shifts = np.random.default_rng(5).integers(-3, 4, (count**dimension, dimension))
    runs = []
    for given in (None, shifts):
        scene, cell = pressed(dimension, count, 1e3, rate=3.0, shifts=given)
        sim = lm.Simulation(scene, time_step=2e-4, solver=lm.Auto(tolerance=1e-12)).run(steps=30)
        runs.append((sim.velocities[:-dimension].copy(), cell.rate, lm.measure.stress(sim)["total"], len(sim.interactions)))
    (v, rate, stress, met), (v2, rate2, stress2, met2) = runs
    assert met == met2 > 0
    # in shear the velocity v relative to the mean flow is that of all images
    assert v2 == pytest.approx(v, abs=1e-11)
    assert rate2 == pytest.approx(rate, abs=1e-9)
    assert stress2 == pytest.approx(stress, abs=1e-8 * np.abs(stress).max())


# ----------------------------------------------------------------------------------------------------------- contacts


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_shock_across_a_face_is_that_of_the_images(dimension):
    """Two grains meet across the face of the cell as two do in the open, one at the place of its image; oblique, rough."""
    ends = []
    for periodic in (True, False):
        scene = lm.Scene(dimension=dimension)
        make = {"radius": 0.1, "mass": 1.0}
        more = (0.5,) * (dimension - 2)
        scene.add(grain(dimension)(position=(0.2, 0.5, *more), velocity=(-1.0, 0.2, *more), **make))
        scene.add(
            grain(dimension)(
                position=(0.85 - (not periodic), 0.55, *more), velocity=(0.5,) + (0.0,) * (dimension - 1), **make
            )
        )
        if periodic:
            scene.periodic(x=1.0)
        scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.4))
        sim = lm.Simulation(scene, time_step=0.01).run(steps=12)
        assert sim.energy.total_interactions["coulomb"] < -0.1
        ends.append(np.hstack([sim.velocities[:2], sim.spins[:2].reshape(2, -1)]))
    assert ends[0] == pytest.approx(ends[1], abs=1e-13)


@pytest.mark.parametrize("dimension", [2, pytest.param(3, marks=pytest.mark.long)])
def test_the_local_blocks_are_those_of_the_assembled_operator(dimension):
    """Diagonal blocks of ``W = H^T M^-1 H`` with the columns of the gradient; so narrow phase, sweeps and Newton steps
    solve the same problem. The velocities at the end are W r + q."""
    scene, cell = pressed(dimension, 4 if dimension == 2 else 3, 1e3, rate=3.0)
    beads = scene.bodies[:3]
    scene.chain(beads, lm.RigidWire(), reference_gap=0.01 if dimension == 2 else 0.002)
    cell.impose_stress(yx=100.0)
    sim = lm.Simulation(scene, time_step=2e-4).run(steps=30)
    problem, d = sim.problem(), dimension
    system = sim.last_step[0].system
    W = problem.W.toarray()
    rows = np.arange(len(W)).reshape(-1, d)
    blocks = W[rows[:, :, None], rows[:, None, :]]
    # a link has one component here
    contacts = slice(2, None)
    assert system.delassus[:2, 0] == pytest.approx(blocks[:2, 0, 0], rel=1e-12)
    assert system.delassus[contacts, :d] == pytest.approx(np.einsum("mii->mi", blocks)[contacts], rel=1e-12)
    scale = blocks.max()
    assert system.coupling[contacts] == pytest.approx(blocks[contacts, 0, 1], abs=1e-12 * scale)
    if d == 3:
        assert system.shear[contacts] == pytest.approx(blocks[contacts, :2, 2], abs=1e-12 * scale)
    u = W @ system.impulse[:, :d].ravel() + problem.q
    assert len(rows) > 10
    bias = u.reshape(-1, d) - sim.last_step[0].data.after[:, :d]
    assert np.abs(bias[:, 1:][contacts]).max() < 1e-12 * np.abs(u).max()


@pytest.mark.long
@pytest.mark.parametrize("dimension", [2, 3])
def test_contacts_that_roll_are_those_of_the_assembled_operator_too(dimension):
    """Rows of rolling and torsion meet spins alone: the cell adds nothing to them."""
    rng, count = np.random.default_rng(0), 4 if dimension == 2 else 3
    scene = lm.Scene(dimension=dimension)
    for index in np.ndindex(*(count,) * dimension):
        radius, velocity = 0.0049 * rng.uniform(0.8, 1.0), rng.normal(0.0, 0.1, dimension)
        position = 0.01 * (np.array(index) + 0.5)
        scene.add(grain(dimension)(radius=radius, position=position, mass=0.1, velocity=velocity))
    scene.see("GRAIN", "GRAIN", lm.RollingCoulomb(friction=0.4, rolling_friction=0.1))
    cell = scene.periodic(**dict.fromkeys(AXES[:dimension], 0.01 * count))
    cell.impose_stress(**{axis + axis: -1e3 for axis in AXES[:dimension]}).impose_rate(xy=2.0)
    sim = lm.Simulation(scene, time_step=2e-4, solver=lm.Auto(tolerance=1e-9)).run(steps=100)
    problem, system, after = sim.problem(), sim.last_step[0].system, sim.last_step[0].data.after
    u = problem.velocities(system.impulse)
    assert problem.width > dimension
    assert np.abs((u - after)[:, 1:]).max() < 1e-12 * np.abs(u).max()  # the normal ones have the biases
    blocks = problem.W.toarray().reshape(len(u), problem.width, len(u), problem.width)
    diagonal = np.einsum("mama->ma", blocks)
    assert system.delassus == pytest.approx(diagonal, abs=1e-12 * diagonal.max())
    assert abs(sim.energy.defect) < 1e-12 * sim.energy.turned


@pytest.mark.parametrize("dimension", [2, pytest.param(3, marks=pytest.mark.long)])
def test_newton_steps_on_the_split_operator_are_those_on_the_whole(dimension):
    """``W = sparse + C C^T`` as one sparse system with the components of the cell beside, or W as it is: the same impulses
    of a step, whose solution the proximal method makes unique, and the same residual in ``lm.solve``."""
    scene, _ = pressed(dimension, 4 if dimension == 2 else 3, 1e3, rate=3.0)
    sim = lm.Simulation(scene, time_step=2e-4).run(steps=60)
    problem = sim.problem()
    sparse, columns = problem.split
    assert columns.shape[1] == dimension
    assert (sparse + columns @ columns.T) == pytest.approx(problem.W.toarray(), abs=1e-12 * problem.W.max())
    whole = replace(problem, split=None)
    ends = [lm.solve(one, solver=lm.Newton(tolerance=1e-12)) for one in (problem, whole)]
    for one, end in zip((problem, whole), ends, strict=True):
        assert lm.residual(one, end.impulses, measure="natural") < 1e-11
    assert ends[0].velocities == pytest.approx(ends[1].velocities, abs=1e-8 * np.abs(problem.q).max())


def test_all_solvers_find_the_same_step():
    """Velocities of a frictionless step are unique; each solver is asked for 1e-10 of them."""
    ends = []
    for solver in (lm.GaussSeidel, lm.AcceleratedGaussSeidel, lm.Newton, lm.Auto):
        scene, cell = pressed(2, 4, 1e3, friction=0.0)
        sim = lm.Simulation(scene, time_step=2e-4, solver=lm.Auto(tolerance=1e-11)).run(steps=60)
        sim.solver = solver(tolerance=1e-11, max_iterations=50_000)
        report = sim.step()
        assert report.status in ("converged", "converged to round-off"), (solver, report)
        ends.append(np.vstack([sim.velocities[:-2], cell.rate * 0.04]))
    for end in ends[1:]:
        assert end == pytest.approx(ends[0], abs=1e-8 * np.abs(ends[0]).max())


# ------------------------------------------------------------------------------------------------------------- stress


@pytest.mark.default_parameters(time_step=(1e-3, 6.25e-5))
@pytest.mark.parametrize("time_step", [1e-3, 5e-4, 2.5e-4, 1.25e-4, 6.25e-5])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_crystal_of_touching_grains_carries_the_imposed_stress(dimension, time_step):
    """Each row of grains in contact along an axis a carries one force; the rows share the force on a face, so that its mean
    is N = p_a D^(d - 1), and Weber's stress is the imposed one; at once, whatever the step. (How the rows share it is open
    between rigid grains.)"""
    scene = lm.Scene(dimension=dimension)
    count, diameter = 4, 0.01
    for index in np.ndindex(*(count,) * dimension):
        position = diameter * (np.array(index) + 0.3)
        scene.add(grain(dimension)(radius=0.5 * diameter, position=position, mass=0.1))
    cell = scene.periodic(**dict.fromkeys(AXES[:dimension], count * diameter))
    pressure = np.array([1000.0, 2000.0, 1500.0])[:dimension]
    cell.impose_stress(**{axis + axis: -p for axis, p in zip(AXES, pressure, strict=False)})
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.0))
    sim = lm.Simulation(scene, time_step=time_step, solver=lm.Auto(tolerance=1e-9)).run(steps=3)
    net = sim.interactions
    along = np.abs(net.normal).argmax(axis=1)
    touching = net.gap < 1e-6
    assert touching.sum() == dimension * count**dimension
    index = np.rint(sim.positions[:-dimension] / diameter - 0.3).astype(int)
    for a in range(dimension):
        mine = touching & (along == a)
        force = net.force[mine, 0]
        assert force.mean() == pytest.approx(pressure[a] * diameter ** (dimension - 1), rel=1e-6)
        row = np.delete(index[net.candidate[mine]], a, axis=1) @ count ** np.arange(dimension - 1)
        mean = np.bincount(row, force) / np.bincount(row)
        assert force == pytest.approx(mean[row], rel=1e-6)
    stress = lm.measure.stress(sim)["total"]
    assert stress == pytest.approx(-np.diag(pressure), abs=1e-6 * pressure.max())


@pytest.mark.long
@pytest.mark.parametrize("time_step", [4e-4, 2e-4, 1e-4, 5e-5, 2.5e-5])
def test_weber_stress_at_rest_is_the_imposed_one(time_step):
    """Grains come to rest under a stress with a shear: then I dG/dt is below 1e-3 of V p, and so is the difference."""
    scene, cell = loose(2, 5)
    cell.impose_stress(xx=-1000.0, yy=-1200.0)
    imposed = np.array([[-1000.0, 0.0], [0.0, -1200.0]])
    cell.fix("yx", "xy")
    sim = lm.Simulation(scene, time_step=time_step)
    for _ in range(round(0.3 / time_step)):
        sim.velocities[:] *= 1.0 - 20.0 * time_step  # a drag brings it to rest
        sim.step()
    stress = lm.measure.stress(sim)["total"]
    assert np.diag(stress) == pytest.approx(np.diag(imposed), rel=1e-3)
    assert np.abs(cell.rate).max() * 0.05 < 1e-3


# ------------------------------------------------------------------------------------------- chains, clusters, walls


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_chain_across_a_face_moves_as_in_the_open(dimension):
    """In a cell at rest a wire that no image meets moves as without the cell, to the last bits."""
    ends = []
    for periodic in (True, False):
        scene = lm.Scene(dimension=dimension)
        rest = (0.5,) * (dimension - 1)
        make = {"radius": 0.01, "mass": 0.1}
        beads = [
            grain(dimension)(position=(0.9 + 0.05 * k, *rest), velocity=(0.0, 1.0 * k, 0.3)[:dimension], **make)
            for k in range(5)
        ]
        for bead in beads:
            scene.add(bead)
        scene.chain(beads, lm.RigidWire())
        scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
        if periodic:
            scene.periodic(x=1.0, y=1.0)
        sim = lm.Simulation(scene, time_step=1e-3).run(steps=20)
        ends.append(sim.positions[:5].copy())
    assert (ends[0] == ends[1]).all()


def test_a_wire_that_is_stretched_by_the_cell_is_taut():
    """Beads in a row along x across a face, at rest in a cell that is extended at a rate: they keep their distances. The
    mean flow accelerates, x'' = G^2 x, and takes them along: tension T_k = m G^2 sum of (x_i - x_mean) beyond the link, to
    first order in h G, and Weber's stress is the sum of T l / V."""
    scene = lm.Scene(dimension=2)
    places = 0.4 + 0.1 * np.arange(9)
    beads = [scene.add(lm.disk(radius=0.01, position=(x, 0.5), mass=0.1, velocity=(-0.2 * (x - 0.8), 0.0))) for x in places]
    scene.chain(beads, lm.RigidWire(), block_spin=True)
    cell = scene.periodic(x=1.0, y=1.0)
    cell.impose_rate(xx=0.2)
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-11)).run(steps=100)
    length = np.linalg.norm(np.diff(sim.positions[:9], axis=0), axis=1)
    assert length == pytest.approx(0.1, rel=1e-6)
    tension = -sim.interactions.force[:, 0]
    beyond = 0.1 * 0.2**2 * np.cumsum((places - 0.8)[::-1])[:-1][::-1]
    assert tension == pytest.approx(beyond, rel=1e-3)
    stress = lm.measure.stress(sim)["total"]
    assert stress[0, 0] == pytest.approx(0.1 * tension.sum() / cell.volume, rel=1e-6)
    assert abs(stress[1, 1]) < 1e-9 * stress[0, 0]


def test_clusters_meet_across_a_face():
    """Two bars of disks that move towards each other through the face stop there: one body after the inelastic shock."""
    scene = lm.Scene(dimension=2)
    for x, v in ((0.2, -1.0), (0.75, 1.0)):
        bar = [(lm.DiskContactor(0.05), (k * 0.05, 0.0)) for k in (-1, 0, 1)]
        scene.add(lm.RigidBody(bar, mass=1.0, inertia=0.01, position=(x, 0.5), color="BAR", velocity=(v, 0.0)))
    scene.see("BAR", "BAR", lm.Coulomb(friction=0.0))
    scene.periodic(x=1.0, y=1.0)
    sim = lm.Simulation(scene, time_step=0.01).run(steps=30)
    assert sim.velocities[:2] == pytest.approx(0.0, abs=1e-12)
    assert sim.positions[0, 0] + 1.0 - sim.positions[1, 0] == pytest.approx(0.2, abs=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_bed_between_periodic_sides_presses_its_floor_with_its_weight(dimension):
    """On an incline of 10 degrees with friction 0.3 a periodic layer rests: the floor bears the weight, its stress is
    sigma_zz = -m g cos / A and sigma_xz = m g sin / A in size at the foot."""
    angle, g = math.radians(10.0), 9.81
    gravity = np.zeros(dimension)
    gravity[0], gravity[-1] = g * math.sin(angle), -g * math.cos(angle)
    scene = lm.Scene(dimension=dimension, gravity=gravity)
    for index in np.ndindex(*(4,) * (dimension - 1)):
        flat = 0.1 * (np.array(index) + 0.5)
        scene.add(grain(dimension)(radius=0.05, position=(*flat, 0.05), mass=1.0))
    count = len(scene.bodies)
    for body in scene.bodies:
        body.fix("spin") if dimension == 2 else body.fix("spin_x", "spin_y", "spin_z")
    floor = scene.add(lm.wall(point=np.zeros(dimension), normal=np.eye(dimension)[-1]))
    scene.periodic(**dict.fromkeys(AXES[: dimension - 1], 0.4))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.0))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=50)
    net = sim.interactions
    on_floor = net.antagonist == floor.id
    force = np.einsum("mk,mkd->md", net.force[on_floor], net.frame[on_floor]).sum(axis=0)
    assert force == pytest.approx(-count * gravity, abs=1e-6 * count * g)
    assert np.abs(sim.velocities).max() < 1e-9


def test_the_stress_between_a_pressed_lid_and_a_floor_is_the_pressure():
    """Periodic along x, a lid of p per length: sigma_yy = -p with the volume of the cell between the walls, and Weber's
    branches that end at the walls."""
    scene, radius = lm.Scene(dimension=2), 0.05
    for i in range(4):
        for j in range(3):
            scene.add(lm.disk(radius=radius, position=(0.1 * i + 0.05 + 0.05 * (j % 2), 0.05 + 0.0866026 * j), mass=1.0))
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0, 1)))
    lid = scene.add(lm.wall(point=(0.0, 0.0866026 * 2 + 0.1), normal=(0, -1), mass=5.0))
    lid.impose_force(y=-1000.0 * 0.4)
    scene.periodic(x=0.4)
    for pair in (("GRAIN", "GRAIN"), ("GRAIN", "WALL")):
        scene.see(*pair, lm.Coulomb(friction=0.0))
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-9)).run(steps=30)
    assert lm.measure.stress(sim)["total"][1, 1] == pytest.approx(-1000.0, rel=1e-5)


def test_windows_that_tile_the_cell_have_its_stress_as_their_mean():
    """Also where bodies lie outside of the cell, and where it leans."""
    shifts = np.random.default_rng(5).integers(-2, 3, (16, 2))
    scene, cell = pressed(2, 4, 1e3, rate=20.0, shifts=shifts)
    sim = lm.Simulation(scene, time_step=2e-4).run(steps=60)
    width, height, count = cell.edges[0, 0], cell.edges[1, 1], 3
    assert abs(cell.edges[1, 0]) > 0.1 * width
    parts = [
        lm.measure.window_stress(
            sim, ((i * width / count, j * height / count), ((i + 1) * width / count, (j + 1) * height / count))
        )
        for i, j in np.ndindex(count, count)
    ]
    total = lm.measure.stress(sim)["total"]
    assert np.abs(total).max() > 100.0
    assert np.mean(parts, axis=0) == pytest.approx(total, abs=1e-9 * np.abs(total).max())


# ------------------------------------------------------------------------------------------------- going on with a run


@pytest.mark.parametrize("dimension", [2, pytest.param(3, marks=pytest.mark.long)])
def test_a_resumed_run_has_the_same_bits(dimension, tmp_path):
    """30 steps = 15 + file + 15, in a shear that changes the edges on the way, with a statement between the steps."""

    def made():
        scene, cell = loose(dimension, 4)
        cell.impose_rate(xy=60.0)
        cell.impose_stress(yy=-1.0)
        beads = scene.bodies[:3]
        scene.chain(beads, lm.RigidWire(), reference_gap=0.01)
        return lm.Simulation(scene, time_step=4e-4, on_unconverged="ignore"), cell

    whole, cell = made()
    whole.run(steps=5)
    cell.impose_stress(yy=-2.0)
    whole.run(steps=25)
    assert cell.edges[1, 0] < 0.0 < 60.0 * whole.time * cell.edges[1, 1]  # other edges by now
    part, cell = made()
    part.run(steps=5)
    cell.impose_stress(yy=-2.0)
    part.run(steps=10, record=tmp_path / "run.h5", every=5)
    again = lm.resume(tmp_path / "run.h5").run(steps=15)
    assert (again.positions == whole.positions).all()
    assert (again.velocities == whole.velocities).all()
    assert (again.scene.cell.edges == whole.scene.cell.edges).all()


def test_a_scene_from_a_run_has_its_cell_as_it_was(tmp_path):
    scene, cell = pressed(2, 4, 1e3, rate=5.0)
    sim = lm.Simulation(scene, time_step=2e-4)
    sim.run(steps=20, record=tmp_path / "run.h5", every=20)
    with lm.io.open_run(tmp_path / "run.h5") as run:
        stress = lm.measure.stress(run)["total"]
        net = run.interactions(-1)
        assert net.lever == pytest.approx(sim.interactions.lever, abs=1e-12)
    assert stress == pytest.approx(lm.measure.stress(sim)["total"], rel=1e-12)
    taken = lm.Scene.from_run(tmp_path / "run.h5")
    assert taken.cell.edges == pytest.approx(cell.edges)
    assert taken.cell.rate == pytest.approx(cell.rate)
    assert taken.cell.volume == pytest.approx(cell.volume)


# --------------------------------------------------------------------------------------------------------- sentences


def test_a_cell_that_is_too_narrow_says_how_wide_it_must_be():
    scene = lm.Scene(dimension=2)
    for x in (0.02, 0.05):
        scene.add(lm.disk(radius=0.01, position=(x, 0.05), mass=1.0))
    scene.periodic(x=0.1, y=0.03)
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    with pytest.raises(ValueError, match=r"The periodic cell is 0.03 m wide.*must be wider than 0.0[45]"):
        lm.Simulation(scene, time_step=1e-3).step()


@pytest.mark.parametrize("normal", [(1, 0), (1, 1)])
def test_a_wall_across_the_faces_is_refused(normal):
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.01, position=(0.05, 0.05), mass=1.0))
    scene.add(lm.wall(point=(0, 0), normal=normal))
    scene.periodic(x=0.1)
    with pytest.raises(ValueError, match="cuts the faces of the periodic cell"):
        lm.Simulation(scene, time_step=1e-3)


def turning_cell(**statements):
    """Two disks in a cell, and what drives it."""
    scene = lm.Scene(dimension=2)
    for x in (0.1, 0.5):
        scene.add(lm.disk(radius=0.05, position=(x, 0.3), mass=1.0))
    cell = scene.periodic(x=1.0, y=1.0)
    for call, components in statements.items():
        getattr(cell, call)(**components)
    return lm.Simulation(scene, time_step=1e-3), cell


@pytest.mark.parametrize(
    "statements",
    [
        {"impose_rate": {"xx": -2001.0}},  # the first half of a step
        {"impose_rate": {"xx": 2001.0}},  # the second half, implicit
        {"impose_rate": {"xy": 2100.0, "yx": 2100.0}},
        {"impose_stress": {"xx": -1e6, "yy": -1e6}},
        {"impose_stress": {"xx": 1e9}},
    ],
)
def test_a_cell_that_would_turn_over_in_a_step_is_told(statements):
    """Half a step with |G| h/2 > 1 turns an edge over: the state is that before the step, and the shorter step does."""
    sim, cell = turning_cell(**statements)
    words = r"cell would turn over: .* A time step [\d.e-]+ times as long would do\."
    with pytest.raises(RuntimeError, match=words) as told:
        sim.run(steps=50)
    positions, edges = sim.positions.copy(), cell.edges.copy()
    with pytest.raises(RuntimeError, match="turn over"):
        sim.step()
    np.testing.assert_array_equal(sim.positions, positions)
    np.testing.assert_array_equal(cell.edges, edges)
    factor = float(str(told.value).split("A time step ")[1].split()[0])
    assert 0.0 < factor < 1.0


@pytest.mark.parametrize("edge", [(0.0, 0.0), (1.0, 0.0)])
def test_edges_that_span_no_cell_are_told(edge):
    sim, _ = turning_cell()
    sim.run(steps=2)
    sim.positions[-1] = edge
    with pytest.raises(RuntimeError, match="span no volume"):
        sim.step()


def test_a_shear_of_any_rate_does_not_turn_a_cell_over():
    """Its eigenvalues are zero: three widths a step."""
    sim, cell = turning_cell(impose_rate={"xy": 3e3})
    sim.run(steps=3)
    assert cell.volume == pytest.approx(1.0)
