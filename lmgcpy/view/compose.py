"""From a moment and a style to a drawing: bodies, wires, forces, walls."""

from __future__ import annotations

import numpy as np

from lmgcpy.view.boundary import cylinder_polygons, edges, wall_polygons
from lmgcpy.view.cutting import clip, section
from lmgcpy.view.drawing import Balls, Drawing, Paint, Tubes, in_space, rgb
from lmgcpy.view.layout import EXCESS, OVERLAP, long_links_of, overlaps_of
from lmgcpy.view.palette import BEAD, COHESION, CONTACT, GROUPS, PUSHING, SAND, WIRE, WRONG
from lmgcpy.view.quantities import GRAINS, WIRES, acting
from lmgcpy.view.snapshot import Snapshot, acting_lines
from lmgcpy.view.style import Style

THICK = {2: 0.35, 3: 1.0}
"""A wire's radius in radii of its beads. In 3D it holds the beads; in 2D, where they are as large as grains, one sees
them behind it."""
BEHIND = 0.5
"""By how much it is thinner behind its forces."""
SEEN_THROUGH = {"layout": 0.4, "forces": 0.6}
"""Part of the light that comes through the whole sample where something inside is to be seen."""
PALE = 0.35
"""Opacity of disks behind forces."""
WEAKEST = 0.01
"""Forces below this part of the largest are left out: they would be thinner than a pixel."""


def compose(moment: Snapshot, style: Style) -> Drawing:
    """The drawing of one panel; colours and thicknesses are not yet scaled."""
    flat = moment.dimension == 2
    wrong = _wrong(moment) if style.what == "layout" else (np.zeros(0, np.int64), np.zeros(0, np.int64))
    legend: list[tuple[str, str]] = []
    balls = _grains(moment, style, wrong[0], legend)
    wires = _wires(moment, style, wrong[1], legend)
    forces = _forces(moment, legend) if style.what == "forces" else []
    walls = wall_polygons(moment)
    below = [normal[-1] > 0.5 for normal in moment.walls.shape]
    cylinders = cylinder_polygons(moment)
    rings = [np.stack([facet[i], facet[i + 1]]) for facet in cylinders for i in (0, 2)]
    drawing = Drawing(
        flat=flat,
        balls=balls,
        tubes=wires + forces,
        walls=[polygon for polygon in walls if len(polygon)] + cylinders,
        lines=edges(walls + rings),
        ground=[] if flat else [polygon for polygon, floor in zip(walls, below, strict=True) if floor and len(polygon)],
        grain=_mean_radius(moment),
        time=moment.time,
        legend=legend,
    )
    if style.clip is not None:
        drawing = clip(drawing, style.clip, style.direction)
    if style.section is not None:
        drawing = section(drawing, style.section)
    return drawing


# ------------------------------------------------------------------------------------------------------------ bodies


def _wrong(moment: Snapshot) -> tuple[np.ndarray, np.ndarray]:
    """Ids of bodies that overlap, and numbers of links that are too long, among all links."""
    overlaps, links = overlaps_of(moment, OVERLAP), long_links_of(moment, EXCESS)
    bodies = np.unique(np.concatenate([overlaps["candidate"], overlaps["antagonist"]]))
    first = np.concatenate([[0], np.cumsum([len(chain.reference) for chain in moment.chains])]).astype(np.int64)
    return bodies, first[links["chain"]] + links["link"]


def _grains(moment: Snapshot, style: Style, wrong: np.ndarray, legend: list[tuple[str, str]]) -> list[Balls]:
    """Disks and spheres that are no beads, and in red those that overlap, beads as well."""
    rounds, flat = moment.rounds, moment.dimension == 2
    red = np.isin(rounds.body, wrong)
    bead = moment.beads[rounds.body]
    # beads are grains in a flat picture, where the wire is drawn over them
    chosen = (~bead | flat) & ~red
    if style.grains == "hidden":
        chosen &= bead
    if style.wires == "hidden":
        chosen &= ~bead
    everything = Balls(in_space(rounds.position), rounds.shape[:, 0], Paint(SAND), rim=flat)
    pieces = []
    for part, paint in _paints(moment, style, legend):
        mine = chosen & part
        if mine.any():
            whole = Balls(everything.centres, everything.radii, paint, _opacity(moment, style, mine), flat)
            pieces.append(whole.take(mine))
    if red.any():
        legend.append((f"overlaps by more than {100 * OVERLAP:g} %", WRONG))
        pieces.append(Balls(everything.centres, everything.radii, Paint(WRONG), rim=flat).take(red))
    return pieces


def _paints(moment: Snapshot, style: Style, legend: list[tuple[str, str]]) -> list[tuple[np.ndarray, Paint]]:
    """Which contactors have which paint: grains, beads."""
    body = moment.rounds.body
    bead = moment.beads[body]
    if style.grains in GRAINS:
        quantity, values = GRAINS[style.grains](moment)
        return [(np.ones(len(body), dtype=bool), Paint(values=values[body], quantity=quantity))]
    if style.grains == "color":
        words = dict.fromkeys(moment.colors[body].tolist())
        shades = {word: GROUPS[k % len(GROUPS)] for k, word in enumerate(words)}
        legend += shades.items()
        values = np.array([rgb(shades[word]) for word in moment.colors[body]]).reshape(-1, 3)
        return [(np.ones(len(body), dtype=bool), Paint(values=values))]
    return [(~bead, Paint(SAND)), (bead, Paint(BEAD))]


def _opacity(moment: Snapshot, style: Style, chosen: np.ndarray) -> float:
    """As asked for, or so that one sees what is inside: a ray through the sample crosses ``sum(pi r^2)/area`` balls."""
    if style.opacity is not None:
        return style.opacity
    if moment.dimension == 2 or style.section is not None:
        return PALE if style.what == "forces" else 1.0
    if style.what == "grains" or (style.what == "layout" and (not moment.chains or style.wires == "hidden")):
        return 1.0
    rounds = moment.rounds
    centres, radii = rounds.position[chosen], rounds.shape[chosen, 0]
    sides = centres.max(axis=0) - centres.min(axis=0) + 2.0 * radii.mean()
    crossed = float(np.pi * (radii**2).sum() / np.prod(sides) ** (2.0 / 3.0))
    return float(1.0 - SEEN_THROUGH[style.what] ** (1.0 / max(crossed, 1.0)))


# ------------------------------------------------------------------------------------------------------------- wires


def _wires(moment: Snapshot, style: Style, wrong: np.ndarray, legend: list[tuple[str, str]]) -> list[Tubes]:
    """Links as tubes, and in red those that are too long."""
    if style.wires == "hidden" or not moment.chains:
        return []
    a = np.concatenate([chain.path[:-1] for chain in moment.chains])
    b = np.concatenate([chain.path[1:] for chain in moment.chains])
    radius = moment.scene["bodies"]["link_radius"]
    thickness = THICK[moment.dimension] * np.minimum(radius[a], radius[b])
    if style.what == "forces":
        thickness *= BEHIND
    thickness[thickness == 0.0] = 0.1 * _mean_radius(moment)  # of bodies that are no disks
    if style.wires in WIRES:
        quantity, values = WIRES[style.wires](moment)
        paint = Paint(values=values, quantity=quantity)
    else:
        label, color = ("course of the wire", BEAD) if style.what == "forces" else ("wire", WIRE)
        paint = Paint(color)
        legend.append((label, color))
    tubes = Tubes(in_space(moment.positions[a]), in_space(moment.positions[b]), thickness, paint)
    red = np.zeros(len(a), dtype=bool)
    red[wrong] = True
    pieces = [tubes.take(~red)]
    if red.any():
        legend.append(("longer than its reference", WRONG))
        pieces.append(Tubes(tubes.starts, tubes.ends, 1.3 * thickness, Paint(WRONG), level=2).take(red))
    return pieces


def _mean_radius(moment: Snapshot) -> float:
    """Of the grains, where there are none of the beads [m]."""
    radii, bead = moment.rounds.shape[:, 0], moment.beads[moment.rounds.body]
    chosen = radii if bead.all() else radii[~bead]
    return float(chosen.mean()) if len(chosen) else 1.0


# ------------------------------------------------------------------------------------------------------------ forces


def _forces(moment: Snapshot, legend: list[tuple[str, str]]) -> list[Tubes]:
    """Normal forces along the line of the two centres; at a wall from the contact point to the centre."""
    forces = acting(moment, "what='forces'")
    start, end = acting_lines(moment)
    link = np.arange(len(forces.normal)) < moment.link_count
    return force_tubes(in_space(start), in_space(end), forces.normal, link, legend)


def force_tubes(
    start: np.ndarray, end: np.ndarray, normal: np.ndarray, link: np.ndarray, legend: list[tuple[str, str]]
) -> list[Tubes]:
    """Tubes as thick as normal forces (m,), pushing positive [N], from ``start`` to ``end`` [m], (m, 3) each.

    ``link``: whether a force acts in a link, (m,). Colours tell contacts from links and compression from tension; the
    entries of those that occur are added to the ``legend``.
    """
    size = np.abs(normal)
    strong = size > WEAKEST * size.max(initial=0.0)
    pushing = normal > 0.0
    pieces = []
    for chosen, label, color, level in (
        (pushing & ~link, "contact reaction", CONTACT, 2),
        (~pushing & ~link, "contact in tension", COHESION, 2),
        (pushing & link, "link in compression", PUSHING, 3),
        (~pushing & link, "wire in tension", WIRE, 3),
    ):
        mine = chosen & strong
        if mine.any():
            legend.append((label, color))
            pieces.append(Tubes(start, end, size, Paint(color), by_force=True, level=level).take(mine))
    return pieces
