"""Parameters of a sand from driven paths: they are found again, and their errors are what they scatter by."""

import functools
import math

import numpy as np
import pytest

from lmgcpy.continuum import DruckerPrager, MeasuredCompression, TexSol, biaxial, fit_sand, triaxial
from lmgcpy.continuum.fit import NAMES

P = 1e5
TRUE = dict(critical=0.9, hardening=0.004, peak=0.35, peak_shear=0.03, dilation=0.8, turning=0.7)
STIFF = 3e5
"""Elastic moduli over the pressure of the sand that is measured: strains of 1e-5, which the fit leaves out."""


@functools.cache
def driven(dimension, **change):
    """A path of 600 increments to 15 %."""
    material = TexSol(DruckerPrager(dimension, **{**TRUE, **change}, bulk_modulus=STIFF * P, shear_modulus=STIFF * P))
    test = biaxial if dimension == 2 else triaxial
    return test(material, -np.linspace(0.0, 0.15, 601)[1:], pressure=P, axis="y")


def measured(dimension, seed=0, noise=1.0, memory=0.0, **change):
    """The path with noise of 5 % of the pressure on the axial stress, and of 1e-3 on a lateral strain.

    ``memory``: correlation of the noise from a moment to the next.
    """
    path, rng = driven(dimension, **change), np.random.default_rng(seed)
    stress, strain = path.stress[::2, :dimension].copy(), path.strain[::2, :dimension].copy()
    errors = rng.standard_normal((2, len(stress)))
    for i in range(1, len(stress)):
        errors[:, i] = memory * errors[:, i - 1] + math.sqrt(1.0 - memory**2) * errors[:, i]
    stress[:, 1] -= noise * 0.05 * P * errors[0]
    strain[:, 0] += noise * 1e-3 * errors[1]
    return MeasuredCompression("y", strain, stress)


@pytest.mark.parametrize("dimension", [2, 3])
def test_a_path_without_noise_gives_its_parameters_back(dimension):
    """But for the elastic strains, which make some 1e-3 of a parameter."""
    found = fit_sand(measured(dimension, noise=0.0))
    for name, value in TRUE.items():
        assert found.values[name] == pytest.approx(value, rel=2e-3), name
    assert found.notes == ()
    assert found.misfit["friction"] < 1e-4
    sand = found.sand()
    assert sand.bulk_modulus == pytest.approx(1000 * P, rel=0.05)  # its first moment has a deviator
    again = (biaxial if dimension == 2 else triaxial)(
        TexSol(found.sand(STIFF * P, STIFF * P)), driven(dimension).axial_strain, pressure=P, axis="y"
    )
    scale = driven(dimension).deviator.max()
    np.testing.assert_allclose(again.deviator, driven(dimension).deviator, atol=5e-3 * scale)
    np.testing.assert_allclose(again.volume_change, driven(dimension).volume_change, atol=2e-4)


@pytest.mark.parametrize("dimension", [2, 3])
def test_with_its_moduli_a_path_gives_its_parameters_back_to_the_order_of_its_increments(dimension):
    """600 increments of second order make some 1e-4; elastic strains of 4e-4 of a, left in, make 4e-4 to 7e-4 of it."""
    for stiff, bound in ((STIFF, 2e-4), (STIFF / 100.0, 4e-4)):
        material = TexSol(DruckerPrager(dimension, **TRUE, bulk_modulus=stiff * P, shear_modulus=2.0 * stiff * P))
        path = (biaxial if dimension == 2 else triaxial)(material, -np.linspace(0.0, 0.15, 601)[1:], pressure=P, axis="y")
        data = MeasuredCompression("y", path.strain[:, :dimension], path.stress[:, :dimension])
        found = fit_sand(data, bulk_modulus=stiff * P, shear_modulus=2.0 * stiff * P)
        for name, value in TRUE.items():
            assert found.values[name] == pytest.approx(value, rel=bound), name
    with pytest.raises(ValueError, match="shear_modulus must be above 0 Pa"):
        fit_sand(data, shear_modulus=0.0)


@pytest.mark.long
@pytest.mark.parametrize(("dimension", "memory"), [(2, 0.0), (3, 0.8)])
def test_standard_errors_are_what_50_noisy_draws_scatter_by(dimension, memory):
    """A standard deviation of 50 draws is known to 10 %, so its ratio lies in 0.7 to 1.3; 1.45 where noise has a memory.

    (x - true)/error has mean square 1, and the mean of the draws is known to 0.14 of an error; the true values are those
    of the path without noise, as its elastic strains make up to some errors of a.
    """
    fits = [fit_sand(measured(dimension, seed, memory=memory)) for seed in range(50)]
    values = np.array([[fit.values[name] for name in NAMES] for fit in fits])
    errors = np.array([[fit.errors[name] for name in NAMES] for fit in fits])
    exact = fit_sand(measured(dimension, noise=0.0))
    true = np.array([exact.values[name] for name in NAMES])
    ratio = values.std(axis=0, ddof=1) / np.median(errors, axis=0)
    assert ratio.min() > 0.7
    assert ratio.max() < (1.3 if memory == 0.0 else 1.45)
    assert np.sqrt((((values - true) / errors) ** 2).mean(axis=0)).max() < 1.5
    assert (np.abs(values.mean(axis=0) - true) < 0.6 * np.median(errors, axis=0)).all()
    times = np.mean([f.correlated["volume"] for f in fits])
    assert times == pytest.approx((1 + memory) / (1 - memory), rel=0.3)


def test_several_compressions_know_more_than_one():
    """Errors of nine are a third of those of one."""
    one = fit_sand(measured(3, 0))
    nine = fit_sand([measured(3, seed) for seed in range(9)])
    for name in NAMES:
        assert nine.errors[name] == pytest.approx(one.errors[name] / 3, rel=0.25), name
        assert abs(nine.values[name] - TRUE[name]) < 3.5 * nine.errors[name] + 0.005 * TRUE[name], name


def test_a_loose_sand_without_a_peak_is_fitted():
    found = fit_sand(measured(3, 3, peak=0.0, turning=0.9))
    assert found.values["critical"] == pytest.approx(0.9, abs=0.02)
    greatest = max(found.sand().friction(k) for k in np.linspace(0.0, 0.15, 50))
    assert greatest == pytest.approx(0.9, abs=0.03)


@pytest.mark.long
def test_what_a_path_does_not_show_is_said():
    """Dilatancy of a path that ends where q/p is constant from the start: beta and M_d are one number."""
    path = driven(3, hardening=1e-6, peak=0.0)
    found = fit_sand(MeasuredCompression("y", path.strain[5:, :3], path.stress[5:, :3]))
    assert found.values["critical"] == pytest.approx(0.9, rel=1e-3)
    assert found.values["dilation"] * (0.9 - found.values["turning"]) == pytest.approx(0.8 * 0.2, abs=2e-3)
    assert "There is no peak: peak is zero and peak_shear has no meaning." in found.notes
    assert math.isinf(found.errors["peak"])


@pytest.mark.parametrize("seed", range(3))
def test_a_fit_is_always_a_sand(seed):
    """Dilation beyond what gains no work is held at it: a fit of nonsense is one that DruckerPrager takes."""
    rng = np.random.default_rng(seed)
    strain = np.stack([np.linspace(0, 0.3, 60), -np.linspace(0, 0.1, 60)], axis=1)
    stress = -P * (1.0 + np.abs(rng.standard_normal((60, 2))))
    found = fit_sand(MeasuredCompression("y", strain, stress)).sand()
    assert all(found.dilatancy(k) <= found.friction(k) + 1e-9 for k in np.linspace(0, 1, 50))


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: fit_sand("run"), "measured must be a MeasuredCompression or a list of them"),
        (lambda: fit_sand([]), "measured must be a MeasuredCompression or a list of them"),
        (lambda: fit_sand([measured(2), measured(3)]), "must be of one dimension"),
        (lambda: MeasuredCompression("z", np.zeros((30, 2)), np.zeros((30, 2))), "axis cannot be 'z'"),
        (lambda: MeasuredCompression("y", np.zeros((30, 2)), np.zeros((30, 3))), "stress must have the shape of strain"),
        (lambda: MeasuredCompression("y", np.zeros((3, 2)), np.zeros((3, 2))), "at least 20 moments"),
        (lambda: MeasuredCompression("y", np.zeros((30, 2)), np.zeros((30, 2))), "mean pressure must be above zero"),
        (lambda: MeasuredCompression("y", np.zeros((30, 2)), -np.ones((30, 2))), "compression is negative"),
    ],
)
def test_bad_arguments_are_sentences(call, sentence):
    with pytest.raises((TypeError, ValueError), match=sentence):
        call()
