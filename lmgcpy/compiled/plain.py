"""Functions of kernels as plain Python, with the bits of the compiled ones.

For ``x ** 2`` compiled code multiplies, and Python raises to a power, which rounds otherwise in one of 1000 cases. For
``hypot`` and logarithms compiled code asks the system's library, and Python and numpy have functions of their own. Sums
are taken in the order in which they are written by both.
"""

from __future__ import annotations

import dis
import itertools
import math
import types
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from lmgcpy.compiled.fingerprint import Template, at_home, context, free_names, rebuildable

STAND_INS: dict[int, tuple[Any, Callable]] = {}
"""Intrinsics and what stands in for them, by the identity of the first."""


def plain_copy(function: types.FunctionType, names: dict[str, Any], built: dict[tuple, Any]) -> types.FunctionType:
    """A copy of ``function`` in plain Python, with the names replaced in it and in the functions that it calls. ``built``:
    the copies already made, by their content."""
    copy, scope, cells = unbound(function)
    copy.__code__ = with_products(function.__code__)
    built[context(function, names)] = copy
    found: dict[str, Any] = {}
    value: Any
    for name, (value, inner) in free_names(function, names).items():
        if isinstance(value, Template):
            inner = {**inner, **value.names}
            value = value.function
        elif rebuildable(value):
            value, inner = value.py_func, {}
        elif id(value) in STAND_INS:
            value = STAND_INS[id(value)][1]
        if isinstance(value, types.FunctionType) and not at_home(value):
            key = context(value, inner)
            value = built[key] if key in built else plain_copy(value, inner, built)
        found[name] = of_the_system(value) if value is math or value is np else value
    bind(function, found, scope, cells)
    return copy


def unbound(function: types.FunctionType) -> tuple[types.FunctionType, dict[str, Any], tuple]:
    """A copy of a function without its globals and closure; the dictionary and the cells in which it looks for them."""
    cells = tuple(types.CellType() for _ in function.__code__.co_freevars)
    # numba imports the module of this name when it loads machine code: this one always exists, a law's may not
    scope: dict[str, Any] = {"__builtins__": __builtins__, "__name__": __name__}
    copy = types.FunctionType(function.__code__, scope, function.__name__, function.__defaults__, cells or None)
    copy.__kwdefaults__ = function.__kwdefaults__
    return copy, scope, cells


def bind(function: types.FunctionType, found: dict[str, Any], scope: dict[str, Any], cells: tuple) -> None:
    """Give an unbound copy of ``function`` what was found for its names."""
    scope.update(found)
    for name, cell in zip(function.__code__.co_freevars, cells, strict=True):
        cell.cell_contents = found[name]


@cache
def with_products(code: types.CodeType) -> types.CodeType:
    """The code with ``x * x`` for ``x ** 2``, by two steps of the same lengths."""
    steps, copy, product = bytearray(code.co_code), dis.opmap["COPY"], _argument_of_product()
    last = None
    for two, power in itertools.pairwise(dis.get_instructions(code)):
        loads_two = two.opname.startswith("LOAD_") and type(two.argval) is int and two.argval == 2
        if loads_two and power.argrepr == "**" and last != "EXTENDED_ARG":
            steps[two.offset : two.offset + 2] = copy, 1
            steps[power.offset + 1] = product
        last = two.opname
    return code.replace(co_code=bytes(steps))


@cache
def _argument_of_product() -> int:
    """The argument of the step that multiplies two operands."""
    return next(step.arg for step in dis.get_instructions(lambda x: x * x) if step.opname == "BINARY_OP")  # type: ignore


@cache
def of_the_system(module: types.ModuleType) -> types.SimpleNamespace:
    """``math`` or ``numpy`` with the functions of the system's library for those that they have themselves."""
    names = dict(vars(module))
    if module is math:
        names["hypot"] = np.hypot
    else:
        names.update({name: _of_numbers(name) for name in ("cos", "exp", "log", "sin", "tan")})
    return types.SimpleNamespace(**names)


def _of_numbers(name: str) -> Callable:
    """A function of numbers by ``math``, and by numpy where that raises, as at infinity, or is given an array."""
    own, other = getattr(math, name), getattr(np, name)

    def function(x: Any) -> Any:
        try:
            return own(x)
        except (TypeError, ValueError, OverflowError):
            return other(x)

    return function
