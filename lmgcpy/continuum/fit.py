"""The parameters of the sand from compressions of sand alone, with their standard errors.

Along a compression the model is explicit in the plastic shear kappa::

    q/p      = M(kappa),    q = M l/(1 - M/d) with the lateral pressure l = p - q/d
    V(kappa) = beta (integral of M from 0 to kappa - M_d kappa)
    eps_v    = V - (p - p_0)/K
    crushing = kappa - V/d + (d - 1) q/(2 d G) + (p - p_0)/(d K)

The crushing and the lateral pressure are imposed and have no error. For each moment kappa is found from them, and q/p and
the volume are compared. This is the material point without increments, so a fit takes milliseconds and not a path an
evaluation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from lmgcpy.continuum.sand import STEEPEST, DruckerPrager
from lmgcpy.continuum.tensors import SIZE
from lmgcpy.errors import AXES, is_infinite, named_arguments, number, numbers, one_of, shown


@named_arguments
@dataclass(frozen=True, eq=False, repr=False)
class MeasuredCompression:
    """Biaxial (d = 2) or triaxial (d = 3) compression from an isotropic state, in s moments of growing crushing.

    ``axis``: the one that was compressed, "x", "y" or "z"; ``strain`` (s, d): logarithmic strains of the sample along the
    axes, zero at the start; ``stress`` (s, d): normal stresses along the axes [Pa]. Both are traction positive.

    Raises TypeError or ValueError for other shapes, for fewer than 20 moments, or if a mean pressure is not above zero.
    """

    axis: str
    strain: Any
    stress: Any

    def __post_init__(self) -> None:
        strain = numbers(self.strain, "strain", "logarithmic strains (s, d)")
        stress = numbers(self.stress, "stress", "normal stresses (s, d) [Pa]")
        if strain.ndim != 2 or strain.shape[1] not in SIZE:
            raise ValueError(f"strain must be of shape (s, 2) or (s, 3), got {strain.shape}.")
        if stress.shape != strain.shape:
            raise ValueError(f"stress must have the shape of strain, {strain.shape}, got {stress.shape}.")
        if len(strain) < 20:
            raise ValueError(f"A fit takes at least 20 moments of a compression, got {len(strain)}.")
        one_of(self.axis, "axis", AXES[: strain.shape[1]])
        object.__setattr__(self, "strain", strain)
        object.__setattr__(self, "stress", stress)
        if not self.pressure.min() > 0.0:
            where = int(np.argmin(self.pressure))
            raise ValueError(f"The mean pressure must be above zero, in moment {where} it is {self.pressure[where]:g} Pa.")
        if not self.crushing.max() > 0.0:
            raise ValueError(f"strain along the axis '{self.axis}' is never below zero: compression is negative.")

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.strain.shape[1]

    @property
    def crushing(self) -> np.ndarray:
        """Strain along the axis, compression positive, (s,)."""
        return -self.strain[:, AXES.index(self.axis)]

    @property
    def volume_change(self) -> np.ndarray:
        """Trace of the strain, dilation positive, (s,)."""
        return self.strain.sum(axis=1)

    @property
    def pressure(self) -> np.ndarray:
        """p, the mean of all sides [Pa], (s,)."""
        return -self.stress.mean(axis=1)

    @property
    def deviator(self) -> np.ndarray:
        """q: pressure along the axis less the mean pressure across it [Pa], (s,)."""
        place = AXES.index(self.axis)
        return np.delete(self.stress, place, axis=1).mean(axis=1) - self.stress[:, place]

    def __repr__(self) -> str:
        return (
            f"<MeasuredCompression along {self.axis} in {self.dimension}D: {len(self.strain)} moments to "
            f"{100.0 * self.crushing.max():.3g} %>"
        )


NAMES = ("critical", "hardening", "peak", "peak_shear", "dilation", "turning")
"""Parameters that are fitted, in their order."""
MODULI = ("bulk_modulus", "shear_modulus")
STIFF = 1000.0
"""Largest elastic moduli of a fitted sand over its pressure, if none are given."""
CEILING = 0.999
"""Greatest q/p of a fit, over the q/p at which a sand needs no lateral pressure."""
LEAST_SHEAR = 1e-6
"""Least hardening and peak shear."""
NO_PEAK = 1e-4
"""Ratio peak/critical below which there is no peak: its shear is not determined."""
SHIFTS = 40
"""Newton steps for the plastic shear of a crushing."""
LEAST_RATE = 0.05
"""Least crushing per plastic shear in a Newton step: less is a soft sand that unloads faster than it flows."""
LAST_SHIFT = 1e-9
"""Newton step over the longest crushing after which no other follows: the error left is of the order of its square."""
KNOWN = 1e-10
"""Component of a parameter in an undetermined direction above which the parameter counts as undetermined."""


@dataclass(frozen=True, eq=False, repr=False)
class SandFit:
    """Parameters of a sand, and how well compressions determine them."""

    dimension: int
    """2 or 3."""
    pressure: float
    """Mean pressure at the first moment [Pa]."""
    values: dict[str, float]
    """Parameters of :class:`~lmgcpy.continuum.sand.DruckerPrager` by name."""
    errors: dict[str, float]
    """Their standard errors; infinite for parameters that the data do not determine."""
    covariance: np.ndarray
    """Covariance of the parameters in their order, (6, 6), with zeros for parameters that are not determined."""
    elastic: dict[str, float]
    """Elastic strains at the pressure, p/K for "bulk_modulus" and p/G for "shear_modulus" [-]; zero for rigid grains."""
    elastic_errors: dict[str, float]
    """Their standard errors; zero if the modulus was given."""
    misfit: dict[str, float]
    """Root mean squares of the residuals of "friction", q/p, and "volume", the change of volume."""
    correlated: dict[str, float]
    """Moments, of "friction" and "volume", that count as one independent moment."""
    notes: tuple[str, ...]
    """Sentences on the parameters that the data do not determine."""

    def sand(self, bulk_modulus: float | None = None, shear_modulus: float | None = None) -> DruckerPrager:
        """The fitted sand; its moduli [Pa], if they are not given, are the fitted ones, and at most 1000 times the
        pressure, which approximates rigid grains."""
        K, G = (
            self.pressure / max(self.elastic[name], 1.0 / STIFF) if modulus is None else modulus
            for name, modulus in zip(MODULI, (bulk_modulus, shear_modulus), strict=True)
        )
        return DruckerPrager(self.dimension, **self.values, bulk_modulus=K, shear_modulus=G)

    def __repr__(self) -> str:
        parts = ", ".join(f"{name} {self.values[name]:.3g}±{self.errors[name]:.1g}" for name in NAMES)
        return f"<SandFit in {self.dimension}D: {parts}>"


@named_arguments
def fit_sand(
    measured: MeasuredCompression | Sequence[MeasuredCompression],
    *,
    bulk_modulus: float | None = None,
    shear_modulus: float | None = None,
) -> SandFit:
    """Least-squares fit of a sand to one compression or several of one dimension, for example of several seeds.

    ``bulk_modulus``, ``shear_modulus``: elastic moduli of the sand [Pa], ``math.inf`` for rigid grains. If they are not
    given, p/K and p/G are fitted too, as numbers that are not negative: the first rise of q/p is then shared out between
    them and the hardening shear, whose error is larger. If a sand that is elastic is fitted as a rigid one, elastic strains
    of a part x of the hardening shear make errors of it and of the dilatancy of about x, which the standard errors do not
    know.

    Residuals of q/p and of the volume are each divided by their own root mean square, which is found from a first fit, so
    that both have the same weight. Standard errors are from least squares, with the covariance
    ``A^-1 (sum tau J^T J) A^-1``, ``A = J^T J``. Residuals of neighbouring moments are not independent: tau is the number
    of moments that count as one, the greater of two estimates, the sum of their correlations and the value for a series of
    first order. The scatter among several compressions is seen from a fit of each.

    Parameters stay where :class:`~lmgcpy.continuum.sand.DruckerPrager` takes them. Raises TypeError or ValueError with a
    sentence.
    """
    data = [measured] if isinstance(measured, MeasuredCompression) else measured
    if not isinstance(data, Sequence) or not data or not all(isinstance(one, MeasuredCompression) for one in data):
        raise TypeError(f"measured must be a MeasuredCompression or a list of them, got {shown(measured)}.")
    if len({one.dimension for one in data}) > 1:
        raise ValueError("All compressions of a fit must be of one dimension: fit those of 2D and of 3D by themselves.")
    moduli = [
        modulus if modulus is None or is_infinite(modulus) else number(modulus, name, above=0.0, unit="Pa")
        for modulus, name in zip((bulk_modulus, shear_modulus), MODULI, strict=True)
    ]
    model = _Curves(data, moduli)
    best = model.solve(model.orders(), model.guesses(), 1e-6)
    for accuracy in (1e-6, 1e-10):  # the scales change little after the first
        best = model.solve(model.scales(best), [best], accuracy)
    peak = bool(best[2] > NO_PEAK * best[0])
    if not peak:
        best[2:4] = 0.0, best[1]
    best = model.inside(best)
    scales = model.scales(best)
    covariance, errors, taus = model.uncertainty(best, scales, peak)
    notes = [] if peak else ["There is no peak: peak is zero and peak_shear has no meaning."]
    names = NAMES + MODULI
    notes += [f"The data do not determine {name}." for name, e in zip(names, errors, strict=True) if math.isinf(e)]
    value, error = (dict(zip(names, one.tolist(), strict=True)) for one in (best, errors))
    return SandFit(
        dimension=model.dimension,
        pressure=model.pressure,
        values={name: value[name] for name in NAMES},
        errors={name: error[name] for name in NAMES},
        covariance=covariance[:6, :6],
        elastic={name: value[name] for name in MODULI},
        elastic_errors={name: error[name] for name in MODULI},
        misfit={"friction": float(scales[0]), "volume": float(scales[1])},
        correlated={"friction": taus[0], "volume": taus[1]},
        notes=tuple(notes),
    )


class _Curves:
    """q/p and the change of volume over the crushing, measured and of parameters: those with NAMES, p/K and p/G."""

    def __init__(self, data: Sequence[MeasuredCompression], moduli: Sequence[float | None]):
        self.dimension = data[0].dimension
        self.ends = np.cumsum([len(one.strain) for one in data])[:-1]
        self.crushing = np.concatenate([one.crushing for one in data])
        self.friction = np.concatenate([one.deviator / one.pressure for one in data])
        self.volume = np.concatenate([one.volume_change for one in data])
        self.longest = float(self.crushing.max())
        self.pressure = float(np.mean([one.pressure[0] for one in data]))
        lateral = [(one.pressure - one.deviator / self.dimension) / self.pressure for one in data]
        self.lateral = np.concatenate(lateral)
        self.isotropic = np.concatenate([np.full(len(one), one[0]) for one in lateral])  # at the start
        self.fitted = np.array([True] * len(NAMES) + [modulus is None for modulus in moduli])
        self.soft = np.array([0.0 if modulus is None else self.pressure / modulus for modulus in moduli])
        self.kappa = np.maximum(self.crushing, 0.0)  # of the parameters before

    def inside(self, values: np.ndarray) -> np.ndarray:
        """Parameters with the greatest peak at which a sand needs lateral pressure, and the greatest beta at which it
        gains no work, if they are beyond."""
        critical, a, peak, b, dilation, turning, *soft = values
        peak = min(peak, CEILING * STEEPEST[self.dimension] - critical)
        beyond = critical + peak - turning
        dilation = min(dilation, (critical + peak) / beyond) if beyond > 0.0 else dilation
        return np.array([critical, a, peak, b, dilation, turning, *soft])

    def curves(self, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """q/p and the change of volume at the measured crushings, by Newton steps on the plastic shears from those of the
        last parameters."""
        critical, a, peak, b, dilation, turning, bulk, shear = self.inside(values)
        d, first = self.dimension, np.maximum(self.crushing, 0.0)
        along = (d - 1) / (2 * d) * shear + bulk / d**2  # elastic crushing per q
        for kappa in (self.kappa, first):
            for _ in range(SHIFTS):
                M, slope, area = _friction(kappa, critical, a, peak, b)
                volume = dilation * (area - turning * kappa)
                support = 1.0 - M / d
                q = M * self.lateral / support
                elastic = along * q + bulk / d * (self.lateral - self.isotropic)
                # above zero without the elastic part, as D <= M < d
                rate = 1.0 - dilation * (M - turning) / d + along * slope * self.lateral / support**2
                step = (kappa - volume / d + elastic - self.crushing) / np.maximum(rate, LEAST_RATE)
                new = np.maximum(kappa - step, 0.0)
                moved = np.abs(new - kappa).max()
                kappa = new
                if moved <= LAST_SHIFT * self.longest:
                    break
            else:
                continue
            self.kappa = kappa
            break
        else:
            self.kappa = first
        M, _, area = _friction(kappa, critical, a, peak, b)
        pressure = self.lateral / (1.0 - M / d) - self.isotropic
        return M, dilation * (area - turning * kappa) - bulk * pressure

    def scales(self, values: np.ndarray) -> np.ndarray:
        """Root mean squares of the residuals of friction and volume, (2,)."""
        M, volume = self.curves(values)
        found = np.array([np.sqrt(np.mean((M - self.friction) ** 2)), np.sqrt(np.mean((volume - self.volume) ** 2))])
        # curves without noise: round-off is the scale
        return np.maximum(found, 1e-9 * np.array([np.abs(self.friction).max(), self.longest]))

    def residuals(self, values: np.ndarray, scales: np.ndarray) -> np.ndarray:
        """Of friction and then of volume, over their scales."""
        M, volume = self.curves(values)
        return np.concatenate([(M - self.friction) / scales[0], (volume - self.volume) / scales[1]])

    def guesses(self) -> list[np.ndarray]:
        """Parameters to start from: with several shears of the peak, as these have several minima."""
        last = self.crushing > 0.8 * self.longest
        critical = float(np.clip(self.friction[last].mean(), 0.05, 0.6 * STEEPEST[self.dimension]))
        top = float(np.clip(np.quantile(self.friction, 0.98), critical, 0.9 * STEEPEST[self.dimension]))
        risen = self.crushing[self.friction > 0.63 * critical]
        a = float(np.clip(risen.min() if len(risen) else 0.1 * self.longest, 2 * LEAST_SHEAR, self.longest))
        turning = 0.8 * critical
        rise = (top - critical) + 0.02
        return [np.array([critical, a, rise, part * self.longest, 0.7, turning, *self.soft]) for part in (0.05, 0.2, 0.5)]

    def orders(self) -> np.ndarray:
        """Scales before anything is fitted: volumes are of the order of the crushing, (2,)."""
        return np.array([0.1, 0.1 * self.longest])

    def solve(self, scales: np.ndarray, starts: list[np.ndarray], accuracy: float) -> np.ndarray:
        """The best fit from all ``starts``, to a relative ``accuracy``."""
        ceiling, far = CEILING * STEEPEST[self.dimension], 10 * self.longest
        low = np.array([0.0, LEAST_SHEAR, 0.0, LEAST_SHEAR, 0.0, 0.0, 0.0, 0.0])
        high = np.array([ceiling, far, ceiling, far, 10.0, ceiling, far, far])
        units = np.array([1.0, 0.1 * self.longest, 1.0, self.longest, 1.0, 1.0, self.longest, self.longest])
        low, high, units = low[self.fitted], high[self.fitted], units[self.fitted]
        found = [
            least_squares(
                lambda fitted: self.residuals(self.whole(fitted), scales),
                np.clip(start[self.fitted], low + 1e-9 * units, high - 1e-9 * units),
                bounds=(low, high),
                x_scale=units,
                xtol=accuracy,
                ftol=accuracy,
                gtol=accuracy,
                max_nfev=400,
            )
            for start in starts
        ]
        return self.whole(min(found, key=lambda one: one.cost).x)

    def whole(self, fitted: np.ndarray) -> np.ndarray:
        """All parameters, from those that are fitted."""
        values = np.concatenate([np.zeros(len(NAMES)), self.soft])
        values[self.fitted] = fitted
        return values

    def uncertainty(self, values: np.ndarray, scales: np.ndarray, peak: bool) -> tuple[np.ndarray, np.ndarray, list[float]]:
        """Covariance (8, 8) and standard errors (8,) of the parameters, and the correlation of both residuals."""
        used = self.fitted & np.array([True, True, peak, peak, True, True, True, True])
        steps = 1e-5 * np.maximum(np.abs(values), 1e-4)
        columns = []
        for place in np.flatnonzero(used):
            step = np.zeros(len(values))
            step[place] = steps[place]
            columns.append((self.residuals(values + step, scales) - self.residuals(values - step, scales)) / 2)
        slopes = np.stack(columns, axis=1)  # per step
        half = len(self.crushing)
        residuals = self.residuals(values, scales)
        taus = [_correlated(np.split(part, self.ends)) for part in (residuals[:half], residuals[half:])]
        # directions of the parameters that the data see
        _, singular, rows = np.linalg.svd(slopes, full_matrices=False)
        seen = singular > 1e-9 * singular[0]
        inverse = (rows[seen].T / singular[seen] ** 2) @ rows[seen]
        middle = sum(t * part.T @ part for t, part in zip(taus, (slopes[:half], slopes[half:]), strict=True))
        freedom = 2 * half / max(2 * half - int(used.sum()), 1)
        small = freedom * inverse @ middle @ inverse
        unknown = (rows[~seen] ** 2).sum(axis=0) > KNOWN
        small[unknown] = small[:, unknown] = 0.0
        covariance = np.zeros((len(values), len(values)))
        errors = np.where(self.fitted, math.inf, 0.0)
        covariance[np.ix_(used, used)] = small * np.outer(steps[used], steps[used])
        errors[used] = np.where(unknown, math.inf, np.sqrt(np.maximum(np.diagonal(covariance)[used], 0.0)))
        return covariance, errors, taus


def _friction(
    kappa: np.ndarray, critical: float, a: float, peak: float, b: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """M, dM/dkappa, and the integral of M from 0 to kappa."""
    rising, part = np.exp(-kappa / a), kappa / b
    risen, falling = -np.expm1(-kappa / a), np.exp(-part)
    M = critical * risen + peak * math.e * part * falling
    slope = critical / a * rising + peak * math.e / b * (1.0 - part) * falling
    return M, slope, critical * (kappa - a * risen) + peak * math.e * b * (1.0 - (1.0 + part) * falling)


def _correlated(series: list[Any]) -> float:
    """``1 + 2 sum of the correlations`` of residuals, at least 1; the mean over the ``series``."""
    found = []
    for values in series:
        size = 1 << (2 * len(values) - 1).bit_length()
        power = np.abs(np.fft.rfft(values, size)) ** 2
        sums = np.fft.irfft(power, size)[: len(values)]
        if not sums[0] > 0.0:
            found.append(1.0)
            continue
        parts = sums / sums[0]
        first = parts[1 : int(np.argmax(parts <= 0.0))] if (parts <= 0.0).any() else parts[1:]
        # parameters follow slow noise and take its correlation away: the first correlation alone says as much or more
        next_one = min(float(parts[1]), 0.99)
        found.append(max(1.0 + 2.0 * float(first.sum()), (1.0 + next_one) / (1.0 - next_one)))
    return max(1.0, float(np.mean(found)))
