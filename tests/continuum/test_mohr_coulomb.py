"""The return to the planes and edges of Mohr and Coulomb: against a linear complementarity problem, Drucker and Prager in
compression, closed forms, differences."""

from itertools import chain, combinations, pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from test_directions import rotation
from test_sand import P, sand, walk

from lmgcpy.continuum import DruckerPrager, MohrCoulomb, TexSol, biaxial, drive, tensor_of, triaxial, turn
from lmgcpy.continuum.tensors import identity


def coulomb(**change):
    """A sand with the numbers of test_sand."""
    like = sand(3, **change)
    names = ("critical", "hardening", "peak", "peak_shear", "dilation", "turning", "bulk_modulus", "shear_modulus")
    return MohrCoulomb(3, **{name: getattr(like, name) for name in names})


def principal(stress):
    """Pressures, the greatest first."""
    return -np.linalg.eigvalsh(tensor_of(stress))


def ratio(material, kappa):
    M = material.friction(kappa)
    return (3.0 + 2.0 * M) / (3.0 - M)


@pytest.mark.parametrize("size", [1e-8, 1e-6, 1e-4, 1e-3, 1e-2, 0.1])
def test_every_return_is_on_the_yield_surface(size):
    """p1 = N p3 to the round-off of the trial stress, for increments of all sizes."""
    material, flowed = coulomb(), 0
    for increment, stress, kappa, answer in walk(material, np.random.default_rng(0), 40, size):
        pressures = principal(answer.stress)
        round_off = 1e-13 * np.linalg.norm(stress + material.elastic @ increment)
        assert answer.kappa >= kappa
        assert pressures[2] >= -round_off
        assert pressures[0] <= ratio(material, answer.kappa) * pressures[2] + round_off
        if answer.kappa > kappa:
            flowed += 1
            assert pressures[0] == pytest.approx(ratio(material, answer.kappa) * pressures[2], abs=10 * round_off)
    assert flowed > 10


def test_the_stress_falls_to_zero_without_a_jump():
    """Ever less pressure at the same shear. Contraction takes p3 below zero on the way to the root: taken for its end,
    27 kPa fell to zero at once. A stress falls by no more than the trial, within a factor for the edges."""
    material = coulomb(critical=0.9, hardening=0.004, peak=0.35, peak_shear=0.03, dilation=0.8, turning=0.7)
    trial = np.array([3.5, 0.8, -2.4, 0.0, 0.0, 0.0]) * P
    step = 0.005 * P
    strain = np.linalg.solve(material.elastic, -np.eye(6)[:3].sum(axis=0) * step)
    stresses = []
    for k in range(-60, 140):
        increment = np.linalg.solve(material.elastic, -trial) + k * strain
        stresses.append(material.respond(increment, np.zeros(6), 1e-3).stress)
    assert np.abs(stresses[0]).max() < 1e-9 * P
    assert principal(stresses[-1])[0] > 0.9 * P
    assert np.abs(np.diff(stresses, axis=0)).max() < 10.0 * step


@pytest.mark.parametrize("increments", [1, 10, 100])
def test_it_loses_all_pressure_as_drucker_and_pragers_sand_does(increments):
    """A triaxial compression at constant volume, over the apex and on: the same digits. The apex is reached over an edge,
    where the difference of the plastic strains is 3/2 of the shear; 2, as on a plane, gave 5 to 13 % less pressure."""
    compression = np.array([0.5, 0.5, -1.0, 0.0, 0.0, 0.0]) * 0.02
    given = {"dilation": 0.8, "bulk_modulus": 2e3 * P, "shear_modulus": 1e3 * P}
    ends = []
    for material in (coulomb(**given), sand(3, **given)):
        stress, kappa = -P * material.unit, 0.0
        for _ in range(increments):
            stress, _, kappa = material.respond(compression / increments, stress, kappa)
        ends.append([*stress / P, kappa])
    np.testing.assert_allclose(*ends, rtol=1e-9, atol=1e-9)


KINDS = ["any", "compression", "extension"]


@given(st.integers(0, 2**31), st.floats(0.2, 1.6), st.floats(0.0, 1.0), st.sampled_from(KINDS))
def test_it_is_the_solution_of_a_linear_complementarity_problem(seed, M, D, kind):
    """With constant friction and dilatancy every plane ``p_i <= N p_j`` has a flow of its own, which is not negative, and
    none off the plane. Both flows of an edge count in the plastic shear. All sets of planes are tried."""
    rng = np.random.default_rng(seed)
    # M and D are constant where kappa is far beyond the hardening, and D is dilation (M - turning)
    material = coulomb(critical=M, hardening=1e-4, peak=0.0, dilation=1.0, turning=M - min(D, M))
    N, D, G = ratio(material, 1.0), min(D, M), material.shear_modulus
    lame = material.bulk_modulus - 2 / 3 * G
    trial = P * (1.0 + 0.8 * rng.standard_normal(3))
    if kind != "any":
        pair = rng.uniform(0.9, 1.1) * P + 1e-3 * P * rng.standard_normal(2)
        trial = np.array([*pair, P * (4.0 if kind == "compression" else 0.1)])
    trial = np.sort(trial + 0.3 * P)[::-1]
    answer = material.respond(np.zeros(6), np.concatenate([-trial, np.zeros(3)]), 1.0)
    planes = [(0, 2), (0, 1), (1, 2)]
    found = []
    for active in chain.from_iterable(combinations(planes, n) for n in range(3)):
        flows = [np.eye(3)[i] * (1 - D / 3) - np.eye(3)[j] * (1 + 2 * D / 3) for i, j in active]
        relax = [lame * -flow.sum() - 2 * G * flow for flow in flows]  # sum of a flow: -D
        matrix = np.array([[r[i] - N * r[j] for r in relax] for i, j in active]).reshape(len(active), len(active))
        shear = np.linalg.solve(matrix, [N * trial[j] - trial[i] for i, j in active]) if active else np.zeros(0)
        p = trial + sum((g * r for g, r in zip(shear, relax, strict=True)), np.zeros(3))
        close = 1e-9 * np.abs(trial).max()
        if (shear >= 0).all() and all(p[i] <= N * p[j] + close for i, j in planes) and p.min() > 0.0:
            if active and (np.diff(p) > close).any():
                continue  # the order has changed: other planes
            found.append((p, shear.sum()))
    if found:
        for p, shear in found:  # several sets only where planes meet
            np.testing.assert_allclose(principal(answer.stress), p, atol=1e-8 * np.abs(trial).max())
            assert answer.kappa - 1.0 == pytest.approx(shear, abs=1e-12)


@pytest.mark.parametrize("size", [1e-6, 1e-4, 1e-2])
def test_the_tangent_is_the_derivative(size):
    """Central differences of 1e-5 of the increment: an error of ~1e-8 of the elastic stiffness, on planes and on edges."""
    material = coulomb()
    states = list(walk(material, np.random.default_rng(1), 15, size))
    path = triaxial(TexSol(material), -np.linspace(0.0, 0.02, 21)[1:], pressure=P)
    for sign in (1.0, -1.0):  # on the edge, pushed along it, and to the other one
        push = sign * size * np.array([0.5, 0.49, -1.0, 0.1, 0.02, 0.05])
        stress = path.sand[-1]
        states.append((push, stress, path.kappa[-1], material.respond(push, stress, path.kappa[-1])))
    for increment, stress, kappa, answer in states:
        step = 1e-5 * np.linalg.norm(increment)
        units = step * np.eye(len(increment))
        ahead, behind = ([material.respond(increment + sign * u, stress, kappa).stress for u in units] for sign in (1, -1))
        found = (np.array(ahead) - np.array(behind)).T / (2 * step)
        np.testing.assert_allclose(answer.tangent, found, atol=1e-5 * material.bulk_modulus)


def test_the_tangent_where_two_pressures_are_equal():
    """If they are equal before and after the return: on the edge of compressions they stay equal, so that a shear of
    these two directions meets no resistance; a shear of the others meets G."""
    material = coulomb()
    path = triaxial(TexSol(material), -np.linspace(0.0, 0.02, 21)[1:], pressure=P)
    answer = material.respond(1e-4 * np.array([0.5, 0.5, -1.0, 0, 0, 0]), path.sand[-1], path.kappa[-1])
    assert answer.tangent[5, 5] == pytest.approx(0.0, abs=1e-6 * material.bulk_modulus)
    assert 0.0 < answer.tangent[3, 3] < 2.0 * material.shear_modulus


def test_a_turned_sample_has_the_turned_stress():
    rng = np.random.default_rng(2)
    material, T = coulomb(), turn(rotation(rng, 3))
    for increment, stress, kappa, answer in walk(material, rng, 20, 1e-3):
        other = material.respond(T @ increment, T @ stress, kappa)
        np.testing.assert_allclose(other.stress, T @ answer.stress, atol=1e-9 * P)
        np.testing.assert_allclose(other.tangent, T @ answer.tangent @ T.T, atol=1e-9 * material.bulk_modulus)
        assert other.kappa == pytest.approx(answer.kappa, rel=1e-9)


def test_a_triaxial_compression_is_that_of_drucker_and_prager():
    strain = -np.linspace(0.0, 0.1, 101)[1:]
    mine, theirs = (triaxial(TexSol(material), strain, pressure=P) for material in (coulomb(), sand(3)))
    np.testing.assert_allclose(mine.deviator, theirs.deviator, rtol=1e-9)
    np.testing.assert_allclose(mine.volume_change, theirs.volume_change, atol=1e-12)
    np.testing.assert_allclose(mine.kappa, theirs.kappa, rtol=1e-9)


def test_extension_and_plane_strain_have_the_same_friction_angle():
    """N = (1 + sin phi)/(1 - sin phi), whatever p2; Drucker and Prager's sand is stronger by far in both."""
    parameters = {"critical": 0.8, "hardening": 1e-5, "peak": 0.0}
    strain = -np.linspace(0.0, 0.02, 51)[1:]
    flat = biaxial(TexSol(coulomb(**parameters)), strain, pressure=P, axis="z", normal="y")
    extended = np.tile([np.nan, np.nan, 0.0, 0.0, 0.0, 0.0], (50, 1))
    extended[:, 2] = np.linspace(0.0, 0.02, 51)[1:]
    held = np.tile([-P, -P, np.nan, np.nan, np.nan, np.nan], (50, 1))
    material = TexSol(coulomb(**parameters))
    extension = drive(material, material.start(P), extended, held)
    for path in (flat, extension):
        p = principal(path.stress[-1])
        assert p[0] / p[2] == pytest.approx(ratio(coulomb(**parameters), 1.0), rel=1e-9)
    p = principal(biaxial(TexSol(sand(3, **parameters)), strain, pressure=P, axis="z", normal="y").stress[-1])
    assert p[0] / p[2] > 1.2 * ratio(coulomb(**parameters), 1.0)


@given(st.integers(0, 2**31), st.sampled_from([1e-5, 1e-3, 1e-2]), st.floats(0.0, 1.0))
def test_flow_never_gains_work(seed, size, dilation):
    """sigma . deps_p = p3 (N (gamma - V/3) - gamma - 2 V/3) for V, the integral of D, at most the integral of M."""
    rng = np.random.default_rng(seed)
    material = coulomb(dilation=dilation, turning=rng.uniform(0.0, 1.0), peak=rng.uniform(0.0, 0.8))
    compliance = np.linalg.inv(material.elastic)
    for increment, stress, kappa, answer in walk(material, rng, 15, size):
        plastic = increment - compliance @ (answer.stress - stress)
        p3, gamma = principal(answer.stress)[2], answer.kappa - kappa
        if p3 > 0.0 and gamma > 0.0:
            V = material.dilated(kappa, gamma)
            lost = p3 * (ratio(material, answer.kappa) * (gamma - V / 3) - gamma - 2 * V / 3)
            assert float(answer.stress @ plastic) == pytest.approx(lost, rel=1e-6, abs=1e-10 * P)


def test_on_a_plane_the_intermediate_direction_does_not_flow():
    material = coulomb()
    stress = -P * np.array([1.0, 1.3, 1.8, 0.0, 0.0, 0.0])
    increment = 1e-3 * np.array([0.6, 0.0, -1.0, 0.0, 0.0, 0.0])
    answer = material.respond(increment, stress, 0.01)
    plastic = increment - np.linalg.inv(material.elastic) @ (answer.stress - stress)
    assert answer.kappa > 0.01
    np.testing.assert_allclose(plastic[[1, 3, 4, 5]], 0.0, atol=1e-15)
    assert plastic[:3].sum() == pytest.approx(material.dilated(0.01, answer.kappa - 0.01), rel=1e-9)


@pytest.mark.parametrize("hardening", [3e-5, 4e-3])
def test_contraction_is_limited_where_it_would_be_faster_than_the_shear_allows(hardening):
    """beta M_d = 8.4: D is -3/2 until M reaches M_d - 3/2/beta, and its integral follows."""
    material = coulomb(critical=0.85, hardening=hardening, peak=0.02, dilation=10.0, turning=0.84)
    assert material.dilatancy(0.0) == -1.5
    assert material.friction(material.steep) == pytest.approx(0.84 - 0.15, rel=1e-9)
    for kappa, gamma in ((0.0, 2 * material.steep), (0.5 * material.steep, 0.3 * material.steep), (0.0, 0.1), (0.02, 0.1)):
        pieces = np.unique(np.clip([kappa, material.steep, kappa + gamma], kappa, kappa + gamma))
        exact = sum(quad(material.dilatancy, *ends)[0] for ends in pairwise(pieces))
        assert material.dilated(kappa, gamma) == pytest.approx(exact, rel=1e-6, abs=1e-12)
    path = triaxial(TexSol(material), -np.linspace(0.0, 0.1, 51)[1:], pressure=P)
    np.testing.assert_allclose(path.stress[:, 0], path.stress[:, 1], rtol=1e-9)
    assert path.strain[-1, 0] == pytest.approx(path.strain[-1, 1], rel=1e-6)
    assert coulomb().steep == 0.0


def test_no_pressure_no_stress():
    material = coulomb()
    stretched = material.respond(0.01 * identity(3) + np.array([0, 0, 0, 0, 0, 1e-3]), -P * identity(3), 0.0)
    assert not stretched.stress.any()
    assert not stretched.tangent.any()
    assert stretched.kappa > 0.0
    again = material.respond(-0.001 * identity(3), stretched.stress, stretched.kappa)
    np.testing.assert_allclose(principal(again.stress), 0.003 * material.bulk_modulus)


def test_in_two_dimensions_it_is_told_that_the_other_is_the_same():
    with pytest.raises(ValueError, match="in 2D DruckerPrager is the law of Mohr and Coulomb"):
        MohrCoulomb(2, 0.9, 0.004, 0.35, 0.03, 0.8, 0.7, 1e8, 1e8)
    assert isinstance(sand(2), DruckerPrager)
