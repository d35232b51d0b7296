"""Panels side by side on one plate, with titles, colour scales and a legend: pixels in, pixels out, by matplotlib."""

from __future__ import annotations

import io
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.view.quantities import Limits, Quantity

DPI = 100
TITLE, LEGEND, BAR = 34, 34, 104
"""Heights of the lines above and below, width of a colour scale [pixels]."""
LETTER = 8
"""Mean width of a letter [pixels]."""


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
    letters: Sequence[int],
    scales: dict[Quantity, Limits],
    legend: Sequence[tuple[str, str]],
    note: str,
    columns: int,
    zoom: float = 1.0,
) -> Plate:
    """Put images (height, width, 3) of uint8 on one plate, with ``columns`` images in a row.

    The images of a row have a common base line, each in the middle of its column. ``letters``: greatest number of letters
    of each column's titles; columns are wide enough for it, so that all plates of a film have one size. ``zoom`` enlarges
    text and colour scales.
    """
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

    letter, line_height, bar, dpi = (round(zoom * pixels) for pixels in (LETTER, LEGEND, BAR, DPI))
    above = round(zoom * TITLE) if any(titles) else 0
    needs = [max(panel.shape[1], letter * (count + 2)) for panel, count in zip(panels, letters, strict=True)]
    widths = [max(needs[k::columns]) for k in range(min(columns, len(panels)))]
    heights = [above + max(p.shape[0] for p in panels[k : k + columns]) for k in range(0, len(panels), columns)]
    entries = [*dict.fromkeys(legend), *([(note, "")] if note else [])]
    lines = _legend_lines(entries, sum(widths), letter)
    tall = sum(heights)
    wide = max([sum(widths) + bar * len(scales), *(letter * (len(label) + 5) for label, _ in entries)])
    height = tall + line_height * len(lines)
    figure = Figure(figsize=(wide / dpi, height / dpi), dpi=dpi)
    corners = []
    for k, (panel, title) in enumerate(zip(panels, titles, strict=True)):
        row, column = divmod(k, columns)
        middle, top = sum(widths[:column]) + 0.5 * widths[column], sum(heights[:row])
        figure.text(middle / wide, 1.0 - (top + 0.5 * above) / height, title, ha="center", va="center")
        corners.append((sum(heights[: row + 1]) - panel.shape[0], round(middle - 0.5 * panel.shape[1])))
    for k, (quantity, limits) in enumerate(scales.items()):
        _scale(figure, quantity, limits, sum(widths) + k * bar, 0.5 * tall, min(0.7 * tall, 500.0 * zoom), zoom)
    for line, together in enumerate(lines):
        handles = [Line2D([], [], color=color or "none", linewidth=4) for _, color in together]
        figure.legend(
            handles,
            [label for label, _ in together],
            loc="center",
            bbox_to_anchor=(0.5, 1.0 - (tall + (line + 0.5) * line_height) / height),
            ncols=len(together),
            frameon=False,
            handlelength=1.4,
        )
    return Plate(figure, list(zip(corners, panels, strict=True)), (height, wide))


def _legend_lines(entries: Sequence[tuple[str, str]], width: int, letter: int) -> list[list[tuple[str, str]]]:
    """Entries of the legend, as many in each line as fit."""
    lines: list[list[tuple[str, str]]] = []
    left = 0
    for label, color in entries:
        need = letter * (len(label) + 5)
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
    bar.set_label(quantity.label)
    bar.outline.set_linewidth(0.5)
    bar.ax.tick_params(width=0.5, labelsize="small")
