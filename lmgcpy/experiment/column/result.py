"""Results of the columns of a study: with which content of wire they stand, weights, volumes, tensions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.experiment.column.course import GRAVITY, Course, time_unit
from lmgcpy.experiment.column.sample import SAND_DENSITY, Laid
from lmgcpy.sample import wire_content

KEPT_HEIGHT, KEPT_RADIUS = 0.95, 1.10
"""A column stands if it keeps this part of its height and if the radius that holds 95 % of its mass grows by no more than
this factor: half a grain each for a column of a dozen grains' height and half as many to its radius. No layer has left
it then."""

LASTING = 0.1
"""Duration over which tensions are averaged, in time units."""


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


# ------------------------------------------------------------------------------------------------------- what is reported


def grain_weight(result: ColumnResult) -> float:
    """Weight of a grain of the mean diameter [N]."""
    return SAND_DENSITY * math.pi / 6.0 * result.study.diameter**3 * GRAVITY


def linear_content(fall: Fall) -> float:
    """Length of wire in the settled column [km/m^3]."""
    return wire_content(length=fall.laid.wire_length, volume=settled_volume(fall))


def settled_volume(fall: Fall) -> float:
    """Volume of the mould up to the level below which 99 % of the grains' mass lies, at the release [m^3]."""
    return fall.laid.mould.side**2 * float(fall.pour.height[-1, 0])


def solid_fraction(fall: Fall) -> float:
    """Solid fraction of the sand in its settled volume [-]."""
    radii = fall.laid.sample.radii[fall.laid.sample.bead_count :]
    return 0.99 * 4.0 / 3.0 * math.pi * float(np.sum(radii**3)) / settled_volume(fall)


def lasting_tension(fall: Fall) -> np.ndarray:
    """Greatest and mean tension of the links during the release, running means over :data:`LASTING` [N], (s, 2).

    In a step in which the wire snaps taut the force is an impulse over the time step, so that it depends on the step.
    """
    tension, time = fall.release.tension, fall.release.time
    count = min(len(time), max(1, round(LASTING * time_unit(fall.laid) / time[0])))
    return np.column_stack([np.convolve(column, np.full(count, 1.0 / count), mode="same") for column in tension.T])
