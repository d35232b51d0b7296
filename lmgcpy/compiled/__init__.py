"""The room that touches the inside of numba: kernels with named slots, their fingerprint and cache, calls by address, and
atomic numbers."""

from lmgcpy.compiled.kernel import Statistics, statistics

__all__ = ["Statistics", "statistics"]
