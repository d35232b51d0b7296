"""Slabs and threads: the partition is of the geometry alone, and who does what cannot be seen in the result."""

from __future__ import annotations

import threading

import numpy as np
import pytest
from mixed_scene import mixed_scene

import lmgcpy as lm
from lmgcpy.contact.slabs import cut_slabs, partition_from


@pytest.fixture
def partition_small_scenes():
    """Scenes of twenty bodies are partitioned, as large ones are."""
    with partition_from(20):
        yield


def box_of_spheres(side=7, seed=1):
    """Spheres thrown about in a box whose floor shakes and whose lid presses, one big among them, one fixed, one held in x;
    two wires that share no bead."""
    rng = np.random.default_rng(seed)
    scene = lm.Scene(dimension=3, gravity=(0.3, 0.1, -9.81))
    width = 2.1 * side
    spheres = []
    for i, j, k in np.ndindex(side, side, side):
        place = 2.1 * (np.array([i, j, k]) + 0.5)
        radius = 3.0 if (i, j, k) == (3, 3, 6) else rng.uniform(0.8, 1.0)
        if radius == 3.0:
            place = np.array([0.5 * width, 0.5 * width, width + 3.0])
        start = {"velocity": rng.normal(0.0, 3.0, 3), "spin": rng.normal(0.0, 2.0, 3)}
        spheres.append(scene.add(lm.sphere(radius=radius, position=place, mass=radius**3, **start)))
    spheres[5].fix()
    spheres[100].fix("x")
    for axis in (0, 1):
        normal = np.eye(3)[axis]
        scene.add(lm.wall(point=(0, 0, 0), normal=normal))
        scene.add(lm.wall(point=width * normal, normal=-normal))
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1))).impose_velocity(z=lambda t: 2.0 * np.cos(60.0 * t))
    scene.add(lm.wall(point=(0, 0, width + 6.1), normal=(0, 0, -1), color="LID", mass=50.0)).impose_force(z=-3e3)
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.4))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.2))
    scene.see("LID", "GRAIN", lm.Restitution(friction=0.1, restitution=0.3))
    scene.chain(spheres[10:14], lm.RigidWire())
    scene.chain(spheres[60:64], lm.ElasticWire(stiffness=1e3))
    return scene


def all_of(sim):
    """What a step leaves, as bytes."""
    net = sim.interactions
    arrays = sim.positions, sim.velocities, sim.spins, net.candidate, net.antagonist, net.gap, net.impulse
    report = sim.report
    told = (sim.energy, report.iterations, report.residual, report.worst)
    return (*(np.ascontiguousarray(array).tobytes() for array in arrays), repr(told))


SOLVERS = {
    "plain": lm.GaussSeidel(tolerance=1e-4, max_iterations=80),
    "momentum": lm.AcceleratedGaussSeidel(tolerance=1e-4, max_iterations=80),
}


@pytest.mark.long
@pytest.mark.parametrize("solver", list(SOLVERS))
@pytest.mark.parametrize("make", [box_of_spheres, mixed_scene])
@pytest.mark.usefixtures("partition_small_scenes")
def test_any_number_of_threads_gives_the_same_bits(make, solver):
    """Step by step, in 2D and 3D, with walls that are held, driven and loaded, wires, and bodies held and out of size;
    three times with two threads, as a race need not show at once."""

    def start(threads):
        options = {"solver": SOLVERS[solver], "on_unconverged": "ignore", "overlap": "ignore"}
        return lm.Simulation(make(), time_step=2e-3, threads=threads, **options)

    sims = [start(threads) for threads in (1, 2, 3, 2, 2)]
    for _ in range(40):
        for sim in sims:
            sim.step()
        expected = all_of(sims[0])
        assert all(all_of(sim) == expected for sim in sims[1:])
    table = sims[0].last_step.problem.groups
    assert len(table.phase) - 1 >= 3  # wires, even slabs, odd slabs, the rest
    assert len(table.task) - 1 >= 6
    assert sims[0]._detector.rebuilds > 2


@pytest.mark.long
@pytest.mark.usefixtures("partition_small_scenes")
def test_two_simulations_in_two_threads_of_python_do_not_meet():
    """Each has helpers of its own."""

    def start():
        return lm.Simulation(box_of_spheres(), time_step=2e-3, threads=2, solver=SOLVERS["plain"], overlap="ignore")

    before = set(threading.enumerate())  # the progress bar of another test may have left one
    alone, *both = (start() for _ in range(3))
    for sim in (alone, *both):
        sim.on_unconverged = "ignore"
    alone.run(steps=30)
    runs = [threading.Thread(target=sim.run, kwargs={"steps": 30}) for sim in both]
    for run in runs:
        run.start()
    for run in runs:
        run.join()
    assert all(all_of(sim) == all_of(alone) for sim in both)
    assert set(threading.enumerate()) <= before


@pytest.mark.long
@pytest.mark.usefixtures("partition_small_scenes")
def test_a_partitioned_run_goes_on_from_a_checkpoint_bit_for_bit():
    """Slabs are those of the last list, which a checkpoint makes again; with another number of threads."""
    whole, first, second = (
        lm.Simulation(box_of_spheres(), time_step=2e-3, threads=n, on_unconverged="ignore", overlap="ignore")
        for n in (1, 2, 3)
    )
    whole.run(steps=50)
    first.run(steps=23)
    second.restore(first.checkpoint())
    second.run(steps=27)
    assert all_of(second)[:-1] == all_of(whole)[:-1]


def test_slabs_solve_the_same_problem():
    """One step solved to a tight tolerance by ids and by slabs: velocities agree, as they are unique."""
    solver = lm.AcceleratedGaussSeidel(tolerance=1e-11, max_iterations=100_000)

    def step():
        sim = lm.Simulation(box_of_spheres(), time_step=2e-3, solver=lm.GaussSeidel(tolerance=1e-3), overlap="ignore")
        sim.on_unconverged = "ignore"
        return sim

    by_ids = step().run(steps=10)
    with partition_from(20):
        by_slabs = step()
    by_slabs.restore(by_ids.checkpoint())
    for sim in (by_ids, by_slabs):
        sim.solver = solver
        sim.step()
        assert sim.report.status == "converged"
    assert len(by_slabs.last_step.problem.groups.task) > 4
    assert len(by_ids.last_step.problem.groups.task) == 2
    scale = np.abs(by_ids.velocities).max()
    assert by_slabs.velocities == pytest.approx(by_ids.velocities, abs=1e-7 * scale)
    assert by_slabs.energy.drives == pytest.approx(by_ids.energy.drives, rel=1e-6)


@pytest.mark.usefixtures("partition_small_scenes")
def test_tasks_that_are_done_side_by_side_write_to_no_body_twice():
    sim = lm.Simulation(box_of_spheres(), time_step=2e-3, on_unconverged="ignore", overlap="ignore").run(steps=20)
    problem = sim.last_step[0]
    table, system = problem.groups, problem.system
    seen = np.zeros(len(system.candidate), dtype=int)
    held = (system.inverse_mass == 0.0).all(axis=1)
    for first, last in zip(table.phase[:-1], table.phase[1:], strict=True):
        written = []
        for t in range(first, last):
            bodies = []
            for p in range(table.task[t], table.task[t + 1]):
                rows = slice(table.start[p], table.stop[p])
                seen[rows] += 1
                for side, ids in enumerate((system.candidate[rows], system.antagonist[rows])):
                    if table.walls[p] == side:
                        assert held[ids].all()
                    else:
                        bodies.append(ids)
            written.append(set(np.concatenate(bodies).tolist()))
        assert sum(map(len, written)) == len(set().union(*written))
    assert (seen == 1).all()


def test_slabs_are_of_about_equal_numbers_and_wide_enough():
    along = np.random.default_rng(0).normal(0.0, 3.0, 20_000)
    count, slab = cut_slabs(along, 0.2)
    assert 14 <= count <= 16  # one for 1250 points
    assert (np.diff(slab[np.argsort(along)]) >= 0).all()
    ends = [(along[slab == s].min(), along[slab == s].max()) for s in range(count)]
    bin_width = np.ptp(along) / 1024
    assert min(high - low for low, high in ends[:-1]) > 0.2 - 2.0 * bin_width
    assert np.bincount(slab).max() < 2 * 20_000 / count
    assert cut_slabs(np.zeros(5), 0.1)[0] == cut_slabs(np.linspace(0.0, 1.0, 9), 0.6)[0] == 1
