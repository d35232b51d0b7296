"""Compiled kernels on disk: one file for every kernel, signature and kind of processor.

numba's own cache keeps an index beside the code of each function, and stops at one that it cannot read; two processes that
write at once can leave an index that points to the other's code; and it does not even read where it may not write. Here a
file is whole or it does not count: it has its name from the moment it is complete, and starts with a digest of its content.
What is missing or damaged is compiled again.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import warnings
from pathlib import Path
from typing import Any

from numba.core.caching import NullCache
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps
from numba.core.sigutils import normalize_signature

from lmgcpy.writing import beside

DIGEST = hashlib.sha256().digest_size


def cache_directory() -> Path:
    """Directory of the compiled kernels: ``LMGCPY_CACHE_DIR`` if set, else the user's cache directory."""
    given = os.environ.get("LMGCPY_CACHE_DIR")
    if given:
        return Path(given)
    import platformdirs

    return Path(platformdirs.user_cache_dir("lmgcpy", appauthor=False))


class CacheWarning(RuntimeWarning):
    """The directory of the compiled kernels cannot be written."""


class KernelCache(NullCache):
    """What numba asks for, and gives, the machine code of one kernel; ``stem``: its name and fingerprint."""

    def __init__(self, stem: str):
        self.stem = stem.replace("<", "").replace(">", "")  # of "<lambda>", for file systems that have no such names

    def load_overload(self, signature: Any, context: Any) -> CompileResult | None:
        """The code for a signature; None where there is none to be used."""
        context.refresh()
        arguments, _ = normalize_signature(signature)
        try:
            content = self._path(arguments, context.codegen()).read_bytes()
        except OSError:
            return None
        if hashlib.sha256(content[DIGEST:]).digest() != content[:DIGEST]:
            return None
        try:
            result = CompileResult._rebuild(context, *pickle.loads(content[DIGEST:]))
        except Exception:  # whole, but of no use here: a type that it takes has moved to another module, for example
            return None
        return result if result.signature.args == arguments else None

    def save_overload(self, signature: Any, result: Any) -> None:
        """Keep compiled code; a directory that cannot be written is told once."""
        if result.library.has_dynamic_globals:
            warnings.warn(
                f"The kernel {self.stem} cannot be kept, as it reads addresses of this process (of a global array of more "
                "than a megabyte, or of a ctypes function): every process compiles it again.",
                RuntimeWarning,
                stacklevel=2,
            )
            return
        arguments, _ = normalize_signature(signature)
        path = self._path(arguments, result.codegen)
        code = dumps(result._reduce())
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with beside(path, flushed=False) as new:
                new.write_bytes(hashlib.sha256(code).digest() + code)
        except OSError as error:
            _warn_once(path.parent, error)

    def _path(self, arguments: tuple, codegen: Any) -> Path:
        key = repr((str(arguments), codegen.magic_tuple()))
        return cache_directory() / "kernels" / f"{self.stem}-{hashlib.sha256(key.encode()).hexdigest()[:16]}.kernel"


_warned: set[Path] = set()


def _warn_once(directory: Path, error: OSError) -> None:
    if directory not in _warned:
        _warned.add(directory)
        warnings.warn(
            f"lmgcpy cannot keep compiled kernels in {directory} ({error.strerror}): every process will compile them "
            "again. Set LMGCPY_CACHE_DIR to a directory that can be written.",
            CacheWarning,
            stacklevel=2,
        )
