"""Reports say how many steps were not solved, why, and what is left of them."""

from types import SimpleNamespace

import numpy as np

from lmgcpy.experiment.study.unsolved import CAUSES, unsolved_words
from lmgcpy.solve.problems.report import SOLVED, STATUS


def run(*status):
    return SimpleNamespace(status=list(status), residual=0.01 * np.arange(1, len(status) + 1))


def test_nothing_is_said_of_solved_steps():
    assert unsolved_words({"a": run("converged", "round-off")}, tolerance=1e-2, max_iterations=9) == ""


def test_counts_causes_and_residuals():
    """Unsolved are the residuals 0.02 and 0.03 of a, 0.01 of c."""
    runs = {"a": run("converged", "budget spent", "stagnated"), "b": run("converged"), "c": run("budget spent")}
    words = unsolved_words(runs, tolerance=5e-3, max_iterations=200)
    assert "not solved to the tolerance: a 2 of 3; c 1 of 1. Of these 2 ran out of sweeps, 1 stagnated" in words
    assert "at most 2.0e-02, the worst with 3.0e-02; the tolerance is 5e-03." in words
    assert "keep it" not in words
    loose = unsolved_words(runs, tolerance=2.5e-2, max_iterations=200)
    assert "2 of them keep it, and miss the bound of forces or of displacements." in loose
    assert "The solver has 200 sweeps for a step" in words
    assert "sweeps for a step" not in unsolved_words({"a": run("locked")}, tolerance=1e-2, max_iterations=200)


def test_every_unsolved_status_has_words():
    assert set(CAUSES) == set(STATUS) - set(SOLVED)
