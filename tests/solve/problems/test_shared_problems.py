"""Published frictional-contact problems and steps of TexSol samples, in FCLIB's format, kept beside the project.

They are read from the folder that the environment variable LMGCPY_PROBLEMS names, else from ``shared/problems`` beside the
checkout, and skipped where there is none.
"""

import os
from pathlib import Path

import pytest

import lmgcpy as lm

FOLDER = Path(os.environ.get("LMGCPY_PROBLEMS", Path(__file__).parents[3] / "shared" / "problems"))
PUBLISHED = sorted(FOLDER.glob("fclib/*.h5"))
pytestmark = pytest.mark.skipif(not PUBLISHED, reason=f"there are no problems in {FOLDER}")


@pytest.mark.parametrize(
    "path",
    [pytest.param(p, marks=[pytest.mark.long] * ("granularflow" in p.stem)) for p in PUBLISHED],
    ids=lambda path: path.stem,
)
def test_auto_solves_every_published_problem(path):
    """To 1e-8 in the measure of published solvers, in which none of them got there on all. No file is left out: those whose
    |q| is round-off, down to 4e-18, are solved to 1e-8 of it."""
    problem = lm.io.fclib.read(path)
    solution = lm.solve(problem, solver=lm.Auto(tolerance=3e-10))
    assert lm.residual(problem, solution.impulses, measure="fclib") <= 1e-8


@pytest.mark.default_parameters(name=("texsol2d-rigid-wire",))
@pytest.mark.parametrize(("name", "most"), [("texsol2d-rigid-wire", 40), ("texsol2d-rigid-rod", 300)])
def test_auto_solves_the_texsol_steps(name, most):
    """To 1e-6, from the stored guess, within some Newton steps: what 100 000 sweeps do not do."""
    problem = lm.io.fclib.read(FOLDER / f"{name}.h5")
    solution = lm.solve(problem, solver=lm.Auto(tolerance=1e-6, max_factorisations=most))
    assert solution.status == "converged"
    assert lm.residual(problem, solution.impulses) <= 1e-6
