"""From a law to the compiled kernels of its groups."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numba
import numpy as np

from lmgcpy.jit import Kernel, kernel, row_reader
from lmgcpy.laws import Law
from lmgcpy.solve import contact_block, wire_block
from lmgcpy.solve.gauss_seidel import group_signature
from lmgcpy.solve.system import System

prepare: Callable[..., Any] = lambda gap, reference_gap, velocity, time_step, parameters: ()  # noqa: E731
"""The law's, given by the specialisation."""
read_parameters: Callable[..., Any] = lambda array, start: ()  # noqa: E731
read_velocity: Callable[..., Any] = lambda array, start: ()  # noqa: E731
as_floats: Callable[..., Any] = lambda row: ()  # noqa: E731
energy: Callable[..., Any] = lambda gap, reference_gap, parameters: 0.0  # noqa: E731
PARAMETERS = 0
PREPARED = 0


@kernel
def prepare_group(start, stop, offset, gap, reference_gap, velocity, time_step, parameters, prepared):
    """Call the law's ``prepare`` for the interactions of one group; ``velocity``: relative, at the start, flat (2 m)."""
    for i in range(start, stop):
        row = (i - start) * PARAMETERS if parameters.shape[0] > PARAMETERS else 0
        numbers = as_floats(
            prepare(gap[i], reference_gap[i], read_velocity(velocity, 2 * i), time_step, read_parameters(parameters, row))
        )
        for k in range(PREPARED):
            prepared[offset + (i - start) * PREPARED + k] = numbers[k]


@kernel
def stored_energy(start, stop, gap, reference_gap, parameters):
    """Energy stored in the interactions of one group at the gaps ``gap`` [J]."""
    total = 0.0
    for i in range(start, stop):
        row = (i - start) * PARAMETERS if parameters.shape[0] > PARAMETERS else 0
        total += energy(gap[i], reference_gap[i], read_parameters(parameters, row))
    return total


@kernel
def relative_velocities(s: System, velocity, result):
    """(u_n, u_t) of every interaction for the velocities of the bodies, into ``result`` (m, 2)."""
    for i in range(s.candidate.shape[0]):
        c = s.candidate[i]
        a = s.antagonist[i]
        x = velocity[c, 0] - velocity[a, 0]
        y = velocity[c, 1] - velocity[a, 1]
        spin_c = velocity[c, 2]
        spin_a = velocity[a, 2]
        u_n = s.normal[i, 0] * x + s.normal[i, 1] * y
        if s.lateral.shape[0] > 0:
            u_n += s.lateral[i, 1] * spin_a - s.lateral[i, 0] * spin_c
        result[i, 0] = u_n
        result[i, 1] = s.normal[i, 0] * y - s.normal[i, 1] * x - s.arm[i, 0] * spin_c - s.arm[i, 1] * spin_a


SYSTEM_TYPE = numba.typeof(
    System(
        candidate=np.zeros(0, np.uint32),
        antagonist=np.zeros(0, np.uint32),
        normal=np.zeros((0, 2)),
        arm=np.zeros((0, 2)),
        lateral=np.zeros((0, 2)),
        delassus=np.zeros((0, 2)),
        coupling=np.zeros(0),
        prepared=np.zeros(0),
        impulse=np.zeros((0, 2)),
        velocity=np.zeros((0, 3)),
        inverse_mass=np.zeros((0, 3)),
        work=np.zeros((0, 0)),
        worst=np.zeros(0),
    )
)


@dataclass(frozen=True)
class LawKernels:
    """Compiled kernels of one law for one kind of group; ``sweep`` and ``error`` are C functions with an address."""

    sweep: Any
    error: Any
    prepare: Kernel
    energy: Kernel | None


def law_kernels(law: type[Law], parameter_count: int, rows: int, central: bool, diagonal: bool, chain: bool) -> LawKernels:
    """Kernels for groups of a law (``chain``: the links of one wire as a block, which needs the law's ``slope``)."""
    sweep, error = group_kernels(law, rows, diagonal, chain, SYSTEM_TYPE, {"CENTRAL": central})
    prepare, energy = _step_kernels(law.prepare, law.energy, len(law.PREPARED), parameter_count, rows)
    return LawKernels(sweep, error, prepare, energy)


def group_kernels(
    law: type[Law], rows: int, diagonal: bool, chain: bool, system_type: Any, names: dict[str, Any]
) -> tuple[Any, Any]:
    """C functions (sweep, error) for groups of a law in a system of the given numba type; ``names`` of the templates."""
    # keyed by the functions, not by the class: a script that redefines a law gets the new one
    functions = law.react, law.slope if chain else None
    return _group_kernels(*functions, len(law.PREPARED), rows, diagonal, system_type, tuple(names.items()))


@cache
def _group_kernels(
    react: Callable, slope: Callable | None, prepared_count: int, rows: int, diagonal: bool, system_type: Any, names: tuple
) -> tuple[Any, Any]:
    meaning = {
        "react": react,
        "read": row_reader(prepared_count),
        "PREPARED": prepared_count,
        "ROWS": rows,
        "DIAGONAL": diagonal,
        **dict(names),
    }
    sweep = Kernel(contact_block.sweep, meaning)
    if slope is not None:
        sweep = Kernel(wire_block.sweep, {**meaning, "slope": slope})
    signature = group_signature(system_type)
    return sweep.pointer(signature), Kernel(contact_block.error, meaning).pointer(signature)


@cache
def _step_kernels(
    law_prepare: Callable, law_energy: Callable | None, prepared_count: int, parameter_count: int, rows: int
) -> tuple[Kernel, Kernel | None]:
    reader = row_reader(parameter_count)
    floats = eval(f"lambda row: ({''.join(f'float(row[{k}]), ' for k in range(prepared_count))})")
    preparing = prepare_group.specialise(
        prepare=law_prepare,
        read_parameters=reader,
        read_velocity=row_reader(rows),
        as_floats=floats,
        PARAMETERS=parameter_count,
        PREPARED=prepared_count,
    )
    if law_energy is None:
        return preparing, None
    return preparing, stored_energy.specialise(energy=law_energy, read_parameters=reader, PARAMETERS=parameter_count)
