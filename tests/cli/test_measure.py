"""``lmgcpy measure``: what it prints of runs whose numbers are known, what it writes, and sentences for what cannot be."""

import csv
import itertools

import numpy as np
import pytest
from click.testing import CliRunner

import lmgcpy as lm
from lmgcpy.cli import main
from lmgcpy.cli.measure_report import with_error


def pressed(path, dimension, wire=True):
    """A square or cubic lattice of three bodies along each axis between walls a unit apart, pressed by 10 Pa along x and
    20 Pa along the last axis, in 5 steps; the wire is the row in its middle, slack by a tenth of its reference."""
    scene = lm.Scene(dimension=dimension)
    radius = 1.0 / 6.0
    shape = lm.disk if dimension == 2 else lm.sphere
    places = radius * (1.0 + 2.0 * np.array(list(itertools.product(range(3), repeat=dimension))))
    bodies = [scene.add(shape(radius=radius, position=p, mass=1.0)) for p in places]
    for k in range(dimension):
        scene.add(lm.wall(point=np.zeros(dimension), normal=np.eye(dimension)[k]))
        lid = scene.add(lm.wall(point=np.eye(dimension)[k], normal=-np.eye(dimension)[k], mass=1.0))
        lid.impose_force(**{"xyz"[k]: -20.0 if k == dimension - 1 else -10.0})
    for color in ("GRAIN", "WALL"):
        scene.see("GRAIN", color, lm.Signorini())
    if wire:
        middle = [body for body, p in zip(bodies, places, strict=True) if np.allclose(p[1:], 0.5)]
        scene.chain(middle, lm.RigidWire(), reference_gap=2.0 * radius / 9.0)
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-10))
    sim.run(steps=5, record=path, every=1)
    return path


@pytest.fixture(scope="module", params=[2, 3])
def file(request, tmp_path_factory):
    return pressed(tmp_path_factory.mktemp("pressed") / "run.h5", request.param)


def run(*arguments):
    return CliRunner().invoke(main, ["measure", *map(str, arguments)])


def told(*arguments):
    """The numbers of the lines, by label; the first of lines with the same label."""
    done = run(*arguments)
    assert done.exit_code == 0, done.output
    found = {}
    for line in done.output.splitlines():
        label, _, number = line.strip().partition("   ")
        found.setdefault(label.strip(), number.strip())
    return found


@pytest.mark.default_parameters("2")
def test_numbers_of_a_lattice_that_is_pressed(file):
    """Stress 10 and 20 Pa; each body has 2 d contacts; nothing moves; two slack links of 1/3 m in a unit box."""
    lines = told(file)
    with lm.io.open_run(file) as opened:
        d = opened.dimension
    assert lines["beads, which belong to chains"] == "3"
    assert lines["grains, which belong to no chain"] == str(3**d - 3)
    assert lines["stress along x, traction positive"].split() == ["-10", "Pa"]
    assert lines[f"stress along {'xyz'[d - 1]}, traction positive"].split() == ["-20", "Pa"]
    assert lines["contacts of a body, without rattlers"] == str(2 * d)
    assert lines["contacts of a body, with rattlers"] == str(2 * d)
    assert float(lines["share of the grains that are rattlers: fewer than two contacts"].split()[0]) == 0.0
    assert lines["links"] == "2"
    assert lines["length of all wires"].split() == ["0.6667", "m"]
    assert lines["length of wire per volume"].split() == ["0.6667", "1/m" if d == 2 else "1/m^2"]
    assert lines["share of the wire that is taut"].split() == ["0", "%"]
    assert lines["mean slack of the links that do not pull, a strain"] == "0.1"
    assert abs(float(lines["strain along x, fitted to all bodies"].split()[0])) < 1e-6
    assert "Wire by direction" in lines
    assert ("In 2D forces, masses and volumes are those of one metre of depth." in lines) == (d == 2)


@pytest.mark.default_parameters("3")
def test_tables_are_what_the_measures_give(file, tmp_path):
    out = tmp_path / "out"
    done = run(file, "--out", out, "--frame", "3", "--since", "1", "--axis", "x")
    assert done.exit_code == 0, done.output
    names = {path.stem for path in out.iterdir()}
    assert names == {
        *("summary", "contact-forces", "contacts", "contact-kinds", "links", "tension-by-direction", "beads"),
        "forces-along",
        *("tension-correlation", "taut-runs", "stretch-of-1-links", "stretch-of-10-links", "slip"),
    }
    assert all(f"{out / name}.csv" in done.output for name in names)
    with open(out / "links.csv", newline="") as text:
        rows = list(csv.DictReader(text))
    with lm.io.open_run(file) as opened:
        links = lm.measure.wire_links(opened, frame=3)
        forces = lm.measure.contact_forces(opened, frame=3)
    assert [float(row["length [m]"]) for row in rows] == links.length.tolist()
    assert [float(row["slack"]) for row in rows] == links.slack.tolist()
    assert [float(row["direction_x"]) for row in rows] == links.direction[:, 0].tolist()
    with open(out / "contacts.csv", newline="") as text:
        assert [float(row["normal [N]"]) for row in csv.DictReader(text)] == forces.normal.tolist()
    with open(out / "summary.csv", newline="") as text:
        summary = {row["quantity"]: row for row in csv.DictReader(text)}
    assert float(summary["length of all wires"]["value"]) == pytest.approx(2 / 3)
    assert summary["length of all wires"]["unit"] == "m"
    again = run(file, "--out", out)
    assert again.exit_code == 1
    assert "is not empty: give another, or force (--force)" in again.output
    assert run(file, "--out", out, "--force").exit_code == 0


def test_facets_have_a_table_with_units(tmp_path):
    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    scene.add(lm.wall_segment((0.0, 0.0), (1.0, 0.0), (2.0, 0.0)))
    scene.add(lm.disk(radius=0.1, position=(0.4, 0.1), mass=3.0))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    lm.Simulation(scene, time_step=1e-3).run(steps=2, record=tmp_path / "plate.h5")
    assert run(tmp_path / "plate.h5", "--out", tmp_path / "out").exit_code == 0
    with open(tmp_path / "out" / "facets.csv", newline="") as text:
        rows = list(csv.DictReader(text))
    assert [float(row["pressure [Pa]"]) for row in rows] == pytest.approx([30.0, 0.0])
    assert [float(row["force_y [N]"]) for row in rows] == pytest.approx([-30.0, 0.0])
    assert [row["area [m^2]"] for row in rows] == ["1.0", "1.0"]


@pytest.mark.default_parameters("2")
def test_the_first_frame_has_geometry_alone(file):
    done = run(file, "--frame", "0", "--since", "0")
    assert done.exit_code == 0
    assert "Nothing acts before the first step" in done.output
    assert "The strain from frame 0 to itself is zero" in done.output
    assert "length of all wires" in done.output
    assert "tension" not in done.output.replace("contacts and tensions", "")
    later = run(file, "--frame", "0", "--since", "-1")
    assert later.exit_code == 0
    assert "stretch of links" in later.output


def test_sand_without_a_wire_and_bodies_without_a_box(tmp_path):
    output = run(pressed(tmp_path / "sand.h5", 2, wire=False)).output
    assert "There is no wire: the scene has no chains." in output
    assert "Friction" not in output
    assert run(tmp_path / "sand.h5", "--out", tmp_path / "csv").exit_code == 0
    assert {path.stem for path in (tmp_path / "csv").iterdir()} == {
        *("summary", "contact-forces", "contacts", "contact-kinds"),
    }
    scene = lm.Scene(dimension=3)
    for x in (0.0, 1.0):
        scene.add(lm.sphere(radius=0.1, position=(x, 0.0, 0.0), mass=1.0))
    scene.chain(scene.bodies[:2], lm.RigidRod())
    lm.Simulation(scene, time_step=1e-3).run(steps=1, record=tmp_path / "two.h5", every=1)
    output = run(tmp_path / "two.h5", "--out", tmp_path / "two").output
    for words in (
        "Volume and stress are not known: the scene has neither opposite walls across each axis nor a periodic cell.",
        "No contact pushes.",
        "needs at least 4 bodies that lie in no line or plane, there are 2.",
        "How the beads slip through the sand cannot be told: there are too few grains.",
    ):
        assert words in output


def test_clumps_and_capsules(tmp_path):
    """Diameters of the spheres of their volumes, solid part of the box, axes; their rotations are in the tables."""
    scene = lm.Scene(dimension=3)
    radius = 0.1
    peanut = lm.clump([radius] * 2, [(0, 0, 0), (0, radius, 0)], density=1.0)
    for x in (0.2, 0.8):
        scene.add(peanut.at((x, 0.5, 0.5)))
    for k in range(3):
        scene.add(lm.wall(point=np.zeros(3), normal=np.eye(3)[k]))
        scene.add(lm.wall(point=np.eye(3)[k], normal=-np.eye(3)[k]))
    scene.see("GRAIN", "WALL", lm.Signorini())
    sim = lm.Simulation(scene, time_step=1e-3).run(steps=1, record=tmp_path / "run.h5", every=1)
    lines = told(tmp_path / "run.h5", "--out", tmp_path / "csv")
    volume = 4.0 / 3.0 * np.pi * radius**3 * (2.0 - 5.0 / 16.0)  # two spheres less a lens
    assert peanut.volume == pytest.approx(volume, rel=1e-10)
    assert lines["mean diameter of the grains"] == f"{2.0 * radius * (2.0 - 5.0 / 16.0) ** (1.0 / 3.0):.4g} m"
    assert lines["solid part of the volume, overlaps twice"] == f"{2.0 * volume:.4g}"
    assert [float(lines[f"fabric of long axes, mean of t_{k} t_{k}"]) for k in "xyz"] == pytest.approx([0, 1, 0], abs=1e-9)
    assert (tmp_path / "csv" / "long-axes.csv").exists()
    with lm.io.open_run(tmp_path / "run.h5") as recorded:
        lm.io.export_csv(recorded, tmp_path / "tables")
    with (tmp_path / "tables" / "bodies.csv").open() as file:
        rows = [row for row in csv.DictReader(file) if row["step"] == "1"]
    found = [[float(row[name]) for name in ("q_x", "q_y", "q_z", "q_w")] for row in rows]
    np.testing.assert_array_equal(found, sim.rotations)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--frame", "6"], "Error: --frame 6 does not exist: the run has the frames 0 to 5."),
        (["--since", "-7"], "Error: --since -7 does not exist: the run has the frames 0 to 5."),
        (["--frame", "-1", "--all-frames"], "--frame chooses one frame, and --all-frames takes all"),
        (["--force"], "--force is about what --out names"),
        (["--axis", "w"], "'w' is not one of 'x', 'y', 'z'"),
        (["--out", __file__], "is a file: give the name of a folder."),
    ],
)
def test_what_cannot_be_gets_a_sentence(file, options, words):
    done = run(file, *options)
    assert done.exit_code != 0
    assert words in done.output
    assert done.output.count("\n") == 1


def test_an_axis_that_a_plane_run_does_not_have(tmp_path):
    done = run(pressed(tmp_path / "run.h5", 2), "--axis", "z")
    assert done.output == "Error: --axis z does not exist: the run is in 2D, with the axes x and y.\n"


@pytest.mark.long
def test_damaged_files_get_a_sentence(file, tmp_path):
    """Bits of the file that are flipped leave it readable, or are named in one sentence; none shows an error of lmgcpy."""
    data, rng = file.read_bytes(), np.random.default_rng(0)
    bad = tmp_path / "bad.h5"
    bad.write_bytes(data[: len(data) // 2])
    assert run(bad).exit_code == 1
    for at in rng.integers(0, len(data), 6).tolist():
        flipped = bytearray(data)
        flipped[at] ^= 1 << int(rng.integers(8))
        bad.write_bytes(bytes(flipped))
        done = run(bad)
        assert "This is an error of lmgcpy" not in done.output, (at, done.output)
        if done.exit_code:
            assert done.output.startswith("Error: "), done.output
            assert done.output.count("\n") == 1


def test_numbers_are_rounded_to_their_error():
    assert with_error(0.123456, 0.00234) == "0.1235 +- 0.0023"
    assert with_error(773.5, 559.3) == "774 +- 559"
    assert with_error(1e-9, 3e-10) == "1e-09 +- 3e-10"
    assert with_error(3.0, float("nan")) == "3"
    assert with_error(25.49, 2e-13) == "25.49"
    assert with_error(float("nan"), 1.0) == "-"


@pytest.mark.default_parameters("2")
def test_stress_is_told_as_soil_mechanics_does(file):
    """10 and 20 Pa: p, q, and the angle whose sine is q / (s1 + s3) = 1/3; three disks or spheres along each edge."""
    lines = told(file)
    with lm.io.open_run(file) as opened:
        d = opened.dimension
    p, q = (15.0 if d == 2 else 40.0 / 3.0), 10.0
    assert float(lines["mean pressure p, mean of the principal stresses"].split()[0]) == pytest.approx(p, rel=1e-3)
    assert float(lines["deviator q, greatest less smallest principal stress"].split()[0]) == pytest.approx(q, rel=1e-3)
    angle = lines["mobilised angle of friction, sin phi = q / (s1 + s3)"]
    assert float(angle.split()[0]) == pytest.approx(np.degrees(np.arcsin(1.0 / 3.0)), rel=1e-3)
    solid = np.pi / 4.0 if d == 2 else np.pi / 6.0
    assert float(lines["void ratio, volume of voids over solid volume"]) == pytest.approx(1.0 / solid - 1.0, rel=1e-3)


def test_shear_strain_is_half_of_the_difference_of_principal_strains(tmp_path):
    """Bodies fly apart along x and together along y, 5 % each: nothing off the diagonal, and a shear strain of 0.05."""
    scene = lm.Scene(dimension=3)
    for place in itertools.product((-1.0, 1.0), repeat=3):
        x, y, _ = place
        scene.add(lm.sphere(radius=0.1, mass=1.0, position=place, velocity=(0.05 * x, -0.05 * y, 0.0)))
    lm.Simulation(scene, time_step=0.1).run(steps=10, record=tmp_path / "run.h5")
    lines = told(tmp_path / "run.h5")
    assert float(lines["greatest shear strain, (e1 - e3) / 2"]) == 0.05
    assert abs(float(lines["greatest rotation, from x to y"].split()[0])) < 1e-9


def test_all_frames_make_one_table(tmp_path):
    file = pressed(tmp_path / "run.h5", 2)
    out = tmp_path / "table.csv"
    assert run(file, "--all-frames").exit_code != 0
    done = run(file, "--all-frames", "--out", out)
    assert done.exit_code == 0, done.output
    with open(out, newline="") as text:
        rows = list(csv.DictReader(text))
    assert [int(row["step"]) for row in rows] == list(range(6))
    stress = [float(row["stress along y, traction positive [Pa]"]) for row in rows]
    assert stress[1:] == pytest.approx([-20.0] * 5, rel=1e-6)
    assert np.isnan(stress[0])
    assert "stress along y, traction positive: part of the wire in the stress along y [Pa]" in rows[1]
    assert "exists" in run(file, "--all-frames", "--out", out).output
    assert run(file, "--all-frames", "--out", out, "--force").exit_code == 0
