"""Drag of a medium: exact where it is linear, stable at any step, and told in energies and files."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm

MASS, G = 1e-3, 9.81


def sinking(dimension=2, start=None, **drag):
    """A disk or sphere under its weight, and how it starts; at rest by default."""
    scene = lm.Scene(dimension=dimension, gravity=[0.0] * (dimension - 1) + [-G])
    make = lm.disk if dimension == 2 else lm.sphere
    body = scene.add(make(radius=0.005, position=[0.0] * dimension, mass=MASS, **(start or {})))
    scene.drag(**drag)
    return scene, body


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("h", [1e-4, 1e-3, 1e-2, 1.0])
def test_linear_drag_is_exact_at_any_step(dimension, h):
    """v = m g/c (1 - exp(-c t/m)): h c/m from 0.1 to 1000, where a force of the velocity is unstable from 2 on."""
    scene, body = sinking(dimension, linear=1.0)
    sim = lm.Simulation(scene, time_step=h)
    for _ in range(5):
        sim.step()
        assert -body.velocity[-1] == pytest.approx(-MASS * G * np.expm1(-sim.time / MASS), rel=1e-12)
        assert abs(sim.energy.defect) < 1e-14


@pytest.mark.long
@pytest.mark.parametrize("h", [1e-3, 1e-2, 1e-1, 10.0])
def test_quadratic_drag_comes_to_its_last_speed_from_both_sides(h):
    """sqrt(m g/k), never exceeded, at any step."""
    for start in (0.0, -30.0):
        scene, body = sinking(2, {"velocity": (0.0, start)}, quadratic=1e-3)
        sim = lm.Simulation(scene, time_step=h)
        last, speed = np.sqrt(MASS * G / 1e-3), []
        for _ in range(400):
            sim.step()
            speed.append(-body.velocity[1])
        assert speed[-1] == pytest.approx(last, rel=1e-9 if h > 1e-3 else 0.2)  # 0.4 s are not long enough
        away = np.array(speed) - last
        assert (away <= 1e-12).all() if start == 0.0 else (away >= -1e-12).all()
        assert (np.abs(np.diff(np.abs(away))) >= 0.0).all()


def test_quadratic_drag_is_of_first_order():
    """Free flight: 1/v = 1/v_0 + k t/m."""
    errors = []
    for h in (1e-2, 5e-3, 2.5e-3):
        scene, body = sinking(2, {"velocity": (3.0, 4.0)}, quadratic=1e-3)
        scene.gravity = (0.0, 0.0)
        lm.Simulation(scene, time_step=h).run(duration=0.5)
        errors.append(abs(np.linalg.norm(body.velocity) - 1.0 / (1.0 / 5.0 + 0.5)))
        assert body.velocity[1] / body.velocity[0] == pytest.approx(4.0 / 3.0, rel=1e-12)
    assert np.log2(errors[0] / errors[1]) == pytest.approx(1.0, abs=0.1)
    assert np.log2(errors[1] / errors[2]) == pytest.approx(1.0, abs=0.1)


def test_a_sphere_sinks_by_stokes_and_its_spin_decays():
    eta, radius = 0.1, 0.005
    scene, body = sinking(3, {"spin": (0.0, 5.0, 0.0)}, viscosity=eta)
    lm.Simulation(scene, time_step=1e-2).run(duration=0.2)
    c = 6.0 * np.pi * eta * radius
    assert -body.velocity[2] == pytest.approx(-MASS * G / c * np.expm1(-c * 0.2 / MASS), rel=1e-12)
    inertia = 0.4 * MASS * radius**2
    assert body.spin[1] == pytest.approx(5.0 * np.exp(-8.0 * np.pi * eta * radius**3 * 0.2 / inertia), rel=1e-12)


@pytest.mark.parametrize("solver", [lm.GaussSeidel(tolerance=1e-10), lm.Auto(tolerance=1e-10)])
def test_a_contact_knows_the_drag(solver):
    """A disk that is pushed along a rough floor by F slides at (F - mu m g)/c, and comes to it with the time m/c; at rest
    its floor bears the weight."""
    scene, body = sinking(linear=0.5)
    scene.add(lm.wall(point=(0.0, -0.005), normal=(0.0, 1.0)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    body.fix("spin")
    force, weight = 2.0 * MASS * G, MASS * G
    body.impose_force(x=force)
    sim = lm.Simulation(scene, time_step=2e-3, solver=solver).run(steps=4)
    slides = (force - 0.3 * weight) / 0.5
    assert body.velocity[0] == pytest.approx(-slides * np.expm1(-0.5 * sim.time / MASS), rel=1e-9)
    np.testing.assert_allclose(sim.interactions.force[0], [weight, 0.3 * weight], rtol=1e-9)  # t = -x
    assert abs(sim.energy.defect) < 1e-15
    assert sim.energy.drag < 0.0


def test_a_heavy_drag_moves_a_wire_as_the_drag_of_its_beads():
    """A chain that is pulled along itself through honey: (F/sum c), at steps 100 times m/c; links are taut."""
    scene = lm.Scene(dimension=2)
    beads = [scene.add(lm.disk(radius=0.001, position=(0.01 * i, 0.0), mass=1e-5)) for i in range(10)]
    scene.chain(beads, lm.RigidWire())
    scene.drag(beads, linear=1e-2)
    beads[-1].impose_force(x=0.05)
    sim = lm.Simulation(scene, time_step=0.1, solver=lm.Auto(tolerance=1e-10)).run(steps=3)
    np.testing.assert_allclose(sim.velocities[:, 0], 0.05 / (10 * 1e-2), rtol=1e-6)
    np.testing.assert_allclose(-sim.interactions.force[:, 0], 0.005 * np.arange(1, 10), rtol=1e-6)


def test_rate_is_a_damping_and_statements_add_up():
    scene, body = sinking(2, {"velocity": (1.0, 0.0)}, rate=2.0)
    other = scene.add(lm.disk(radius=0.1, position=(1.0, 0.0), mass=5.0, velocity=(1.0, 0.0), spin=3.0))
    scene.drag([other], linear=5.0)
    scene.gravity = (0.0, 0.0)
    lm.Simulation(scene, time_step=0.05).run(duration=0.5)
    assert body.velocity[0] == pytest.approx(np.exp(-1.0), rel=1e-12)
    assert other.velocity[0] == pytest.approx(np.exp(-1.5), rel=1e-12)
    assert other.spin == pytest.approx(3.0 * np.exp(-1.0), rel=1e-12)


@pytest.mark.long
def test_a_run_goes_on_with_its_drag(tmp_path):
    def begin():
        scene, body = sinking(linear=0.01)
        scene.drag([body], quadratic=1e-3)
        scene.add(lm.wall(point=(0.0, -0.02), normal=(0.0, 1.0)))
        scene.see("GRAIN", "WALL", lm.Restitution(restitution=0.5))
        return lm.Simulation(scene, time_step=1e-3)

    begin().run(steps=60, record=tmp_path / "run.h5")
    lm.resume(tmp_path / "run.h5").run(steps=60)
    whole = begin().run(steps=120)
    with lm.io.open_run(tmp_path / "run.h5") as run:
        np.testing.assert_array_equal(run.positions[-1], whole.positions)
        again = lm.Scene.from_run(tmp_path / "run.h5")
    assert [each.bodies for each in again._media] == [None, (0,)]


@pytest.mark.parametrize(
    ("drag", "error", "words"),
    [
        ({}, TypeError, "drag needs a coefficient"),
        ({"linear": -1.0}, ValueError, "linear of a drag must be at least 0 N s/m"),
        ({"viscosity": 1.0}, ValueError, "Stokes"),
        ({"bodies": 3, "linear": 1.0}, TypeError, "list of bodies"),
        ({"bodies": [lm.disk(radius=1.0, position=(0, 0), mass=1.0)], "linear": 1.0}, ValueError, "bodies of the scene"),
        ({"speed": 1.0}, TypeError, "drag has no argument 'speed'"),
    ],
)
def test_wrong_statements_get_sentences(drag, error, words):
    with pytest.raises(error, match=words):
        lm.Scene(dimension=2).drag(**drag)
