"""Compiled kernels on disk: one file for every kernel, signature and kind of processor.

numba's own cache keeps an index beside the code of each function, and fails if it cannot read the index; two processes that
write at once can leave an index that points to the other's code; and numba does not read from a directory in which it
cannot write. Here a file counts only if it is whole: it gets its name when it is complete, and starts with a digest of its
content. A kernel whose file is missing or damaged is compiled again.

The content of a file becomes code of this process. So directories and files count only if they belong to the user or to
root, and no other user may write to them. (The user's own group, with the user's number, is allowed.)

A kernel is not kept if an extension of numba by another package may be part of it (``numba.extending.overload`` and its
kind). An extension changes what a kernel does although the kernel's own text does not name it: ``np.i0(x)``, ``x.half`` or
``a * b`` of tuples call a function of another package, and that function may read anything while it makes code.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import stat
import sys
from collections.abc import Callable
from functools import cache, cached_property
from pathlib import Path
from typing import Any

from numba.core.caching import NullCache
from numba.core.compiler import CompileResult, compile_result
from numba.core.environment import Environment, lookup_environment
from numba.core.runtime import nrtdynmod, rtsys
from numba.core.serialize import dumps
from numba.core.sigutils import normalize_signature
from numba.core.typing.templates import builtin_registry

from lmgcpy.compiled.fingerprint import described
from lmgcpy.compiled.mode import NotCompiled, mode
from lmgcpy.compiled.waiting import turn
from lmgcpy.errors import warn
from lmgcpy.writing import beside

DIGEST = hashlib.sha256().digest_size

AT_HOME = ("numba", "lmgcpy", "abc")
"""Packages whose templates are known; templates that numba makes without a class statement are of module abc."""


_compile_runtime = nrtdynmod.compile_nrt_functions


class RuntimeLater:
    """numba's functions for memory that compiled code allocates, which numba compiles as a process begins to use kernels.

    Machine code from the cache has its own copy of them. So they are compiled once something else asks for them, and a
    process that finds its kernels saves 20 MB and 20 ms.
    """

    def __init__(self, context: Any):
        self._context = context

    @cached_property
    def _compiled(self) -> Any:
        return _compile_runtime(self._context)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._compiled, name)


nrtdynmod.compile_nrt_functions = RuntimeLater


def cache_directory() -> Path:
    """Directory of the compiled kernels: ``LMGCPY_CACHE_DIR`` if set, else the user's cache directory.

    FileNotFoundError where neither is known.
    """
    given = os.environ.get("LMGCPY_CACHE_DIR")
    if given:
        return Path(given)
    import platformdirs

    cause: Exception | None = None
    try:
        found = Path(platformdirs.user_cache_dir("lmgcpy", appauthor=False))
    except RuntimeError as error:
        found, cause = Path("~"), error
    if not found.is_absolute():  # what older versions of platformdirs answer: "~/.cache/lmgcpy"
        raise FileNotFoundError(
            "lmgcpy finds no directory for compiled kernels, as this user has no home directory. Set LMGCPY_CACHE_DIR to a "
            "directory that can be written."
        ) from cause
    return found


class CacheWarning(RuntimeWarning):
    """The directory of the compiled kernels cannot be written, or is not known."""


class KernelCache(NullCache):
    """The cache of one kernel, with the methods that numba calls.

    ``stem``: name and fingerprint of the kernel. ``why_not_kept``: function that returns a clause if the fingerprint does
    not cover all that the code depends on. It is called when the kernel has been compiled, and earlier if another process
    is compiling it.
    """

    def __init__(self, stem: str, why_not_kept: Callable[[], str | None]):
        self.stem = stem.replace("<", "").replace(">", "")  # of "<lambda>", for file systems that have no such names
        self.why_not_kept = why_not_kept

    def load_overload(self, signature: Any, context: Any) -> CompileResult | None:
        """The code for a signature; None if there is no usable code and this process must compile it.

        If another process is compiling the same code, it waits for that process and then looks again.
        """
        _make_ready(context)
        arguments, _ = normalize_signature(signature)
        try:
            path = self._path(arguments, context.codegen())
        except FileNotFoundError:
            return None
        if _is_open_to_others(path.parent):
            return None
        result = _read(path, arguments, context)
        if result is None:
            if mode.loads_only:
                raise NotCompiled
            turn.take(path, worth_waiting=lambda: self.why_not_kept() is None)
            result = _read(path, arguments, context)
            if result is not None:
                turn.end()
        return result

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep compiled code, and end the wait of other processes for it; warns once if the directory cannot be written."""
        try:
            self._save(signature, result)
        finally:
            turn.end()

    def _save(self, signature: Any, result: Any) -> None:
        reason = self.why_not_kept()
        if reason is None and result.library.has_dynamic_globals:
            reason = f"{self.stem} reads a global array of more than a megabyte by its address in this process"
        if reason is not None:
            _warn_once(
                reason,
                f"A compiled kernel cannot be kept, as {reason}: every process compiles it again. Kernels are kept that "
                "read numbers, strings, members of an Enum, arrays and tuples of these, and call plain functions, or "
                "numba.njit ones without signatures.",
                RuntimeWarning,
            )
            return
        arguments, _ = normalize_signature(signature)
        try:
            path = self._path(arguments, result.codegen)
        except FileNotFoundError as error:
            _warn_once("home", f"{error} Until then every process compiles them again.", CacheWarning)
            return
        if _is_open_to_others(path.parent):
            return
        code = dumps(_parts(result))
        try:
            for folder in (path.parent.parent, path.parent):
                folder.mkdir(mode=0o755, parents=True, exist_ok=True)
            _clear_away(path)
            with beside(path, flushed=False) as new:
                new.write_bytes(hashlib.sha256(code).digest() + code)
                new.chmod(new.stat().st_mode & 0o755)
        except OSError as error:
            _warn_once(
                str(path.parent),
                f"lmgcpy cannot keep compiled kernels in {path.parent} ({error.strerror}): every process will compile them "
                "again. Set LMGCPY_CACHE_DIR to a directory that can be written.",
                CacheWarning,
            )

    def _path(self, arguments: tuple, codegen: Any) -> Path:
        key = repr(([described(kind) for kind in arguments], codegen.magic_tuple()))
        return cache_directory() / "kernels" / f"{self.stem}-{hashlib.sha256(key.encode()).hexdigest()[:16]}.kernel"


@cache
def _make_ready(context: Any) -> None:
    """Give the symbols to which machine code is linked; the compiler's registries would take four times as long as all
    kernels. numba's engine starts with a module in which there is nothing: to compile that would take 5 MB."""
    rtsys.initialize(context)
    codegen = context.codegen()
    codegen._engine._ee.remove_module(codegen._llvm_module)


def _read(path: Path, arguments: tuple, context: Any) -> CompileResult | None:
    """The code in a file; None if there is no usable code."""
    try:
        content = _content(path)
    except OSError:
        return None
    if hashlib.sha256(content[DIGEST:]).digest() != content[:DIGEST]:
        return None
    try:
        result = _result(context, *pickle.loads(content[DIGEST:]))
    except (
        Exception
    ):  # a whole file may still not load here: a type that the kernel takes has moved to another module, for example
        return None
    return result if result.signature.args == arguments else None


def _parts(result: Any) -> tuple:
    """What :func:`_result` needs of a kernel.

    numba would also keep its bitcode, for other code that it is linked into, and import the modules of all functions in it.
    No kernel is linked into other code; that saves two thirds of the file, and most of the memory of a loaded kernel.
    """
    library, fndesc = result.library, result.fndesc
    fndesc.typemap = fndesc.calltypes = None  # of the compiler, which is done with them
    names = (fndesc.llvm_func_name, fndesc.llvm_cpython_wrapper_name, fndesc.llvm_cfunc_wrapper_name)
    entries = [name for name in names if library.codegen._engine.is_symbol_defined(name)]
    environments = [
        (one.globals["__name__"], one.consts, one.env_name)
        for one in (result.environment, *result._find_referenced_environments())
    ]
    code = library._get_compiled_object()
    return library.name, code, entries, fndesc, environments, result.signature, result.reload_init


def _result(
    context: Any,
    name: str,
    code: bytes,
    entries: list[str],
    fndesc: Any,
    environments: list[tuple[str, list, str]],
    signature: Any,
    reload_init: list[Callable[[], None]],
) -> Any:
    """The kernel made of these parts, ready to be called in this process."""
    for function in reload_init:
        function()
    library = context.codegen().create_library(name)
    library.enable_object_caching()
    library._set_compiled_object(code)
    library._finalize_final_module()
    library.codegen._engine._defined_symbols.update(entries)
    own, *others = [_environment(*parts) for parts in environments]
    entry_point = context.get_executable(library, fndesc, own)
    for one in others:
        library.codegen.set_env(one.env_name, one)
    return compile_result(
        target_context=context,
        typing_context=context.typing_context,
        library=library,
        environment=own,
        entry_point=entry_point,
        fndesc=fndesc,
        signature=signature,
        objectmode=False,
        lifted=(),
        reload_init=reload_init,
        referenced_envs=others,
    )


def _environment(module: str, constants: list, name: str) -> Environment:
    """The environment of a function in machine code: what it prints, and what the errors say that it raises."""
    environment = lookup_environment(name)
    if environment is None:
        environment = Environment(vars(sys.modules[module]) if module in sys.modules else {"__name__": module})
        environment.consts[:] = constants
        environment.env_name = name
        Environment._memo[name] = environment
    return environment


def _content(path: Path) -> bytes:
    """The content of a file; empty if it is not a regular file, such as a pipe, or if another user may have written it."""
    # without O_NONBLOCK, opening a pipe would wait for a writer
    flags = os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    with open(os.open(path, flags), "rb") as file:
        about = os.fstat(file.fileno())
        if not stat.S_ISREG(about.st_mode):
            return b""
        why = open_to_others(about)
        if why is None:
            return file.read()
    _warn_once(
        str(path), f"lmgcpy does not use the compiled kernel {path}, as {why}: it is compiled again.", RuntimeWarning
    )
    return b""


def _clear_away(path: Path) -> None:
    """Remove a file that has a kernel's name but must not be used; raises OSError."""
    try:
        about = path.lstat()
    except FileNotFoundError:
        return
    if not stat.S_ISREG(about.st_mode) or open_to_others(about) is not None:
        path.unlink()


def _is_open_to_others(kernels: Path) -> bool:
    """Whether another user may write to a directory of kernels or to its parent; warns once."""
    for folder in (kernels.parent, kernels):
        try:
            why = open_to_others(folder.stat())
        except OSError:  # there is none yet
            continue
        if why is not None:
            _warn_once(
                str(folder),
                f"lmgcpy does not use compiled kernels in {folder}, as {why}: what is read there would be run. Every "
                "process compiles them again. Make the directory yours alone (chown, chmod go-w), or set LMGCPY_CACHE_DIR "
                "to another.",
                CacheWarning,
            )
            return True
    return False


def open_to_others(about: os.stat_result) -> str | None:
    """A clause on who may have written a file or directory; None if only the user or root may have."""
    if not hasattr(os, "geteuid"):  # Windows keeps the user's directories to the user
        return None
    if about.st_uid not in (0, os.geteuid()):
        return f"it belongs to user {about.st_uid}"
    of_group = about.st_mode & stat.S_IWGRP and about.st_gid != about.st_uid
    if of_group or about.st_mode & stat.S_IWOTH:
        return f"others may write to it (mode {stat.S_IMODE(about.st_mode):o})"
    return None


_warned: set[str] = set()


def _warn_once(about: str, sentence: str, category: type[Warning]) -> None:
    if about not in _warned:
        _warned.add(about)
        warn(sentence, category)


def extension_in_use(read: set[str]) -> str | None:
    """A clause about an extension of numba that code with these names may use; None if there is none."""
    for template in (*builtin_registry.functions, *builtin_registry.attributes):
        maker = made_by(template)
        if maker is None or not answered(template):
            continue
        name = stands_for(template)
        if name is None or name in read:
            return f"{maker} has taught numba {f'a {name!r}' if name else 'an operator'} of its own"
    return None


def answered(template: Any) -> bool:
    """Whether a template has ever applied in this process: numba asks most of them about types that are not theirs."""
    answers = getattr(template, "_impl_cache", None)
    if answers is None or hasattr(template, "_attr"):  # answers for attributes are not kept there
        return True
    return any((answer[0] if isinstance(answer, tuple) else answer) is not None for answer in answers.values())


def made_by(template: Any) -> str | None:
    """Module and name of the function that made a template; None for templates of numba and lmgcpy."""
    makers: list[Any] = [getattr(template, part, None) for part in ("_overload_func", "_definition_func")]
    makers = [maker for maker in makers if maker is not None]
    if not makers:
        generic = getattr(template, "generic", None)
        makers = [template, generic, *(cell.cell_contents for cell in getattr(generic, "__closure__", None) or ())]
    return next((f"{maker.__module__}.{maker.__qualname__}" for maker in makers if foreign(maker)), None)


def foreign(made: Any) -> bool:
    """Whether a function or class belongs neither to numba nor to lmgcpy; one that was made from text has no module."""
    module, name = getattr(made, "__module__", None), getattr(made, "__qualname__", None)
    return isinstance(module, str) and isinstance(name, str) and module.split(".")[0] not in AT_HOME


def stands_for(template: Any) -> str | None:
    """The name in code of the function or attribute that a template defines; None for an operator, which has no name."""
    name = getattr(template, "_attr", None) or getattr(getattr(template, "key", None), "__name__", None)
    return None if getattr(template.key, "__module__", None) == "_operator" else name
