"""Files: runs, their comparison and export as tables, and problems in FCLIB's format."""

from typing import Any

from lmgcpy.errors import closest
from lmgcpy.io import fclib
from lmgcpy.io.compare import compare
from lmgcpy.io.csv_tables import export_csv
from lmgcpy.io.run import Run, open_run
from lmgcpy.io.take_up import take_up

__all__ = ["Run", "compare", "export_csv", "fclib", "open_run", "take_up"]


def __getattr__(name: str) -> Any:
    if name == "export_vtk":
        raise AttributeError("lmgcpy.io has no 'export_vtk': it is lmgcpy.view.export_vtk, beside the pictures.")
    raise AttributeError(f"lmgcpy.io has no '{name}'{closest(name, __all__)}")


def __dir__() -> list[str]:
    return __all__
