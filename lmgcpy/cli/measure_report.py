"""The lines of ``lmgcpy measure``: what a frame of a run measures, in words and numbers with units."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from lmgcpy import measure
from lmgcpy.errors import AXES
from lmgcpy.io.run import Run
from lmgcpy.measure.moment import Moment, frame_number, moment
from lmgcpy.measure.stress import volumes_of
from lmgcpy.measure.wire_fabric import volume_if_known

CHORD = 10
"""Links of the longer pieces of wire whose stretch is shown."""
ROUND_OFF = 1e-9
"""Part of a number below which its error is due to rounding, and is not shown."""
BINS = 6
"""Bins of directions that are shown."""


class Entry(NamedTuple):
    """A number in words; ``value`` is nan if there is none, ``error`` is nan if none is known."""

    label: str
    value: float
    unit: str = ""
    error: float = math.nan


@dataclass(frozen=True)
class Subject:
    """What is measured: a frame of a run, the frame since which it moved, and the axis by which directions are sorted."""

    run: Run
    frame: int
    since: int
    axis: str

    @classmethod
    def of(cls, run: Run, frame: int, since: int, axis: str | None) -> Subject:
        """The subject of a call; the axis is by default the axis of the test that the run notes, or upward."""
        names = AXES[: run.dimension]
        noted = run.notes.get("axis")
        chosen = axis or (noted if isinstance(noted, str) and noted in tuple(names) else names[-1])
        if chosen not in names:
            raise ValueError(f"--axis {chosen} does not exist: the run is in 2D, with the axes {' and '.join(names)}.")
        return cls(run, frame_number(run, frame, "--frame"), frame_number(run, since, "--since"), chosen)

    @cached_property
    def now(self) -> Moment:
        """The frame as the measures read it."""
        return moment(self.run, self.frame, "lmgcpy measure")

    @property
    def axes(self) -> str:
        """Names of the axes."""
        return AXES[: self.run.dimension]

    @cached_property
    def has_wire(self) -> bool:
        """Whether the scene has chains."""
        return len(self.now.scene["chains"]["law"]) > 0

    @cached_property
    def has_step(self) -> bool:
        """Whether a step led to the frame."""
        return int(self.run.steps[self.frame]) > 0

    @cached_property
    def grain_size(self) -> float:
        """Mean diameter of the bodies with bounds that belong to no chain, of all if there are none [m]: of the disks or
        spheres that have their volumes, or if these are not known, that hold them."""
        bounded = self.now.bounded
        grains = bounded & ~self.now.beads
        chosen = grains if grains.any() else bounded
        volume, d = volumes_of(self.now), self.run.dimension
        unit = math.pi if d == 2 else 4.0 / 3.0 * math.pi
        radius = np.where(volume > 0.0, np.abs(volume / unit) ** (1.0 / d), self.now.extent)
        return 2.0 * float(radius[chosen].mean()) if chosen.any() else math.nan


def report(subject: Subject) -> dict[str, list[Entry | str]]:
    """Entries by heading, and sentences if something cannot be measured."""
    parts: dict[str, Callable[[Subject], Iterator[Entry | str]]] = {
        "Sample": _sample,
        "Contacts": _contacts,
        "Strain": _strain,
        "Wire": _wire,
        "Friction and slip of the wire": _friction,
    }
    found = {heading: list(part(subject)) for heading, part in parts.items()}
    return {heading: entries for heading, entries in found.items() if entries}


def _sample(subject: Subject) -> Iterator[Entry | str]:
    now, run, frame = subject.now, subject.run, subject.frame
    bounded, beads = now.bounded, now.beads
    solid, volume = float(volumes_of(now)[bounded].sum()), volume_if_known(now, None)
    unit = f"m^{run.dimension}"
    if run.dimension == 2:
        yield "In 2D forces, masses and volumes are those of one metre of depth."
    yield Entry("grains, which belong to no chain", int((bounded & ~beads).sum()))
    yield Entry("beads, which belong to chains", int(beads.sum()))
    yield Entry("mean diameter of the grains" if (bounded & ~beads).any() else "mean diameter", subject.grain_size, "m")
    if run.dimension == 3 and len(axes := measure.long_axes(run, frame=frame)):
        for k, axis in enumerate(subject.axes):
            yield Entry(f"fabric of long axes, mean of t_{axis} t_{axis}", float(axes.fabric[k, k]))
    if math.isnan(volume):
        yield "Volume and stress are not known: the scene has neither opposite walls across each axis nor a periodic cell."
        return
    yield Entry("volume between the walls, or of the cell", volume, unit)
    yield Entry("solid part of the volume, overlaps twice", solid / volume)
    if solid > 0.0:
        yield Entry("void ratio, volume of voids over solid volume", volume / solid - 1.0)
    if not subject.has_step:
        yield "Nothing acts before the first step: stress, contacts and tensions are those of later frames."
        return
    sigma = measure.stress(run, frame=frame)
    wire = sum((sigma[law] for law in now.links if law in sigma), start=np.zeros_like(sigma["total"]))
    for k, axis in enumerate(subject.axes):
        yield Entry(f"stress along {axis}, traction positive", float(sigma["total"][k, k]), "Pa")
        if subject.has_wire:
            yield Entry(f"  part of the wire in the stress along {axis}", float(wire[k, k]), "Pa")
    pressures = -measure.principal(sigma["total"])
    greatest, least = float(pressures[-1]), float(pressures[0])
    yield Entry("mean pressure p, mean of the principal stresses", float(pressures.mean()), "Pa")
    yield Entry("deviator q, greatest less smallest principal stress", greatest - least, "Pa")
    if least > 0.0:
        angle = math.degrees(math.asin((greatest - least) / (greatest + least)))
        yield Entry("mobilised angle of friction, sin phi = q / (s1 + s3)", angle, "degrees")


def _contacts(subject: Subject) -> Iterator[Entry | str]:
    run, frame = subject.run, subject.frame
    if not subject.has_step:
        yield "There are none before the first step."
        return
    net, kinds = measure.network(run, frame=frame), measure.contact_kinds(run, frame=frame)
    words = "between grains", "of grains and beads", "between beads", "at walls"
    for kind, count, normal, share in zip(words, kinds.contacts, kinds.normal, kinds.sliding_share, strict=True):
        if not count:
            continue
        yield Entry(f"contacts {kind} that push", int(count))
        yield Entry("  their mean normal force", float(normal), "N")
        if not math.isnan(share):
            yield Entry("  share that slides", 100.0 * share, "%")
    if not kinds.contacts.sum():
        yield "No contact pushes."
        return
    forces = measure.contact_forces(run, frame=frame)
    yield Entry("share of contacts that push more than the mean", 100.0 * float((forces.relative > 1.0).mean()), "%")
    yield Entry("greatest normal force over the mean", float(forces.relative.max()))
    yield Entry("contacts of a body, without rattlers", net.coordination)
    yield Entry("contacts of a body, with rattlers", net.coordination_with_rattlers)
    grains = subject.now.bounded & ~subject.now.beads
    if grains.any():
        share = grains[net.rattlers].sum() / grains.sum()
        yield Entry("share of the grains that are rattlers: fewer than two contacts", 100.0 * float(share), "%")
    yield from (
        Entry(f"fabric of the contacts, mean of n_{k} n_{k}", float(net.fabric[i, i])) for i, k in enumerate(subject.axes)
    )


def _strain(subject: Subject) -> Iterator[Entry | str]:
    run = subject.run
    if subject.frame == subject.since:
        yield f"The strain from frame {subject.since} to itself is zero: give another --frame or --since."
        return
    try:
        found = measure.mean_strain(run, frame=subject.frame, since=subject.since)
    except ValueError as error:
        yield str(error)
        return
    for k, axis in enumerate(subject.axes):
        yield Entry(f"strain along {axis}, fitted to all bodies", found.strain[k, k], "", found.standard_error[k, k])
        if not math.isnan(found.box[k, k]):
            yield Entry(f"  of the box along {axis}", found.box[k, k])
    yield Entry("change of the volume, fitted", found.volumetric)
    if not np.isnan(found.box).any():
        yield Entry("  of the box", float(np.linalg.det(np.eye(run.dimension) + found.box)) - 1.0)
    principal = np.linalg.eigvalsh(found.strain)
    yield Entry("greatest shear strain, (e1 - e3) / 2", 0.5 * np.ptp(principal))
    pairs = [(i, j) for i in range(run.dimension) for j in range(i)]
    i, j = pairs[int(np.argmax([abs(found.rotation[pair]) for pair in pairs]))]
    yield Entry(f"greatest rotation, from {subject.axes[j]} to {subject.axes[i]}", abs(found.rotation[i, j]), "rad")
    yield Entry("displacement that the fit leaves, root mean square", found.non_affine, "m")
    yield Entry("  in mean diameters of the grains", found.non_affine / subject.grain_size)
    yield Entry("share of the fluctuating displacement that is not affine", 100.0 * found.non_affine_share, "%")


def _wire(subject: Subject) -> Iterator[Entry | str]:
    run, frame = subject.run, subject.frame
    if not subject.has_wire:
        yield "There is no wire: the scene has no chains."
        return
    fabric, links = measure.wire_fabric(run, frame=frame), measure.wire_links(run, frame=frame)
    yield Entry("links", fabric.link_count)
    yield Entry("length of all wires", fabric.length, "m")
    if not math.isnan(fabric.volume):
        yield Entry("length of wire per volume", fabric.length_per_volume, "1/m^2" if run.dimension == 3 else "1/m")
    for k, axis in enumerate(subject.axes):
        label = f"fabric of the wire, mean of t_{axis} t_{axis} by length"
        yield Entry(label, fabric.fabric[k, k], "", fabric.fabric_error[k, k])
    yield Entry("anisotropy of the fabric, 0 to 1", fabric.anisotropy)
    if not subject.has_step:
        return
    yield Entry("share of the wire that is taut", 100.0 * fabric.taut_share, "%")
    if not math.isnan(fabric.slack):
        yield Entry("mean slack of the links that do not pull, a strain", fabric.slack)
    yield Entry("greatest stretch of a link over its reference", max(float(links.stretch.max()), 0.0))
    yield Entry("mean tension of all links", float(links.tension.mean()), "N")
    yield Entry("greatest tension", float(links.tension.max()), "N")
    tension, runs = measure.tension_correlation(run, frame=frame), measure.taut_runs(run, frame=frame)
    if not math.isnan(tension.correlation_length):
        yield Entry("length along the wire over which tension is correlated", tension.correlation_length, "m")
        yield Entry("  in links", tension.correlation_length / float(links.length.mean()))
    if len(runs):
        yield Entry("runs of links that are taut without a break", len(runs))
        yield Entry("  mean length of the run of a taut link", runs.mean_length, "m")
        yield Entry("  longest run", float(runs.length.max()), "m")
        yield Entry("  friction per length q by which T = q L/2 fits their greatest tensions", runs.anchorage, "N/m")


def _friction(subject: Subject) -> Iterator[Entry | str]:
    run, frame = subject.run, subject.frame
    if not subject.has_wire:
        return
    if subject.has_step:
        beads = measure.wire_contacts(run, frame=frame)
        if math.isnan(beads.sliding_share):
            yield "Nothing but wire touches the wire."
        else:
            yield Entry("share of the contacts of beads with sand and walls that slide", 100.0 * beads.sliding_share, "%")
        if not math.isnan(beads.force_per_length):
            yield Entry("force of contacts along taut wire, per length", beads.force_per_length, "N/m")
            yield Entry("  by friction", beads.friction_per_length, "N/m")
            yield Entry("  greatest that friction could give, mu times the normal forces", beads.limit_per_length, "N/m")
    if subject.frame == subject.since:
        return
    try:
        slip = measure.bead_slip(run, frame=frame, since=subject.since)
    except ValueError:
        yield "How the beads slip through the sand cannot be told: there are too few grains."
        return
    size = subject.grain_size
    for name, part, along in (
        ("mean strain of the grains", slip.from_mean, slip.along_mean),
        ("surrounding grains", slip.from_neighbours, slip.along_neighbours),
    ):
        if np.isnan(part).any():
            continue
        across = np.sqrt(np.maximum((part**2).sum(axis=1) - along**2, 0.0))
        yield Entry(f"slip of beads along the wire from the {name}, root mean square", _size(along), "m")
        yield Entry("  in mean diameters of the grains", _size(along) / size)
        yield Entry("  across the wire", _size(across), "m")


def _size(values: np.ndarray) -> float:
    """Root mean square."""
    return float(np.sqrt((values**2).mean()))


def direction_table(subject: Subject) -> list[list[str]]:
    """Rows of a table of the wire by direction: the head, the units, and one for each bin; no rows if there is no wire, or
    neither a step nor a motion."""
    columns: list[tuple[str, str, list[str]]] = []
    if subject.has_wire and subject.has_step:
        columns += _pulling(subject)
    if subject.has_wire and subject.frame != subject.since:
        with suppress(ValueError):  # too few bodies for a mean strain, as the lines above say
            columns += _stretching(subject, first=not columns)
    cells = [[head, unit, *column] for head, unit, column in columns]
    return [list(row) for row in zip(*cells, strict=True)]


def _pulling(subject: Subject) -> Iterator[tuple[str, str, list[str]]]:
    """Columns of the loads of the links: head, unit, cells."""
    axis, k = subject.axis, subject.axes.index(subject.axis)
    found = measure.tension_by_direction(subject.run, frame=subject.frame, axis=axis, bins=BINS)
    yield f"angle to {axis}", "degrees", _bounds(found)
    yield "links", "", [str(count) for count in found.links]
    yield "taut", "%", _cells(100.0 * found.taut_share, 100.0 * found.taut_share_error)
    yield "mean tension", "N", _cells(found.tension, found.tension_error)
    if not np.isnan(found.stress).any():
        along = found.stress[:, k, k]
        across = (np.trace(found.stress, axis1=1, axis2=2) - along) / (subject.run.dimension - 1)
        yield f"stress along {axis}", "Pa", [plain(value) for value in along]
        yield "mean across", "Pa", [plain(value) for value in across]


def _stretching(subject: Subject, *, first: bool) -> Iterator[tuple[str, str, list[str]]]:
    """Columns of how links and chords stretch; with the bounds of the bins if they are the ``first``."""
    for size in (1, CHORD):
        found = measure.stretch_by_direction(
            subject.run, frame=subject.frame, since=subject.since, axis=subject.axis, bins=BINS, links=size
        )
        if first and size == 1:
            yield f"angle to {subject.axis}", "degrees", _bounds(found)
        cells = _cells(100.0 * found.stretch, 100.0 * found.stretch_error)
        yield "stretch of links" if size == 1 else f"of chords of {size}", "%", cells
        yield "affine", "%", [plain(value) for value in 100.0 * found.affine_finite]


def _bounds(found: measure.TensionByDirection | measure.StretchByDirection) -> list[str]:
    return [f"{low:.0f} to {high:.0f}" for low, high in zip(found.lower, found.upper, strict=True)]


def _cells(values: np.ndarray, errors: np.ndarray) -> list[str]:
    return [with_error(value, error) for value, error in zip(values.tolist(), errors.tolist(), strict=True)]


def plain(value: float) -> str:
    """A number to four digits, "-" if there is none."""
    if math.isnan(value):
        return "-"
    return str(int(value)) if float(value).is_integer() and abs(value) < 1e9 else f"{value:.4g}"


def with_error(value: float, error: float) -> str:
    """A number and its standard error, to the second digit of the error."""
    if math.isnan(value) or math.isnan(error) or error <= ROUND_OFF * abs(value):
        return plain(value)
    digits = max(1 - math.floor(math.log10(error)), 0)
    if digits > 6 or max(abs(value), error) >= 1e7:
        return f"{value:.4g} +- {error:.2g}"
    return f"{value:.{digits}f} +- {error:.{digits}f}"
