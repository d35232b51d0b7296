"""Problems in FCLIB's local layout (HDF5), the exchange format of published frictional-contact problems.

``fclib_local/W`` holds the operator as CSR (``p``, ``i``, ``x``, ``m``, ``n``, ``nz`` = -2), ``fclib_local/vectors`` ``q``
and ``mu``, ``fclib_local/spacedim`` the dimension. Two extensions: ``fclib_local/law`` (0 Coulomb contact, 1 wire, 2 rod)
with ``fclib_local/compliance`` and, where links have any, ``fclib_local/geometric`` (their geometric stiffness), and
``fclib_local/guesses/r``.
"""

from __future__ import annotations

import os
from typing import Any

import numpy as np

from lmgcpy.errors import named_arguments, place, shown, system_error
from lmgcpy.io.hdf5 import h5py
from lmgcpy.solve.problem import BOTH, CONTACT, PULL, Problem

CODES = {CONTACT: "coulomb", PULL: "rigid-wire", BOTH: "rigid-rod"}
"""Law of each code of the extension; with a compliance, the elastic one."""
ELASTIC = {"rigid-wire": "elastic-wire", "rigid-rod": "elastic-rod"}


@named_arguments
def read(path: str | os.PathLike) -> Problem:
    """Read a problem.

    Raises FileNotFoundError, IsADirectoryError, PermissionError, or ValueError where the file is no problem, is incomplete
    or damaged.
    """
    path = place(path, "path")
    if not os.path.exists(path):
        raise FileNotFoundError(f"There is no file '{path}'.")
    if os.path.isdir(path):
        raise IsADirectoryError(f"'{path}' is a folder, not a file of a problem.")
    if not os.access(path, os.R_OK):
        raise PermissionError(f"The file '{path}' may not be read: change its permissions.")
    try:
        with h5py().File(path, "r") as file:
            return _read(file)
    except (OSError, RuntimeError) as error:
        raise ValueError(f"'{path}' is no HDF5 file, or is damaged: {error}.") from error
    except (LookupError, TypeError, ValueError) as error:
        what = str(error.args[0] if error.args else error).rstrip(".")
        raise ValueError(f"'{path}' is no FCLIB problem: {what}.") from error


def _read(file: Any) -> Problem:
    import scipy.sparse as sparse

    group = file["fclib_local"]
    matrix, vectors = group["W"], group["vectors"]
    dimension = int(np.asarray(group["spacedim"]).ravel()[0])
    q = np.asarray(vectors["q"], dtype=float).ravel()
    mu = np.asarray(vectors["mu"], dtype=float).ravel()
    values, indices, pointers = (np.asarray(matrix[name]).ravel() for name in ("x", "i", "p"))
    W = sparse.csr_array((values.astype(float), indices, pointers), shape=(len(q), len(q)))
    count = len(mu)
    law = np.asarray(group["law"]).ravel() if "law" in group else np.zeros(count, int)
    compliance = np.asarray(group["compliance"], dtype=float).ravel() if "compliance" in group else np.zeros(count)
    guess = np.zeros((count, dimension))
    if "guesses" in group and "r" in group["guesses"]:
        guess = np.asarray(group["guesses"]["r"], dtype=float).reshape(-1, dimension)[:count]
    for code in law:
        if int(code) not in CODES:
            raise ValueError(f"law code {code} is none of 0 (contact), 1 (wire) and 2 (rod)")
    names = [CODES[int(code)] for code in law]
    names = [ELASTIC.get(name, name) if c > 0.0 else name for name, c in zip(names, compliance, strict=True)]
    geometric = np.asarray(group["geometric"], dtype=float).ravel() if "geometric" in group else np.zeros(0)
    return Problem(W, q, mu, dimension, tuple(names), compliance, guess, geometric)


@named_arguments
def write(problem: Problem, path: str | os.PathLike, *, force: bool = False) -> None:
    """Write a problem.

    Raises FileExistsError where the file is there already, unless ``force``, FileNotFoundError where its folder is not,
    IsADirectoryError or PermissionError.
    """
    if not isinstance(problem, Problem):
        raise TypeError(f"write takes a problem, such as Simulation.problem() gives, got {shown(problem)}.")
    path = place(path, "path")
    folder = os.path.dirname(os.path.abspath(path))
    if not os.path.isdir(folder):
        raise FileNotFoundError(f"There is no folder '{folder}' to write '{path}' into: make it first.")
    if os.path.isdir(path):
        raise IsADirectoryError(f"'{path}' is a folder: give the name of a file.")
    if not os.access(path if os.path.exists(path) else folder, os.W_OK):
        raise PermissionError(f"'{path}' cannot be written: it or its folder is read-only.")
    if os.path.exists(path) and not force:
        raise FileExistsError(f"The file '{path}' exists: give another name, or force=True to replace it.")
    try:
        with h5py().File(path, "w") as file:
            _write(problem, file)
    except (OSError, RuntimeError) as error:
        raise system_error(f"'{path}' could not be written", error, "Make room, or give another place.") from error


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
