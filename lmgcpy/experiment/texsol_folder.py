"""The folder of a TexSol study."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar

from lmgcpy.experiment.study_folder import Folder
from lmgcpy.experiment.texsol_2d import Study
from lmgcpy.experiment.texsol_3d import Study3D
from lmgcpy.experiment.texsol_tests import TexSolStudy

STUDIES: dict[int, Callable[..., TexSolStudy]] = {kind.DIMENSION: kind for kind in (Study, Study3D)}
"""By dimension."""


class StudyFolder(Folder[TexSolStudy]):
    """Where a TexSol study is kept."""

    COMMAND: ClassVar[str] = "texsol"

    def told_beside(self, study: TexSolStudy) -> dict[str, Any]:
        return {"dimension": study.DIMENSION}

    def kind_of(self, about: dict[str, Any]) -> Callable[..., TexSolStudy]:
        return STUDIES[about.get("dimension", 2)]
