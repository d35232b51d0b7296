"""Result of a TexSol study."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.experiment.box import Sample
from lmgcpy.experiment.compaction import Compaction


@dataclass(frozen=True)
class TexSolResult:
    """All that a TexSol study computed."""

    study: Any
    """A :class:`~lmgcpy.experiment.texsol.study.TexSolStudy`."""
    compaction: Compaction
    records: dict[str, Any]
    """Records of the tests, by the law, in 3D by "law-axis"."""
    checks: dict[str, Any]
    """Records of the same tests at a tighter tolerance, over their first part."""

    @property
    def seconds(self) -> float:
        """Wall clock time of the steps of all runs [s]."""
        return self.compaction.seconds + sum(run.seconds for run in [*self.records.values(), *self.checks.values()])

    @property
    def sample(self) -> Sample:
        """The relaxed sample at the start of the tests."""
        return self.compaction.sample


def deviation(record: Any, check: Any) -> float:
    """Mean difference of two runs' reactions over their common crushing, relative to the mean reaction."""
    strain = check.strain[check.strain <= record.strain[-1]]
    ours = np.interp(strain, record.strain, record.smooth(record.reaction))
    theirs = np.interp(strain, check.strain, check.smooth(check.reaction))
    return float(np.abs(ours - theirs).mean() / theirs.mean())
