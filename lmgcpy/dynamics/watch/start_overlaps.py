"""Before the first step: bodies that overlap, and bodies so far from the origin that the round-off of positions is coarse.

Overlaps are allowed, as laws leave an old penetration alone, but rarely meant. A body whose centre is inside another one is
a mistake, and the run is doomed: it is refused unless overlaps are ignored.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.contact.detector import Detector
from lmgcpy.contact.foreign_pairs import NarrowPhaseError
from lmgcpy.dynamics.model import Model

COARSE = 1e-3
"""Largest round-off of a position, in parts of the body's size.

Positions are rounded to ``eps |x|``, and gaps with them. Laws take a gap for a velocity, ``gap / h``, and bodies in
quasi-static tests overlap by 1e-3 of their radius or less: with coarser positions no gap has a digit that is right, and
what moves by less than ``eps |x|`` in a step does not move at all. A disk of 1 cm may be 4e10 m away."""


def check_positions(model: Model) -> None:
    """ValueError if a body starts so far away that its position is rounded by more than :data:`COARSE` of its size."""
    far = np.abs(model.start.positions[:, : model.dimension]).max(axis=1, initial=0.0)
    share = 2.0**-52 * far / model.size
    if not (share > COARSE).any():
        return
    body = int(np.argmax(share))
    raise ValueError(
        f"Body {body} is {far[body]:.3g} m from the origin, where positions are rounded by {2.0**-52 * far[body]:.2g} m, "
        f"too coarse for its radius of {model.size[body]:.3g} m: a step would not move it as it should. Put the origin "
        "near the bodies."
    )


SHARE = 0.05
"""Overlaps up to this part of the smaller radius are not reported. The relaxation of a sample at a solver's tolerance of
1e-2 leaves overlaps of up to 3.5 % (measured on 70 to 2000 particles). A misplaced body overlaps by tenths."""
INSIDE = 1.0
"""Overlaps beyond this part of the smaller radius stop a simulation that does not ignore them: bodies inside each other."""

SMALL, LARGE = 0.2, 3e4
"""Sizes of surfaces, in parts of the radii of what they see, that are more likely another unit of length."""


def check_start(model: Model, overlap: str, first: int = 0) -> list[str]:
    """Look at bodies before their first step, those in rows ``first`` and later; returns sentences for the user.

    ValueError if positions are rounded too coarsely, or a periodic cell is too narrow; if bodies overlap and ``overlap`` is
    "stop"; and if they overlap by more than a radius and it is "warn".
    """
    check_positions(model)
    if overlap == "ignore" and model.cell is None:
        return []
    overlaps, share = overlaps_at_start(model, first)
    if overlap == "ignore":
        return []
    if overlaps and (overlap == "stop" or share > INSIDE):
        raise ValueError(overlaps[0])
    return overlaps + sizes_at_odds(model, first)


def sizes_at_odds(model: Model, first: int = 0) -> list[str]:
    """A sentence about a surface that is so small or so large beside the bodies that it sees that its coordinates may be in
    other units than metres; of bodies in rows ``first`` and later."""
    table = model.contactors
    if not table.features.any():
        return []
    reach = np.linalg.norm(table.swing, axis=1) + table.bounding_radius
    color = np.array(table.color, dtype=str)
    for row in model.rows:
        for one, other in ((row.candidate, row.antagonist), (row.antagonist, row.candidate)):
            mine = table.features & (color == one) & (table.body >= first)
            radii = table.bounding_radius[~table.features & (color == other) & np.isfinite(table.bounding_radius)]
            if not mine.any() or not len(radii):
                continue
            bodies, which = np.unique(table.body[mine], return_inverse=True)
            size = np.zeros(len(bodies))
            np.maximum.at(size, which, reach[mine])
            for least, wrong in ((True, size < SMALL * radii.min()), (False, size > LARGE * radii.max())):
                if wrong.any():
                    k, radius = int(wrong.argmax()), radii.min() if least else radii.max()
                    return [
                        f"The surface of body {bodies[k]} ('{one}') reaches {size[k]:.3g} m from its centre, and the "
                        f"{'smallest' if least else 'largest'} radius of '{other}' is {radius:.3g} m: if its coordinates "
                        "are not in metres, scale them, as lmgcpy.read_mesh(path, scale=1e-3) does."
                    ]
    return []


def overlaps_at_start(model: Model, first: int = 0) -> tuple[list[str], float]:
    """A sentence about the pairs that see each other and overlap at the start of a model, if there are any, and the largest
    overlap in parts of the smaller radius. If bodies were added to a simulation, in rows ``first`` and later, only their
    pairs count.

    It says how many pairs of bodies overlap by more than :data:`SHARE` of the smaller radius (of the circle that holds
    the contactor), and the worst: its bodies, depth, share of that radius, and law. Linked neighbours that do not
    collide are left out. Costs one detection.
    """
    if not model.rows:
        return [], 0.0
    detector = Detector(model.contactors, model.rows, [], model.inverse_mass, model.dimension, model.apart, model.lattice)
    detector.hide(model.hidden)
    try:
        found = detector.detect(model.start.positions, 0.0)
    except NarrowPhaseError as error:
        raise RuntimeError(f"At the start {error}.") from error.__cause__
    pairs = np.concatenate([np.zeros((0, 2), np.int32), *(group.pairs for group in detector.groups)])[found.slot]
    radius = model.contactors.radius[pairs].min(axis=1, initial=np.inf)
    share = -found.gap / radius
    deep = (share > SHARE) & (model.contactors.body[pairs].max(axis=1, initial=0) >= first)
    if not deep.any():
        return [], 0.0
    i = int(np.argmax(np.where(deep, share, 0.0)))
    bodies = np.sort(np.column_stack([found.candidate[deep], found.antagonist[deep]]), axis=1)
    count = len(np.unique(bodies, axis=0))
    one, other = (f"body {model.contactors.body[k]} ('{model.contactors.color[k]}')" for k in pairs[i])
    law = next(group.law.NAME for group in detector.groups if group.start <= i < group.stop)
    what = "pair of bodies overlaps" if count == 1 else "pairs of bodies overlap"
    inside = share[i] > INSIDE
    law = f"under the law '{law}', which leaves an old penetration as it is"
    say = "Move the bodies apart, or allow it with" if inside else "Move the bodies, or say"
    sentence = (
        f"{count} {what} {'with what was added' if first else 'at the start'} by more than {100.0 * SHARE:g} % of the "
        f"smaller radius; the worst: {one} and {other} by {-found.gap[i]:.3g} m, {100.0 * share[i]:.3g} % of "
        f"{radius[i]:.3g} m, {law}. {say} overlap='ignore'."
    )
    return [sentence], float(share[i])
