"""Local frames from normals."""

from __future__ import annotations

import numpy as np

from lmgcpy.contact.narrow_phase_3d import STEEP


def local_frames(normal: np.ndarray) -> np.ndarray:
    """Rows n, t(, s) of the local frames of normals (m, d): (m, d, d).

    In 2D t is n turned by +90 degrees; in 3D it is as :mod:`lmgcpy.contact.narrow_phase_3d` says, and s = n x t.
    """
    if normal.shape[1] == 2:
        return np.stack([normal, np.column_stack([-normal[:, 1], normal[:, 0]])], axis=1)
    x, y, z = normal.T
    nothing = np.zeros(len(normal))
    level = np.abs(z) <= STEEP
    tangent = np.where(level[:, None], np.column_stack([-y, x, nothing]), np.column_stack([nothing, -z, y]))
    tangent /= np.sqrt(np.where(level, x * x + y * y, y * y + z * z))[:, None]
    return np.stack([normal, tangent, np.cross(normal, tangent)], axis=1)
