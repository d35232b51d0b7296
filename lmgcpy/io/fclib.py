"""Problems in FCLIB's local layout (HDF5), the exchange format of published frictional-contact problems.

``fclib_local/W`` holds the operator as CSR (``p``, ``i``, ``x``, ``m``, ``n``, ``nz`` = -2), ``fclib_local/vectors`` holds
``q`` and ``mu``, and ``fclib_local/spacedim`` the dimension. lmgcpy adds ``fclib_local/law`` (0 Coulomb contact, 1 wire,
2 rod), ``fclib_local/compliance``, ``fclib_local/geometric`` if links have geometric stiffness, and
``fclib_local/guesses/r``.
"""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from lmgcpy.errors import named_arguments, regular_file, shown
from lmgcpy.io.hdf5 import NumberReader, h5py, in_memory
from lmgcpy.solve.problems.delassus import checked_lines
from lmgcpy.solve.problems.problem import BOTH, CONTACT, PULL, Problem
from lmgcpy.writing import check_target, write_bytes

CODES = {CONTACT: "coulomb", PULL: "rigid-wire", BOTH: "rigid-rod"}
"""Name of the law of each code; with a compliance, :data:`ELASTIC` replaces it."""
ROWS, COLUMNS = -2, -1
"""Values of ``nz``: W is stored by compressed rows or by compressed columns."""
ELASTIC = {"rigid-wire": "elastic-wire", "rigid-rod": "elastic-rod"}


@named_arguments
def read(path: str | os.PathLike) -> Problem:
    """Read a problem.

    Raises FileNotFoundError, IsADirectoryError, PermissionError, and ValueError if the file is no problem, incomplete,
    damaged, or a pipe. ``lmgcpy/io/hdf5.py`` and :class:`lmgcpy.Problem` check the whole content.
    """
    path = regular_file(path, "a file of a problem")
    try:
        with h5py().File(path, "r") as file:
            return _read(NumberReader(file))
    except (OSError, RuntimeError, KeyError) as error:
        raise ValueError(f"'{path}' is no HDF5 file, or is damaged: {_words(error)}.") from error
    except MemoryError as error:
        raise ValueError(f"'{path}' holds more than there is memory for, or is damaged: {_words(error)}.") from error
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError(f"'{path}' is no FCLIB problem: {_words(error)}.") from error


def _words(error: Exception) -> str:
    return str(error.args[0] if error.args else error).rstrip(".")


def _read(file: NumberReader) -> Problem:
    dimension = file.whole("fclib_local/spacedim")
    if dimension not in (2, 3):
        raise ValueError(f"fclib_local/spacedim must be 2 or 3, got {dimension}")
    q, mu = file.reals("fclib_local/vectors/q"), file.reals("fclib_local/vectors/mu")
    W = _operator(file, len(q))
    count = len(mu)
    compliance = np.zeros(count)
    if "fclib_local/compliance" in file:
        compliance = _one_each(file.reals("fclib_local/compliance"), count, "compliance")
    guess = np.zeros((count, dimension))
    if "fclib_local/guesses/r" in file:
        guess = _one_each(file.reals("fclib_local/guesses/r"), count * dimension, "guesses/r").reshape(count, dimension)
    names = ["coulomb"] * count
    if "fclib_local/law" in file:
        codes = _one_each(file.wholes("fclib_local/law"), count, "law").tolist()
        for code in codes:
            if code not in CODES:
                raise ValueError(f"law code {code} is none of 0 (contact), 1 (wire) and 2 (rod)")
        names = [CODES[code] for code in codes]
        names = [ELASTIC.get(name, name) if c > 0.0 else name for name, c in zip(names, compliance, strict=True)]
    geometric = file.reals("fclib_local/geometric") if "fclib_local/geometric" in file else np.zeros(0)
    return Problem(W, q, mu, dimension, tuple(names), compliance, guess, geometric)


def _operator(file: NumberReader, size: int) -> Any:
    """W of a problem with ``size`` rows, from compressed rows (``nz`` = -2) or compressed columns (``nz`` = -1)."""
    import scipy.sparse as sparse

    for name in ("m", "n"):
        if f"fclib_local/W/{name}" in file and file.whole(f"fclib_local/W/{name}") != size:
            given = file.whole(f"fclib_local/W/{name}")
            raise ValueError(f"fclib_local/W/{name} is {given}, but there are {size} numbers in fclib_local/vectors/q")
    kind = file.whole("fclib_local/W/nz") if "fclib_local/W/nz" in file else ROWS
    if kind not in (ROWS, COLUMNS):
        raise ValueError(f"fclib_local/W/nz must be -2 (compressed rows) or -1 (compressed columns), got {kind}")
    values = file.reals("fclib_local/W/x")
    lines = checked_lines(len(values), file.wholes("fclib_local/W/i"), file.wholes("fclib_local/W/p"), size, size)
    make = sparse.csr_array if kind == ROWS else sparse.csc_array
    return make((values[: len(lines[0])], *lines), shape=(size, size))


def _one_each(values: np.ndarray, size: int, name: str) -> np.ndarray:
    if len(values) != size:
        raise ValueError(f"fclib_local/{name} must be {size} numbers, got {len(values)}")
    return values


@named_arguments
def write(problem: Problem, path: str | os.PathLike, *, force: bool = False) -> None:
    """Write a problem.

    Raises ValueError for a problem with rolling friction, for which FCLIB has no place, FileExistsError if the file
    exists, unless ``force``, FileNotFoundError if its folder is missing, IsADirectoryError, PermissionError, and OSError if
    it cannot be written; then an old file stays.
    """
    if not isinstance(problem, Problem):
        raise TypeError(f"write takes a problem, such as Simulation.problem() gives, got {shown(problem)}.")
    if problem.width > problem.dimension:
        raise ValueError(
            "A problem with rolling friction cannot be written: FCLIB's layout has room for the normal and tangential "
            "components of an interaction only."
        )
    path = check_target(path, force=force)
    write_bytes(path, in_memory(lambda file: _write(problem, file), libver=("earliest", "v110")))


def _write(problem: Problem, file: Any) -> None:
    W = problem.W.tocsr()
    group = file.create_group("fclib_local")
    group["spacedim"] = np.array([problem.dimension])
    matrix = group.create_group("W")
    for name, value in (("x", W.data), ("i", W.indices), ("p", W.indptr)):
        matrix[name] = value
    for name, number in (("m", W.shape[0]), ("n", W.shape[1]), ("nz", -2), ("nzmax", W.nnz)):
        matrix[name] = np.array([number])
    vectors = group.create_group("vectors")
    vectors["q"], vectors["mu"] = problem.q, problem.mu
    group["law"] = problem.cones
    group["compliance"] = problem.compliance
    if problem.geometric.any():
        group["geometric"] = problem.geometric
    group.create_group("guesses")["r"] = problem.guess.ravel()
