"""The 3D study's conclusions, each on made-up records whose answer is known, and one small study from end to end."""

import csv
import json
import re
import subprocess
import sys
import warnings
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import lmgcpy as lm
from lmgcpy.cli import main
from lmgcpy.experiment.study.engine import carry_out_study
from lmgcpy.experiment.study.folder import StudyFolder
from lmgcpy.experiment.texsol.conclusions import (
    at,
    boundary_mismatch,
    cohesion,
    friction_angle,
    gains,
    late,
    layer_parts,
    peak,
    principal_axes,
)
from lmgcpy.experiment.texsol.report_3d import summary
from lmgcpy.experiment.texsol.study import Study3D, TexSolStudy
from lmgcpy.experiment.triaxial import TriaxialRecord

STRAIN = np.linspace(0.0002, 0.1, 500)
OPTIONS = {"dimension": 3, "laws": "none,rigid-wire", "grains": 30, "beads": 24, "strain": 0.4, "tolerance": 0.01}
TINY = ["texsol", *(str(word) for name, value in OPTIONS.items() for word in (f"--{name}", value))]
RUNS = ("compaction", "none-z", "none-x", "rigid-wire-z", "rigid-wire-x")


def record(deviator, law="rigid-wire", axis="z", lateral=1e5, wire=(0.0, 0.0, 0.0)):
    """A test whose wire bears the same all along."""
    deviator = np.asarray(deviator, dtype=float)
    zeros = np.zeros_like(deviator)
    sides = np.full((len(deviator), 2), lateral)
    sigma = np.zeros((len(deviator), 3, 3))
    return TriaxialRecord(
        law=law,
        tolerance=1e-2,
        inertial_number=2e-3,
        strain=STRAIN[: len(deviator)],
        reaction=deviator,
        top_force=deviator,
        size=np.ones((len(deviator), 3)),
        stress={"total": sigma, "sand": sigma, "wire": sigma + np.diag(wire)},
        residual=zeros,
        iterations=zeros,
        interactions=zeros,
        kinetic=zeros,
        stored=zeros,
        defect=zeros,
        status=["converged"] * len(deviator),
        axis=axis,
        axial=deviator + lateral,
        lateral=sides,
        volume_change=zeros,
        coordination=zeros,
        fabric=sigma,
        penetration=zeros,
    )


def test_friction_angle_is_that_of_mohr_and_coulomb():
    """Of 30 degrees, s1/s3 = (1 + sin)/(1 - sin) = 3: q = 2 s3, p = 5/3 s3."""
    assert friction_angle(2.0, 5.0 / 3.0) == pytest.approx(30.0)
    assert friction_angle(0.0, 1.0) == 0.0


def test_cohesion_is_what_mohr_and_coulomb_say():
    """At an angle phi and a lateral pressure s3, q = 2 (s3 sin + c cos)/(1 - sin)."""
    phi, c, lateral = np.radians(25.0), 1.7e4, 1e5

    def bears(c):
        return np.full(500, 2.0 * (lateral * np.sin(phi) + c * np.cos(phi)) / (1.0 - np.sin(phi)))

    assert cohesion(record(bears(c)), record(bears(0.0), "none")) == pytest.approx(c, rel=1e-9)


def test_gains_are_ratios_of_deviators_as_far_as_both_went():
    found = gains(record(np.full(500, 3e5)), record(np.full(300, 2e5), "none"), [0.01, 0.05, 0.1])
    assert found == [(0.01, pytest.approx(1.5)), (0.05, pytest.approx(1.5))]


def test_peak_and_late():
    hill = record(np.where(np.abs(STRAIN - 0.03) < 0.01, 2e5, 1e5))
    strain, q, phi = peak(hill)
    assert strain == pytest.approx(0.03, abs=0.006)
    assert q == pytest.approx(2e5)
    assert phi == pytest.approx(30.0)  # of q twice the lateral pressure
    assert late(hill, hill.deviator) == pytest.approx(1e5)
    assert at(hill, hill.deviator, 0.07) == pytest.approx(1e5)


def test_layer_parts():
    within, across = layer_parts(record(np.ones(500), wire=(3.0, 5.0, 1.0)))
    np.testing.assert_array_equal((within[0], across[0]), (4.0, 1.0))


def test_principal_axes_of_a_turned_stress():
    """Turned by 20 degrees about y: the directions are the turned axes, up to their sign, greatest value first."""
    turn = np.array([[np.cos(0.35), 0.0, np.sin(0.35)], [0.0, 1.0, 0.0], [-np.sin(0.35), 0.0, np.cos(0.35)]])
    sigma = turn @ np.diag([2.0, -1.0, 5.0]) @ turn.T
    skew = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 0.0]])  # does not count
    values, directions = principal_axes(np.stack([sigma, sigma + skew]))
    for k in range(2):
        np.testing.assert_allclose(values[k], [5.0, 2.0, -1.0], atol=1e-12)
        np.testing.assert_allclose(directions[k], [turn[:, 2], turn[:, 0], turn[:, 1]], atol=1e-12)


pytestmark = pytest.mark.filterwarnings("ignore:In the step.*moves by")  # pressed together, light nodes move fast


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """The folder of a study by the command line that was not interrupted, without pictures."""
    out = tmp_path_factory.mktemp("whole") / "study"
    with pytest.MonkeyPatch.context() as patch, warnings.catch_warnings():
        warnings.filterwarnings("ignore", "In the step.*moves by")
        patch.setitem(sys.modules, "pyvista", None)  # importing it fails
        done = run(*TINY, "--out", out)
    assert done.exit_code == 0, done.output
    return out


def test_the_study_writes_what_it_promises(whole):
    written = {path.name for path in whole.iterdir()}
    tables = {"triaxial.csv", "stress.csv", "deviator.png", "stress.png", "layers.png", "summary.md"}
    assert written == {*tables, "study.json", "runs"}
    assert {path.name for path in (whole / "runs").glob("*.h5")} == {f"{name}.h5" for name in RUNS}
    with (whole / "triaxial.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert {(row["law"], row["axis"]) for row in rows} == {(a, b) for a in ("none", "rigid-wire") for b in "zx"}
    for row in rows:
        parts = [float(row[f"{name} pressure [Pa]"]) for name in ("axial", "lateral")]
        assert float(row["deviator [Pa]"]) == pytest.approx(parts[0] - parts[1], rel=1e-4, abs=1.0)
    with (whole / "stress.csv").open() as file:
        for row in csv.DictReader(file):
            direction = [float(row[f"total smallest along {axis}"]) for axis in "xyz"]
            assert np.linalg.norm(direction) == pytest.approx(1.0, abs=1e-3)


def test_the_summary_answers_the_questions_and_says_why_there_are_no_pictures(whole):
    text = (whole / "summary.md").read_text()
    for heading in ("The sand", "strengthen the sand?", "anisotropic", "Principal stresses", "The runs"):
        assert heading in text
    assert "km/m³" in text
    assert "nan" not in text.lower()
    assert 'There are no pictures of the sample, as pyvista is not installed: pip install "lmgcpy[view]"' in text


@pytest.mark.long
def test_with_pyvista_the_same_study_has_its_pictures(whole, tmp_path, monkeypatch):
    pytest.importorskip("pyvista")
    monkeypatch.setattr(lm.view, "render", partial(lm.view.render, size=(200, 200)))
    out = tmp_path / "study"
    out.mkdir()
    (out / "runs").mkdir()
    (out / "study.json").write_text((whole / "study.json").read_text())
    for file in (whole / "runs").iterdir():
        (out / "runs" / file.name).write_bytes(file.read_bytes())
    done = run("texsol", "--resume", "--out", out)
    assert done.exit_code == 0, done.output
    for name in ("wire.png", "sample.png", "chains-z.png", "chains-x.png"):
        assert (out / name).stat().st_size > 1000
    assert "no pictures" not in (out / "summary.md").read_text()


@pytest.mark.long
def test_interrupted_and_killed_it_is_the_same_study(whole, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    out = tmp_path / "study"
    script = Path(__file__).parents[1] / "stop_study.py"

    def stopped(signal, name, step, *arguments):
        command = [sys.executable, script, signal, name, str(step), *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True, timeout=100)

    first = stopped("SIGKILL", "compaction", 30, *TINY, "--out", out)
    assert first.returncode == -9, first.stderr
    second = stopped("SIGINT", "rigid-wire-x", 4, "texsol", "--resume", "--out", out)
    assert second.returncode == 130, second.stderr
    assert not (out / "summary.md").exists()
    done = run("texsol", "--resume", "--out", out, "--threads", 1)
    assert done.exit_code == 0, done.output
    for name in ("triaxial.csv", "stress.csv"):
        assert (out / name).read_text() == (whole / name).read_text()
    for name in RUNS:
        with lm.io.open_run(out / "runs" / f"{name}.h5") as a, lm.io.open_run(whole / "runs" / f"{name}.h5") as b:
            assert lm.io.compare(a, b) is None, name


def test_a_folder_knows_its_dimension(whole, tmp_path):
    study = StudyFolder(whole, TexSolStudy).read()
    assert isinstance(study, Study3D)
    assert study.axes == ("z", "x")
    about = json.loads((whole / "study.json").read_text())
    assert about["dimension"] == 3
    folder = StudyFolder(tmp_path, TexSolStudy)
    folder.study_file.write_text(json.dumps({**about, "dimension": 4}))
    with pytest.raises(ValueError, match=r"study.json' is damaged"):
        folder.read()


@pytest.mark.long
@pytest.mark.default_parameters("elastic-wire")
@pytest.mark.parametrize("law", ["elastic-wire", "rigid-wire"])
def test_a_study_with_a_smooth_thread(law, monkeypatch):
    """The thread pulls and bears no push, its nodes have the mass of their part of 167 dtex; the sand alone has none."""
    few = {"grain_count": 40, "strain": 0.02, "axes": ("z",), "threads": 1, "wire_friction": (0.3, 0.2)}
    study = Study3D(laws=("none", law), bead_count=40, wire="thread", **few)
    result = carry_out_study(study)
    sample = result.sample
    assert sample.thread
    for name, record in result.records.items():
        wire = np.trace(record.stress["wire"], axis1=1, axis2=2)
        assert (wire >= 0.0).all()
        assert (wire.max() > 0.0) == (record.law == law), name
    nodes = study.test(sample, study.planned[-1]).box.particles[: sample.bead_count]
    assert sum(node.mass for node in nodes) == pytest.approx(167e-7 * sample.wire_length)
    assert study.test(sample, study.planned[0]).box.bead_count == 0


def test_a_study_of_sand_alone_and_one_of_elastic_wire_alone(tmp_path, monkeypatch):
    """Conclusions that need both are left out."""
    monkeypatch.setitem(sys.modules, "pyvista", None)
    few = {"grain_count": 30, "strain": 0.002, "tolerance": 0.01, "check_strain": 0.0, "axes": ("y",)}
    sand = carry_out_study(Study3D(laws=("none",), bead_count=0, **few))
    text = summary(sand)
    assert "without wire" in text
    assert "strengthens" not in text
    folder = StudyFolder(tmp_path / "study", TexSolStudy)
    study = Study3D(laws=("elastic-wire",), bead_count=24, wires=2, **few)
    wire = carry_out_study(study, folder=folder)
    assert wire.sample.wires == (12, 12)
    study.report(wire, folder)
    text = (folder.path / "summary.md").read_text()
    assert "2 wires" in text
    assert "strengthens" not in text
    assert re.search(r"\| elastic-wire \| y \|", text)
    assert "nan" not in text.lower()
    for record in wire.records.values():
        assert boundary_mismatch(record) < 0.5
