"""VTK's polygonal data: points, cells, arrays, and their files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from lmgcpy.view.drawing import in_space
from lmgcpy.writing import new_file


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
    """Write a .vtp file; raises the errors of :func:`lmgcpy.writing.new_file`."""
    from vtkmodules.vtkCommonMisc import vtkErrorCode
    from vtkmodules.vtkIOXML import vtkXMLPolyDataWriter

    writer = vtkXMLPolyDataWriter()
    writer.SetInputData(data)
    with new_file(path) as new:
        writer.SetFileName(str(new))
        if not writer.Write() or writer.GetErrorCode():
            raise OSError(vtkErrorCode.GetStringFromErrorCode(writer.GetErrorCode()))
