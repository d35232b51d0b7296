"""Quantities in the report of the columns: weights, contents, volumes, tensions."""

from __future__ import annotations

import math

import numpy as np

from lmgcpy.experiment.column.course import GRAVITY, time_unit
from lmgcpy.experiment.column.result import ColumnResult, Fall
from lmgcpy.experiment.column.sample import SAND_DENSITY
from lmgcpy.sample import wire_content

LASTING = 0.1
"""Duration over which tensions are averaged, in time units."""


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
