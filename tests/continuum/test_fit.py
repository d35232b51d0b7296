"""Parameters of a sand from driven paths: they are found again, and their errors are what they scatter by."""

import functools
import math

import numpy as np
import pytest

from lmgcpy.continuum import DruckerPrager, MeasuredCompression, TexSol, biaxial, fit_sand, triaxial
from lmgcpy.continuum.fit import NAMES

P = 1e5
TRUE = dict(critical=0.9, hardening=0.004, peak=0.35, peak_shear=0.03, dilation=0.8, turning=0.7)
RIGID = dict(bulk_modulus=math.inf, shear_modulus=math.inf)


@functools.cache
def driven(dimension, stiff=3e5, **change):
    """A path of 600 increments to 15 %, with moduli of ``stiff`` and twice as much over the pressure."""
    material = TexSol(DruckerPrager(dimension, **{**TRUE, **change}, bulk_modulus=stiff * P, shear_modulus=2.0 * stiff * P))
    test = biaxial if dimension == 2 else triaxial
    return test(material, -np.linspace(0.0, 0.15, 601)[1:], pressure=P, axis="y")


def measured(dimension, seed=0, noise=1.0, memory=0.0, stiff=3e5, **change):
    """The path with noise of 5 % of the pressure on the axial stress, and of 1e-3 on a lateral strain.

    ``memory``: correlation of the noise from a moment to the next.
    """
    path, rng = driven(dimension, stiff, **change), np.random.default_rng(seed)
    stress, strain = path.stress[::2, :dimension].copy(), path.strain[::2, :dimension].copy()
    errors = rng.standard_normal((2, len(stress)))
    for i in range(1, len(stress)):
        errors[:, i] = memory * errors[:, i - 1] + math.sqrt(1.0 - memory**2) * errors[:, i]
    stress[:, 1] -= noise * 0.05 * P * errors[0]
    strain[:, 0] += noise * 1e-3 * errors[1]
    return MeasuredCompression("y", strain, stress)


@pytest.mark.default_parameters("weak1-1000.0-3")
@pytest.mark.parametrize("dimension", [2, 3])
@pytest.mark.parametrize("stiff", [30.0, 1e3, 1e5])
@pytest.mark.parametrize("weak", [{}, dict(peak=0.1, peak_shear=0.06, dilation=1.0, turning=0.85)])
def test_a_path_without_noise_gives_its_parameters_and_moduli_back(dimension, stiff, weak):
    """To the error that is stated, which is that of residuals of 1e-9."""
    found = fit_sand(measured(dimension, noise=0.0, stiff=stiff, **weak))
    for name, value in {**TRUE, **weak}.items():
        assert found.errors[name] < 1e-6 * value, name
        assert abs(found.values[name] - value) < found.errors[name], name
    for name, modulus in (("bulk_modulus", stiff * P), ("shear_modulus", 2.0 * stiff * P)):
        assert abs(found.elastic[name] - found.pressure / modulus) < found.elastic_errors[name] < 1e-8, name
    assert found.notes == ()
    sand = found.sand()
    assert sand.bulk_modulus == pytest.approx(min(stiff * P, 1000 * found.pressure), rel=1e-4)
    if stiff == 30.0:
        test, path = biaxial if dimension == 2 else triaxial, driven(dimension, stiff, **weak)
        again = test(TexSol(sand), path.axial_strain, pressure=P, axis="y")
        np.testing.assert_allclose(again.stress, path.stress, atol=1e-5 * P)
        np.testing.assert_allclose(again.strain, path.strain, atol=1e-6)


@pytest.mark.default_parameters("2")
@pytest.mark.parametrize("dimension", [2, 3])
def test_moduli_that_are_given_are_held(dimension):
    for stiff in (1e5, 1e3):
        data = measured(dimension, noise=0.0, stiff=stiff)
        found = fit_sand(data, bulk_modulus=stiff * P, shear_modulus=2.0 * stiff * P)
        assert found.elastic_errors == {"bulk_modulus": 0.0, "shear_modulus": 0.0}
        for name, value in TRUE.items():
            assert abs(found.values[name] - value) < found.errors[name] < 1e-6 * value, name
    # elastic strains of 5e-4 and more, taken for plastic ones, are a tenth of the hardening shear
    assert fit_sand(data, **RIGID).values["hardening"] == pytest.approx(1.1 * TRUE["hardening"], rel=0.07)
    with pytest.raises(ValueError, match="shear_modulus must be above 0 Pa"):
        fit_sand(data, shear_modulus=0.0)


@pytest.mark.long
@pytest.mark.parametrize(("dimension", "memory"), [(2, 0.0), (3, 0.8)])
@pytest.mark.parametrize(("stiff", "given"), [(3e5, RIGID), (50.0, {})])
def test_standard_errors_are_what_50_noisy_draws_scatter_by(dimension, memory, stiff, given):
    """A standard deviation of 50 draws is known to 10 %, so its ratio lies in 0.7 to 1.3; 1.45 where noise has a memory.

    (x - true)/error has mean square 1, and the mean of the draws is known to 0.14 of an error.
    """
    fits = [fit_sand(measured(dimension, seed, memory=memory, stiff=stiff), **given) for seed in range(50)]
    values = np.array([[fit.values[name] for name in NAMES] for fit in fits])
    errors = np.array([[fit.errors[name] for name in NAMES] for fit in fits])
    true = np.array([TRUE[name] for name in NAMES])
    ratio = values.std(axis=0, ddof=1) / np.median(errors, axis=0)
    assert ratio.min() > 0.7
    assert ratio.max() < (1.3 if memory == 0.0 else 1.45)
    assert np.sqrt((((values - true) / errors) ** 2).mean(axis=0)).max() < 1.5
    assert (np.abs(values.mean(axis=0) - true) < 0.6 * np.median(errors, axis=0)).all()
    times = np.mean([f.correlated["volume"] for f in fits])
    assert times == pytest.approx((1 + memory) / (1 - memory), rel=0.3)


@pytest.mark.long
@pytest.mark.parametrize("stiff", [1e2, 1e3, 1e4, 3e5])
def test_errors_are_not_too_small_at_any_stiffness(stiff):
    """Where noise hides the elastic part it is held at zero in half of the draws: the scatter is then less than stated."""
    fits = [fit_sand(measured(3, seed, memory=0.8, stiff=stiff)) for seed in range(30)]
    for name, value in TRUE.items():
        far = np.array([(fit.values[name] - value) / fit.errors[name] for fit in fits])
        assert math.sqrt((far**2).mean()) < 1.5, name
    for name, modulus in (("bulk_modulus", stiff * P), ("shear_modulus", 2.0 * stiff * P)):
        far = np.array([(fit.elastic[name] - fit.pressure / modulus) / fit.elastic_errors[name] for fit in fits])
        assert math.sqrt((far**2).mean()) < 1.5, name


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
        (lambda: fit_sand(measured(2), bulk_modulus=np.ones(2)), "bulk_modulus must be a number"),
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
