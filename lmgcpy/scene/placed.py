"""Bodies as samples hold them: a twin of a body in another place, and the volume of a body in space."""

from __future__ import annotations

import copy
from typing import TYPE_CHECKING, Any

import numpy as np

from lmgcpy.scene.ball_union import union_volume
from lmgcpy.scene.body import NO_CONDITIONS, RADIUS, Body, _start_rows
from lmgcpy.scene.capsule import Capsule, capsule_volume
from lmgcpy.scene.contactor import SphereContactor

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


def placed(body: Body, position: Any, turn: Rotation | None = None) -> Body:
    """A body like this one, in no scene, with its centre at ``position`` [m]: at rest, without conditions.

    It stands as the body does, or turned from there by ``turn``, if it turns in space.
    """
    twin = copy.copy(body)
    twin._state, twin._id, twin._hidden = None, -1, False
    twin._velocities = twin._forces = NO_CONDITIONS
    twin._block, twin._row = _start_rows.take()
    twin._block[twin._row] = 0.0
    twin._block[twin._row, RADIUS:] = body._block[body._row, RADIUS:]
    twin.position[:] = position
    if body.turns:
        twin._quaternion = (body.rotation if turn is None else turn * body.rotation).as_quat()
    return twin


def body_volume(body: Body) -> float:
    """Volume [m^3] of a sphere, a clump, whose overlaps count once, or a capsule; ValueError for other bodies."""
    if isinstance(body, Capsule):
        return capsule_volume(body.radius, body.length)
    balls = [(*at, ball.radius) for ball, at in body.contactors if isinstance(ball, SphereContactor)]
    if len(balls) < len(body.contactors):
        raise ValueError(f"{body!r} is no sphere, clump or capsule, so that its volume is not known.")
    return union_volume(np.array(balls)[:, :3], np.array(balls)[:, 3])
