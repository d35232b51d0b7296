"""Panels of a picture, from a user's sources and options; a list makes several panels."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from lmgcpy.errors import shown
from lmgcpy.io.run import Run
from lmgcpy.view.camera import Camera
from lmgcpy.view.compose import compose
from lmgcpy.view.drawing import Drawing
from lmgcpy.view.snapshot import Snapshot, frame_number, snapshot
from lmgcpy.view.style import Style, style_of


@dataclass(frozen=True)
class Panel:
    """A panel through time."""

    drawings: Sequence[Callable[[], Drawing]]
    """Functions that make the drawings, one for each picture; a panel that does not change has one."""
    camera: Camera
    dimension: int
    """Dimension of the scene, 2 or 3; a section of a scene in 3D is drawn flat."""
    title: str | None = None
    """None: the time, if the drawing has one."""
    shows_forces: bool = False

    def drawing(self, k: int) -> Drawing:
        """Drawing of picture number k."""
        return self.drawings[self.index(k)]()

    def index(self, k: int) -> int:
        """Number of the drawing that picture number k shows."""
        return min(k, len(self.drawings) - 1)


def panels_of(source: Any, frame: Any, options: dict[str, Any], *, moving: bool) -> list[Panel]:
    """The panels that a user asked for. If the picture is ``moving``, runs give all their frames.

    The function raises TypeError or ValueError for what cannot be drawn.
    """
    return [_panel(one, at, said, moving) for one, at, said in _one_by_one(source, frame, options)]


def _one_by_one(source: Any, frame: Any, options: dict[str, Any]) -> Iterator[tuple[Any, Any, dict[str, Any]]]:
    """Source, frame and options of each panel: a list has one entry for each panel, other values hold for all panels."""
    given = {"source": source, "frame": frame, **options}
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


def _panel(source: Any, frame: Any, options: dict[str, Any], moving: bool) -> Panel:
    snapshots: list[Callable[[], Snapshot]]
    if moving and isinstance(source, Run) and (frame is None or isinstance(frame, range)):
        chosen = range(source.frame_count) if frame is None else frame
        snapshots = [partial(snapshot, source, frame_number(source, k)) for k in chosen]
        if not snapshots:
            raise ValueError(f"frame must name a frame at least, got {shown(frame)}.")
    else:
        one = snapshot(source, frame)
        snapshots = [lambda: one]
    first = snapshots[0]()
    style = style_of(options, dimension=first.dimension, is_scene=first.time is None)
    return Panel(
        drawings=[partial(_composed, make, style) for make in snapshots],
        camera=Camera.looking(style.direction),
        dimension=first.dimension,
        title=style.title,
        shows_forces=style.what == "forces",
    )


def _composed(make: Callable[[], Snapshot], style: Style) -> Drawing:
    return compose(make(), style)
