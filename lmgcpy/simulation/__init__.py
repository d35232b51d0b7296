"""Simulations: runs of a scene, and continuation of a run from its file."""

from lmgcpy.simulation.simulation import Simulation

__all__ = ["Simulation"]
