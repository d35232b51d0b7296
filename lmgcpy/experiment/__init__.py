"""Experiments: samples in a box, compaction, biaxial and triaxial tests, columns, and the studies made of them.

``from lmgcpy.experiment import Biaxial, compact, lay_sample``. A name is imported when it is first asked for.
"""

import importlib
from typing import TYPE_CHECKING, Any

# ruff: noqa: F401
if TYPE_CHECKING:  # the names of MODULES, for type checkers
    from lmgcpy.experiment.biaxial import Biaxial, BiaxialRecord, Frame
    from lmgcpy.experiment.box import Box, Sample, characteristic_time
    from lmgcpy.experiment.campaign.campaign import Campaign
    from lmgcpy.experiment.campaign.cases import CampaignFolder, CampaignResults, CaseResult
    from lmgcpy.experiment.column.course import ColumnState, Course, SandColumn, let_go, time_unit
    from lmgcpy.experiment.column.result import ColumnResult, Fall
    from lmgcpy.experiment.column.sample import Laid, Mould, lay_column
    from lmgcpy.experiment.column.study import ColumnStudy
    from lmgcpy.experiment.compaction import Compaction, Unrest, compact
    from lmgcpy.experiment.compression import Compression, CompressionRecord
    from lmgcpy.experiment.grains import lay_grains
    from lmgcpy.experiment.periodic import (
        PeriodicCell,
        PeriodicSample,
        PeriodicShear,
        PeriodicShearRecord,
        lay_periodic,
    )
    from lmgcpy.experiment.recorded_run import carry_out
    from lmgcpy.experiment.study.engine import Site, Study, Task, carry_out_study
    from lmgcpy.experiment.study.folder import StudyFolder
    from lmgcpy.experiment.study.stages import Stages
    from lmgcpy.experiment.texsol.result import TexSolResult
    from lmgcpy.experiment.texsol.sample import lay_sample, lay_sample_3d
    from lmgcpy.experiment.texsol.study import Study2D, Study3D
    from lmgcpy.experiment.triaxial import Triaxial, TriaxialRecord

MODULES = {
    "biaxial": ("Biaxial", "BiaxialRecord", "Frame"),
    "box": ("Box", "Sample", "characteristic_time"),
    "campaign.campaign": ("Campaign",),
    "campaign.cases": ("CampaignFolder", "CampaignResults", "CaseResult"),
    "column.course": ("ColumnState", "Course", "SandColumn", "let_go", "time_unit"),
    "column.result": ("ColumnResult", "Fall"),
    "column.sample": ("Laid", "Mould", "lay_column"),
    "column.study": ("ColumnStudy",),
    "compaction": ("Compaction", "Unrest", "compact"),
    "compression": ("Compression", "CompressionRecord"),
    "grains": ("lay_grains",),
    "periodic": (
        "PeriodicCell",
        "PeriodicSample",
        "PeriodicShear",
        "PeriodicShearRecord",
        "lay_periodic",
    ),
    "study.engine": ("Site", "Study", "Task", "carry_out_study"),
    "study.folder": ("StudyFolder",),
    "study.stages": ("Stages",),
    "texsol.result": ("TexSolResult",),
    "texsol.sample": ("lay_sample", "lay_sample_3d"),
    "texsol.study": ("Study2D", "Study3D"),
    "recorded_run": ("carry_out",),
    "triaxial": ("Triaxial", "TriaxialRecord"),
}
"""The public names by the module that defines them."""

__all__ = sorted(name for names in MODULES.values() for name in names)


def __getattr__(name: str) -> Any:
    """A public name, from its module."""
    for module, names in MODULES.items():
        if name in names:
            return getattr(importlib.import_module(f"{__name__}.{module}"), name)
    from lmgcpy.errors import closest

    raise AttributeError(f"lmgcpy.experiment has no '{name}'{closest(name, __all__)}")


def __dir__() -> list[str]:
    return __all__
