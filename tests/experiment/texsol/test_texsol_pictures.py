"""Pictures of 2D samples show what they must: the wire's colour where the wire is, tubes as thick as the force."""

import sys
from dataclasses import replace

import numpy as np
import pytest
from seen import like, pixels

from lmgcpy.experiment.biaxial import Frame
from lmgcpy.experiment.box import Sample
from lmgcpy.experiment.texsol.pictures import draw_chains, draw_sample, reason_without_pictures
from lmgcpy.view.drawing import CONTACT, PUSHING, WIRE

SIZE = (400, 400)


@pytest.fixture
def frame():
    """Two vertical contact forces, one three times the other, and a horizontal wire."""
    return Frame(
        strain=0.05,
        top_force=4000.0,
        positions=np.array([[0.05, 0.5], [0.95, 0.5], [0.5, 0.1]]),
        walls=np.array([0.0, 1.0, 0.0, 1.0]),
        lines=np.array([[[0.3, 0.0], [0.3, 1.0]], [[0.7, 0.0], [0.7, 1.0]], [[0.3, 0.5], [0.7, 0.5]]]),
        forces=np.array([3000.0, 1000.0, -3000.0]),
        in_wire=np.array([False, False, True]),
    )


def chains(tmp_path, left, right):
    """The picture of two frames, (height, width, 3) of uint8."""
    return pixels(draw_chains(tmp_path / "a.png", left, right, np.full(3, 0.05), 2, size=SIZE))


def test_chains_are_as_thick_as_the_force_and_the_wire_has_its_color(frame, tmp_path):
    empty = Frame(0.1, 4000.0, frame.positions, frame.walls, np.zeros((0, 2, 2)), np.zeros(0), np.zeros(0, bool))
    image = chains(tmp_path, ("wire", frame), ("sand", empty))
    height, width, _ = image.shape
    body = image[int(0.15 * height) : int(0.8 * height)]
    left, right = body[:, : width // 2], body[:, width // 2 :]
    assert like(left, WIRE, 5).sum() > 100
    assert not like(right, WIRE, 5).any()
    assert not like(right, CONTACT, 5).any()
    # Between the wire and the foot a row of pixels crosses the walls, one thick and one thin tube. A tube takes away green
    # in proportion to its thickness.
    ink = 1.0 - image[int(0.65 * height), 20 : width // 2 - 20, 1] / 255.0
    strong, weak = ink[: len(ink) // 2].sum(), ink[len(ink) // 2 :].sum()
    assert strong / weak == pytest.approx(3.0, rel=0.1)  # edges are rounded to half pixels


def test_titles_of_force_chains_keep_to_their_half(frame, tmp_path):
    """Also over a slender sample, which is narrower than its title."""
    tall = replace(frame, walls=np.array([0.0, 1.0, 0.0, 4.0]))
    image = chains(tmp_path, ("elastic wire", tall), ("elastic rod", tall))
    ink = (image[:30] < 150).any(axis=(0, 2))
    middle = image.shape[1] // 2
    assert ink.any()
    assert not ink[:5].any()
    assert not ink[-5:].any()
    assert not ink[middle - 5 : middle + 5].any()


def test_compressed_rods_have_a_color_of_their_own(frame, tmp_path):
    pushed = replace(frame, forces=np.abs(frame.forces))
    image = chains(tmp_path, ("rod", pushed), ("sand", pushed))
    assert like(image, PUSHING, 5).sum() > 100
    assert not like(image, WIRE, 5).any()


def test_sample_shows_the_wire(tmp_path):
    beads = np.array([[0.1, 0.5], [0.5, 0.5], [0.9, 0.5]])
    sample = Sample(np.vstack([beads, [[0.5, 0.9]]]), np.full(4, 0.05), (3,), 0.3, (1.0, 1.0))
    image = pixels(draw_sample(tmp_path / "a.png", sample, size=SIZE))
    wire = like(image, WIRE, 5)
    height = len(wire)
    assert wire[int(0.3 * height) : int(0.7 * height)].sum() > 200
    assert not wire[: int(0.3 * height)].any()


@pytest.mark.long
def test_text_grows_with_a_wide_picture(frame, tmp_path):
    """A panel three times as wide as pictures are read has letters three times as high."""
    beads = np.array([[0.1, 0.5], [0.9, 0.5]])
    sample = Sample(beads, np.full(2, 0.05), (2,), 0.7, (1.0, 1.0))
    heights = []
    for side in (1000, 3000):
        image = pixels(draw_sample(tmp_path / "a.png", sample, size=(side, side)))
        title = image[: len(image) - side]
        rows = np.flatnonzero((title < 100).any(axis=(1, 2)))
        heights.append(np.ptp(rows[rows < 0.9 * len(title)]))
    assert heights[1] / heights[0] == pytest.approx(3.0, rel=0.15)


def test_a_study_says_why_it_has_no_pictures(monkeypatch):
    """Hours of tests must not end in an error because pyvista or OpenGL is missing."""
    monkeypatch.setattr("lmgcpy.view.painter.can_draw", lambda window: False)
    assert reason_without_pictures().startswith("There are no pictures of the sample. No OpenGL was found")
    monkeypatch.setitem(sys.modules, "pyvista", None)
    assert "as pyvista is not installed" in reason_without_pictures()
