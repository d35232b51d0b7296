"""Measures of a sample: solid fraction, Weber stress by law, contact network."""

from lmgcpy.measure.density import density
from lmgcpy.measure.network import Network, network
from lmgcpy.measure.stress import principal, stress

__all__ = ["Network", "density", "network", "principal", "stress"]
