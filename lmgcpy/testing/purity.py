"""Property: a law remembers nothing but its state."""

from __future__ import annotations

import types
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from lmgcpy.compiled.kernel import Kernel
from lmgcpy.laws import Law
from lmgcpy.laws.registry import ARGUMENTS
from lmgcpy.testing.case import LawCase, Nonconformance
from lmgcpy.testing.conformance import run_once, search
from lmgcpy.testing.draw import USUAL, cases


@run_once("purity", "the same call gives the same bits, in any order, and no global changes")
def purity(law: Law) -> str:
    """The functions of a law depend on their arguments alone. In compiled code global variables are constants; in plain
    Python a counter or a list that a function changes would make another law at each call."""
    before, failed = variables_of(law), None
    try:
        search(law, "purity", lambda case, draw: asked_again(case, draw(cases(law))), USUAL, 30)
    except Nonconformance as failure:
        failed = failure
    now = variables_of(law)
    for name, kept in now.items():
        if kept != before.get(name):
            return (
                f"a call of the law's functions changed {name}: a law must keep its memory in the state, see lmgcpy.State."
            )
    if failed is not None:
        raise failed
    return ""


def asked_again(case: LawCase, other: LawCase) -> str:
    """The error in the answers to a case after another case was asked, or ""."""
    first = answers(case)
    answers(other)
    again = answers(case)
    for what, one, two in zip(
        ("history", "prepare", "react", "commit", "slope", "energy", "dissipation"), first, again, strict=True
    ):
        if one != two:
            return f"{what} gave {one}, and {two} when it was asked again: it depends on more than its arguments."
    return ""


def answers(case: LawCase) -> tuple[Any, ...]:
    """All answers of the law to a case, computed anew."""
    case = replace(case)  # a copy has no cached answers
    slope = case.slope(case.q) if case.law.slope is not None else None
    energy = case.energy(case.gap) if case.law.energy is not None else None
    lost = case.dissipation if case.law.dissipation is not None else None
    return case.history, case.prepared, case.impulse, case.after, slope, energy, lost


def variables_of(law: Law) -> dict[str, Any]:
    """Contents of the global and closure variables that the law's functions, and their callees, may read or write."""
    found: dict[str, Any] = {}
    seen: set[int] = set()

    def enter(name: str, value: Any, read: set[str]) -> None:
        value = value.function if isinstance(value, Kernel) else getattr(value, "py_func", value)
        if id(value) in seen:
            return
        if isinstance(value, types.FunctionType):
            seen.add(id(value))
            walk(value)
        elif isinstance(value, types.ModuleType):
            if value.__name__.split(".")[0] not in ("math", "numpy", "numba"):
                for attribute in sorted(read & set(vars(value))):
                    enter(f"{value.__name__}.{attribute}", getattr(value, attribute), read - {attribute})
        else:
            found[name] = content(value)

    def walk(function: types.FunctionType) -> None:
        read = {name for code in code_objects(function.__code__) for name in code.co_names}
        for name in sorted(read & set(function.__globals__)):
            enter(f"the global '{name}' of {function.__module__}", function.__globals__[name], read)
        for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
            enter(f"the variable '{name}' around {function.__qualname__}", cell.cell_contents, read)
        for name, value in vars(function).items():
            enter(f"the attribute '{name}' of {function.__qualname__}", value, read)
        for value in function.__defaults__ or ():
            enter(f"a default of {function.__qualname__}", value, read)

    for name in ARGUMENTS:
        if getattr(law, name) is not None:
            enter(name, getattr(law, name), set())
    return found


def code_objects(code: types.CodeType) -> Iterator[types.CodeType]:
    """A code object and those inside it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from code_objects(constant)


def content(value: Any) -> Any:
    """The content of a variable, in a form that can be compared later."""
    if isinstance(value, np.ndarray):
        return value.tobytes()
    if isinstance(value, Mapping):
        return [(repr(key), content(item)) for key, item in value.items()]
    if isinstance(value, (list, tuple, set)):
        return [content(item) for item in value]
    if isinstance(value, type):
        return [(name, repr(item)) for name, item in vars(value).items() if not name.startswith("_")]
    return repr(value), repr(getattr(value, "__dict__", None))
