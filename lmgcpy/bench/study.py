"""The whole comparison: the solvers are judged on one problem after another, and the report is written."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path

from lmgcpy.bench import load
from lmgcpy.bench.cases import Case, chains, from_folder, in_space, in_the_plane, packings
from lmgcpy.bench.frontier import Judged, judge
from lmgcpy.bench.report import write_report
from lmgcpy.errors import closest, whole
from lmgcpy.experiment.study.stages import Stages
from lmgcpy.solve.solvers import SOLVERS

FAMILIES = ("chains", "2d", "3d", "packings")
"""Families of problems that are made on the spot."""


@dataclass(frozen=True)
class Bench:
    """Choice of the problems and of the solvers that are compared on them."""

    folders: tuple[Path, ...] = ()
    """Folders with problems of the user, FCLIB files."""
    families: tuple[str, ...] = FAMILIES
    packing_sizes: tuple[int, ...] = (1000,)
    """Number of spheres of each packing."""
    solvers: tuple[str, ...] = tuple(SOLVERS)
    quick: bool = False
    """Whether the problems of every family are small, for a look."""

    def __post_init__(self):
        known_words(self.families, FAMILIES, "families")
        known_words(self.solvers, SOLVERS, "solvers")
        if not self.solvers:
            raise ValueError(f"solvers must name one at least, of {', '.join(SOLVERS)}.")
        if not self.folders and not self.families:
            raise ValueError("There is nothing to solve: name a folder with problems, or families to make.")
        for size in self.packing_sizes:
            whole(size, "spheres of a packing", minimum=10)

    def cases(self) -> Iterator[Case]:
        """All problems; each is made when it is asked for."""
        make = {
            "chains": lambda: chains((10, 100)) if self.quick else chains(),
            "2d": lambda: in_the_plane(60, 12) if self.quick else in_the_plane(),
            "3d": lambda: in_space(60, 20) if self.quick else in_space(),
            "packings": lambda: packings((100,) if self.quick else self.packing_sizes),
        }
        made = [make[family]() for family in self.families]
        return chain(*[from_folder(folder) for folder in self.folders], *made)


def known_words(words: Sequence[str], known: Sequence[str] | dict, name: str) -> None:
    """Raise ValueError for a word that is unknown or repeated."""
    for word in words:
        if word not in known:
            raise ValueError(f"{name} cannot be {word!r}{closest(word, known)}")
    if len(set(words)) < len(words):
        raise ValueError(f"{name} must name each once, got {', '.join(words)}.")


def run_bench(bench: Bench, out: Path, stages: Stages) -> list[Path]:
    """Judge every problem and write the report into a folder; returns the paths of its files, the page last.

    Interrupted, it writes what it has, and raises KeyboardInterrupt with a sentence that says so.
    """
    before = load()
    judged: list[Judged] = []
    left_out: list[str] = []
    try:
        for case in bench.cases():
            with stages.stage(f"{case.name}, {case.interactions} interactions", 1) as tick:
                result = judge(case, bench.solvers)
                tick(1)
            if result is None:
                left_out.append(case.name)
            else:
                judged.append(result)
    except KeyboardInterrupt:
        if judged:
            write_report(judged, left_out, bench.solvers, out, before)
        raise KeyboardInterrupt(f"Interrupted: the report is of {len(judged)} problems.") from None
    if not judged:
        raise ValueError(f"No impulse changes anything in these problems: {', '.join(left_out)}.")
    return write_report(judged, left_out, bench.solvers, out, before)
