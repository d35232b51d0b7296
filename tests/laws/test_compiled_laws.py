"""The compiled functions of a law give what the interpreted ones give: all other tests of the laws run interpreted.

One kernel a law, made from the template below by the specialisation that the solver's kernels use.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from law_cases import LAWS, cases

from lmgcpy.jit import kernel, row_reader

react = prepare = slope = energy = read_parameters = read_velocity = read_prepared = None
ROWS = 0
PREPARED = 0
HAS_SLOPE = HAS_ENERGY = False


@kernel
def evaluate(W, q, gap, reference_gap, before, time_step, parameters, prepared, impulse, slopes):
    """Everything that a law computes for one interaction; returns the energy."""
    numbers = prepare(gap, reference_gap, read_velocity(before, 0), time_step, read_parameters(parameters, 0), ())
    for k in range(PREPARED):
        prepared[k] = numbers[k]
    given = read_prepared(prepared, 0)
    if ROWS == 1:
        block = ((W[0, 0],),)
        free = (q[0],)
        (impulse[0],) = react(block, free, given)
    else:
        block = ((W[0, 0], W[0, 1]), (W[1, 0], W[1, 1]))
        free = (q[0], q[1])
        impulse[0], impulse[1] = react(block, free, given)
    if HAS_SLOPE:
        rows = slope(block, free, given)
        for i in range(ROWS):
            for j in range(ROWS):
                slopes[i, j] = rows[i][j]
    return energy(gap, reference_gap, read_parameters(parameters, 0), ()) if HAS_ENERGY else 0.0


def no_energy(gap, reference_gap, parameters, state):
    return 0.0


def no_slope(W, u, prepared):
    return ((0.0,),)


def compiled(law, rows, parameter_count):
    return evaluate.specialise(
        react=law.react,
        prepare=law.prepare,
        slope=law.slope or no_slope,
        energy=law.energy or no_energy,
        read_parameters=row_reader(parameter_count),
        read_velocity=row_reader(rows),
        read_prepared=row_reader(len(law.PREPARED)),
        ROWS=rows,
        PREPARED=len(law.PREPARED),
        HAS_SLOPE=law.slope is not None,
        HAS_ENERGY=law.energy is not None,
    )


def close(a, b):
    """Equal up to fused multiplications, which the compiler may use: two units of round-off of the larger terms."""
    return np.allclose(a, b, rtol=1e-14, atol=0.0)


@pytest.mark.parametrize("law", LAWS.values(), ids=LAWS.keys())
@settings(suppress_health_check=[HealthCheck.too_slow])  # the first example compiles
@given(data=st.data())
def test_compiled_and_interpreted_agree(law, data):
    case = data.draw(cases(law))
    rows = len(case.q)
    prepared = np.empty(len(law.PREPARED))
    impulse = np.empty(rows)
    slopes = np.zeros((rows, rows))
    parameters = np.array((*case.parameters, 0.0))  # never empty
    stored = compiled(law, rows, len(case.parameters))(
        np.array(case.W),
        np.array(case.q),
        case.gap,
        case.reference_gap,
        np.array(case.before),
        case.time_step,
        parameters,
        prepared,
        impulse,
        slopes,
    )
    assert close(prepared, case.prepared)
    w = np.diag(case.W)
    # a difference of two bits in one term of u is one of that size in W r
    assert np.abs(w * (impulse - case.impulse)).max() <= 1e-12 * case.velocity_scale
    if law.slope is not None:
        assert close(slopes, law.slope(case.W, case.q, case.prepared))
    if law.energy is not None:
        assert close(stored, law.energy(case.gap, case.reference_gap, case.parameters, ()))
