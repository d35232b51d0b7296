"""Pictures of scenes, simulations and runs by pyvista, files for ParaView, and curves of runs by matplotlib.

Importing this package imports neither library: they are loaded when the first picture is made.
``pip install "lmgcpy[view]"`` brings pyvista.
"""

from lmgcpy.view.curves import plot
from lmgcpy.view.fields import draw_fields, export_fields
from lmgcpy.view.layout import Layout, check
from lmgcpy.view.pictures import render, show
from lmgcpy.view.vtk import export_vtk

__all__ = ["Layout", "check", "draw_fields", "export_fields", "export_vtk", "plot", "render", "show"]


def __dir__() -> list[str]:
    return __all__
