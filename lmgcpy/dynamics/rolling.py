"""The lever of the rolling components of contacts, and their entries of W."""

from __future__ import annotations

import numpy as np

from lmgcpy.contact.detector import Group
from lmgcpy.contact.frames import local_frames
from lmgcpy.contact.interactions import Interactions
from lmgcpy.laws.pair import effective


def rolling_radius(groups: list[Group], pairs: np.ndarray, dimension: int, count: int) -> np.ndarray:
    """Effective radius R of the contacts with rolling components [m], 0 for other interactions, (m,).

    ``1/R = 1/R_c + 1/R_a``; walls are flat. ``pairs``: radii and masses of candidates and antagonists, (m, 4).
    """
    radius = np.zeros(count)
    for group in groups:
        if group.law.rows(dimension) > dimension:
            part = slice(group.start, group.stop)
            radius[part] = [effective(*radii) for radii in pairs[part, :2].tolist()]
    radius[np.isinf(radius)] = 0.0  # two walls: neither rolls
    return radius


def with_rolling(
    delassus: np.ndarray,
    rolling: np.ndarray,
    groups: list[Group],
    interactions: Interactions,
    inverse_mass: np.ndarray,
    axes: np.ndarray,
) -> np.ndarray:
    """The diagonals of the local blocks with columns for the rolling components, ``W_rr = R^2 (1/I_c + 1/I_a)`` [1/kg].
    ``axes`` of the bodies, (n, 9), see :class:`~lmgcpy.solve.kernels.system.System`."""
    d = delassus.shape[1]
    turning = inverse_mass[interactions.candidate, d:] + inverse_mass[interactions.antagonist, d:]
    if d == 3:  # about s, t and n, the axes of the rows
        frame = local_frames(interactions.normal)
        about = np.einsum("iab,ib->ia", frame[:, ::-1] ** 2, turning)
        turning = np.where((turning == turning[:, :1]).all(axis=1)[:, None], turning, about)
        for group in groups:
            if group.form == "lever":  # inertias are along the axes of the bodies
                part = slice(group.start, group.stop)
                both = np.stack([interactions.candidate[part], interactions.antagonist[part]], axis=1)
                # s, t and n along the axes of both bodies
                own = frame[part, None, ::-1] @ axes[both].reshape(-1, 2, 3, 3)
                turning[part] = (own**2 @ inverse_mass[both, d:, None]).sum(axis=1)[..., 0]
    return np.column_stack([delassus, rolling[:, None] ** 2 * turning])


def mark_isotropic(groups: list[Group], interactions: Interactions, inverse_mass: np.ndarray) -> None:
    """Mark whether each body of a group with rolling components in 3D has the same inertia about all axes, where its form
    asks."""
    d = interactions.normal.shape[1]
    alike = (inverse_mass[:, d:] == inverse_mass[:, d : d + 1]).all(axis=1)
    both = alike[interactions.candidate] & alike[interactions.antagonist]
    for group in groups:
        asks = group.law.rows(d) > d and group.form == "central"
        group.isotropic = bool(not asks or both[group.start : group.stop].all())


def moments(rolling: np.ndarray, impulse: np.ndarray, dimension: int) -> np.ndarray:
    """Impulses of the moments on the candidates [N m s], from effective radii (m,) and impulses with rolling components:
    (m, 1) in 2D, (m, 3) in the local frame in 3D, (m, 0) if there are none."""
    parts = impulse[:, dimension:]
    if not parts.shape[1]:
        return parts.copy()
    if dimension == 3:  # rows 1, 2, z turn about s, -t, n
        parts = np.column_stack([parts[:, 2], -parts[:, 1], parts[:, 0]])
    return rolling[:, None] * parts
