"""Wrong input on the command line: a non-zero exit, one sentence on standard error, and a traceback only if asked for.

Rows are ``name: (command of the world w, words that the sentence holds ...)``; the world is that of ``test_bad_input.py``.
"""

from __future__ import annotations

import subprocess
import sys

import pytest
from bad_input.world import World
from click.testing import CliRunner

import lmgcpy as lm
from lmgcpy.cli import main
from lmgcpy.compiled.waiting import ONCE


@pytest.fixture
def w(tmp_path, monkeypatch):
    with World(tmp_path, monkeypatch) as world:
        yield world


def texsol(w, *options):
    """A study of few grains, kept from running by what is wrong."""
    return ["texsol", "--grains", "60", "--out", w.path("out"), *options]


def study(w, text):
    """A folder with the file of a study."""
    w.path("out").mkdir()
    (w.path("out") / "study.json").write_text(text)
    return ["texsol", "--resume", "--out", w.path("out")]


def column(w, *options):
    """Columns of few grains, kept from falling by what is wrong."""
    return ["column", "--grains", "60", "--out", w.path("out"), *options]


def no_display(w):
    """The machine has none from now on."""
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        w.patch.delenv(name, raising=False)


def bench(w, *options):
    """A comparison on problems of the user's alone."""
    return ["bench", "--make", "none", "--out", w.path("out"), *options]


# fmt: off
ROWS = {
    "no such command": (lambda w: ["texsoll"],
        "There is no command 'texsoll'; did you mean 'texsol'? Known: bench, campaign, column, compare"),
    "no such example": (lambda w: ["example", "pul-out"],
        "There is no example 'pul-out'; did you mean 'pull-out'? Known: again, angle-of-repose"),
    "all examples and one": (lambda w: ["example", "silo", "--all"], "--all runs every example: leave out the names."),
    "no such option before the command": (lambda w: ["--tracebak", "info", "x"],
        "No such option", "--tracebak", "--traceback"),
    "no such option": (lambda w: texsol(w, "--sed", "3"), "No such option", "--sed"),
    "no file named": (lambda w: ["info"], "Missing argument 'FILES...'."),
    "laws misspelt": (lambda w: texsol(w, "--laws", "rigid-wir"),
        "The study has no law 'rigid-wir'; did you mean 'rigid-wire'?"),
    "no laws": (lambda w: texsol(w, "--laws", ""), "laws must name each law once, got none"),
    "grains below zero": (lambda w: texsol(w, "--grains", "-5"), "grains must be at least 10, got -5"),
    "grains in words": (lambda w: texsol(w, "--grains", "many"), "'--grains': 'many' is not a valid integer"),
    "one bead": (lambda w: texsol(w, "--beads", "1"), "beads must be at least 2 for a wire, got 1"),
    "beads without room": (lambda w: texsol(w, "--beads", "5000"),
        "No place was found for a wire of 5000 beads among 60 grains"),
    "no strain": (lambda w: texsol(w, "--strain", "0"), "strain must be above 0, got 0"),
    "strain beyond all": (lambda w: texsol(w, "--strain", "120"), "strain must be at most 0.5, got 1.2"),
    "strain NaN": (lambda w: texsol(w, "--strain", "nan"), "strain must be finite, got nan"),
    "suction": (lambda w: texsol(w, "--pressure", "-1"), "pressure must be above 0 Pa, got -1000 Pa"),
    "pressure NaN": (lambda w: texsol(w, "--pressure", "nan"), "pressure must be finite, got nan"),
    "pressure infinite": (lambda w: texsol(w, "--pressure", "inf"), "pressure must be finite, got inf"),
    "no tolerance": (lambda w: texsol(w, "--tolerance", "0"), "tolerance must be above 0, got 0"),
    "too much tolerance": (lambda w: texsol(w, "--tolerance", "7"), "tolerance must be at most 1, got 7"),
    "no rigidity": (lambda w: texsol(w, "--axial-rigidity", "0"), "axial_rigidity must be above 0 N, got 0 N"),
    "friction below zero": (lambda w: texsol(w, "--platen-friction", "-1"),
        "platen_friction must be at least 0, got -1"),
    "no threads": (lambda w: texsol(w, "--threads", "0"), "threads must be at least 1, got 0"),
    "seed below zero": (lambda w: texsol(w, "--seed", "-3"), "seed must be at least 0, got -3"),
    "four dimensions": (lambda w: texsol(w, "--dimension", "4"), "'--dimension': '4' is not one of '2', '3'"),
    "rods in 3D": (lambda w: texsol(w, "--dimension", "3", "--laws", "rigid-rod"),
        "laws of the study in 3D cannot be 'rigid-rod'", "Take rigid-wire or elastic-wire."),
    "axes in 2D": (lambda w: texsol(w, "--axes", "x"), "A study in 2D has no --axes: add --dimension 3"),
    "node distance of beads": (lambda w: texsol(w, "--dimension", "3", "--node-distance", "0.5"),
        "node_distance is of a thread, and the wire of this study has beads", "--wire thread"),
    "thread diameter of beads": (lambda w: texsol(w, "--dimension", "3", "--thread-diameter", "0.1"),
        "thread_diameter is of a thread, and the wire of this study has beads"),
    "dtex of beads as heavy as grains": (lambda w: texsol(w, "--dimension", "3", "--dtex", "100"),
        "bead_mass of this study is 'grain'", "--bead-mass own"),
    "axes misspelt": (lambda w: texsol(w, "--dimension", "3", "--axes", "up"),
        "The study has no axis 'up'", "Known: x, y, z."),
    "out is a file": (lambda w: ["texsol", "--out", w.text()], "'--out': Directory '", "run.h5' is a file."),
    "out below a file": (lambda w: ["texsol", "--grains", "60", "--beads", "12", "--out", w.text() / "out"],
        "run.h5/out", "could not be made: Not a directory"),
    "out is not empty": (lambda w: ["texsol", "--out", w.text().parent],
        "is not empty: give another by --out, or --force to write there"),
    "nothing to resume": (lambda w: ["texsol", "--resume", "--out", w.path("out")],
        "There is no study to go on with in '", "study.json' is missing"),
    "resumed otherwise": (lambda w: texsol(w, "--resume"),
        "--resume takes the study as it is in '", "leave out --grains"),
    "study damaged": (lambda w: study(w, "{"), "study.json' is damaged"),
    "study of another version": (
        lambda w: study(w, '{"format": "lmgcpy texsol study", "study": {"laws": []}, "versions": {"lmgcpy": "0.0"}}'),
        "study.json' is of lmgcpy 0.0"),
    "column of few grains": (lambda w: column(w, "--grains", "5"), "grains must be at least 10, got 5"),
    "column of no content": (lambda w: column(w, "--contents", ","), "contents must name each content once, got none"),
    "column of contents in words": (lambda w: column(w, "--contents", "0.1,much"),
        "'--contents': '0.1,much' is not a list of numbers separated by commas, such as 0.1,0.4"),
    "column of one content twice": (lambda w: column(w, "--contents", "0.1,0.10"),
        "contents must name each content once, got 0.1, 0.1"),
    "column of next to no wire": (lambda w: column(w, "--contents", "0.001"),
        "A wire content of 0.001 is too little for a column of 60 grains"),
    "column with thick wire": (lambda w: column(w, "--bead", "0.5"), "bead_diameter must be at most 0.45, got 0.5"),
    "column of flat aspect": (lambda w: column(w, "--aspect", "0"), "aspect must be at least 0.1, got 0"),
    "column of no size": (lambda w: column(w, "--diameter", "0"), "diameter must be above 0 m"),
    "column in great steps": (lambda w: column(w, "--travel", "9"), "travel must be at most 4, got 9"),
    "column out is not empty": (lambda w: ["column", "--out", w.text().parent],
        "is not empty: give another by --out, or --force to write there"),
    "column with nothing to resume": (lambda w: ["column", "--resume", "--out", w.path("out")],
        "There is no study to go on with in '", "lmgcpy column --out"),
    "column resumed otherwise": (lambda w: column(w, "--resume"),
        "--resume takes the study as it is in '", "leave out --grains"),
    "column resumed in a study of another kind": (
        lambda w: ["column", *study(w, '{"format": "lmgcpy texsol study", "study": {}, "versions": {"lmgcpy": "0"}}')[1:]],
        "study.json' is of another kind of study, 'lmgcpy texsol study': give another folder"),
    "warmup of no law": (lambda w: ["warmup", "--laws", "coulom"], "There is no law 'coulom'; did you mean 'coulomb'?"),
    "info on nothing": (lambda w: ["info", w.path()], "There is no file '", "run.h5'."),
    "info on a folder": (lambda w: ["info", w.folder], "is a folder, not a run file"),
    "info on nothing in it": (lambda w: ["info", w.text(b"")], "is empty: no lmgcpy run"),
    "info on text": (lambda w: ["info", w.text()], "is no HDF5 file, hence no lmgcpy run"),
    "info on another program's": (lambda w: ["info", w.hdf5()], "is an HDF5 file, but no lmgcpy run"),
    "info on half a file": (lambda w: ["info", w.cut(0.5)], "is truncated: its end is missing"),
    "info on a file from the future": (lambda w: ["info", w.changed(format_version=99)],
        "is of format version 99", "install a newer lmgcpy"),
    "info on a file from before": (lambda w: ["info", w.changed(format_version=0)],
        "is of format version 0, older than"),
    "resume nothing": (lambda w: ["resume", w.path(), "--steps", "1"], "There is no file '"),
    "resume without steps": (lambda w: ["resume", w.run_file()], "Missing option '--steps'."),
    "resume steps in words": (lambda w: ["resume", w.run_file(), "--steps", "some"],
        "'--steps': 'some' is not a valid integer"),
    "resume steps back": (lambda w: ["resume", w.plain_run_file(), "--steps", "-1"],
        "steps must be at least 0, got -1"),
    "resume what has functions": (lambda w: ["resume", w.run_file(), "--steps", "1"],
        "Functions of time, which no file can hold, gave the force along 'x'", "lmgcpy.resume(path, functions="),
    "resume what is busy": (lambda w: w.lock() or ["resume", w.path(), "--steps", "1"],
        "is being written by another run: wait for its end"),
    "resume what is read-only": (lambda w: ["resume", w.read_only(w.plain_run_file()), "--steps", "1"],
        "is read-only: change its permissions, or copy it"),
    "resume with another step in its file": (
        lambda w: ["resume", w.plain_run_file(), "--steps", "1", "--time-step", "1e-4"],
        "--time-step needs another file, as a file holds one time step: give --record FILE."),
    "resume into a file that is there": (
        lambda w: ["resume", w.plain_run_file(), "--steps", "1", "--record", w.text()], "exists: give another name."),
    "resume onto a full disk": (lambda w: ["resume", w.full_disk(w.plain_run_file()), "--steps", "1"],
        "could not be written on: 1000 bytes are left", "make room"),
    "compare with nothing": (lambda w: ["compare", w.run_file(), w.path("b.h5")], "There is no file '", "b.h5'."),
    "compare one": (lambda w: ["compare", w.run_file()], "Missing argument 'B'."),
    "compare to NaN": (lambda w: ["compare", w.run_file(), w.path(), "--tolerance", "nan"],
        "tolerance must be finite, got nan"),
    "compare to less than nothing": (lambda w: ["compare", w.run_file(), w.path(), "--tolerance", "-1"],
        "tolerance must be at least 0, got -1"),
    "export to nowhere": (lambda w: ["export", w.run_file()], "Say where to export to: --csv FOLDER, --vtk FOLDER, or"),
    "export to ParaView into a full folder": (lambda w: ["export", w.run_file(), "--vtk", w.folder],
        "is not empty: give another, or force (--force)"),
    "render nothing": (lambda w: ["render"], "Missing argument 'FILES...'."),
    "render what is not there": (lambda w: ["render", w.path()], "There is no file '"),
    "render what is unknown": (lambda w: ["render", w.run_file(), "--what", "grain"],
        "what cannot be 'grain'; did you mean 'grains'?"),
    "render no such frame": (lambda w: ["render", w.run_file(), "--frame", "7"], "has 2 frames, 0 to 1, got frame 7."),
    "render into no picture": (lambda w: ["render", w.run_file(), "--out", w.path("a.bmp")],
        "must end in .png, .pdf, .svg or, for a moving picture, in .gif or .mp4"),
    "render from half a direction": (lambda w: ["render", w.run_file(), "--camera", "1,2"],
        "'--camera': '1,2' is not 3 numbers separated by commas, such as 1,-1,1"),
    "render on half a scale": (lambda w: ["render", w.run_file(), "--limits", "1"],
        "'--limits': '1' is not 2 numbers separated by commas, such as 0,1.5"),
    "render at no plane": (lambda w: ["render", w.run_file(), "--section", "y=middle"],
        "'--section': 'y=middle' is no plane such as y or y=0.1"),
    "render a plane in space of the plane": (lambda w: ["render", w.run_file(), "--section", "y"], "section is for 3D"),
    "render panels that do not match": (
        lambda w: ["render", w.run_file(), "--frame", "0", "--frame", "1", *["--camera", "x"] * 3],
        "frame has 2, camera has 3"),
    "view without a display": (lambda w: no_display(w) or ["view", w.run_file()],
        "There is no display to open a window on"),
    "plot nothing": (lambda w: ["plot"], "Missing argument 'FILES...'."),
    "plot what is unknown": (lambda w: ["plot", w.run_file(), "--what", "strain"],
        "what cannot be 'strain'", "Known: deviator, energy"),
    "plot a reaction without a wall": (lambda w: ["plot", w.run_file(), "--out", w.path("a.png")], "has no wall"),
    "plot into no picture": (lambda w: ["plot", w.run_file(), "--out", w.path("a.bmp")],
        "path must end in .png, .svg, .pdf"),
    "solve nothing": (lambda w: ["solve", w.path()], "There is no file '", "run.h5'."),
    "solve a folder": (lambda w: ["solve", w.folder], "is a folder, not a file of a problem"),
    "solve text": (lambda w: ["solve", w.text()], "is no HDF5 file, or is damaged"),
    "solve a run": (lambda w: ["solve", w.run_file()], "is no FCLIB problem: "),
    "solve by nobody": (lambda w: ["solve", w.problem_file(), "--solver", "newtn"],
        "solver cannot be 'newtn'; did you mean 'newton'? Known: accelerated, auto, gauss-seidel, newton."),
    "solve in no measure": (lambda w: ["solve", w.problem_file(), "--measure", "natral"],
        "measure cannot be 'natral'; did you mean 'natural'?"),
    "solve to nothing": (lambda w: ["solve", w.problem_file(), "--tolerance", "0"], "tolerance must be above 0, got 0"),
    "solve to NaN": (lambda w: ["solve", w.problem_file(), "--tolerance", "nan"], "tolerance must be finite, got nan"),
    "solve to anything": (lambda w: ["solve", w.problem_file(), "--tolerance", "2"], "tolerance must be at most 1, got 2"),
    "solve without a sweep": (lambda w: ["solve", w.problem_file(), "--max-iterations", "0"],
        "max_iterations must be at least 1, got 0"),
    "solve sweeps in words": (lambda w: ["solve", w.problem_file(), "--max-iterations", "many"],
        "'--max-iterations': 'many' is not a valid integer"),
    "solve onto a file": (lambda w: ["solve", w.problem_file(), "--out", w.text()],
        "exists: give another by --out, or --force to replace it"),
    "solve onto a folder": (lambda w: ["solve", w.problem_file(), "--out", w.folder],
        "is a folder: give the name of a file"),
    "solve into no folder": (lambda w: ["solve", w.problem_file(), "--out", w.path("no") / "s.h5"],
        "There is no folder '", "make it first"),
    "bench to nowhere": (lambda w: ["bench"], "Missing option '--out'."),
    "bench of no folder": (lambda w: bench(w, w.path("no")), "There is no folder '", "no' with problems to solve"),
    "bench of a folder without problems": (lambda w: bench(w, (w.path("empty").mkdir(), w.path("empty"))[1]),
        "There is no problem in the folder '", "no file ends in .h5 or .hdf5"),
    "bench of what is no problem": (lambda w: bench(w, w.text().parent), "is no HDF5 file, or is damaged"),
    "bench of nothing": (lambda w: bench(w), "There is nothing to solve: name a folder with problems, or families"),
    "bench of no family": (lambda w: ["bench", "--make", "chain", "--out", w.path("out")],
        "families cannot be 'chain'; did you mean 'chains'? Known: 2d, 3d, chains, packings."),
    "bench of a family twice": (lambda w: ["bench", "--make", "2d,2d", "--out", w.path("out")],
        "families must name each once, got 2d, 2d."),
    "bench by nobody": (lambda w: bench(w, w.folder, "--solvers", "autoo"),
        "solvers cannot be 'autoo'; did you mean 'auto'?"),
    "bench by none": (lambda w: bench(w, w.folder, "--solvers", ","), "solvers must name one at least"),
    "bench of spheres in words": (lambda w: bench(w, w.folder, "--spheres", "1e3"),
        "'--spheres': '1e3' is not a list of whole numbers separated by commas, such as 1000,10000"),
    "bench of few spheres": (lambda w: bench(w, w.folder, "--spheres", "3"),
        "spheres of a packing must be at least 10, got 3"),
    "bench into what is not empty": (lambda w: ["bench", "--out", w.text().parent],
        "is not empty: give another by --out, or --force to write there"),
    "bench onto a file": (lambda w: ["bench", "--out", w.text()], "'--out': Directory '", "run.h5' is a file."),
    "export into a file": (lambda w: ["export", w.run_file(), "--csv", w.path()],
        "is a file: give the name of a folder"),
    "export into a full folder": (lambda w: ["export", w.run_file(), "--csv", w.folder],
        "is not empty: give another, or force (--force)"),
}
# fmt: on
CLICKS = (
    "Say where",
    "Missing",
    "No such option",
    "leave out the names",
    "needs another file",
    "There is no command",
    "'--",
    "is not empty: give another by",
    "--resume takes",
)
"""Beginnings and parts of sentences about the command line itself, to which a traceback has nothing to add."""


def command(row, w):
    return [str(word) for word in ROWS[row][0](w)]


def assert_sentence(output, words):
    *stages, told = output.splitlines()
    assert told.startswith("Error: ")
    assert all(line.startswith("sample: ") for line in stages)  # what was done before
    for word in words:
        assert word in told, told
    assert told[-1] in ".?)", told
    assert len(told) <= 500, told
    assert "Traceback" not in told
    assert "[Errno" not in told


SLOW = {"beads without room"}
"""Rows of work that fails late."""


@pytest.mark.parametrize("row", [pytest.param(row, marks=[pytest.mark.long] * (row in SLOW)) for row in ROWS])
def test_a_mistake_gets_one_sentence(row, w):
    done = CliRunner().invoke(main, command(row, w))
    assert done.exit_code != 0
    assert_sentence(done.output, ROWS[row][1:])
    assert not any(path.name in ("summary.md", "study.new") for path in w.folder.rglob("*"))


@pytest.mark.default_parameters(
    "laws misspelt", "info on text", "resume what has functions", "resume onto a full disk", "render what is unknown"
)
@pytest.mark.parametrize("row", [row for row in ROWS if not any(part in ROWS[row][1] for part in CLICKS)])
def test_the_exception_itself_comes_if_it_is_asked_for(row, w):
    done = CliRunner().invoke(main, ["--traceback", *command(row, w)])
    assert done.exit_code == 1
    assert isinstance(done.exception, (ValueError, TypeError, LookupError, OSError))
    assert type(done.exception).__module__ == "builtins"


def process(*words):
    return subprocess.run([sys.executable, "-m", "lmgcpy.cli", *map(str, words)], capture_output=True, text=True)


@pytest.mark.default_parameters("laws misspelt")
@pytest.mark.parametrize("row", ["laws misspelt", "info on text", "no such option", "resume what has functions"])
def test_in_a_process_of_its_own(row, w):
    done = process(*command(row, w))
    assert done.returncode != 0
    assert done.stdout == ""
    assert_sentence(done.stderr, ROWS[row][1:])


@pytest.mark.long
def test_the_traceback_of_a_process(w):
    done = process("--traceback", "info", w.text())
    assert done.returncode == 1
    assert done.stderr.startswith("Traceback (most recent call last):")
    assert done.stderr.splitlines()[-1].startswith("ValueError: '")


def test_what_nobody_foresaw_is_an_error_of_lmgcpy(monkeypatch):
    """Still one sentence, and one that asks for a report."""
    monkeypatch.setattr(lm.io.run, "open_run", lambda path: {}["name"])
    told = CliRunner().invoke(main, ["info", "x"]).output
    assert_sentence(told, ["This is an error of lmgcpy: KeyError('name')", "--traceback"])


@pytest.mark.long
def test_a_warning_is_a_sentence_too(w):
    """Not converged steps, told without the line of the program."""
    done = process("resume", w.unsolved_run_file(), "--steps", "1")
    assert done.returncode == 0
    lines = [line for line in done.stderr.splitlines() if line != ONCE]
    assert lines[0].startswith("Warning: 1 of 1 steps did not reach the solver's tolerance")
    assert len(lines) == 1
