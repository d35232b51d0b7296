"""Parallel projection of points onto the pixels of a panel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

MARGIN = 0.03
"""White margin around a panel that shows everything, as part of its longer side."""


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
