"""The columns side by side: the same sand without wire and with more and more of it, and the content at which it stands."""

from __future__ import annotations

import math
import threading
import warnings
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from lmgcpy.dynamics.interrupt import between_steps
from lmgcpy.errors import named_arguments, number, shown, whole
from lmgcpy.experiment.column import LEAST, POUR, RELEASE, Column, Course, let_go, time_step, time_unit
from lmgcpy.experiment.column_measure import dry_run_out
from lmgcpy.experiment.column_sample import Laid, lay_column
from lmgcpy.experiment.stages import Stages
from lmgcpy.solve.accelerated import AcceleratedGaussSeidel

if TYPE_CHECKING:
    from lmgcpy.experiment.column_folder import ColumnFolder

KEPT_HEIGHT, KEPT_RADIUS = 0.95, 1.10
"""A column stands if it keeps this part of its height and if the radius that holds 95 % of its mass grows by no more than
this factor: half a grain each for a column of a dozen grains' height and half as many to its radius. No layer has left
it then."""
GROUND_MARGIN = 1.4
"""The rough ground reaches so many times as far as dry sand is expected to run."""


@named_arguments
@dataclass(frozen=True)
class ColumnStudy:
    """What to compute: columns with these ``contents`` of wire beside the dry one.

    A content is the wire's length times the mean grain ``diameter`` [m] squared, over the volume of the sand; ``aspect``:
    height over radius; ``bead_diameter`` in mean grain diameters; ``travel``: way of a grain that has fallen through
    the whole height in one step, in radii of a bead. If some contents stand and some do not, the least is found by
    ``refinements`` bisections.
    """

    contents: tuple[float, ...] = (0.05, 0.2, 0.8)
    grain_count: int = 1000
    aspect: float = 2.0
    friction: float = 0.5
    diameter: float = 5e-4
    bead_diameter: float = 0.3
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
        whole(self.seed, "seed")
        whole(self.refinements, "refinements", maximum=20)
        number(self.tolerance, "tolerance", above=0.0, maximum=1.0)
        whole(self.max_iterations, "max_iterations", minimum=1)
        number(self.travel, "travel", above=0.0, maximum=4.0)
        whole(self.threads, "threads", minimum=1)

    def quick(self) -> ColumnStudy:
        """The same on a small column with one content, for a look: 300 grains."""
        return replace(self, contents=(0.4,), grain_count=300)

    @property
    def reach(self) -> float:
        """Of the rough ground, in radii of the column."""
        return GROUND_MARGIN * (1.0 + dry_run_out(self.aspect))

    def lay(self, content: float) -> Laid:
        """The column with this content of wire, before it settles."""
        return lay_column(
            grain_count=self.grain_count,
            content=content,
            aspect=self.aspect,
            diameter=self.diameter,
            bead_diameter=self.bead_diameter,
            seed=self.seed,
        )


@dataclass(frozen=True)
class Fall:
    """What became of one column."""

    content: float
    """Asked for; :attr:`Laid.content` is what was laid."""
    laid: Laid
    pour: Course
    release: Course

    @property
    def kept_height(self) -> float:
        """Height at the end over that at the release."""
        return float(self.release.height[-1, 0] / self.pour.height[-1, 0])

    @property
    def grown_radius(self) -> float:
        """Radius that holds 95 % of the mass at the end over that at the release."""
        return float(self.release.spread[-1, 0] / self.pour.spread[-1, 0])

    @property
    def stands(self) -> bool:
        """See :data:`KEPT_HEIGHT`."""
        return self.kept_height >= KEPT_HEIGHT and self.grown_radius <= KEPT_RADIUS


@dataclass(frozen=True)
class ColumnResult:
    """All that a study computed."""

    study: ColumnStudy
    falls: tuple[Fall, ...]
    """By content, the dry column first."""

    @property
    def dry(self) -> Fall:
        """The column without wire."""
        return self.falls[0]

    @property
    def seconds(self) -> float:
        """Time of the clock that the steps of all runs took [s]."""
        return sum(fall.pour.seconds + fall.release.seconds for fall in self.falls)


def run_study(
    study: ColumnStudy, stages: Stages | None = None, folder: ColumnFolder | None = None, *, resume: bool = False
) -> ColumnResult:
    """Pour and release the columns, as many at once as there are threads.

    With a ``folder`` every run is kept in a file there; ``resume``: they are there in part already, and go on. Ctrl-C
    (KeyboardInterrupt), or an error in one run, ends every run between two steps, with good files.
    """
    stages = stages or Stages(quiet=True)
    failed = threading.Event()
    # what is asked for and cannot be laid is told before anything is written or computed
    laid = {content: study.lay(content) for content in (0.0, *study.contents)}
    if folder is not None and not resume:
        folder.begin(study)
    with between_steps() as pressed, warnings.catch_warnings():
        # an end of the wire whips faster than a grain falls: alert distances follow the fastest body, contacts are seen
        warnings.filterwarnings("ignore", message="In the step to t = .* more than half its radius")

        def interrupted() -> bool:
            return pressed() or failed.is_set()

        def fall(content: float) -> Fall:
            try:
                return _fall(study, content, laid[content], stages, folder, interrupted)
            except BaseException:
                failed.set()
                raise

        falls: dict[float, Fall] = {}
        with ThreadPoolExecutor(study.threads) as pool:
            wanted = sorted(laid, reverse=True)  # the longest first, so that no thread waits for the last
            refined = 0
            while wanted:
                runs = {content: pool.submit(fall, content) for content in wanted}
                errors = [error for error in (run.exception() for run in runs.values()) if error is not None]
                if errors:  # an error before the interruptions that it caused
                    raise min(errors, key=lambda error: isinstance(error, KeyboardInterrupt))
                if pressed():
                    raise KeyboardInterrupt
                falls.update({content: run.result() for content, run in runs.items()})
                between = middle({content: fall.stands for content, fall in falls.items()})
                wanted = [between] if between is not None and refined < study.refinements else []
                refined += len(wanted)
                laid.update({content: study.lay(content) for content in wanted})
    return ColumnResult(study, tuple(falls[content] for content in sorted(falls)))


def _fall(study: ColumnStudy, content: float, laid: Laid, stages: Stages, folder: ColumnFolder | None, interrupted) -> Fall:
    unit, reach = time_unit(laid), study.reach * laid.mould.radius
    solver = AcceleratedGaussSeidel(tolerance=study.tolerance, max_iterations=study.max_iterations)

    def course(what: str, units: float, least: float, state) -> Course:
        column = Column(laid, friction=study.friction, reach=reach, mould=what == "pour", state=state, seed=study.seed)
        name = run_name(what, content)
        with stages.stage(f"{what}, {words(content)}", math.ceil(units * unit / time_step(laid, study.travel))) as tick:
            return let_go(
                column,
                duration=units * unit,
                least=least * unit,
                travel=study.travel,
                solver=solver,
                name=f"column, {what}",
                file=None if folder is None else folder.run_file(name),
                on_step=tick,
                interrupted=interrupted,
            )

    pour = course("pour", POUR, 0.0, None)
    release = course("release", RELEASE, LEAST, pour.end)
    return Fall(content, laid, pour, release)


def run_name(what: str, content: float) -> str:
    """Name of a run: "pour" or "release" of a column."""
    return f"{what}-{content}" if content > 0.0 else f"{what}-dry"


def words(content: float) -> str:
    """A column as lists and legends call it."""
    return f"wire {content:.3g}" if content > 0.0 else "dry sand"


def bracket(stands: Mapping[float, bool]) -> tuple[float | None, float | None]:
    """(greatest content below that falls, least that stands); None where there is none. The dry column has content 0.

    More wire is taken to hold better: of contents above the least that stands nothing is asked.
    """
    standing = [content for content, stood in stands.items() if stood]
    least = min(standing, default=None)
    fallen = [content for content, stood in stands.items() if not stood and (least is None or content < least)]
    return max(fallen, default=None), least


def middle(stands: Mapping[float, bool]) -> float | None:
    """The content to try next: in the middle of the bracket; None where two contents of wire make none."""
    below, above = bracket(stands)
    if not below or above is None:
        return None
    return float(f"{math.sqrt(below * above):.3g}")  # three digits, as it is told
