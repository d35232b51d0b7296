"""Slabs in periodic scenes: a ring of slabs, and a cell whose gradient all interactions share."""

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.contact.slabs import partition_from

AXES = "xyz"


@pytest.fixture
def partition_small_scenes():
    """Scenes of twenty bodies are partitioned, as large ones are."""
    with partition_from(20):
        yield


def grains(dimension, sides, friction, seed=0, speed=0.3):
    """A scene of grains that do not touch, and move at random; ``sides``: number of grains along each axis."""
    rng = np.random.default_rng(seed)
    scene = lm.Scene(dimension=dimension)
    make = lm.disk if dimension == 2 else lm.sphere
    bodies = []
    for index in np.ndindex(*sides):
        place, velocity = 0.01 * (np.array(index) + 0.5), rng.normal(0.0, speed, dimension)
        radius = 0.0049 * rng.uniform(0.7, 1.0)
        bodies.append(scene.add(make(radius=radius, position=place, velocity=velocity, mass=2e3 * radius**2)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=friction))
    return scene, bodies


def cell_of(scene, sides, axes=None):
    return scene.periodic(**{AXES[a]: 0.01 * sides[a] for a in (range(len(sides)) if axes is None else axes)})


def held(dimension, sides, friction=0.3):
    scene, _ = grains(dimension, sides, friction)
    cell_of(scene, sides)
    return scene


def sheared(dimension, sides, friction=0.3):
    """Fast enough for the cell to take other edges within a hundred steps."""
    scene, _ = grains(dimension, sides, friction)
    cell_of(scene, sides).impose_rate(xy=20.0)
    return scene


def pressed(dimension, sides, friction=0.3):
    """Yields to a pressure, and is sheared."""
    scene, _ = grains(dimension, sides, friction)
    cell = cell_of(scene, sides)
    cell.impose_stress(**{a + a: -2e3 for a in AXES[:dimension]})
    cell.impose_rate(xy=5.0)
    return scene


def free(dimension, sides, friction=0.3):
    """All components yield, with two wires that share no bead."""
    scene, bodies = grains(dimension, sides, friction)
    row = len(bodies) // sides[0]
    for first in (3, 5):
        scene.chain(bodies[first : 6 * row : row], lm.ElasticWire(stiffness=1e4))
    cell = cell_of(scene, sides)
    cell.impose_stress(**{a + b: -2e3 * (a == b) for a in AXES[:dimension] for b in AXES[:dimension]})
    return scene


def bed(dimension, sides, friction=0.3):
    """On a floor that shakes under a lid that presses, periodic along the other axes."""
    scene, _ = grains(dimension, sides, friction)
    up = np.eye(dimension)[-1]
    floor = scene.add(lm.wall(point=0.0 * up, normal=up))
    floor.impose_velocity(**{AXES[dimension - 1]: lambda t: 0.2 * np.cos(60.0 * t)})
    scene.add(lm.wall(point=0.01 * sides[-1] * up, normal=-up, mass=0.5)).impose_force(**{AXES[dimension - 1]: -20.0})
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
    cell_of(scene, sides, range(dimension - 1)).impose_rate(xx=0.5)
    return scene


KINDS = {kind.__name__: kind for kind in (held, sheared, pressed, free, bed)}
SIDES = {2: (16, 8), 3: (13, 6, 6)}
SOLVERS = {
    "plain": lm.GaussSeidel(tolerance=1e-4, max_iterations=40),
    "momentum": lm.AcceleratedGaussSeidel(tolerance=1e-4, max_iterations=40),
}


def simulation(scene, **options):
    options = {"time_step": 1e-3, "on_unconverged": "ignore", "overlap": "ignore", **options}
    return lm.Simulation(scene, **options)


def bits(sim):
    """What a step leaves, as bytes."""
    net, report = sim.interactions, sim.report
    arrays = sim.positions, sim.velocities, net.candidate, net.antagonist, net.gap, net.impulse
    told = sim.energy, report.iterations, report.residual, report.worst
    return (*(np.ascontiguousarray(array).tobytes() for array in arrays), repr(told))


def same_bits(make, dimension, solver, steps, threads):
    sims = [simulation(make(dimension, SIDES[dimension]), threads=n, solver=SOLVERS[solver]) for n in threads]
    edges = []
    for _ in range(steps):
        for sim in sims:
            sim.step()
        expected = bits(sims[0])
        assert all(bits(sim) == expected for sim in sims[1:])
        edges.append(sims[0].scene.cell.edges)
    assert np.diff(sims[0].last_step.problem.groups.phase).max() >= 3
    return sims[0], np.array(edges)


@pytest.mark.filterwarnings("ignore:In the step to")
@pytest.mark.usefixtures("partition_small_scenes")
@pytest.mark.parametrize(("kind", "solver"), [("pressed", "momentum"), ("held", "plain")])
def test_some_threads_give_the_bits_of_one(kind, solver):
    same_bits(KINDS[kind], 2, solver, 12, (1, 2, 3, 4))


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:In the step to")
@pytest.mark.usefixtures("partition_small_scenes")
@pytest.mark.parametrize("solver", list(SOLVERS))
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("kind", list(KINDS))
def test_any_number_of_threads_gives_the_bits_of_one(kind, dimension, solver):
    """Two hundred steps, in which bodies cross the faces and the cell takes other edges; twice with two threads, as a race
    need not show at once."""
    sim, edges = same_bits(KINDS[kind], dimension, solver, 200, (1, 2, 2, 3, 4))
    assert sim._detector.rebuilds > 5
    places = sim.scene.cell.wrapped(sim.positions[:, :dimension]) - sim.positions[:, :dimension]
    assert (np.abs(places).max(axis=1) > 1e-3).sum() > 3  # bodies outside the cell
    if kind == "sheared":
        assert (np.diff(edges[:, 1, 0]) < 0.0).any()


def interactions_by_task(problem):
    """Rows of the interactions of each task, and the tasks of each phase."""
    table = problem.groups
    rows = [
        np.concatenate([np.arange(table.start[p], table.stop[p]) for p in range(*table.task[t : t + 2])])
        for t in range(len(table.task) - 1)
    ]
    return rows, [range(*table.phase[f : f + 2]) for f in range(len(table.phase) - 1)]


@pytest.mark.filterwarnings("ignore:In the step to")
@pytest.mark.usefixtures("partition_small_scenes")
@pytest.mark.parametrize(("kind", "dimension"), [("sheared", 2), ("free", 2), ("bed", 2), ("pressed", 3)])
def test_tasks_that_are_done_side_by_side_write_to_no_body_twice(kind, dimension):
    """Nor to one copy of the cell; and the ring is closed: next to all interactions are in slabs, across the faces too."""
    sim = simulation(KINDS[kind](dimension, SIDES[dimension]), solver=SOLVERS["plain"]).run(steps=30)
    problem = sim.last_step[0]
    system, free_velocity = problem.system.reordered(problem.row, problem.free_velocity)
    rows, phases = interactions_by_task(problem)
    assert sorted(np.concatenate(rows)) == list(range(len(system.candidate)))
    held = (system.inverse_mass == 0.0).all(axis=1)
    for tasks in phases:
        written = [set(np.concatenate([system.candidate[rows[t]], system.antagonist[rows[t]]]).tolist()) for t in tasks]
        written = [{body for body in bodies if not held[body]} for bodies in written]
        assert sum(map(len, written)) == len(set().union(*written))
    swept = problem.crews[False]._job.s
    of_task = [set(swept.cell[r].tolist()) for r in rows]
    assert all(len(cells) == 1 for cells in of_task)
    assert len(set().union(*of_task)) == len(rows)
    assert min(set().union(*of_task)) >= len(free_velocity)
    alone = [len(rows[t]) for tasks in phases if len(tasks) == 1 for t in tasks]
    with_walls = (problem.system.branch == 0.0).all(axis=1).sum() if kind == "bed" else 0
    assert sum(alone) <= 0.02 * len(system.candidate) + with_walls
    along = sim.scene.cell.lattice.crossed(
        sim.positions[problem.system.candidate, :dimension] - sim.positions[problem.system.antagonist, :dimension],
        sim.scene.cell.edges,
    )
    assert (np.abs(along[:, 0]) > 0.05).sum() > 3


@pytest.mark.default_parameters("5-2-sheared", "5-2-free")
@pytest.mark.filterwarnings("ignore:In the step to")
@pytest.mark.parametrize("kind", list(KINDS))
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("rounds", [5, 20])
def test_slabs_solve_the_same_problem(rounds, dimension, kind):
    """A run by ids; every tenth step is made by slabs too, from the same state, both to a residual of 1e-10. Without
    friction a step has one solution for the velocities, and the cell is among them."""
    make, sides = KINDS[kind], SIDES[dimension]
    loose = lm.GaussSeidel(tolerance=1e-3)
    tight = lm.AcceleratedGaussSeidel(tolerance=1e-10, max_iterations=100_000)
    by_ids = simulation(make(dimension, sides, friction=0.0), solver=loose)
    with partition_from(20):
        by_slabs = simulation(make(dimension, sides, friction=0.0), solver=tight)
    for _ in range(rounds):
        by_ids.solver = loose
        by_ids.run(steps=9)
        by_slabs.restore(by_ids.checkpoint())
        by_ids.solver = tight
        for sim in (by_ids, by_slabs):
            sim.step()
            assert sim.report.residual <= 5e-10, (sim.report, sim.time)  # rounding may stop a step at 2e-10
        assert len(by_slabs.last_step.problem.groups.task) > 4
        assert len(by_ids.last_step.problem.groups.task) == 2
        scale = np.abs(by_ids.velocities).max()
        assert by_slabs.velocities == pytest.approx(by_ids.velocities, abs=1e-6 * scale)  # 1e-7 at rest, 3e-9 else
        edges = by_ids.scene.cell.lattice.rows
        assert by_slabs.velocities[edges] == pytest.approx(by_ids.velocities[edges], rel=1e-6, abs=1e-7)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:In the step to")
@pytest.mark.usefixtures("partition_small_scenes")
@pytest.mark.parametrize("kind", list(KINDS))
def test_a_run_goes_on_from_a_checkpoint_bit_for_bit(kind):
    """Slabs are those of the last list, which a checkpoint makes again; with another number of threads."""
    whole, first, second = (simulation(KINDS[kind](2, SIDES[2]), threads=n) for n in (1, 2, 3))
    whole.run(steps=50)
    first.run(steps=23)
    second.restore(first.checkpoint())
    second.run(steps=27)
    assert bits(second)[:-1] == bits(whole)[:-1]
