"""Export of a run for ParaView: bodies, forces, wires and walls as VTK's polygonal data, frame by frame."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np

from lmgcpy.dynamics.interactions import InteractionView
from lmgcpy.errors import named_arguments, shown
from lmgcpy.io.csv_tables import folder_for
from lmgcpy.io.run import Run
from lmgcpy.measure.facets import Facets, facets_of
from lmgcpy.measure.moment import moment
from lmgcpy.scene.contactor import RodContactor
from lmgcpy.view.boundary import FACETS, cell_outline, cylinder_polygons, wall_polygons
from lmgcpy.view.drawing import in_space
from lmgcpy.view.quantities import coordination
from lmgcpy.view.snapshot import Snapshot, acting_lines, snapshot
from lmgcpy.writing import new_file, write_text

MISSING = 'Files for ParaView are written by VTK, which is not installed: pip install "lmgcpy[view]".'
PARTS = ("bodies", "forces", "wires", "walls")
"""Parts of every export; each is a series of files."""


@named_arguments
def export_vtk(run: Run, folder: str | os.PathLike, *, force: bool = False) -> list[Path]:
    """Write a run into a folder for ParaView; returns the paths of the series to open, .pvd files.

    * ``bodies.pvd`` has a point for each disk or sphere, also in clumps and at the ends of capsules, with
      ``radius`` [m], and of its body ``body`` (the id), ``velocity`` [m/s], ``spin`` [rad/s], ``mass`` [kg],
      ``coordination``, and ``color`` (its word is in the field ``color_names``). Foreign shapes without outline appear as
      their bounding circles.
    * ``rods.pvd``, of a scene with capsules, has a line along the axis of each, with the same arrays of its body and
      ``radius`` [m] at its ends: a tube of it and the spheres of ``bodies.pvd`` are the capsule.
    * ``turning.pvd``, of a scene with bodies that keep a rotation in space, has a point at the centre of mass of each, with
      the same arrays of the body and ``orientation``, the quaternion from its axes to those of space, q_w first, as VTK has
      it: a surface of any shape can be drawn there.
    * ``forces.pvd`` has a line for each contact or link with a force, not for joints. A link goes between its ends; a
      contact goes through its point, between the centres of the disks or spheres that touch, and ends there at a wall or
      a foreign shape. It has ``force``, the vector that acts on the candidate [N], ``normal_force`` (positive
      if it pushes) and ``tension`` [N], ``candidate``, ``antagonist``, ``gap`` [m], and ``law`` (its name is in the field
      ``law_names``).
    * ``wires.pvd`` has a line for each link, with ``tension`` [N], ``excess`` (relative to its reference length),
      ``chain``, ``link`` and ``law``. Its points have ``radius`` [m], ``velocity`` and ``length``, the length of the wire
      up to the point [m].
    * ``walls.pvd`` has lines and planes, cut to the sample, and the triangles or segments of surfaces, with ``body``.
      Triangles and segments have ``force`` [N] and ``pressure`` [Pa] of the contacts on them, see
      :func:`lmgcpy.measure.facets`; others have NaN.
    * ``membranes.pvd``, of a scene with membranes, has their triangles, in 2D the segments of chains with a surface, with
      ``surface``, ``force`` and ``pressure``.
    * ``cell.pvd``, of a periodic scene, has the edges of the cell. Bodies and forces are then drawn in it, bodies by their
      centres and forces by their middles; wires are whole and go on beyond its faces.
    * ``outlines.pvd``, of a scene with foreign shapes that have an outline, has their lines, with ``body``.

    Raises FileExistsError if the folder is not empty, unless ``force``, and ImportError without VTK.
    """
    if not isinstance(run, Run):
        raise TypeError(f"export_vtk takes a run, which lmgcpy.io.open_run(path) opens, got {shown(run)}.")
    try:
        import vtkmodules.vtkIOXML  # noqa: F401
    except ImportError as error:
        raise ImportError(MISSING) from error
    target = folder_for(folder, force)
    series: dict[str, list[tuple[float, str]]] = {part: [] for part in PARTS}
    for frame, time in enumerate(run.times.tolist()):
        taken, net = snapshot(run, frame), run.interactions(frame)
        found, corners = facets_of(moment(run, frame, "export_vtk"))
        made = {
            "bodies": bodies(taken),
            "forces": forces(taken, net, run.laws),
            "wires": wires(taken, net, run.laws),
            "walls": walls(taken, found, corners),
        }
        if (found.body < 0).any():
            made["membranes"] = membranes(taken, found, corners)
        if taken.lattice is not None:
            made["cell"] = cell(taken)
        if RodContactor.KIND in taken.scene["contactors"]["kinds"]:
            made["rods"] = rods(taken)
        if "turning" in taken.scene:
            made["turning"] = turning(taken)
        if taken.outlines:
            made["outlines"] = outlines(taken)
        for part, data in made.items():
            name = f"{part}-{frame:05d}.vtp"
            write(data, target / name)
            series.setdefault(part, []).append((time, name))
    return [write_series(target / f"{part}.pvd", files) for part, files in series.items()]


def write_series(path: Path, files: list[tuple[float, str]]) -> Path:
    """Write a .pvd file, which gives the time [s] of each file."""
    rows = [f'    <DataSet timestep="{time!r}" group="" part="0" file="{name}"/>' for time, name in files]
    body = "\n".join(["  <Collection>", *rows, "  </Collection>"])
    write_text(path, f'<?xml version="1.0"?>\n<VTKFile type="Collection" version="0.1">\n{body}\n</VTKFile>\n')
    return path


# ------------------------------------------------------------------------------------------------------------- parts


def bodies(snapshot: Snapshot) -> Any:
    """Disks and spheres."""
    rounds = snapshot.rounds
    data = polygonal_data(snapshot.placed(rounds), "verts", np.arange(len(rounds.body))[:, None])
    add_arrays(data.GetPointData(), {"radius": rounds.shape[:, 0]})
    add_bodies(data, data.GetPointData(), snapshot, rounds.body)
    return data


def rods(snapshot: Snapshot) -> Any:
    """Axes of rods."""
    found, middle = snapshot.rods, snapshot.placed(snapshot.rods)
    half, count = found.shape[:, 1:], len(found.body)
    ends = np.stack([middle - half, middle + half], axis=1).reshape(-1, snapshot.dimension)
    data = polygonal_data(ends, "lines", np.arange(2 * count).reshape(-1, 2))
    add_arrays(data.GetPointData(), {"radius": np.repeat(found.shape[:, 0], 2)})
    add_bodies(data, data.GetCellData(), snapshot, found.body)
    return data


def turning(snapshot: Snapshot) -> Any:
    """Centres of mass and orientations of the bodies that keep a rotation in space."""
    body = snapshot.scene["turning"]["body"]
    body = body[~snapshot.hidden[body]]
    assert snapshot.rotations is not None
    centres = snapshot.positions[body]
    data = polygonal_data(centres + snapshot.into_cell(centres), "verts", np.arange(len(body))[:, None])
    add_arrays(data.GetPointData(), {"orientation": np.roll(snapshot.rotations[body], 1, axis=1)})
    add_bodies(data, data.GetPointData(), snapshot, body)
    return data


def add_bodies(data: Any, attributes: Any, snapshot: Snapshot, body: np.ndarray) -> None:
    """Add the arrays of bodies (k,) to the attributes of points or cells."""
    spins = snapshot.spins if snapshot.dimension == 3 else snapshot.spins[:, None] * np.array([0.0, 0.0, 1.0])
    arrays = {
        "body": body,
        "velocity": in_space(snapshot.velocities)[body],
        "spin": spins[body],
        "mass": snapshot.scene["bodies"]["mass"][body],
        "coordination": coordination(snapshot)[1][body].astype(np.int64),
        "color": snapshot.scene["bodies"]["color"][body],
    }
    add_arrays(attributes, arrays)
    add_words(data, "color_names", snapshot.scene["bodies"]["colors"])


def forces(snapshot: Snapshot, net: InteractionView, laws: list[str]) -> Any:
    """Contacts and links with a force."""
    assert snapshot.forces is not None
    row = snapshot.forces.row
    start, end = acting_lines(snapshot)
    into_cell = snapshot.into_cell(0.5 * (start + end))
    start, end = start + into_cell, end + into_cell
    force = net.force[row]
    acting = force.any(axis=1)
    count = int(acting.sum())
    points = np.stack([start[acting], end[acting]], axis=1).reshape(-1, snapshot.dimension)
    data = polygonal_data(points, "lines", np.arange(2 * count).reshape(-1, 2))
    link = np.arange(len(row)) < snapshot.link_count
    arrays = {
        "force": in_space(np.einsum("mk,mkd->md", force, net.frame[row])),
        "normal_force": force[:, 0],
        "tension": np.where(link, np.maximum(-force[:, 0], 0.0), 0.0),
        "candidate": net.candidate[row],
        "antagonist": net.antagonist[row],
        "gap": net.gap[row],
        "law": codes(net.law[row], laws),
    }
    add_arrays(data.GetCellData(), {name: values[acting] for name, values in arrays.items()})
    add_words(data, "law_names", laws)
    return data


def wires(snapshot: Snapshot, net: InteractionView, laws: list[str]) -> Any:
    """Links of the chains."""
    assert snapshot.forces is not None
    paths = [chain.path for chain in snapshot.chains]
    body = np.concatenate([np.zeros(0, np.int64), *paths])
    courses = snapshot.courses
    places = np.concatenate([np.zeros((0, snapshot.dimension)), *courses])
    cells, along = [np.zeros((0, 2), np.int64)], [np.zeros(0)]
    first = 0
    for course in courses:
        point = first + np.arange(len(course))
        first += len(course)
        cells.append(np.column_stack([point[:-1], point[1:]]))
        steps = np.linalg.norm(np.diff(course, axis=0), axis=1)
        along.append(np.concatenate([[0.0], np.cumsum(steps)]))
    link = np.concatenate(cells)
    length = np.linalg.norm(np.diff(places[link], axis=1)[:, 0], axis=1)
    reference = np.concatenate([np.zeros(0), *(chain.reference for chain in snapshot.chains)])
    data = polygonal_data(places, "lines", link)
    points = {
        "radius": snapshot.scene["bodies"]["link_radius"][body],
        "velocity": in_space(snapshot.velocities)[body],
        "length": np.concatenate(along),
    }
    add_arrays(data.GetPointData(), points)
    law_of_chain = [snapshot.scene["laws"][k]["name"] for k in snapshot.scene["chains"]["law"].tolist()]
    counts = [len(chain.reference) for chain in snapshot.chains]
    arrays = {
        "tension": np.maximum(-snapshot.forces.link, 0.0),
        "excess": length / reference - 1.0,
        "chain": np.repeat(np.arange(len(paths)), counts),
        "link": np.concatenate([np.zeros(0, np.int64), *map(np.arange, counts)]),
        "law": np.repeat(codes(np.array(law_of_chain or [""]), laws)[: len(paths)], counts),
    }
    add_arrays(data.GetCellData(), arrays)
    add_words(data, "law_names", laws)
    return data


def walls(snapshot: Snapshot, found: Facets, corners: np.ndarray) -> Any:
    """Lines, planes, facets of surfaces with their forces, and facets of cylinders."""
    pieces = [(body, piece) for body, piece in zip(snapshot.walls.body, wall_polygons(snapshot), strict=True) if len(piece)]
    pieces += [(snapshot.cylinders.body[k // FACETS], facet) for k, facet in enumerate(cylinder_polygons(snapshot))]
    others, wall = len(pieces), found.body >= 0
    pieces += zip(found.body[wall].tolist(), map(in_space, corners[wall]), strict=True)
    data = polygons([piece for _, piece in pieces], snapshot.dimension)
    force, pressure = in_space(found.force[wall]), found.pressure[wall]
    arrays = {
        "body": np.array([body for body, _ in pieces], dtype=np.int64),
        "force": np.concatenate([np.full((others, 3), np.nan), force]),
        "pressure": np.concatenate([np.full(others, np.nan), pressure]),
    }
    add_arrays(data.GetCellData(), arrays)
    return data


def membranes(snapshot: Snapshot, found: Facets, corners: np.ndarray) -> Any:
    """Facets between bodies, with the forces of contacts."""
    mine = found.body < 0
    places = corners[mine] + snapshot.into_cell(found.position[mine])[:, None]
    data = polygons(list(map(in_space, places)), snapshot.dimension)
    arrays = {"surface": found.surface[mine], "force": in_space(found.force[mine]), "pressure": found.pressure[mine]}
    add_arrays(data.GetCellData(), arrays)
    return data


def polygons(pieces: list[np.ndarray], dimension: int) -> Any:
    """Polygonal data of polygons, in the plane lines, of points (v, 3) each."""
    points = np.concatenate([np.zeros((0, 3)), *pieces])
    first = np.cumsum([0, *map(len, pieces)])
    cells = [np.arange(first[i], first[i + 1]) for i in range(len(pieces))]
    return polygonal_data(points, "lines" if dimension == 2 else "polys", cells)


def cell(snapshot: Snapshot) -> Any:
    """Edges of the periodic cell."""
    lines = cell_outline(snapshot)
    return polygonal_data(lines.reshape(-1, 3), "lines", np.arange(2 * len(lines)).reshape(-1, 2))


def outlines(snapshot: Snapshot) -> Any:
    """Outlines of the shapes of plug-ins."""
    body, lines = zip(*snapshot.outlines, strict=True)
    first = np.cumsum([0, *map(len, lines)])
    cells = [np.arange(first[i], first[i + 1]) for i in range(len(lines))]
    data = polygonal_data(np.concatenate(lines), "lines", cells)
    add_arrays(data.GetCellData(), {"body": np.array(body, dtype=np.int64)})
    return data


def codes(names: np.ndarray, known: list[str]) -> np.ndarray:
    """Index of each name in a list, (k,); -1 for an unknown name."""
    return np.array([known.index(name) if name in known else -1 for name in names.tolist()], dtype=np.int64)


# --------------------------------------------------------------------- VTK's polygonal data: points, cells, arrays, files


def polygonal_data(points: np.ndarray, kind: str, cells: Any) -> Any:
    """Polygonal data of points [m], (p, d), and cells of point indices; ``kind`` is "verts", "lines" or "polys"."""
    from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

    vtk_points = vtkPoints()
    vtk_points.SetData(numpy_to_vtk(np.ascontiguousarray(in_space(points)), deep=True))
    offsets = np.cumsum([0, *map(len, cells)]).astype(np.int64)
    members = np.concatenate([np.zeros(0, np.int64), *cells]).astype(np.int64)
    array = vtkCellArray()
    array.SetData(numpy_to_vtkIdTypeArray(offsets, deep=True), numpy_to_vtkIdTypeArray(members, deep=True))
    data = vtkPolyData()
    data.SetPoints(vtk_points)
    {"verts": data.SetVerts, "lines": data.SetLines, "polys": data.SetPolys}[kind](array)
    return data


def add_arrays(attributes: Any, arrays: dict[str, np.ndarray]) -> None:
    """Add arrays, by name, to the attributes of points or cells."""
    from vtkmodules.util.numpy_support import numpy_to_vtk

    for name, values in arrays.items():
        array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
        array.SetName(name)
        attributes.AddArray(array)


def add_words(data: Any, name: str, words: list[str]) -> None:
    """Add an array of words, the meanings of integer codes."""
    from vtkmodules.vtkCommonCore import vtkStringArray

    array = vtkStringArray()
    array.SetName(name)
    for word in words:
        array.InsertNextValue(word)
    data.GetFieldData().AddArray(array)


def write(data: Any, path: Path) -> None:
    """Write a data set, into a .vtp or .vti file; raises the errors of :func:`lmgcpy.writing.new_file`."""
    from vtkmodules.vtkCommonMisc import vtkErrorCode
    from vtkmodules.vtkIOXML import vtkXMLDataSetWriter

    writer = vtkXMLDataSetWriter()
    writer.SetInputData(data)
    with new_file(path) as new:
        writer.SetFileName(str(new))
        if not writer.Write() or writer.GetErrorCode():
            raise OSError(vtkErrorCode.GetStringFromErrorCode(writer.GetErrorCode()))
