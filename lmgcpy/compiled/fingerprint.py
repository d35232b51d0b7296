"""Fingerprint of everything that the machine code of a function depends on, and the names that cannot be hashed.

:meth:`Content._add` hashes numbers, strings, members of an Enum, arrays, tuples of these, plain functions and
``numba.njit`` functions with all that they read in turn. Objects of Python, numpy and numba are hashed by name, and the
versions of these packages as well. The content of any other object, such as a ``numba.vectorize`` function or an
intrinsic, is not guessed: its name is entered in :attr:`Content.unknown`, and the machine code is not kept (see
:mod:`lmgcpy.compiled.cache`).
"""

from __future__ import annotations

import dis
import hashlib
import inspect
import itertools
import operator
import sys
import types
import uuid
from collections.abc import Callable, Iterator
from enum import Enum, EnumMeta
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core import types as kinds
from numba.core.compiler import Compiler
from numba.core.dispatcher import Dispatcher
from numba.core.registry import CPUDispatcher
from numba.extending import is_jitted

from lmgcpy.compiled.reference import ReferenceType

OPTIONS: dict[str, Any] = {"error_model": "numpy", "nogil": True}
"""Compiler flags of every kernel: division by zero gives infinity, as in numpy, and the interpreter lock is free."""
SWITCHES = (
    *("OPT", "BOUNDSCHECK", "LOOP_VECTORIZE", "SLP_VECTORIZE", "ENABLE_AVX", "DEBUGINFO_DEFAULT", "LLVM_REFPRUNE_PASS"),
    *("DISABLE_INTEL_SVML", "USING_SVML", "ENABLE_PROFILING"),
)
"""Settings of ``numba.config``, or ``NUMBA_...`` in the environment, that change the machine code."""
HOUSES = ("builtins", "math", "cmath", "_operator", "numpy", "numba")
"""Packages whose functions and classes are hashed by name, as the versions of the packages are hashed."""
ALLOCATING = frozenset(("array", "empty", "full", "ravel", "zeros"))
"""Names under which lmgcpy's own kernels make arrays: with another one they would not compile."""
KIND = inspect.CO_VARARGS | inspect.CO_VARKEYWORDS | inspect.CO_GENERATOR | inspect.CO_COROUTINE
"""Flags of a code object that describe the kind of function. Under a profiler numba changes other flags."""
PLAIN = (bool, int, float, complex, str, bytes, type(None), type(Ellipsis))


class Template:
    """A function, and the values that replace global ``names`` in it."""

    def __init__(self, function: Callable, names: dict[str, Any] | None = None):
        self.function = function
        self.names = names or {}


class Slot:
    """Placeholder for a function that only a specialisation of a template gives; code that still reads one cannot be
    compiled."""

    def __init__(self, name: str):
        self.name = name

    def __call__(self, *arguments: Any) -> Any:
        raise TypeError(f"Nothing stands in for '{self.name}'.")


class Content:
    """All that the machine code of ``function`` depends on (``names``: replaced globals; ``arguments``: types of numba)."""

    def __init__(self, function: Callable, names: dict[str, Any] | None = None, arguments: tuple = ()):
        self.unknown: list[str] = []
        """Objects that the code reads and that cannot be hashed, one clause each."""
        self.read: set[str] = set()
        """Every name that is read, of globals and of attributes."""
        self.foreign = False
        """Whether a function from outside lmgcpy takes part."""
        self._digest = hashlib.sha256()
        self._seen: dict[tuple, int] = {}
        self._trail: list[str] = []
        """The chain of calls down to the function that is being hashed."""
        self._note(versions(), *map(described, arguments))
        self._add_function(function, names or {})

    @property
    def mark(self) -> str:
        """The hash; if some content is unknown, a hash that never comes again."""
        digest = self._digest.copy()
        digest.update(repr(self.counts_references).encode())
        if self.unknown:
            digest.update(uuid.uuid4().bytes)
        return digest.hexdigest()[:16]

    @property
    def counts_references(self) -> bool:
        """Whether the code must count references, as it may make arrays; functions from outside lmgcpy may always. Code
        that counts is half as long again, and takes an eighth longer to compile."""
        return self.foreign or not ALLOCATING.isdisjoint(self.read)

    def _note(self, *values: Any) -> None:
        self._digest.update(repr(values).encode())

    def _refuse(self, name: str, what: str) -> None:
        here = self._trail[-1]
        asking = next((way for way in self._trail if not way.startswith("lmgcpy.")), here)
        called = "" if asking == here else f" (called by {asking})"
        self.unknown.append(f"{here}{called} reads '{name}', {what}")

    def _add(self, value: Any, name: str, names: dict[str, Any], *, direct: bool = False) -> None:
        """Add a value to the hash; ``name``: its name in the code that reads it. ``names``: names that are replaced in it,
        if it is a plain function. ``direct``: whether it is read by this name alone, so that a ``numba.njit`` function is
        made anew under a name of its own."""
        kind = type(value)
        if isinstance(value, Template):
            self._add_function(value.function, {**names, **value.names})
        elif kind in PLAIN:
            self._note(value)
        elif kind in (tuple, frozenset) or (isinstance(value, tuple) and hasattr(kind, "_fields")):
            self._note(kind.__qualname__, getattr(kind, "_fields", None), len(value))
            for item in sorted(value, key=repr) if kind is frozenset else value:
                self._add(item, name, {})
        elif isinstance(value, Enum):
            self._note(kind.__qualname__, value.name)
            self._add(value.value, name, {})
        elif kind is np.ndarray and not value.dtype.hasobject:
            self._note(value.dtype, value.shape, value.strides, value.flags.writeable, value.flags.aligned)
            self._digest.update(value.tobytes())
        elif isinstance(value, np.generic) and not value.dtype.hasobject and kind.__module__ == "numpy":
            self._note(kind.__name__, value.dtype, value.tobytes())
        elif isinstance(value, (kinds.Number, kinds.Boolean, np.dtype)):
            self._note(kind.__qualname__, repr(value))
        elif at_home(value):
            self._note(home_of(value), name_of(value))
        elif isinstance(value, types.FunctionType):
            self._add_function(value, names)
        elif rebuildable(value) and (direct or has_its_name(value)):
            self._note(sorted((key, repr(option)) for key, option in value.targetoptions.items()))
            self._note(sorted((key, repr(local)) for key, local in value.locals.items()))
            self._add_function(value.py_func, {})
        elif isinstance(value, type) and issubclass(value, BaseException):
            self._note(value.__module__, value.__qualname__)
        elif isinstance(value, EnumMeta):
            self._note(value.__module__, value.__qualname__)
            for member in value.__members__.values():  # type: ignore[var-annotated]
                self._add(member, name, {})
        elif isinstance(value, type) and issubclass(value, tuple) and hasattr(value, "_fields"):
            self._note(value.__module__, value.__qualname__, value._fields)
            for default in getattr(value, "_field_defaults", {}).values():
                self._add(default, name, {})
        elif own_intrinsic(value):
            self._add_intrinsic(value)
        else:
            self._note(name)
            self._refuse(name, f"{described_kind(value)}, whose content cannot be told")

    def _add_function(self, function: Callable, names: dict[str, Any]) -> None:
        key = context(function, names)
        if key in self._seen:
            self._note(self._seen[key])
            return
        self._seen[key] = len(self._seen)
        assert isinstance(function, types.FunctionType)
        self._trail.append(f"{function.__module__}.{function.__qualname__}")
        self.foreign |= not str(function.__module__).startswith("lmgcpy.")
        self._note(getattr(function, "inlined", False))
        for code in code_objects(function.__code__):
            self.read.update(code.co_names)
            self._add_code(code)
            if "getattr" in code.co_names and "getattr" not in function.__globals__:
                self._refuse("getattr", "which reads an attribute whose name is not in the code")
        for default in (*(function.__defaults__ or ()), *(function.__kwdefaults__ or {}).values()):
            self._add(default, "a default argument", {})
        for value in inspect.get_annotations(function).values():
            if isinstance(value, str):  # where annotations are postponed
                value = function.__globals__.get(value)
            self._note(getattr(value, "_fields", None))
        reads = attributes_read(function)
        for name, (value, inner) in free_names(function, names).items():
            self._note(name)
            if isinstance(value, types.ModuleType):
                for chain in sorted(reads.get(name, ())):
                    self._add_attribute(value, name, chain)
            else:
                self._add(value, name, inner, direct=True)
        self._trail.pop()

    def _add_code(self, code: types.CodeType) -> None:
        constants = [in_order(c) for c in code.co_consts if not isinstance(c, types.CodeType)]
        self._note(code.co_code, constants, code.co_names, code.co_varnames, code.co_cellvars, code.co_freevars)
        self._note(code.co_flags & KIND, code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount)
        self._note(getattr(code, "co_exceptiontable", None))

    def _add_attribute(self, module: types.ModuleType, name: str, chain: tuple[str, ...]) -> None:
        """Add the attributes that the code reads of a module, or of a module in it."""
        value: Any = module
        for attribute in chain:
            if not isinstance(value, types.ModuleType):
                break
            name = f"{name}.{attribute}"
            try:
                value = getattr(value, attribute)
            except AttributeError:
                value = None
        self._note(name)
        if isinstance(value, types.ModuleType):
            self._refuse(name, "a module that is handed on")
        else:
            self._add(value, name, {})

    def _add_intrinsic(self, value: Any) -> None:
        """Add an intrinsic of lmgcpy: Python that writes code and reads only its constants, llvmlite and numba."""
        known = len(self.unknown)
        self._add_function(value._defn, {})
        del self.unknown[known:]


def fingerprint(function: Callable, names: dict[str, Any] | None = None, arguments: tuple = ()) -> str:
    """Hash of all that the machine code of ``function`` depends on (``names``: replaced globals)."""
    return Content(function, names, arguments).mark


def versions() -> tuple:
    """Of everything that takes part in making machine code, but the processor."""
    made_by = sys.version_info[:3], getattr(sys, "abiflags", ""), numba.__version__, llvmlite.__version__, np.__version__
    return (
        *made_by,
        own_part(),
        sorted(OPTIONS.items()),
        *(str(getattr(numba.config, switch, None)) for switch in SWITCHES),
    )


@cache
def own_part() -> str:
    """Hash of the parts that lmgcpy adds to numba's compiler."""
    added = (Path(__file__).with_name(name).read_bytes() for name in ("compiler.py", "reference.py"))
    return hashlib.sha256(b"".join(added)).hexdigest()


def described(kind: Any) -> str:
    """A type of numba with the fields of its named tuples, which its name leaves out."""
    if isinstance(kind, kinds.BaseTuple):
        made = getattr(kind, "instance_class", tuple)
        fields, parts = getattr(kind, "fields", ()), getattr(kind, "types", ())
        return f"{made.__module__}.{made.__qualname__}{fields}[{', '.join(map(described, parts))}]"
    return f"&{described(kind.kind)}" if isinstance(kind, ReferenceType) else str(kind)


def at_home(value: Any) -> bool:
    """Whether a value is a function or class that Python, numpy or numba have under its own name."""
    home = home_of(value)
    return isinstance(home, str) and home.split(".")[0] in HOUSES and has_its_name(value, home)


def home_of(value: Any) -> Any:
    """The module of a function or class; before numpy 2.2 universal functions do not name theirs."""
    return "numpy" if isinstance(value, np.ufunc) else getattr(value, "__module__", None)


def name_of(value: Any) -> Any:
    """The name of a function or class in its module."""
    return getattr(value, "__qualname__", getattr(value, "__name__", None))


def has_its_name(value: Any, home: str | None = None) -> bool:
    """Whether the name of a function or class in its module refers to it, so that the name identifies it."""
    name, home = name_of(value), home or value.__module__
    if not isinstance(name, str) or not isinstance(home, str):
        return False
    try:
        return operator.attrgetter(name)(sys.modules[home]) is value
    except (KeyError, AttributeError):
        return False


def rebuildable(value: Any) -> bool:
    """Whether a value is a ``numba.njit`` function that the same decorator makes again from its Python function."""
    kind: Any = type(value)
    return (
        kind is CPUDispatcher
        and value._can_compile  # it has no signatures of its own
        and value._compiler.pipeline_class is Compiler
        and not value.targetoptions.get("forceobj")
        and all(type(option) in (*PLAIN, set, frozenset) for option in value.targetoptions.values())
    )


def own_intrinsic(value: Any) -> bool:
    """Whether a value is an intrinsic of lmgcpy itself."""
    definition = getattr(value, "_defn", None)
    return isinstance(definition, types.FunctionType) and definition.__module__.startswith("lmgcpy.")


def described_kind(value: Any) -> str:
    """Description of a value, for a sentence."""
    if isinstance(value, Dispatcher):
        return "a numba.jit function with signatures or options of its own, or without a name in its module"
    if is_jitted(value):
        return "a compiled function"
    if isinstance(value, type):
        return f"the class {value.__module__}.{value.__qualname__}"
    return f"an object of {type(value).__module__}.{type(value).__qualname__}"


def may_raise(function: Callable) -> bool:
    """Whether ``function``, or a plain function that it calls, holds a raise or an assert statement, or returns None in
    some cases and a value in others: numba raises where None is then used as a value."""
    seen: set[int] = set()

    def reaches_raise(value: Any) -> bool:
        value = value.function if isinstance(value, Template) else getattr(value, "py_func", value)
        if not isinstance(value, types.FunctionType) or id(value) in seen:
            return False
        seen.add(id(value))
        if any(_code_may_raise(code) for code in code_objects(value.__code__)):
            return True
        return any(reaches_raise(called) for called, _ in free_names(value, {}).values())

    return reaches_raise(function)


def _code_may_raise(code: types.CodeType) -> bool:
    steps = list(dis.get_instructions(code))
    if any(step.opname == "RAISE_VARARGS" for step in steps):
        return True
    returned = [
        before.argval if before.opname == "LOAD_CONST" else ... if step.opname == "RETURN_VALUE" else step.argval
        for before, step in itertools.pairwise(steps)
        if step.opname in ("RETURN_VALUE", "RETURN_CONST")
    ]
    return None in returned and any(value is not None for value in returned)


def code_objects(code: types.CodeType) -> Iterator[types.CodeType]:
    """A function's code, and the codes of the functions defined in it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from code_objects(constant)


def free_names(function: types.FunctionType, names: dict[str, Any]) -> dict[str, tuple[Any, dict[str, Any]]]:
    """The global and closure names that a function reads: their values, and the replacements that hold in each value."""
    read = {name for code in code_objects(function.__code__) for name in code.co_names}
    found = {name: (function.__globals__[name], names) for name in read if name in function.__globals__}
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        found[name] = (cell.cell_contents, names)
    found.update({name: (value, {}) for name, value in names.items() if name in found})
    return dict(sorted(found.items()))


def slots_of(function: Any, names: dict[str, Any]) -> set[str]:
    """The names that can be replaced in a function: the globals and closures that it, and the functions that it calls,
    read. Functions that replace a name are not searched."""
    found: set[str] = set()
    todo: list[tuple[Any, dict[str, Any]]] = [(function, names)]
    seen: set[tuple] = set()
    while todo:
        current, replaced = todo.pop()
        if context(current, replaced) in seen:
            continue
        seen.add(context(current, replaced))
        for name, (value, inner) in free_names(current, replaced).items():
            found.add(name)
            part: Any = value
            if isinstance(part, Template):
                part, inner = part.function, {**inner, **part.names}
            if isinstance(part, types.FunctionType) and not at_home(part) and name not in replaced:
                todo.append((part, inner))
    return found


def attributes_read(function: types.FunctionType) -> dict[str, set[tuple[str, ...]]]:
    """Chains of attributes that a function reads, by global or closure name: ``a.b.c`` and ``a`` alone are
    ``{"a": {("b", "c"), ()}}``."""
    found: dict[str, set[tuple[str, ...]]] = {}
    for code in code_objects(function.__code__):
        for name, chain in chains(code):
            found.setdefault(name, set()).add(chain)
    return found


@cache
def chains(code: types.CodeType) -> set[tuple[str, tuple[str, ...]]]:
    """Pairs (name, chain of attributes) of one code object; cached, as many kernels share it."""
    found = set()
    name: str | None = None
    chain: tuple[str, ...] = ()
    for step in dis.get_instructions(code):
        if step.opname == "EXTENDED_ARG":
            continue
        if name is not None and step.opname in ("LOAD_ATTR", "LOAD_METHOD"):
            chain = (*chain, step.argval)
            continue
        if name is not None:
            found.add((name, chain))
        loads = step.opname in ("LOAD_GLOBAL", "LOAD_NAME", "LOAD_DEREF")
        name, chain = step.argval if loads else None, ()
    return found


def context(value: Any, names: dict[str, Any]) -> tuple:
    """Key of a function and of the replacements that hold inside it: with others it is another function."""
    return (id(value), *sorted((name, id(replacement)) for name, replacement in names.items()))


def in_order(constant: Any) -> Any:
    """A constant with its sets sorted: their own order changes from process to process."""
    if isinstance(constant, frozenset):
        return ("frozenset", *sorted(map(repr, constant)))
    return tuple(map(in_order, constant)) if type(constant) is tuple else constant
