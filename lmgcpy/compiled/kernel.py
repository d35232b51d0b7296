"""Compiled functions with named slots.

A :class:`Kernel` is a plain Python function that is compiled by numba at its first call and kept in the user's cache
directory. It does four things that ``numba.njit(cache=True)`` does not:

* Plain functions that a kernel calls are compiled with it; they need no decorator.
* Its name in the cache carries a fingerprint of everything the code depends on: its own byte code, the functions it
  calls, in whatever file, the constants it reads, the fields of the named tuples it takes, numba and Python. numba's own
  cache watches the defining file only and would run stale code after an edit elsewhere. A kernel that reads something
  whose content cannot be hashed is compiled without the cache, and a warning says so once
  (:mod:`lmgcpy.compiled.fingerprint`).
* The functions in the machine code have the fingerprint in their names as well. numba counts them instead, in each
  process anew, and of two functions of one name from two processes the linker keeps the first: the code of another law.
* :meth:`Kernel.specialise` gives some global names a new meaning, in the kernel and in the functions that it calls, and
  so makes one kernel per interaction law out of one readable template, at no cost per call and cached like every other.

Kernels run as plain Python, names replaced alike, with ``NUMBA_DISABLE_JIT=1``, and in the steps of small scenes while
another process compiles (:mod:`lmgcpy.compiled.meanwhile`).
"""

from __future__ import annotations

import gc
import types
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numba
import numba.extending
import numpy as np
from numba.core.ccallback import CFunc
from numba.core.dispatcher import Dispatcher
from numba.core.sigutils import normalize_signature

from lmgcpy.compiled.ahead import ahead
from lmgcpy.compiled.cache import KernelCache, extension_in_use
from lmgcpy.compiled.compiler import Compiler
from lmgcpy.compiled.fingerprint import (
    OPTIONS,
    Content,
    Slot,
    Template,
    at_home,
    context,
    fingerprint,
    free_names,
    rebuildable,
    slots_of,
)
from lmgcpy.compiled.mode import INTERPRETED, mode
from lmgcpy.compiled.plain import STAND_INS, bind, plain_copy, unbound
from lmgcpy.compiled.waiting import told_to_wait, turn
from lmgcpy.errors import closest

CompilerError = (
    numba.core.errors.NumbaError,
    getattr(numba.core.errors, "UnsupportedBytecodeError", numba.core.errors.NumbaError),
)
"""Errors that numba raises if it cannot compile a function; 0.60 has one class for all."""


class Kernel(Template):
    """A function compiled at its first call; see the module's text. Made by :func:`kernel`."""

    def __init__(self, function: Callable, names: dict[str, Any] | None = None):
        super().__init__(function, names)
        self._dispatcher: Any = None
        self._interpreted: Callable | None = None
        self._called: Any = None
        self._specialised: dict[tuple, Kernel] = {}
        self.__doc__ = function.__doc__
        self.__name__ = function.__name__

    def __repr__(self) -> str:
        return f"<kernel {self.function.__module__}.{self.__name__}>"

    def __call__(self, *arguments):
        if self._called is None:
            self._called = self.interpreted if mode.plain else self.dispatcher
            mode.called.append(self)
        return self._called(*arguments)

    def forget(self) -> None:
        """Look again, at the next call, how kernels run."""
        self._called = None

    @property
    def interpreted(self) -> Callable:
        """The kernel as plain Python, with names replaced as in the compiled one; divisions by zero are silent, too."""
        if self._interpreted is None:
            assert isinstance(self.function, types.FunctionType)
            self._interpreted = np.errstate(all="ignore")(plain_copy(self.function, self.names, {}))
        return self._interpreted

    @property
    def dispatcher(self) -> Dispatcher:
        """The numba function behind this kernel, cached on disk."""
        if self._dispatcher is None:
            function, complete, cache, options = self._prepare(())
            self._dispatcher = numba.jit(pipeline_class=Compiler, **options)(function)
            self._dispatcher._cache = cache
            self._dispatcher._compiler.compile = _undisturbed(self._dispatcher._compiler.compile, complete)
            _in_use.append(self._dispatcher)
        return self._dispatcher

    def make_ready(self, *arguments: Any) -> None:
        """Load or compile what a call with such arguments needs, and run nothing."""
        if mode.plain:
            return
        dispatcher: Any = self.dispatcher
        dispatcher.compile(tuple(map(dispatcher.typeof_pyval, arguments)))

    def specialise(self, **names: Any) -> Kernel:
        """The kernel with the global ``names`` replaced by functions or constants, which the compiler knows.

        They are also replaced in the functions that the kernel calls, but not in the functions that replace a name: a
        law's own globals stay its own. Raises TypeError for a name that none of these functions reads.
        """
        if not names:
            return self
        key = tuple(sorted((name, id(value)) for name, value in names.items()))
        if key not in self._specialised:
            slots = slots_of(self.function, self.names)
            for name in names:
                if name not in slots:
                    raise TypeError(f"{self!r} reads no name '{name}' that could be replaced{closest(name, slots)}")
            self._specialised[key] = Kernel(self.function, {**self.names, **names})
        return self._specialised[key]

    def pointer(self, signature: numba.core.typing.Signature) -> Pointer:
        """A C function of this signature: its ``.address`` can stand in a table; keep the object alive."""
        pointer = Pointer(self, signature)
        if not mode.plain:
            _ = pointer.compiled  # says here if it cannot be compiled
        return pointer

    def _prepare(self, arguments: tuple) -> tuple[types.FunctionType, Callable[[], None], KernelCache, dict[str, Any]]:
        """The function in the form that numba needs, a function that completes it before it is compiled, its cache, and
        the compiler's flags. ``arguments``: types of the arguments, for a C function."""
        assert isinstance(self.function, types.FunctionType)
        content = Content(self.function, self.names, arguments)
        mark = content.mark

        def why_not_kept() -> str | None:
            if content.unknown:
                return content.unknown[0]
            if fingerprint(self.function, self.names, arguments) != mark:
                return f"what {self.function.__module__}.{self.__name__} reads was changed after its first use"
            return extension_in_use(content.read)

        options = {**OPTIONS, "_nrt": content.counts_references}
        function, complete = _compilable(self.function, self.names, mark, options)
        return function, complete, KernelCache(f"{self.__name__}-{mark}", why_not_kept), options


class Pointer:
    """A C function of a kernel. A number replaces its address if kernels run as plain Python."""

    functions: ClassVar[dict[int, Callable]] = {}
    """Plain functions by number."""

    def __init__(self, kernel: Kernel, signature: numba.core.typing.Signature):
        self._kernel = kernel
        self._signature = signature

    @property
    def address(self) -> int:
        """The address, which only kernels that run as now may call."""
        return self._number if mode.plain else self.compiled.address

    @cached_property
    def compiled(self) -> Any:
        """The function of numba."""
        function, complete, cache, options = self._kernel._prepare(self._signature.args)
        signature = normalize_signature(self._signature)
        made: Any = CFunc(function, signature, locals={}, options=options, pipeline_class=Compiler)
        made._cache = cache
        made._compiler.compile = _undisturbed(made._compiler.compile, complete)
        made.compile()
        _in_use.append(made)
        return made

    @cached_property
    def _number(self) -> int:
        number = len(self.functions) + 1
        self.functions[number] = self._kernel.interpreted
        return number


def intrinsic(stand_in: Callable) -> Callable[[Callable], Any]:
    """Decorator of a function that writes machine code for kernels, see ``numba.extending.intrinsic``; ``stand_in``: a
    function that does the same if kernels run as plain Python."""

    def mark(definition: Callable) -> Any:
        made = numba.extending.intrinsic(definition)
        STAND_INS[id(made)] = made, stand_in
        return made

    return (lambda definition: stand_in) if INTERPRETED else mark


def kernel(function: Callable) -> Kernel:
    """Mark a function as compiled: ``@kernel``. Nothing happens before its first call."""
    return Kernel(function)


def inlined(function: Callable) -> Callable:
    """Mark a function that the compiler must inline in every kernel that calls it, regardless of its size. It is for the
    few functions that are called for each interaction: a call would cost half as much as their work."""
    function.inlined = True  # type: ignore[attr-defined]
    return function


@dataclass(frozen=True)
class Statistics:
    """Origin of the kernels of this process: names with fingerprints, and the types of the arguments."""

    loaded: tuple[str, ...]
    """Kernels found in the cache."""
    compiled: tuple[str, ...]
    """Kernels compiled by this process."""


def statistics() -> Statistics:
    """The kernels of this process so far, loaded and compiled."""
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
        _readers[count] = eval(f"lambda array, start: ({items})", {"np": np, "__name__": __name__})
    return _readers[count]


# ------------------------------------------------------------------------------------- functions as numba wants them


UNWRAPPED = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Flags of functions that only compiled code calls: without a way in from Python they take a third less to compile."""


def _undisturbed(compile: Callable, complete: Callable[[], None]) -> Callable:
    """Complete a function before numba compiles it, with the garbage collector off: it takes a fifth of the time and finds
    nothing. If the compilation fails, the turn ends, so that processes that wait for the code go on."""

    def call(*arguments: Any) -> Any:
        enabled = gc.isenabled()
        gc.disable()
        try:
            with told_to_wait():
                ahead.begin()
                complete()
                return compile(*arguments)
        except BaseException:
            turn.end()
            raise
        finally:
            if enabled:
                gc.enable()

    return call


def _compilable(
    function: types.FunctionType,
    names: dict[str, Any],
    mark: str,
    flags: dict[str, Any],
    built: dict[tuple, Any] | None = None,
) -> tuple[types.FunctionType, Callable[[], None]]:
    """A copy of ``function``, and a function that completes the copy: it sets the replaced names, and a numba function for
    every plain function that it calls. A kernel that is found in the cache is never completed.

    ``mark``: fingerprint, part of the copy's name, which no other code then has. ``flags``: flags of the compiler for the
    plain functions. ``built``: the functions already made for this kernel, by their content; None if there are none yet.
    """

    def ready(value: Any, names: dict[str, Any], built: dict[tuple, Any]) -> Any:
        options = {**flags, **UNWRAPPED}
        if isinstance(value, Slot):
            raise TypeError(f"Nothing stands in for '{value.name}', which {function.__qualname__} calls: specialise it.")
        if isinstance(value, Template):
            value, names = value.function, {**names, **value.names}
        elif rebuildable(value):  # made anew: numba counts the names of these as well
            value, names, options = value.py_func, {}, {**value.targetoptions, **UNWRAPPED, "locals": value.locals}
        if not isinstance(value, types.FunctionType) or at_home(value):
            return value
        if getattr(value, "inlined", False):
            options["forceinline"] = True
        key = *context(value, names), repr(sorted(options.items()))
        if key in built and built[key] is None:
            raise TypeError(f"{value.__qualname__} calls itself: a recursive function cannot be compiled into a kernel.")
        if key not in built:
            built[key] = None  # under way
            built[key] = _inner(value, names, options, flags, built)
        return built[key]

    copy, scope, cells = unbound(function)

    def complete() -> None:
        parts: dict[tuple, Any] = {} if built is None else built
        free = free_names(function, names).items()
        bind(function, {name: ready(value, inner, parts) for name, (value, inner) in free}, scope, cells)

    copy.__qualname__ = f"{function.__qualname__}_{mark}"
    copy.__module__ = function.__module__ or __name__  # of a function without one numba would keep all globals
    return copy, complete


def _inner(
    function: types.FunctionType,
    names: dict[str, Any],
    options: dict[str, Any],
    flags: dict[str, Any],
    built: dict[tuple, Any],
) -> Dispatcher:
    """The numba function made from a plain function. Kernels that call the same function with the same flags share it."""
    mark = Content(function, names, (repr((sorted(options.items()), sorted(flags.items()))),)).mark
    if mark not in _shared:
        copy, complete = _compilable(function, names, mark, flags, built)
        complete()
        _shared[mark] = numba.jit(pipeline_class=Compiler, **options)(copy)
    return _shared[mark]


_shared: dict[str, Dispatcher] = {}
"""Numba functions by fingerprint: a third of those that kernels call are in several kernels."""
