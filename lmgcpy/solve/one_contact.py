"""The frictional contact problem of one interaction: its solution, or the status that it has none."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.errors import named_arguments, number, numbers
from lmgcpy.laws.coulomb import react_in_plane, react_in_space

SOUND = 1e-9
"""A difference of at most this part of its terms is taken for round-off: blocks that miss symmetry or a zero eigenvalue by
it, and errors ``e = w (r - react(w I, u - w r))`` of a solution. The errors of positive definite blocks stay below 1e-9 up
to a condition of 1e9 (``tests/solve/test_one_contact.py``)."""


@dataclass(frozen=True)
class LocalSolution:
    """Impulse and velocity of one contact, normal first."""

    impulse: np.ndarray
    """[N s], (d,)."""
    velocity: np.ndarray
    """``q + W r`` [m/s], (d,)."""
    status: str
    """"open", "stick", "slide", or "infeasible": no impulse satisfies the law, and the impulse given is the one without
    friction, or zero if no impulse changes the normal velocity."""

    def __repr__(self) -> str:
        given = ", ".join(f"{component:.6g}" for component in self.impulse)
        return f"<LocalSolution: {self.status}, impulse ({given}) N s>"


@kernel
def react_plane_alone(W, q, friction, impulse):
    """The impulse of a single contact in the plane, with the block W (2, 2), into ``impulse``."""
    impulse[0], impulse[1] = react_in_plane(((W[0, 0], W[0, 1]), (W[1, 0], W[1, 1])), q[0], q[1], friction)


@kernel
def react_space_alone(W, q, friction, impulse):
    """The impulse of a single contact in space, with the block W (3, 3), into ``impulse``."""
    block = ((W[0, 0], W[0, 1], W[0, 2]), (W[1, 0], W[1, 1], W[1, 2]), (W[2, 0], W[2, 1], W[2, 2]))
    impulse[0], impulse[1], impulse[2] = react_in_space(block, q[0], q[1], q[2], friction)


@named_arguments
def solve_local(W: Any, q: Any, *, friction: float) -> LocalSolution:
    """The impulse of one contact with Coulomb friction, by the kernel that the sweeps use.

    ``W``: block of the Delassus operator [1/kg], (2, 2) or (3, 3), symmetric, without negative eigenvalues; ``q``: velocity
    without the impulse [m/s], (2,) or (3,); ``friction``: mu >= 0. A positive definite block always has a solution
    (docs/solvers.md says which one if there are several), and a singular one a solution or the status "infeasible".
    ValueError for a block that is neither.
    """
    block, free = numbers(W, "W"), numbers(q, "q")
    friction = number(friction, "friction", minimum=0.0)
    if block.shape not in ((2, 2), (3, 3)) or free.shape != block.shape[:1]:
        raise ValueError(f"W must have shape (2, 2) or (3, 3) and q (2,) or (3,), got {block.shape} and {free.shape}.")
    size = float(np.abs(block).max())
    if float(np.abs(block - block.T).max()) > SOUND * size:
        raise ValueError("W must be symmetric.")
    least = float(np.linalg.eigvalsh(block).min())
    if least < -SOUND * size:
        raise ValueError(f"W must have no negative eigenvalue, got {least:g}.")
    block = 0.5 * (block + block.T)
    react = react_plane_alone if len(free) == 2 else react_space_alone
    impulse, again = np.zeros(len(free)), np.zeros(len(free))
    react(block, free, friction, impulse)
    velocity = free + block @ impulse
    weight = float(block.diagonal().mean()) or 1.0
    react(weight * np.eye(len(free)), velocity - weight * impulse, friction, again)
    error = weight * float(np.abs(impulse - again).max())
    terms = float(np.abs(free).max() + (np.abs(block) @ np.abs(impulse)).max())
    if error > SOUND * terms:
        status = "infeasible"
    elif impulse[0] == 0.0:
        status = "open"
    else:
        status = "stick" if float(np.abs(velocity[1:]).max()) <= SOUND * terms else "slide"
    return LocalSolution(impulse, velocity, status)
