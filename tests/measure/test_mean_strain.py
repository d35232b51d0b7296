"""Strain of a sample and stretch of its wire against fields that are imposed: affine, noise, a wire that straightens."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm

GRADIENT = np.array([[0.1, 0.04, -0.02], [-0.03, -0.15, 0.01], [0.02, 0.05, 0.07]])
SHIFT = np.array([0.3, -0.2, 0.1])
GRAINS, BEADS = 300, 60


def moved(dimension, seed=0, noise=0.0, hidden=()):
    """Random grains and a random wire in a box of walls, and where they were: an affine field took them from there."""
    rng = np.random.default_rng(seed)
    gradient, shift = GRADIENT[:dimension, :dimension], SHIFT[:dimension]
    before = rng.uniform(0.0, 1.0, (GRAINS, dimension))
    steps = rng.normal(size=(BEADS - 1, dimension))
    steps *= 0.02 / np.linalg.norm(steps, axis=1)[:, None]
    wire = 0.5 + np.vstack([np.zeros(dimension), np.cumsum(steps, axis=0)])
    before = np.vstack([wire, before])
    after = before + before @ gradient.T + shift + noise * rng.normal(size=before.shape)
    scene = lm.Scene(dimension=dimension)
    shape = lm.disk if dimension == 2 else lm.sphere
    bodies = [scene.add(shape(radius=1e-3, position=p, mass=1.0)) for p in after]
    scene.chain(bodies[:BEADS], lm.RigidWire())
    for k in hidden:
        bodies[k].hide()
    walls = []
    for k in range(dimension):
        for at, side in ((0.0, 1.0), (1.0, -1.0)):
            point = at * np.eye(dimension)[k]
            walls.append(point)
            scene.add(lm.wall(point=(1.0 + gradient[k, k]) * point + shift, normal=side * np.eye(dimension)[k]))
    return lm.Simulation(scene, time_step=1e-3), np.vstack([before, walls])


@pytest.fixture(scope="module", params=[2, 3])
def affine(request):
    return moved(request.param)


def test_an_affine_field_is_found_to_round_off(affine):
    sim, since = affine
    d = sim.scene.dimension
    gradient = GRADIENT[:d, :d]
    for kind, count in (("all", GRAINS + BEADS), ("grains", GRAINS), ("beads", BEADS)):
        found = lm.measure.mean_strain(sim, since=since, kind=kind)
        assert found.gradient == pytest.approx(gradient, abs=1e-12)
        assert len(found.body) == count
        assert found.rest == pytest.approx(np.zeros((count, d)), abs=1e-13)
        assert found.non_affine_share == pytest.approx(0.0, abs=1e-20)
        assert found.non_affine < 1e-13
    assert found.strain + found.rotation == pytest.approx(found.gradient)
    assert found.rotation == pytest.approx(-found.rotation.T)
    assert found.volumetric == pytest.approx(np.linalg.det(np.eye(d) + gradient) - 1.0)
    assert found.box == pytest.approx(np.diag(np.diag(gradient)), abs=1e-12)
    places = since[:7]
    assert found.at(places) == pytest.approx(places @ gradient.T + SHIFT[:d])


def test_windows_and_margins_choose_bodies_by_where_they_were(affine):
    sim, since = affine
    d = sim.scene.dimension
    bodies = since[: GRAINS + BEADS]
    window = [0.2] * d, [0.9] * d
    inside = ((bodies >= 0.2) & (bodies <= 0.9)).all(axis=1)
    assert np.array_equal(lm.measure.mean_strain(sim, since=since, window=window).body, np.flatnonzero(inside))
    inside = ((bodies > 0.15) & (bodies < 0.85)).all(axis=1)
    assert np.array_equal(lm.measure.mean_strain(sim, since=since, margin=0.15).body, np.flatnonzero(inside))


@pytest.mark.default_parameters("3")
@pytest.mark.parametrize("dimension", [2, 3])
def test_the_standard_error_is_that_of_noise(dimension):
    """Independent noise s on p bodies spread evenly over a unit box: s/sqrt(p/12) for each component. Over 20 samples the
    true error is within it by the factor that 20 d^2 squares leave, and so is the mean of the errors that are told; blocks
    at corners weigh more, for which 25 % are allowed."""
    s, found = 0.01, []
    for seed in range(20):
        sim, since = moved(dimension, seed, noise=s)
        found.append(lm.measure.mean_strain(sim, since=since, kind="grains"))
    expected = s / np.sqrt(GRAINS / 12.0)
    errors = np.array([one.gradient - GRADIENT[:dimension, :dimension] for one in found])
    told = np.array([one.standard_error for one in found])
    assert np.sqrt((errors**2).mean()) == pytest.approx(expected, rel=0.25)
    assert np.sqrt((told**2).mean()) == pytest.approx(expected, rel=0.25)
    assert (np.abs(errors) < 4.0 * told).mean() > 0.98
    # and the noise is the non-affine part
    assert found[0].non_affine == pytest.approx(s * np.sqrt(dimension), rel=0.1)


def test_a_few_bodies_have_no_error():
    scene = lm.Scene(dimension=2)
    for p in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0)):
        scene.add(lm.disk(radius=0.1, position=p, mass=1.0))
    sim = lm.Simulation(scene, time_step=1e-3)
    found = lm.measure.mean_strain(sim, since=np.array([[0.0, 0.0], [2.0, 0.0], [0.0, 1.0]]))
    assert found.gradient == pytest.approx(np.diag([-0.5, 0.0]))
    assert np.isnan(found.standard_error).all()
    assert np.isnan(found.box).all()


def test_a_periodic_cell_is_the_box():
    """Its edges and bodies follow one gradient; a cell that was straightened has other edges of the same lattice."""
    gradient = np.array([[0.02, 0.1], [0.0, -0.05]])
    rng = np.random.default_rng(2)
    scene = lm.Scene(dimension=2)
    before = rng.uniform(0.0, 1.0, (40, 2))
    for p in before @ (np.eye(2) + gradient).T:
        scene.add(lm.disk(radius=1e-3, position=p, mass=1.0))
    edges = np.eye(2) @ (np.eye(2) + gradient).T
    scene.periodic(x=edges[0], y=edges[1])
    sim = lm.Simulation(scene, time_step=1e-3)
    rows = sim.model.lattice.rows
    since = np.zeros_like(sim.positions)
    since[np.isfinite(sim.model.extent)] = before
    for lattice in (np.eye(2), [[1.0, 0.0], [-1.0, 1.0]]):
        since[rows] = lattice
        found = lm.measure.mean_strain(sim, since=since)
        assert found.gradient == pytest.approx(gradient, abs=1e-12)
        assert found.box == pytest.approx(gradient, abs=1e-12)


def test_images_surround_a_wire_that_leaves_the_periodic_cell():
    """A wire and its image three cells to the right and two below, whose displacement differs by that of the cell, slip
    alike among grains that move by an affine field and one that has the period of the cell."""
    gradient, wave = np.array([[0.02, 0.05], [0.0, -0.05]]), 0.01
    rng = np.random.default_rng(6)
    wire = 0.9 + np.outer(np.arange(5), (0.05, 0.02))
    shift = np.array([3.0, -2.0])
    before = np.vstack([wire, wire + shift, rng.uniform(0.0, 1.0, (300, 2))])
    after = before @ (np.eye(2) + gradient).T + wave * np.sin(2.0 * np.pi * before)
    after[:10] = before[:10] @ (np.eye(2) + gradient).T
    scene = lm.Scene(dimension=2)
    bodies = [scene.add(lm.disk(radius=1e-3, position=p, mass=1.0)) for p in after]
    scene.chain(bodies[:5], lm.RigidWire())
    scene.chain(bodies[5:10], lm.RigidWire())
    scene.periodic(x=(np.eye(2) + gradient)[:, 0], y=(np.eye(2) + gradient)[:, 1])
    sim = lm.Simulation(scene, time_step=1e-3)
    since = np.zeros_like(sim.positions)
    since[np.isfinite(sim.model.extent)] = before
    since[sim.model.lattice.rows] = np.eye(2)
    slip = lm.measure.bead_slip(sim, since=since)
    assert slip.from_neighbours[5:] == pytest.approx(slip.from_neighbours[:5], abs=1e-12)
    # the wave that the grains follow and the wire does not: curvature over the distance r of eight grains leaves
    # (2 pi r)^2 / 2 of it, a quarter at r = 0.1
    assert slip.from_neighbours == pytest.approx(-wave * np.sin(2.0 * np.pi * before[:10]), abs=0.3 * wave)


def test_hidden_bodies_do_not_count(affine):
    sim, since = moved(affine[0].scene.dimension, hidden=[BEADS + 4])
    assert np.array_equal(lm.measure.mean_strain(sim, since=since).body, np.delete(np.arange(GRAINS + BEADS), BEADS + 4))


@pytest.mark.parametrize("links", [1, 4])
def test_an_affine_wire_stretches_as_the_sample(affine, links):
    """|(1 + G) n| - 1 to round-off; n.eps.n differs by the squares of G."""
    sim, since = affine
    found = lm.measure.stretch_by_direction(sim, since=since, bins=4, links=links)
    some = found.pieces > 0
    assert found.pieces.sum() == (BEADS - 1) // links
    assert found.stretch[some] == pytest.approx(found.affine_finite[some], abs=1e-12)
    assert found.difference[some] == pytest.approx(np.zeros(some.sum()), abs=1e-12)
    assert found.affine[some] == pytest.approx(found.stretch[some], abs=0.05)
    assert np.isnan(found.stretch[~some]).all()


def test_beads_of_an_affine_field_do_not_slip(affine):
    sim, since = affine
    slip = lm.measure.bead_slip(sim, since=since)
    assert len(slip) == BEADS
    assert np.abs(slip.from_mean).max() < 1e-12
    # extrapolation from grains that nearly lie in a plane multiplies round-off
    assert np.abs(slip.from_neighbours).max() < 1e-10


def test_a_wire_that_is_drawn_through_resting_grains_slips_along_itself(affine):
    """By the distance that it is drawn, straight along x: all of the slip is along the wire, toward its last bead."""
    d = affine[0].scene.dimension
    rng = np.random.default_rng(4)
    scene = lm.Scene(dimension=d)
    shape = lm.disk if d == 2 else lm.sphere
    wire = 0.5 + np.outer(np.linspace(-0.3, 0.2, 11), np.eye(d)[0])
    beads = [scene.add(shape(radius=1e-3, position=p, mass=1.0)) for p in wire + 0.02 * np.eye(d)[0]]
    grains = rng.uniform(0.0, 1.0, (200, d))
    for p in grains:
        scene.add(shape(radius=1e-3, position=p, mass=1.0))
    scene.chain(beads, lm.RigidWire())
    sim, since = lm.Simulation(scene, time_step=1e-3), np.vstack([wire, grains])
    slip = lm.measure.bead_slip(sim, since=since)
    assert slip.along_neighbours == pytest.approx(np.full(11, 0.02))
    assert slip.along_mean == pytest.approx(np.full(11, 0.02))
    assert slip.along == pytest.approx(np.linspace(0.0, 0.5, 11))
    assert slip.to_end.max() == pytest.approx(0.25)
    few = lm.measure.bead_slip(sim, since=since, neighbours=201)
    assert np.isnan(few.from_neighbours).all()


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_wire_that_straightens_stretches_its_chords_and_not_its_links(dimension):
    """A zigzag of angle a to x becomes straight: links keep their length, chords of two stretch by 1/cos a - 1, while the
    grains do not move at all."""
    angle, links = 0.6, 20
    scene = lm.Scene(dimension=dimension)
    shape = lm.disk if dimension == 2 else lm.sphere
    x, up = np.eye(dimension)[0], np.eye(dimension)[-1]
    straight = np.outer(np.arange(links + 1) * 0.1, x)
    zigzag = np.cos(angle) * straight + 0.1 * np.sin(angle) * np.outer(np.arange(links + 1) % 2, up)
    beads = [scene.add(shape(radius=1e-3, position=p, mass=1.0)) for p in straight]
    grains = np.random.default_rng(0).uniform(0.0, 2.0, (50, dimension))
    for p in grains:
        scene.add(shape(radius=1e-3, position=p, mass=1.0))
    scene.chain(beads, lm.RigidWire())
    sim, since = lm.Simulation(scene, time_step=1e-3), np.vstack([zigzag, grains])
    for size, stretch in ((1, 0.0), (2, 1.0 / np.cos(angle) - 1.0)):
        found = lm.measure.stretch_by_direction(sim, since=since, axis="x", bins=1, links=size, kind="grains")
        assert found.pieces.tolist() == [links // size]
        assert found.stretch == pytest.approx([stretch], abs=1e-12)
        assert found.affine == pytest.approx([0.0], abs=1e-12)
        assert found.difference == pytest.approx([stretch], abs=1e-12)
        assert found.difference_error == pytest.approx([0.0], abs=1e-12)


def test_a_run_measures_what_its_simulation_does(tmp_path):
    """Since the positions of the first frame, to the last bit."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    rng = np.random.default_rng(0)
    for p in rng.uniform(0.0, 1.0, (30, 2)):
        scene.add(lm.disk(radius=1e-3, position=p, mass=1.0, velocity=rng.normal(size=2)))
    scene.chain(scene.bodies[:9], lm.ElasticWire(stiffness=1e3))
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=6, record=tmp_path / "run.h5", every=2)
    with lm.io.open_run(tmp_path / "run.h5") as run:
        for measure in ("mean_strain", "stretch_by_direction", "bead_slip"):
            of_run = getattr(lm.measure, measure)(run, since=1)
            of_sim = getattr(lm.measure, measure)(sim, since=run.positions[1])
            for name, value in vars(of_run).items():
                assert np.array_equal(value, getattr(of_sim, name), equal_nan=True), name
            with pytest.raises(IndexError, match=r"since -9 does not exist: the run has the frames 0 to 3\."):
                getattr(lm.measure, measure)(run, since=-9)
            with pytest.raises(ValueError, match="since of a simulation must be positions"):
                getattr(lm.measure, measure)(sim)
        rest = lm.measure.mean_strain(run, since=2, frame=2)
        assert np.array_equal(rest.gradient, np.zeros((2, 2)))
        assert np.isnan(rest.non_affine_share)


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"kind": "sand"}, ValueError, "kind cannot be 'sand'"),
        ({"margin": -1.0}, ValueError, "margin must be at least 0 m"),
        ({"margin": 0.6}, ValueError, "mean_strain needs at least 3 bodies .*there are 0: take a larger window"),
        ({"window": ((0, 0),)}, TypeError, "window must be two corners"),
        ({"window": ((0, 0), (0, 1))}, ValueError, "low corner and its high corner"),
        ({"frame": 0}, TypeError, "frame is for run files"),
    ],
)
def test_wrong_choices_get_sentences(options, error, words):
    sim, since = moved(2)
    with pytest.raises(error, match=words):
        lm.measure.mean_strain(sim, since=since, **options)
