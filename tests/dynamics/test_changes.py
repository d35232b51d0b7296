"""Scenes that change between steps, and gravity that changes with time."""

from __future__ import annotations

import math

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.dynamics.changes import Counts, from_rows
from lmgcpy.scene.cell import Edge

G = 9.81


def silo(count=30, seed=0):
    """Grains on a gate between two walls; returns the scene and the gate, which is a wall, above a floor 2 m below."""
    rng = np.random.default_rng(seed)
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    for i in range(count):
        position = (0.15 + 0.3 * (i % 5) + rng.uniform(-0.04, 0.04), 0.12 + 0.24 * (i // 5))
        scene.add(lm.disk(radius=0.1, position=position, mass=rng.uniform(1.0, 2.0)))
    for point, normal in (((0.0, 0.0), (1.0, 0.0)), ((1.5, 0.0), (-1.0, 0.0)), ((0.0, -2.0), (0.0, 1.0))):
        scene.add(lm.wall(point=point, normal=normal))
    gate = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    return scene, gate


def simulate(scene, time_step=2e-3, **options):
    return lm.Simulation(scene, time_step=time_step, solver=lm.GaussSeidel(tolerance=1e-6), **options)


def works_close(sim):
    """Whether the energy identity of the step closed to round-off of its terms."""
    energy = sim.energy
    terms = energy.kinetic + abs(energy.loads) + abs(energy.drives) + sum(map(abs, energy.interactions.values()))
    return abs(energy.defect) <= 1e-12 * (terms + 1e-3)


# ------------------------------------------------------------------------------------------------------------- hiding


@pytest.mark.parametrize("dimension", [2, 3])
def test_what_loses_its_support_falls_freely(dimension):
    """A ball on another one that is fixed: from the step after that is hidden on it falls as if alone, to the bit."""
    up = (0.0,) * (dimension - 1)
    make = lm.disk if dimension == 2 else lm.sphere

    def scene(supported):
        scene = lm.Scene(dimension=dimension, gravity=(*up, -G))
        ball = scene.add(make(radius=0.1, position=(*up, 0.2), mass=1.0))
        support = scene.add(make(radius=0.1, position=(*up, 0.0 if supported else -9.0), mass=1.0)).fix()
        scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
        return scene, ball, support

    with_support, ball, support = scene(True)
    sim = simulate(with_support).run(steps=20)
    assert abs(ball.velocity[-1]) < 1e-9
    assert support.hide() is support
    assert support.hidden
    position, velocity = ball.position.copy(), ball.velocity.copy()
    sim.run(steps=30)
    assert len(sim.interactions) == 0
    alone, other, _ = scene(False)
    alone.bodies[0]._block[alone.bodies[0]._row, [dimension - 1, *((3 + dimension - 1,))]] = position[-1], velocity[-1]
    simulate(alone).run(steps=30)
    assert np.allclose(ball.position, other.position, rtol=0, atol=1e-14)
    assert works_close(sim)


def test_a_silo_empties_when_its_gate_is_hidden_and_not_before():
    scene, gate = silo()
    sim = simulate(scene, on_unconverged="ignore").run(steps=150)
    grains = sim.positions[:30, 1]
    assert grains.min() > 0.09
    gate.hide()
    sim.run(steps=400)
    assert grains.max() < 0.0
    assert grains.min() > -2.0
    assert sim.unconverged_steps == 0


def test_a_shown_gate_bears_again():
    """Grains that fell through stay below: an old penetration is left alone."""
    scene, gate = silo()
    gate.hide()
    sim = simulate(scene).run(steps=50)
    fallen = sim.positions[:30, 1] < -0.1
    gate.show()
    assert not gate.hidden
    sim.run(steps=5)
    assert gate.id in sim.interactions.antagonist
    assert (sim.positions[:30, 1][fallen] < -0.1).all()


def test_a_hidden_body_stays_where_it_is_and_counts_nowhere():
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    one, other = (scene.add(lm.disk(radius=0.1, position=(x, 0.0), mass=1.0, velocity=(1.0, 0.0))) for x in (0.0, 1.0))
    other.hide()
    sim = simulate(scene).run(steps=100)
    assert other.position.tolist() == [1.0, 0.0]
    assert other.velocity.tolist() == [0.0, 0.0]
    assert sim.energy.kinetic == pytest.approx(0.5 * (one.velocity**2).sum())
    assert sim.energy.total_loads == pytest.approx(-G * one.position[1], rel=1e-12)
    other.show()
    sim.run(steps=1)
    assert other.velocity == pytest.approx([0.0, -G * sim.time_step])


def test_a_bead_cannot_be_hidden():
    scene = lm.Scene(dimension=2)
    beads = [scene.add(lm.disk(radius=0.1, position=(x, 0.0), mass=1.0)) for x in (0.0, 0.5)]
    scene.chain(beads, lm.RigidWire())
    sim = simulate(scene).run(steps=1)
    with pytest.raises(ValueError, match="linked in a chain, which would be cut"):
        beads[0].hide()
    sim.run(steps=1)
    assert not beads[0].hidden


def test_a_bead_hidden_from_the_start_is_refused():
    scene = lm.Scene(dimension=2)
    beads = [scene.add(lm.disk(radius=0.1, position=(x, 0.0), mass=1.0)) for x in (0.0, 0.5)]
    scene.chain(beads, lm.RigidWire())
    beads[1].hide()
    with pytest.raises(ValueError, match="hidden, but it is linked in a chain"):
        simulate(scene)


# --------------------------------------------------------------------------------------------------------- conditions


def test_conditions_replace_one_another_between_steps():
    """A disk of 2 kg without gravity: pushed by 4 N, driven at 3 m/s, let go, held."""
    scene = lm.Scene(dimension=2)
    disk = scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=2.0))
    sim = simulate(scene, time_step=0.1)
    disk.impose_force(x=4.0)
    assert sim.run(steps=5).velocities[0, 0] == pytest.approx(1.0)
    disk.impose_velocity(x=3.0)
    assert sim.run(steps=2).velocities[0, 0] == 3.0
    assert works_close(sim)
    disk.free("x")
    assert sim.run(steps=2).velocities[0, 0] == 3.0
    disk.fix()
    assert sim.run(steps=1).velocities[0].tolist() == [0.0, 0.0]
    disk.free()
    disk.impose_force(x=-2.0)
    assert sim.run(steps=1).velocities[0, 0] == pytest.approx(-0.1)
    assert works_close(sim)


def test_a_wall_is_loaded_and_freed_between_steps():
    """A wall of 4 kg, held, is pushed by 8 N for a second, then let go."""
    scene = lm.Scene(dimension=2)
    wall = scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0), mass=4.0))
    scene.add(lm.disk(radius=0.1, position=(0.0, 5.0), mass=1.0))
    sim = simulate(scene, time_step=0.1).run(steps=3)
    assert wall.velocity.tolist() == [0.0, 0.0]
    wall.impose_force(y=8.0)
    sim.run(steps=10)
    assert wall.velocity[1] == pytest.approx(2.0)
    wall.free("y")
    sim.run(steps=10)
    assert wall.velocity[1] == pytest.approx(2.0)
    massless = lm.Scene(dimension=2)
    wall = massless.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    simulate(massless)
    with pytest.raises(ValueError, match="has no mass"):
        wall.free("y")


def test_the_block_of_a_wire_knows_which_bead_is_held_now():
    """A hanging wire whose hook is let go falls as a whole; held in its middle it hangs from there."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    beads = [scene.add(lm.disk(radius=0.05, position=(0.0, -0.5 * i), mass=1.0)) for i in range(5)]
    beads[0].fix()
    scene.chain(beads, lm.RigidWire())
    sim = simulate(scene).run(steps=5)
    assert -sim.interactions.force[:, 0] == pytest.approx([40.0, 30.0, 20.0, 10.0], rel=1e-9)
    beads[0].free()
    sim.run(steps=5)
    assert sim.interactions.force[:, 0] == pytest.approx(np.zeros(4), abs=1e-9)
    beads[2].fix()
    beads[0].fix()
    sim.run(steps=2)
    assert -sim.interactions.force[2:, 0] == pytest.approx([20.0, 10.0], rel=1e-6)
    assert sim.report.solved


# ------------------------------------------------------------------------------------------------------------- gravity


@pytest.mark.long
@pytest.mark.parametrize("friction", [0.2, 0.5, 0.8])
def test_a_tilted_block_slides_from_the_angle_of_friction_on(friction):
    """Gravity turns by 0.5 rad/s; a cluster of two disks, which does not roll, holds up to tan(angle) = friction."""
    rate, h = 0.5, 2e-3
    angle = math.atan(friction)

    def gravity(time):
        return (G * math.sin(rate * time), -G * math.cos(rate * time))

    scene = lm.Scene(dimension=2, gravity=gravity)
    feet = [(lm.DiskContactor(0.05), (-0.5, 0.0)), (lm.DiskContactor(0.05), (0.5, 0.0))]
    block = scene.add(lm.RigidBody(feet, mass=1.0, inertia=0.1, position=(0.0, 0.05), color="BLOCK"))
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    scene.see("BLOCK", "WALL", lm.Coulomb(friction=friction))
    sim = lm.Simulation(scene, time_step=h, solver=lm.GaussSeidel(tolerance=1e-10))
    sim.run(duration=angle / rate - 5 * h)
    assert abs(block.velocity[0]) < 1e-9
    sim.run(duration=0.2)
    # beyond it: a = g (sin a - mu cos a), with a = angle + rate t
    t = sim.time - angle / rate
    expected = G * (
        math.cos(angle) - math.cos(angle + rate * t) - friction * (math.sin(angle + rate * t) - math.sin(angle))
    )
    assert block.velocity[0] == pytest.approx(expected / rate, rel=0.02)  # of 0.2 s, in steps of 2 ms
    assert works_close(sim)


def test_shaking_is_taken_at_the_middle_of_the_step():
    """A free body under g cos(w t): v = (g/w) sin(w t), with an error of second order, (w h)^2/24."""
    w, errors = 2.0, []
    for count in (50, 100):
        scene = lm.Scene(dimension=3, gravity=lambda time: (0.0, 3.0 * math.cos(w * time), 0.0))
        ball = scene.add(lm.sphere(radius=0.1, position=(0.0, 0.0, 0.0), mass=2.0))
        sim = simulate(scene, time_step=1.0 / count).run(steps=count)
        errors.append(abs(ball.velocity[1] / (1.5 * math.sin(w)) - 1.0))
        assert works_close(sim)
    assert errors[0] == pytest.approx((w / 50) ** 2 / 24.0, rel=0.01)
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.01)


def test_gravity_set_between_steps_acts_from_the_next_on():
    scene = lm.Scene(dimension=2, gravity=(0.0, -1.0))
    ball = scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=2.0))
    sim = simulate(scene, time_step=0.5).run(steps=2)
    scene.gravity = (3.0, 0.0)
    sim.run(steps=2)
    assert ball.velocity == pytest.approx([3.0, -1.0])


@pytest.mark.parametrize(
    ("gravity", "error", "words"),
    [
        (lambda time: (0.0,), FloatingPointError, r"What is gravity\(t = 0.001 s\) must be 2 numbers"),
        (lambda time: "down", TypeError, r"What is gravity\(t = 0.001 s\)"),
        (lambda time: (0.0, math.nan), FloatingPointError, "finite"),
        (lambda time: 1 / 0, RuntimeError, r"gravity\(t = 0.001 s\) failed with ZeroDivisionError"),
    ],
)
def test_a_wrong_function_of_gravity_stops_the_step(gravity, error, words):
    scene = lm.Scene(dimension=2, gravity=gravity)
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=2.0))
    sim = simulate(scene)
    with pytest.raises(error, match=words):
        sim.step()
    assert sim.steps == 0
    assert sim.time == 0.0


# ------------------------------------------------------------------------------------------- checkpoints and run files


def changing(sim):
    """Statements at certain steps."""
    bodies, scene = sim.scene.bodies, sim.scene
    statements = {
        20: lambda: bodies[33].hide(),
        30: lambda: bodies[0].fix("x", "spin"),
        40: lambda: bodies[33].show(),
        45: lambda: setattr(scene, "gravity", (2.0, -G)),
        50: lambda: bodies[0].free(),
        55: lambda: bodies[1].impose_force(x=3.0),
    }
    statements.get(sim.steps, lambda: None)()


def same(one, other):
    assert one.steps == other.steps
    assert np.array_equal(one.positions, other.positions)
    assert np.array_equal(one.velocities, other.velocities)
    assert np.array_equal(one.interactions.impulse, other.interactions.impulse)
    assert vars(one.energy) == vars(other.energy)


def test_a_restored_simulation_goes_through_the_statements(tmp_path):
    """From checkpoints before, between and after them; going back undoes those that come later."""
    sim = simulate(silo()[0])
    checkpoints = {}
    sim.run(steps=70, on_step=lambda sim: (changing(sim), checkpoints.__setitem__(sim.steps, sim.checkpoint())))
    for other in (simulate(silo()[0]), sim):
        for step in (60, 10, 42, 20):
            whole = (sim.positions.copy(), sim.velocities.copy()) if step == 60 and other is not sim else None
            other.restore(checkpoints[step])
            other.run(steps=70 - step, on_step=changing)
            if whole is not None:
                assert np.array_equal(other.positions, whole[0])
                assert np.array_equal(other.velocities, whole[1])
    same(sim, other)


@pytest.mark.default_parameters("57")
@pytest.mark.parametrize("first", [20, 21, 41, 57])
def test_a_run_that_goes_on_goes_through_the_statements(tmp_path, first):
    whole = simulate(silo()[0]).run(steps=70, on_step=changing)
    simulate(silo()[0]).run(steps=first, on_step=changing, record=tmp_path / "run.h5")
    again = lm.resume(tmp_path / "run.h5")
    again.run(steps=70 - first, on_step=changing)
    same(whole, again)
    assert [body.hidden for body in again.scene.bodies] == [body.hidden for body in whole.scene.bodies]


def test_statements_between_runs_of_a_resumed_file(tmp_path):
    """Without on_step: the gate is hidden between two runs, and the file is gone on with twice."""
    scene, gate = silo()
    whole = simulate(scene).run(steps=30)
    gate.hide()
    whole.run(steps=40)
    simulate(silo()[0]).run(steps=30, record=tmp_path / "run.h5")
    sim = lm.resume(tmp_path / "run.h5")
    sim.scene.bodies[33].hide()
    sim.run(steps=15)
    same(whole, lm.resume(tmp_path / "run.h5").run(steps=25))


def test_gravity_as_a_function_is_asked_for_again(tmp_path):
    def gravity(time):
        return (math.sin(time), -G)

    def scene():
        scene = lm.Scene(dimension=2, gravity=gravity)
        scene.add(lm.disk(radius=0.1, position=(0.0, 1.0), mass=1.0)).impose_velocity(spin=lambda time: time)
        return scene

    whole = simulate(scene()).run(steps=20)
    simulate(scene()).run(steps=8, record=tmp_path / "run.h5")
    with pytest.raises(ValueError, match=r'functions=\{"gravity": f, \(0, "spin"\): f\}'):
        lm.resume(tmp_path / "run.h5")
    with pytest.raises(TypeError, match=r"functions\['gravity'\] must be a function of time"):
        lm.resume(tmp_path / "run.h5", functions={"gravity": (0.0, 1.0), (0, "spin"): lambda time: time})
    again = lm.resume(tmp_path / "run.h5", functions={"gravity": gravity, (0, "spin"): lambda time: time})
    assert np.array_equal(again.run(steps=12).positions, whole.positions)


@pytest.mark.parametrize(
    "rows",
    [
        [[0.0, 10.0, 0.0, 0.0, 1.0]],
        [[0.0, 7.0, 0.0, 1.0, 1.0]],  # a parameter of a law that no statement gives
        [[0.0, 7.0, 0.0, -1.0, 0.0], [0.0, 7.0, 0.0, 2.0, 1.0]],  # the one law of contacts has two parameters
        [[0.0, 7.0, 0.0, -1.0, 0.0], [0.0, 7.0, 0.0, 1.0, 1.0], [0.0, 7.0, 0.0, 0.0, 1.0]],
        [[0.0, 7.0, 0.0, -1.0, 0.0], [1.0, 7.0, 0.0, 0.0, 1.0]],
        [[0.0, 7.0, 1.0, -1.0, 0.0]],
        [[0.0, 8.0, 0.0, -1.0, 0.0], [0.0, 8.0, 0.0, 0.0, 1.0]],
        [[0.0, 9.0, 0.0, 3.0, 1.0]],
        [[0.0, 6.0, 1.0, 0.0, 1.0]],  # the one chain is number 0, and has three links
        [[0.0, 6.0, 0.0, 3.0, 1.0]],
        [[0.0, 6.0, 0.0, -2.0, 1.0]],
        [[0.0, 0.0, 7.0, 0.0, 1.0]],
        [[0.0, 0.0, 0.0, 3.0, 1.0]],
        [[0.5, 0.0, 0.0, 0.0, 1.0]],
        [[0.0, 0.0, 0.0, 0.0, math.nan]],
        [[4.0, 3.0, 0.0, -1.0, 0.0], [3.0, 4.0, 0.0, -1.0, 0.0]],
        [[-1.0, 3.0, 0.0, -1.0, 0.0]],
        [[0.0, 5.0, -1.0, 2.0, 1.0]],
        [0.0, 1.0],
    ],
)
def test_damaged_statements_get_a_sentence(rows):
    with pytest.raises(ValueError, match="statement"):
        from_rows(np.array(rows), Counts(7, 2, [3], [2], [0]))


# ---------------------------------------------------------------------------------------------------- a prepared sample


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    """The run file of a silo at rest, with a wire in it, its gate hidden and shown on the way."""
    path = tmp_path_factory.mktemp("silo") / "silo.h5"
    scene, _ = silo()
    scene.chain(scene.bodies[:5], lm.RigidWire())
    sim = simulate(scene)
    sim.run(steps=100, record=path, every=25, on_step=lambda sim: changing(sim) if sim.steps < 45 else None)
    return path, sim.positions.copy(), sim.velocities.copy()


def test_a_sample_that_is_prepared_once_is_tested_again_and_again(prepared):
    path, positions, velocities = prepared
    ends = []
    for _ in range(2):
        scene = lm.Scene.from_run(path)
        assert np.array_equal([body.position for body in scene.bodies], positions)
        assert np.array_equal([body.velocity for body in scene.bodies], velocities)
        ball = scene.add(lm.disk(radius=0.3, position=(0.7, 4.0), mass=9.0, velocity=(0.0, -3.0)))
        # grains have sunk into the gate while it was hidden
        sim = simulate(scene, overlap="ignore").run(steps=60)
        assert sim.unconverged_steps == 0
        assert ball.position[1] < 4.0
        ends.append(sim.positions.copy())
    assert np.array_equal(*ends)
    assert len(scene.chains) == 1


def test_a_scene_of_an_earlier_step(prepared):
    """After step 25 the gate was hidden, and disk 0 still free; after step 50 the gate was there again."""
    path, _, _ = prepared
    for step, hidden in ((0, False), (25, True), (50, False)):
        scene = lm.Scene.from_run(path, step)
        assert scene.bodies[33].hidden == hidden
    with lm.io.open_run(path) as run:
        assert np.array_equal([body.position for body in lm.Scene.from_run(path, 25).bodies], run.positions[1])
    with pytest.raises(ValueError, match="has no frame of step 30; the nearest are of 25 and 50"):
        lm.Scene.from_run(path, 30)
    with pytest.raises(ValueError, match="step must be at least 0"):
        lm.Scene.from_run(path, -1)
    with pytest.raises(FileNotFoundError):
        lm.Scene.from_run(path.parent / "nothing.h5")


# --------------------------------------------------------------------------------------------------- on_step and options


def test_an_error_in_on_step_ends_the_run_with_a_complete_file(tmp_path):
    def fail(sim):
        if sim.steps == 7:
            raise KeyError("mine")

    with pytest.raises(KeyError, match="mine"):
        simulate(silo()[0]).run(steps=20, on_step=fail, record=tmp_path / "run.h5")
    with lm.io.open_run(tmp_path / "run.h5") as run:
        assert len(run.history) == 6
    assert lm.resume(tmp_path / "run.h5").run(steps=3).steps >= 3


def test_time_step_and_solver_change_between_steps_but_not_in_a_file(tmp_path):
    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    ball = scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0))
    sim = simulate(scene, time_step=0.1).run(steps=5)
    sim.time_step = 0.01
    sim.solver = lm.GaussSeidel(tolerance=1e-3)
    sim.run(steps=50)
    assert sim.time == pytest.approx(1.0)
    assert ball.velocity[1] == pytest.approx(-10.0)
    with pytest.raises(ValueError, match="time_step must be above 0"):
        sim.time_step = -1.0
    with pytest.raises(TypeError, match="solver"):
        sim.solver = "newton"
    with pytest.raises(RuntimeError, match="time_step cannot change in a run that is recorded"):
        sim.run(steps=2, record=tmp_path / "run.h5", on_step=lambda sim: setattr(sim, "time_step", 0.1))
    again = lm.resume(tmp_path / "run.h5")
    for name, value in [("solver", lm.GaussSeidel()), ("theta", 1.0), ("geometric_stiffness", False)]:
        with pytest.raises(RuntimeError, match=f"{name} cannot change"):
            setattr(again, name, value)


@pytest.mark.parametrize(
    ("name", "value", "error", "words"),
    [
        ("theta", 0.4, ValueError, r"theta must be at least 0.5"),
        ("theta", "implicit", TypeError, "theta must be a number"),
        ("on_unconverged", "wrn", ValueError, "on_unconverged cannot be 'wrn'; did you mean 'warn'"),
        ("geometric_stiffness", 2, TypeError, "geometric_stiffness"),
        ("timestep", 1e-3, AttributeError, "A simulation has no 'timestep' that could be set; did you mean 'time_step'"),
        ("gravity", (0.0, -1.0), AttributeError, "A simulation has no 'gravity' that could be set"),
    ],
)
def test_what_is_set_wrongly_gets_a_sentence(name, value, error, words):
    """A name that a simulation does not have was taken without a word, and changed nothing."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0))
    sim = simulate(scene)
    with pytest.raises(error, match=words):
        setattr(sim, name, value)
    assert (sim.theta, sim.on_unconverged, sim.geometric_stiffness) == (0.5, "warn", True)


def test_a_class_of_ones_own_has_attributes_of_its_own():
    class Labelled(lm.Simulation):
        pass

    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0))
    sim = Labelled(scene, time_step=1.0)
    sim.label = "first"
    sim.theta = 1.0
    assert sim.run(steps=1).label == "first"


def test_theta_acts_from_the_next_step_on():
    """Free fall: x = -(1 - theta) h v- - theta h v+ in a step, with v+ = v- - g h."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    ball = scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0))
    sim = simulate(scene, time_step=0.1).run(steps=1)
    assert ball.position[1] == pytest.approx(-0.05)
    sim.theta = 1.0
    sim.step()
    assert ball.position[1] == pytest.approx(-0.05 - 0.2)


def test_functions_and_wrong_statements_between_steps_get_a_sentence():
    scene = lm.Scene(dimension=2)
    disk = scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0))
    sim = simulate(scene)
    with pytest.raises(RuntimeError, match="between steps takes numbers, which a run file keeps"):
        disk.impose_velocity(x=lambda time: 1.0)
    with pytest.raises(RuntimeError, match="Cannot make gravity a function of time"):
        scene.gravity = lambda time: (0.0, 0.0)
    with pytest.raises(ValueError, match="no component 'z'"):
        disk.free("z")
    with pytest.raises(TypeError, match="free takes names of components"):
        disk.free(1)
    with pytest.raises(TypeError, match="on_step must be a function"):
        sim.run(steps=1, on_step=3)
    assert sim.run(steps=1).positions[0].tolist() == [0.0, 0.0]


# ------------------------------------------------------------------------------------------------------------- adding


def heap(dimension, later):
    """Balls in a trough; returns the scene, and what is to come: two balls, one with a velocity, and a wall. With ``later``
    they are hidden from the start."""
    up = (0.0,) * (dimension - 1)
    make = lm.disk if dimension == 2 else lm.sphere
    scene = lm.Scene(dimension=dimension, gravity=(*up, -G))
    for normal in ((1.0, *up[1:], 1.0), (-1.0, *up[1:], 1.0)):
        scene.add(lm.wall(point=(0.0,) * dimension, normal=normal))
    for i in range(6):
        scene.add(make(radius=0.1 + 0.005 * i, position=(0.03 * (-1) ** i, *up[1:], 0.25 + 0.25 * i), mass=1.0 + 0.1 * i))
    velocity = (0.5, *up[1:], -1.0)
    coming = [
        make(radius=0.04, position=(0.3, *up[1:], 1.9), mass=0.3),
        make(radius=0.2, position=(-0.2, *up[1:], 2.2), mass=2.0, velocity=velocity),
        lm.wall(point=(0.4, *up), normal=(-1.0, *up), color="WALL"),
    ]
    for color in ("GRAIN", "WALL"):
        scene.see("GRAIN", color, lm.Coulomb(friction=0.3))
    if later:
        for body in coming:
            scene.add(body).hide()
    return scene, coming, velocity


@pytest.mark.default_parameters("2")
@pytest.mark.parametrize("dimension", [2, 3])
def test_what_is_added_is_what_was_hidden_until_then(dimension):
    """To the last bit: positions, velocities, impulses and energy, through lists of neighbours made anew."""
    runs = []
    for later in (True, False):
        scene, coming, velocity = heap(dimension, later)
        sim = simulate(scene, on_unconverged="ignore").run(steps=150)
        for body in coming:
            body.show() if later else scene.add(body)
        assert len(sim.positions) == 11
        assert coming[1].id == 9
        if later:
            sim.velocities[9] = velocity
        sim.run(steps=300)
        assert works_close(sim)
        assert sim.interactions.candidate.tolist()
        runs.append(sim)
    hidden, added = runs
    assert np.array_equal(hidden.positions, added.positions)
    assert np.array_equal(hidden.velocities, added.velocities)
    assert np.array_equal(hidden.interactions.impulse, added.interactions.impulse)
    assert hidden.energy.total_interactions == added.energy.total_interactions
    assert coming[0].position.tolist() == added.positions[8].tolist()


def test_added_with_a_velocity_it_flies_at_once():
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0))
    sim = simulate(scene, time_step=1e-3).run(steps=10)
    balls = scene.add_disks(0.1, [(1.0, 0.0), (2.0, 0.0)], masses=1.0, velocities=(0.0, 3.0))
    balls[1].impose_velocity(x=0.5)
    assert sim.positions.shape == (3, 2)
    sim.run(steps=100)  # theta = 1/2 is exact in free flight
    assert sim.positions[1] == pytest.approx((1.0, 0.3 - 0.5 * G * 0.01), abs=1e-12)
    assert balls[1].position[0] == pytest.approx(2.0 + 0.5 * (0.1 - 0.5e-3), abs=1e-12)  # half a step at rest


def test_grains_are_poured_in_a_run_and_recorded_afterwards(tmp_path):
    """Not into a run that is recorded; what is recorded after that goes on bit for bit, with a grain that came hidden."""
    scene, coming, _ = heap(2, later=False)
    sim = simulate(scene, on_unconverged="ignore")

    def pour(sim):
        if sim.steps in (40, 80):
            scene.add(coming[sim.steps // 40 - 1])

    with pytest.raises(RuntimeError, match="The number of bodies cannot change in a run that is recorded"):
        sim.run(steps=50, on_step=pour, record=tmp_path / "refused.h5")
    assert len(scene.bodies) == len(sim.positions) == 8
    assert coming[0].id == -1
    scene.add(coming[0])
    sim.run(steps=60, on_step=lambda sim: sim.steps == 80 and scene.add(coming[1]))
    scene.add(lm.disk(radius=0.1, position=(3.0, 3.0), mass=1.0).hide())
    sim.run(steps=20, record=tmp_path / "run.h5", every=5)
    again = lm.resume(tmp_path / "run.h5")
    assert again.scene.bodies[10].hidden
    again.scene.bodies[10].show()
    with pytest.raises(RuntimeError, match="The number of bodies cannot change"):
        again.scene.add(lm.disk(radius=0.1, position=(5.0, 3.0), mass=1.0))
    again.run(steps=30)
    scene.bodies[10].show()
    sim.run(steps=30)
    assert np.array_equal(again.positions, sim.positions)
    assert np.array_equal(again.velocities, sim.velocities)


def test_a_checkpoint_holds_what_was_added():
    scene, coming, _ = heap(2, later=False)
    sim = simulate(scene).run(steps=100)
    fewer = sim.checkpoint()
    scene.add(coming[1])
    kept = sim.checkpoint()
    after = sim.run(steps=50).positions.copy()
    sim.restore(kept)
    assert np.array_equal(sim.run(steps=50).positions, after)
    with pytest.raises(ValueError, match="give a checkpoint of this scene"):
        sim.restore(fewer)


def test_what_cannot_be_added_leaves_everything_as_it_was():
    class OfWalls(lm.Signorini):
        NAME = "of-walls-alone"
        PAIRS = frozenset({("disk", "wall")})

    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    scene.add(lm.disk(radius=0.1, position=(0.0, 0.2), mass=1.0))
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", OfWalls())
    sim = simulate(scene).run(steps=10)
    stone = lm.disk(radius=0.1, position=(1.0, 1.0), mass=1.0, color="WALL")
    with pytest.raises(ValueError, match="is for contacts disk-wall"):
        scene.add(stone)
    assert stone.id == -1
    assert len(scene.bodies) == 2
    assert sim.run(steps=10).positions.shape == (2, 2)


def test_what_is_added_into_others_is_told():
    scene, _, _ = heap(2, later=False)
    sim = simulate(scene).run(steps=10)
    scene.add(lm.disk(radius=0.1, position=scene.bodies[3].position + np.array([0.0, 0.15]), mass=1.0))
    with pytest.warns(RuntimeWarning, match="overlaps? with what was added by more than 5 %"):
        sim.run(steps=1)
    scene, _, _ = heap(2, later=False)
    sim = simulate(scene, overlap="stop").run(steps=10)
    wrong = lm.disk(radius=0.1, position=scene.bodies[3].position + np.array([0.05, 0.0]), mass=1.0)
    with pytest.raises(ValueError, match="with what was added"):
        scene.add(wrong)
    scene.add(wrong.hide())  # what is hidden overlaps nothing
    assert sim.run(steps=1).steps == 11


def in_a_cell():
    scene = lm.Scene(dimension=2)
    for i in range(3):
        scene.add(lm.disk(radius=0.1, position=(0.3 * i, 0.3), mass=1.0))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.periodic(x=1.0, y=1.0).impose_rate(xy=0.5)
    return scene


FAR, BIG = {"radius": 0.1, "position": (1e16, 0.1)}, {"radius": 0.4, "position": (0.5, 0.8)}
CANNOT_COME = {
    "too far": (lambda: heap(2, later=False)[0], lambda: lm.disk(mass=1.0, **FAR), ValueError, "from the origin"),
    "too far for a cell": (in_a_cell, lambda: lm.disk(mass=1.0, **FAR), ValueError, "from the origin"),
    "too big for a cell": (in_a_cell, lambda: lm.disk(mass=1.0, **BIG), ValueError, "wider than 1.6"),
    "too big, hidden": (in_a_cell, lambda: lm.disk(mass=1.0, **BIG).hide(), ValueError, "wider than 1.6"),
    "a wall across": (in_a_cell, lambda: lm.wall(point=(0, 0), normal=(0, 1)), ValueError, "cuts the faces"),
    "an edge": (in_a_cell, lambda: Edge(0, (1.0, 0.0)), TypeError, "Scene.periodic makes it"),
}


@pytest.mark.default_parameters("too far", "too big, hidden", "an edge")
@pytest.mark.parametrize("what", CANNOT_COME)
def test_what_a_simulation_could_not_go_on_with_is_refused_as_it_is_added(what):
    """And the steps after that are those of a scene in which nobody tried."""
    make, body, error, words = CANNOT_COME[what]
    scene, untried = make(), simulate(make()).run(steps=20)
    sim, count, made = simulate(scene).run(steps=10), len(scene.bodies), body()
    with pytest.raises(error, match=words):
        scene.add(made)
    assert made.id == -1
    assert len(scene.bodies) == count
    assert np.array_equal(sim.run(steps=10).state.positions, untried.state.positions)


class Dumbbell(lm.Body):
    """Two spheres off the centre of a body in 3D, as a stranger would write it."""

    dimension = 3
    mass = inertia = 1.0

    def __init__(self, offset, **start):
        super().__init__(**start)
        shape = lm.sphere(radius=0.1, position=(0, 0, 0), mass=1.0).contactors[0][0]
        self.contactors = [(shape, offset), (shape, tuple(-x for x in offset))]

    contactors = None


@pytest.mark.parametrize("later", [False, True])
def test_an_offset_has_as_many_numbers_as_the_scene_dimensions(later):
    scene = lm.Scene(dimension=3)
    scene.add(lm.sphere(radius=0.1, position=(0, 0, 0), mass=1.0))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    body = Dumbbell((0.1, 0.0), position=(1.0, 0.0, 0.0), color="GRAIN")
    if later:
        sim = simulate(scene).run(steps=1)
        with pytest.raises(ValueError, match="an offset is 3 numbers in 3D"):
            scene.add(body)
        assert sim.run(steps=1).steps == 2
        return
    scene.add(body)
    with pytest.raises(ValueError, match="an offset is 3 numbers in 3D"):
        simulate(scene)


@pytest.mark.long
def test_a_body_that_turns_joins_a_scene_of_spheres():
    """Positions get a rotation then; the scene is, bit for bit, the one in which the body was hidden until then."""
    runs = []
    for later in (True, False):
        scene = lm.Scene(dimension=3, gravity=(0, 0, -G))
        scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
        scene.add(lm.sphere(radius=0.1, position=(0, 0, 0.11), mass=1.0, spin=(1.0, 2.0, 3.0)))
        scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
        scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
        body = Dumbbell((0.0, 0.05, 0.1), position=(0.05, 0.0, 0.5), color="GRAIN", rotation=(0.5, 0.5, 0.5, 0.5))
        if not later:
            scene.add(body).hide()
        sim = simulate(scene, time_step=1e-3).run(steps=100)
        assert sim.state.positions.shape[1] == (3 if later else 7)
        if later:
            scene.add(body)
        body.show()
        runs.append(sim.run(steps=400).state)
    for name in ("positions", "velocities"):
        np.testing.assert_array_equal(getattr(runs[0], name), getattr(runs[1], name))
    assert 0.1 < runs[0].positions[2, 2] < 0.4  # it fell from 0.5 and lies on the sphere


def test_rigid_bodies_refuse_contactors_of_the_other_dimension():
    flat = lm.DiskContactor(0.1)
    with pytest.raises(ValueError, match="whose position has 3 numbers cannot be <DiskContactor"):
        lm.RigidBody([flat], mass=1.0, inertia=1.0, position=(0, 0, 0), color="A")
    with pytest.raises(ValueError, match="whose position has 2 numbers cannot be <SphereContactor"):
        lm.RigidBody([lm.SphereContactor(0.1)], mass=1.0, inertia=1.0, position=(0, 0), color="A")
    with pytest.raises(ValueError, match="2D"):
        lm.Scene(dimension=3).add(lm.RigidBody([flat], mass=1.0, inertia=1.0, position=(0, 0), color="A"))


@pytest.mark.long
@pytest.mark.parametrize("dimension", [2, 3])
def test_grains_fall_on_a_wire_with_a_law_that_rolls(dimension):
    """Chains, what the wire remembers, and rolling contacts: the bits of grains that were hidden until then."""
    up, make = (0.0,) * (dimension - 1), lm.disk if dimension == 2 else lm.sphere
    law = lm.RollingCoulomb(friction=0.3, rolling_friction=0.1)
    runs = []
    for later in (True, False):
        scene = lm.Scene(dimension=dimension, gravity=(*up, -G))
        scene.add(lm.wall(point=(0.0,) * dimension, normal=(*up, 1.0)))
        at = [(0.06 * i, *up[1:], 0.3) for i in range(12)]
        beads = [scene.add(make(radius=0.02, position=x, mass=0.1, color="BEAD")) for x in at]
        beads[0].fix()
        scene.chain(beads, lm.RigidWire(), block_spin=True)
        grains = [make(radius=0.05, position=(0.1 + 0.11 * i, *up[1:], 0.5), mass=1.0) for i in range(5)]
        scene.add(grains[0]).hide()
        for color in ("BEAD", "GRAIN", "WALL"):
            scene.see("GRAIN", color, law)
        scene.see("BEAD", "WALL", law)
        if later:
            for grain in grains[1:]:
                scene.add(grain).hide()
        sim = simulate(scene, time_step=1e-3, on_unconverged="ignore").run(steps=150)
        for grain in grains:
            scene.add(grain) if grain.id < 0 else grain.show()
        runs.append(sim.run(steps=150))
    assert np.array_equal(runs[0].positions, runs[1].positions)
    assert np.array_equal(runs[0].velocities, runs[1].velocities)
    assert runs[0].energy.total_interactions == runs[1].energy.total_interactions


@pytest.mark.long
def test_grains_are_added_to_a_periodic_cell():
    """Half of a gas of disks comes later, as its cell begins to shear: bit for bit as if hidden until then."""
    runs = []
    for later in (True, False):
        scene = lm.Scene(dimension=2)
        cell = scene.periodic(x=1.0, y=1.0)
        rng = np.random.default_rng(4)
        grid = np.array([(i / 8, j / 8) for i in range(8) for j in range(8)]) + 0.02
        disks = [lm.disk(radius=0.05, position=at, mass=1.0, velocity=0.2 * rng.normal(size=2)) for at in grid]
        scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
        for disk in disks[:32]:
            scene.add(disk)
        if later:
            for disk in disks[32:]:
                scene.add(disk).hide()
        sim = simulate(scene).run(steps=20)
        cell.impose_rate(xy=0.3)
        for disk in disks[32:]:
            disk.show() if later else scene.add(disk)
        sim.velocities[-32:] = 0.0
        runs.append(sim.run(steps=100))
    assert np.array_equal(runs[0].positions, runs[1].positions)
    assert len(runs[0].interactions.gap) > 20


@pytest.mark.long
def test_grains_come_one_by_one_from_the_mouth_of_a_hopper():
    """Bodies that come later are hidden from the start, all at one place: they touch nothing until they are shown. Three
    disks pile up on the floor, each on the one before."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    grains = [scene.add(lm.disk(radius=0.05, position=(0.0, 0.5), mass=1.0)).hide() for _ in range(3)]
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    sim = simulate(scene, time_step=2e-3)

    def feed(sim):
        if sim.steps % 200 == 0:
            grains[sim.steps // 200 - 1].show()

    sim.run(steps=799, on_step=feed)
    # the fall of 0.45 m takes 0.3 s; a shock ends within one step, h v = 6 mm, of the floor
    assert [grain.position[1] for grain in grains] == pytest.approx([0.05, 0.15, 0.25], abs=7e-3)
    assert abs(sim.velocities).max() < 1e-6


@pytest.mark.parametrize("statement", ["hide", "fix"])
def test_a_body_comes_in_the_same_gap_in_which_one_that_bears_a_load_goes(statement):
    """What is remembered is of bodies as they were: before, every later step failed. Balls of 1 kg press with 9.81 N."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    balls = [scene.add(lm.disk(radius=0.1, position=(x, 0.1), mass=1.0)) for x in (0.0, 1.0)]
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    sim = simulate(scene).run(steps=5)
    getattr(balls[0], statement)()
    scene.add(lm.disk(radius=0.1, position=(2.0, 0.1), mass=1.0))
    sim.run(steps=5)
    assert sim.steps == 10
    assert sim.interactions.candidate.tolist() == [1, 3]
    assert sim.interactions.force[:, 0] == pytest.approx(G, rel=1e-9)


@pytest.mark.parametrize("theta", [0.5, 0.7, 1.0])
@pytest.mark.parametrize(
    "law", [lm.Signorini(), lm.Coulomb(friction=0.3), *(lm.Restitution(restitution=e) for e in (0.0, 0.2, 1.0))]
)
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_velocity_that_is_written_is_not_taken_for_turning(dimension, law, theta):
    """A ball at rest on a floor that is told to fall leaves with -e times that velocity, as it does in the first step."""
    down = np.eye(dimension)[-1]
    scene = lm.Scene(dimension=dimension)
    make = lm.disk if dimension == 2 else lm.sphere
    ball = scene.add(make(radius=0.1, position=0.1 * down, mass=1.0))
    scene.add(lm.wall(point=0.0 * down, normal=down))
    scene.see("GRAIN", "WALL", law)
    sim = lm.Simulation(scene, time_step=1e-3, theta=theta).run(steps=5)
    ball.velocity[:] = -down
    sim.step()
    np.testing.assert_allclose(ball.velocity, getattr(law, "restitution", 0.0) * down, atol=1e-12)


def test_a_tower_that_is_told_to_fall_stays():
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    balls = [scene.add(lm.disk(radius=0.1, position=(0.0, 0.1 + 0.2 * k), mass=1.0)) for k in range(3)]
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    for other in ("GRAIN", "WALL"):
        scene.see("GRAIN", other, lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.Auto(tolerance=1e-10)).run(steps=20)
    sim.velocities[:3, 1] = -2.0
    sim.run(steps=50)
    heights = [ball.position[1] for ball in balls]
    # they moved by h v/2 before the first detection, and keep that
    np.testing.assert_allclose(heights, np.array([0.1, 0.3, 0.5]) - 1e-3, atol=1e-8)


def test_grains_that_come_later_leave_a_cell_that_yields_its_inertia():
    """They bring no energy, as they are at rest in the mean flow, and are as good as grains that were hidden until then."""
    sims = []
    for late in (True, False):
        scene = lm.Scene(dimension=2)

        def row(y, scene=scene):
            return [scene.add(lm.disk(radius=0.05, position=(0.1 + 0.2 * k, y), mass=1.0)) for k in range(5)]

        row(0.2)
        scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
        scene.periodic(x=1.0, y=1.0).impose_stress(xx=-10.0)
        hidden = [] if late else [body.hide() for body in row(0.7)]
        sim = lm.Simulation(scene, time_step=1e-3).run(steps=40)
        before = sim.energy.kinetic
        if late:
            row(0.7)
        for body in hidden:
            body.show()
        sim.step()
        works = sim.energy.loads + sim.energy.drives + sum(sim.energy.interactions.values())
        assert sim.energy.kinetic - before == pytest.approx(works, rel=1e-9)
        sims.append(sim.run(steps=40))
    np.testing.assert_array_equal(*(sim.positions[:7] for sim in sims))  # those of the start, and the edges
