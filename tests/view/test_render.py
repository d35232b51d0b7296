"""Pictures show what they must: pixels of the right colour where things are, as thick as the force."""

import base64
import os
import re
import subprocess
import sys

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from PIL import Image
from seen import hanging, like, pile, pixels, reddish, wire_in_a_box

import lmgcpy as lm
from lmgcpy.view.compose import compose, panels_of
from lmgcpy.view.cutting import within
from lmgcpy.view.drawing import CONTACT, SAND, WIRE, Drawing, Paint, Tubes, rgb
from lmgcpy.view.film import LEGEND, THICKEST_BAR, TITLE, Film
from lmgcpy.view.painter import Painter
from lmgcpy.view.pictures import palette_of
from lmgcpy.view.snapshot import snapshot
from lmgcpy.view.style import OPTIONS, Camera, View, style_of

SIZE = (300, 300)


def where(source, points, image, top=0, **options):
    """Pixels of points in a picture of one panel without a title: the projection again, from the documented rule."""
    snap = snapshot(source)
    style = style_of({**dict.fromkeys(OPTIONS), **options}, dimension=snap.dimension, is_scene=snap.time is None)
    view = View.of(Camera.looking(style.direction), compose(snap, style).bounds())
    scale = min(SIZE[0] / view.width, SIZE[1] / view.height)
    points = np.asarray(points, dtype=float)
    at = view.pixels(np.pad(points, ((0, 0), (0, 3 - points.shape[1]))), scale)
    return image[top + at[:, 1].astype(int), at[:, 0].astype(int)], scale


@pytest.mark.default_parameters("isometric")
@pytest.mark.parametrize("camera", ["x", "y", "z", "isometric", (1.0, -2.0, 0.5)])
def test_the_wire_is_where_it_is_projected_to(camera, tmp_path):
    """Blue along the middle of every link, however lit, and nowhere 0.1 m above it."""
    scene, out = wire_in_a_box(), tmp_path / "a.png"
    options = {"grains": "hidden", "wires": "plain", "camera": camera}
    lm.view.render(scene, out, size=SIZE, **options)
    image = pixels(out)
    middles = np.array([[0.2 + 0.2 * i, 0.5, 0.3] for i in range(4)])
    on, _ = where(scene, middles, image, **options)
    on = on.astype(int)
    assert (on[:, 2] > 2 * on[:, 0]).all()
    assert (on[:, 2] > 60).all()
    if camera != "z":
        off, _ = where(scene, middles + np.array([0.0, 0.0, 0.1]), image, **options)
        assert not like(off[None], WIRE, 60).any()


def test_disks_have_their_colour_and_their_size(tmp_path):
    """Area of the middle ball of a pile, by its colour: pi R^2 within the darker edge."""
    out = tmp_path / "a.png"
    sim = pile(3)
    lm.view.render(sim, out, grains="plain", size=SIZE, title="")
    image = pixels(out)
    (centre,), scale = where(sim, [[0.0, 1.5]], image, grains="plain")
    assert like(centre[None, None], SAND, 3).all()
    shown = like(image, SAND, 3).sum()
    assert shown == pytest.approx(3 * np.pi * ((0.5 - 0.07 * 0.5) * scale) ** 2, rel=0.02)


def test_overlaps_and_long_links_are_red_where_they_are(tmp_path):
    scene, out = wire_in_a_box(overlap=0.3, stretch=1.25), tmp_path / "a.png"
    lm.view.render(scene, out, size=SIZE, camera="y")
    image = pixels(out)
    places = [[0.3, 0.5, 0.7], [0.47, 0.5, 0.7], [0.2, 0.5, 0.3], [0.8, 0.5, 0.3]]
    found, _ = where(scene, places, image, camera="y")
    assert reddish(found[None]).all()
    sound = tmp_path / "b.png"
    lm.view.render(wire_in_a_box(), sound, size=SIZE, camera="y")
    assert not reddish(pixels(sound)).any()


def test_thickness_grows_with_the_force(tmp_path):
    """Across the three contacts of a pile of equal balls: 3, 2 and 1 times the same width."""
    sim, out = pile(3), tmp_path / "a.png"
    lm.view.render(sim, out, what="forces", grains="hidden", size=(900, 900), title="")
    image = pixels(out)
    red = like(image, CONTACT, 60)
    rows = np.flatnonzero(red.any(axis=1))
    height = rows[-1] - rows[0]  # from the floor to the top ball's centre, 2.5 m
    widths = [red[int(rows[-1] - height * y / 2.5)].sum() for y in (0.25, 1.0, 2.0)]
    # widths are whole pixels: the thinnest line has some 15 of them
    np.testing.assert_allclose(np.array(widths) / widths[2], [3.0, 2.0, 1.0], rtol=0.08)


def test_two_panels_share_one_scale_of_forces(tmp_path):
    """The same pile under three times the gravity has lines three times as wide beside it, not on its own."""
    light, out = pile(1), tmp_path / "a.png"
    scene = lm.Scene(dimension=2, gravity=(0.0, -30.0))
    scene.add(lm.disk(radius=0.5, position=(0.0, 0.5), mass=0.1))
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3))
    heavy = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12))
    heavy.step()
    lm.view.render([heavy, light], out, what="forces", grains="hidden", size=(400, 400), title="")
    red = like(pixels(out), CONTACT, 60)
    width = red.shape[1] // 2
    row = np.flatnonzero(red[:, :width].any(axis=1)).mean().astype(int)
    assert red[row, :width].sum() == pytest.approx(3.0 * red[row, width:].sum(), rel=0.08)


def test_tension_is_blue_and_pushing_red(tmp_path):
    for name, sim in (("hang", hanging(3)), ("pile", pile(3))):
        lm.view.render(sim, tmp_path / f"{name}.png", what="forces", size=SIZE)
    hang, pushed = pixels(tmp_path / "hang.png"), pixels(tmp_path / "pile.png")
    assert like(hang, WIRE).sum() > 50
    assert like(hang, CONTACT).sum() == 0
    assert like(pushed, CONTACT).sum() > 50
    assert like(pushed, WIRE).sum() == 0


def test_what_is_inside_is_seen_through_the_grains(tmp_path):
    """A wire behind a screen of grains: blue through them, hidden by opaque ones."""
    scene = lm.Scene(dimension=3)
    beads = [scene.add(lm.sphere(radius=0.05, position=(0.2 * i, 0.0, 0.0), mass=1.0, color="BEAD")) for i in range(10)]
    for i in range(10):
        for j in range(-3, 4):
            scene.add(lm.sphere(radius=0.1, position=(0.2 * i, -0.5, 0.2 * j), mass=1.0))
    scene.see("BEAD", "BEAD", lm.Signorini())
    scene.chain(beads, lm.RigidWire())
    blue = {}
    for opacity in (None, 1.0):
        lm.view.render(scene, tmp_path / "a.png", wires="plain", camera="y", opacity=opacity, size=SIZE)
        image = pixels(tmp_path / "a.png").astype(int)[:-60]  # without the legend
        blue[opacity] = (image[..., 2] > image[..., 0] + 20).sum()
    assert blue[None] > 200
    assert blue[1.0] < 0.2 * blue[None]


@pytest.mark.default_parameters("1.0")
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_of_two_translucent_balls_the_near_one_tells_more(side, tmp_path):
    """A sand-coloured one before a bluish one, and the other way round: half of the near, a quarter of the far."""
    scene = lm.Scene(dimension=3)
    for color, y in (("A", -1.0), ("B", 1.0)):
        scene.add(lm.sphere(radius=0.5, position=(0.0, y, 0.0), mass=1.0, color=color))
    how = {"grains": "color", "opacity": 0.5, "camera": (0.0, side, 0.0), "title": ""}
    lm.view.render(scene, tmp_path / "a.png", size=SIZE, **how)
    ((red, _, blue),), _ = where(scene, [[0.0, 0.0, 0.0]], pixels(tmp_path / "a.png").astype(int), **how)
    assert (red > blue) == (side < 0.0)


@pytest.fixture(scope="module")
def run_of_a_fall(tmp_path_factory):
    """The run file of a falling ball, of five frames."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -10.0))
    scene.add(lm.disk(radius=0.1, position=(0.0, 1.0), mass=1.0))
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0.0, 1.0)))
    path = tmp_path_factory.mktemp("fall") / "fall.h5"
    lm.Simulation(scene, time_step=1e-2).run(steps=40, record=path, every=10)
    return path


@pytest.mark.long
def test_a_moving_picture_moves(run_of_a_fall, tmp_path):
    """A falling ball: a frame for each of the run's, at one scale, and it goes down as it should."""
    with lm.io.open_run(run_of_a_fall) as run:
        out = lm.view.render(run, tmp_path / "fall.gif", grains="plain", size=(200, 200), frames_per_second=10.0)
        some = lm.view.render(run, tmp_path / "some.gif", grains="plain", frame=range(0, 5, 2), size=(100, 100))
    heights = []
    with Image.open(out) as image:
        assert image.n_frames == 5
        assert image.info["duration"] == 100
        for k in range(5):
            image.seek(k)
            found = like(np.asarray(image.convert("RGB")), SAND, 12)
            heights.append(np.flatnonzero(found.any(axis=1)).mean())
    drops = np.diff(heights)
    # 0.05, 0.15, 0.25, 0.35 m: in proportion to 1, 3, 5, 7, to a pixel
    np.testing.assert_allclose(drops, drops.sum() * np.array([1, 3, 5, 7]) / 16, atol=1.5)
    with Image.open(some) as image:
        assert image.n_frames == 3


@pytest.mark.long
def test_colours_of_all_frames_are_on_one_scale(tmp_path):
    """Three panels of a run, of which the scale is the fastest frame's: up to the 99 % quantile of speeds 0 and 1 m/s."""
    scene = lm.Scene(dimension=2)
    scene.add(lm.disk(radius=0.4, position=(0.0, 0.0), mass=1.0))
    fast = scene.add(lm.disk(radius=0.4, position=(1.0, 0.0), mass=1.0))
    fast.impose_velocity(x=lambda t: 100.0 * t)
    lm.Simulation(scene, time_step=1e-3).run(steps=10, record=tmp_path / "a.h5", every=5)
    with lm.io.open_run(tmp_path / "a.h5") as run:
        lm.view.render(run, tmp_path / "a.png", frame=[2, 1, 0], size=SIZE, title="")
        image = pixels(tmp_path / "a.png")
    from lmgcpy.view.quantities import SPEED

    for speed, count in ((0.0, 4), (0.5, 1), (1.0, 1)):
        (color,) = SPEED.colors(np.array([speed]), (0.0, 0.99))
        shown = (np.abs(image.astype(int) - color) <= 3).all(axis=2).sum()
        one = np.pi * (0.36 * SIZE[0] / 2.0) ** 2
        assert 0.5 * count * one < shown < 2.0 * count * one, (speed, shown, one)


def test_panels_in_rows(tmp_path):
    """Four panels of one size, two a row: as wide as two, and twice as high."""
    sim = pile(2)
    for count, columns in ((2, None), (4, 2)):
        out = tmp_path / f"{count}.png"
        lm.view.render([sim] * count, out, grains="plain", size=(100, 100), title="", columns=columns)
    two, four = pixels(tmp_path / "2.png"), pixels(tmp_path / "4.png")
    assert four.shape == (2 * two.shape[0], two.shape[1], 3)
    np.testing.assert_array_equal(four[: two.shape[0]], two)
    np.testing.assert_array_equal(four[two.shape[0] :], two)


def test_what_is_written_has_room(tmp_path):
    """A narrow panel with a long title, a legend and a note: the text ends before the picture does."""
    lm.view.render(pile(3), tmp_path / "a.png", what="forces", title="a pile of three balls at rest", size=(60, 60))
    ink = (pixels(tmp_path / "a.png") < 200).any(axis=2)
    assert ink[:TITLE].any()
    assert ink[-30:].any()
    assert not ink[:, :3].any()
    assert not ink[:, -3:].any()


def test_titles_take_a_line(tmp_path):
    sim = pile(2)
    heights = []
    for title in ("", None, "a pile"):
        lm.view.render(sim, tmp_path / "a.png", title=title, size=SIZE)
        heights.append(pixels(tmp_path / "a.png").shape[0])
    assert heights == [heights[0], heights[0] + TITLE, heights[0] + TITLE]


@pytest.mark.long
def test_many_spheres_are_one_actor(tmp_path):
    """So that 10 000 stay interactive: one vertex each, in one mapper."""
    scene = lm.Scene(dimension=3)
    for position in np.random.default_rng(0).uniform(0.0, 1.0, (10_000, 3)):
        scene.add(lm.sphere(radius=0.01, position=position, mass=1.0))
    scene.see("GRAIN", "OTHER", lm.Signorini())
    snap = snapshot(scene)
    style = style_of(dict.fromkeys(OPTIONS), dimension=3, is_scene=True)
    painter = Painter(off_screen=True)
    painter.draw(compose(snap, style), {}, 0.0, np.array([0.0, 0.0, 1.0]))
    (actor,) = painter.plotter.actors.values()
    assert actor.GetMapper().GetInput().GetNumberOfPoints() == 10_000
    painter.close()


@pytest.mark.long
def test_nothing_is_said_without_a_display(tmp_path):
    """VTK's words about an X server that there is not are for its developers."""
    code = (
        "import lmgcpy as lm\nscene = lm.Scene(dimension=2)\n"
        "scene.add(lm.disk(radius=1.0, position=(0, 0), mass=1.0))\n"
        "lm.view.render(scene, 'a.png', size=(50, 50))\n"
        "try:\n    lm.view.show(scene)\nexcept OSError as error:\n    print(error)\n"
    )
    bare = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    done = subprocess.run(
        [sys.executable, "-W", "error", "-c", code], capture_output=True, text=True, cwd=tmp_path, env=bare
    )
    assert done.stderr == ""
    assert done.stdout.startswith("There is no display to open a window on")
    assert (tmp_path / "a.png").exists()


@pytest.mark.long
def test_without_opengl_a_sentence_and_not_a_crash(tmp_path):
    """Mesa's EGL hidden: a machine that has OSMesa draws all the same."""
    code = (
        "import lmgcpy as lm\nscene = lm.Scene(dimension=2)\n"
        "scene.add(lm.disk(radius=1.0, position=(0, 0), mass=1.0))\n"
        "try:\n    lm.view.render(scene, 'a.png', size=(50, 50))\n"
        "except OSError as error:\n    print(error)\n"
    )
    bare = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    bare["__EGL_VENDOR_LIBRARY_FILENAMES"] = str(tmp_path / "none.json")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=tmp_path, env=bare)
    assert done.returncode == 0
    assert done.stderr == ""
    assert (tmp_path / "a.png").exists() != done.stdout.startswith("No OpenGL was found to draw with")


# ---------------------------------------------------------------------------------------------------------- sentences


def test_without_pyvista_a_sentence(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    for call in (lambda: lm.view.render(pile(1), tmp_path / "a.png"), lambda: lm.view.show(pile(1))):
        with pytest.raises(ImportError, match=r'pip install "lmgcpy\[view\]"\.'):
            call()
    assert not list(tmp_path.iterdir())


WRONG = {
    "suffix": ({"path": "a.jpg"}, "must end in .png, .pdf, .svg or, for a moving picture, in .gif or .mp4, got"),
    "folder": ({"path": "no/such/a.png"}, "to write 'no/such/a.png' into: make it first"),
    "what": ({"what": "grain"}, "what cannot be 'grain'; did you mean 'grains'?"),
    "forces": ({"what": "forces"}, "run a Simulation of the scene first"),
    "grains": ({"grains": "sped"}, "grains cannot be 'sped'; did you mean 'speed'?"),
    "wires": ({"wires": "tensions"}, "wires cannot be 'tensions'; did you mean 'tension'?"),
    "rotation": ({"grains": "rotation"}, "in 3D, where it is no angle: ask for 'spin'"),
    "camera": ({"camera": "front"}, "camera cannot be 'front'"),
    "camera of nothing": ({"camera": (0.0, 0.0, 0.0)}, "camera must not be zero"),
    "section and camera": ({"section": "y", "camera": "x"}, "leave out one of the two"),
    "clip": ({"clip": ("w", 0.1)}, "the axis of clip cannot be 'w'"),
    "limits of nothing": ({"grains": "plain", "wires": "plain", "limits": (0.0, 1.0)}, "this picture has none"),
    "limits": ({"limits": (1.0, 0.0)}, "low below high"),
    "force": ({"force": 1.0}, "say what='forces', or leave it out"),
    "frame": ({"frame": 0}, "frame is for run files"),
    "panels": ({"camera": ["x", "y"], "title": ["a", "b", "c"]}, "camera has 2, title has 3"),
    "no panels": ({"camera": []}, "camera has 0"),
    "standing gif": ({"path": "a.gif"}, "A .gif moves"),
    "region": ({"region": (0, 1)}, "a corner of region"),
    "region of one corner": ({"region": ((0, 0, 0),)}, "region must be a pair of corners"),
    "regions of two panels": ({"region": [(0, 0, 0), (1, 1, 1)]}, "a list has a region for each panel"),
    "region upside down": ({"region": ((0, 0, 1), (1, 1, 0))}, "its low corner and its high corner"),
    "region of nothing": ({"region": ((5, 5, 5), (6, 6, 7))}, "Nothing is to be seen in the region"),
    "title": ({"title": 3}, "title must be a line of text, got 3."),
    "size": ({"size": (0, 100)}, "the width in size must be at least 16, got 0."),
}


@pytest.mark.parametrize("row", WRONG)
def test_what_cannot_be_drawn_gets_a_sentence(row, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    options, words = WRONG[row]
    with pytest.raises((ValueError, TypeError, FileNotFoundError)) as caught:
        lm.view.render(wire_in_a_box(), **{"path": "a.png", **options})
    assert words in str(caught.value)
    assert str(caught.value)[-1] in ".?"
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("kind", ["pdf", "svg"])
def test_words_of_a_pdf_or_svg_are_no_pixels(kind, tmp_path):
    """The bodies are one image, of the size of the panel."""
    out = lm.view.render(pile(3), tmp_path / f"a.{kind}", title="a pile", size=SIZE)
    content = out.read_bytes()
    assert content.startswith(b"%PDF" if kind == "pdf" else b"<?xml")
    assert content.count(b"/Subtype /Image" if kind == "pdf" else b"<image ") >= 1
    if kind == "svg":
        assert b"<!-- a pile -->" in content


def test_a_page_shows_what_the_pixels_show():
    """The figure of a PDF or SVG, as pixels, is the picture: images lie where they lie there."""
    panels = [
        panel for k in (2, 3) for panel in panels_of(pile(k), None, {**dict.fromkeys(OPTIONS), "title": "a"}, moving=False)
    ]
    painter = Painter(off_screen=True)
    page = Film(panels, size=(201, 157)).plate(painter, 0)
    painter.close()
    picture = page.pixels()
    page.document("svg")
    canvas = FigureCanvasAgg(page.figure)
    canvas.draw()
    assert np.array_equal(np.array(canvas.buffer_rgba())[..., :3], picture)


def test_a_region_is_seen_and_nothing_else(tmp_path):
    """A disk of radius 1 in a window of 4 x 4 covers pi/16 of it, though another one is far away."""
    scene = lm.Scene(dimension=2)
    for x in (0.0, 1000.0):
        scene.add(lm.disk(radius=1.0, position=(x, 0.0), mass=1.0))
    shown = {"grains": "plain", "title": "", "size": (300, 300)}
    lm.view.render(scene, tmp_path / "a.png", region=((-2, -2), (2, 2)), **shown)
    image = pixels(tmp_path / "a.png")
    assert image.shape[0] == image.shape[1]
    assert (image < 250).any(axis=2).mean() == pytest.approx(np.pi / 16.0, rel=0.02)
    lm.view.render(scene, tmp_path / "all.png", **shown)
    assert (pixels(tmp_path / "all.png") < 250).any(axis=2).mean() < 0.01


def in_region(scene, region, **options):
    """The drawing of a scene in a region."""
    words = {**dict.fromkeys(OPTIONS), **options, "region": region}
    return Film(panels_of(scene, None, words, moving=False), size=SIZE)


def test_what_is_beyond_a_region_does_not_count_for_the_scales():
    """Of four balls in a row of spacing 3, radius 1, speeds 0 to 3, the region from 2.5 to 6.5 holds the third, and the
    second reaches into it, up to 4; the last is beyond it by 1.5."""
    scene = lm.Scene(dimension=3)
    for i in range(4):
        scene.add(lm.sphere(radius=1.0, position=(3.0 * i, 0.0, 1.0), mass=1.0, velocity=(0.0, 0.0, float(i))))
    scene.add(lm.wall(point=(0.0, 0.0, 0.0), normal=(0.0, 0.0, 1.0)))
    region = ((2.5, -1.0, -0.5), (6.5, 1.0, 2.0))
    film = in_region(scene, region, what="grains", grains="speed")
    drawing = film.drawing(0, 0)
    assert drawing.balls[0].centres[:, 0].tolist() == [3.0, 6.0]
    assert next(iter(film.limits.values()))[1] == pytest.approx(2.0, rel=0.02)  # the 99 % quantile
    [ground] = drawing.ground
    assert np.allclose(ground.min(axis=0), [2.5, -1.0, 0.0], atol=1e-12)
    assert np.allclose(ground.max(axis=0), [6.5, 1.0, 0.0], atol=1e-12)
    flat = in_region(scene, region, section=("y", 0.0))
    assert flat.views[0].width == pytest.approx(4.0)
    assert flat.views[0].height == pytest.approx(2.5)
    [floor] = flat.drawing(0, 0).lines
    assert np.allclose(np.sort(floor[:, 0]), [2.5, 6.5])
    shown = flat.drawing(0, 0).balls[0].centres
    assert np.allclose(shown, [[3.0, 1.0, 0.0], [6.0, 1.0, 0.0]])


def test_one_that_escapes_from_a_region_changes_nothing_there():
    """In space grains around a wire are translucent, by their density. The drawing of the region is that without the
    escaped ball."""
    region = ((-0.1, -0.1, -0.1), (1.1, 1.1, 1.1))
    drawings = []
    for escaped in (False, True):
        scene = wire_in_a_box()
        for position in np.ndindex(4, 4, 4):
            scene.add(lm.sphere(radius=0.15, position=0.2 + 0.2 * np.array(position), mass=1.0, color="MANY"))
        if escaped:
            scene.add(lm.sphere(radius=0.1, position=(0.5, 0.5, 900.0), mass=1.0, color="MANY"))
        drawings.append(in_region(scene, region).drawing(0, 0))
    one, other = drawings
    assert one.balls[0].opacity < 0.4
    assert [balls.opacity for balls in one.balls] == [balls.opacity for balls in other.balls]
    for a, b in zip(one.balls, other.balls, strict=True):
        assert np.array_equal(a.centres, b.centres)
    assert np.allclose(one.bounds(), other.bounds())
    for drawing in drawings:
        assert drawing.lines.min() >= -0.1
        assert drawing.lines.max() <= 1.1


def test_lines_are_cut_by_a_region():
    """Through, within, into from either side, along an axis, and past a corner."""
    lines = np.array(
        [
            [[-1, 0, 0], [3, 4, 0]],
            [[0.5, 0.5, 0], [1, 0.5, 0]],
            [[1, 1, 0], [1, 5, 0]],
            [[1, 5, 0], [1, 1, 0]],
            [[-1, 2.5, 0], [3, 2.5, 0]],
            [[-1, 1.5, 0], [1.5, 4, 0]],
        ],
        dtype=float,
    )
    drawing = Drawing(flat=True, balls=[], tubes=[], walls=[], lines=lines, grain=1.0)
    region = np.array([[0.0, 0.0, 0.0], [2.0, 2.0, 0.0]])
    pieces = [[[0, 1, 0], [1, 2, 0]], [[0.5, 0.5, 0], [1, 0.5, 0]], [[1, 1, 0], [1, 2, 0]], [[1, 2, 0], [1, 1, 0]]]
    assert np.allclose(within(drawing, region).lines, pieces, atol=1e-15)


def test_the_force_of_the_scale_is_a_round_number(tmp_path):
    film = Film(panels_of(pile(3), None, {**dict.fromkeys(OPTIONS), "what": "forces"}, moving=False), size=SIZE)
    assert film.force == float(f"{film.force:.2g}") > 0.0
    assert re.fullmatch(r"half as thick as a mean grain: \d{1,3} (m|k)?N(/m)?", film.note), film.note


@pytest.mark.parametrize("side", [100, 400, 1600])
def test_the_scale_of_forces_is_a_bar_as_thick_as_its_force(side, tmp_path):
    """Of one ball on another one, 10 N: the bar has the thickness of its force beside the thickness of the picture, and is
    no thicker than a line of the legend."""
    film = Film(panels_of(pile(3), None, {**dict.fromkeys(OPTIONS), "what": "forces"}, moving=False), size=(side, side))
    words, thick = film.bar
    prefix = {"": 1.0, "m": 1e-3, "k": 1e3}
    number, unit = re.fullmatch(r"a force of ([0-9.]+) ((?:m|k)?)N(?:/m)?", words).groups()
    assert thick == pytest.approx(2.0 * film.thickness * float(number) * prefix[unit] * film.scale, rel=1e-2)
    assert thick <= THICKEST_BAR * film.zoom
    painter = Painter(off_screen=True)
    image = film.plate(painter, 0).pixels()
    painter.close()
    legend = (image < 60).all(axis=2)[-round(LEGEND * film.zoom) :]
    columns = legend.sum(axis=0)
    assert columns.max() == pytest.approx(thick, abs=1.5 + 0.3 * thick)  # or a letter beside a thin bar


def test_fixed_bodies_are_plain_in_a_picture_of_motion():
    """The scale is that of the others."""
    scene = lm.Scene(dimension=2)
    for x, spin in ((0.0, 2.0), (3.0, 5.0)):
        scene.add(lm.disk(radius=1.0, position=(x, x), mass=1.0, velocity=(1.0, 0.0), spin=spin))
    scene.bodies[0].fix("x", "y")  # it may turn
    scene.bodies[1].fix("spin")
    scene.add(lm.wall(point=(0.0, -1.0), normal=(0.0, 1.0)))
    held = np.array([[True, True, False], [False, False, True], [True, True, True]])
    assert np.array_equal(snapshot(scene).held, held)
    expected = {
        "layer": [(3.0, 3.0)],
        "speed": [(0.0, 1.0)],
        "radius": [(1.0, 1.0)],
        "spin": [(-2.0, 2.0)],
    }
    for grains, count in (("layer", 1), ("speed", 1), ("radius", 2), ("spin", 1)):
        options = {**dict.fromkeys(OPTIONS), "what": "grains", "grains": grains}
        film = Film(panels_of(scene, None, options, moving=False), size=SIZE)
        painted = [balls for balls in film.drawing(0, 0).balls if balls.paint.quantity is not None]
        assert sum(len(balls.radii) for balls in painted) == count
        assert list(film.limits.values()) == expected[grains]


def test_a_rare_colour_stays_in_the_palette_of_a_gif():
    """The wire, of a thousandth of the pixels, among 40 000 shades of brown and red: white is exact, and a colour is off by
    16 of 255 at most (seen: 0; by median cut 54)."""
    shades = np.mgrid[60:260, 0:200].transpose(1, 2, 0).clip(0, 255)
    picture = np.concatenate([shades, shades[..., 1:]], axis=2).astype(np.uint8)
    picture[:4, :10] = rgb(WIRE)
    picture[4:8] = 255
    seen = np.array(Image.fromarray(picture).quantize(palette=palette_of(picture), dither=0).convert("RGB"))
    assert (seen[4:8] == 255).all()
    assert np.abs(seen[:4, :10].astype(int) - rgb(WIRE)).max() <= 16


def test_an_mp4_has_all_frames(run_of_a_fall, tmp_path):
    imageio_ffmpeg = pytest.importorskip("imageio_ffmpeg")
    with lm.io.open_run(run_of_a_fall) as run:
        out = lm.view.render(run, tmp_path / "fall.mp4", grains="plain", size=(121, 121), frames_per_second=10.0)
        frames = run.frame_count
    count, seconds = imageio_ffmpeg.count_frames_and_secs(str(out))
    assert count == frames
    assert seconds == pytest.approx(frames / 10.0, rel=0.05)


def test_without_its_encoder_an_mp4_gets_a_sentence(run_of_a_fall, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with lm.io.open_run(run_of_a_fall) as run, pytest.raises(ImportError, match=r'pip install "lmgcpy\[film\]"'):
        lm.view.render(run, tmp_path / "fall.mp4")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["clip", "section", "camera"])
def test_space_is_not_for_the_plane(name, tmp_path):
    with pytest.raises(ValueError, match=f"{name} is for 3D"):
        lm.view.render(pile(1), tmp_path / "a.png", **{name: "y"})


def test_a_window_has_one_panel():
    with pytest.raises(TypeError, match=r"show has one panel: camera must not be a list"):
        lm.view.show(wire_in_a_box(), camera=["x", "y"])


@pytest.mark.parametrize("opacity", [1.0, 0.5])
def test_a_tube_that_is_seen_end_on_is_round(opacity):
    """Corners of the square around it are white, its middle is blue: VTK draws a dark square."""
    for direction in ((0.0, -1.0, 0.0), (0.6, -0.48, 0.64)):
        camera = Camera.looking(direction)
        ends = np.array([camera.towards, -camera.towards])
        tubes = Tubes(ends[:1], ends[1:], np.array([0.5]), Paint(WIRE), opacity=opacity)
        drawing = Drawing(flat=False, balls=[], tubes=[tubes], walls=[], lines=np.zeros((0, 2, 3)), grain=0.5)
        view = View(camera, np.array([-0.5, -0.5, -2.0]), np.array([0.5, 0.5, 2.0]))
        painter = Painter(off_screen=True)
        image = painter.image(drawing, view, 60.0, {}, 1.0).astype(int)
        painter.close()
        assert (image[[2, 2, -3, -3], [2, -3, 2, -3]] > 250).all()
        assert image[30, 30, 2] > image[30, 30, 0] + 20


@pytest.mark.parametrize("settings", [{}, {"font.size": 24.0, "legend.fontsize": 24.0}])
def test_no_word_of_the_legend_is_cut(tmp_path, settings):
    """However narrow the panel is, and whatever the size of letters in a notebook: the margins of the plate are white."""
    from matplotlib import rc_context

    scene = lm.Scene(dimension=2)
    for k, word in enumerate(("WWWWWWWWWWWWWWWW", "MMMMMMMMMMMMMMMMMMMMMMMM", "GRAIN", "OTHER GRAINS")):
        scene.add(lm.disk(radius=0.1, position=(0.0, 0.3 * k), mass=1.0, color=word))
    with rc_context(settings):
        lm.view.render(scene, tmp_path / "a.png", what="grains", grains="color", title="WWWWWWWWWWWWW", size=(40, 100))
    image = pixels(tmp_path / "a.png")
    assert (image[:, :3] == 255).all()
    assert (image[:, -3:] == 255).all()
    words = np.flatnonzero(image[-140:].min(axis=(0, 2)) < 128)
    assert 150 < np.ptp(words) < image.shape[1] - 8


def escaped(where):
    """A hundred grains in a heap of 1 m, and one elsewhere."""
    scene = lm.Scene(dimension=2)
    for k in range(100):
        scene.add(lm.disk(radius=0.04, position=(0.1 * (k % 10), 0.1 * (k // 10)), mass=1.0))
    scene.add(lm.disk(radius=0.04, position=where, mass=1.0))
    return scene


def test_a_body_that_has_escaped_does_not_make_the_others_small(tmp_path):
    with pytest.warns(RuntimeWarning, match=r"body 100 has escaped and is left out of the picture: give region"):
        lm.view.render(escaped((90.0, 3.0)), tmp_path / "a.png", size=SIZE)
    assert min(pixels(tmp_path / "a.png").shape[:2]) >= 290
    drawing = compose(snapshot(escaped((90.0, 3.0))), style_of(dict.fromkeys(OPTIONS), dimension=2, is_scene=True))
    assert sum(len(balls.radii) for balls in drawing.balls) == 100
    lm.view.render(escaped((90.0, 3.0)), tmp_path / "b.png", size=SIZE, region="everything")
    assert pixels(tmp_path / "b.png").shape[0] < 60
    lm.view.render(escaped((2.0, 3.0)), tmp_path / "c.png", size=SIZE)  # not far, without a warning
    with pytest.raises(ValueError, match="region cannot be 'all'"):
        lm.view.render(escaped((2.0, 3.0)), tmp_path / "c.png", region="all")


def test_a_notebook_shows_the_picture(tmp_path):
    """The path that render returns is the picture in the format of its file."""
    for name, kind in (("a.png", "image/png"), ("a.svg", "image/svg+xml"), ("a.pdf", None)):
        path = lm.view.render(pile(3), tmp_path / name, size=(60, 60))
        assert path == tmp_path / name
        bundle = path._repr_mimebundle_()
        assert set(bundle) == {"text/plain", *([kind] if kind else [])}
        if kind == "image/png":
            assert base64.b64decode(bundle[kind]) == path.read_bytes()
