"""The drawing of a snapshot in a style: bodies, wires, forces, walls; and panels of such drawings through time."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from lmgcpy.errors import shown
from lmgcpy.io.run import Run
from lmgcpy.view.boundary import cell_outline, cylinder_polygons, edges, polylines, wall_polygons
from lmgcpy.view.cutting import clip, reaching, section, within
from lmgcpy.view.drawing import (
    BEAD,
    COHESION,
    CONTACT,
    GROUPS,
    PUSHING,
    SAND,
    WIRE,
    WRONG,
    Balls,
    Drawing,
    Paint,
    Tubes,
    in_space,
    rgb,
)
from lmgcpy.view.layout import EXCESS, OVERLAP, long_links_of, overlaps_of
from lmgcpy.view.quantities import GRAINS, WIRES, acting
from lmgcpy.view.snapshot import LINKS, Snapshot, acting_lines, frame_number, snapshot
from lmgcpy.view.style import MARGIN, Camera, Style, style_of

FEW, FAR, MANY = 0.02, 6.0, 20
"""Largest part of the free bodies that has escaped, or one; factor by which these are farther out than the others; and
number of free bodies from which on some may have escaped."""
THICK = {2: 0.35, 3: 1.0}
"""Radius of a wire in radii of its beads. In 3D the wire hides its beads. In 2D beads are as large as grains and are seen
behind the wire."""
BEHIND = 0.5
"""Factor by which a wire is thinner behind its forces."""
SEEN_THROUGH = {"layout": 0.4, "forces": 0.6}
"""Part of the light that comes through the whole sample in pictures that show something inside."""
OF_MOTION, OF_TURNING = ("speed", "layer"), ("spin", "rotation")
"""Quantities that say nothing of bodies that cannot move, or cannot turn; these are plain in their pictures."""
PALE = 0.35
"""Opacity of disks behind forces."""
AMONG_WIRES = 0.3
"""Opacity of the other forces in 3D if links are taut, so that the tensions inside are visible."""
WEAKEST = 0.01
"""Smallest force that is drawn, as part of the largest; smaller forces would be thinner than a pixel."""


def compose(snap: Snapshot, style: Style) -> Drawing:
    """The drawing of one panel. Colours and thicknesses are scaled later, for all panels together."""
    flat = snap.dimension == 2
    wrong = _wrong(snap) if style.what == "layout" else (np.zeros(0, np.int64), np.zeros(0, np.int64))
    legend: list[tuple[str, str]] = []
    balls, rods = _grains(snap, style, wrong[0], legend)
    wires = _wires(snap, style, wrong[1], legend)
    forces = _forces(snap, legend) if style.what == "forces" else []
    walls = wall_polygons(snap)
    below = [normal[-1] > 0.5 for normal in snap.walls.shape]
    cylinders = cylinder_polygons(snap)
    rings = [np.stack([facet[i], facet[i + 1]]) for facet in cylinders for i in (0, 2)]
    facets = [*(in_space(corners) for _, corners in snap.facets), *snap.membranes]
    held = [bool(snap.scene["bodies"]["held_by_default"][body]) for body, _ in snap.facets] + [False] * len(snap.membranes)
    thin = [line for _, line in (*snap.outlines, *snap.sharp_edges, *(snap.facets if flat else []))]
    drawing = Drawing(
        flat=flat,
        balls=balls,
        tubes=rods + wires + forces,
        walls=[polygon for polygon in walls if len(polygon)] + cylinders + facets,
        lines=np.concatenate([edges(walls + rings), polylines(thin), cell_outline(snap)]),
        ground=[] if flat else [polygon for polygon, floor in zip(walls, below, strict=True) if floor and len(polygon)],
        sheets=[] if flat else [corners for corners, wall in zip(facets, held, strict=True) if wall],
        solids=[] if flat else [corners for corners, wall in zip(facets, held, strict=True) if not wall],
        grain=_mean_radius(snap),
        time=snap.time,
        legend=legend,
    )
    if snap.lattice is not None:
        drawing = into_cell(drawing, snap)
    escaped = np.zeros(0, np.int64) if style.everything or style.region is not None else escaped_bodies(snap)
    if style.region is not None:
        drawing = within(drawing, style.region)
    elif len(escaped):
        drawing = replace(within(drawing, _around_the_others(snap, escaped)), escaped=escaped)
    if style.clip is not None:
        drawing = clip(drawing, style.clip, style.direction)
    if style.section is not None:
        drawing = section(drawing, style.section)
    return drawing


def escaped_bodies(snap: Snapshot) -> np.ndarray:
    """Ids of the bodies that have escaped: free ones that are in no chain, at most :data:`FEW` of all, so far out that the
    others would be small beside them. The distance from the median, the largest coordinate of it, is more than :data:`FAR`
    times the distance within which all but these bodies lie."""
    loose = np.zeros(len(snap.positions), dtype=bool)
    loose[snap.drawn] = ~snap.held[snap.drawn, : snap.dimension].any(axis=1)
    for chain in snap.chains:
        loose[chain.path] = False
    if snap.lattice is not None or loose.sum() < MANY:
        return np.zeros(0, np.int64)
    ids = np.flatnonzero(loose)
    distance = np.abs(snap.positions[ids] - np.median(snap.positions[ids], axis=0)).max(axis=1)
    most = np.sort(distance)[-1 - max(1, int(FEW * len(ids)))]
    return ids[distance > FAR * (most + _mean_radius(snap))]


def _around_the_others(snap: Snapshot, escaped: np.ndarray) -> np.ndarray:
    """Low and high corner of the box that holds the bodies that have not escaped, walls left out, and a margin [m],
    (2, 3)."""
    extent = np.asarray(snap.scene["bodies"]["extent"], dtype=float)
    kept = np.isfinite(extent)
    kept[escaped] = False
    at, reach = in_space(snap.positions[kept]), extent[kept, None]
    low, high = (at - reach).min(axis=0), (at + reach).max(axis=0)
    margin = MARGIN * float((high - low).max())
    return np.stack([low - margin, high + margin])


def into_cell(drawing: Drawing, snap: Snapshot) -> Drawing:
    """The drawing with the images of wires and forces whose middles lie in the periodic cell. Bodies are in it already."""
    tubes = []
    for tube in drawing.tubes:
        if tube.bodies is None:
            middles = 0.5 * (tube.starts + tube.ends)
            by = in_space(snap.into_cell(middles[:, : snap.dimension]))
            tube = replace(tube, starts=tube.starts + by, ends=tube.ends + by)
        tubes.append(tube)
    return replace(drawing, tubes=tubes)


# ------------------------------------------------------------------------------------------------------------ bodies


def _wrong(snap: Snapshot) -> tuple[np.ndarray, np.ndarray]:
    """Ids of the bodies that overlap, and indices of the links that are too long."""
    overlaps, links = overlaps_of(snap, OVERLAP), long_links_of(snap, EXCESS)
    bodies = np.unique(np.concatenate([overlaps["candidate"], overlaps["antagonist"]]))
    first = np.concatenate([[0], np.cumsum([len(chain.reference) for chain in snap.chains])]).astype(np.int64)
    return bodies, first[links["chain"]] + links["link"]


def _grains(
    snap: Snapshot, style: Style, wrong: np.ndarray, legend: list[tuple[str, str]]
) -> tuple[list[Balls], list[Tubes]]:
    """Disks, spheres and rods that are no beads, and in red those that overlap, beads included."""
    flat = snap.dimension == 2
    red = np.isin(np.arange(len(snap.positions)), wrong)
    # In 2D beads are drawn like grains, and the wire over them.
    chosen = (~snap.beads | flat) & ~red
    if style.grains == "hidden":
        chosen &= snap.beads
    if style.wires == "hidden":
        chosen &= ~snap.beads
    parts = [(chosen & part, paint) for part, paint in _paints(snap, style, legend)]
    if red.any():
        legend.append((f"overlaps by more than {100 * OVERLAP:g} %", WRONG))
        parts.append((red, Paint(WRONG)))
    balls, tubes = [], []
    for mine, paint in parts:
        rounds, rods = mine[snap.rounds.body], mine[snap.rods.body]
        opacity = 1.0 if mine is red else _opacity(snap, style, rounds, rods)
        if rounds.any():
            balls.append(_balls(snap, paint, opacity).take(rounds))
        if rods.any():
            tubes.append(_rods(snap, paint, opacity).take(rods))
    return balls, tubes


def _balls(snap: Snapshot, paint: Paint, opacity: float) -> Balls:
    """All disks and spheres, in the paint of their bodies."""
    rounds, at = snap.rounds, in_space(snap.placed(snap.rounds))
    bodies = at - in_space(rounds.position - snap.positions[rounds.body])
    return Balls(at, rounds.shape[:, 0], paint.take(rounds.body), opacity, rim=snap.dimension == 2, bodies=bodies)


def _rods(snap: Snapshot, paint: Paint, opacity: float) -> Tubes:
    """All rods, in the paint of their bodies."""
    rods, at, half = snap.rods, in_space(snap.placed(snap.rods)), in_space(snap.rods.shape[:, 1:])
    bodies = at - in_space(rods.position - snap.positions[rods.body])
    radii, own = rods.shape[:, 0], paint.take(rods.body)
    return Tubes(at - half, at + half, radii, own, level=0, opacity=opacity, bodies=bodies)


def _paints(snap: Snapshot, style: Style, legend: list[tuple[str, str]]) -> list[tuple[np.ndarray, Paint]]:
    """Bodies, (n,) bool, and their paints, for grains and for beads."""
    bead = snap.beads
    if style.grains in GRAINS:
        quantity, values = GRAINS[style.grains](snap)
        painted = Paint(values=values, quantity=quantity)
        plain = np.zeros(len(bead), dtype=bool)
        if style.grains in OF_MOTION:
            plain |= snap.held[:, : snap.dimension].all(axis=1)
        elif style.grains in OF_TURNING:
            plain |= snap.held[:, snap.dimension :].all(axis=1)
        if plain[snap.drawn].all():
            return [(plain, painted)]
        return [(plain & ~bead, Paint(SAND)), (plain & bead, Paint(BEAD)), (~plain, painted)]
    if style.grains == "color":
        shades = style.shades
        for word in dict.fromkeys(snap.colors[snap.drawn].tolist()):
            legend.append((word, shades.setdefault(word, GROUPS[len(shades) % len(GROUPS)])))
        values = np.array([rgb(shades.get(word, SAND)) for word in snap.colors]).reshape(-1, 3)
        return [(np.ones(len(bead), dtype=bool), Paint(values=values))]
    return [(~bead, Paint(SAND)), (bead, Paint(BEAD))]


def _opacity(snap: Snapshot, style: Style, rounds: np.ndarray, rods: np.ndarray) -> float:
    """Opacity of some disks, spheres and rods: the user's, or one at which the inside is seen. A ray crosses as many of
    them as the sum of their mean shadows over the area of the sample: ``pi r^2`` of a ball, ``pi/4 2 r l`` of a rod."""
    if style.opacity is not None:
        return style.opacity
    if snap.dimension == 2 or style.section is not None:
        return PALE if style.what == "forces" else 1.0
    if style.what == "grains" or (style.what == "layout" and (not snap.chains or style.wires == "hidden")):
        return 1.0
    half = np.linalg.norm(snap.rods.shape[:, 1:], axis=1)
    chosen = np.concatenate([rounds, rods])
    centres = np.concatenate([snap.placed(snap.rounds), snap.placed(snap.rods)])
    radii = np.concatenate([snap.rounds.shape[:, 0], snap.rods.shape[:, 0]])
    length = np.concatenate([np.zeros(len(rounds)), half])
    if style.region is not None:
        chosen = chosen & reaching(in_space(centres), radii + length, style.region)
    if not chosen.any():
        return 1.0
    centres, radii, length = centres[chosen], radii[chosen], length[chosen]
    sides = centres.max(axis=0) - centres.min(axis=0) + 2.0 * radii.mean()
    shadows = np.pi * radii * np.where(length > 0.0, length, radii)
    crossed = float(shadows.sum() / np.prod(sides) ** (2.0 / 3.0))
    return float(1.0 - SEEN_THROUGH[style.what] ** (1.0 / max(crossed, 1.0)))


# ------------------------------------------------------------------------------------------------------------- wires


def _wires(snap: Snapshot, style: Style, wrong: np.ndarray, legend: list[tuple[str, str]]) -> list[Tubes]:
    """Links as tubes; links that are too long are red."""
    if style.wires == "hidden" or not snap.chains:
        return []
    first, second = (np.concatenate([chain.radius[part] for chain in snap.chains]) for part in LINKS)
    thinner, thicker = np.minimum(first, second), np.maximum(first, second)
    thickness = THICK[snap.dimension] * np.where(thinner > 0.0, thinner, thicker)  # a point has no radius
    if style.what == "forces":
        thickness *= BEHIND
    nodes = [np.concatenate([chain.path[part] for chain in snap.chains]) for part in LINKS]
    skin = np.min([snap.skin_radius[path] for path in nodes], axis=0)
    thickness = np.where(skin > 0.0, skin, thickness)  # a thread is drawn as it is
    slack = None
    thickness[thickness == 0.0] = 0.1 * _mean_radius(snap)  # links between bodies that are no disks
    if style.wires in WIRES:
        quantity, values = WIRES[style.wires](snap)
        paint = Paint(values=values, quantity=quantity)
        if style.what == "forces":
            legend.append(("course of the wire: not as thick as its force", ""))
    elif style.what == "forces":
        # links with a force are drawn as thick as it, and nothing else is drawn there
        forces = acting(snap, "what='forces'")
        slack = np.abs(forces.link) <= WEAKEST * np.abs(forces.normal).max(initial=0.0)
        paint = Paint(BEAD)
        if slack.any():
            legend.append(("wire without force", BEAD))
    else:
        paint = Paint(WIRE)
        legend.append(("wire", WIRE))
    starts, ends = (np.concatenate([course[part] for course in snap.courses]) for part in LINKS)
    tubes = Tubes(in_space(starts), in_space(ends), thickness, paint)
    if slack is not None:
        tubes = tubes.take(slack)
    red = np.zeros(len(tubes.starts), dtype=bool)
    red[wrong] = True
    pieces = [tubes.take(~red)]
    if red.any():
        legend.append(("longer than its reference", WRONG))
        pieces.append(Tubes(tubes.starts, tubes.ends, 1.3 * tubes.radii, Paint(WRONG), level=2).take(red))
    return pieces


def _mean_radius(snap: Snapshot) -> float:
    """Mean radius of the grains [m]. If there are no grains: mean radius of the beads; if there are no beads: mean radius
    of the circles around the shapes with an outline; else 1."""
    radii, bead = snap.rounds.shape[:, 0], snap.beads[snap.rounds.body]
    chosen = radii if bead.all() else radii[~bead]
    if not len(chosen):
        chosen = snap.scene["bodies"]["extent"][[body for body, _ in (*snap.outlines, *snap.facets)]]
        chosen = chosen[np.isfinite(chosen)]
    return float(chosen.mean()) if len(chosen) else 1.0


# ------------------------------------------------------------------------------------------------------------ forces


def _forces(snap: Snapshot, legend: list[tuple[str, str]]) -> list[Tubes]:
    """Normal forces along the lines in which they act."""
    forces = acting(snap, "what='forces'")
    start, end = acting_lines(snap)
    link = np.arange(len(forces.normal)) < snap.link_count
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
    taut = (~pushing & link & strong).any()
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
            opacity = AMONG_WIRES if taut and not chosen[link].any() else 1.0
            pieces.append(Tubes(start, end, size, Paint(color), by_force=True, level=level, opacity=opacity).take(mine))
    return pieces


# -------------------------------------------------------- panels, from a user's sources and options; a list makes several


@dataclass(frozen=True)
class Panel:
    """A panel through time."""

    drawings: Sequence[Callable[[], Drawing]]
    """Functions that make the drawings, one for each picture; a panel that does not change has one."""
    camera: Camera
    dimension: int
    """Dimension of the scene, 2 or 3; a section of a scene in 3D is drawn flat."""
    title: str | None = None
    """None: the time, if the drawing has one."""
    shows_forces: bool = False

    def drawing(self, k: int) -> Drawing:
        """Drawing of picture number k."""
        return self.drawings[self.index(k)]()

    def index(self, k: int) -> int:
        """Number of the drawing that picture number k shows."""
        return min(k, len(self.drawings) - 1)


def panels_of(source: Any, frame: Any, options: dict[str, Any], *, moving: bool) -> list[Panel]:
    """The panels that a user asked for. If the picture is ``moving``, runs give all their frames.

    The function raises TypeError or ValueError for what cannot be drawn.
    """
    shades: dict[str, str] = {}
    return [_panel(one, at, said, moving, shades) for one, at, said in _one_by_one(source, frame, options)]


def _one_by_one(source: Any, frame: Any, options: dict[str, Any]) -> Iterator[tuple[Any, Any, dict[str, Any]]]:
    """Source, frame and options of each panel: a list has one entry for each panel, other values hold for all panels."""
    given = {"source": source, "frame": frame, **options}
    lengths = {name: len(value) for name, value in given.items() if isinstance(value, list)}
    count = max(lengths.values(), default=1)
    for name, length in lengths.items():
        if length != count or length == 0:
            raise ValueError(
                f"Lists give one entry a panel, all as many: {', '.join(f'{n} has {c}' for n, c in lengths.items())}. "
                f"Make {name} as long as the others."
            )
    for i in range(count):
        each = {name: value[i] if isinstance(value, list) else value for name, value in given.items()}
        yield each.pop("source"), each.pop("frame"), each


def _panel(source: Any, frame: Any, options: dict[str, Any], moving: bool, shades: dict[str, str]) -> Panel:
    snapshots: list[Callable[[], Snapshot]]
    if moving and isinstance(source, Run) and (frame is None or isinstance(frame, range)):
        chosen = range(source.frame_count) if frame is None else frame
        snapshots = [partial(snapshot, source, frame_number(source, k)) for k in chosen]
        if not snapshots:
            raise ValueError(f"frame must name a frame at least, got {shown(frame)}.")
    else:
        one = snapshot(source, frame)
        snapshots = [lambda: one]
    first = snapshots[0]()
    style = replace(style_of(options, dimension=first.dimension, is_scene=first.time is None), shades=shades)
    return Panel(
        drawings=[partial(_composed, make, style) for make in snapshots],
        camera=Camera.looking(style.direction),
        dimension=first.dimension,
        title=style.title,
        shows_forces=style.what == "forces",
    )


def _composed(make: Callable[[], Snapshot], style: Style) -> Drawing:
    return compose(make(), style)
