"""The Delassus operator of a problem that anyone may have made: checked before a compiled kernel follows its indices.

The checks are on W scaled to a unit diagonal, ``w_ij / sqrt(w_ii w_jj)``, which is free of units and of the ratio of
masses. Of a symmetric, positive semidefinite W no entry of it is above 1 in size.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from lmgcpy.errors import numbers, shown, warn

if TYPE_CHECKING:
    import scipy.sparse as sparse

UNSYMMETRIC = 1e-2
"""Largest accepted difference of two scaled entries across the diagonal: up to 2e-3 in most published problems."""
MOST_UNSYMMETRIC = 0.3
"""If they differ by no more than this, the symmetric part is taken, with a warning. In two published problems they differ
by 1.9 % and 22 %, and the symmetric parts are solved to 1e-8."""
ONE_SIDED = 0.5
"""Largest ratio of the antisymmetric part of W to the symmetric part off the diagonal (Frobenius' norms, scaled): above
this W is no Delassus operator. A triangular matrix has 1."""
EXCESS = 1e-2
"""Largest excess of a scaled entry over 1: up to 4e-6 in published problems."""
NEGATIVE = -1e-3
"""An eigenvalue of the scaled W below this is no round-off: the least one of published problems is -6e-7."""
TINY = 1e-12
"""Entries in rows with a zero on the diagonal are round-off up to this part of the largest diagonal entry."""
STEPS = 200
"""Most steps of Lanczos' method; it finds eigenvalues that stand apart from the others within some tens."""
WHAT = "W of a problem"


def checked_operator(W: Any) -> sparse.csr_array:
    """W as compressed rows of its own, sorted, every entry once; its indices cannot be written.

    TypeError: it is no sparse array of numbers; ValueError: indices lead out of it, or an entry is not finite.
    """
    import scipy.sparse as sparse

    if not sparse.issparse(W):
        raise TypeError(f"{WHAT} must be a sparse array such as scipy.sparse.csr_array, got {shown(W)}.")
    if W.ndim != 2:
        raise ValueError(f"{WHAT} must have two dimensions, got shape {W.shape}.")
    if W.format not in ("csr", "csc", "bsr", "coo"):
        W = W.tocoo()
    values = numbers(W.data, WHAT)
    if W.format == "coo":
        indices_of = [
            _whole(given, f"{name} of {WHAT}") for name, given in zip(("rows", "columns"), (W.row, W.col), strict=True)
        ]
        for name, given, size in zip(("rows", "columns"), indices_of, W.shape, strict=True):
            _check_range(given, size, f"{name} of {WHAT}")
            if given.shape != values.shape:
                raise ValueError(f"{WHAT} has {given.size} {name} for {values.size} entries: there must be one for each.")
        csr = sparse.coo_array((values, tuple(indices_of)), shape=W.shape).tocsr()
    else:
        blocks = values.shape[1:] if W.format == "bsr" else (1, 1)
        lines, columns = (size // block for size, block in zip(W.shape, blocks, strict=True))
        if W.format == "csc":
            lines, columns = columns, lines
        indices, pointers = checked_lines(len(values), W.indices, W.indptr, lines, columns)
        kind = {"csr": sparse.csr_array, "csc": sparse.csc_array, "bsr": sparse.bsr_array}[W.format]
        csr = kind((values[: len(indices)], indices, pointers), shape=W.shape).tocsr()
    return sparse_rows(csr)


def sparse_rows(csr: sparse.csr_array) -> sparse.csr_array:
    """Rows with every entry once, sorted; indices cannot be written."""
    csr.sum_duplicates()  # sorts as well
    csr.indices.flags.writeable = csr.indptr.flags.writeable = False
    return csr


def checked_lines(entries: int, indices: Any, pointers: Any, lines: int, size: int) -> tuple[np.ndarray, np.ndarray]:
    """Check indices and pointers of compressed rows or columns: they must stay within ``size`` and ``entries``.

    Returns both, (k,) and (lines + 1,), cut to the entries to which the pointers refer. Raises TypeError if they are not
    whole numbers, ValueError if they are out of range.
    """
    indices, pointers = _whole(indices, f"indices of {WHAT}"), _whole(pointers, f"pointers of {WHAT}")
    if len(pointers) != lines + 1:
        raise ValueError(f"pointers of {WHAT} with {lines} lines must be {lines + 1}, got {len(pointers)}.")
    if len(indices) != entries:
        raise ValueError(f"{WHAT} has {len(indices)} indices for {entries} entries: there must be one for each.")
    if pointers[0] != 0 or pointers[-1] > entries:
        raise ValueError(
            f"pointers of {WHAT} with {entries} entries must begin with 0 and end with that number at the most, got "
            f"{pointers[0]} and {pointers[-1]}."
        )
    falls = np.flatnonzero(pointers[1:] < pointers[:-1])
    if len(falls):
        k = int(falls[0])
        raise ValueError(
            f"pointers of {WHAT} must not fall, but that of line {k} is {pointers[k]} and then {pointers[k + 1]}."
        )
    indices = indices[: int(pointers[-1])]
    _check_range(indices, size, f"indices of {WHAT}")
    return indices, pointers


def _whole(values: Any, name: str) -> np.ndarray:
    values = np.asarray(values)
    if values.dtype.kind not in "iu":
        raise TypeError(f"{name} must be whole numbers, got numbers of type {values.dtype}.")
    if values.ndim != 1:
        raise ValueError(f"{name} must be one row of numbers, got shape {values.shape}.")
    return values.astype(np.int64)  # values of 2^63 and more become negative, and are refused as negative


def _check_range(values: np.ndarray, size: int, name: str) -> None:
    wrong = np.flatnonzero((values < 0) | (values >= size))
    if len(wrong):
        k = int(wrong[0])
        raise ValueError(f"{name} must be in 0 ... {size - 1}, got {values[k]} for entry {k}.")


def symmetric_semidefinite(W: sparse.csr_array) -> sparse.csr_array:
    """A square W from :func:`checked_operator`; if it is not symmetric, its symmetric part, with a warning.

    Raises ValueError if W is far from symmetric, if its diagonal has a negative entry, or if two of its rows alone show
    that it is not positive semidefinite.
    """
    diagonal = W.diagonal()
    if not len(diagonal):
        return W
    if diagonal.min() < 0.0:
        i = int(np.argmin(diagonal))
        raise ValueError(f"{WHAT} must be positive semidefinite, got {diagonal[i]:g} on its diagonal, in row {i}.")
    size, least = np.sqrt(diagonal), TINY * diagonal.max()
    rows, columns = np.repeat(np.arange(len(diagonal)), np.diff(W.indptr)), W.indices
    scale = size[rows] * size[columns]
    excess = np.abs(W.data) > (1.0 + EXCESS) * scale + least
    if excess.any():
        k = int(np.argmax(excess))
        i, j = rows[k], columns[k]
        raise ValueError(
            f"{WHAT} must be positive semidefinite, but entry ({i}, {j}) is {W.data[k]:g}: no more in size than "
            f"{scale[k]:g} goes with the entries {diagonal[i]:g} and {diagonal[j]:g} of the diagonal."
        )
    across = W.T.tocsr()
    if np.array_equal(across.indptr, W.indptr) and np.array_equal(across.indices, W.indices):
        apart = np.abs(W.data - across.data)
    else:
        parted = abs(W - across).tocoo()
        rows, columns, apart = parted.row, parted.col, parted.data
        scale = size[rows] * size[columns]
    wrong = apart > UNSYMMETRIC * scale + least
    if not wrong.any():
        return W
    by = np.divide(apart, scale, out=np.zeros_like(apart), where=scale > 0.0)
    k = int(np.argmax(np.where(wrong, np.where(scale > 0.0, by, np.inf), 0.0)))
    i, j = rows[k], columns[k]
    entries = f"entry ({i}, {j}) is {W[i, j]:g} and entry ({j}, {i}) is {W[j, i]:g}"
    half = 0.5 * (W + across)
    beside = half.tocoo()
    off = (beside.row != beside.col) & (size[beside.row] * size[beside.col] > 0.0)
    rest = np.linalg.norm(beside.data[off] / (size[beside.row[off]] * size[beside.col[off]]))
    if scale[k] == 0.0 or by[k] > MOST_UNSYMMETRIC or 0.5 * np.linalg.norm(by) > ONE_SIDED * rest:
        raise ValueError(f"{WHAT} must be symmetric, but {entries}.")
    warn(
        f"{WHAT} is not symmetric: {entries}, which is {100.0 * by[k]:.2g} % of sqrt(w_ii w_jj) apart. Its symmetric part "
        "is solved; W = H^T M^-1 H would be symmetric to round-off."
    )
    return sparse_rows(half)


def least_eigenvalue(W: sparse.csr_array) -> float:
    """An upper bound of the least eigenvalue of the symmetric part of W, scaled to a unit diagonal: a negative one proves
    that W is not positive semidefinite.

    Lanczos' method without reorthogonalisation; its extreme values still converge to the extreme eigenvalues (Paige 1980).
    It costs :data:`STEPS` products with W, so it is called only for problems that could not be solved.
    """
    import scipy.sparse as sparse
    from scipy.linalg import eigvalsh_tridiagonal

    diagonal = W.diagonal()
    scale = sparse.diags_array(1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0)))
    scaled = (scale @ (0.5 * (W + W.T)) @ scale).tocsr()
    vector = np.random.default_rng(0).standard_normal(len(diagonal))
    vector /= np.linalg.norm(vector)
    before, beta = np.zeros_like(vector), 0.0
    on: list[float] = []
    beside: list[float] = []
    for _ in range(min(STEPS, len(diagonal))):
        product = scaled @ vector - beta * before
        on.append(float(vector @ product))
        product -= on[-1] * vector
        beta = float(np.linalg.norm(product))
        beside.append(beta)
        if beta <= 1e-12:
            break
        before, vector = vector, product / beta
    return float(eigvalsh_tridiagonal(np.array(on), np.array(beside[:-1]))[0]) if on else 0.0


def unsolvable(W: sparse.csr_array, *, finite: bool) -> None:
    """Raise the reason why a solve failed: ValueError if W is not positive semidefinite, else FloatingPointError unless the
    impulses are ``finite``."""
    least = least_eigenvalue(W)
    if least < NEGATIVE:
        raise ValueError(
            f"{WHAT} must be positive semidefinite, but scaled to a unit diagonal it has an eigenvalue of {least:.2g} or "
            "less, and the problem was not solved: make it as H^T M^-1 H."
        )
    if not finite:
        raise FloatingPointError(
            "The impulses of this problem grow beyond all numbers: it has no solution, as where rigid links contradict "
            "each other, or its numbers lie too far apart. Give links a compliance, or look at the sizes in W and q."
        )
