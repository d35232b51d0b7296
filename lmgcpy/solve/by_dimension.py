"""What differs between dimension 2 and 3: the templates of a single interaction, and what solvers do to the velocities."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from lmgcpy.compiled.kernel import Kernel
from lmgcpy.solve import contact_block, contact_block_3d


@dataclass(frozen=True)
class Space:
    """One dimension's kernels and templates."""

    dimension: int
    components: tuple[str, ...]
    """Of a body's velocity."""
    sweep: Callable
    error: Callable
    """Templates of a group of single interactions."""
    link: dict[str, Any]
    """What the template of wires is specialised with."""
    driver: dict[str, Any]
    """What the kernels of solvers are specialised with."""
    momentum: Kernel
    """``(start, stop, walls, s, result)``: adds what impulses give to the bodies."""
    relative_velocities: Kernel
    """``(s, velocity, result)``: relative velocities of all interactions for the velocities of the bodies."""


PLANE = Space(
    dimension=2,
    components=("x", "y", "spin"),
    sweep=contact_block.sweep,
    error=contact_block.error,
    link={},
    driver={},
    momentum=Kernel(contact_block.momentum),
    relative_velocities=Kernel(contact_block.relative_velocities),
)
VOLUME = Space(
    dimension=3,
    components=("x", "y", "z", "spin_x", "spin_y", "spin_z"),
    sweep=contact_block_3d.sweep,
    error=contact_block_3d.error,
    link={
        "normal_velocity": contact_block_3d.normal_velocity,
        "push_normal": contact_block_3d.push_normal,
        "relative_velocity": contact_block_3d.relative_velocity,
        "push_row": contact_block_3d.push_row,
    },
    driver={"momentum": contact_block_3d.momentum},
    momentum=Kernel(contact_block_3d.momentum),
    relative_velocities=Kernel(contact_block_3d.relative_velocities),
)
SPACES = {2: PLANE, 3: VOLUME}
