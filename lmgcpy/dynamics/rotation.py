r"""Rotation of rigid bodies in space between two kicks.

A step is a free motion from its start to the detection, a kick there by loads and impulses, and a free motion to its end
(the equations of :meth:`lmgcpy.Simulation.step`). A body that turns freely keeps its angular momentum in space, ``R I w``,
and its energy, ``w . I w / 2``; w is the spin and I the diagonal inertia along the axes of the body, R the rotation from
these axes to the axes of space. Over a time T

    (1)  I (w1 - w0) = c T (I m) x m,     m = (w0 + w1) / 2,     c = tan(a) / a,   a = T |m| / 2
    (2)  R1 = R0 exp(T m)

keep both to round-off, for any T. Energy: the product of (1) with m is zero. Momentum: with ``A = c T [m]_x``, the matrix
of ``c T m x``, Cayley's map ``(1 - A/2)^-1 (1 + A/2)`` turns by twice the arctangent of half the length of its vector,
which is ``T |m|``; so it is ``exp(T m)``. Hence ``R1 I w1 = R0 I w0`` says ``(1 + A/2) I w1 = (1 - A/2) I w0``, which is
(1). (Simo and Wong 1991, Int. J. Numer. Meth. Eng. 31; with c = 1 and Cayley's map, Austin, Krishnaprasad and Wang 1993,
J. Comput. Phys. 107. With c a turn about a principal axis is exact.) The scheme is symmetric in time, and so of second
order in T.

Free motion over T and free motion over two parts of T agree to second order, and both keep the invariants. A body that
turns far in a step takes several parts (:data:`TURN`), so that its motion is resolved at any speed.

A spin component that is driven stays as it is, along the axis of the body: (1) holds for the others alone, and the drive
gives the moment, whose work is the change of the energy of the others. A body whose spin is driven as a whole turns by
``exp(T w)``.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.compiled.kernel import inlined, kernel
from lmgcpy.contact.positions import axes_of

TURN = 0.1
"""Largest angle of a part of a free motion [rad]. The error of a part is a twelfth of the cube of it at most."""
PARTS = 1e5
"""Most parts of a free motion: beyond that, ten thousand radians in a step, nothing is resolved."""
PASSES = 60
"""Most passes for the mean spin. Each takes the error down by the angle of the part at least, as no moment of inertia is
larger than the sum of the others."""


@kernel
def turn_freely(rows, time, positions, velocities, mass, inverse_mass):
    """Turn the bodies of some rows over a time [s]: their quaternions in ``positions`` (n, 7) and their spins in
    ``velocities`` (n, 6), in place. Returns the work of what drives a part of their spins [J]."""
    work = 0.0
    for j in range(rows.shape[0]):
        b = rows[j]
        angle = time * np.sqrt(velocities[b, 3] ** 2 + velocities[b, 4] ** 2 + velocities[b, 5] ** 2)
        if not 0.0 < angle < np.inf:
            continue
        parts = min(np.ceil(angle / TURN), PARTS)
        driven = inverse_mass[b, 3] == 0.0 or inverse_mass[b, 4] == 0.0 or inverse_mass[b, 5] == 0.0
        if driven:
            work -= turning_energy(b, velocities, mass, inverse_mass)
        for _ in range(int(parts)):
            turn_part(b, time / parts, positions, velocities, mass, inverse_mass)
        if driven:
            work += turning_energy(b, velocities, mass, inverse_mass)
    return work


@inlined
def turning_energy(b, velocities, mass, inverse_mass):
    """Kinetic energy of the free components of the spin of a body [J]."""
    energy = 0.0
    for k in range(3, 6):
        if inverse_mass[b, k] > 0.0:
            energy += 0.5 * mass[b, k] * velocities[b, k] ** 2
    return energy


@inlined
def turn_part(b, time, positions, velocities, mass, inverse_mass):
    """Turn a body over a time in which it turns little."""
    x = velocities[b, 3]
    y = velocities[b, 4]
    z = velocities[b, 5]
    m_x = x
    m_y = y
    m_z = z
    i_x = mass[b, 3]
    i_y = mass[b, 4]
    i_z = mass[b, 5]
    held_x = inverse_mass[b, 3] == 0.0
    held_y = inverse_mass[b, 4] == 0.0
    held_z = inverse_mass[b, 5] == 0.0
    if not (i_x == i_y == i_z):
        for _ in range(PASSES):
            half = 0.5 * time * np.sqrt(m_x * m_x + m_y * m_y + m_z * m_z)
            factor = 0.5 * time * (np.tan(half) / half if half > 0.0 else 1.0)
            # (1) for the mean spin: m = w0 + c T/2 I^-1 (I m) x m
            new_x = x if held_x else x + factor * ((i_y - i_z) / i_x * m_y * m_z)
            new_y = y if held_y else y + factor * ((i_z - i_x) / i_y * m_z * m_x)
            new_z = z if held_z else z + factor * ((i_x - i_y) / i_z * m_x * m_y)
            change = abs(new_x - m_x) + abs(new_y - m_y) + abs(new_z - m_z)
            m_x = new_x
            m_y = new_y
            m_z = new_z
            if change <= 2.0**-53 * (abs(m_x) + abs(m_y) + abs(m_z)):
                break
        velocities[b, 3] = 2.0 * m_x - x
        velocities[b, 4] = 2.0 * m_y - y
        velocities[b, 5] = 2.0 * m_z - z
    turn_by(b, time * m_x, time * m_y, time * m_z, positions)


@inlined
def turn_by(b, x, y, z, positions):
    """Turn a body by a rotation vector along its own axes [rad], (2)."""
    angle = np.sqrt(x * x + y * y + z * z)
    if angle == 0.0:
        return
    # q <- q (sin(angle / 2) axis, cos(angle / 2)), of length one again
    sine = np.sin(0.5 * angle) / angle
    e_x = sine * x
    e_y = sine * y
    e_z = sine * z
    e_w = np.cos(0.5 * angle)
    q_x = positions[b, 3]
    q_y = positions[b, 4]
    q_z = positions[b, 5]
    q_w = positions[b, 6]
    n_x = q_w * e_x + q_x * e_w + q_y * e_z - q_z * e_y
    n_y = q_w * e_y + q_y * e_w + q_z * e_x - q_x * e_z
    n_z = q_w * e_z + q_z * e_w + q_x * e_y - q_y * e_x
    n_w = q_w * e_w - q_x * e_x - q_y * e_y - q_z * e_z
    length = np.sqrt(n_x * n_x + n_y * n_y + n_z * n_z + n_w * n_w)
    positions[b, 3] = n_x / length
    positions[b, 4] = n_y / length
    positions[b, 5] = n_z / length
    positions[b, 6] = n_w / length


@kernel
def turn_on(rows, moving, positions):
    """Turn bodies by rotation vectors along their own axes [rad], the last three columns of ``moving`` (n, 6)."""
    for j in range(rows.shape[0]):
        b = rows[j]
        turn_by(b, moving[b, 3], moving[b, 4], moving[b, 5], positions)


def turn_to(rows: np.ndarray, ahead: np.ndarray, expected: np.ndarray, positions: np.ndarray) -> None:
    """Turn the bodies of some rows so that the free motion which leads from ``positions`` to ``expected`` leads to
    ``ahead`` instead, all (n, 7). A free motion turns a body by the same rotation about its own axes wherever it starts, so
    that the rotation from ``expected`` to ``ahead``, about the axes of space, may come first."""
    from scipy.spatial.transform import Rotation  # takes as long to import as the rest of lmgcpy

    now, then, place = (Rotation.from_quat(q[rows, 3:]) for q in (positions, expected, ahead))
    positions[rows, 3:] = (place * then.inv() * now).as_quat()


def with_rotations(positions: np.ndarray) -> np.ndarray:
    """Positions (n, 7) of bodies (n, 3) whose axes are those of space."""
    return np.column_stack([positions, np.zeros((len(positions), 3)), np.ones(len(positions))])


def matrices(positions: np.ndarray, turning: np.ndarray) -> np.ndarray:
    """Rotation matrices of bodies row by row, (n, 9), from positions (n, 7) and the rows of those that turn; (0, 9) if none
    does."""
    if not len(turning):
        return np.zeros((0, 9))
    axes = np.tile(np.eye(3).ravel(), (len(positions), 1))
    axes[turning] = axes_of(positions[turning]).reshape(-1, 9)
    return axes
