"""What is measured on a sample: density, and Weber stress by law."""

from lmgcpy.measure.density import density
from lmgcpy.measure.stress import principal, stress

__all__ = ["density", "principal", "stress"]
