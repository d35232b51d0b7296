"""Run files of 3D scenes: recorded, read, gone on with, compared, exported."""

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.io.compare import compare
from lmgcpy.io.csv_tables import export_csv


def heap(functions=None):
    """Spheres of two sizes with a wire through them, thrown into a box with a driven floor, a loaded wall, a cylinder."""
    rng = np.random.default_rng(1)
    scene = lm.Scene(dimension=3, gravity=(0.2, 0.0, -9.81))
    sand = lm.Material("sand", density=2600.0)
    balls = []
    for i in range(27):
        place = 0.2 * np.array([i % 3 - 1, i // 3 % 3 - 1, i // 9 + 0.6]) + rng.uniform(-0.02, 0.02, 3)
        start = {"velocity": rng.normal(0.0, 1.0, 3), "spin": rng.normal(0.0, 3.0, 3)}
        balls.append(scene.add(lm.sphere(radius=rng.uniform(0.06, 0.09), position=place, material=sand, **start)))
    balls[4].fix("spin_x", "y")
    floor = scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0.1, 1)))
    floor.impose_velocity(z=functions[27, "z"] if functions else 0.1)
    scene.add(lm.wall(point=(0.45, 0, 0), normal=(-1, 0, 0), mass=20.0)).impose_force(x=-40.0)
    scene.add(lm.cylinder_wall(point=(0, 0, 0), axis=(0, 0, 1), radius=0.5))
    scene.see("GRAIN", "GRAIN", lm.Coulomb(friction=0.4))
    scene.see("WALL", "GRAIN", lm.Restitution(restitution=0.4, friction=0.3), alert=0.02)
    scene.chain(balls[::4], lm.VoigtWire(stiffness=1e4, viscosity=10.0), block_spin=True)
    return lm.Simulation(scene, time_step=1e-3, theta=0.6, on_unconverged="ignore")


def same(a, b):
    return all(np.array_equal(getattr(a, name), getattr(b, name)) for name in ("positions", "velocities", "spins"))


@pytest.mark.long
@pytest.mark.parametrize("functions", [None, {(27, "z"): lambda time: 0.1 + time}])
def test_a_run_in_two_parts_is_the_whole_run(tmp_path, functions):
    whole = heap(functions).run(steps=120)
    heap(functions).run(steps=50, record=tmp_path / "run.h5", every=10)
    rest = lm.resume(tmp_path / "run.h5", functions=functions).run(steps=70)
    assert same(whole, rest)
    assert np.array_equal(whole.interactions.impulse, rest.interactions.impulse)
    assert any(rest.interactions.impulse[:, 2])


def test_a_file_tells_what_the_simulation_does(tmp_path):
    path = tmp_path / "run.h5"
    sim = heap().run(steps=80, record=path, every=20)
    net = sim.interactions
    with lm.io.open_run(path) as run:
        assert run.dimension == 3
        assert np.array_equal(run.positions[-1], sim.positions)
        assert np.array_equal(run.spins[-1], sim.spins)
        kept = run.interactions(-1)
        assert np.array_equal(kept.impulse, net.impulse)
        assert kept.frame == pytest.approx(net.frame, abs=1e-15)
        assert np.einsum("mij,mkj->mik", net.frame, net.frame) == pytest.approx(
            np.tile(np.eye(3), (len(net), 1, 1)), abs=1e-15
        )
        from_file, direct = lm.measure.stress(run, volume=0.3), lm.measure.stress(sim, volume=0.3)
        for name, sigma in direct.items():
            assert from_file[name] == pytest.approx(sigma, abs=1e-9 * np.abs(direct["total"]).max())
        written = export_csv(run, tmp_path / "csv")
    bodies = (tmp_path / "csv" / "bodies.csv").read_text().splitlines()
    assert bodies[0].endswith("spin_z [rad/s]")
    assert len(bodies) == 1 + 5 * 30
    assert len(written) == 3
    heap().run(steps=80, record=tmp_path / "again.h5", every=20)
    with lm.io.open_run(path) as one, lm.io.open_run(tmp_path / "again.h5") as other:
        assert compare(one, other) is None
        assert compare(one, other, tolerance=1e-9) is None
