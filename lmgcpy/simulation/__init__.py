"""Simulations: runs of a scene, and continuation of a run from its file."""

from lmgcpy.simulation import resume as _gives_scenes_their_reader  # noqa: F401
from lmgcpy.simulation.simulation import Simulation

__all__ = ["Simulation"]
