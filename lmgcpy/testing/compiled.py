"""Property: the compiled law gives the answers of plain Python, in which the other properties are checked."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from lmgcpy.compiled.fingerprint import Slot
from lmgcpy.compiled.kernel import CompilerError, Kernel, kernel, row_reader
from lmgcpy.compiled.small_matrices import small_matrices
from lmgcpy.errors import told
from lmgcpy.laws import Law
from lmgcpy.laws.pair import TAKE_PAIR, pair_of, takes_pair
from lmgcpy.solve.kernels.law_kernels import as_floats, not_compiled, zeros
from lmgcpy.testing.case import LawCase, Nonconformance, Numbers, velocity
from lmgcpy.testing.conformance import drawn

react: Callable[..., Any] = Slot("react")  # the specialisation fills this slot and the next ones
prepare: Callable[..., Any] = Slot("prepare")
slope: Callable[..., Any] = lambda W, u, prepared: ((0.0,),)  # noqa: E731
energy: Callable[..., Any] = lambda *given: 0.0  # noqa: E731
dissipation: Callable[..., Any] = lambda *given: 0.0  # noqa: E731
initial: Callable[..., Any] = Slot("initial")
commit: Callable[..., Any] = lambda *given: ()  # noqa: E731
prepare_pair: Callable[..., Any] = Slot("prepare_pair")  # the last argument of each function
initial_pair: Callable[..., Any] = Slot("initial_pair")
commit_pair: Callable[..., Any] = Slot("commit_pair")
energy_pair: Callable[..., Any] = Slot("energy_pair")
dissipation_pair: Callable[..., Any] = Slot("dissipation_pair")
read_parameters: Callable[..., Any] = Slot("read_parameters")
read_vector: Callable[..., Any] = Slot("read_vector")
read_state: Callable[..., Any] = Slot("read_state")
square: Callable[..., Any] = Slot("square")
exactly: Callable[..., Any] = Slot("exactly")
as_prepared: Callable[..., Any] = Slot("as_prepared")
as_state: Callable[..., Any] = Slot("as_state")
ROWS = PREPARED = STATE = 0
SLOPE = COMMIT = False


@kernel
def evaluate(W, numbers, vectors, parameters, state, prepared, answer, slopes, first, after):
    """Call every function of a law for one interaction; returns the stored and the dissipated energy.

    ``numbers``: gap, reference gap, time step, birth, time, radii and masses; ``vectors``: velocity before the step, free
    velocity, velocity and impulse for ``commit``, mean velocity. The kernel fills the other arrays.
    """
    gap, reference_gap, time_step, birth = numbers[0], numbers[1], numbers[2], numbers[3]
    given = read_parameters(parameters, 0)
    kept = read_state(state, 0)
    asked = prepare_pair(numbers, 4)
    # numbers of the local solve, prepared at the velocity before the step
    row = as_prepared(prepare(gap, reference_gap, read_vector(vectors, 0), time_step, given, kept, *asked))
    for k in range(PREPARED):
        prepared[k] = row[k]
    # r = react(W, u_free), and its slope by u
    free = read_vector(vectors, ROWS)
    if ROWS == 1:
        block: Any = ((W[0, 0, 0],),)
        (answer[0],) = react(block, free, row)
    else:
        block = square(W, 0)
        new_impulse = exactly(react(block, free, row))
        for k in range(ROWS):
            answer[k] = new_impulse[k]
    if SLOPE:
        derivative = slope(block, free, row)
        for i in range(ROWS):
            for j in range(ROWS):
                slopes[i, j] = derivative[i][j]
    # state of a new interaction, and state after the step
    if STATE > 0:
        new = as_state(initial(gap, reference_gap, birth, given, *initial_pair(numbers, 3)))
        for k in range(STATE):
            first[k] = new[k]
    if COMMIT:
        end, push = read_vector(vectors, 2 * ROWS), read_vector(vectors, 3 * ROWS)
        old = as_state(commit(gap, reference_gap, end, push, time_step, given, kept, *commit_pair(numbers, 4)))
        for k in range(STATE):
            after[k] = old[k]
    # energy dissipated by the impulse at the mean velocity
    mean, push = read_vector(vectors, 4 * ROWS), read_vector(vectors, 3 * ROWS)
    lost = dissipation(gap, reference_gap, mean, push, time_step, given, kept, *dissipation_pair(numbers, 4))
    return float(energy(gap, reference_gap, given, kept, *energy_pair(numbers, 4))), float(lost)


def no_pair(numbers, time):
    """No last argument, for functions that take no pair."""
    return ()


def known_pair(numbers, time):
    """The pair of bodies, the last argument of functions that take it; ``time``: index of the time."""
    return (pair_of((numbers[5], numbers[6]), (numbers[7], numbers[8]), numbers[time]),)


@cache
def of_law(law: type[Law], rows: int, parameter_count: int) -> Kernel:
    """The kernel :func:`evaluate` for a law; it is compiled at the first call."""
    count, of_rows = len(law.states()), small_matrices(max(rows, 2))
    return evaluate.specialise(
        react=law.react,
        prepare=law.prepare,
        slope=law.slope or slope,
        energy=law.energy or energy,
        dissipation=law.dissipation or dissipation,
        initial=law.initial or zeros(count),
        **{f"{name}_pair": known_pair if takes_pair(getattr(law, name)) else no_pair for name in TAKE_PAIR},
        commit=law.commit or commit,
        read_parameters=row_reader(parameter_count),
        read_vector=row_reader(rows),
        read_state=row_reader(count),
        square=of_rows["block"],
        exactly=of_rows["exactly"],
        as_prepared=as_floats(len(law.PREPARED)),
        as_state=as_floats(count),
        ROWS=rows,
        PREPARED=len(law.PREPARED),
        STATE=count,
        SLOPE=law.slope is not None,
        COMMIT=law.commit is not None,
    )


def same(got: Any, expected: Any) -> bool:
    """Whether two answers agree up to a few units of round-off: a compiler may fuse multiplications and additions."""
    return np.allclose(got, expected, rtol=1e-13, atol=0.0, equal_nan=True)


@drawn("compiled", "compiled = interpreted, up to round-off")
def compiled(case: LawCase, draw: Any) -> str:
    """All functions of the law, compiled as the solvers compile them, give the answers of plain Python. W r may differ by
    the round-off of velocities. ``commit`` may be at a threshold: there the answer for a velocity and an impulse that
    differ by round-off is accepted too."""
    law, size, step = case.law, case.size, case.steps[-1]
    prepared, answer, slopes = np.empty(len(law.PREPARED)), np.empty(size), np.zeros((size, size))
    first, after = np.zeros(len(law.states())), np.array(case.state)
    filled = [np.append(values, 0.0) for values in (case.parameters, case.state)]  # never empty
    try:
        mean = 0.5 * (np.array(step.before) + case.velocity)
        times = case.time_step, case.birth, step.time
        stored, lost = of_law(type(law), size, len(case.parameters))(
            np.array([case.W]),
            np.array([step.gap, case.reference_gap, *times, *case.radii, *case.masses]),
            np.concatenate([step.before, step.q, case.velocity, case.impulse, mean]),
            *filled,
            prepared,
            answer,
            slopes,
            first,
            after,
        )
    except CompilerError as error:
        raise Nonconformance("compiled", str(not_compiled(type(law), error)), law) from error
    except Exception as error:
        return f"compiled, the law raised {told(error)}; interpreted it did not."
    if not same(prepared, case.prepared):
        return f"prepare, compiled, gives {prepared.tolist()}, interpreted {case.prepared}."
    if (np.diag(case.W) * np.abs(answer - case.impulse)).max() > 1e-12 * case.speed:
        return f"react, compiled, gives {answer.tolist()} N s, interpreted {case.impulse} N s."
    if law.slope is not None and not same(slopes, case.slope(case.q)):
        return f"slope, compiled, gives {slopes.tolist()} kg, interpreted {case.slope(case.q)} kg."
    if law.energy is not None and not same(stored, case.energy(case.gap)):
        return f"energy, compiled, gives {stored!r} J, interpreted {case.energy(case.gap)!r} J."
    if law.dissipation is not None and not same(lost, case.dissipation):
        return f"dissipation, compiled, gives {lost!r} J, interpreted {case.dissipation!r} J."
    new = case.first_state(step.gap)
    if not same(first, new):
        return f"initial, compiled, gives {first.tolist()}, interpreted {new}."
    if law.commit is not None and not any(same(after, near) for near in commits_near(case)):
        return f"commit, compiled, gives {after.tolist()}, interpreted {case.after}."
    return ""


def commits_near(case: LawCase) -> list[Numbers]:
    """Answers of ``commit`` to the step, and to the step with a normal velocity or impulse that differs by round-off."""
    step = case.steps[-1]
    found = []
    for sign in (0.0, 1.0, -1.0):
        for k, part in enumerate((1e-14 * case.speed, 1e-14 * case.speed / case.W[0][0])):
            shift = [0.0, 0.0]
            shift[k] = sign * part
            u, r = velocity(step, case.impulse), case.impulse
            found.append(case.committed(step, (u[0] + shift[0], *u[1:]), (r[0] + shift[1], *r[1:]), case.state))
    return found
