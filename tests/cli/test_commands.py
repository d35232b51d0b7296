"""The command line: what it writes. Wrong input is in ``test_bad_command_line.py``."""

import textwrap
from importlib.util import find_spec

import pytest
from click.testing import CliRunner
from forks import forked

import lmgcpy
from lmgcpy.cli import main
from lmgcpy.compiled.waiting import ONCE

TINY = ["texsol", "--grains", "60", "--beads", "12", "--strain", "0.5", "--laws", "none,rigid-wire", "--threads", "1"]


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def test_version_and_help():
    assert lmgcpy.__version__ in run("--version").output
    told = run("texsol", "--help").output
    for option in ("grains", "beads", "seed", "strain", "pressure", "tolerance", "quick", "out", "force", "resume", "laws"):
        assert f"--{option}" in told


@pytest.mark.long
def test_texsol_writes_and_does_not_overwrite(tmp_path):
    out = tmp_path / "study"
    first = run(*TINY, "--out", out)
    assert first.exit_code == 0, first.output
    summary = (out / "summary.md").read_text()
    pictures = ["sample.png", "chains-rigid-wire.png"] if find_spec("pyvista") else []
    for name in ["reaction.csv", "reaction.png", "stress.csv", "stress.png", *pictures]:
        assert (out / name).stat().st_size > 100
    assert ("There are no pictures of the sample" in summary) == (not pictures)
    assert "Does the wire stiffen" in summary
    again = run(*TINY, "--out", out)
    assert again.exit_code != 0
    assert "is not empty" in again.output
    assert run(*TINY, "--out", out, "--force", "--laws", "none").exit_code == 0


@pytest.mark.long
def test_one_line_a_stage_where_there_is_no_terminal(tmp_path):
    command = f"""
        import sys
        sys.modules["pyvista"] = None  # pictures of the sample take longer than its test
        from lmgcpy.cli import main
        main({[*TINY, "--out", str(tmp_path / "o")]!r})
    """
    told = forked(textwrap.dedent(command), strict=False).stderr.splitlines()
    lines = [line for line in told if line != ONCE]
    assert [line.split(":")[0] for line in lines[:2]] == ["sample", "relaxation to the pressure"]
    # a relaxation, then for each law the test and its check at a tighter tolerance
    assert len(lines) == 2 + 2 * 2


def test_info_counts_all_functions_of_time(tmp_path):
    """Of a body, of a chain, of a pressure, of forces on many bodies, and of gravity."""
    scene = lmgcpy.Scene(dimension=2, gravity=lambda time: (0.0, -time))
    nodes = [scene.add(lmgcpy.point_mass(position=place, mass=1.0)) for place in [(0, 0), (1, 0), (0.5, 1)]]
    chain = scene.chain(nodes, lmgcpy.RigidWire(), closed=True, surface=lmgcpy.Thread(0.01))
    chain.skin.impose_pressure(lambda time: time)
    chain.reference_gap = lambda time: chain.start_gaps
    scene.impose_forces(nodes, lambda time: (time, 0.0))
    nodes[0].impose_force(x=lambda time: time)
    lmgcpy.Simulation(scene, time_step=1e-3).run(steps=1, record=tmp_path / "run.h5")
    answer = CliRunner().invoke(main, ["info", str(tmp_path / "run.h5")])
    assert answer.exit_code == 0
    assert "functions 5 conditions are functions of time" in answer.output
