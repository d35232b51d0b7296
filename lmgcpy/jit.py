"""One place for everything that has to do with the compiler.

A :class:`Kernel` is a plain Python function that is compiled by numba at its first call and kept in the user's cache
directory. Three things it does that ``numba.njit(cache=True)`` does not:

* Plain functions that a kernel calls are compiled with it, so that nobody has to decorate a helper.
* Its name in the cache carries a fingerprint of everything the code depends on: its own byte code, the functions it
  calls, in whatever file, the constants it reads, the fields of the named tuples it takes, numba and Python. numba's own
  cache watches the defining file only and would run stale code after an edit elsewhere.
* :meth:`Kernel.specialise` gives some global names a new meaning, in the kernel and in the functions that it calls, and
  so makes one kernel per interaction law out of one readable template, at no cost per call and cached like every other.
"""

from __future__ import annotations

import dis
import hashlib
import inspect
import os
import sys
import tempfile
import types
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import llvmlite
import numba
import numpy as np
import platformdirs
from numba.core.dispatcher import Dispatcher

OPTIONS: dict[str, Any] = {"error_model": "numpy", "nogil": True}
"""Compiler flags of every kernel: division by zero gives infinity, as in numpy, and the interpreter lock is free."""


def cache_directory() -> Path:
    """Directory of the compiled kernels: ``LMGCPY_CACHE_DIR`` if set, else the user's cache directory."""
    return Path(os.environ.get("LMGCPY_CACHE_DIR") or platformdirs.user_cache_dir("lmgcpy", appauthor=False))


class Kernel:
    """A function compiled at its first call; see the module's text. Made by :func:`kernel`."""

    def __init__(self, function: Callable, names: dict[str, Any] | None = None):
        self.function = function
        self.names = names or {}
        self._dispatcher: Dispatcher | None = None
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
            function, cached = _at_home_in_cache(self.function, self.names, ())
            self._dispatcher = numba.njit(cache=cached, **OPTIONS)(function)
        return self._dispatcher

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
        function, cached = _at_home_in_cache(self.function, self.names, signature.args)
        return numba.cfunc(signature, cache=cached, **OPTIONS)(function)


def kernel(function: Callable) -> Kernel:
    """Mark a function as compiled: ``@kernel``. Nothing happens before its first call."""
    return Kernel(function)


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


def _compilable(function: types.FunctionType, names: dict[str, Any], built: dict[tuple, Any]) -> types.FunctionType:
    """A copy of ``function`` in which names are replaced and every plain function it calls is a numba function."""

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
            built[key] = numba.njit(**OPTIONS)(_compilable(value, names, built))
        return built[key]

    found = {name: ready(value, inner) for name, (value, inner) in _free_names(function, names).items()}
    closure = tuple(types.CellType(found[name]) for name in function.__code__.co_freevars) or None
    # numba imports the module of this name when it loads machine code: one that is always there, as a law's need not be
    scope = {"__builtins__": __builtins__, "__name__": __name__, **found}
    copy = types.FunctionType(function.__code__, scope, function.__name__, function.__defaults__, closure)
    copy.__qualname__ = function.__qualname__
    copy.__module__ = function.__module__
    return copy


def _at_home_in_cache(function: Callable, names: dict[str, Any], arguments: tuple) -> tuple[Callable, bool]:
    """The compilable copy of ``function`` as if defined in a file of the cache named by its fingerprint.

    numba keeps what it compiles beside the file in which a function is defined; the second result says whether that
    file could be written.
    """
    assert isinstance(function, types.FunctionType)
    copy = _compilable(function, names, {})
    home = _home(f"{function.__name__}-{fingerprint(function, names, arguments)}.py", function)
    if home is None:
        return copy, False
    copy.__code__ = copy.__code__.replace(co_filename=str(home))
    return copy, True


def _home(name: str, function: Callable) -> Path | None:
    path = cache_directory() / "kernels" / name
    if path.exists():
        return path
    try:
        # the whole source file, so that line numbers in a traceback or a profile are right
        text = Path(inspect.getfile(function)).read_text(encoding="utf-8")
    except (OSError, TypeError):
        text = f"# {function.__module__}.{function.__qualname__}: its source is in no file\n"
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile("w", dir=path.parent, delete=False, encoding="utf-8") as file:
            file.write(text)
        os.replace(file.name, path)
    except OSError as error:
        _warn_once(path.parent, error)
        return None
    return path


_warned: set[Path] = set()


def _warn_once(directory: Path, error: OSError) -> None:
    if directory not in _warned:
        _warned.add(directory)
        warnings.warn(
            f"lmgcpy cannot keep compiled kernels in {directory} ({error.strerror}): every process will compile them "
            "again. Set LMGCPY_CACHE_DIR to a directory that can be written.",
            RuntimeWarning,
            stacklevel=2,
        )
