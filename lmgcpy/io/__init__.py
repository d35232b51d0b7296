"""Files."""

from lmgcpy.io import fclib
from lmgcpy.io.compare import compare
from lmgcpy.io.restart import take_up
from lmgcpy.io.run import Run, open_run
from lmgcpy.io.tables import export_csv

__all__ = ["Run", "compare", "export_csv", "fclib", "open_run", "take_up"]
