"""Steps that have no solution are told apart from steps that are not solved yet."""

import math

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.measure import stress

RADIUS = 0.1


def column(
    count=5, *, offset=0.0, mass_ratio=1.0, time_step=1e-3, speed=1e-3, dimension=2, rods=True, friction=0.4, law=None,
    solver=None,
):  # fmt: skip
    """A column of beads between a floor and a lid that comes down; every other bead is ``offset`` radii aside.

    With ``rods`` the beads are linked and do not touch; else they lie on each other."""
    scene = lm.Scene(dimension=dimension)
    bead = lm.disk if dimension == 2 else lm.sphere
    up = np.eye(dimension)[-1]
    spacing = 2.0 * RADIUS + (0.1 if rods else 0.0)
    rise = spacing if rods else math.sqrt(spacing**2 - (offset * RADIUS) ** 2)
    beads = []
    for k in range(count):
        position = (RADIUS + k * rise) * up
        position[0] = offset * RADIUS * (k % 2)
        beads.append(scene.add(bead(radius=RADIUS, position=position, mass=mass_ratio if k == 1 else 1.0)))
    scene.add(lm.wall(point=0.0 * up, normal=up))
    lid = scene.add(lm.wall(point=(2.0 * RADIUS + (count - 1) * rise) * up, normal=-up, mass=1.0))
    lid.impose_velocity(**{"xyz"[dimension - 1]: -speed})
    for other in ("GRAIN", "WALL"):
        scene.see("GRAIN", other, lm.Coulomb(friction=friction))
    if rods:
        scene.chain(beads, lm.RigidRod() if law is None else law)
    solver = lm.AcceleratedGaussSeidel(tolerance=1e-6, max_iterations=3000) if solver is None else solver
    return lm.Simulation(scene, time_step=time_step, solver=solver, on_unconverged="ignore", overlap="ignore")


@pytest.mark.parametrize(
    "options",
    [
        {},
        {"rods": False},
        {"count": 2},
        {"count": 12},
        {"time_step": 1e-5},
        {"time_step": 1e-1, "speed": 1e-1},
        {"mass_ratio": 1e4},
        {"mass_ratio": 1e-4},
        {"speed": 1e-7},
        {"friction": 0.0},
        {"dimension": 3},
        {"solver": lm.Auto(max_iterations=3000)},
    ],
    ids=str,
)
def test_a_straight_column_is_locked_at_any_step_mass_and_speed(options):
    """Beads one above the other between floor and lid: the same impulse in every contact and link is in balance."""
    sim = column(**options)
    count = options.get("count", 5)
    report = sim.step()
    assert report.status == "locked"
    assert not report.solved
    assert sim.unconverged_steps == 1
    assert report.lock.driven == (count + 1,)
    assert report.lock.held == tuple(range(count + 1))
    assert report.lock.motion > 100.0
    assert f"locked: no motion of body {count + 1} is compatible with the constraints on bodies 0, 1, " in str(report)


@pytest.mark.parametrize(
    "options",
    [
        {"offset": 0.01, "count": 3},
        {"offset": 0.2},
        {"offset": 0.2, "mass_ratio": 1e3},
        {"offset": 0.01, "count": 9},
        {"law": lm.RigidWire()},
        {"law": lm.ElasticRod(axial_rigidity=1e6)},
        {"law": lm.ElasticRod(axial_rigidity=1e9)},
        {"speed": 0.0},
        {"speed": -1e-3},
    ],
    ids=str,
)
def test_a_column_that_can_move_is_not(options):
    """It gives way sideways, however little it is off its line; its wire is slack; its rods are elastic; the lid rises."""
    report = column(**options).step()
    assert report.status != "locked"
    assert report.lock is None


def test_too_few_sweeps_tell_nothing():
    """After 50 sweeps nobody can know that impulses grow without end."""
    report = column(solver=lm.GaussSeidel(tolerance=1e-6, max_iterations=50)).step()
    assert report.status == "budget spent"


def test_a_wedge_is_locked_by_friction_alone():
    """A disk between two walls that come together at 2 x 20 degrees slips out if mu < tan 20 = 0.364, else it is held."""
    for friction, status in ((0.3, "converged"), (0.5, "locked")):
        scene = lm.Scene(dimension=2)
        scene.add(lm.disk(radius=RADIUS, position=(0.0, 0.0), mass=1.0))
        for side in (-1.0, 1.0):
            normal = (-side * math.cos(math.radians(20.0)), math.sin(math.radians(20.0)))
            point = tuple(-RADIUS * c for c in normal)
            scene.add(lm.wall(point=point, normal=normal, mass=1.0)).impose_velocity(x=-side * 1e-3)
        scene.see("GRAIN", "WALL", lm.Coulomb(friction=friction))
        solver = lm.AcceleratedGaussSeidel(tolerance=1e-8, max_iterations=5000)
        report = lm.Simulation(scene, time_step=1e-3, solver=solver, on_unconverged="ignore").step()
        assert report.status == status, friction


def test_a_law_whose_conic_form_fails_is_not_examined():
    """The step was made by sweeps, which do not ask for it."""

    class NoForm(lm.RigidRod):
        NAME = "no-form"

        @staticmethod
        def conic(prepared):
            raise RuntimeError("no form today")

    report = column(law=NoForm()).step()
    assert report.status in ("budget spent", "stagnated")


def test_a_run_that_stops_at_unsolved_steps_says_what_is_locked():
    sim = column()
    sim.on_unconverged = "stop"
    with pytest.raises(RuntimeError, match="was not solved: locked: no motion of body 6 is compatible"):
        sim.run(steps=3)


def test_a_locked_step_is_kept_as_one_in_a_run_file(tmp_path):
    sim = column().run(steps=2, record=tmp_path / "run.h5")
    assert stress(sim, volume=1.0)["rigid-rod"][1, 1] < 0.0  # traction positive: the rods are pressed
    with lm.io.open_run(tmp_path / "run.h5") as run:
        assert run.status.tolist() == ["locked", "locked"]
        assert run.unconverged_steps == 2


def drawn(law, *, dimension=2, solver=None, closed=False, bend=0.0):
    """A chain between two posts that is drawn to 0.999 of its length; ``bend``: every other bead is so far aside [m]."""
    scene = lm.Scene(dimension=dimension)
    bead = lm.disk if dimension == 2 else lm.sphere
    places = [(0.01 * i, bend * (i % 2)) for i in range(11)]
    if closed:  # back on a lower line; the chain begins in the middle of the upper one
        places += [(0.01 * i, -0.05) for i in range(10, -1, -1)]
        places = places[5:] + places[:5]
    for x, y in places:
        position = (x, y) if dimension == 2 else (x, 0.3 * y, y)
        scene.add(bead(radius=0.002, position=position, mass=0.01))
        if x in (0.0, 0.1):
            scene.bodies[-1].fix()
    ring = np.array([body.position for body in (*scene.bodies, *scene.bodies[:closed])])
    gaps = 0.999 * np.linalg.norm(np.diff(ring, axis=0), axis=1) - 0.004
    scene.chain(scene.bodies, law, reference_gap=gaps, relaxation=0.01, closed=closed)
    return lm.Simulation(scene, time_step=1e-3, solver=solver or lm.GaussSeidel(), on_unconverged="ignore")


@pytest.mark.default_parameters("GaussSeidel-2-RigidRod()-False")
@pytest.mark.parametrize("closed", [False, True])
@pytest.mark.parametrize("law", [lm.RigidRod(), lm.RigidWire()], ids=repr)
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize(
    "solver", [lm.GaussSeidel(), lm.AcceleratedGaussSeidel(), lm.Auto(), lm.Newton()], ids=lambda s: type(s).__name__
)
def test_a_chain_without_a_finite_tension_is_named(solver, dimension, law, closed):
    """Links that are drawn shorter between two posts: no motion and no tension makes them so. No step counts as solved,
    not even if impulses are so large that in ``u - w r`` nothing is left of u."""
    sim = drawn(law, dimension=dimension, solver=solver, closed=closed)
    sim.step()  # not yet drawn in its middle
    for _ in range(3):
        report = sim.step()
        assert report.status == "locked"
        assert not report.lock.driven
        first, last = report.lock.chain
        ends = np.array([sim.positions[first], sim.positions[last]])
        assert sorted(ends[:, 0]) == [0.0, 0.1]
        assert ends[0, -1] == ends[1, -1]
        assert f"no finite tension: the chain from body {first} to body {last} is straight" in str(report)


@pytest.mark.filterwarnings("ignore:Until t")  # stiff rods in a coarse step
@pytest.mark.parametrize(
    ("law", "bend"), [(lm.ElasticRod(stiffness=1e6), 0.0), (lm.RigidRod(), 1e-3), (lm.RigidWire(), 1e-3)], ids=repr
)
def test_a_chain_that_is_elastic_or_gives_way_is_not(law, bend):
    """Beads 1 mm off their line, on links of 10 mm, come into it as they are drawn by 0.1 %."""
    sim = drawn(law, bend=bend)
    for _ in range(15):
        assert sim.step().status == "converged"


@pytest.mark.parametrize("held", [False, True])
def test_a_taut_string_of_springs_is_not_solved_yet_but_never_locked(held):
    """Beads on a string of 10 N, free or held along it, in a step of 50 ms that is longer than its period: single updates
    spend their budget. (The energy that springs store passed for motion, and bodies held along x for bodies without mass.)
    """
    scene = lm.Scene(dimension=2, gravity=(0.0, 0.0))
    for i in range(13):
        bead = scene.add(lm.disk(radius=0.005, position=(i / 12, 0.0), mass=0.01, velocity=(0.0, 1e-3 * (i == 4))))
        if i in (0, 12):
            bead.fix()
        elif held:
            bead.fix("x")
    scene.chain(scene.bodies, lm.ElasticWire(stiffness=1e4), reference_gap=1 / 12 - 0.01 - 1e-3)
    solver = lm.GaussSeidel(wire_blocks=False, tolerance=1e-12, max_iterations=2000)
    sim = lm.Simulation(scene, time_step=0.05, solver=solver, on_unconverged="ignore")
    sim.step()
    assert sim.report.status == ("round-off" if held else "budget spent")
    assert sim.report.lock is None
