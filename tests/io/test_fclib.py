"""FCLIB files: written and read back, and the shared reference problems where they are at hand."""

from pathlib import Path

import numpy as np
import pytest
import scipy.sparse as sparse

import lmgcpy as lm

SHARED = Path(__file__).parents[2].parent / "shared" / "problems"
needs_shared = pytest.mark.skipif(not SHARED.exists(), reason="the reference problems are not beside this checkout")


@pytest.fixture
def problem():
    rng = np.random.default_rng(1)
    A = rng.normal(size=(6, 8))
    return lm.Problem(
        W=sparse.csr_array(A @ A.T),
        q=rng.normal(size=6),
        mu=np.array([0.3, 0.0, 0.0]),
        dimension=2,
        laws=("coulomb", "rigid-wire", "elastic-rod"),
        compliance=np.array([0.0, 0.0, 0.7]),
        guess=rng.normal(size=(3, 2)),
    )


def test_a_problem_comes_back_as_it_was(problem, tmp_path):
    path = tmp_path / "problem.h5"
    lm.io.fclib.write(problem, path)
    back = lm.io.fclib.read(path)
    assert (back.W != problem.W).nnz == 0
    for name in ("q", "mu", "compliance", "guess"):
        np.testing.assert_array_equal(getattr(back, name), getattr(problem, name))
    assert (back.dimension, back.laws) == (problem.dimension, problem.laws)
    r = np.ones((3, 2))
    assert lm.residual(back, r) == lm.residual(problem, r)


def test_nothing_is_overwritten(problem, tmp_path):
    path = tmp_path / "problem.h5"
    lm.io.fclib.write(problem, path)
    with pytest.raises(FileExistsError, match="force=True"):
        lm.io.fclib.write(problem, path)
    lm.io.fclib.write(problem, path, force=True)


@needs_shared
def test_every_shared_problem_can_be_read_and_measured():
    paths = sorted(SHARED.glob("**/*.h5"))
    assert len(paths) > 30
    for path in paths:
        problem = lm.io.fclib.read(path)
        assert lm.residual(problem, np.zeros_like(problem.guess)) in (0.0, 1.0)


@needs_shared
@pytest.mark.parametrize("name", ["rigid-wire", "rigid-rod"])
def test_the_shared_texsol_steps(name):
    """Their stored guesses are warm starts, off by more than doing nothing; sweeps bring them down a hundredfold."""
    problem = lm.io.fclib.read(SHARED / f"texsol2d-{name}.h5")
    assert problem.laws[:299] == (name,) * 299
    assert 1.0 < lm.residual(problem, problem.guess) < 5.0
    solution = lm.solve(problem, solver=lm.AcceleratedGaussSeidel(tolerance=1e-2, max_iterations=5000))
    assert solution.status == "converged"
    assert solution.residual <= 1.01e-2
