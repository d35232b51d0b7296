"""The columns side by side: the same sand without wire and with more and more of it, and the content at which it stands."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from lmgcpy.errors import named_arguments, number, one_of, shown, whole
from lmgcpy.experiment.column.course import (
    LEAST,
    POUR,
    RELEASE,
    ColumnState,
    Course,
    SandColumn,
    dry_run_out,
    let_go,
    time_step,
    time_unit,
)
from lmgcpy.experiment.column.result import ColumnResult, Fall, middle, run_name, words
from lmgcpy.experiment.column.sample import Laid, lay_column
from lmgcpy.experiment.study.engine import Site, Study, Task
from lmgcpy.experiment.study.folder import StudyFolder
from lmgcpy.experiment.thread_course import WIRES
from lmgcpy.solve.sweeps.accelerated import AcceleratedGaussSeidel

GROUND_MARGIN = 1.4
"""Radius of the rough ground over the expected radius of the run-out of dry sand."""


@named_arguments
@dataclass(frozen=True)
class ColumnStudy(Study):
    """Study of columns with these ``contents`` of wire, and of the dry column.

    A content is the wire's length times the mean grain ``diameter`` [m] squared, over the volume of the sand. ``aspect`` is
    the height over the radius; ``bead_diameter``, also of a thread, is in mean grain diameters; ``wire`` is
    "beads", or "thread", smooth, with nodes at most ``node_distance`` mean grain diameters apart. ``travel`` is the
    displacement in one step of a grain that has fallen through the whole height, in radii of a bead. If some contents stand
    and some do not, ``refinements`` bisections find the least content that stands.
    """

    COMMAND: ClassVar[str] = "column"
    FORMER: ClassVar[Mapping[str, Any]] = {"wire": "beads", "node_distance": 0.7}
    # an end of the wire whips faster than a grain falls: alert distances follow the fastest body, contacts are seen
    IGNORED: ClassVar[tuple[str, ...]] = ("In the step to t = .* more than half its radius",)

    contents: tuple[float, ...] = (0.05, 0.2, 0.8)
    grain_count: int = 1000
    aspect: float = 2.0
    friction: float = 0.5
    diameter: float = 5e-4
    bead_diameter: float = 0.3
    wire: str = "beads"
    node_distance: float = 0.7
    seed: int = 0
    refinements: int = 2
    tolerance: float = 1e-2
    max_iterations: int = 200
    travel: float = 1.0
    threads: int = 2

    def __post_init__(self):
        if not isinstance(self.contents, (tuple, list)):
            raise TypeError(f"contents must be a tuple of numbers, got {shown(self.contents)}.")
        contents = tuple(number(content, "contents", above=0.0, maximum=10.0) for content in self.contents)
        if not contents or len(set(contents)) < len(contents):
            raise ValueError(
                f"contents must name each content once, got {', '.join(map('{:g}'.format, contents)) or 'none'}."
            )
        object.__setattr__(self, "contents", tuple(sorted(contents)))
        whole(self.grain_count, "grains", minimum=10)
        number(self.aspect, "aspect", minimum=0.1, maximum=20.0)
        number(self.friction, "friction", minimum=0.0)
        number(self.diameter, "diameter", above=0.0, unit="m")
        number(self.bead_diameter, "bead_diameter", minimum=0.05, maximum=0.45)
        one_of(self.wire, "wire", WIRES)
        number(self.node_distance, "node_distance", above=0.0)
        if self.wire == "beads" and self.node_distance != ColumnStudy.node_distance:
            raise ValueError(
                "node_distance is of a thread, and the wire of this study has beads: give wire='thread' (--wire thread)."
            )
        whole(self.seed, "seed")
        whole(self.refinements, "refinements", maximum=20)
        number(self.tolerance, "tolerance", above=0.0, maximum=1.0)
        whole(self.max_iterations, "max_iterations", minimum=1)
        number(self.travel, "travel", above=0.0, maximum=4.0)
        whole(self.threads, "threads", minimum=1)

    def quick(self) -> ColumnStudy:
        """A study of a small column with one content, for a first look: 300 grains."""
        return replace(self, contents=(0.4,), grain_count=300)

    @property
    def reach(self) -> float:
        """Radius of the rough ground, in radii of the column."""
        return GROUND_MARGIN * (1.0 + dry_run_out(self.aspect))

    def lay_column(self, content: float) -> Laid:
        """The column with this content of wire, before it settles."""
        return lay_column(
            grain_count=self.grain_count,
            content=content,
            aspect=self.aspect,
            diameter=self.diameter,
            bead_diameter=self.bead_diameter,
            seed=self.seed,
            thread=self.wire == "thread",
            node_distance=self.node_distance,
        )

    # ------------------------------------------------------------------------------------------- what the engine asks for

    def lay(self, site: Site) -> dict[float, Laid]:
        """The columns by content, the dry one with them."""
        return {content: self.lay_column(content) for content in (0.0, *self.contents)}

    def tests(self, prepared: dict[float, Laid], done: Mapping[str, Fall]) -> list[Task]:
        wanted = prepared
        if done:
            falls = {fall.content: fall.stands for fall in done.values()}
            between = middle(falls) if len(done) < len(prepared) + self.refinements else None
            wanted = {} if between is None or between in falls else {between: self.lay_column(between)}
        # the longest first, so that no thread waits for the last
        contents = sorted(wanted, reverse=True)
        return [Task(run_name("fall", content), _fall, (self, content, wanted[content])) for content in contents]

    def result(self, prepared: Any, done: Mapping[str, Fall]) -> ColumnResult:
        return ColumnResult(self, tuple(sorted(done.values(), key=lambda fall: fall.content)))

    def measures(self, result: ColumnResult) -> tuple[dict[str, float], dict[str, dict[str, np.ndarray]]]:
        numbers: dict[str, float] = {}
        curves: dict[str, dict[str, np.ndarray]] = {}
        for fall in result.falls:
            name, release = words(fall.content), fall.release
            numbers[f"{name}: height kept"] = fall.kept_height
            numbers[f"{name}: growth of the radius"] = fall.grown_radius
            numbers[f"{name}: stands"] = float(fall.stands)
            height, radius = release.height[:, 0], release.spread[:, 0]
            curves[name] = {"time [s]": release.time, "height [m]": height, "radius [m]": radius}
        return numbers, curves

    def report(self, result: ColumnResult, folder: StudyFolder) -> list[Path]:
        from lmgcpy.experiment.column.report import write_report

        return write_report(result, folder)


def _fall(site: Site, study: ColumnStudy, content: float, laid: Laid) -> Fall:
    """A column poured and released."""
    unit, reach = time_unit(laid), study.reach * laid.mould.radius
    solver = AcceleratedGaussSeidel(tolerance=study.tolerance, max_iterations=study.max_iterations)

    def course(what: str, units: float, least: float, state: ColumnState | None) -> Course:
        return site.run(
            run_name(what, content),
            f"{what}, {words(content)}",
            math.ceil(units * unit / time_step(laid, study.travel)),
            let_go,
            SandColumn(laid, friction=study.friction, reach=reach, mould=what == "pour", state=state, seed=study.seed),
            duration=units * unit,
            least=least * unit,
            travel=study.travel,
            solver=solver,
            name=f"column, {what}",
        )

    pour = course("pour", POUR, 0.0, None)
    release = course("release", RELEASE, LEAST, pour.end)
    return Fall(content, laid, pour, release)
