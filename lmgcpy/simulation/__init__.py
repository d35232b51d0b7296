"""Simulations: runs of a scene, and going on with a run from its file."""

from lmgcpy.simulation.simulation import Simulation

__all__ = ["Simulation"]
