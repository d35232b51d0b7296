"""The round-off of positions, which is too coarse for small bodies far from the origin."""

from __future__ import annotations

import numpy as np

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
