"""What measures, curves and pictures read of an open run file.

Run files are opened in a room above this one, so that they are described here by their attributes.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, TypeGuard

import numpy as np


class ActingInteractions(Protocol):
    """Links and contacts of one step in canonical order; m interactions in d dimensions."""

    @property
    def law(self) -> np.ndarray:
        """Names of the laws, (m,)."""

    @property
    def candidate(self) -> np.ndarray:
        """Ids of the candidate bodies, (m,)."""

    @property
    def antagonist(self) -> np.ndarray:
        """Ids of the antagonist bodies, (m,)."""

    @property
    def normal(self) -> np.ndarray:
        """Normals from the antagonist to the candidate, (m, d)."""

    @property
    def frame(self) -> np.ndarray:
        """Rows n, t(, s) of the local frames, (m, d, d)."""

    @property
    def impulse(self) -> np.ndarray:
        """Impulses in the local frame, normal first [N s], (m, d)."""

    @property
    def force(self) -> np.ndarray:
        """Forces in the local frame, impulse / time step [N], (m, d)."""

    @property
    def lever(self) -> np.ndarray:
        """Contact point seen from the centre of the candidate, and of the antagonist [m], (m, 2, d)."""

    def __len__(self) -> int:
        """Number of interactions."""
        ...


class RecordedRun(Protocol):
    """An open run file; f frames of n bodies in d dimensions. Tables are read when they are indexed."""

    @property
    def path(self) -> Any:
        """Path of the file."""

    @property
    def dimension(self) -> int:
        """2 or 3."""
        ...

    @property
    def scene(self) -> Mapping[str, Any]:
        """The scene as :func:`lmgcpy.scene.description.describe` gives it."""
        ...

    @property
    def laws(self) -> Sequence[str]:
        """Names of the laws of the scene."""
        ...

    @property
    def extent(self) -> np.ndarray:
        """Radius of the circle that holds each body [m], infinite for walls, (n,)."""

    @property
    def wall_normals(self) -> dict[int, np.ndarray]:
        """Outward normals of the walls by id, (d,) each."""
        ...

    @property
    def frame_count(self) -> int:
        """Number of frames f."""
        ...

    @property
    def times(self) -> np.ndarray:
        """Times of the frames [s], (f,)."""

    @property
    def steps(self) -> np.ndarray:
        """Number of steps made up to each frame, (f,)."""

    def reference_gaps(self, frame: int) -> np.ndarray:
        """Reference gaps of the links of all chains at a frame [m], (l,)."""
        ...

    def hidden(self, frame: int) -> np.ndarray:
        """Which bodies were hidden after the step of a frame, (n,) bool."""

    @property
    def positions(self) -> Any:
        """Positions [m], (f, n, d)."""

    @property
    def rotations(self) -> Any:
        """Angles turned [rad], (f, n), in 2D."""

    @property
    def velocities(self) -> Any:
        """Velocities [m/s], (f, n, d)."""

    @property
    def spins(self) -> Any:
        """Angular velocities [rad/s], (f, n), in 3D (f, n, 3)."""

    def interactions(self, frame: int) -> ActingInteractions:
        """Interactions of the step that ended with a frame."""

    @property
    def history(self) -> Any:
        """One row for each step."""

    @property
    def energy(self) -> Mapping[str, Any]:
        """Parts of the energy balance, one value for each step."""
        ...

    @property
    def observed(self) -> Mapping[str, Any]:
        """What the run observed after each step, by name."""
        ...

    @property
    def options(self) -> Mapping[str, Any]:
        """Options of the simulation."""
        ...

    @property
    def notes(self) -> Mapping[str, Any]:
        """What the author of the run noted."""
        ...


def is_run(source: Any) -> TypeGuard[RecordedRun]:
    """Whether something is an open run file."""
    return hasattr(source, "frame_count")
