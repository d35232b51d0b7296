"""Every tutorial runs as a reader would run it, in an empty folder; what it prints agrees with the formula beside it, and
its picture shows what it must."""

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from matplotlib import colormaps
from PIL import Image

from lmgcpy.view.drawing import CONTACT, WIRE, rgb

TUTORIALS = sorted((Path(__file__).parent.parent / "tutorials").glob("*.py"))
DOCS = Path(__file__).parent.parent / "docs"


def follow(number, home):
    """What a tutorial printed, run in the folder ``home`` with warnings as errors, and the folder that it filled."""
    script = TUTORIALS[number - 1]
    done = subprocess.run([sys.executable, "-W", "error", script], capture_output=True, text=True, cwd=home)
    assert done.returncode == 0, done.stderr
    assert "Warning" not in done.stderr
    printed = {labels(line) for line in done.stdout.splitlines()}
    assert [line for line in shown(number) if labels(line) not in printed] == []
    return done.stdout, home / f"tutorial_{number:02}"


def shown(number):
    """The lines that the page shows as a tutorial's output."""
    page = (DOCS / f"tutorial_{number}.md").read_text("utf-8")
    return re.search(r"It prints:\n\n```text\n(.*?)```", page, re.S)[1].splitlines()


def labels(line):
    """A line without its numbers, which depend on the processor, and without the width of its columns."""
    return " ".join(re.sub(r"-?\d[\d.]*(?:e[+-]?\d+)?", "#", line).split())


def numbers(text, beginning):
    """All numbers in the first line that begins so, less those of that beginning."""
    line = next(line for line in text.splitlines() if line.strip().startswith(beginning))
    return [float(x) for x in re.findall(r"(?<![\w^])-?\d+\.?\d*(?:e[+-]?\d+)?", line.split(beginning, 1)[1])]


def pixels(path):
    """A picture, (height, width, 3)."""
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB")).astype(int)


def like(image, color, within=12):
    """How many pixels have a colour, to ``within`` of 255 in each part."""
    wanted = rgb(color).astype(int) if isinstance(color, str) else np.array(color)
    return int((np.abs(image - wanted) <= within).all(axis=2).sum())


def blue(image):
    """How many pixels are of a wire's blue, however lit."""
    red, green, blue = (image[..., k] for k in range(3))
    return int(((blue > 60) & (blue > 2 * red) & (blue > 1.5 * green)).sum())


def halves(image):
    """Its left and its right half."""
    middle = image.shape[1] // 2
    return image[:, :middle], image[:, middle:]


def test_there_are_eight_short_ones_each_with_its_picture_on_its_page():
    assert [int(path.name[:2]) for path in TUTORIALS] == list(range(1, 9))
    for number, path in enumerate(TUTORIALS, 1):
        page = (DOCS / f"tutorial_{number}.md").read_text()
        assert len(path.read_text().splitlines()) < 150, path.name
        assert f"../tutorials/{path.name}" in page
        assert f"```{{literalinclude}} ../tutorials/{path.name}\n:language: python\n```" in page
        assert len(shown(number)) >= 5
        assert f"images/tutorial_{number}.png" in page
        assert (DOCS / "images" / f"tutorial_{number}.png").stat().st_size < 150_000


@pytest.mark.long
def test_1_the_ground_bears_the_pile_and_no_energy_is_lost(tmp_path):
    """At rest the ground bears the weight, to the tolerance of a step, 1e-2 of what a step without contacts would do."""
    text, folder = follow(1, tmp_path)
    table = text.split("last step\n")[1].splitlines()
    last = [line.split() for line in table if re.match(r" +\d\.\d\d ", line)][-1]
    assert float(last[1]) == pytest.approx(1.0, abs=2e-3)
    assert float(last[2]) < 1e-6  # kinetic energy [J/m], of 74 J/m of work
    given, defect = numbers(text, "centre of mass fell by")[-1], numbers(text, "work of the contacts")[-1]
    assert given > 50.0
    assert abs(defect) < 1e-9 * given
    picture = pixels(folder / "pile.png")
    above, below = picture[: len(picture) // 2, :, :], picture[len(picture) // 2 :, :, :]
    assert like(below, CONTACT) > 1000 > 10 * like(above, CONTACT)  # force chains
    assert like(above, (94, 79, 162)) > 1000  # the lowest layer, Spectral's first colour
    assert like(above, (217, 203, 163)) > 3000  # the ground, which has no layer
    with Image.open(folder / "pile.gif") as film:
        assert film.n_frames > 5


@pytest.mark.long
def test_2_the_wire_snaps_and_swings_by_the_formulas_and_does_not_explode(tmp_path):
    text, folder = follow(2, tmp_path)
    for beginning in ("snaps taut at", "impulse", "speed after", "lowest point"):
        found, exact = numbers(text, beginning)
        assert found == pytest.approx(exact, rel=1e-3), beginning  # of first order: h is 0.2 ms of 0.44 s
    by_links, by_block = (numbers(text, f"tensions {how}:")[0] for how in ("link by link", "as one block"))
    assert by_block < 1e-6 < 10.0 < by_links  # [%]
    rows = [[float(x) for x in line.split()] for line in text.split("(m g)\n")[1].splitlines()]
    for k, number, _, stretch, explicit, back, rest in rows:
        assert 0.0 < stretch < 0.1
        assert back < 0.1  # no higher than where it fell from
        assert (explicit > 1.0) == (number > 4.0), k
        assert rest == pytest.approx(1.0, abs=1e-3)
    picture = pixels(folder / "wire.png")
    plasma = [tuple(round(255 * part) for part in colormaps["plasma"](share)[:3]) for share in (0.0, 12.398 / 20.0)]
    slack, taut = halves(picture[:, : int(0.82 * picture.shape[1])])  # without the scale
    assert like(slack, plasma[0]) > 300
    assert like(slack, plasma[1]) == 0
    assert like(taut, plasma[1]) > 300


@pytest.mark.long
def test_3_the_boulder_stops_where_energy_says_and_the_law_conforms(tmp_path):
    text, folder = follow(3, tmp_path)
    for force, found, exact, most, rest in (map(float, re.findall(r"[\d.]+", line)) for line in text.splitlines()[1:4]):
        assert found == pytest.approx(exact, abs=2e-3)  # m: a contact begins within a step
        assert most == pytest.approx(force, rel=1e-9)
        assert rest == pytest.approx(9.81, rel=1e-4)
    assert "conforms" in text
    assert "broken" not in text
    picture = pixels(folder / "cushion.png")
    for half in halves(picture):
        assert all(like(half, color) > 100 for color in ("#1f77b4", "#ff7f0e", "#2ca02c"))


@pytest.mark.long
def test_4_the_stresses_are_those_of_the_walls_and_the_wire_pulls_one_way(tmp_path):
    text, folder = follow(4, tmp_path)
    sand, wire = text.split("rigid-wire: stress")
    for part in (sand, wire):
        for beginning in ("horizontal", "vertical"):
            found, loaded = numbers(part, beginning)
            assert found == pytest.approx(loaded, rel=0.01)  # the tolerance of a step
    (without,), (with_wire,) = (numbers(part, "mobilised friction") for part in (sand, wire))
    assert 9.0 < without < with_wire - 3.0  # degrees; loose sand, over four seeds 9.6 to 14.8
    greatest, smallest = numbers(wire, "wire's part")
    assert -0.1 * greatest < smallest < 0.3 * greatest
    left, right = halves(pixels(folder / "chains.png")[:400])  # without the legend
    assert like(right, WIRE) > 1000 > like(left, WIRE) == 0
    assert like(right, CONTACT) > 3000
    assert like(left, CONTACT) > 100  # a third of the force: thin lines take the colour of what is beside them
    assert like(pixels(folder / "stress.png"), WIRE) > 1000
    assert like(pixels(folder / "reaction.png"), WIRE) > 1000


@pytest.mark.long
def test_5_the_sample_is_dense_and_its_wire_pulls_within_its_layers(tmp_path):
    text, folder = follow(5, tmp_path)
    for row in text.splitlines()[2:7]:
        _, _, solid_fraction, lateral, sand, _, *_ = (float(number) for number in row.split())
        assert solid_fraction == pytest.approx(0.63, abs=0.03)
        assert lateral == pytest.approx(100.0, abs=0.5)  # kPa, imposed
        assert sand > 50.0
    gain, error = numbers(text, "the wire adds")
    assert 0.0 < error < gain  # 9 and 3
    within, spread = numbers(text, "its part of the stress:")
    across, more, of = next(
        [float(x) for x in re.findall(r"[\d.]+", line)] for line in text.splitlines() if "kPa across them" in line
    )
    assert 0.0 <= across < 0.5 * within  # 0.2 of it
    assert 0.0 < spread < within  # 1.1 and 0.5 kPa
    assert more >= 4 <= of  # all five; one may hardly pull
    sample = pixels(folder / "sample.png")
    assert (sample[:, :, 0].astype(int) > sample[:, :, 2] + 60).sum() > 5000  # contact forces, translucent among the wires
    left, right = halves(pixels(folder / "columns.png")[:-40])
    assert blue(right) > blue(left) + 300


@pytest.mark.long
def test_6_errors_fall_by_the_orders_that_theory_gives(tmp_path):
    text, folder = follow(6, tmp_path)
    assert numbers(text, "pendulum")[-1] == pytest.approx(2.0, abs=0.1)
    assert numbers(text, "ten shocks")[-1] == pytest.approx(1.0, abs=0.2)
    for solver in ("GaussSeidel", "Auto"):
        errors = [float(line.split()[-1]) for line in text.splitlines() if line.startswith(solver)]
        assert errors == sorted(errors, reverse=True)
        assert errors[-1] < 1e-4 < 0.05 < errors[0]
    table = text.split("overlap / size\n")[1].splitlines()
    rows = [[float(x) for x in re.findall(r"[\d.]+(?:e-\d+)?", line)] for line in table]
    stresses, overlaps = ([row[k] for row in rows] for k in (3, 5))  # kPa, in parts of a grain
    assert max(stresses) < 1.2 * min(stresses)
    assert overlaps[0] > 4.0 * overlaps[1] > 8.0 * overlaps[2]  # grains sink into each other
    thirds = np.array_split(pixels(folder / "accuracy.png"), 3, axis=1)
    assert all(like(third, "#1f77b4", 40) > 100 for third in thirds)


@pytest.mark.long
def test_7_going_on_is_bit_for_bit_and_paraview_gets_it_all(tmp_path):
    text, folder = follow(7, tmp_path)
    assert "run without interruption: None" in text
    *_, borne, weight = numbers(text, "floor")
    assert borne == pytest.approx(weight, rel=0.01)
    given, taken = numbers(text, "work of gravity")
    _, left = numbers(text, "out of balance")
    assert given + taken == pytest.approx(left, rel=1e-4)  # of numbers of seven digits
    assert {path.name for path in folder.glob("paraview/*.pvd")} == {
        f"{x}.pvd" for x in ("bodies", "forces", "wires", "walls")
    }
    picture = pixels(folder / "paraview.png")
    assert blue(picture) > 5000
    red = (picture[..., 0] > 90) & (picture[..., 1] < picture[..., 0] // 3)
    assert red.sum() > 5000


@pytest.mark.long
def test_8_what_slips_bears_less_and_the_anchored_wire_is_nearer_to_the_run(tmp_path):
    text, folder = follow(8, tmp_path)
    sand, held, slipping = numbers(text, "sand alone")[0], numbers(text, "wire, held"), numbers(text, "wire, slipping")
    M = 6.0 * np.sin(np.radians(20.0)) / (3.0 - np.sin(np.radians(20.0)))
    assert sand == pytest.approx(100.0 * M / (1.0 - M / 3.0), rel=2e-3)  # q = M p, p = p_lateral + q/3
    assert held[0] > slipping[0] > sand
    assert held[0] > held[1] > sand
    q = {name: numbers(text, f"{name} ")[-1] for name in ("run", "local", "anchored")}
    assert abs(q["anchored"] - q["run"]) < 0.3 * q["run"] < abs(q["local"] - q["run"])
    assert (pixels(folder / "prediction-elastic-wire.png") < 100).sum() > 5000
