"""Files."""

from lmgcpy.io import fclib

__all__ = ["fclib"]
