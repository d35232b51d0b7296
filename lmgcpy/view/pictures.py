"""Pictures: into a file without a display, or in a window."""

from __future__ import annotations

import base64
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from lmgcpy.errors import file_path, named_arguments, number, shown, vector, whole
from lmgcpy.view.compose import panels_of
from lmgcpy.view.film import Film
from lmgcpy.view.painter import Painter, has_display, load_pyvista
from lmgcpy.view.style import OPTIONS
from lmgcpy.writing import check_target, new_file, write_bytes

STILL, MOVING = (".png", ".pdf", ".svg"), (".gif", ".mp4")
"""Kinds of files."""
SHOWN_BY_NOTEBOOKS = (".png", ".gif", ".mp4")
SIZE, SIZE_OF_GIF = (1000, 900), (600, 540)
"""Largest size of a panel [pixels], of a picture and of one that moves."""


class Picture(type(Path())):  # type: ignore[misc]
    """The path of a picture; a notebook shows the picture."""

    def _repr_mimebundle_(self, include: Any = None, exclude: Any = None) -> dict[str, str]:
        """The picture in the format of its file; of a PDF, which notebooks do not show, its path alone."""
        bundle, kind = {"text/plain": str(self)}, self.suffix.lower()
        if kind == ".svg":
            return {**bundle, "image/svg+xml": self.read_text(encoding="utf-8")}
        if kind not in SHOWN_BY_NOTEBOOKS:
            return bundle
        content = base64.b64encode(self.read_bytes()).decode("ascii")
        if kind == ".mp4":
            return {**bundle, "text/html": f'<video controls loop src="data:video/mp4;base64,{content}"></video>'}
        return {**bundle, f"image/{kind[1:]}": content}


@named_arguments
def render(
    source: Any,
    path: str | os.PathLike,
    *,
    what: Any = None,
    frame: Any = None,
    grains: Any = None,
    wires: Any = None,
    opacity: Any = None,
    clip: Any = None,
    section: Any = None,
    camera: Any = None,
    title: Any = None,
    limits: Any = None,
    force: float | None = None,
    region: Any = None,
    size: Any = None,
    columns: int | None = None,
    frames_per_second: float = 20.0,
) -> Path:
    """Draw a scene, a simulation or a run into a PNG, PDF or SVG file, or a run into a GIF or MP4 that moves; no display
    is needed.

    ``source``: a Scene, a Simulation, or a run that ``lmgcpy.io.open_run`` opened, of which ``frame`` is shown, by default
    the last (negative: from the end). A ``path`` that ends in .gif or .mp4 shows all frames of a run, or the frames of a
    ``range`` that is given as ``frame``, at ``frames_per_second``. In .pdf and .svg words and scales are lines that can be
    edited, and bodies are pixels. A file of that name is replaced, as by ``savefig``: a picture can be drawn again, which a
    run cannot. Returns the path, which a notebook shows as the picture.

    ``what``, by default "layout" of a scene and "grains" of the others:

    * "layout": before a run. Wires as tubes, grains translucent if there are wires, and in red what :func:`check` finds:
      bodies that overlap and links longer than their reference;
    * "grains": grains by speed;
    * "forces": force chains as tubes as thick as the normal force: contacts in red, wires in tension in blue, links in
      compression in orange. A wire without force is pale.

    Options say how each of these shows bodies and wires:

    * ``grains``, what their colour means: "speed", "spin", "rotation" (2D), "coordination", "radius", "layer" (height at
      the start), "color" (of the visibility table), "plain", or "hidden";
    * ``wires``: "length" (of arc, along each chain), "tension", "layer", "plain" or "hidden";
    * ``opacity`` of the grains in [0, 1];
    * ``clip``: an axis "x", "y", "z" or a pair (axis, coordinate [m]), by default the middle: the grains on the near side
      of this plane are left out;
    * ``section``, the same in 3D: what the plane cuts, flat: disks of the grains, and wires and forces beside it;
    * ``camera`` in 3D: "isometric", "x", "y", "z", or the direction (x, y, z) from which one looks, in parallel projection;
    * ``title``: a line above, by default the time, for a simulation or a run;
    * ``region`` [m]: low and high corner of what is seen, ((x, y), (x, y)), in 3D with z: bodies and forces beyond it are
      left out, and do not count for the scales; by default everything but single bodies that have escaped far from all
      others, with a warning; "everything" shows these, too;
    * ``limits``: (low, high) of the colour scale, of the grains if they have one, else of the wires; by default from the
      smallest to the largest value, of speeds, spins and rotations up to their 99 % quantile;
    * ``force`` [N]: the force that is drawn half as thick as a mean grain, by default the 99.9 % quantile of those drawn,
      to two digits.

    **Panels.** ``source``, ``what``, ``frame``, ``grains``, ``wires``, ``opacity``, ``clip``, ``section``, ``camera``,
    ``title`` and ``region`` may be lists of one length, one entry a panel: panels stand side by side, ``columns`` of them
    in a row (by default all), at one scale of lengths, colours and forces. Examples::

        lm.view.render(scene, "wire.png", grains="hidden", camera=["isometric", "x"])
        titles = ["sand", "TexSol"]
        lm.view.render([sand, texsol], "chains.png", what="forces", title=titles)
        lm.view.render(run, "before-after.png", grains="layer", frame=[0, -1])
        lm.view.render(run, "fall.gif")

    ``size``: pixels (width, height) that no panel exceeds, by default (1000, 900), of a moving picture (600, 540).

    The function raises ImportError if pyvista, or imageio-ffmpeg for .mp4, is missing, and says how to install it; OSError
    without any OpenGL; ValueError or TypeError for what cannot be drawn.
    """
    target = Path(file_path(path, "path"))
    kind = target.suffix.lower()
    moving = kind in MOVING
    if not moving and kind not in STILL:
        raise ValueError(
            f"path must end in {', '.join(STILL)} or, for a moving picture, in {' or '.join(MOVING)}, got '{target}'."
        )
    if kind == ".mp4":
        load_encoder()
    check_target(target, force=True)
    size = _size(size, moving)
    if columns is not None:
        columns = whole(columns, "columns", minimum=1)
    number(frames_per_second, "frames_per_second", above=0.0, maximum=100.0)
    options = dict(zip(OPTIONS, (what, grains, wires, opacity, clip, section, camera, title, region), strict=True))
    load_pyvista()
    panels = panels_of(source, frame, options, moving=moving)
    if moving and all(len(panel.drawings) == 1 for panel in panels):
        raise ValueError(f"A {kind} moves: give a run of several frames as source, or a path that ends in .png.")
    film = Film(panels, limits=limits, force=force, size=size, columns=columns)
    return Picture(write_film(film, target, frames_per_second))


@named_arguments
def show(
    source: Any,
    *,
    what: Any = None,
    frame: int | None = None,
    grains: Any = None,
    wires: Any = None,
    opacity: Any = None,
    clip: Any = None,
    section: Any = None,
    camera: Any = None,
    title: Any = None,
    limits: Any = None,
    force: float | None = None,
    region: Any = None,
) -> None:
    """Show a scene, a simulation or a run in a window, which the mouse turns, or in a notebook.

    Arguments are as for :func:`render`, with one panel. The function returns when the window is closed, and raises OSError
    if there is no display.
    """
    given = (what, grains, wires, opacity, clip, section, camera, title, region)
    for name, value in zip((*OPTIONS, "source", "frame"), (*given, source, frame), strict=True):
        if isinstance(value, (list, range)):
            raise TypeError(f"show has one panel: {name} must not be a list, got {shown(value)}.")
    panels = panels_of(source, frame, dict(zip(OPTIONS, given, strict=True)), moving=False)
    film = Film(panels, limits=limits, force=force, size=SIZE)
    painter = Painter(off_screen=False)
    if not (painter.plotter.notebook or has_display()):
        painter.close()
        raise OSError("There is no display to open a window on: make a file by lmgcpy.view.render(source, 'a.png').")
    film.show(painter)


def _size(size: Any, moving: bool) -> tuple[int, int]:
    if size is None:
        return SIZE_OF_GIF if moving else SIZE
    width, height = vector(size, "size", 2)
    return whole(int(width), "the width in size", minimum=16, maximum=20_000), whole(
        int(height), "the height in size", minimum=16, maximum=20_000
    )


def write_film(film: Film, target: Path, frames_per_second: float = 20.0) -> Path:
    """Draw all pictures of a film into a .gif or .mp4, or its first picture into another file; returns the path."""
    painter, kind = Painter(off_screen=True), target.suffix.lower()
    try:
        if kind == ".gif":
            _write_gif(film, painter, target, frames_per_second)
        elif kind == ".mp4":
            _write_mp4(film, painter, target, frames_per_second)
        elif kind == ".png":
            _write_png(film.plate(painter, 0).pixels(), target)
        else:
            write_bytes(target, film.plate(painter, 0).document(kind[1:]))
    finally:
        painter.close()
    return target


def _write_png(pixels: np.ndarray, path: Path) -> None:
    from PIL import Image

    with new_file(path) as new:
        Image.fromarray(pixels).save(new, optimize=True)


def _write_gif(film: Film, painter: Painter, path: Path, frames_per_second: float) -> None:
    """Write all pictures with one palette, made from the first, the middle and the last, so that colours do not flicker."""
    from PIL import Image

    count = film.frame_count
    some = [film.plate(painter, k).pixels() for k in sorted({0, count // 2, count - 1})]
    palette = palette_of(np.concatenate(some))

    def pictures() -> Iterator[Image.Image]:
        for k in range(count):
            yield Image.fromarray(film.plate(painter, k).pixels()).quantize(palette=palette, dither=Image.Dither.NONE)

    first, *rest = pictures()
    with new_file(path) as new:
        first.save(new, save_all=True, append_images=rest, duration=1000.0 / frames_per_second, loop=0, optimize=False)


def palette_of(pixels: np.ndarray) -> Any:
    """An image with a palette of 256 colours for pixels (height, width, 3). Maximum coverage keeps rare colours, such as
    the colours of a wire; median cut would mix them with others. White stays white."""
    from PIL import Image

    palette = Image.fromarray(pixels).quantize(255, method=Image.Quantize.MAXCOVERAGE)
    palette.putpalette([*(palette.getpalette() or [])[: 3 * 255], 255, 255, 255])
    return palette


def load_encoder() -> Any:
    """The module imageio_ffmpeg; ImportError with a sentence if it is missing."""
    try:
        import imageio_ffmpeg
    except ImportError as error:
        raise ImportError(
            'An .mp4 needs imageio-ffmpeg, which is not installed: pip install "lmgcpy[film]". A .gif needs nothing more.'
        ) from error
    return imageio_ffmpeg


def _write_mp4(film: Film, painter: Painter, path: Path, frames_per_second: float) -> None:
    """Write all pictures, in H.264 with colours as most players know them: width and height are even."""
    first = _even(film.plate(painter, 0).pixels())
    with tempfile.TemporaryDirectory() as folder:
        raw = Path(folder) / "film.mp4"  # the encoder writes only to a name
        size = first.shape[1], first.shape[0]
        frames = load_encoder().write_frames(str(raw), size, fps=frames_per_second, quality=7, macro_block_size=2)
        try:
            frames.send(None)
            frames.send(np.ascontiguousarray(first))
            for k in range(1, film.frame_count):
                frames.send(np.ascontiguousarray(_even(film.plate(painter, k).pixels())))
        finally:
            frames.close()  # ends the encoder, after an error too
        write_bytes(path, raw.read_bytes())


def _even(pixels: np.ndarray) -> np.ndarray:
    """A picture with a further white line if its height or its width is odd."""
    down, right = (size % 2 for size in pixels.shape[:2])
    return np.pad(pixels, ((0, down), (0, right), (0, 0)), constant_values=255)
