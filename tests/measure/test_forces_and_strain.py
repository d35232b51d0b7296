"""Contact forces, stress by particle and window, strain, tension: of simulations and of runs alike."""

from __future__ import annotations

import sys

import numpy as np
import pytest
from two_frames import TwoFrames

import lmgcpy as lm

G = 9.81


def pressed(law, count=5):
    """A square lattice of disks between four walls, pressed by 10 N/m from the right and 20 N/m from above."""
    scene = lm.Scene(dimension=2)
    for j in range(count):
        for i in range(count):
            scene.add(lm.disk(radius=0.1, position=(0.1 + 0.2 * i, 0.1 + 0.2 * j), mass=1.0))
    size = 0.2 * count
    scene.add(lm.wall(point=(0, 0), normal=(0, 1)))
    scene.add(lm.wall(point=(0, 0), normal=(1, 0)))
    scene.add(lm.wall(point=(size, 0), normal=(-1, 0), mass=1.0)).impose_force(x=-10.0)
    scene.add(lm.wall(point=(0, size), normal=(0, -1), mass=1.0)).impose_force(y=-20.0)
    scene.see("GRAIN", "GRAIN", law)
    scene.see("GRAIN", "WALL", law)
    return scene


def heap(seed=0, count=40):
    """Disks that have fallen on each other between walls; and the file of the run."""
    rng = np.random.default_rng(seed)
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    for i in range(count):
        at = (0.15 + 0.22 * (i % 6) + rng.uniform(-0.005, 0.005), 0.12 + 0.24 * (i // 6))
        scene.add(lm.disk(radius=rng.uniform(0.06, 0.1), position=at, mass=rng.uniform(1, 2)))
    for point, normal in (((0, 0), (0, 1)), ((0, 0), (1, 0)), ((1.4, 0), (-1, 0)), ((0, 3), (0, -1))):
        scene.add(lm.wall(point=point, normal=normal))
    for color in ("GRAIN", "WALL"):
        scene.see("GRAIN", color, lm.Coulomb(friction=0.3))
    return scene


@pytest.fixture(scope="module")
def both(tmp_path_factory):
    """A heap at rest as a simulation and as an open run."""
    path = tmp_path_factory.mktemp("heap") / "heap.h5"
    sim = lm.Simulation(heap(), time_step=2e-3, solver=lm.AcceleratedGaussSeidel(tolerance=1e-5))
    sim.run(steps=400, record=path, every=100)
    with lm.io.open_run(path) as run:
        yield sim, run


def test_forces_of_a_lattice():
    """Six planes of contacts across x carry 10 N/m each, six across y 20 N/m, as nothing rubs."""
    sim = lm.Simulation(pressed(lm.Signorini()), time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-10)).run(steps=1)
    forces = lm.measure.contact_forces(sim)
    along_x = np.abs(forces.direction[:, 0]) > 0.5
    # 6 planes of contacts across x, walls included, each carries 10 N/m
    assert forces.normal[along_x].sum() == pytest.approx(6 * 10.0, rel=1e-8)
    assert forces.normal[~along_x].sum() == pytest.approx(6 * 20.0, rel=1e-8)
    network = lm.measure.network(sim)
    assert np.diag(network.fabric) == pytest.approx([0.5, 0.5], abs=0.1)
    assert np.diag(network.force_fabric) == pytest.approx([1 / 3, 2 / 3], rel=1e-8)


def test_mobilised_friction_of_a_block_on_an_incline():
    """Two feet on a plane at an angle below that of friction: tan(angle)/mu of the whole, whatever each foot bears."""
    scene = lm.Scene(dimension=2, gravity=(G * np.sin(0.2), -G * np.cos(0.2)))
    feet = [(lm.DiskContactor(0.05), (-0.5, 0.0)), (lm.DiskContactor(0.05), (0.5, 0.0))]
    scene.add(lm.RigidBody(feet, mass=1.0, inertia=0.1, position=(0.0, 0.05), color="BLOCK"))
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    scene.see("BLOCK", "WALL", lm.Coulomb(friction=0.5))
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12)).run(steps=3)
    forces = lm.measure.contact_forces(sim)
    assert (forces.mobilised * forces.normal).sum() / forces.normal.sum() == pytest.approx(np.tan(0.2) / 0.5, rel=1e-6)
    frictionless = lm.Simulation(pressed(lm.Signorini()), time_step=1e-3).run(steps=1)
    assert np.isnan(lm.measure.contact_forces(frictionless).mobilised).all()


def test_friction_is_the_one_of_the_step(tmp_path):
    """Two linked disks slide, so that all of their friction is mobilised, with 0.2, and after ``set_law`` with 0.1: in the
    frames before and after, and in the simulation between the statement and the next step."""
    scene = lm.Scene(dimension=2, gravity=(3.0, -10.0))
    disks = [scene.add(lm.disk(radius=0.1, position=(0.2 * k, 0.1), mass=1.0)).fix("spin") for k in range(2)]
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    scene.chain(disks, lm.RigidWire())
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.2))
    sim = lm.Simulation(scene, time_step=1e-3)

    def weaken(sim):
        if sim.steps == 4:
            scene.set_law("GRAIN", "WALL", lm.Coulomb(friction=0.1))
            slides_with(0.2, sim)

    def slides_with(friction, source, **frame):
        found = lm.measure.contact_forces(source, **frame)
        assert found.friction == pytest.approx([friction, friction])
        assert found.mobilised == pytest.approx([1.0, 1.0])
        assert lm.measure.contact_kinds(source, **frame).sliding_share[-1] == 1.0
        wire = lm.measure.wire_contacts(source, **frame)
        assert wire.sliding.tolist() == [1, 1]
        assert wire.limit == pytest.approx([10.0 * friction, 10.0 * friction])

    sim.run(steps=8, record=tmp_path / "run.h5", every=2, on_step=weaken)
    slides_with(0.1, sim)
    with lm.io.open_run(tmp_path / "run.h5") as run:
        for frame, friction in ((1, 0.2), (2, 0.2), (3, 0.1), (4, 0.1)):
            slides_with(friction, run, frame=frame)


def test_a_distribution_of_forces_is_a_density(both):
    """It integrates to the part of the contacts below its end, and its mean is 1 where that is all of them."""
    forces = lm.measure.contact_forces(both[0])
    centres, density = forces.distribution(40, largest=float(forces.relative.max()) * 1.000001)
    width = centres[1] - centres[0]
    assert density.sum() * width == pytest.approx(1.0, rel=1e-12)
    assert (density * centres).sum() * width == pytest.approx(1.0, abs=width)
    _, part = forces.distribution(10, largest=1.0)
    assert part.sum() * 0.1 == pytest.approx((forces.relative < 1.0).mean(), rel=1e-12)


def test_moments_of_particles_are_the_stress_of_the_sample(both):
    """V sigma = sum of moments, to round-off; so are windows that tile the box."""
    sim, run = both
    total = lm.measure.stress(sim)["total"]
    particles = lm.measure.particle_stress(sim)
    volume = 1.4 * 3.0
    assert particles.moment.sum(axis=0) / volume == pytest.approx(total, rel=1e-12, abs=1e-12 * np.abs(total).max())
    radii = np.array([sim.scene.bodies[i].radius for i in particles.body])
    assert particles.volume == pytest.approx(np.pi * radii**2, rel=1e-14)
    assert particles.stress[3] == pytest.approx(particles.moment[3] / particles.volume[3])
    windows = [((x, y), (x + 0.7, y + 1.0)) for x in (0.0, 0.7) for y in (0.0, 1.0, 2.0)]
    parts = [lm.measure.window_stress(sim, window) for window in windows]
    assert np.mean(parts, axis=0) == pytest.approx(total, rel=1e-12, abs=1e-12 * np.abs(total).max())
    assert lm.measure.window_stress(run, windows[0]) == pytest.approx(parts[0], rel=1e-9, abs=1e-9)


def test_a_sphere_between_two_forces_has_the_stress_of_its_volume():
    """2 N along z on a sphere of radius R: sigma_zz = -2 R f/V, V = 4/3 pi R^3."""
    scene = lm.Scene(dimension=3)
    ball = scene.add(lm.sphere(radius=0.1, position=(0.0, 0.0, 0.1), mass=1.0)).impose_force(z=-2.0)
    scene.add(lm.wall(point=(0, 0, 0), normal=(0, 0, 1)))
    scene.add(lm.wall(point=(0, 0, 0.2), normal=(0, 0, -1), mass=1.0)).impose_force(z=-2.0)
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12)).run(steps=1)
    found = lm.measure.particle_stress(sim)
    # 2 N above, 4 N below: sum of f (x) lever
    assert found.moment[0, 2, 2] == pytest.approx(-0.1 * (2.0 + 4.0), rel=1e-6)
    assert found.stress[0, 2, 2] == pytest.approx(found.moment[0, 2, 2] / (4 / 3 * np.pi * 1e-3), rel=1e-12)
    assert found.body.tolist() == [ball.id]


@pytest.mark.parametrize("measure", ["network", "contact_forces", "particle_stress", "stress"])
def test_a_run_measures_what_its_simulation_does(both, measure):
    sim, run = both
    one, other = getattr(lm.measure, measure)(sim), getattr(lm.measure, measure)(run)
    one, other = (part if isinstance(part, dict) else vars(part) for part in (one, other))
    assert one.keys() == other.keys()
    for name, value in one.items():
        if np.asarray(value).dtype.kind in "fi":  # levers are kept to round-off: the file holds points
            np.testing.assert_allclose(value, other[name], rtol=1e-9, atol=1e-9, err_msg=name)
        else:
            assert np.array_equal(value, other[name])
    earlier = getattr(lm.measure, measure)(run, frame=1)
    assert type(earlier) is type(getattr(lm.measure, measure)(sim))
    with pytest.raises(TypeError, match="frame is for run files"):
        getattr(lm.measure, measure)(sim, frame=1)
    with pytest.raises(TypeError, match=f"{measure} takes a simulation"):
        getattr(lm.measure, measure)(3)


@pytest.mark.parametrize("dimension", [2, 3])
def test_an_affine_field_is_found_to_round_off(dimension):
    rng = np.random.default_rng(1)
    before = rng.uniform(0.0, 1.0, (200, dimension))
    gradient = rng.normal(0.0, 0.1, (dimension, dimension))
    found = lm.measure.strain(TwoFrames(before, before + before @ gradient.T + 0.3))
    assert found.gradient == pytest.approx(np.broadcast_to(gradient, found.gradient.shape), abs=1e-11)
    assert found.strain == pytest.approx(0.5 * (found.gradient + found.gradient.swapaxes(1, 2)))
    assert found.rest == pytest.approx(np.zeros(200), abs=1e-20)
    assert found.displacement == pytest.approx(before @ gradient.T + 0.3)


def test_a_body_that_moves_alone_has_the_largest_rest():
    before = np.stack(np.meshgrid(np.arange(7.0), np.arange(7.0)), axis=-1).reshape(-1, 2)
    after = before.copy()
    after[24] += (0.3, 0.1)
    found = lm.measure.strain(TwoFrames(before, after))
    assert np.argmax(found.rest) == 24
    assert found.rest[0] == 0.0


def test_strain_of_a_run_and_of_too_few_bodies(both):
    found = lm.measure.strain(both[1], since=0, frame=-1)
    assert len(found) == 40
    assert found.displacement[:, 1].mean() < 0.0
    with pytest.raises(ValueError, match="strain needs at least 3 bodies"):
        lm.measure.strain(TwoFrames(np.zeros((2, 2)), np.zeros((2, 2))))
    with pytest.raises(ValueError, match="strain needs at least 3 bodies that lie in no line"):
        lm.measure.strain(TwoFrames(np.arange(10.0).reshape(5, 2), np.zeros((5, 2))))


def test_strain_of_a_simulation_is_that_of_its_run(both):
    """Since the positions of the first frame, to the last bit."""
    sim, run = both
    of_run, of_sim = lm.measure.strain(run), lm.measure.strain(sim, since=run.positions[0])
    for name in ("body", "displacement", "gradient", "rest"):
        assert np.array_equal(getattr(of_sim, name), getattr(of_run, name), equal_nan=True), name
    with pytest.raises(
        ValueError, match=r"since of a simulation must be positions of all its bodies.*got an array of shape \(\)"
    ):
        lm.measure.strain(sim)
    with pytest.raises(TypeError, match="frame is for run files"):
        lm.measure.strain(sim, frame=0, since=run.positions[0])
    with pytest.raises(TypeError, match="strain takes a simulation or a run file"):
        lm.measure.strain(3)


def test_tension_along_a_hanging_wire(tmp_path):
    """Link i carries the beads below; the second chain has its own."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    for x, mass in ((0.0, 1.0), (5.0, 2.0)):
        beads = [scene.add(lm.disk(radius=0.05, position=(x, -0.5 * i), mass=mass)) for i in range(5)]
        beads[0].fix()
        scene.chain(beads, lm.RigidWire())
    sim = lm.Simulation(scene, time_step=1e-3)
    assert np.isnan(lm.measure.wire_links(sim).tension).all()
    sim.run(steps=3, record=tmp_path / "run.h5", every=1)
    with lm.io.open_run(tmp_path / "run.h5") as run:
        for source in (sim, run):
            for chain, weight in ((0, 10.0), (1, 20.0)):
                links = lm.measure.wire_links(source)
                here = links.chain == chain
                assert links.tension[here] == pytest.approx(weight * np.array([4.0, 3.0, 2.0, 1.0]), rel=1e-8)
                assert links.along[here] == pytest.approx([0.25, 0.75, 1.25, 1.75], rel=1e-8)


def test_tables_of_pandas(both):
    pandas = pytest.importorskip("pandas")
    frame = lm.measure.contact_forces(both[0]).to_dataframe()
    assert isinstance(frame, pandas.DataFrame)
    assert list(frame) == [
        "candidate",
        "antagonist",
        "law",
        "direction_x",
        "direction_y",
        "normal",
        "tangential",
        "friction",
    ]
    frame = lm.measure.particle_stress(both[0]).to_dataframe()
    assert [name for name in frame if name.startswith("moment")] == ["moment_xx", "moment_xy", "moment_yx", "moment_yy"]
    assert len(frame) == 40


def test_without_pandas_there_is_a_sentence(both, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match="to_dataframe needs pandas, which is not installed: pip install pandas"):
        lm.measure.contact_forces(both[0]).to_dataframe()


@pytest.mark.parametrize(
    ("window", "error", "words"),
    [
        (((0, 0),), TypeError, "window must be two corners"),
        (((0, 0), (0, 1)), ValueError, "low corner and its high corner"),
        (((0, 0, 0), (1, 1, 1)), ValueError, "a corner of window must be 2 numbers"),
    ],
)
def test_a_wrong_window_gets_a_sentence(both, window, error, words):
    with pytest.raises(error, match=words):
        lm.measure.window_stress(both[0], window)


def test_each_contact_has_the_friction_of_its_colours(tmp_path):
    """Two rows with laws of one name: a block slides on a rough floor, of which all friction is mobilised, beside a smooth
    wall; the friction of each is that of its row."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -G))
    scene.add(lm.disk(radius=0.1, position=(0.1, 0.1), mass=1.0, velocity=(-1.0, 0.0))).impose_velocity(spin=0.0)
    scene.add(lm.wall(point=(0, 0), normal=(0, 1), color="FLOOR"))
    scene.add(lm.wall(point=(0, 0), normal=(1, 0), color="SIDE"))
    scene.see("GRAIN", "FLOOR", lm.Coulomb(friction=0.3))
    scene.see("SIDE", "GRAIN", lm.Coulomb(friction=0.0))
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=1, record=tmp_path / "run.h5", every=1)
    with lm.io.open_run(tmp_path / "run.h5") as run:
        for source in (sim, run):
            forces = lm.measure.contact_forces(source)
            rough = np.abs(forces.direction[:, 1]) > 0.5
            assert forces.friction[rough].tolist() == [0.3]
            assert forces.friction[~rough].tolist() == [0.0]


@pytest.mark.parametrize("d", [2, pytest.param(3, marks=pytest.mark.long)])
def test_contacts_on_a_thread_have_the_friction_of_its_row_and_the_moments_are_the_stress(d, tmp_path):
    """A thread whose end beads have a shape and a colour of their own is drawn between two grains: of its contacts all
    friction is mobilised. Two coefficients fit a contact at an end bead, and it is not known which: NaN."""
    scene, low, high = lm.Scene(dimension=d), np.zeros(d), np.zeros(d)
    make, thick = lm.disk if d == 2 else lm.sphere, 0.01
    low[-1], high[-1] = -0.05 - thick, 0.05 + thick

    def at(x):
        return [x] + [0.0] * (d - 1)

    nodes = [scene.add(lm.point_mass(position=at(0.1 * k - 0.27), mass=0.1)) for k in range(6)]
    last = scene.add(make(radius=thick, position=at(0.33), mass=0.1, color="BEAD"))
    scene.chain([*nodes, last], lm.RigidWire(), surface=lm.Thread(thick))
    spins = ("spin",) if d == 2 else ("spin_x", "spin_y", "spin_z")
    for place, force in ((low, 2.0), (high, -2.0)):
        grain = scene.add(make(radius=0.05, position=place, mass=1.0)).fix(*"xyz"[: d - 1], *spins)
        grain.impose_force(**{"xyz"[d - 1]: force})
    over = scene.add(make(radius=0.05, position=high + at(0.33), mass=1.0)).fix(*"xyz"[: d - 1], *spins)
    over.impose_force(**{"xyz"[d - 1]: -2.0})
    last.impose_velocity(x=0.1).fix(*"xyz"[1:d])
    scene.see("BEAD", "GRAIN", lm.Coulomb(friction=0.7))
    scene.see("GRAIN", "THREAD", lm.Coulomb(friction=0.4))
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=5, record=tmp_path / "run.h5", every=1)
    with lm.io.open_run(tmp_path / "run.h5") as run:
        for source in (sim, run):
            forces = lm.measure.contact_forces(source)
            at_bead = (forces.pairs == last.id).any(axis=1)
            assert (~at_bead).sum() == 2
            assert forces.friction[~at_bead] == pytest.approx([0.4, 0.4])
            assert np.isnan(forces.friction[at_bead]).all()
            assert at_bead.any()
            assert forces.mobilised[~at_bead] == pytest.approx([1.0, 1.0])
            assert lm.measure.wire_contacts(source).limit.sum() == pytest.approx(0.4 * forces.normal[~at_bead].sum())
    total, moments = lm.measure.stress(sim, volume=1.0), lm.measure.particle_stress(sim).moment.sum(axis=0)
    assert moments == pytest.approx(total["total"], abs=1e-9 * np.abs(moments).max())
    assert np.abs(moments).max() > 0.1
