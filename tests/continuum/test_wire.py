"""The wire network: closed forms, convexity, its dual, and slip."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from test_directions import rotation

from lmgcpy.continuum import (
    Directions,
    DruckerPrager,
    GrowingAnchorage,
    TexSol,
    WireNetwork,
    in_plane,
    isotropic,
    layers,
    triaxial,
    turn,
)

SIZE = {2: 3, 3: 6}
NETWORKS = {
    "circle": WireNetwork(2.0, 50.0, isotropic(2, 40), slack=0.01),
    "sphere": WireNetwork(2.0, 50.0, isotropic(3, 100)),
    "layers": WireNetwork(2.0, 50.0, layers("z", 0.2, 60), slack=np.linspace(-0.02, 0.05, len(layers("z", 0.2, 60)))),
}


def strains(rng, network, count=20):
    return 0.1 * rng.standard_normal((count, SIZE[network.dimension]))


def derivative(function, at, step=1e-6):
    """Central differences; of a function with kinks in its second derivative they are exact to about ``step``."""
    units = np.eye(len(at)) * step
    return np.stack([(function(at + unit) - function(at - unit)) / (2 * step) for unit in units], axis=-1)


@pytest.fixture(params=NETWORKS)
def network(request):
    return NETWORKS[request.param]


def test_all_wire_in_one_direction():
    """A bar: psi = L EA e^2 / 2 under the stretch e, and nothing under compression or across."""
    wire = WireNetwork(3.0, 7.0, Directions([[0.6, 0.8]], [1.0]), slack=0.01)
    n = np.array([0.36, 0.64, math.sqrt(2) * 0.48])
    strain = 0.05 * n
    assert wire.energy(strain) == pytest.approx(21.0 * 0.04**2 / 2, rel=1e-13)
    np.testing.assert_allclose(wire.stress(strain), 21.0 * 0.04 * n, rtol=1e-13)
    np.testing.assert_allclose(wire.tangent(strain), 21.0 * np.outer(n, n), rtol=1e-13)
    assert wire.energy(-strain) == 0.0
    assert not wire.stress(np.array([0.64, 0.36, -math.sqrt(2) * 0.48])).any()


@pytest.mark.parametrize(
    ("rule", "part"), [(isotropic(2, 400), 1 / 8), (in_plane("z", 400), 1 / 8), (isotropic(3, 4000), 1 / 15)]
)
def test_pure_shear_of_an_isotropic_network(rule, part):
    """psi = 1/2 L EA <e>_+^2 in the mean, e = gamma cos 2 theta: half of <cos^2> = 1/2; in 3D of <sin^4> <cos^2> = 4/15."""
    wire = WireNetwork(5.0, 3.0, rule)
    gamma = 0.02
    strain = gamma * np.eye(SIZE[rule.dimension])[0] - gamma * np.eye(SIZE[rule.dimension])[1]
    assert wire.energy(strain) == pytest.approx(15.0 * part * gamma**2, rel=2e-4)
    assert strain @ wire.stress(strain) == pytest.approx(2 * wire.energy(strain), rel=1e-13)


def test_energy_is_convex_and_stress_its_gradient(network):
    rng = np.random.default_rng(2)
    a, b = strains(rng, network), strains(rng, network)
    for one, other in zip(a, b, strict=True):
        # gradient inequality, stronger than the middle of the chord
        assert network.energy(other) >= network.energy(one) + network.stress(one) @ (other - one) - 1e-12
        np.testing.assert_allclose(derivative(network.energy, one), network.stress(one), rtol=1e-6, atol=1e-5)


def test_tangent_is_symmetric_positive_and_the_derivative(network):
    """Differences of 1e-7 meet a kink with a probability of some 1e-5 a direction; the seed meets none."""
    for strain in strains(np.random.default_rng(3), network):
        tangent = network.tangent(strain)
        np.testing.assert_allclose(tangent, tangent.T, atol=1e-12)
        assert np.linalg.eigvalsh(tangent).min() > -1e-12 * network.stiffnesses.sum()
        np.testing.assert_allclose(derivative(network.stress, strain, 1e-7), tangent, atol=1e-6 * 100)


@pytest.mark.parametrize("dimension", [2, 3])
def test_turned_wires_under_a_turned_strain_have_the_turned_stress(dimension):
    rng = np.random.default_rng(4)
    rule, R = isotropic(dimension, 60), rotation(rng, dimension)
    rule = Directions(rule.units, rng.random(len(rule)))
    wire, turned = WireNetwork(1.0, 1.0, rule), WireNetwork(1.0, 1.0, Directions(rule.units @ R.T, rule.weights))
    for strain in strains(rng, wire):
        assert turned.energy(turn(R) @ strain) == pytest.approx(wire.energy(strain), rel=1e-12)
        np.testing.assert_allclose(turned.stress(turn(R) @ strain), turn(R) @ wire.stress(strain), atol=1e-14)


def test_an_isotropic_network_turns_with_the_strain_to_the_error_of_its_quadrature():
    """The sum of both parts, stretched and shortened, is exact; the stretched part has the error of the rule: 2e-3."""
    rng = np.random.default_rng(5)
    wire = WireNetwork(1.0, 1.0, isotropic(3, 400))
    for strain in strains(rng, wire):
        R = rotation(rng, 3)
        both = [wire.stress(e) - wire.stress(-e) for e in (strain, turn(R) @ strain)]
        np.testing.assert_allclose(both[1], turn(R) @ both[0], atol=1e-14)
        scale = np.linalg.norm(both[0])
        np.testing.assert_allclose(wire.stress(turn(R) @ strain), turn(R) @ wire.stress(strain), atol=2e-3 * scale)


def test_fenchel(network):
    """psi(eps) + psi*(sigma) >= sigma . eps for any pair, and equal at sigma = psi'(eps)."""
    rng = np.random.default_rng(6)
    scale = network.stiffnesses.sum() * 0.01
    for one, other in zip(strains(rng, network), strains(rng, network), strict=True):
        sigma = network.stress(one)
        dual = network.dual_energy(sigma)
        assert network.energy(one) + dual == pytest.approx(sigma @ one, abs=1e-10 * scale)
        assert network.energy(other) + dual >= sigma @ other - 1e-10 * scale


def test_dual_is_the_least_energy_of_tensions(network):
    """Tensions t_k = c_k <...>_+ make the stress with sum t^2/(2 c) + slack t; others that make it have no less."""
    rng = np.random.default_rng(7)
    _, _, null = np.linalg.svd(network.products.T)
    for strain in strains(rng, network, 8):
        t = network.stiffnesses * np.maximum(network.elongation(strain), 0.0)
        least = float((t**2 / (2 * network.stiffnesses) + network.slack * t).sum())
        sigma = network.products.T @ t
        assert network.dual_energy(sigma) == pytest.approx(least, rel=1e-9, abs=1e-9)
        other = t + 0.3 * t.max() * rng.random() * null[SIZE[network.dimension] + rng.integers(5)]
        if other.min() >= 0.0:
            np.testing.assert_allclose(network.products.T @ other, sigma, atol=1e-9)
            assert float((other**2 / (2 * network.stiffnesses) + network.slack * other).sum()) >= least


def test_strain_of_a_stress_where_all_strains_are_resisted(network):
    found = 0
    for strain in strains(np.random.default_rng(8), network):
        if np.linalg.eigvalsh(network.tangent(strain)).min() > 1e-3 * network.stiffnesses.mean():
            found += 1
            np.testing.assert_allclose(network.strain(network.stress(strain)), strain, atol=1e-8)
    assert found > 3


def test_what_wires_cannot_make_has_an_infinite_dual_energy_and_no_strain():
    wire = WireNetwork(1.0, 1.0, isotropic(2, 20))
    assert wire.dual_energy([-1.0, 0.0, 0.0]) == math.inf
    assert wire.dual_energy([1.0, 1.0, 3.0]) == math.inf  # shear above the mean: one principal stress is negative
    assert wire.dual_energy([0.0, 0.0, 0.0]) == 0.0
    with pytest.raises(ValueError, match=r"cannot make the stress .* they only pull"):
        wire.strain([-1.0, 0.0, 0.0])
    with pytest.raises(ValueError, match="leave one free"):
        WireNetwork(1.0, 1.0, Directions([[1.0, 0.0]], [1.0])).strain([1.0, 0.0, 0.0])


def test_stress_on_the_edge_of_the_cone():
    """Along one of the directions only that one pulls: psi* = sigma^2 / (2 L EA w)."""
    rule = isotropic(2, 20)
    wire = WireNetwork(2.0, 3.0, rule)
    for k in (0, 7):
        assert wire.dual_energy(4.0 * wire.products[k]) == pytest.approx(16.0 / (2 * 6.0 / 20), rel=1e-8)


@pytest.mark.parametrize("seed", range(3))
def test_prestressed_wires_have_a_dual_energy_below_zero(seed):
    """Slack below zero: psi*(0) = -min psi, which is 0 as wires go slack in a contracted sample, and psi(0) > 0."""
    rule = isotropic(2, 20)
    wire = WireNetwork(1.0, 1.0, rule, slack=-0.01 * np.random.default_rng(seed).random(20))
    assert wire.energy(np.zeros(3)) > 0.0
    assert wire.dual_energy(np.zeros(3)) == pytest.approx(0.0, abs=1e-15)


def test_the_dual_energy_of_stiff_wires_becomes_that_of_inextensible_ones():
    """EA -> infinity at a given stress: psi* -> sup of sigma . eps over n.eps.n <= slack, which is slack tr sigma here:
    sum t_k slack with sum t_k = tr sigma. It differs by ~ 1/EA."""
    sigma = np.array([3.0, 1.0, 0.5])
    rest = [WireNetwork(1.0, EA, isotropic(2, 40), slack=0.02).dual_energy(sigma) - 0.02 * 4.0 for EA in (1e3, 1e4, 1e5)]
    np.testing.assert_allclose(np.array(rest) * [1e3, 1e4, 1e5], rest[0] * 1e3, rtol=1e-5)


@given(st.integers(0, 2**31), st.sampled_from(["circle", "sphere"]))
def test_random_stresses_of_the_cone_have_their_dual_energy(seed, name):
    network, rng = NETWORKS[name], np.random.default_rng(seed)
    t = rng.exponential(size=len(network.directions)) * (rng.random(len(network.directions)) < rng.random())
    sigma = network.products.T @ t
    assert network.dual_energy(sigma) <= float((t**2 / (2 * network.stiffnesses) + network.slack * t).sum()) + 1e-6


def anchored(anchorage=1e-4, EA=50.0):
    return WireNetwork(2.0, EA, Directions([[1.0, 0.0]], [1.0]), anchorage=anchorage)


def test_a_wire_that_slips_has_the_tension_of_its_anchorage():
    """EA 0.1 = 5 N would be the tension; the sand of 1 kPa holds 1e-4 m x 1e3 Pa = 0.1 N of it."""
    wire = anchored()
    answer = wire.respond(np.array([0.1, 0.0, 0.0]), np.zeros(1), 1e3)
    assert wire.tensions([0.1, 0.0, 0.0], answer.slip) == pytest.approx([0.1], rel=1e-12)
    np.testing.assert_allclose(answer.stress, [0.2, 0.0, 0.0])
    np.testing.assert_allclose(answer.slip, 0.1 - 0.1 / 50.0)
    assert not answer.stiffness.any()
    np.testing.assert_allclose(answer.slope, [2.0 * 1e-4, 0.0, 0.0])
    unloaded = wire.respond(np.array([0.09, 0.0, 0.0]), answer.slip, 1e3)
    assert not unloaded.stress.any()


def test_no_pressure_no_tension():
    answer = anchored().respond(np.array([0.1, 0.0, 0.0]), np.zeros(1), -5.0)
    assert not answer.stress.any()
    assert answer.slip == pytest.approx([0.1])


def test_the_loop_of_unloading_and_reloading_has_the_area_of_the_dissipation():
    """Work of a closed cycle of strain = what slip dissipates + energy at its end, to the order of the steps."""
    wire, pressure = anchored(), 1e3
    path = np.concatenate(
        [np.linspace(0, 0.05, 2001)[1:], np.linspace(0.05, 0.0, 2001)[1:], np.linspace(0, 0.06, 2001)[1:]]
    )
    slip, before, work, lost, last = np.zeros(1), np.zeros(3), 0.0, 0.0, np.zeros(3)
    for value in path:
        strain = np.array([value, 0.0, 0.0])
        answer = wire.respond(strain, slip, pressure)
        loss = wire.dissipation(strain, slip, answer.slip)
        assert loss >= 0.0
        assert wire.tensions(strain, answer.slip)[0] <= 0.1 * (1 + 1e-12)
        work += 0.5 * (answer.stress + last) @ (strain - before)
        lost += loss
        slip, before, last = answer.slip, strain, answer.stress
    stored = wire.length * 0.5 * wire.tensions(before, slip)[0] ** 2 / wire.axial_rigidity
    assert work == pytest.approx(lost + stored, rel=1e-3)
    assert lost == pytest.approx(2.0 * 0.1 * (0.06 - 0.1 / 50.0), rel=1e-3)  # L T of all that the wire slipped


def test_derivatives_of_a_slipping_network():
    wire = WireNetwork(2.0, 50.0, layers("z", 0.2, 60), slack=0.003, anchorage=2e-3)
    rng = np.random.default_rng(9)
    strain, slip, pressure = 0.06 * rng.standard_normal(6), 0.01 * rng.random(len(wire.directions)), 150.0
    answer = wire.respond(strain, slip, pressure)
    stretch = wire.elongation(strain) - slip
    ceiling = wire.anchorage * pressure
    assert (stretch < 0).any()
    assert (50 * stretch > ceiling).any()
    assert ((stretch > 0) & (50 * stretch < ceiling)).any()
    np.testing.assert_allclose(
        derivative(lambda e: wire.respond(e, slip, pressure).stress, strain, 1e-7), answer.stiffness, atol=1e-5
    )
    by_pressure = [wire.respond(strain, slip, pressure + step).stress for step in (-1e-3, 1e-3)]
    np.testing.assert_allclose((by_pressure[1] - by_pressure[0]) / 2e-3, answer.slope, atol=1e-9)


GROWS = GrowingAnchorage(slip=[0.002, 0.01, 0.03], strength=[1e-3, 2e-3, 5e-3])


def growing(anchorage=GROWS, EA=50.0):
    return WireNetwork(2.0, EA, layers("z", 0.2, 60), slack=0.003, anchorage=anchorage)


def test_a_growing_anchorage_is_linear_between_its_points():
    for slip in (0.0, 0.002, 0.005, 0.01, 0.02, 0.03, 0.5):
        chi, slope, end = GROWS.piece(slip)
        assert chi == pytest.approx(np.interp(slip, GROWS.slip, GROWS.strength), rel=1e-14)
        assert end > slip
        ahead = min(end, slip + 1e-3)
        assert chi + slope * (ahead - slip) == pytest.approx(np.interp(ahead, GROWS.slip, GROWS.strength), rel=1e-12)


def test_one_that_does_not_grow_is_a_number():
    rng, slips = np.random.default_rng(10), 0
    one, other = growing(2e-3), growing(GrowingAnchorage([0.0, 0.02], [2e-3, 2e-3]))
    for _ in range(20):
        strain, slip = 0.06 * rng.standard_normal(6), 0.01 * rng.random(len(one.directions))
        mine, theirs = one.respond(strain, slip, 150.0), other.respond(strain, slip, 150.0)
        slips += mine.slope is not None
        for part in ("stress", "stiffness", "slip", "slope")[: 3 + (mine.slope is not None)]:
            np.testing.assert_allclose(getattr(mine, part), getattr(theirs, part), rtol=1e-13)
    assert slips > 10


@given(st.integers(0, 2**31), st.sampled_from([0.0, 5.0, 150.0, 5e4]), st.sampled_from([0.003, 0.03, 0.3]))
def test_the_tension_is_that_of_the_mean_slip_at_the_end(seed, pressure, size):
    """Every wire that slips pulls with chi(m) p, the others with less, and the increment gains no work."""
    rng = np.random.default_rng(seed)
    wire = growing()
    strain, slip = size * rng.standard_normal(6), 0.01 * rng.random(len(wire.directions)) * rng.random()
    answer = wire.respond(strain, slip, pressure)
    chi = GROWS.piece(float(wire.directions.weights @ answer.slip))[0]
    tensions = wire.tensions(strain, answer.slip)
    slipped = answer.slip > slip
    # a tension is a difference of stretches of the given size
    round_off = 1e-14 * wire.axial_rigidity * size
    np.testing.assert_allclose(tensions[slipped], chi * pressure, rtol=1e-11, atol=round_off)
    assert (tensions[~slipped] <= chi * pressure * (1.0 + 1e-12) + round_off).all()
    assert wire.dissipation(strain, slip, answer.slip) >= 0.0


def test_a_stretch_is_the_same_in_one_increment_and_in_many():
    wire, direction = growing(), np.array([0.05, 0.03, -0.06, 0.01, -0.02, 0.01])
    once = wire.respond(direction, np.zeros(len(wire.directions)), 150.0)
    slip = np.zeros(len(wire.directions))
    for part in np.linspace(0.0, 1.0, 301)[1:]:
        many = wire.respond(part * direction, slip, 150.0)
        slip = many.slip
    np.testing.assert_allclose(many.slip, once.slip, atol=1e-15)
    np.testing.assert_allclose(many.stress, once.stress, rtol=1e-12)


@pytest.mark.parametrize("anchorage", [2e-3, GROWS], ids=["a number", "growing"])
@pytest.mark.parametrize("EA", [5.0, 50.0, 5e3])
def test_derivatives_while_wires_slip(anchorage, EA):
    """By strain, symmetric and with no negative eigenvalue, and by the pressure; the seeds meet no kink."""
    wire, pressure, slips = growing(anchorage, EA), 150.0, 0
    for seed in range(5):
        rng = np.random.default_rng(seed)
        strain, slip = 0.06 * rng.standard_normal(6), 0.01 * rng.random(len(wire.directions))
        answer = wire.respond(strain, slip, pressure)
        slips += answer.slope is not None
        slope = np.zeros(6) if answer.slope is None else answer.slope
        found = derivative(lambda e: wire.respond(e, slip, pressure).stress, strain, 1e-8)  # noqa: B023
        np.testing.assert_allclose(found, answer.stiffness, atol=1e-6 * wire.stiffnesses.sum())
        np.testing.assert_allclose(answer.stiffness, answer.stiffness.T, atol=1e-12 * wire.stiffnesses.sum())
        assert np.linalg.eigvalsh(answer.stiffness).min() > -1e-12 * wire.stiffnesses.sum()
        by_pressure = [wire.respond(strain, slip, pressure + step).stress for step in (-1e-3, 1e-3)]
        np.testing.assert_allclose((by_pressure[1] - by_pressure[0]) / 2e-3, slope, atol=1e-8)
    assert slips >= 2


@pytest.mark.parametrize("stretch", [np.nan, np.inf, 1e308])
@pytest.mark.filterwarnings("ignore:.*encountered in:RuntimeWarning")
def test_a_strain_that_is_no_number_ends(stretch):
    """What Newton's method of another code may ask for as it diverges."""
    wire = WireNetwork(1e4, 100.0, layers("z", 0.2, 60), anchorage=GROWS)
    answer = wire.respond(np.array([stretch, 0.0, 0.0, 0.0, 0.0, 0.0]), np.zeros(len(wire.directions)), 1e5)
    pulled = answer.stress[:3].sum()  # all wires at once, each with the greatest strength
    assert np.isnan(pulled) if np.isnan(stretch) else pulled == pytest.approx(1e4 * GROWS.strength[-1] * 1e5)


def test_a_path_with_a_growing_anchorage_is_driven():
    """100 and 400 increments of a triaxial test give the same stresses."""
    sand = DruckerPrager(
        3, critical=0.8, hardening=0.004, peak=0.0, peak_shear=0.03, dilation=0.8, turning=0.7,
        bulk_modulus=1e8, shear_modulus=1e8,
    )  # fmt: skip
    wire = WireNetwork(2e5, 100.0, layers("z", 0.2, 60), anchorage=GrowingAnchorage([0.0, 0.05], [0.2e-6, 1e-6]))
    ends = [triaxial(TexSol(sand, wire), -np.linspace(0.0, 0.1, n + 1)[1:], pressure=1e5) for n in (100, 400)]
    assert ends[0].deviator[-1] == pytest.approx(ends[1].deviator[-1], rel=1e-6)
    assert ends[0].wire[-1, 0] > 1.5 * ends[0].wire[20, 0] > 0.0
    assert max(path.residual.max() for path in ends) <= 1e-10


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: GrowingAnchorage([0.0, 0.0], [1.0, 2.0]), "slip must be growing numbers of at least zero"),
        (lambda: GrowingAnchorage([-0.1, 0.0], [1.0, 2.0]), "slip must be growing numbers of at least zero"),
        (lambda: GrowingAnchorage([0.0, 0.1], [2.0, 1.0]), "strength must be 2 numbers above zero that do not fall"),
        (lambda: GrowingAnchorage([0.0, 0.1], [1.0]), "strength must be 2 numbers above zero"),
        (lambda: GrowingAnchorage([0.0], [0.0]), "strength must be 1 numbers above zero"),
        (lambda: WireNetwork(1.0, 1.0, isotropic(3), anchorage=np.ones(2)), "anchorage must be a number"),
        (lambda: GrowingAnchorage([0.0], ["much"]), "strength must be one number for each slip"),
        (lambda: WireNetwork(0.0, 1.0, isotropic(2)), "length must be above 0"),
        (lambda: WireNetwork(1.0, -1.0, isotropic(2)), "axial_rigidity must be above 0"),
        (lambda: WireNetwork(1.0, 1.0, [[1.0, 0.0]]), "directions must be Directions, such as isotropic"),
        (lambda: WireNetwork(1.0, 1.0, isotropic(2, 5), slack=[0.0, 1.0]), "one for each of the 5 directions"),
        (lambda: WireNetwork(1.0, 1.0, isotropic(2, 5), anchorage=0.0), "anchorage must be above 0"),
        (lambda: WireNetwork(1.0, 1.0, isotropic(2), slak=0.0), "no argument 'slak'; did you mean 'slack'"),
        (lambda: WireNetwork(1.0, 1.0, isotropic(2)).stress([1.0, 2.0]), "strain must be 3 components"),
        (lambda: WireNetwork(1.0, 1.0, isotropic(2)).dual_energy("much"), "stress must be 3 components"),
    ],
)
def test_bad_arguments_are_sentences(call, sentence):
    with pytest.raises((TypeError, ValueError), match=sentence):
        call()
