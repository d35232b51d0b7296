"""One place for everything that has to do with the compiler.

A :class:`Kernel` is a plain Python function that is compiled by numba at its first call and kept in the user's cache
directory. Four things it does that ``numba.njit(cache=True)`` does not:

* Plain functions that a kernel calls are compiled with it, so that nobody has to decorate a helper.
* Its name in the cache carries a fingerprint of everything the code depends on: its own byte code, the functions it
  calls, in whatever file, the constants it reads, the fields of the named tuples it takes, numba and Python. numba's own
  cache watches the defining file only and would run stale code after an edit elsewhere.
* The functions in the machine code have the fingerprint in their names as well. numba counts them instead, in each
  process anew, and of two functions of one name from two processes the linker keeps the first: the code of another law.
* :meth:`Kernel.specialise` gives some global names a new meaning, in the kernel and in the functions that it calls, and
  so makes one kernel per interaction law out of one readable template, at no cost per call and cached like every other.
"""

from __future__ import annotations

import dis
import hashlib
import inspect
import sys
import types
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import llvmlite
import numba
import numpy as np
from numba.core.ccallback import CFunc
from numba.core.dispatcher import Dispatcher
from numba.core.sigutils import normalize_signature

from lmgcpy.jit_cache import KernelCache

OPTIONS: dict[str, Any] = {"error_model": "numpy", "nogil": True}
"""Compiler flags of every kernel: division by zero gives infinity, as in numpy, and the interpreter lock is free."""


class Kernel:
    """A function compiled at its first call; see the module's text. Made by :func:`kernel`."""

    def __init__(self, function: Callable, names: dict[str, Any] | None = None):
        self.function = function
        self.names = names or {}
        self._dispatcher: Any = None
        self._specialised: dict[tuple, Kernel] = {}
        self.__doc__ = function.__doc__
        self.__name__ = function.__name__

    def __repr__(self) -> str:
        return f"<kernel {self.function.__module__}.{self.__name__}>"

    def __call__(self, *arguments):
        return self.dispatcher(*arguments)

    @property
    def dispatcher(self) -> Dispatcher:
        """The numba function behind this kernel, cached on disk."""
        if self._dispatcher is None:
            function, cache = self._prepare(())
            self._dispatcher = numba.njit(**OPTIONS)(function)
            self._dispatcher._cache = cache
            _in_use.append(self._dispatcher)
        return self._dispatcher

    def make_ready(self, *arguments: Any) -> None:
        """Load or compile what a call with such arguments needs; nothing is run."""
        dispatcher: Any = self.dispatcher
        dispatcher.compile(tuple(map(dispatcher.typeof_pyval, arguments)))

    def specialise(self, **names: Any) -> Kernel:
        """The same kernel with the global ``names`` replaced: functions or constants, known to the compiler.

        They are replaced in the functions that the kernel calls as well, but not inside what replaces them: a law's
        own globals stay its own.
        """
        if not names:
            return self
        key = tuple(sorted((name, id(value)) for name, value in names.items()))
        if key not in self._specialised:
            self._specialised[key] = Kernel(self.function, {**self.names, **names})
        return self._specialised[key]

    def pointer(self, signature: numba.core.typing.Signature) -> Any:
        """A C function of this signature: its ``.address`` can stand in a table; keep the object alive."""
        function, cache = self._prepare(signature.args)
        pointer: Any = CFunc(function, normalize_signature(signature), locals={}, options=OPTIONS)
        pointer._cache = cache
        pointer.compile()
        _in_use.append(pointer)
        return pointer

    def _prepare(self, arguments: tuple) -> tuple[types.FunctionType, KernelCache]:
        """The function as numba wants it and its place in the cache; ``arguments``: their types, of a C function."""
        assert isinstance(self.function, types.FunctionType)
        mark = fingerprint(self.function, self.names, arguments)
        return _compilable(self.function, self.names, mark, {}), KernelCache(f"{self.__name__}-{mark}")


def kernel(function: Callable) -> Kernel:
    """Mark a function as compiled: ``@kernel``. Nothing happens before its first call."""
    return Kernel(function)


@dataclass(frozen=True)
class Statistics:
    """Where the kernels of this process come from: names with fingerprints, and the types of what they take."""

    loaded: tuple[str, ...]
    """Found in the cache."""
    compiled: tuple[str, ...]
    """Not found there."""


def statistics() -> Statistics:
    """What numba counted of all kernels so far."""
    loaded: list[str] = []
    compiled: list[str] = []
    for one in _in_use:
        name = one._cache.stem
        if isinstance(one, CFunc):
            (loaded if one.cache_hits else compiled).append(name)
        else:
            loaded += [f"{name} {kinds}" for kinds in one.stats.cache_hits]
            compiled += [f"{name} {kinds}" for kinds in one.stats.cache_misses]
    return Statistics(tuple(loaded), tuple(compiled))


_in_use: list[Any] = []
"""Functions and C functions of numba."""
_readers: dict[int, Callable] = {}


def row_reader(count: int) -> Callable:
    """Function ``(array, start) -> (array[start], ..., array[start + count - 1])``: a tuple whose length the compiler
    knows, which a loop could not give it. Indices are unsigned, so that none is tested for counting from the end."""
    if count not in _readers:
        items = "".join(f"array[np.uintp(start + {k})], " for k in range(count))
        _readers[count] = eval(f"lambda array, start: ({items})", {"np": np})
    return _readers[count]


# ------------------------------------------------------------------------------------------------------ fingerprints


def fingerprint(function: Callable, names: dict[str, Any] | None = None, arguments: tuple = ()) -> str:
    """Hash of all that the machine code of ``function`` depends on (``names``: replaced globals)."""
    digest = hashlib.sha256()
    versions = (sys.version_info[:3], numba.__version__, llvmlite.__version__, sorted(OPTIONS.items()))
    digest.update(repr(versions).encode())
    for argument in arguments:
        _hash_value(digest, getattr(argument, "instance_class", argument), {}, {})
    _hash_function(digest, function, names or {}, {})
    return digest.hexdigest()[:16]


def may_raise(function: Callable) -> bool:
    """Whether ``function``, or a plain function that it calls, holds a raise or an assert statement."""
    seen: set[int] = set()

    def reaches_raise(value: Any) -> bool:
        value = value.function if isinstance(value, Kernel) else getattr(value, "py_func", value)
        if not isinstance(value, types.FunctionType) or id(value) in seen:
            return False
        seen.add(id(value))
        if any(
            step.opname == "RAISE_VARARGS" for code in _code_objects(value.__code__) for step in dis.get_instructions(code)
        ):
            return True
        return any(reaches_raise(called) for called, _ in _free_names(value, {}).values())

    return reaches_raise(function)


def _code_objects(code: types.CodeType) -> Iterator[types.CodeType]:
    yield code
    for constant in code.co_consts:
        if isinstance(constant, types.CodeType):
            yield from _code_objects(constant)


def _free_names(function: types.FunctionType, names: dict[str, Any]) -> dict[str, tuple[Any, dict[str, Any]]]:
    """The global and closure names that a function reads: their values, and the replacements that hold inside those."""
    read = {name for code in _code_objects(function.__code__) for name in code.co_names}
    found = {name: (function.__globals__[name], names) for name in read if name in function.__globals__}
    for name, cell in zip(function.__code__.co_freevars, function.__closure__ or (), strict=True):
        found[name] = (cell.cell_contents, names)
    found.update({name: (value, {}) for name, value in names.items() if name in found})
    return dict(sorted(found.items()))


def _context(value: Any, names: dict[str, Any]) -> tuple:
    """Key of a function and of the replacements that hold inside it: with others it is another function."""
    return (id(value), *sorted((name, id(replacement)) for name, replacement in names.items()))


def _hash_function(digest, function: Callable, names: dict[str, Any], seen: dict) -> None:
    key = _context(function, names)
    if key in seen:
        digest.update(repr(seen[key]).encode())
        return
    seen[key] = len(seen)
    assert isinstance(function, types.FunctionType)
    for code in _code_objects(function.__code__):
        constants = [_in_order(c) for c in code.co_consts if not isinstance(c, types.CodeType)]
        digest.update(repr((code.co_code, constants, code.co_names, code.co_varnames)).encode())
    digest.update(repr(function.__defaults__).encode())
    for value in inspect.get_annotations(function).values():
        if isinstance(value, str):  # where annotations are postponed
            value = function.__globals__.get(value)
        digest.update(repr(getattr(value, "_fields", None)).encode())
    read = {name for code in _code_objects(function.__code__) for name in code.co_names}
    for name, (value, inner) in _free_names(function, names).items():
        digest.update(name.encode())
        if isinstance(value, types.ModuleType):
            _hash_module(digest, value, read, seen)
        else:
            _hash_value(digest, value, inner, seen)


def _hash_module(digest, module: types.ModuleType, read: set[str], seen: dict, path: tuple = ()) -> None:
    """Those attributes of a module, and of modules in it, that have the name of anything that the code reads."""
    digest.update(module.__name__.encode())
    if module.__name__.split(".")[0] in ("math", "numpy", "numba") or module in path:
        return
    for attribute in sorted(read & set(vars(module))):
        digest.update(attribute.encode())
        value = getattr(module, attribute)
        if isinstance(value, types.ModuleType):
            _hash_module(digest, value, read, seen, (*path, module))
        else:
            _hash_value(digest, value, {}, seen)


def _hash_value(digest, value: Any, names: dict[str, Any], seen: dict) -> None:
    if isinstance(value, Kernel):
        _hash_function(digest, value.function, {**names, **value.names}, seen)
    elif isinstance(value, Dispatcher):
        _hash_function(digest, value.py_func, {}, seen)
    elif isinstance(value, types.FunctionType):
        _hash_function(digest, value, names, seen)
    elif isinstance(value, np.ndarray):
        digest.update(repr((value.dtype, value.shape)).encode() + value.tobytes())
    elif isinstance(value, type):
        digest.update(repr((value.__module__, value.__qualname__, getattr(value, "_fields", None))).encode())
    elif isinstance(value, (bool, int, float, complex, str, tuple, frozenset, type(None))):
        digest.update(repr(_in_order(value)).encode())
    else:
        digest.update(repr((type(value).__module__, type(value).__qualname__, str(value))).encode())


def _in_order(constant: Any) -> Any:
    """A constant with its sets sorted: their own order changes from process to process."""
    if isinstance(constant, frozenset):
        return ("frozenset", *sorted(map(repr, constant)))
    return tuple(map(_in_order, constant)) if type(constant) is tuple else constant


# ------------------------------------------------------------------------------------- functions as numba wants them


def _compilable(
    function: types.FunctionType, names: dict[str, Any], mark: str, built: dict[tuple, Any]
) -> types.FunctionType:
    """A copy of ``function`` in which names are replaced and every plain function it calls is a numba function.

    ``mark``: fingerprint of the kernel; with the number of the function among those ``built`` for the kernel it makes a
    name that no other code has.
    """
    number = len(built)

    def ready(value: Any, names: dict[str, Any]) -> Any:
        if isinstance(value, Kernel):
            value, names = value.function, {**names, **value.names}
        if not isinstance(value, types.FunctionType):
            return value
        key = _context(value, names)
        if key in built and built[key] is None:
            raise TypeError(f"{value.__qualname__} calls itself: a recursive function cannot be compiled into a kernel.")
        if key not in built:
            built[key] = None  # under way
            built[key] = numba.njit(**OPTIONS)(_compilable(value, names, mark, built))
        return built[key]

    found = {name: ready(value, inner) for name, (value, inner) in _free_names(function, names).items()}
    closure = tuple(types.CellType(found[name]) for name in function.__code__.co_freevars) or None
    # numba imports the module of this name when it loads machine code: one that is always there, as a law's need not be
    scope = {"__builtins__": __builtins__, "__name__": __name__, **found}
    copy = types.FunctionType(function.__code__, scope, function.__name__, function.__defaults__, closure)
    copy.__qualname__ = f"{function.__qualname__}_{mark}_{number}"
    copy.__module__ = function.__module__
    return copy
