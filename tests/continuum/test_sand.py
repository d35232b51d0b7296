"""The return mapping of the sand: its tangent, its limits, closed forms, dissipation and order."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from test_directions import rotation

from lmgcpy.continuum import DruckerPrager, TexSol, biaxial, triaxial, turn
from lmgcpy.continuum.sand import SHAPE
from lmgcpy.continuum.tensors import SIZE, identity

P = 1e5
"""Pressure [Pa]."""


def sand(dimension=3, stiff=1000.0, **change):
    given = dict(critical=0.9, hardening=0.004, peak=0.35, peak_shear=0.03, dilation=0.8, turning=0.7)
    given |= {"bulk_modulus": stiff * P, "shear_modulus": 0.7 * stiff * P, **change}
    return DruckerPrager(dimension, **given)


def walk(material, rng, count, size):
    """States on a random walk of strain from the pressure P: (increment, stress, kappa, answer) at each step."""
    stress, kappa = -P * identity(material.dimension), 0.0
    drift = rng.standard_normal(SIZE[material.dimension])
    for _ in range(count):
        increment = size * (0.5 * rng.standard_normal(len(drift)) + drift)
        increment -= identity(material.dimension) * size * rng.uniform(0.0, 0.5)
        answer = material.respond(increment, stress, kappa)
        yield increment, stress, kappa, answer
        stress, kappa = answer.stress, answer.kappa


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("size", [1e-8, 1e-6, 1e-4, 1e-3, 1e-2, 0.1])
def test_every_return_is_on_the_yield_surface(dimension, size):
    """q = M p to the round-off of the trial stress, for increments of all sizes."""
    material, flowed = sand(dimension), 0
    for increment, stress, kappa, answer in walk(material, np.random.default_rng(0), 40, size):
        p, q = material.invariants(answer.stress)
        trial = np.linalg.norm(stress + material.elastic @ increment)
        assert answer.kappa >= kappa
        assert p >= 0.0
        assert q <= material.friction(answer.kappa) * p + 1e-13 * trial
        if answer.kappa > kappa:
            flowed += 1
            assert q == pytest.approx(material.friction(answer.kappa) * p, abs=1e-13 * trial)
    assert flowed > 10


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("size", [1e-6, 1e-4, 1e-2])
def test_the_tangent_is_the_derivative(dimension, size):
    """Central differences of 1e-5 of the increment: an error of ~1e-8 of the elastic stiffness."""
    material = sand(dimension)
    for increment, stress, kappa, answer in walk(material, np.random.default_rng(1), 15, size):
        step = 1e-5 * np.linalg.norm(increment)
        units = step * np.eye(len(increment))
        ahead, behind = ([material.respond(increment + sign * u, stress, kappa).stress for u in units] for sign in (1, -1))
        found = (np.array(ahead) - np.array(behind)).T / (2 * step)
        np.testing.assert_allclose(answer.tangent, found, atol=1e-5 * material.bulk_modulus)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_turned_sample_has_the_turned_stress(dimension):
    rng = np.random.default_rng(2)
    material, T = sand(dimension), turn(rotation(rng, dimension))
    for increment, stress, kappa, answer in walk(material, rng, 20, 1e-3):
        other = material.respond(T @ increment, T @ stress, kappa)
        np.testing.assert_allclose(other.stress, T @ answer.stress, atol=1e-9 * P)
        np.testing.assert_allclose(other.tangent, T @ answer.tangent @ T.T, atol=1e-9 * material.bulk_modulus)
        assert other.kappa == pytest.approx(answer.kappa, rel=1e-9)


@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("critical", [0.0, 1e-17, 1e-15])
def test_sand_without_friction_keeps_its_pressure(dimension, critical):
    """It loses its deviator, and round-off at the end of the way is no lack of a root."""
    material = sand(dimension, critical=critical, peak=0.0, dilation=0.0)
    rng = np.random.default_rng(4)
    for _ in range(200):
        increment = 1e-3 * rng.standard_normal(SIZE[dimension])
        increment[:dimension] -= increment[:dimension].mean()
        p, q = material.invariants(material.respond(increment, -P * identity(dimension), 0.0).stress)
        assert p == pytest.approx(P, rel=1e-12)
        assert q <= 1e-10 * P


@given(st.integers(0, 2**31), st.sampled_from([2, 3]), st.sampled_from([1e-5, 1e-3, 1e-2]), st.floats(0.0, 1.0))
def test_flow_never_gains_work(seed, dimension, size, dilation):
    """sigma . deps_p = p (M dgamma - V), deps_p what the elastic part does not hold, M at the end of the increment and V
    the dilation in it; V is at most the integral of M, which Simpson's rule has to 1e-4 of dgamma at these increments."""
    rng = np.random.default_rng(seed)
    material = sand(dimension, dilation=dilation, turning=rng.uniform(0.0, 1.0), peak=rng.uniform(0.0, 0.8))
    compliance = np.linalg.inv(material.elastic)
    for increment, stress, kappa, answer in walk(material, rng, 15, size):
        plastic = increment - compliance @ (answer.stress - stress)
        lost = float(answer.stress @ plastic)
        p, _ = material.invariants(answer.stress)
        if p > 0.0 and answer.kappa > kappa:
            gamma = answer.kappa - kappa
            M, V = material.friction(answer.kappa), material.dilated(kappa, gamma)
            assert quad(material.friction, kappa, answer.kappa)[0] - V >= -1e-12
            assert lost == pytest.approx(p * (M * gamma - V), rel=1e-6, abs=1e-10 * P)


@pytest.mark.parametrize("dimension", [2, 3])
def test_flow_has_the_shear_and_the_dilation_that_are_stated(dimension):
    """deps_p: its trace is the integral of D, and its part along s does the work q dgamma."""
    material = sand(dimension)
    compliance = np.linalg.inv(material.elastic)
    for increment, stress, kappa, answer in walk(material, np.random.default_rng(3), 20, 1e-3):
        plastic, gamma = increment - compliance @ (answer.stress - stress), answer.kappa - kappa
        p, q = material.invariants(answer.stress)
        dilation = quad(material.dilatancy, kappa, answer.kappa, epsabs=1e-14)[0]
        assert plastic[:dimension].sum() == pytest.approx(dilation, abs=1e-12)
        shear = answer.stress + p * identity(dimension)
        assert shear @ plastic == pytest.approx(q * gamma, abs=1e-9 * P)


def test_no_pressure_no_stress():
    """A sample that is stretched in all directions is at the apex, and one that is compressed afterwards carries again."""
    material = sand()
    stretched = material.respond(0.01 * identity(3), -P * identity(3), 0.0)
    assert not stretched.stress.any()
    assert not stretched.tangent.any()
    sheared = material.respond(0.01 * identity(3) + np.array([0, 0, 0, 0, 0, 1e-3]), -P * identity(3), 0.0)
    assert not sheared.stress.any()
    assert sheared.kappa == pytest.approx(1e-3 / SHAPE[3])  # all of the shear is lost
    again = material.respond(-0.001 * identity(3), stretched.stress, stretched.kappa)
    assert material.invariants(again.stress)[0] == pytest.approx(0.003 * material.bulk_modulus)


def test_unloading_is_elastic():
    material = TexSol(sand())
    loaded = triaxial(material, -np.linspace(0.0, 0.02, 101)[1:], pressure=P)
    back = np.array([1e-5, 0, 0, 0, 0, 0.0])[[1, 1, 0, 3, 4, 5]]
    answer = material.material_point(back, loaded.state)
    np.testing.assert_array_equal(answer.tangent, material.sand.elastic)
    np.testing.assert_allclose(answer.stress, loaded.state.stress + material.sand.elastic @ back, rtol=1e-13)
    assert answer.state.kappa == loaded.state.kappa


@pytest.mark.parametrize("test", [triaxial, biaxial])
def test_constant_friction_and_dilatancy(test):
    """q/p = M, dilation D per shear: q/p_lateral = M/(1 - M/d), d eps_v = D dgamma, -d eps_axial = (1 - D/d) dgamma."""
    d = 3 if test is triaxial else 2
    material = sand(d, critical=0.8, hardening=1e-7, peak=0.0, dilation=0.9, turning=0.5)
    path = test(TexSol(material), -np.linspace(0.0, 0.05, 201)[1:], pressure=P)
    M, D = 0.8, 0.9 * 0.3
    np.testing.assert_allclose(path.deviator[20:], P * M / (1 - M / d), rtol=1e-9)
    np.testing.assert_allclose(np.diff(path.volume_change)[20:], D * np.diff(path.kappa)[20:], rtol=1e-6)
    np.testing.assert_allclose(np.diff(path.axial_strain)[20:], -(1 - D / d) * np.diff(path.kappa)[20:], rtol=1e-6)


def test_friction_angles():
    """2D is Mohr-Coulomb, sin phi = M/2; in 3D triaxial compression M = 6 sin phi/(3 - sin phi)."""
    for test, d, sine in ((biaxial, 2, 0.8 / 2), (triaxial, 3, 3 * 0.8 / (6 + 0.8))):
        material = TexSol(sand(d, critical=0.8, hardening=1e-5, peak=0.0))
        stress = test(material, -np.linspace(0.0, 0.02, 51)[1:], pressure=P).stress[-1]
        greatest, least = -stress[:d].min(), -stress[:d].max()
        assert (greatest - least) / (greatest + least) == pytest.approx(sine, rel=1e-9)


@pytest.mark.default_parameters(stiff=(1e5,))
@pytest.mark.parametrize("stiff", [3e3, 1e5])
def test_the_path_is_that_of_the_formulas_of_rigid_grains(stiff):
    """q/p = M(kappa), and dilation beta (integral of M - M_d kappa) less the elastic (p - p_0)/K, both exactly."""
    material = sand(3, stiff)
    path = triaxial(TexSol(material), -np.linspace(0.0, 0.1, 2001)[1:], pressure=P)
    k, (a, b) = path.kappa, (material.hardening, material.peak_shear)
    M = np.array([material.friction(value) for value in k])
    np.testing.assert_allclose(path.deviator / P, M / (1 - M / 3), rtol=1e-8)
    area = material.critical * (k + a * np.expm1(-k / a)) + material.peak * math.e * b * (1 - (1 + k / b) * np.exp(-k / b))
    volume = material.dilation * (area - material.turning * k) - path.deviator / 3 / material.bulk_modulus
    np.testing.assert_allclose(path.volume_change, volume, atol=1e-11)


def test_results_do_not_depend_on_the_elastic_stand_in():
    """The curves move along the strain by q/(2 c^2 G) ~ 2e-3 at 500 pressures, and by less as 1/K. The slope of q/p is up
    to 80 there, from 1 % of strain on, and that of the volume up to 1."""
    strain = -np.linspace(0.0, 0.1, 401)[1:]
    paths = [triaxial(TexSol(sand(3, stiff)), strain, pressure=P) for stiff in (500, 2000, 8000, 1e6)]
    q = [np.abs(path.deviator - paths[-1].deviator)[40:].max() / P for path in paths[:3]]
    v = [np.abs(path.volume_change - paths[-1].volume_change).max() for path in paths[:3]]
    for errors, at_500 in ((q, 0.2), (v, 5e-3)):
        assert errors[0] < at_500
        assert errors[1] < 0.35 * errors[0]
        assert errors[2] < 0.35 * errors[1]


@pytest.mark.parametrize("kappa", [0.0, 1e-6, 0.02, 0.5])
@pytest.mark.parametrize("gamma", [1e-12, 1e-6, 1e-2, 0.3])
def test_the_dilation_of_an_increment_keeps_its_digits(kappa, gamma):
    """Against Gauss' rule in pieces that are short for a = 0.004."""
    material, (nodes, weights) = sand(), np.polynomial.legendre.leggauss(12)
    parts = np.linspace(0.0, 1.0, 201)[:-1, None] + (nodes + 1.0) / 400
    rates = [[material.dilatancy(kappa + gamma * part) for part in row] for row in parts]
    exact = gamma / 400 * float((rates @ weights).sum())
    assert material.dilated(kappa, gamma) == pytest.approx(exact, rel=1e-8, abs=1e-12 * gamma)


@pytest.mark.default_parameters("triaxial")
@pytest.mark.parametrize("test", [triaxial, biaxial])
def test_increments_of_a_compression_make_no_error(test):
    """The volume after 4 % of strain in 1, 7 and 2000 increments, to the 1e-10 to which stresses are met over K/p."""
    material = TexSol(sand(3 if test is triaxial else 2))
    ends = [test(material, -np.linspace(0.0, 0.04, n + 1)[1:], pressure=P).volume_change[-1] for n in (1, 7, 2000)]
    assert ends[:2] == pytest.approx([ends[2]] * 2, abs=1e-11)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"critical": -0.1}, "critical must be at least 0"),
        ({"hardening": 0.0}, "hardening must be above 0"),
        ({"peak": "high"}, "peak must be a number"),
        ({"critical": 2.9}, r"critical \+ peak must be below 3 in 3D, got 3.25"),
        ({"dilation": 2.5}, "dilation 2.5 is too large: where q/p is .* 1.25 the sand would dilate by 1.375"),
        ({"bulk_modulus": math.inf}, "bulk_modulus must be finite"),
        ({"dilatency": 1.0}, "no argument 'dilatency'"),
    ],
)
def test_bad_arguments_are_sentences(change, sentence):
    with pytest.raises((TypeError, ValueError), match=sentence):
        sand(**change)


def test_a_dilation_above_one_is_taken_where_it_gains_no_work():
    """beta (M_c + B - M_d) <= M_c + B: 2 (1.25 - 0.7) = 1.1."""
    assert sand(dilation=2.0).dilatancy(0.03) < sand(dilation=2.0).friction(0.03)
