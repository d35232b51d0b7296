"""The command line: what it writes, and that wrong input gets a sentence and a non-zero exit, never a traceback."""

import subprocess
import sys

import pytest
from click.testing import CliRunner

import lmgcpy
from lmgcpy.cli import main

TINY = ["texsol", "--grains", "60", "--beads", "12", "--strain", "0.5", "--laws", "none,rigid-wire", "--threads", "1"]


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_version_and_help():
    assert lmgcpy.__version__ in run("--version").output
    told = run("texsol", "--help").output
    for option in ("grains", "beads", "seed", "strain", "pressure", "tolerance", "quick", "out", "force", "laws"):
        assert f"--{option}" in told


def test_texsol_writes_and_does_not_overwrite(tmp_path):
    out = tmp_path / "study"
    first = run(*TINY, "--out", out)
    assert first.exit_code == 0, first.output
    for name in ("reaction.csv", "reaction.png", "stress.csv", "stress.png", "sample.png", "chains-rigid-wire.png"):
        assert (out / name).stat().st_size > 100
    assert "By how much the wire stiffens" in (out / "summary.md").read_text()
    again = run(*TINY, "--out", out)
    assert again.exit_code != 0
    assert "is not empty" in again.output
    assert run(*TINY, "--out", out, "--force").exit_code == 0


def test_one_line_a_stage_where_there_is_no_terminal(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "lmgcpy.cli", *TINY, "--out", str(tmp_path / "o")], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stderr
    lines = done.stderr.splitlines()
    assert [line.split(":")[0] for line in lines[:2]] == ["sample", "relaxation to the pressure"]
    # a relaxation, then for each law the test and its check at a tighter tolerance
    assert len(lines) == 2 + 2 * 2


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--laws", "rigid-wir"], "did you mean 'rigid-wire'"),
        (["--laws", ""], "laws must name each law once"),
        (["--grains", "-5"], "grains must be at least 10"),
        (["--grains", "many"], "not a valid integer"),
        (["--beads", "1"], "beads must be at least 2"),
        (["--beads", "5000"], "No place was found"),
        (["--strain", "0"], "strain must be above 0"),
        (["--strain", "120"], "strain must be at most"),
        (["--pressure", "-1"], "pressure must be above 0"),
        (["--pressure", "nan"], "pressure must be finite"),
        (["--tolerance", "0"], "tolerance must be above 0"),
        (["--tolerance", "7"], "tolerance must be at most 1"),
        (["--axial-rigidity", "0"], "axial_rigidity must be above 0"),
        (["--threads", "0"], "threads must be at least 1"),
        (["--seed", "-3"], "seed must be at least 0"),
        (["--sed", "3"], "No such option"),
    ],
)
def test_wrong_input_gets_a_sentence(arguments, sentence, tmp_path):
    result = run("texsol", "--grains", "60", "--out", tmp_path / "out", *arguments)
    assert result.exit_code != 0
    assert sentence in result.output
    assert "Traceback" not in result.output
    assert not (tmp_path / "out").exists()


def test_unknown_command_is_refused():
    assert run("texsoll").exit_code != 0
