"""The part of the view that needs pyvista: it paints a drawing as pixels, or in a window.

Spheres and cylinders are computed pixel by pixel from one vertex each (VTK's sphere and stick mappers). This is exact at
any size, and the fastest method for many of them. With software rendering on two cores, 10 000 spheres of 450 triangles
each take 2.5 s (one mesh) or 4 s (glyphs) to turn in a window of a thousand by a thousand pixels; these take 0.2 to 0.5 s.
"""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from lmgcpy.view.drawing import EDGE, GROUND, Balls, Drawing, Tubes
from lmgcpy.view.quantities import Limits, Quantity
from lmgcpy.view.style import View

MISSING = 'Pictures need pyvista, which is not installed: pip install "lmgcpy[view]".'
FINER = 2
"""Factor by which an image is computed wider and higher than it is; averaging then smooths the edges."""
RIM = 0.07
"""Width of the darker edge of a disk, in mean radii, at most a third of its own radius."""
DARKER = 0.55
"""Factor by which the edge of a disk is darker."""
AMBIENT, DIFFUSE = 0.25, 0.85
"""Ambient light, and diffuse light from the lamps."""
SHADE = 3.0
"""Distance within which neighbours take light from each other (ambient occlusion), in mean radii of the grains. Without it
a dense sample looks flat, as all its spheres are lit alike."""
SHEET = 0.35
"""Opacity of the facets of walls."""
EDGE_WIDTH = 1.2
"""Width of the edges of walls [pixels]."""
TILT = 1e-3
"""Angle by which a tube is turned that would be seen end-on [rad]; it moves its ends by less than a pixel."""
BAR = 0.11
"""Width of a colour scale in a window, as part of the window's."""


def load_pyvista() -> Any:
    """The module pyvista; ImportError with a sentence if it is missing."""
    try:
        import pyvista
    except ImportError as error:
        raise ImportError(MISSING) from error
    return pyvista


@contextmanager
def quiet() -> Iterator[None]:
    """Suppress VTK's message about a missing X server, after which it draws without one."""
    from vtkmodules.vtkCommonCore import vtkLogger

    before = vtkLogger.GetCurrentVerbosityCutoff()
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    try:
        yield
    finally:
        vtkLogger.SetStderrVerbosity(before)


def has_display() -> bool:
    """Whether a window can be opened, as far as the environment tells."""
    return not sys.platform.startswith("linux") or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def can_draw(window: Any) -> bool:
    """Whether OSMesa is installed, if VTK fell back to it: drawing without the library ends the process."""
    if window.GetClassName() != "vtkOSOpenGLRenderWindow":
        return True
    for name in ("libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so", "osmesa.dll"):
        try:
            ctypes.CDLL(name)
        except OSError:
            continue
        return True
    return False


def not_end_on(along: np.ndarray, towards: np.ndarray) -> np.ndarray:
    """Unit vectors (k, 3), turned by :data:`TILT` if they point ``towards`` the eye or away from it: VTK draws a stick that
    is seen exactly end-on as a dark square."""
    across = np.cross(towards, np.eye(3)[np.argmin(np.abs(towards))])
    end_on = np.linalg.norm(np.cross(along, towards), axis=1) < TILT
    turned = along + TILT * across / np.linalg.norm(across)
    return np.where(end_on[:, None], turned / np.linalg.norm(turned, axis=1, keepdims=True), along)


class NoOpenGL(OSError):
    """There is no OpenGL to draw with on this machine."""


class Painter:
    """Paints drawings into one plotter, one after the other."""

    def __init__(self, *, off_screen: bool):
        pyvista = load_pyvista()
        with quiet():
            self.plotter = pyvista.Plotter(off_screen=off_screen, lighting="light kit")
        if not can_draw(self.plotter.render_window):
            raise NoOpenGL(
                "No OpenGL was found to draw with: install Mesa's EGL or OSMesa (on Debian and Ubuntu libegl1 with "
                "libgl1-mesa-dri, or libosmesa6)."
            )
        self.plotter.set_background("white")
        self.plotter.enable_parallel_projection()
        if off_screen:  # balls are sorted by depth, which is exact; VTK's order-independent mixing is not
            self.plotter.renderer.SetUseOIT(False)

    def close(self) -> None:
        """Close the plotter."""
        self.plotter.close()

    def image(
        self,
        drawing: Drawing,
        view: View,
        scale: float,
        limits: dict[Quantity, Limits],
        thickness: float,
        zoom: float = 1.0,
    ) -> np.ndarray:
        """The view's rectangle, (height, width, 3) uint8; ``scale`` [pixels/m], ``thickness`` of forces [m/N]. ``zoom``
        enlarges the edges of walls."""
        plotter = self.plotter
        width, height = view.image_size(scale)
        plotter.window_size = [FINER * width, FINER * height]
        forward = self.draw(drawing, limits, thickness, view.camera.towards, finer=FINER * zoom)
        solid = all(balls.opacity == 1.0 for balls in drawing.balls)
        if drawing.flat or not solid:
            plotter.disable_ssao()
        else:
            plotter.enable_ssao(radius=SHADE * drawing.grain, bias=0.5 * drawing.grain, kernel_size=64)
        depth = float(view.high[2] - view.low[2]) + 2.0 * forward
        camera = plotter.camera
        camera.focal_point = view.centre
        camera.position = view.centre + 2.0 * depth * view.camera.towards
        camera.up = view.camera.up
        camera.parallel_scale = 0.5 * height / scale
        camera.clipping_range = (0.5 * depth, 4.0 * depth)
        plotter.render()
        pixels = plotter.screenshot(return_img=True)[..., :3]
        return pixels.reshape(height, FINER, width, FINER, 3).mean(axis=(1, 3)).astype(np.uint8)

    def draw(
        self,
        drawing: Drawing,
        limits: dict[Quantity, Limits],
        thickness: float,
        towards: np.ndarray,
        finer: float = 1.0,
    ) -> float:
        """Replace the former drawing by this one. Translucent balls are sorted from the back ``towards`` the eye, so that
        their colours mix correctly. Returns the height of the levels of a flat drawing towards the eye [m]."""
        plotter = self.plotter
        plotter.clear_actors()
        largest = max((balls.radii.max(initial=0.0) for balls in drawing.balls), default=0.0)
        step = 5.0 * max(largest, 0.2 * drawing.grain) if drawing.flat else 0.0
        for balls in drawing.balls:
            if drawing.flat:
                self._add_disks(balls, balls.paint.rgb(len(balls.radii), limits), drawing.grain, step)
            else:
                ordered = balls.take(np.argsort(balls.centres @ towards, kind="stable")) if balls.opacity < 1.0 else balls
                colors = ordered.paint.rgb(len(ordered.radii), limits)
                self._add_balls(ordered.centres, ordered.radii, colors, ordered.opacity, 0.0, flat=False)
        for tubes in drawing.tubes:
            if tubes.opacity < 1.0 and not drawing.flat:
                tubes = tubes.take(np.argsort((tubes.starts + tubes.ends) @ towards, kind="stable"))
            radii = thickness * tubes.radii if tubes.by_force else tubes.radii
            colors = tubes.paint.rgb(len(radii), limits)
            self._add_tubes(tubes, radii, colors, tubes.level * step, flat=drawing.flat, towards=towards)
        self._add_walls(drawing, finer, towards)
        return 4.0 * step

    def _add_disks(self, balls: Balls, colors: np.ndarray, grain: float, step: float) -> None:
        """Add disks with darker edges. Translucent disks are pale, as only white is behind them."""
        if balls.opacity == 0.0:
            return
        edges = DARKER * colors if balls.rim else colors
        pale, edges = (255.0 - balls.opacity * (255.0 - shade) for shade in (colors.astype(float), edges))
        up = balls.level * step
        self._add_balls(balls.centres, balls.radii, edges.astype(np.uint8), 1.0, up - 0.5 * step, flat=True)
        inner = np.maximum(balls.radii - RIM * grain, 2.0 / 3.0 * balls.radii)
        self._add_balls(balls.centres, inner, pale.astype(np.uint8), 1.0, up, flat=True)

    def _add_balls(
        self, centres: np.ndarray, radii: np.ndarray, colors: np.ndarray, opacity: float, up: float, *, flat: bool
    ) -> None:
        from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLSphereMapper

        if not len(radii) or opacity == 0.0:
            return
        points = self._points(centres, colors, up, radius=radii)
        mapper = vtkOpenGLSphereMapper()
        mapper.SetScaleArray("radius")
        self._add(mapper, points, opacity, flat)

    def _add_tubes(
        self, tubes: Tubes, radii: np.ndarray, colors: np.ndarray, up: float, *, flat: bool, towards: np.ndarray
    ) -> None:
        from vtkmodules.vtkRenderingOpenGL2 import vtkOpenGLStickMapper

        along = tubes.ends - tubes.starts
        length = np.linalg.norm(along, axis=1)
        kept = (length > 0.0) & (radii > 0.0)
        if not kept.any():
            return
        along, length, radii, colors = along[kept] / length[kept, None], length[kept], radii[kept], colors[kept]
        starts, ends = tubes.starts[kept], tubes.ends[kept]
        points = self._points(
            0.5 * (starts + ends),
            colors,
            up,
            along=not_end_on(along, towards),
            size=np.column_stack([length, radii, np.zeros(len(radii))]),
            number=np.arange(len(radii)),
        )
        mapper = vtkOpenGLStickMapper()
        mapper.SetOrientationArray("along")
        mapper.SetScaleArray("size")
        mapper.SetSelectionIdArray("number")
        opacity = 1.0 if flat else tubes.opacity
        self._add(mapper, points, opacity, flat)
        if opacity < 1.0:  # round ends would show twice
            return
        both = np.concatenate([starts, ends])
        self._add_balls(both, np.tile(radii, 2), np.tile(colors, (2, 1)), 1.0, up, flat=flat)

    def _points(self, centres: np.ndarray, colors: np.ndarray, up: float, **arrays: np.ndarray) -> Any:
        """A cloud of points with arrays."""
        points = load_pyvista().PolyData((centres + np.array([0.0, 0.0, up])).astype(np.float32))
        for name, values in arrays.items():
            points[name] = values.astype(np.float32 if values.dtype.kind == "f" else np.int64)
        points["color"] = colors
        return points

    def _add(self, mapper: Any, points: Any, opacity: float, flat: bool) -> None:
        from vtkmodules.vtkRenderingCore import vtkActor

        mapper.SetInputData(points)
        mapper.SetScalarModeToUsePointFieldData()
        mapper.SelectColorArray("color")
        mapper.SetColorModeToDirectScalars()
        actor = vtkActor()
        actor.SetMapper(mapper)
        look = actor.GetProperty()
        look.SetOpacity(opacity)
        look.SetLighting(not flat)
        look.SetAmbient(0.0 if flat else AMBIENT)
        look.SetDiffuse(1.0 if flat else DIFFUSE)
        self.plotter.add_actor(actor, reset_camera=False, render=False)

    def _add_walls(self, drawing: Drawing, finer: float, towards: np.ndarray) -> None:
        pyvista = load_pyvista()
        for polygon in drawing.ground:
            face = pyvista.PolyData(polygon, faces=[len(polygon), *range(len(polygon))])
            self.plotter.add_mesh(face, color=GROUND, lighting=False, reset_camera=False, render=False)
        for pieces, opacity in ((drawing.solids, 1.0), (drawing.sheets, SHEET)):
            if not pieces:
                continue
            ordered = sorted(pieces, key=lambda piece: float(piece.mean(axis=0) @ towards))
            first = np.cumsum([0, *map(len, ordered)])
            faces = [n for k, piece in enumerate(ordered) for n in (len(piece), *range(first[k], first[k + 1]))]
            surface = pyvista.PolyData(np.concatenate(ordered), faces=faces)
            self.plotter.add_mesh(surface, color=GROUND, opacity=opacity, reset_camera=False, render=False)
        if len(drawing.lines):
            count = len(drawing.lines)
            lines = np.column_stack([np.full(count, 2), np.arange(2 * count).reshape(-1, 2)]).ravel()
            mesh = pyvista.PolyData(drawing.lines.reshape(-1, 3), lines=lines)
            self.plotter.add_mesh(
                mesh, color=EDGE, line_width=EDGE_WIDTH * finer, lighting=False, reset_camera=False, render=False
            )

    def show(
        self,
        drawing: Drawing,
        view: View,
        limits: dict[Quantity, Limits],
        thickness: float,
        title: str,
        legend: list[tuple[str, str]],
        note: str,
    ) -> None:
        """Open the window, and return when it is closed."""
        pyvista, plotter = load_pyvista(), self.plotter
        self.draw(drawing, limits, thickness, view.camera.towards)
        column = max(2, len(limits)) * BAR  # to the right of the picture
        for k, (quantity, (low, high)) in enumerate(limits.items()):
            mapper = pyvista.DataSetMapper()
            steps = quantity.bands or 256
            mapper.lookup_table = pyvista.LookupTable(quantity.map(), n_values=steps, scalar_range=(low, high))
            plotter.add_scalar_bar(
                quantity.label.replace(" [", "\n["),
                mapper=mapper,
                vertical=True,
                color="black",
                n_labels=5,
                fmt="%.4g",
                position_x=1.0 - column + k * BAR,
                position_y=0.05,
                width=0.4 * BAR,
                height=0.6,
                title_font_size=16,
                label_font_size=14,
                unconstrained_font_size=True,
            )
        if legend:
            labels = [list(entry) for entry in legend]
            size = (column - 0.02, 0.03 * len(legend))
            plotter.add_legend(labels, bcolor=None, face="rectangle", loc="upper right", size=size)
        if title or note:
            plotter.add_text("\n".join(filter(None, (title, note))), position="upper_left", font_size=10, color="black")
        wide = plotter.window_size[0] / plotter.window_size[1]
        half = max(0.53 * view.height, 0.5 * view.width / (wide * (1.0 - column)))
        plotter.camera.focal_point = view.centre + column * half * wide * view.camera.right
        plotter.camera.position = plotter.camera.focal_point + view.camera.towards * (view.width + view.height)
        plotter.camera.up = view.camera.up
        plotter.camera.parallel_scale = half
        plotter.reset_camera_clipping_range()
        if drawing.flat:
            plotter.enable_image_style()
        plotter.show()
