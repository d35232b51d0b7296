"""Measures of wires against wires whose answers are known: drawn over a floor, hanging, random, straightening."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.measure.wire_fabric import DirectionBins, means_along
from lmgcpy.measure.wire_links import WireLinks, correlation_of, runs_of

G, MU, MASS, LINK = 10.0, 0.4, 0.5, 0.25
BEADS = 9


def drawn(dimension):
    """Two wires of nine beads that do not roll, drawn over a floor along x at a steady speed, the second one in its middle.

    At rest in their frame, friction mu m g acts on each bead.
    """
    gravity = (0.0,) * (dimension - 1) + (-G,)
    scene = lm.Scene(dimension=dimension, gravity=gravity)
    up = np.eye(dimension)[-1]
    shape = lm.disk if dimension == 2 else lm.sphere
    for start, puller in ((0.0, BEADS - 1), (5.0, BEADS // 2)):
        places = [start + LINK * i for i in range(BEADS)]
        # the second wire is pulled in its middle: what is before it is slack by a tenth of a link
        places = [x - 0.1 * LINK * max(0, i - puller) for i, x in enumerate(places)]
        beads = [
            scene.add(
                shape(
                    radius=0.1,
                    position=x * np.eye(dimension)[0] + 0.1 * up,
                    mass=MASS,
                    color="BEAD",
                    velocity=0.3 * np.eye(dimension)[0],
                )
            )
            for x in places
        ]
        scene.chain(beads, lm.RigidWire(), reference_gap=LINK - 0.2, neighbours_collide=False)
        for bead in beads:
            bead.impose_velocity(**dict.fromkeys(["spin"] if dimension == 2 else ["spin_x", "spin_y", "spin_z"], 0.0))
        beads[puller].impose_velocity(x=0.3)
    scene.add(lm.wall(point=np.zeros(dimension), normal=up))
    scene.see("BEAD", "WALL", lm.Coulomb(friction=MU))
    return lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-10))


@pytest.fixture(scope="module", params=[2, 3])
def both(request, tmp_path_factory):
    """Drawn wires as a simulation and as an open run."""
    path = tmp_path_factory.mktemp("drawn") / "drawn.h5"
    sim = drawn(request.param).run(steps=4, record=path, every=2)
    with lm.io.open_run(path) as run:
        yield sim, run


def test_links_of_drawn_wires(both):
    """Link i of the first wire draws i + 1 beads; so does the second one up to its middle, before which it is slack."""
    for source in both:
        links = lm.measure.wire_links(source)
        assert links.chain.tolist() == [0] * 8 + [1] * 8
        ramp = MU * MASS * G * np.arange(1.0, 9.0)
        # 1e-8: the tolerance of the solver, 1e-10, times the number of links squared
        assert links.tension[:8] == pytest.approx(ramp, rel=1e-8)
        assert links.tension[8:12] == pytest.approx(ramp[:4], rel=1e-8)
        assert (links.tension[12:] == 0.0).all()
        assert links.taut.sum() == 12
        assert links.reference_length == pytest.approx(np.full(16, LINK))
        assert links.slack[:12] == pytest.approx(np.zeros(12), abs=1e-6)
        # unpulled, the beads before the middle slow down by mu g t, t = 4 ms: the first of their links closes by 3e-5 m
        assert links.slack[12:] == pytest.approx(np.full(4, 0.1), abs=1e-3)
        assert np.array_equal(links.stretch, -links.slack)
        assert links.direction == pytest.approx(np.broadcast_to(np.eye(links.direction.shape[1])[0], links.direction.shape))
        assert links.along[:8] == pytest.approx(LINK * (np.arange(8) + 0.5))
        assert links.along[8] == pytest.approx(0.5 * LINK)


def test_fabric_of_drawn_wires(both):
    """Twelve links of 0.25 m are taut, four of nine tenths of it slack by 0.1; all lead along x."""
    sim, _ = both
    fabric = lm.measure.wire_fabric(sim)
    length = 12 * LINK + 4 * 0.9 * LINK
    assert fabric.length == pytest.approx(length, rel=1e-4)
    assert fabric.taut_share == pytest.approx(12 * LINK / length, rel=1e-4)
    assert fabric.slack == pytest.approx(0.1, abs=1e-3)
    assert fabric.fabric == pytest.approx(np.diag([1.0] + [0.0] * (sim.scene.dimension - 1)), abs=1e-9)
    assert fabric.anisotropy == pytest.approx(1.0)
    assert np.isnan(fabric.length_per_volume)
    assert lm.measure.wire_fabric(sim, volume=2.0).length_per_volume == pytest.approx(0.5 * fabric.length)


def test_friction_of_drawn_wires(both):
    """mu m g on each bead, all of it friction and all that friction can give, against the way of the beads."""
    for source in both:
        beads = lm.measure.wire_contacts(source)
        assert len(beads) == 2 * BEADS
        assert (beads.contacts == 1).all()
        assert (beads.sliding == 1).all()
        assert beads.sliding_share == 1.0
        assert beads.force_along == pytest.approx(np.full(18, -MU * MASS * G), rel=1e-8)
        assert beads.friction_along == pytest.approx(beads.force_along, rel=1e-8)
        assert beads.normal == pytest.approx(np.full(18, MASS * G), rel=1e-8)
        assert beads.limit == pytest.approx(MU * beads.normal)
        # nine beads on eight links, and five on the taut four, whose last one has half a slack link in front of it
        length = 8 * LINK + 4 * LINK + 0.45 * LINK
        assert beads.friction_per_length == pytest.approx(14 * MU * MASS * G / length, rel=1e-4)
        assert beads.force_per_length == pytest.approx(beads.friction_per_length, rel=1e-8)
        assert beads.limit_per_length == pytest.approx(beads.friction_per_length, rel=1e-8)
        assert beads.to_end[:BEADS] == pytest.approx(LINK * np.array([0, 1, 2, 3, 4, 3, 2, 1, 0]), abs=1e-8)
        # the balance along a straight wire
        tension = lm.measure.wire_links(source).tension[:8]
        assert np.diff(tension) == pytest.approx(-beads.force_along[1:8], rel=1e-7)


def test_taut_runs_of_drawn_wires(both):
    """One run over the whole first wire, one over half of the second; the best q of T = q L/2 is twice the friction."""
    for source in both:
        runs = lm.measure.taut_runs(source)
        assert runs.links.tolist() == [8, 4]
        assert runs.first.tolist() == [0, 0]
        assert runs.chain.tolist() == [0, 1]
        assert runs.length == pytest.approx([8 * LINK, 4 * LINK], rel=1e-6)
        assert runs.greatest == pytest.approx(MU * MASS * G * np.array([8.0, 4.0]), rel=1e-8)
        assert runs.mean == pytest.approx(MU * MASS * G * np.array([4.5, 2.5]), rel=1e-8)
        assert runs.anchorage == pytest.approx(2.0 * MU * MASS * G / LINK, rel=1e-6)
        assert runs.mean_length == pytest.approx((64 + 16) / 12 * LINK, rel=1e-6)


def test_kinds_of_contacts_of_drawn_wires(both):
    for source in both:
        kinds = lm.measure.contact_kinds(source)
        assert kinds.contacts.tolist() == [0, 0, 0, 18]
        assert kinds.sliding_share[3] == 1.0
        assert kinds.mobilised[3] == pytest.approx(1.0)
        assert kinds.normal[3] == pytest.approx(MASS * G, rel=1e-8)
        assert np.isnan(kinds.normal[:3]).all()


@pytest.mark.parametrize(
    "measure", ["wire_links", "tension_by_direction", "wire_contacts", "tension_correlation", "taut_runs", "contact_kinds"]
)
def test_a_run_measures_what_its_simulation_does(both, measure):
    sim, run = both
    one, other = vars(getattr(lm.measure, measure)(sim)), vars(getattr(lm.measure, measure)(run))
    assert one.keys() == other.keys()
    for name, value in one.items():
        if value.dtype.kind == "f":  # contact points are kept to round-off, and forces are impulses over the time step
            np.testing.assert_allclose(value, other[name], rtol=1e-9, atol=1e-12, err_msg=name)
        else:
            assert np.array_equal(value, other[name]), name
    with pytest.raises(TypeError, match="frame is for run files"):
        getattr(lm.measure, measure)(sim, frame=0)
    with pytest.raises(TypeError, match=f"{measure} takes a simulation"):
        getattr(lm.measure, measure)(3)
    with pytest.raises(IndexError, match="frame 3 does not exist: the run has the frames 0 to 2"):
        getattr(lm.measure, measure)(run, frame=3)


def test_before_the_first_step_there_is_geometry_alone(both):
    sim = drawn(2)
    links = lm.measure.wire_links(sim)
    assert np.isnan(links.tension).all()
    assert not links.taut.any()
    assert links.length[:8] == pytest.approx(np.full(8, LINK))
    assert np.isnan(lm.measure.wire_fabric(sim).taut_share)
    for measure in ("tension_by_direction", "tension_correlation", "taut_runs"):
        with pytest.raises(ValueError, match="There is no step yet, and so no tension"):
            getattr(lm.measure, measure)(sim)
    assert np.isnan(lm.measure.wire_links(both[1], frame=0).tension).all()


# -------------------------------------------------------------------------------------------------------- directions


@pytest.mark.parametrize("dimension", [2, 3])
def test_tension_by_direction_of_a_weight_on_two_wires(dimension):
    """W on two links at the angle a to the vertical: T = W / (2 cos a) each; their stress is that of Weber."""
    angle, weight = 0.5, 20.0
    scene = lm.Scene(dimension=dimension, gravity=(0.0,) * (dimension - 1) + (-G,))
    up, side = np.eye(dimension)[-1], np.eye(dimension)[0]
    shape = lm.disk if dimension == 2 else lm.sphere
    ends = [np.cos(angle) * up + sign * np.sin(angle) * side for sign in (-1.0, 1.0)]
    beads = [shape(radius=0.01, position=p, mass=weight / G, color="BEAD") for p in (ends[0], 0.0 * up, ends[1])]
    for bead in beads:
        scene.add(bead)
    beads[0].fix()
    beads[2].fix()
    scene.chain(beads, lm.RigidWire())
    sim = lm.Simulation(scene, time_step=1e-4, solver=lm.GaussSeidel(tolerance=1e-12)).run(steps=2)
    found = lm.measure.tension_by_direction(sim, bins=6, volume=3.0)
    (bin_,) = np.flatnonzero(found.links)
    assert found.links[bin_] == 2
    assert found.lower[bin_] <= np.degrees(angle) <= found.upper[bin_]
    tension = weight / (2.0 * np.cos(angle))
    assert found.tension[bin_] == pytest.approx(tension, rel=1e-6)  # h^2 g / l = 1e-7 of a turn
    assert found.taut_share[bin_] == 1.0
    assert found.pull.sum() == pytest.approx(2.0 * tension, rel=1e-6)
    weber = lm.measure.stress(sim, volume=3.0)["rigid-wire"]
    assert found.stress.sum(axis=0) == pytest.approx(weber, rel=1e-12, abs=1e-12)
    assert found.stress[bin_][-1, -1] == pytest.approx(2.0 * tension * np.cos(angle) ** 2 / 3.0, rel=1e-6)
    assert np.isnan(lm.measure.tension_by_direction(sim, bins=6).stress).all()
    along_x = lm.measure.tension_by_direction(sim, axis="x", bins=90)
    (bin_,) = np.flatnonzero(along_x.links)
    assert along_x.lower[bin_] <= 90.0 - np.degrees(angle) <= along_x.upper[bin_]


@pytest.mark.parametrize("dimension", [2, 3])
def test_isotropic_directions_fill_all_bins_alike(dimension):
    """Chi squared of 20 000 directions in 10 bins: 9 expected, 9 + 5 sqrt(18) is the bound."""
    rng = np.random.default_rng(3)
    t = rng.normal(size=(20_000, dimension))
    t /= np.linalg.norm(t, axis=1)[:, None]
    bins = DirectionBins.along("y", 10, dimension)
    counts = np.bincount(bins.of(t), minlength=10)
    assert ((counts - 2000.0) ** 2 / 2000.0).sum() < 9 + 5 * np.sqrt(18.0)
    angle = np.degrees(np.arccos(np.abs(t[:, 1])))
    assert np.array_equal(bins.of(t), np.searchsorted(bins.edges[1:-1], angle, side="right"))
    assert (bins.edges[0], bins.edges[-1]) == (0.0, 90.0)
    assert bins.of(np.eye(dimension)[:2]).tolist() == [9, 0]
    assert np.array_equal(bins.of(t), DirectionBins.along(-2.0 * np.eye(dimension)[1], 10, dimension).of(-t))


def test_wrong_axes_get_sentences():
    for axis, error, words in (
        ("z", ValueError, "axis cannot be 'z'"),
        ((0.0, 0.0), ValueError, "axis must have a direction"),
        ((1.0, 0.0, 0.0), ValueError, "axis must be 2 numbers"),
    ):
        with pytest.raises(error, match=words):
            DirectionBins.along(axis, 9, 2)


def test_errors_of_means_along_a_wire():
    """Of independent values sd/sqrt(n). Of values that stay the same over 8 links sd/sqrt(n/8): with the reach K = 40 the
    triangle of their correlation is weighted by at least 1 - 8/41, so that the error falls short by at most 10 %; 8000
    values give it to some 10 % (1 of 2.8 in the case of independent ones)."""
    rng = np.random.default_rng(0)
    one, chain = np.zeros(8000, dtype=int), np.zeros(8000, dtype=int)
    alone = rng.normal(size=8000)
    mean, error = means_along(alone, one, 2, chain)
    assert mean[0] == pytest.approx(alone.mean())
    assert np.isnan([mean[1], error[1]]).all()
    assert error[0] == pytest.approx(1.0 / np.sqrt(8000), rel=0.2)
    assert means_along(alone, one, 1, chain, reach=0)[1][0] == pytest.approx(alone.std(ddof=1) / np.sqrt(8000))
    held = np.repeat(rng.normal(size=1000), 8)
    assert means_along(held, one, 1, chain, reach=40)[1][0] == pytest.approx(1.0 / np.sqrt(1000), rel=0.25)
    # links of different chains are independent: each chain a single link
    assert means_along(held, one, 1, np.arange(8000))[1][0] == pytest.approx(1.0 / np.sqrt(8000), rel=0.1)


@pytest.mark.default_parameters("3")
@pytest.mark.parametrize("dimension", [2, 3])
def test_fabric_of_a_random_wire_is_isotropic_within_its_error(dimension):
    """1/d within four standard errors, which are those of the variance of t_i t_j: 1/8 and 1/8 in 2D, 4/45 and 1/15 in
    3D, over 4000 links of one length. Lengths per volume and links of two chains add."""
    rng = np.random.default_rng(5)
    scene = lm.Scene(dimension=dimension)
    shape = lm.disk if dimension == 2 else lm.sphere
    for chain in range(2):
        steps = rng.normal(size=(2000, dimension))
        steps /= 5.0 * np.linalg.norm(steps, axis=1)[:, None]
        places = np.vstack([np.zeros(dimension), np.cumsum(steps, axis=0)]) + chain
        beads = [scene.add(shape(radius=0.001, position=p, mass=1.0)) for p in places]
        scene.chain(beads, lm.RigidWire())
    fabric = lm.measure.wire_fabric(lm.Simulation(scene, time_step=1e-3), volume=10.0)
    assert fabric.length_per_volume == pytest.approx(4000 * 0.2 / 10.0)
    assert np.trace(fabric.fabric) == pytest.approx(1.0)
    assert (np.abs(fabric.fabric - np.eye(dimension) / dimension) < 4.0 * fabric.fabric_error).all()
    variance = np.full((2, 2), 1 / 8) if dimension == 2 else np.full((3, 3), 1 / 15) + np.eye(3) * (4 / 45 - 1 / 15)
    # the correlation sums of 9 lags scatter by some 10 % of the error
    assert fabric.fabric_error == pytest.approx(np.sqrt(variance / 4000), rel=0.3)


# ------------------------------------------------------------------------------------------------- along the wire


def links_with(tension, chain):
    """Links of length 0.5 m with such tensions."""
    count = len(tension)
    d, half, none = np.zeros((count, 2)), np.full(count, 0.5), np.zeros(count)
    pairs = np.zeros((count, 2), dtype=int)
    return WireLinks(np.asarray(chain), pairs, none, d, d, half, half, none, np.asarray(tension, dtype=float))


def test_correlation_length_of_an_exponential_decay():
    """T_{i+1} = rho T_i + noise has C(k) = rho^k, the length b = -l / ln rho. 40 000 links hold 4000 of these lengths, so
    that it is off by some sqrt(2/4000) of itself, and by the noise of the tail: 10 % is the bound."""
    rng = np.random.default_rng(1)
    rho, noise = np.exp(-0.1), rng.normal(size=40_000)
    tension = np.empty(40_000)
    tension[0] = noise[0] / np.sqrt(1 - rho**2)
    for i in range(1, 40_000):
        tension[i] = rho * tension[i - 1] + noise[i]
    found = correlation_of(links_with(tension, np.zeros(40_000, int)), 200)
    assert found.correlation[0] == 1.0
    assert found.correlation[:30] == pytest.approx(rho ** np.arange(30), abs=0.05)
    assert found.correlation_length == pytest.approx(10 * 0.5, rel=0.1)
    assert (np.abs(found.correlation[1:30] - rho ** np.arange(1, 30)) < 4.0 * found.error[1:30]).all()
    assert found.distance[3] == 1.5
    # the same of independent tensions is half a link, up to noise of neighbours
    apart = correlation_of(links_with(noise, np.zeros(40_000, int)), 200)
    assert apart.correlation_length == pytest.approx(0.25, abs=0.05)


def test_links_of_two_chains_are_no_pair():
    """A ramp up in one chain and down in the other: at the seam nothing is multiplied."""
    tension = [1.0, 2.0, 3.0, 3.0, 2.0, 1.0]
    found = correlation_of(links_with(tension, [0, 0, 0, 1, 1, 1]), 5)
    rest = np.array(tension) - 2.0
    assert found.count.tolist() == [6, 4]
    assert found.correlation[1] == pytest.approx(0.0 / (rest**2).mean(), abs=1e-15)
    assert np.isnan(correlation_of(links_with([2.0] * 6, [0] * 6), 5).correlation_length)
    assert len(correlation_of(links_with([], []), 5)) == 0


def test_a_run_leads_over_the_seam_of_a_closed_chain():
    tension = [2.0, 0.0, 1.0, 4.0, 0.0, 3.0]
    ring = runs_of(links_with(tension, [0] * 6), np.array([True]))
    assert sorted(zip(ring.first.tolist(), ring.links.tolist(), ring.greatest.tolist(), strict=True)) == [
        (2, 2, 4.0),
        (5, 2, 3.0),
    ]
    line = runs_of(links_with(tension, [0] * 6), np.array([False]))
    assert line.first.tolist() == [0, 2, 5]
    assert runs_of(links_with([1.0] * 3, [0] * 3), np.array([True])).links.tolist() == [3]
    none = runs_of(links_with([0.0] * 3, [0] * 3), np.array([True]))
    assert len(none) == 0
    assert np.isnan([none.mean_length, none.anchorage]).all()


def test_tables_are_ready_for_pandas(both):
    pytest.importorskip("pandas")
    sim, run = both
    axes = "xyz"[: sim.scene.dimension]
    frame = lm.measure.wire_links(run).to_dataframe()
    assert [name for name in frame if name.startswith("direction")] == [f"direction_{k}" for k in axes]
    for measure in ("tension_by_direction", "wire_contacts", "tension_correlation", "taut_runs", "contact_kinds"):
        table = getattr(lm.measure, measure)(run)
        assert len(table.to_dataframe()) == len(table)
