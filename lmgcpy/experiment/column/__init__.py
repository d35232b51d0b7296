"""Columns of sand, without and with wire: sample, pour and release, study, report, pictures."""

from lmgcpy.experiment.column.course import ColumnState, Course, SandColumn, let_go, time_unit
from lmgcpy.experiment.column.sample import Laid, Mould, lay_column

Column, State = SandColumn, ColumnState
"""Names of version 0.1."""

__all__ = ["Column", "ColumnState", "Course", "Laid", "Mould", "SandColumn", "State", "lay_column", "let_go", "time_unit"]
