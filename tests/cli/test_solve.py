"""``lmgcpy solve`` and ``lmgcpy bench``: what they write and say. Wrong input is in ``test_bad_command_line.py``."""

import csv
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.sparse as sparse
import suites
from click.testing import CliRunner

import lmgcpy as lm
from lmgcpy.bench.report import COLOURS
from lmgcpy.cli import main
from lmgcpy.cli.solve import briefly
from lmgcpy.solve.solve_to_measure import solve_to_measure


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def problem(count=24, seed=0):
    """Contacts between neighbours of a line of equal bodies, thrown together."""
    rng = np.random.default_rng(seed)
    H = sparse.lil_array((2 * count, 3 * (count + 1)))
    for i in range(count):
        a, c = 3 * i, 3 * (i + 1)
        H[2 * i, c], H[2 * i, a] = 1.0, -1.0
        H[2 * i + 1, c + 1], H[2 * i + 1, a + 1] = 1.0, -1.0
        H[2 * i + 1, c + 2], H[2 * i + 1, a + 2] = -0.5, -0.5
    H = H.tocsr()
    W = sparse.csr_array(H @ H.T)
    q = rng.normal(-0.3, 1.0, 2 * count)
    laws = ("coulomb",) * count
    return lm.Problem(W, q, np.full(count, 0.4), 2, laws, np.zeros(count), np.zeros((count, 2)))


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "problem.h5"
    lm.io.fclib.write(problem(), path)
    return path


@pytest.mark.parametrize("solver", ["auto", "newton", "accelerated", "gauss-seidel"])
def test_solve_writes_a_solution(file, tmp_path, solver):
    """Both errors are recomputed from what the file holds."""
    out = tmp_path / "solution.h5"
    done = run("solve", file, "--solver", solver, "--tolerance", "1e-9", "--out", out)
    assert done.exit_code == 0, done.output
    assert "24 interactions in 2D" in done.output
    assert "24 coulomb" in done.output
    assert "converged after" in done.output
    given = problem()
    with h5py.File(out) as written:
        group = written["solution"]
        r, u = group["r"][:].reshape(-1, 2), group["u"][:]
        about = dict(group.attrs)
    assert about["status"] == "converged"
    assert about["solver"] == solver
    natural = lm.residual(given, r)
    assert natural <= 1e-9
    assert about["error_natural"] == pytest.approx(natural, rel=1e-12)
    assert about["error_fclib"] == pytest.approx(lm.residual(given, r, measure="fclib"), rel=1e-12)
    assert f"natural {natural:.3g}" in done.output
    np.testing.assert_array_equal(u, given.W @ r.ravel() + given.q)


def test_exit_code_of_what_is_not_solved(file, tmp_path):
    """And what was reached is written all the same."""
    out = tmp_path / "solution.h5"
    done = run("solve", file, "--solver", "gauss-seidel", "--tolerance", "1e-12", "--max-iterations", "2", "--out", out)
    assert done.exit_code == 1
    assert "budget spent after 2 sweeps" in done.output
    with h5py.File(out) as written:
        assert written["solution"].attrs["status"] == "budget spent"


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no device that is always full")
def test_a_full_disk_is_told_after_the_result(file):
    done = run("solve", file, "--out", "/dev/full", "--force")
    assert done.exit_code == 1
    assert "converged after" in done.output
    assert "Error: '/dev/full' could not be written: No space left on device. Make room, or give another" in done.output


def test_the_measure_of_published_solvers_is_kept(monkeypatch):
    """Where the first solve is too loose, and so not within tolerance in that measure, the solve goes on from there."""
    given = problem()
    solver = lm.GaussSeidel(tolerance=1e-6)
    monkeypatch.setitem(solve_to_measure.__globals__, "LOOSER", 100.0)
    of_nothing = lm.residual(given, np.zeros((24, 2)), measure="fclib")
    first = lm.solve(given, solver=replace(solver, tolerance=1e-4 / of_nothing))
    assert first.status == "converged"
    assert lm.residual(given, first.impulses, measure="fclib") > 1e-6
    solved = solve_to_measure(given, solver, measure="fclib")
    assert solved.status == "converged"
    assert lm.residual(given, solved.impulses, measure="fclib") == solved.error <= 1e-6
    assert solved.iterations > first.iterations


def test_distant_contacts_loosen_the_measure_of_published_solvers():
    """They enlarge |q|, by 1e4 here, and take part in nothing else: fewer digits are left to find, in fewer sweeps."""
    given = problem()
    count = len(given.mu)
    distant = sparse.csr_array(sparse.block_diag([given.W, sparse.eye_array(2)]))
    q = np.concatenate([given.q, [1e4 * np.linalg.norm(given.q), 0.0]])
    wider = lm.Problem(
        distant, q, np.full(count + 1, 0.4), 2, ("coulomb",) * (count + 1), np.zeros(count + 1), np.zeros((count + 1, 2))
    )
    solver = lm.GaussSeidel(tolerance=1e-8)
    near, far = (solve_to_measure(each, solver, measure="fclib") for each in (given, wider))
    assert near.status == far.status == "converged"
    assert max(near.error, far.error) <= 1e-8
    assert far.iterations < 0.7 * near.iterations  # sweeps converge linearly: half of eight digits are left


@pytest.fixture(scope="module")
def benched(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bench")
    (folder / "mine").mkdir()
    for seed in range(suites.size(1, long=3)):
        lm.io.fclib.write(problem(seed=seed), folder / "mine" / f"line-{seed}.h5")
    done = run("bench", folder / "mine", "--make", "none", "--out", folder / "out")
    return done, folder / "out"


@pytest.mark.long
@pytest.mark.long
def test_bench_of_a_folder(benched):
    done, out = benched
    assert done.exit_code == 0, done.output
    with (out / "runs.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {row["problem"] for row in rows} == {"line-0", "line-1", "line-2"}
    assert {row["solver"] for row in rows} == set(COLOURS)
    assert {row["family"] for row in rows} == {"mine"}
    for row in rows:
        assert int(row["updates"]) == 24 * int(row["sweeps"])
        assert float(row["seconds"]) > 0.0
    with (out / "references.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 3
    page = (out / "frontier.md").read_text()
    for word in ("line-0", "profiles.png", "work-mine.png", "numpy", "Load of the machine"):
        assert word in page


@pytest.mark.long
def test_interrupted_bench_writes_what_it_has(tmp_path, monkeypatch):
    """Ctrl-C while the third problem is judged: a report of two, and the exit code of an interrupted command."""
    from lmgcpy.bench import study

    judge, count = study.judge, [0]

    def interrupted(*arguments):
        count[0] += 1
        if count[0] == 3:
            raise KeyboardInterrupt
        return judge(*arguments)

    monkeypatch.setattr(study, "judge", interrupted)
    out = tmp_path / "out"
    done = run("bench", "--make", "chains", "--quick", "--solvers", "gauss-seidel", "--out", out)
    assert done.exit_code == 130
    assert "Interrupted: the report is of 2 problems." in done.output
    with (out / "references.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 2


@pytest.mark.long
def test_bench_draws_every_solver(benched):
    """Each solver's colour is in both pictures, in more points than a legend has."""
    from matplotlib.colors import to_rgb
    from matplotlib.image import imread

    _, out = benched
    for name in ("work-mine.png", "profiles.png"):
        pixels = imread(out / name)[..., :3]
        for colour in COLOURS.values():
            assert (np.abs(pixels - to_rgb(colour)).max(axis=-1) < 0.01).sum() > 200, (name, colour)


@pytest.mark.long
def test_quick_bench_of_what_is_made(tmp_path):
    done = run("bench", "--make", "chains,packings", "--quick", "--solvers", "gauss-seidel,auto", "--out", tmp_path / "out")
    assert done.exit_code == 0, done.output
    page = (tmp_path / "out" / "frontier.md").read_text()
    for word in ("hanging-100-tip-1e+06", "packing-100", "extended precision"):
        assert word in page
    again = run("bench", "--make", "chains", "--quick", "--out", tmp_path / "out")
    assert again.exit_code == 1
    assert "is not empty" in again.output


@pytest.mark.parametrize(
    "solver", [lm.GaussSeidel(), lm.AcceleratedGaussSeidel(), lm.Newton(), lm.Auto(max_factorisations=0)]
)
def test_kernels_are_loaded_by_a_sweep_and_a_newton_step(solver):
    """In space many Newton steps would take longer than what is asked for."""
    brief = briefly(solver)
    assert type(brief) is type(solver)
    assert brief.max_iterations == 1
    assert getattr(brief, "max_factorisations", 0) == min(1, getattr(solver, "max_factorisations", 0))
