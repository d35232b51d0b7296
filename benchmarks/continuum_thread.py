"""The continuous model beside tests with a thread, and what one content says of others: docs/continuum.md.

Reads folders of ``strength_thread.py``, and of larger samples of the same study. Cases that differ in their seed only are
compared as ``lmgcpy continuum`` does. A table gives the tension of links by the stretch that they would have if they
followed the sand, in the first and the last third of the tests. Then anchorage and gain are taken from the small samples
with a content of 0.2 along the same axis, as ``lmgcpy continuum --measured-in`` does, and the other contents and sizes are
predicted with them.

    python benchmarks/continuum_thread.py FOLDER...
"""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from functools import cached_property
from itertools import pairwise
from pathlib import Path

import numpy as np
from strength import CONTENT, GRAINS
from strength_thread import CHANGES, same
from table import report

from lmgcpy.errors import AXES
from lmgcpy.experiment import CampaignFolder, StudyFolder
from lmgcpy.experiment.continuum.comparison import Comparison, Prediction, compare, miss
from lmgcpy.experiment.study.engine import carry_out_study
from lmgcpy.experiment.texsol.study import TexSolStudy
from lmgcpy.io.run import open_run
from lmgcpy.measure import wire_links

MODELS = {"sand": "sand alone", "anchored": "anchored", "stronger": "stronger sand", "coulomb": "Mohr and Coulomb"}
STRETCHES = (-0.04, -0.02, 0.0, 0.02, 0.04, 0.06, 0.08)
"""Stretches between which tensions are averaged."""
FEWEST = 100
"""Least number of links in a mean."""
SOURCE = 800
"""Number of places of the wire in the samples from which the others are predicted."""


@dataclass(frozen=True)
class Group:
    """Studies that differ in their seed only, and what the continuous model says of them."""

    paths: list[Path]
    found: Comparison

    @property
    def study(self) -> TexSolStudy:
        return self.found.studies[0]

    @cached_property
    def test(self) -> str:
        (name,) = self.found.predictions
        return name

    @property
    def change(self) -> str:
        """The change of the usual thread, or nothing if only content, axis and number of grains are others."""
        for name, change in CHANGES.items():
            own = {field: value for field, value in change.items() if field not in ("bead_count", "axes")}
            if own and all(same(getattr(self.study, field), value) for field, value in own.items()):
                return name
        return ""

    @property
    def name(self) -> str:
        """Number of grains, axis and change."""
        return ", ".join(filter(None, (f"{self.study.grain_count} grains", f"along {self.study.axes[0]}", self.change)))


def groups(folders: list[Path]) -> Iterator[Group]:
    """The groups, small samples with at least two seeds. A single larger sample is predicted from itself."""
    found = defaultdict(list)
    finished = [folder / "cases" / case.name for folder in folders for case in CampaignFolder(folder).results().finished]
    for path in sorted(finished):
        study = StudyFolder(path, TexSolStudy).read()
        found[str({name: value for name, value in asdict(study).items() if name not in ("seed", "threads")})].append(path)
    for paths in found.values():
        group = Group(paths, compare(paths))
        if len(paths) > 1 or group.study.grain_count > GRAINS:
            yield group


def row(group: Group, many: list[Prediction]) -> list:
    """Samples, scatter, errors of the models, and what the wire bears late in the run and in the models."""
    late = [one.run.crushing[-1] * np.linspace(0.8, 0.99, 20) for one in many]
    deviator = np.array([one.run.at(moments).deviator.mean() for one, moments in zip(many, late, strict=True)])
    errors = []
    for model in MODELS:
        misses = [miss(one, getattr(one, model)) for one in many]
        deviators, volumes = np.mean([one.deviator for one in misses]), np.mean([one.volume for one in misses])
        errors.append(f"{100 * deviators:.0f} %, {100 * volumes:.2f}")
    across = [k for k in range(3) if AXES[k] != many[0].axis]
    bears = [
        np.mean([getattr(one, who).at(moments).wire[:, across] for one, moments in zip(many, late, strict=True)])
        for who in ("run", "anchored", "stronger")
    ]
    scatter = f"{100 * deviator.std(ddof=1) / deviator.mean():.0f} %" if len(many) > 1 else ""
    told = [f"{1e-3 * value:.1f}" for value in bears]
    return [group.name, f"{group.found.content:.2f}", len(many), scatter, *errors, *told]


def measured(group: Group) -> list:
    """Measured spans, strengths, slip and gain of a group."""
    found, d = group.found, np.mean(group.found.diameters)
    span = np.array([one.span for one in found.anchorages]) / d
    first, last = (np.array([one.strength[k] for one in found.anchorages]) / d**2 for k in (0, -1))
    slip = np.mean([one.slip[-1] for one in found.anchorages])
    gain = np.array(found.gains[group.test])
    told = []
    for values, form in ((span, ".1f"), (first, ".2f"), (last, ".2f"), (gain, ".3f")):
        scatter = f" ± {values.std(ddof=1):{form}}" if len(values) > 1 else ""
        told.append(f"{values.mean():{form}}{scatter}")
    return [group.name, f"{group.found.content:.2f}", *told[:3], f"{100 * slip:.1f}", told[3]]


def by_stretch(group: Group) -> list:
    """Mean tension over p d^2 of links by the stretch that the strain would give them, in two thirds of a test."""
    tension, counts = np.zeros((2, len(STRETCHES) + 1)), np.zeros((2, len(STRETCHES) + 1))
    for path, wire in zip(group.paths, group.found.wires, strict=True):
        folder = StudyFolder(path, TexSolStudy)
        result = carry_out_study(folder.read(), None, folder, resume=True)
        record = result.records[group.test]
        pressure = -np.trace(record.stress["sand"], axis1=1, axis2=2) / 3
        with open_run(folder.run_file(group.test)) as run:
            for frame in np.flatnonzero(run.steps > 0).tolist():
                step = run.steps[frame] - 1
                third = int(3.0 * step / run.steps[-1])
                if third != 1:
                    stretch = wire.direction**2 @ np.log(record.size[step] / result.sample.box)
                    of = np.digitize(stretch, STRETCHES)
                    links = wire_links(run, frame=frame).tension / (pressure[step] * result.sample.diameter**2)
                    tension[third // 2] += np.bincount(of, links, len(STRETCHES) + 1)
                    counts[third // 2] += np.bincount(of, minlength=len(STRETCHES) + 1)
    rows = []
    for when, sums, numbers in zip(("first", "last"), tension, counts, strict=True):
        means = [f"{t / n:.2f}" if n >= FEWEST else "-" for t, n in zip(sums, numbers, strict=True)]
        rows.append([group.name, f"{group.found.content:.2f}", when, *means])
    return rows


def main(folders: list[Path]) -> None:
    """Print the tables."""
    every = sorted(groups(folders), key=lambda one: (one.study.grain_count, one.study.axes, one.change, one.found.content))
    head = ["test", "content", "samples", "scatter of seeds", *(f"{words}: q, volume off by" for words in MODELS.values())]
    head += ["the wire bears late [kPa]", "anchored", "in stronger sand"]
    strengths = ["span [d]", "strength at first [p d²]", "at the end", "slip at the end [%]", "gain in q/p"]
    report("continuum_thread", head, [row(group, group.found.predictions[group.test]) for group in every])
    report("continuum_thread_measured", ["test", "content", *strengths], [measured(group) for group in every])
    ends = [f"{100 * low:.0f} to {100 * high:.0f} %" for low, high in pairwise(STRETCHES)]
    ends = [f"below {100 * STRETCHES[0]:.0f} %", *ends, f"above {100 * STRETCHES[-1]:.0f} %"]
    usual = [group for group in every if not group.change and group.study.axes == ("z",)]
    rows = [row for group in usual for row in by_stretch(group)]
    report("continuum_thread_stretch", ["test", "content", "third", *ends], rows)
    sources = {
        group.study.axes: group
        for group in every
        if not group.change and group.study.grain_count == GRAINS and group.study.bead_count == SOURCE
    }
    others = [group for group in every if not group.change and group is not sources.get(group.study.axes)]
    print(f"\nPredicted from the content of {CONTENT * SOURCE:.2f} as ordered:")
    rows = [
        row(group, compare(group.paths, source=sources[group.study.axes].found).predictions[group.test])
        for group in others
        if group.study.axes in sources
    ]
    report("continuum_thread_moved", head, rows)


if __name__ == "__main__":
    main([Path(word) for word in sys.argv[1:]])
