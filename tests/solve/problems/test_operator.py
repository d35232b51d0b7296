"""W of a problem is checked before any kernel follows its indices; where it is at fault, the sentence is about W."""

import warnings

import numpy as np
import pytest
import scipy.sparse as sparse

import lmgcpy as lm
from lmgcpy.solve.problems.delassus import least_eigenvalue


def problem(W, **more):
    """Contacts in the plane that are pressed."""
    count = W.shape[0] // 2
    parts = {"q": np.tile([-1.0, 0.1], count), "mu": np.full(count, 0.3), "laws": ("coulomb",) * count}
    rest = {"dimension": 2, "compliance": np.zeros(count), "guess": np.zeros((count, 2))}
    return lm.Problem(**{"W": W, **parts, **rest, **more})


def operator(size=8, seed=0):
    A = np.random.default_rng(seed).normal(size=(size, size))
    return sparse.csr_array(A @ A.T)


def with_part(name, place, value, kind="csr", dtype=None):
    """A W with one number of its arrays changed behind scipy's back."""
    W = operator().asformat(kind)
    part = getattr(W, name).astype(dtype) if dtype else getattr(W, name)
    part[place] = value
    setattr(W, name, part)
    return W


def cut(name, kind="csr"):
    W = operator().asformat(kind)
    setattr(W, name, getattr(W, name)[:-1])
    return W


BROKEN = {
    "index far out": (lambda: with_part("indices", 3, 5_000_000), ValueError, r"in 0 \.\.\. 7, got 5000000 for entry 3"),
    "index negative": (lambda: with_part("indices", 3, -3), ValueError, r"indices .* got -3 for entry 3"),
    "index of floats": (lambda: with_part("indices", 3, 1.5, dtype=float), TypeError, "whole numbers, got .* type float64"),
    "index beyond int64": (lambda: with_part("indices", 3, 2**63 + 1, dtype=np.uint64), ValueError, r"got -\d+ for"),
    "indices short": (lambda: cut("indices"), ValueError, "63 indices for 64 entries"),
    "columns far out": (lambda: with_part("indices", 3, 9, kind="csc"), ValueError, "got 9 for entry 3"),
    "blocks far out": (lambda: with_part("indices", 0, 64, kind="bsr"), ValueError, "got 64 for entry 0"),
    "rows far out": (lambda: with_part("row", 3, 9, kind="coo"), ValueError, r"rows of W .* got 9 for entry 3"),
    "pointer falls": (lambda: with_part("indptr", 3, 2), ValueError, "must not fall, but that of line 2 is 16 and then 2"),
    "pointer far out": (lambda: with_part("indptr", -1, 999), ValueError, "must begin with 0 and end .* got 0 and 999"),
    "pointer late": (lambda: with_part("indptr", 0, 4), ValueError, "must begin with 0 .* got 4 and 64"),
    "pointers short": (lambda: cut("indptr"), ValueError, "pointers of W of a problem with 8 lines must be 9, got 8"),
    "entry NaN": (lambda: with_part("data", 5, np.nan), ValueError, "W of a problem must be finite"),
    "entry infinite": (lambda: with_part("data", 5, -np.inf), ValueError, "W of a problem must be finite"),
    "no numbers": (lambda: operator().astype(complex), TypeError, "W of a problem must be an array of numbers"),
    "dense": (lambda: operator().toarray(), TypeError, "W of a problem must be a sparse array"),
    "one entry differs": (lambda: with_part("data", 1, 1.0), ValueError, r"symmetric, but entry \(\d, \d\) is"),
    "triangle": (lambda: sparse.triu(operator()), ValueError, r"symmetric, but entry \(\d, \d\) is"),
    "diagonal negative": (lambda: with_part("data", 9, -1.0), ValueError, "semidefinite, got -1 on its diagonal, in row 1"),
    "entry too large": (lambda: with_part("data", 1, 1e6), ValueError, r"semidefinite, but entry \(0, 1\) is 1e\+06"),
    "mu short": (lambda: (operator(), {"mu": np.ones(3)}), ValueError, r"mu of a problem of 4 .* shape \(4,\), got \(3,\)"),
    "q short": (lambda: (operator(), {"q": np.ones(7)}), ValueError, r"q of a problem of 4 .* shape \(8,\), got \(7,\)"),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_operator_gets_a_sentence(name):
    make, kind, words = BROKEN[name]
    made = make()
    with pytest.raises(kind, match=words) as caught:
        problem(made[0], **made[1]) if isinstance(made, tuple) else problem(made)
    assert str(caught.value).endswith(".")


@pytest.mark.parametrize("kind", ["csr", "csc", "bsr", "coo", "dia", "lil", "dok"])
def test_any_sparse_format_gives_the_same_problem(kind):
    made = problem(operator().asformat(kind))
    assert made.W.format == "csr"
    np.testing.assert_array_equal(made.W.toarray(), operator().toarray())
    assert lm.solve(made, solver=lm.GaussSeidel(max_iterations=5)).impulses.any()


def test_doubled_and_unsorted_entries_are_put_together():
    W = operator()
    columns = np.repeat(W.indices.reshape(8, 8)[:, ::-1], 2)
    doubled = sparse.csr_array((np.repeat(W.data.reshape(8, 8)[:, ::-1], 2) / 2, columns, 2 * W.indptr), shape=W.shape)
    made = problem(doubled)
    assert (made.W.nnz, made.W.indices[:8].tolist()) == (64, list(range(8)))
    np.testing.assert_array_equal(made.W.toarray(), W.toarray())


def test_a_problem_is_its_own():
    """What it was made of may change; its indices may not, as kernels follow them."""
    W = operator()
    made = problem(W)
    W.indices[:] = 10**6
    W.data[:] = np.nan
    np.testing.assert_array_equal(made.W.toarray(), operator().toarray())
    for indices in (made.W.indices, made.W.indptr):
        with pytest.raises(ValueError, match="read-only"):
            indices[0] = 10**6


def test_small_asymmetry_is_let_pass():
    """Published problems are unsymmetric by up to 2e-3 of the diagonal."""
    W = operator()
    W.data[1] += 4e-3 * np.sqrt(W[0, 0] * W[1, 1])
    problem(W)


def test_the_symmetric_part_is_taken_with_the_number():
    """Two published problems have entries that differ by 1.9 % and 22 % of the diagonal; solved as their symmetric part."""
    W = operator()
    whole = lm.solve(problem(W)).impulses
    W.data[1] += 0.2 * np.sqrt(W[0, 0] * W[1, 1])
    with pytest.warns(RuntimeWarning, match=r"entry \(0, 1\) is .* which is 20 % of sqrt\(w_ii w_jj\) apart") as told:
        made = problem(W)
    assert told[0].filename == __file__
    np.testing.assert_allclose(made.W.toarray(), 0.5 * (W + W.T).toarray(), rtol=1e-15)
    one = lm.solve(made, solver=lm.Auto(tolerance=1e-9))
    assert one.status == "converged"
    assert np.abs(one.impulses - whole).max() > 0.0


def three_rows(off):
    """1 on the diagonal and -off beside it: eigenvalues 1 + off twice and 1 - 2 off; tangential rows apart."""
    return np.kron((1.0 + off) * np.eye(3) - off * np.ones((3, 3)), np.diag([1.0, 0.0])) + np.kron(
        np.eye(3), np.diag([0.0, 1.0])
    )


@pytest.mark.parametrize("solver", [lm.GaussSeidel(), lm.AcceleratedGaussSeidel(), lm.Newton(), lm.Auto()])
def test_impulses_that_grow_without_bound_get_a_word_about_W(solver):
    """Three contacts that push each other in: W has the eigenvalue 1 - 2 * 0.9 = -0.8, which no pair of rows tells."""
    made = problem(sparse.csr_array(three_rows(0.9)))
    with pytest.raises(ValueError, match=r"W of a problem must be positive semidefinite, .* eigenvalue of -0\.8 or less"):
        lm.solve(made, solver=solver)


def test_a_problem_without_solution_is_not_blamed_on_W():
    """Three contacts of the semidefinite W of 1 - 2 off = 0 (along (1, 1, 1)), pressed along it: 1.r grows for ever.

    If a solver gives up before the numbers end it says so by its status; it does not say that W is at fault.
    """
    made = problem(sparse.csr_array(three_rows(0.5)))
    solution = lm.solve(made, solver=lm.GaussSeidel(max_iterations=3000))
    assert solution.status != "converged"


@pytest.mark.parametrize("size", [2, 3, 10, 300])
def test_the_least_eigenvalue_is_found_from_above(size):
    """Of C - t, C of unit diagonal: scaled to a unit diagonal again it is (l - t) / (1 - t), l that of C by LAPACK."""
    A = np.random.default_rng(4).normal(size=(size, 2 * size))
    A /= np.linalg.norm(A, axis=1)[:, None]
    C, t = A @ A.T, 0.4
    exact = (np.linalg.eigvalsh(C)[0] - t) / (1.0 - t)
    found = least_eigenvalue(sparse.csr_array(7.0 * (C - t * np.eye(size))))
    assert exact - 1e-12 <= found <= exact + 1e-3


def test_numbers_at_the_edge_give_a_sentence_and_no_warning():
    """Impulses of 1e70 / 1e-70: no number in SI units; the measure of what overflows is infinite."""
    W = sparse.csr_array(1e-70 * np.eye(4))
    made = problem(W, q=-1e70 * np.ones(4))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(FloatingPointError, match="grow beyond all numbers"):
            lm.solve(made)
        large = problem(sparse.csr_array(1e70 * np.eye(4)))
        assert lm.residual(large, 1e70 * np.ones((2, 2))) > 1e100
