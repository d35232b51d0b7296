"""Bodies move by their velocities: the displacements of a step without a periodic cell."""

from __future__ import annotations

from lmgcpy.compiled.kernel import kernel


@kernel
def move(positions, one, time, other, earlier):
    """Add ``time one + earlier other`` to the first three columns of ``positions`` (n, w); (n, k) both."""
    for b in range(positions.shape[0]):
        for k in range(3):
            positions[b, k] += time * one[b, k] + earlier * other[b, k]
