"""Files: runs, their comparison and export, and problems in FCLIB's format."""

from typing import TYPE_CHECKING, Any

from lmgcpy.io import fclib
from lmgcpy.io.compare import compare
from lmgcpy.io.csv_tables import export_csv
from lmgcpy.io.run import Run, open_run
from lmgcpy.io.take_up import take_up

if TYPE_CHECKING:
    from lmgcpy.io.vtk import export_vtk

__all__ = ["Run", "compare", "export_csv", "export_vtk", "fclib", "open_run", "take_up"]


def __getattr__(name: str) -> Any:
    """``export_vtk``, imported at its first use, because it imports the drawing code."""
    if name == "export_vtk":
        from lmgcpy.io.vtk import export_vtk

        return export_vtk
    from lmgcpy.errors import closest

    raise AttributeError(f"lmgcpy.io has no '{name}'{closest(name, __all__)}")


def __dir__() -> list[str]:
    return __all__
