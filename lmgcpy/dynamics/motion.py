"""Bodies move by their velocities, and fly without impulses: equations (1), (2) and (5) of a step."""

from __future__ import annotations

from lmgcpy.compiled.kernel import kernel


@kernel
def move(positions, one, time, other, earlier):
    """Add ``time one + earlier other`` to the first three columns of ``positions`` (n, w); (n, k) both."""
    for b in range(positions.shape[0]):
        for k in range(3):
            positions[b, k] += time * one[b, k] + earlier * other[b, k]


@kernel
def fly(before, time_step, mobility, force, component, value, positions, bound, free_velocity):
    """Write ``v + h M^-1 F`` (n, k), and the imposed values of components, indices into the flat array; returns whether
    no velocity and no position (n, w) is beyond a bound, or NaN."""
    beyond = 0
    width = before.shape[1]
    for b in range(before.shape[0]):
        for k in range(width):
            free_velocity[b, k] = before[b, k] + time_step * mobility[b, k] * force[b, k]
    for j in range(component.shape[0]):
        free_velocity[component[j] // width, component[j] % width] = value[j]
    for b in range(before.shape[0]):
        for k in range(width):
            beyond += not abs(free_velocity[b, k]) <= bound
        for k in range(positions.shape[1]):
            beyond += not abs(positions[b, k]) <= bound
    return beyond == 0
