"""Pictures show what they must: pixels of the wire's colour where the wire is, lines as wide as the force."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.colors import to_rgb

from lmgcpy.experiment.biaxial import Frame
from lmgcpy.experiment.box import Sample
from lmgcpy.view import figures


def pixels(figure):
    """The figure as an array (height, width, 3) in [0, 1]."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3] / 255.0


def count(image, color, region=np.s_[:, :]):
    return int((np.abs(image[region] - to_rgb(color)).max(axis=2) < 0.02).sum())


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


def test_chains_are_as_wide_as_the_force_and_the_wire_has_its_color(frame):
    radii = np.full(3, 0.05)
    empty = Frame(0.1, 4000.0, frame.positions, frame.walls, np.zeros((0, 2, 2)), np.zeros(0), np.zeros(0, bool))
    image = pixels(figures.chains_figure(("wire", frame), ("sand", empty), radii, 2))
    height, width, _ = image.shape
    body = np.s_[int(0.1 * height) : int(0.88 * height), :]
    left, right = image[body][:, : width // 2], image[body][:, width // 2 :]
    assert count(left, figures.WIRE) > 100
    assert count(right, figures.WIRE) == 0
    assert count(right, figures.CONTACT) == 0
    # below the wire a line of the contact's color takes away green in proportion to its width
    ink = (1.0 - image[int(0.5 * height) : int(0.6 * height), : width // 2, 1]).mean(axis=0)
    ink[ink < 0.1] = 0.0
    inside = np.flatnonzero(ink)[[0, -1]]
    middle = inside.sum() // 2
    strong, weak = ink[inside[0] + 8 : middle].sum(), ink[middle : inside[1] - 8].sum()  # without the walls
    # edges are blurred and snapped to pixels: 3 to within a tenth
    assert strong / weak == pytest.approx(3.0, rel=0.1)


@pytest.mark.parametrize("height", [1.0, 2.0])
def test_titles_of_force_chains_keep_to_their_half(frame, height):
    """Also over a slender sample, which is narrower than its title."""
    tall = replace(frame, walls=np.array([0.0, 1.0, 0.0, height]))
    figure = figures.chains_figure(("elastic wire", tall), ("elastic rod", tall), np.full(3, 0.05), 2)
    pixels(figure)
    left, right = (axes.title.get_window_extent() for axes in figure.axes)
    width = figure.bbox.width
    assert left.x0 > 0.02 * width
    assert left.x1 < 0.5 * width < right.x0
    assert right.x1 < 0.98 * width


def test_compressed_rods_have_a_color_of_their_own(frame):
    pushed = Frame(
        frame.strain, frame.top_force, frame.positions, frame.walls, frame.lines, np.abs(frame.forces), frame.in_wire
    )
    image = pixels(figures.chains_figure(("rod", pushed), ("sand", pushed), np.full(3, 0.05), 2))
    assert count(image, figures.PUSHING) > 100
    assert count(image, figures.WIRE) < count(image, figures.PUSHING)


def test_sample_shows_the_wire():
    beads = np.array([[0.1, 0.5], [0.5, 0.5], [0.9, 0.5]])
    sample = Sample(np.vstack([beads, [[0.5, 0.9]]]), np.full(4, 0.05), (3,), 0.3, (1.0, 1.0))
    image = pixels(figures.sample_figure(sample))
    height = image.shape[0]
    middle = np.s_[int(0.3 * height) : int(0.7 * height), :]
    assert count(image, figures.WIRE, middle) > 200
    assert count(image, figures.WIRE, np.s_[: int(0.3 * height), :]) == 0
