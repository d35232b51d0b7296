"""Panels side by side, picture by picture, at one scale of lengths, colours and forces for all."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.errors import number, shown, vector, warn
from lmgcpy.view.compose import Panel
from lmgcpy.view.drawing import Drawing
from lmgcpy.view.painter import Painter
from lmgcpy.view.quantities import Limits, Quantity
from lmgcpy.view.style import MARGIN, View

THICKEST = 0.5
"""Thickness of the force that the scale of forces names, in mean diameters of the grains."""
REFERENCE = 0.999
"""Quantile of the forces that the scale shows if the user gives no force."""
THICKEST_BAR = 22.0
"""Greatest thickness of the bar of forces in the legend [pixels]."""
BLACK = "#000000"
SHOWN = 5
"""Escaped bodies that a warning names."""
READ_WIDTH = 1000.0
"""Width at which pictures are read [pixels]. Text and thin lines of a wider picture grow with it."""
DPI = 100
TITLE, LEGEND, BAR = 34, 34, 104
"""Heights of the lines above and below, width of a colour scale [pixels]."""
FONT = 10.0
"""Size of the letters, whatever the settings of matplotlib are [points]."""
HANDLE = 60.0
"""Width of the colour of an entry of the legend and of the gaps beside it [pixels]."""


class Film:
    """All pictures of one file: panels, the scales that they share, and the plates that they make.

    ``limits``: ends of the colour scale, by default from the values; ``force``: the force that is drawn half as thick as a
    mean grain [N]; ``size``: largest width and height of a panel [pixels]; ``columns``: panels in a row, by default all.
    """

    def __init__(
        self,
        panels: Sequence[Panel],
        *,
        size: tuple[int, int],
        limits: Any = None,
        force: Any = None,
        columns: int | None = None,
    ):
        self.panels = panels
        self.frame_count = max(len(panel.drawings) for panel in panels)
        self.dimension = panels[0].dimension
        self.columns = len(panels) if columns is None else columns
        self.views: list[View] = []
        self.limits: dict[Quantity, Limits] = {}
        self.force = 0.0
        self.grain = 0.0
        self.legend: list[tuple[str, str]] = []
        self.escaped: set[int] = set()
        """Ids of the bodies that are left out, as they have escaped."""
        self.words = [0.0] * len(panels)
        """Width of the widest title of each panel [pixels]."""
        self._drawn: tuple[tuple[int, int], Drawing] | None = None
        self._survey()
        if self.escaped:
            ids = ", ".join(map(str, sorted(self.escaped)[:SHOWN])) + (", ..." if len(self.escaped) > SHOWN else "")
            some = f"body {ids} has escaped and is" if len(self.escaped) == 1 else f"bodies {ids} have escaped and are"
            warn(
                f"Far from all others, {some} left out of the picture: give region='everything' to see all, or "
                "region=(low, high)."
            )
        self._take_scales(limits, force)
        self.scale = min(min(size[0] / view.width, size[1] / view.height) for view in self.views)
        """Pixels for each metre."""
        row = sum(view.width for view in self.views[: self.columns])
        self.zoom = max(1.0, self.scale * row / READ_WIDTH)
        """Factor by which text and thin lines are enlarged."""

    def _survey(self) -> None:
        """Look at every picture for the scales, views and legend that they share."""
        for number_of_panel, panel in enumerate(self.panels):
            seen = False
            for k in range(len(panel.drawings)):
                drawing = self.drawing(number_of_panel, k)
                seen = seen or drawing.region is None or not drawing.empty
                view = View.of(panel.camera, drawing.bounds(), MARGIN if drawing.region is None else 0.0)
                if k == 0:
                    self.views.append(view)
                else:
                    self.views[-1] = self.views[-1].joined(view)
                for paint in drawing.paints():
                    if paint.quantity is not None and paint.values is not None:
                        found = paint.quantity.limits(paint.values)
                        low, high = self.limits.get(paint.quantity, found)
                        self.limits[paint.quantity] = min(low, found[0]), max(high, found[1])
                forces = drawing.forces()
                if len(forces):
                    self.force = max(self.force, float(np.quantile(forces, REFERENCE)))
                self.grain = max(self.grain, drawing.grain)
                self.escaped.update(drawing.escaped.tolist())
                title = self._title(number_of_panel, k)
                self.words[number_of_panel] = max(self.words[number_of_panel], width_of(title))
                self.legend += [entry for entry in drawing.legend if entry not in self.legend]
            if not seen:
                raise ValueError("Nothing is to be seen in the region: give other corners.")
        self.force = float(f"{self.force:.2g}")

    def _take_scales(self, limits: Any, force: Any) -> None:
        if limits is not None:
            low, high = vector(limits, "limits", 2)
            if not self.limits:
                raise ValueError("limits are of a colour scale, and this picture has none: leave them out.")
            if not low < high:
                raise ValueError(f"limits must be (low, high) with low below high, got {shown(limits)}.")
            self.limits[next(iter(self.limits))] = float(low), float(high)
        if force is not None:
            force = number(force, "force", above=0.0, unit="N")
            if not any(panel.shows_forces for panel in self.panels):
                raise ValueError("force is the scale of a picture of forces: say what='forces', or leave it out.")
            self.force = force

    @property
    def thickness(self) -> float:
        """Radius of a tube over its force [m/N]."""
        return THICKEST * self.grain / self.force if self.force > 0.0 else 0.0

    @property
    def note(self) -> str:
        """The line that says what a thickness means."""
        if self.force == 0.0:
            return ""
        return f"half as thick as a mean grain: {self._of(self.force)}"

    def drawing(self, number_of_panel: int, k: int) -> Drawing:
        """Drawing of a panel in picture number k."""
        panel = self.panels[number_of_panel]
        key = number_of_panel, panel.index(k)
        if self._drawn is None or self._drawn[0] != key:
            self._drawn = key, panel.drawing(k)
        return self._drawn[1]

    def plate(self, painter: Painter, k: int) -> Plate:
        """Picture number k."""
        images, titles = [], []
        for i, view in enumerate(self.views):
            images.append(painter.image(self.drawing(i, k), view, self.scale, self.limits, self.thickness, self.zoom))
            titles.append(self._title(i, k))
        return plate(images, titles, self.words, self.limits, self.legend, self.bar, self.columns, self.zoom)

    @property
    def bar(self) -> tuple[str, float] | None:
        """A force in words, and the thickness with which it is drawn [pixels]: as large as the legend has room for."""
        if self.force == 0.0:
            return None
        force, thick, most = self.force, 2.0 * THICKEST * self.grain * self.scale, THICKEST_BAR * self.zoom
        halvings = max(0, math.ceil(math.log2(thick / most)))
        return f"a force of {self._of(force / 2.0**halvings)}", thick / 2.0**halvings

    def _of(self, force: float) -> str:
        from matplotlib.ticker import EngFormatter

        return EngFormatter("N/m" if self.dimension == 2 else "N")(float(f"{force:.3g}"))

    def _title(self, number_of_panel: int, k: int) -> str:
        title, time = self.panels[number_of_panel].title, self.drawing(number_of_panel, k).time
        if title is not None:
            return title
        return "" if time is None else f"t = {time:.4g} s"

    def show(self, painter: Painter) -> None:
        """Open the window of the first panel."""
        drawing = self.drawing(0, 0)
        painter.show(drawing, self.views[0], self.limits, self.thickness, self._title(0, 0), self.legend, self.note)


# -------------------------------------------------------------------------------- words, scales and legend, by matplotlib


@dataclass(frozen=True)
class Plate:
    """Words, scales and legend as a matplotlib figure, and the images on it with their upper left corners [pixels]."""

    figure: Any
    images: list[tuple[tuple[int, int], np.ndarray]]
    size: tuple[int, int]
    """Height and width [pixels]."""

    def pixels(self) -> np.ndarray:
        """The whole plate, (height, width, 3) uint8."""
        from matplotlib.backends.backend_agg import FigureCanvasAgg

        canvas = FigureCanvasAgg(self.figure)
        canvas.draw()
        height, wide = self.size
        image = np.array(canvas.buffer_rgba())[:height, :wide, :3]
        for (top, left), panel in self.images:
            image[top : top + panel.shape[0], left : left + panel.shape[1]] = panel
        return image

    def document(self, kind: str) -> bytes:
        """The plate as "pdf" or "svg": words as lines, bodies as pixels."""
        height, wide = self.size
        for (top, left), panel in self.images:
            tall, broad = panel.shape[:2]
            place = left / wide, 1.0 - (top + tall) / height, broad / wide, tall / height
            axes = self.figure.add_axes(place)
            axes.imshow(panel, interpolation="none", aspect="auto")
            axes.set_axis_off()
        memory = io.BytesIO()
        self.figure.savefig(memory, format=kind, dpi=self.figure.dpi)
        return memory.getvalue()


def plate(
    panels: Sequence[np.ndarray],
    titles: Sequence[str],
    words: Sequence[float],
    scales: dict[Quantity, Limits],
    legend: Sequence[tuple[str, str]],
    force: tuple[str, float] | None,
    columns: int,
    zoom: float = 1.0,
) -> Plate:
    """Put images (height, width, 3) of uint8 on one plate, with ``columns`` images in a row.

    The images of a row have a common base line, each in the middle of its column. ``force``: entry of the legend for
    the scale of forces, and the thickness of its bar [pixels]. ``words``: width of the widest
    title of each panel [pixels]; columns are wide enough for it, so that all plates of a film have one size. ``zoom``
    enlarges text and colour scales.
    """
    from matplotlib.figure import Figure

    line_height, bar, dpi = (round(zoom * pixels) for pixels in (LEGEND, BAR, DPI))
    above = round(zoom * TITLE) if any(titles) else 0
    needs = [
        max(panel.shape[1], math.ceil(zoom * (title + 2.0 * FONT))) for panel, title in zip(panels, words, strict=True)
    ]
    widths = [max(needs[k::columns]) for k in range(min(columns, len(panels)))]
    heights = [above + max(p.shape[0] for p in panels[k : k + columns]) for k in range(0, len(panels), columns)]
    entries = [*dict.fromkeys(legend), *([(force[0], BLACK)] if force else [])]
    needed = [math.ceil(zoom * (width_of(label) + HANDLE)) for label, _ in entries]
    lines = _legend_lines(entries, needed, sum(widths))
    tall = sum(heights)
    wide = max([sum(widths) + bar * len(scales), *needed])
    height = tall + line_height * len(lines)
    figure = Figure(figsize=(wide / dpi, height / dpi), dpi=dpi)
    corners = []
    for k, (panel, title) in enumerate(zip(panels, titles, strict=True)):
        row, column = divmod(k, columns)
        middle, top = sum(widths[:column]) + 0.5 * widths[column], sum(heights[:row])
        at = middle / wide, 1.0 - (top + 0.5 * above) / height
        figure.text(*at, title, ha="center", va="center", fontsize=FONT)
        corners.append((sum(heights[: row + 1]) - panel.shape[0], round(middle - 0.5 * panel.shape[1])))
    for k, (quantity, limits) in enumerate(scales.items()):
        _scale(figure, quantity, limits, sum(widths) + k * bar, 0.5 * tall, min(0.7 * tall, 500.0 * zoom), zoom)
    for line, together in enumerate(lines):
        handles = [_sample(entry, force, dpi) for entry in together]
        figure.legend(
            handles,
            [label for label, _ in together],
            loc="center",
            bbox_to_anchor=(0.5, 1.0 - (tall + (line + 0.5) * line_height) / height),
            ncols=len(together),
            frameon=False,
            handlelength=1.4,
            fontsize=FONT,
        )
    return Plate(figure, list(zip(corners, panels, strict=True)), (height, wide))


def _sample(entry: tuple[str, str], force: tuple[str, float] | None, dpi: int) -> Any:
    """The line beside an entry of the legend; for the scale of forces as thick as its force."""
    from matplotlib.lines import Line2D

    label, color = entry
    thick = 72.0 * force[1] / dpi if force is not None and label == force[0] else 4.0
    return Line2D([], [], color=color or "none", linewidth=thick, solid_capstyle="butt")


def width_of(text: str) -> float:
    """Width of a line of text in a picture that is not enlarged [pixels]."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    if not text.strip():
        return 0.0
    path = TextPath((0.0, 0.0), text, prop=FontProperties(size=FONT))
    return float(path.get_extents().x1) * DPI / 72.0


def _legend_lines(entries: Sequence[tuple[str, str]], needed: Sequence[int], width: int) -> list[list[tuple[str, str]]]:
    """Entries of the legend, as many in each line as fit; ``needed``: their widths [pixels]."""
    lines: list[list[tuple[str, str]]] = []
    left = 0
    for (label, color), need in zip(entries, needed, strict=True):
        if not lines or need > left:
            lines.append([])
            left = width
        lines[-1].append((label, color))
        left -= need
    return lines


def _scale(figure: Any, quantity: Quantity, limits: Limits, left: float, middle: float, height: float, zoom: float) -> None:
    """A colour scale with its label and unit; ``left``, ``middle`` and ``height`` in pixels, from the upper left corner."""
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    wide, tall = figure.bbox.width, figure.bbox.height
    x, y = left + 8.0 * zoom, middle + 0.5 * height
    axes = figure.add_axes((x / wide, 1.0 - y / tall, 18.0 * zoom / wide, height / tall))
    low, high = limits
    beyond = "neither" if not quantity.outliers else "both" if quantity.scale == "both" else "max"
    colors = ScalarMappable(Normalize(low, high if high > low else low + 1.0), quantity.map())
    bar = figure.colorbar(colors, cax=axes, extend=beyond)
    bar.set_label(quantity.label, fontsize=FONT)
    bar.outline.set_linewidth(0.5)
    bar.ax.tick_params(width=0.5, labelsize=0.83 * FONT)
