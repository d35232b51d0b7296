"""Coarse-grained fields as pictures and as files for ParaView."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from lmgcpy.errors import AXES, file_path, named_arguments, number, one_of, shown
from lmgcpy.measure.fields import CoarseFields
from lmgcpy.view.curves import SUFFIXES
from lmgcpy.view.figures import new_figure, save
from lmgcpy.view.vtk import MISSING, add_arrays, write
from lmgcpy.writing import check_target

ARROWS = 20
"""Most arrows of the velocity along an axis."""
FAINT = 1e-3
"""Part of the greatest density below which no velocity is drawn."""


def _pressure(fields: CoarseFields) -> np.ndarray:
    return -np.trace(fields.stress, axis1=-2, axis2=-1) / fields.stress.shape[-1]


def _shear(fields: CoarseFields) -> np.ndarray:
    sigma = fields.stress
    values = np.linalg.eigvalsh(0.5 * (sigma + sigma.swapaxes(-1, -2)))
    return 0.5 * (values[..., -1] - values[..., 0])


def _speed(fields: CoarseFields) -> np.ndarray:
    there = fields.density > FAINT * fields.density.max()
    return np.where(there, np.linalg.norm(fields.velocity, axis=-1), np.nan)


QUANTITIES: dict[str, tuple[str, Callable[[CoarseFields], np.ndarray]]] = {
    "density": ("density [kg/m³]", lambda fields: fields.density),
    "solid-fraction": ("solid fraction", lambda fields: fields.solid_fraction),
    "velocity": ("speed [m/s]", _speed),
    "pressure": ("pressure [Pa]", _pressure),
    "shear": ("greatest shear stress [Pa]", _shear),
}
"""What can be drawn: the words beside the scale, and the values."""


@named_arguments
def draw_fields(fields: CoarseFields, path: str | os.PathLike, *, what: str = "density", cut: Any = None) -> Path:
    """Draw a field of :func:`lmgcpy.measure.coarse_fields` into a PNG, SVG or PDF file. A file of that name is replaced.

    ``what``: "density", "solid-fraction", "velocity" (speed, and arrows), "pressure" (minus the mean normal stress), or
    "shear", half the difference of the greatest and the least principal stress. In 3D the picture is a section by a plane:
    ``cut`` is its axis, or axis and coordinate [m], such as "y" or ("y", 0.1); by default it is normal to y, half-way. The
    function returns the path.
    """
    _check(fields, "draw_fields")
    label, values_of = QUANTITIES[one_of(what, "what", QUANTITIES)]
    target = Path(file_path(path, "path"))
    if target.suffix.lower() not in SUFFIXES:
        raise ValueError(f"path must end in {', '.join(SUFFIXES)}, got '{target}'.")
    check_target(target, force=True)
    d = len(fields.axes)
    if d == 2 and cut is not None:
        raise ValueError("cut is for fields in 3D: these are in 2D.")
    normal, row = _plane(fields, "y" if cut is None else cut) if d == 3 else (None, 0)
    shown_axes = [k for k in range(d) if k != normal]
    values, flow = values_of(fields), fields.velocity
    if normal is not None:
        values, flow = np.take(values, row, axis=normal), np.take(flow, row, axis=normal)
    across, up = (fields.axes[k] for k in shown_axes)
    ratio = np.ptp(up) / np.ptp(across)
    figure = new_figure(width=7.0, height=float(np.clip(5.5 * ratio, 2.5, 10.0)))
    axes = figure.subplots()
    colours = axes.pcolormesh(across, up, values.T, shading="gouraud", cmap="viridis", rasterized=True)
    figure.colorbar(colours, ax=axes, label=label)
    if what == "velocity":
        every = max(1, -(-max(len(across), len(up)) // ARROWS))
        arrows = np.where(np.isnan(values[..., None]), np.nan, flow[..., shown_axes])[::every, ::every]
        axes.quiver(across[::every], up[::every], *np.moveaxis(arrows.swapaxes(0, 1), -1, 0), color="white", pivot="mid")
    axes.set_aspect("equal")
    axes.set_xlabel(f"{AXES[shown_axes[0]]} [m]")
    axes.set_ylabel(f"{AXES[shown_axes[1]]} [m]")
    if normal is not None:
        axes.set_title(f"{AXES[normal]} = {fields.axes[normal][row]:.4g} m", loc="left", fontsize="medium")
    save(figure, target)
    return target


@named_arguments
def export_fields(fields: CoarseFields, path: str | os.PathLike, *, force: bool = False) -> Path:
    """Write fields of :func:`lmgcpy.measure.coarse_fields` for ParaView, as an image of VTK (.vti); returns the path.

    It has ``density`` [kg/m^3], ``solid_fraction``, ``velocity`` [m/s], ``stress``, ``kinetic_stress`` [Pa] and
    ``wall_force`` [N/m^3] at the points of the grid; in 2D vectors and tensors have zeros for z. Raises FileExistsError if
    the file exists, unless ``force``, and ImportError without VTK.
    """
    _check(fields, "export_fields")
    target = Path(file_path(path, "path"))
    if target.suffix.lower() != ".vti":
        raise ValueError(f"path must end in .vti, got '{target}'.")
    check_target(target, force=force)
    try:
        from vtkmodules.vtkCommonDataModel import vtkImageData
    except ImportError as error:
        raise ImportError(MISSING) from error
    d = len(fields.axes)
    image = vtkImageData()
    image.SetDimensions(*[len(axis) for axis in fields.axes], *[1] * (3 - d))
    image.SetOrigin(*[float(axis[0]) for axis in fields.axes], *[0.0] * (3 - d))
    image.SetSpacing(*[float(axis[1] - axis[0]) for axis in fields.axes], *[1.0] * (3 - d))
    arrays = {
        "density": fields.density,
        "solid_fraction": fields.solid_fraction,
        "velocity": np.nan_to_num(fields.velocity),
        "stress": fields.stress,
        "kinetic_stress": fields.kinetic_stress,
        "wall_force": fields.wall_force,
    }
    add_arrays(image.GetPointData(), {name: _in_order(values, d) for name, values in arrays.items()})
    write(image, target)
    return target


def _check(fields: Any, call: str) -> None:
    if not isinstance(fields, CoarseFields):
        raise TypeError(f"{call} takes the fields that lmgcpy.measure.coarse_fields makes, got {shown(fields)}.")


def _plane(fields: CoarseFields, cut: Any) -> tuple[int, int]:
    """The axis normal to a section, and the number of the grid's nearest plane."""
    if not isinstance(cut, str) and not (isinstance(cut, (tuple, list)) and len(cut) == 2):
        raise TypeError(f"cut must be an axis, or an axis and a coordinate [m]: 'y' or ('y', 0.1), got {shown(cut)}.")
    axis, at = (cut, None) if isinstance(cut, str) else cut
    normal = AXES.index(one_of(axis, "the axis of cut", AXES))
    places = fields.axes[normal]
    low, high = float(places[0]), float(places[-1])
    where = 0.5 * (low + high) if at is None else number(at, "the coordinate of cut", minimum=low, maximum=high, unit="m")
    return normal, int(np.abs(places - where).argmin())


def _in_order(values: np.ndarray, d: int) -> np.ndarray:
    """Values as VTK has them: the first axis runs fastest, and vectors (p, 3) and tensors (p, 9) have three axes."""
    values = values.transpose(*range(d - 1, -1, -1), *range(d, values.ndim))
    rank = values.ndim - d
    flat = values.reshape(-1, *[d] * rank)
    flat = np.pad(flat, [(0, 0), *[(0, 3 - d)] * rank])
    return flat.reshape(len(flat), -1) if rank else flat
