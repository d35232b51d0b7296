"""Style of a panel: what it shows and from where, from the checked options of a user; and the camera that projects it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from lmgcpy.errors import AXES, number, one_of, shown, vector
from lmgcpy.view.drawing import in_space
from lmgcpy.view.quantities import GRAINS, WIRES

MARGIN = 0.03
"""White margin around a panel that shows everything, as part of its longer side."""

SUITABLE = {"layout": ("plain", "length"), "grains": ("speed", "plain"), "forces": ("plain", "plain")}
"""Pictures, and the default quantities of grains and wires in each."""
OPTIONS = ("what", "grains", "wires", "opacity", "clip", "section", "camera", "title", "region")
"""Options of a panel."""

Plane = tuple[int, float | None]
"""Number of the axis, and coordinate [m] or None for the middle."""


@dataclass(frozen=True)
class Camera:
    """A parallel projection: ``right``, ``up`` and ``towards`` the eye are unit vectors at right angles."""

    right: np.ndarray
    up: np.ndarray
    towards: np.ndarray

    @classmethod
    def looking(cls, direction: tuple[float, float, float]) -> Camera:
        """A camera that looks from a direction; z is up, or y if it looks along z."""
        towards = np.array(direction)
        upward = np.array([0.0, 0.0, 1.0]) if abs(towards[2]) < 1.0 - 1e-9 else np.array([0.0, 1.0, 0.0])
        right = np.cross(upward, towards)
        right /= np.linalg.norm(right)
        return cls(right, np.cross(towards, right), towards)

    def on_screen(self, points: np.ndarray) -> np.ndarray:
        """Coordinates of points to the right, upward and towards the eye [m], (k, 3)."""
        return points @ np.column_stack([self.right, self.up, self.towards])


@dataclass(frozen=True)
class View:
    """A camera and the rectangle that it shows."""

    camera: Camera
    low: np.ndarray
    high: np.ndarray
    """Corners of the seen box on the screen [m], (3,): to the right, upward, towards the eye."""

    @classmethod
    def of(cls, camera: Camera, corners: np.ndarray, share: float = MARGIN) -> View:
        """A view that holds points (k, 3) [m], and a margin, a ``share`` of its longer side."""
        seen = camera.on_screen(corners)
        low, high = seen.min(axis=0), seen.max(axis=0)
        margin = share * max(float((high - low)[:2].max()), 1e-300)
        return cls(camera, low - margin, high + margin)

    def joined(self, other: View) -> View:
        """The view that holds both."""
        return View(self.camera, np.minimum(self.low, other.low), np.maximum(self.high, other.high))

    @property
    def width(self) -> float:
        """Width [m]."""
        return float(self.high[0] - self.low[0])

    @property
    def height(self) -> float:
        """Height [m]."""
        return float(self.high[1] - self.low[1])

    @property
    def centre(self) -> np.ndarray:
        """Middle of what is seen, in space [m], (3,)."""
        x, y, z = 0.5 * (self.low + self.high)
        return x * self.camera.right + y * self.camera.up + z * self.camera.towards

    def pixels(self, points: np.ndarray, scale: float) -> np.ndarray:
        """Column and row of points (k, 3) in the image, from its upper left corner, (k, 2); ``scale`` in pixels per m."""
        seen = self.camera.on_screen(points)
        return scale * np.column_stack([seen[:, 0] - self.low[0], self.high[1] - seen[:, 1]])

    def image_size(self, scale: float) -> tuple[int, int]:
        """Width and height of the image in pixels, at least one each."""
        return max(1, round(scale * self.width)), max(1, round(scale * self.height))


@dataclass(frozen=True)
class Style:
    """How one panel shows its source."""

    what: str
    grains: str
    wires: str
    opacity: float | None
    """None: the opacity follows from the sample."""
    clip: Plane | None
    section: Plane | None
    direction: tuple[float, float, float]
    """Unit vector towards the eye; (0, 0, 1) for a flat picture."""
    title: str | None
    """None: the time, if the source has one."""
    region: np.ndarray | None
    """Low and high corner of what is seen, in space [m], (2, 3); None: everything but bodies that have escaped."""
    everything: bool
    """Whether bodies that have escaped are seen."""
    shades: dict[str, str] = field(default_factory=dict)
    """Shades by the colour of the visibility table, in the order in which they were drawn first; panels share them."""


def style_of(options: Mapping[str, Any], *, dimension: int, is_scene: bool) -> Style:
    """A style from a user's :data:`OPTIONS`; an option that is None has the default of the picture.

    The function raises TypeError or ValueError, with a sentence, for impossible options.
    """
    what, grains, wires, opacity, clip, section, camera, title, region = (options[name] for name in OPTIONS)
    what = one_of(("layout" if is_scene else "grains") if what is None else what, "what", SUITABLE)
    grains = one_of(SUITABLE[what][0] if grains is None else grains, "grains", (*GRAINS, "color", "plain", "hidden"))
    wires = one_of(SUITABLE[what][1] if wires is None else wires, "wires", (*WIRES, "plain", "hidden"))
    if opacity is not None:
        opacity = number(opacity, "opacity", minimum=0.0, maximum=1.0)
    if title is not None and not isinstance(title, str):
        raise TypeError(f"title must be a line of text, got {shown(title)}.")
    for name, value in (("clip", clip), ("section", section), ("camera", camera)):
        if value is not None and dimension == 2:
            raise ValueError(f"{name} is for 3D: a picture in 2D shows everything, from the front. Leave it out.")
    if section is not None and camera is not None:
        raise ValueError("camera is of no use with section, which is seen at right angles: leave out one of the two.")
    flat = dimension == 2 or section is not None
    return Style(
        what=what,
        grains=grains,
        wires=wires,
        opacity=opacity,
        clip=_plane(clip, "clip"),
        section=_plane(section, "section"),
        direction=(0.0, 0.0, 1.0) if flat else _direction("isometric" if camera is None else camera),
        title=title,
        region=None if region is None or isinstance(region, str) else _region(region, dimension),
        everything=isinstance(region, str) and one_of(region, "region", ("everything",)) == "everything",
    )


def _plane(value: Any, name: str) -> Plane | None:
    if value is None:
        return None
    if isinstance(value, str):
        return AXES.index(one_of(value, name, AXES)), None
    if not isinstance(value, tuple) or len(value) != 2:
        raise TypeError(f"{name} must be an axis such as 'y', or with a coordinate as ('y', 0.1), got {shown(value)}.")
    axis, at = value
    return AXES.index(one_of(axis, f"the axis of {name}", AXES)), number(at, f"the coordinate of {name}", unit="m")


def _region(value: Any, dimension: int) -> np.ndarray:
    if not isinstance(value, (tuple, np.ndarray)) or len(value) != 2:
        raise TypeError(
            f"region must be a pair of corners such as ((0, 0), (1, 2)) [m], or 'everything', got {shown(value)}; "
            "a list has a region for each panel."
        )
    low, high = (vector(corner, "a corner of region", dimension) for corner in value)
    if not (low < high).all():
        raise ValueError(f"region must be its low corner and its high corner [m], got {shown(value)}.")
    return in_space(np.stack([low, high]))


def _direction(camera: Any) -> tuple[float, float, float]:
    """Unit vector towards the eye: "x" looks from large x, "y" from small y."""
    named = {"isometric": (1.0, -1.0, 1.0), "x": (1.0, 0.0, 0.0), "y": (0.0, -1.0, 0.0), "z": (0.0, 0.0, 1.0)}
    if isinstance(camera, str):
        given = np.array(named[one_of(camera, "camera", named)])
    else:
        given = vector(camera, "camera, where it is a direction,", 3)
    length = float(np.linalg.norm(given))
    if length == 0.0:
        raise ValueError("camera must not be zero: it is the direction from which one looks.")
    x, y, z = (given / length).tolist()
    return x, y, z
