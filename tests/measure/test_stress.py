"""The Weber stress of a run file is that of the simulation that wrote it."""

import sys
from pathlib import Path

import numpy as np
import pytest

import lmgcpy as lm

sys.path.insert(0, str(Path(__file__).parent.parent))
from mixed_scene import mixed_scene


def boxed():
    """Twelve grains between four walls, pressed together from the side; two are tied."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    grains = [
        scene.add(lm.disk(radius=0.05, position=(0.06 + 0.105 * (i % 4), 0.052 + 0.105 * (i // 4)), mass=1.0))
        for i in range(12)
    ]
    for point, normal in (((0, 0), (0, 1)), ((0, 0.4), (0, -1)), ((0, 0), (1, 0))):
        scene.add(lm.wall(point=point, normal=normal))
    scene.add(lm.wall(point=(0.44, 0), normal=(-1, 0), mass=5.0)).impose_force(x=-60.0)
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.3))
    scene.see("WALL", "GRAIN", lm.Coulomb(friction=0.3))
    scene.chain([grains[0], grains[5]], lm.RigidWire())
    return scene


@pytest.mark.default_parameters(theta=(0.8,))
@pytest.mark.parametrize(
    ("scene", "volume"),
    [
        pytest.param(boxed, None, id="box whose volume is that between its walls, which are candidates"),
        pytest.param(mixed_scene, 2.0, id="clusters, inclined and moving walls, links of all kinds"),
    ],
)
@pytest.mark.parametrize("theta", [0.5, 0.8])
def test_stress_of_a_frame_is_that_of_the_simulation_then(scene, volume, theta, tmp_path):
    """Levers come from contact points and positions, each rounded: 1e-16 of places of 3 m, against levers of 0.05 m."""
    path = tmp_path / "run.h5"
    seen = {"stress": [], "lever": []}

    def note(sim):
        if sim.steps % 20 == 0:
            seen["stress"].append(lm.measure.stress(sim, volume=volume))
            seen["lever"].append(sim.interactions.lever)

    sim = lm.Simulation(scene(), time_step=1e-3, theta=theta, on_unconverged="ignore")
    sim.run(steps=100, record=path, every=20, until=note)
    walls = ~np.isfinite(sim.model.extent)
    with lm.io.open_run(path) as run:
        assert not lm.measure.stress(run, frame=0, volume=volume)["total"].any()
        for k, (stress, lever) in enumerate(zip(*seen.values(), strict=True), start=1):
            mine = lm.measure.stress(run, frame=k, volume=volume)
            assert mine.keys() == stress.keys()
            size = np.abs(stress["total"]).max()
            assert size > 1.0
            for law, sigma in stress.items():
                np.testing.assert_allclose(mine[law], sigma, rtol=0.0, atol=1e-13 * size)
            net = run.interactions(k)
            for side, body in enumerate((net.candidate, net.antagonist)):
                off = ~walls[body]
                np.testing.assert_allclose(net.lever[off, side], lever[off, side], rtol=0.0, atol=3e-15)
        np.testing.assert_array_equal(lm.measure.stress(run, volume=volume)["total"], mine["total"])


def test_wrong_sources_get_sentences(tmp_path):
    sim = lm.Simulation(mixed_scene(), time_step=1e-3).run(steps=1, record=tmp_path / "run.h5")
    with pytest.raises(TypeError, match="frame is for run files"):
        lm.measure.stress(sim, frame=0, volume=1.0)
    with pytest.raises(TypeError, match=r"takes a simulation, .* or a run file"):
        lm.measure.stress("run.h5")
    with lm.io.open_run(tmp_path / "run.h5") as run:
        with pytest.raises(ValueError, match="Give volume="):
            lm.measure.stress(run)
        with pytest.raises(IndexError):
            lm.measure.stress(run, frame=3, volume=1.0)


def gas(periodic, fraction=0.05, count=64, radius=0.01):
    """Elastic disks in a square; the pressure that Henderson's equation of state gives them in 2D."""
    side = np.sqrt(count * np.pi / fraction) * radius
    k = round(np.sqrt(count))
    places = [((i + 0.5) * side / k, (j + 0.5) * side / k) for i in range(k) for j in range(k)]
    velocities = np.random.default_rng(1).normal(size=(count, 2))
    velocities -= velocities.mean(axis=0)
    scene = lm.Scene(dimension=2)
    ones = np.ones(count)
    scene.add_disks(radius * ones, places, velocities=velocities, masses=ones, inertias=5e-5 * ones)
    scene.see("GRAIN", "GRAIN", lm.Restitution(restitution=1.0))
    if periodic:
        scene.periodic(x=side, y=side)
    else:
        for point, normal in (((0, 0), (1, 0)), ((0, 0), (0, 1)), ((side, side), (-1, 0)), ((side, side), (0, -1))):
            scene.add(lm.wall(point=point, normal=normal))
        scene.see("GRAIN", "WALL", lm.Restitution(restitution=1.0))
    factor = (1.0 + fraction**2 / 8.0) / (1.0 - fraction) ** 2
    return scene, 0.5 * (velocities**2).sum() * factor / side**2


@pytest.mark.long
@pytest.mark.filterwarnings("ignore:In the step")  # at 0.3 r a step glancing disks overlap by a tenth of a radius
@pytest.mark.parametrize("periodic", [True, pytest.param(False, marks=pytest.mark.long)])
def test_a_gas_has_the_pressure_of_its_equation_of_state(periodic, tmp_path):
    """Forces and flight together; the forces alone are a tenth of it. 5 % are chance: some 1500 shocks in the run."""
    scene, pressure = gas(periodic)
    sim, found = lm.Simulation(scene, time_step=1e-3), []
    sim.run(steps=1500, until=lambda sim: found.append(lm.measure.stress(sim)), record=tmp_path / "run.h5", every=1500)
    forces, flight = (-np.mean([np.trace(sigma[part]) / 2.0 for sigma in found]) for part in ("total", "kinetic"))
    assert forces + flight == pytest.approx(pressure, rel=0.05)
    assert forces < 0.2 * pressure
    with lm.io.open_run(tmp_path / "run.h5") as run:
        np.testing.assert_array_equal(lm.measure.stress(run)["kinetic"], found[-1]["kinetic"])


def test_bodies_that_drift_together_have_no_kinetic_stress():
    scene = lm.Scene(dimension=2)
    for x in (0.0, 1.0):
        scene.add(lm.disk(radius=0.1, position=(x, 0.0), mass=2.0, velocity=(3.0, 1.0)))
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=1)
    assert np.abs(lm.measure.stress(sim, volume=1.0)["kinetic"]).max() < 1e-14


@pytest.mark.default_parameters(
    kind=("disks on a thread", "spheres on a membrane"), nodes=("balls", "two radii"), wrapped=(False,)
)
@pytest.mark.parametrize("wrapped", [False, True])
@pytest.mark.parametrize("nodes", ["points", "balls", "two radii", "two radii, turned"])
@pytest.mark.parametrize("kind", ["disks on a thread", "spheres on a thread", "spheres on a membrane"])
def test_a_ball_on_a_thread_has_its_force_times_the_distance_of_the_axis(kind, nodes, wrapped, tmp_path):
    """-f l, with l from the foot on the axis to the centre, normal to the thread: nodes may have a shape of their own, or
    lie on a second surface that is thicker."""
    d, x = (2 if "disks" in kind else 3), 1.45 if wrapped else 0.15
    scene = lm.Scene(dimension=d)
    if wrapped:
        scene.periodic(x=1.5)
    make, up, rest = lm.disk if d == 2 else lm.sphere, "xyz"[d - 1], [0.0] * (d - 2)

    def node(*at):
        place = (*at, *rest)[:d]
        ball = make(radius=0.005, position=place, mass=1.0, color="NODE")
        return scene.add(ball if nodes == "balls" else lm.point_mass(position=place, mass=1.0)).fix(*"xyz"[:d])

    def thin():
        if "membrane" in kind:
            beside = node(x, 0.4)
            return scene.membrane([*row, beside], [(0, 1, 2)], lm.ElasticRod(stiffness=1.0), radius=0.02, color="THREAD")
        return scene.chain(row, lm.ElasticRod(stiffness=1.0), surface=lm.Thread(0.02))

    def thick():
        scene.chain([row[0], node(x - 0.15, -0.4)], lm.ElasticRod(stiffness=1.0), surface=lm.Thread(0.1, color="THICK"))

    row = [node(x - 0.15, 0.0), node((x + 0.25) % 1.5, 0.0)]
    for make_surface in {"two radii": (thin, thick), "two radii, turned": (thick, thin)}.get(nodes, (thin,)):
        make_surface()
    place = np.array([x, *rest, 0.12])
    if "membrane" in kind:
        place[1] = 0.1
    ball = scene.add(make(radius=0.1, position=place, mass=1.0)).fix(*"xyz"[: d - 1])
    ball.impose_force(**{up: -2.0})
    scene.see("GRAIN", "THREAD", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=1, record=tmp_path / "run.h5", every=1)
    wanted = np.zeros((d, d))
    wanted[-1, -1] = -2.0 * 0.12
    with lm.io.open_run(tmp_path / "run.h5") as run:
        for source in (sim, run):
            np.testing.assert_allclose(lm.measure.stress(source, volume=1.0)["total"], wanted, atol=1e-9)
            np.testing.assert_allclose(lm.measure.particle_stress(source).moment.sum(axis=0), wanted, atol=1e-9)
