"""Panels side by side, picture by picture, at one scale of lengths, colours and forces for all."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from lmgcpy.errors import number, shown, vector
from lmgcpy.view.camera import Camera, View
from lmgcpy.view.compose import compose
from lmgcpy.view.drawing import Drawing
from lmgcpy.view.painter import Painter
from lmgcpy.view.plate import plate
from lmgcpy.view.quantities import Limits, Quantity
from lmgcpy.view.snapshot import Snapshot, frame_number, snapshot
from lmgcpy.view.style import Style, style_of

THICKEST = 0.5
"""Thickness of the force that the scale of forces names, in mean diameters of the grains."""
REFERENCE = 0.999
"""Quantile of the forces that is the scale's, where the user names none."""


@dataclass(frozen=True)
class Panel:
    """One panel through time: what gives its moments, and how it shows them."""

    style: Style
    camera: Camera
    moments: Sequence[Callable[[], Snapshot]]

    def moment(self, k: int) -> Snapshot:
        """Of picture number k, of a panel that stands still the only one."""
        return self.moments[min(k, len(self.moments) - 1)]()


class Film:
    """All pictures of one file: panels, what they have in common, and the plates that they make.

    ``words``: options of the panels by name; ``moving``: whether runs give all their frames.
    """

    def __init__(
        self,
        source: Any,
        frame: Any,
        words: dict[str, Any],
        *,
        moving: bool,
        limits: Any,
        force: Any,
        size: tuple[int, int],
        columns: int | None = None,
    ):
        self.panels = [_panel(one, at, said, moving) for one, at, said in _panels(source, frame, words)]
        self.frame_count = max(len(panel.moments) for panel in self.panels)
        if moving and self.frame_count == 1:
            raise ValueError("A .gif moves: give a run of several frames as source, or a path that ends in .png.")
        self.dimension = self.panels[0].moment(0).dimension
        self.columns = len(self.panels) if columns is None else columns
        self.views: list[View] = []
        self.limits: dict[Quantity, Limits] = {}
        self.force = 0.0
        self.grain = 0.0
        self.legend: list[tuple[str, str]] = []
        self.letters = [0] * len(self.panels)
        """Of the longest title of each panel."""
        self._drawn: tuple[tuple[int, int], Drawing] | None = None
        self._survey()
        self._take_scales(limits, force)
        self.scale = min(min(size[0] / view.width, size[1] / view.height) for view in self.views)

    def _survey(self) -> None:
        """Look at every picture for what they have in common."""
        for number_of_panel, panel in enumerate(self.panels):
            for k in range(len(panel.moments)):
                drawing = self.drawing(number_of_panel, k)
                view = View.of(panel.camera, drawing.bounds())
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
                self.letters[number_of_panel] = max(self.letters[number_of_panel], len(self._title(number_of_panel, k)))
                self.legend += [entry for entry in drawing.legend if entry not in self.legend]

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
            if all(panel.style.what != "forces" for panel in self.panels):
                raise ValueError("force is the scale of a picture of forces: say what='forces', or leave it out.")
            self.force = force

    @property
    def thickness(self) -> float:
        """Radius of a tube over its force [m/N]."""
        return THICKEST * self.grain / self.force if self.force > 0.0 else 0.0

    @property
    def note(self) -> str:
        """What a thickness means."""
        if self.force == 0.0:
            return ""
        from matplotlib.ticker import EngFormatter

        unit = "N/m" if self.dimension == 2 else "N"
        return f"half as thick as a mean grain: {EngFormatter(unit, places=1)(self.force)}"

    def drawing(self, number_of_panel: int, k: int) -> Drawing:
        """What a panel shows in picture number k."""
        panel = self.panels[number_of_panel]
        key = number_of_panel, min(k, len(panel.moments) - 1)
        if self._drawn is None or self._drawn[0] != key:
            self._drawn = key, compose(panel.moment(k), panel.style)
        return self._drawn[1]

    def plate(self, painter: Painter, k: int) -> np.ndarray:
        """Picture number k, (height, width, 3) uint8."""
        images, titles = [], []
        for i, view in enumerate(self.views):
            images.append(painter.image(self.drawing(i, k), view, self.scale, self.limits, self.thickness))
            titles.append(self._title(i, k))
        return plate(images, titles, self.letters, self.limits, self.legend, self.note, self.columns)

    def _title(self, number_of_panel: int, k: int) -> str:
        title, time = self.panels[number_of_panel].style.title, self.drawing(number_of_panel, k).time
        if title is not None:
            return title
        return "" if time is None else f"t = {time:.4g} s"

    def show(self, painter: Painter) -> None:
        """Open the window of the first panel."""
        drawing = self.drawing(0, 0)
        painter.show(drawing, self.views[0], self.limits, self.thickness, self._title(0, 0), self.legend, self.note)


def _panels(source: Any, frame: Any, words: dict[str, Any]) -> Iterator[tuple[Any, Any, dict[str, Any]]]:
    """Source, frame and words of each panel: what is a list has one entry a panel, the rest is the same for all."""
    given = {"source": source, "frame": frame, **words}
    lengths = {name: len(value) for name, value in given.items() if isinstance(value, list)}
    count = max(lengths.values(), default=1)
    for name, length in lengths.items():
        if length != count or length == 0:
            raise ValueError(
                f"Lists give one entry a panel, all as many: {', '.join(f'{n} has {c}' for n, c in lengths.items())}. "
                f"Make {name} as long as the others."
            )
    for i in range(count):
        each = {name: value[i] if isinstance(value, list) else value for name, value in given.items()}
        yield each.pop("source"), each.pop("frame"), each


def _panel(source: Any, frame: Any, words: dict[str, Any], moving: bool) -> Panel:
    is_run = hasattr(source, "frame_count")
    moments: list[Callable[[], Snapshot]]
    if moving and is_run and (frame is None or isinstance(frame, range)):
        chosen = range(source.frame_count) if frame is None else frame
        moments = [partial(snapshot, source, frame_number(source, k)) for k in chosen]
        if not moments:
            raise ValueError(f"frame must name a frame at least, got {shown(frame)}.")
    else:
        one = snapshot(source, frame)
        moments = [lambda: one]
    first = moments[0]()
    style = style_of(words, dimension=first.dimension, is_scene=first.time is None)
    return Panel(style, Camera.looking(style.direction), moments)
