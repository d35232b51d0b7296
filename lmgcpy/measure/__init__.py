"""Measures of a sample: solid fraction, Weber stress by law, contact network, shape of wires."""

from lmgcpy.measure.density import density
from lmgcpy.measure.network import Network, network
from lmgcpy.measure.stress import principal, stress
from lmgcpy.measure.wire_shape import WireShape, wire_shape

__all__ = ["Network", "WireShape", "density", "network", "principal", "stress", "wire_shape"]
