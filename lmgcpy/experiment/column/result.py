"""Results of the columns of a study, and the content of wire with which they stand."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from lmgcpy.experiment.column.course import Course
from lmgcpy.experiment.column.sample import Laid

KEPT_HEIGHT, KEPT_RADIUS = 0.95, 1.10
"""A column stands if it keeps this part of its height and if the radius that holds 95 % of its mass grows by no more than
this factor: half a grain each for a column of a dozen grains' height and half as many to its radius. No layer has left
it then."""


@dataclass(frozen=True)
class Fall:
    """Result of one column."""

    content: float
    """Requested wire content; :attr:`Laid.content` is the content that was laid."""
    laid: Laid
    pour: Course
    release: Course

    @property
    def kept_height(self) -> float:
        """Height at the end over the height at the release."""
        return float(self.release.height[-1, 0] / self.pour.height[-1, 0])

    @property
    def grown_radius(self) -> float:
        """Radius that holds 95 % of the mass at the end, over the same radius at the release."""
        return float(self.release.spread[-1, 0] / self.pour.spread[-1, 0])

    @property
    def stands(self) -> bool:
        """Whether the column stands; see :data:`KEPT_HEIGHT`."""
        return self.kept_height >= KEPT_HEIGHT and self.grown_radius <= KEPT_RADIUS


@dataclass(frozen=True)
class ColumnResult:
    """All that a study computed."""

    study: Any
    """A :class:`~lmgcpy.experiment.column.study.ColumnStudy`."""
    falls: tuple[Fall, ...]
    """The columns by content, the dry one first."""

    @property
    def dry(self) -> Fall:
        """The column without wire."""
        return self.falls[0]

    @property
    def seconds(self) -> float:
        """Wall clock time of the steps of all runs [s]."""
        return sum(fall.pour.seconds + fall.release.seconds for fall in self.falls)


def run_name(what: str, content: float) -> str:
    """Name of the run file of a "pour" or "release"."""
    return f"{what}-{content}" if content > 0.0 else f"{what}-dry"


def words(content: float) -> str:
    """Name of a column in lists and legends."""
    return f"wire {content:.3g}" if content > 0.0 else "dry sand"


def bracket(stands: Mapping[float, bool]) -> tuple[float | None, float | None]:
    """(greatest content that falls, least content that stands), None for each that does not exist. The dry column has
    content 0.

    More wire is assumed to hold better: contents above the least content that stands do not matter.
    """
    standing = [content for content, stood in stands.items() if stood]
    least = min(standing, default=None)
    fallen = [content for content, stood in stands.items() if not stood and (least is None or content < least)]
    return max(fallen, default=None), least


def middle(stands: Mapping[float, bool]) -> float | None:
    """The content to try next, in the middle of the bracket; None if the bracket has not two contents of wire."""
    below, above = bracket(stands)
    if not below or above is None:
        return None
    return float(f"{math.sqrt(below * above):.3g}")  # three digits, as in the summary
