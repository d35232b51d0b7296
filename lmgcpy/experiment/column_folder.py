"""The folder of a column study."""

from __future__ import annotations

from typing import Any, ClassVar

from lmgcpy.experiment.column_study import ColumnStudy
from lmgcpy.experiment.study_folder import Folder


class ColumnFolder(Folder[ColumnStudy]):
    """Where a column study is kept."""

    COMMAND: ClassVar[str] = "column"

    def kind_of(self, about: dict[str, Any]) -> type[ColumnStudy]:
        return ColumnStudy
