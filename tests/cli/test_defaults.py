"""What the help says of a default is what the study has, in its own unit."""

from __future__ import annotations

import pytest
from click.testing import CliRunner

from lmgcpy.cli import main
from lmgcpy.cli.column import new_study as new_column
from lmgcpy.cli.options import OfStudy
from lmgcpy.cli.texsol import ONLY_3D
from lmgcpy.cli.texsol import new_study as new_texsol


def told(command):
    """Defaults in the help of a command, by option."""
    lines = CliRunner().invoke(main, [command, "--help"], terminal_width=400).output.splitlines()
    rows = [line.split("[default: (") for line in lines if "[default: (" in line]
    return {row[0].split()[0].removeprefix("--"): row[1].rstrip(")]") for row in rows}


def as_given(option, words):
    """An option's words as the command would give them on."""
    if option in ("laws", "axes"):
        return tuple(words.split(","))
    if option in ("preparation", "solver", "bead-mass", "wire"):
        return words
    if option == "contents":
        return tuple(map(float, words.split(",")))
    return float(words) if "." in words or "e" in words else int(words)


@pytest.mark.parametrize("dimension", [2, 3])
def test_options_of_texsol(dimension):
    """The tolerance in 3D was told as that in 2D."""
    defaults = told("texsol")
    assert defaults["tolerance"] == "0.003; 3D: 0.01"
    given = {}
    for option, words in defaults.items():
        if option == "out" or (dimension == 2 and option.replace("-", "_") in ONLY_3D):
            continue
        words = words.split("; 3D: ")
        given[option.replace("-", "_")] = as_given(option, words[-1 if dimension == 3 else 0])
    assert len(given) >= 10
    assert new_texsol(dimension, given, False) == new_texsol(dimension, {}, False)


def test_options_of_column():
    given = {option.replace("-", "_"): as_given(option, words) for option, words in told("column").items()}
    assert {"contents", "grains", "diameter", "travel"} < given.keys()
    assert new_column(given, False) == new_column({}, False)


@pytest.mark.parametrize("name", ["texsol", "column"])
def test_no_default_is_written_twice(name):
    command = main.get_command(None, name)
    for option in command.params:
        assert isinstance(option, OfStudy) or not isinstance(option.show_default, str) or option.name == "out"
