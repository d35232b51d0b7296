"""Everything that touches numba: kernels with named slots, their fingerprint and cache, calls by address, atomics."""

from lmgcpy.compiled.kernel import Statistics, statistics

__all__ = ["Statistics", "statistics"]
