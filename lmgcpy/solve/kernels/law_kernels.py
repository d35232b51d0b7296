"""The compiled kernels of a law for its groups: sweep, error, and one kernel for each of the law's own functions."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numba
import numpy as np

from lmgcpy.compiled.by_address import group_signature
from lmgcpy.compiled.fingerprint import Slot, may_raise
from lmgcpy.compiled.kernel import CompilerError, Kernel, kernel, row_reader
from lmgcpy.compiled.reference import by_reference
from lmgcpy.laws import Law
from lmgcpy.laws.pair import pair_of, takes_pair
from lmgcpy.solve.kernels import contact_block, stiffened_wire_block, wire_block
from lmgcpy.solve.kernels.forms.form import Form
from lmgcpy.solve.kernels.guarded_kernels import finite_matrix, finite_vector, guard, noting_guard, noting_reader
from lmgcpy.solve.kernels.system import System

prepare: Callable[..., Any] = Slot("prepare")
"""The law's ``prepare``. The specialisation gives this name and those below."""
energy: Callable[..., Any] = Slot("energy")
initial: Callable[..., Any] = Slot("initial")
commit: Callable[..., Any] = Slot("commit")
dissipation: Callable[..., Any] = Slot("dissipation")
pair: Callable[..., Any] = Slot("pair")
"""Gives the last arguments of the function: ``(Pair,)`` if it takes the pair, ``()`` if not."""
initial_pair: Callable[..., Any] = Slot("initial_pair")
"""Gives the last arguments of ``initial``."""
read_parameters: Callable[..., Any] = Slot("read_parameters")
read_local: Callable[..., Any] = Slot("read_local")
read_state: Callable[..., Any] = Slot("read_state")
as_prepared: Callable[..., Any] = Slot("as_prepared")
as_state: Callable[..., Any] = Slot("as_state")
PARAMETERS = 0
PREPARED = 0
STATE = 0


@by_reference
class StepData(NamedTuple):
    """Arguments of the laws in a step, except the impulses, for kernels that sweeps do not call; m interactions."""

    gap: np.ndarray
    """Gaps at the detection configuration [m], (m,)."""
    reference_gap: np.ndarray
    """[m], (m,); of contacts at most zero, see ``Law.KEEPS_GAP``."""
    before: np.ndarray
    """Relative velocities at the start of the step [m/s], (m, d)."""
    after: np.ndarray
    """Relative velocities at its end [m/s], (m, d), once it is solved; the problems solved in one step share it."""
    pairs: np.ndarray
    """Radii and masses of candidates and antagonists [m, m, kg, kg], (m, 4); (0, 4) if no law asks."""
    state: np.ndarray
    """States of the laws, (m, k + 1) with k the most numbers that a law of the scene keeps; NaN beyond a law's own. In the
    last column the gap that a contact was to have at this step's detection [m], NaN where not known."""
    time: float
    """Time at the start of the step [s]."""
    time_step: float
    """[s]."""
    at: np.ndarray
    """(1,): row of the interaction for which a law is called; if the law raises, the error names it."""


def parameters_of(i, start, parameters):
    """Parameters of interaction ``i``: of its own row, or of the one row that all share."""
    return read_parameters(parameters, (i - start) * PARAMETERS if parameters.shape[0] > PARAMETERS else 0)


def no_pair(i, data):
    """No last argument, for functions that take no pair."""
    return ()


def known_pair(i, data):
    """The pair of bodies of interaction ``i``, the last argument of functions that take it."""
    radii = (data.pairs[i, 0], data.pairs[i, 1])
    masses = (data.pairs[i, 2], data.pairs[i, 3])
    return (pair_of(radii, masses, data.time),)


@kernel
def prepare_group(start, stop, offset, data: StepData, parameters, prepared):
    """Call the law's ``prepare`` for the interactions of one group, and ``initial`` for interactions without a state.
    Returns -1, or i if ``prepare`` gives a NaN at row i, or -2 - i if ``initial`` does: ``max`` and comparisons could hide
    a NaN from the solver."""
    before = data.before.ravel()
    states = data.state.ravel()
    width = data.state.shape[1]
    for i in range(start, stop):
        data.at[0] = i
        given = parameters_of(i, start, parameters)
        # a new interaction has NaN for its state
        if STATE > 0 and np.isnan(data.state[i, 0]):
            first = as_state(initial(data.gap[i], data.reference_gap[i], data.time, given, *initial_pair(i, data)))
            for k in range(STATE):
                if np.isnan(first[k]):
                    return -2 - i
                data.state[i, k] = first[k]
        state = read_state(states, i * width)
        local = read_local(before, data.before.shape[1] * i)
        known = pair(i, data)
        # numbers of the local solve from gap, reference gap, velocity before the step, h, parameters and state
        numbers = as_prepared(prepare(data.gap[i], data.reference_gap[i], local, data.time_step, given, state, *known))
        for k in range(PREPARED):
            prepared[offset + (i - start) * PREPARED + k] = numbers[k]
            if np.isnan(numbers[k]):
                return i
    return -1


@kernel
def commit_group(start, stop, data: StepData, impulse, parameters):
    """Call the law's ``commit`` for the interactions of one group; returns the row of the first state that is not finite,
    or -1."""
    after = data.after.ravel()
    impulses = impulse.ravel()
    states = data.state.ravel()
    width = data.state.shape[1]
    for i in range(start, stop):
        data.at[0] = i
        given = parameters_of(i, start, parameters)
        local = read_local(after, data.after.shape[1] * i)
        push = read_local(impulses, data.after.shape[1] * i)
        state = read_state(states, i * width)
        known = pair(i, data)
        new = as_state(commit(data.gap[i], data.reference_gap[i], local, push, data.time_step, given, state, *known))
        for k in range(STATE):
            if not np.isfinite(new[k]):
                return i
            data.state[i, k] = new[k]
    return -1


@kernel
def stored_energy(start, stop, data: StepData, parameters):
    """Energy stored in the interactions of one group at the gaps predicted at the end of the step [J]."""
    total = 0.0
    states = data.state.ravel()
    width = data.state.shape[1]
    for i in range(start, stop):
        data.at[0] = i
        given = parameters_of(i, start, parameters)
        predicted = data.gap[i] + data.time_step * data.after[i, 0]
        total += energy(predicted, data.reference_gap[i], given, read_state(states, i * width), *pair(i, data))
    return total


@kernel
def dissipated_energy(start, stop, data: StepData, mean, impulse, parameters):
    """Energy that the interactions of one group have dissipated in the step [J], before they commit; ``mean``: the means of
    their relative velocities at the start and at the end of the step (m, d)."""
    total = 0.0
    means = mean.ravel()
    impulses = impulse.ravel()
    states = data.state.ravel()
    width = data.state.shape[1]
    for i in range(start, stop):
        data.at[0] = i
        given = parameters_of(i, start, parameters)
        local = read_local(means, mean.shape[1] * i)
        push = read_local(impulses, mean.shape[1] * i)
        state = read_state(states, i * width)
        known = pair(i, data)
        total += dissipation(data.gap[i], data.reference_gap[i], local, push, data.time_step, given, state, *known)
    return total


SYSTEM_TYPE = numba.typeof(
    System(
        candidate=np.zeros(0, np.uint32),
        antagonist=np.zeros(0, np.uint32),
        normal=np.zeros((0, 2)),
        tangent=np.zeros((0, 3)),
        arm=np.zeros((0, 2)),
        lateral=np.zeros((0, 2)),
        lever=np.zeros((0, 6)),
        moment=np.zeros((0, 18)),
        axes=np.zeros((0, 9)),
        rolling=np.zeros(0),
        edges=np.zeros(0, np.int64),
        branch=np.zeros((0, 0)),
        cell=np.zeros(0, np.uint32),
        delassus=np.zeros((0, 2)),
        coupling=np.zeros(0),
        shear=np.zeros((0, 2)),
        corner=np.zeros((0, 0), np.uint32),
        weight=np.zeros((0, 0)),
        prepared=np.zeros(0),
        impulse=np.zeros((0, 2)),
        velocity=np.zeros((0, 3)),
        inverse_mass=np.zeros((0, 3)),
        geometric=np.zeros(0),
        carried=np.zeros((0, 1)),
        own=np.zeros((0, 2, 2)),
        following=np.zeros((0, 2, 2)),
        scratch=np.zeros((0, 0)),
        scale=np.zeros(0),
        squared_error=np.zeros(0),
        noise=np.zeros((0, 2)),
        floor=np.zeros(0),
        farness=np.zeros(0),
        measured=np.zeros(0),
    )
)


@dataclass(frozen=True)
class KernelKey:
    """Key of the kernels of a group; beside it they depend only on the functions of its law."""

    form: Form
    """The form of the rows of ``H^T``."""
    rows: int
    """Components of the law's impulse."""
    parameters: int = 0
    """How many numbers its functions get as parameters."""
    diagonal: bool = True
    """Whether all local blocks of W are."""
    block: bool = False
    """Whether the links of one wire are swept as a block, which needs the law's ``slope``."""
    stiffened: bool = False
    """Whether they are links with geometric stiffness."""
    walls: int = -1
    """0 or 1 if the candidates or antagonists are held walls, which other threads see and nobody writes to."""
    watched: bool = False
    """Whether to find the interaction at fault: kernels stop for good at a law that raises or returns a value that is not
    finite. They leave the start of the prepared numbers of this interaction in the last entry of ``System.prepared``, which
    then has two entries more."""
    system_type: Any = SYSTEM_TYPE
    """numba type of the system."""


@dataclass(frozen=True)
class LawKernels:
    """Compiled kernels of one law for one kind of group; the first four are C functions with an address."""

    key: KernelKey
    sweep: Any
    error: Any
    momentum: Any
    beside_walls: Any
    """The sweep for contacts with held walls in the slabs of a partitioned scene; elsewhere that for all."""
    prepare: Kernel
    energy: Kernel | None
    commit: Kernel | None
    dissipation: Kernel | None

    def sweep_in_slab(self, walls: int) -> Any:
        """The sweep; ``walls`` (0, 1) for contacts whose candidates, or antagonists, are held walls."""
        return self.sweep if walls < 0 else self.beside_walls


def law_kernels(law: type[Law], key: KernelKey) -> LawKernels:
    """The kernels of a law from its present functions: a user may replace them, or define the class again."""
    functions = law.react, law.slope if key.block else None
    rest = law.prepare, law.energy, law.initial, law.commit, law.dissipation
    return _law_kernels(law, functions, rest, key)


@cache
def _law_kernels(law: type[Law], functions: tuple, rest: tuple, key: KernelKey) -> LawKernels:
    count = len(law.PREPARED)
    try:
        sweep, error = sweep_kernels(*functions, count, replace(key, walls=-1))
        beside = sweep if key.walls < 0 else sweep_kernels(*functions, count, key)[0]
    except CompilerError as refusal:
        raise not_compiled(law, refusal) from refusal
    counts = count, len(law.states()), key.parameters, key.rows
    momentum = key.form.momentum_at(key.system_type)
    return LawKernels(key, sweep, error, momentum, beside, *_step_kernels(rest, *counts))


@cache
def sweep_kernels(react: Callable, slope: Callable | None, prepared_count: int, key: KernelKey) -> tuple[Any, Any]:
    """C functions (sweep, error) of a law's functions."""
    guarded = key.watched or may_raise(react) or (slope is not None and may_raise(slope))
    reader = row_reader(prepared_count)
    if key.watched:
        reader = Kernel(noting_reader, {"read": reader})  # type: ignore[assignment]
        react = Kernel(finite_vector, {"compute": react})  # type: ignore[assignment]
        slope = slope and Kernel(finite_matrix, {"compute": slope})  # type: ignore[assignment]
    names = {"react": react, "read": reader, "PREPARED": prepared_count, "DIAGONAL": key.diagonal}
    if key.walls >= 0:
        names["WALLS"] = key.walls
    if key.stiffened:
        sweep, error = stiffened_kernels(names, key.form, slope)
    else:
        slots = key.form.slots({**names, "ROWS": min(key.rows, key.form.dimension)})
        sweep, error = Kernel(contact_block.sweep, slots), Kernel(contact_block.error, slots)
        if slope is not None:
            sweep = Kernel(wire_block.sweep, {**slots, "slope": slope})
    if guarded:
        sweep, error = (Kernel(noting_guard if key.watched else guard, {"body": kernel}) for kernel in (sweep, error))
    signature = group_signature(key.system_type)
    return sweep.pointer(signature), error.pointer(signature)


def stiffened_kernels(constants: dict[str, Any], form: Form, slope: Callable | None) -> tuple[Kernel, Kernel]:
    """(sweep, error) for the links of a chain with geometric stiffness; without a ``slope`` one link after another."""
    columns = stiffened_wire_block.scratch_columns(form.dimension)
    meaning = form.slots({**constants, **columns, "ROWS": form.dimension})
    error = Kernel(stiffened_wire_block.error, meaning)
    if slope is None:
        return Kernel(stiffened_wire_block.sweep_links, meaning), error
    meaning = {**meaning, "slope": slope}
    steps = (getattr(stiffened_wire_block, name) for name in ("residual", "newton_step", "move", "relax"))
    return Kernel(wire_block.sweep, {step.__name__: Kernel(step, meaning) for step in steps}), error


_OPCODE = r"""numba has no instruction \1; imports stand at the top of a file
File "\2", line \3"""


def not_compiled(law: type[Law], error: Exception) -> TypeError:
    """The error for a law of which numba refuses a function; it begins with numba's reason and the line of the law."""
    said = re.sub(r"^Use of unsupported opcode \((\w+)\) found. Raised from (.*) \((\d+)\)$", _OPCODE, str(error))
    lines = [line.strip() for line in said.splitlines()]
    reason = next((line for line in lines if line and not line.startswith("Failed in")), "numba gives no reason")
    places = (re.match(r'File "(.*)", line (\d+)', line) for line in lines)
    foreign = (f"{Path(place[1]).name}, line {place[2]}" for place in places if place and "/lmgcpy/" not in f"/{place[1]}")
    function = re.search(r"<function \S*?(\w+)_[0-9a-f]{16} ", said)
    where = next(foreign, f"in {function[1]}" if function else "in one of its functions")
    return TypeError(
        f"Law '{law.NAME}' ({law.__module__}.{law.__qualname__}) cannot be compiled: {reason.rstrip('.:')[:300]} "
        f"({where}). Its functions may use numbers, tuples, and functions of math and numpy on numbers."
    )


@cache
def _step_kernels(
    functions: tuple, prepared_count: int, state_count: int, parameter_count: int, rows: int
) -> tuple[Kernel, Kernel | None, Kernel | None, Kernel | None]:
    law_prepare, law_energy, law_initial, law_commit, law_dissipation = functions
    common: dict[str, Any] = {
        "read_parameters": row_reader(parameter_count),
        "read_state": row_reader(state_count),
        "PARAMETERS": parameter_count,
    }
    states = {"as_state": as_floats(state_count), "STATE": state_count, "read_local": row_reader(rows)}
    preparing = prepare_group.specialise(
        prepare=law_prepare,
        pair=pair_for(law_prepare),
        initial=law_initial or zeros(state_count),
        initial_pair=pair_for(law_initial),
        as_prepared=as_floats(prepared_count),
        PREPARED=prepared_count,
        **common,
        **states,
    )
    storing = law_energy and stored_energy.specialise(energy=law_energy, pair=pair_for(law_energy), **common)
    committing = law_commit and commit_group.specialise(
        commit=law_commit, pair=pair_for(law_commit), **common, **states
    )
    dissipating = law_dissipation and dissipated_energy.specialise(
        dissipation=law_dissipation, pair=pair_for(law_dissipation), read_local=states["read_local"], **common
    )
    return preparing, storing, committing, dissipating


@cache
def as_floats(count: int) -> Callable:
    """Function ``row -> (float(row[0]), ...)``, a tuple of ``count`` numbers."""
    return eval(f"lambda row: ({''.join(f'float(row[{k}]), ' for k in range(count))})", {"__name__": __name__})


def pair_for(function: Callable | None) -> Callable:
    """What gives a function of a law its last arguments."""
    return known_pair if takes_pair(function) else no_pair


@cache
def zeros(count: int) -> Callable:
    """An ``initial`` that returns ``count`` zeros."""
    return eval(f"lambda gap, reference_gap, time, parameters: ({'0.0, ' * count})", {"__name__": __name__})
