"""The parts of templates that differ between 2D and 3D, and the kernels over all interactions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from lmgcpy.compiled.kernel import Kernel
from lmgcpy.solve import cell_rows, contact_block, h_rows_2d, h_rows_3d, rolling_rows_2d, rolling_rows_3d
from lmgcpy.solve.small_matrices import small_matrices


@dataclass(frozen=True)
class DimensionKernels:
    """One dimension's kernels and parts of templates."""

    dimension: int
    components: tuple[str, ...]
    """Names of the components of a body's velocity."""
    parts: dict[str, Callable]
    """Slots of the templates: what relative velocities, impulses and local blocks are for bodies."""
    driver: dict[str, Any]
    """Slots of the kernels that lead sweeps."""
    momentum: Kernel
    """``(start, stop, walls, s, result)``: adds what impulses give to the bodies."""
    relative_velocities: Kernel
    """``(s, velocity, result)``: relative velocities of all interactions for the velocities of the bodies."""


IN_2D = DimensionKernels(
    dimension=2,
    components=("x", "y", "spin"),
    parts={
        "relative_velocity": h_rows_2d.relative_velocity,
        "push": h_rows_2d.push,
        "local_problem": h_rows_2d.local_problem,
    },
    driver={},
    momentum=Kernel(h_rows_2d.momentum),
    relative_velocities=Kernel(h_rows_2d.relative_velocities),
)
IN_3D = DimensionKernels(
    dimension=3,
    components=("x", "y", "z", "spin_x", "spin_y", "spin_z"),
    parts={
        "relative_velocity": h_rows_3d.relative_velocity,
        "push": h_rows_3d.push,
        "local_problem": h_rows_3d.local_problem,
    },
    driver={"momentum": h_rows_3d.momentum},
    momentum=Kernel(h_rows_3d.momentum),
    relative_velocities=Kernel(h_rows_3d.relative_velocities),
)
DIMENSIONS = {2: IN_2D, 3: IN_3D}
ROLLING = {
    2: DimensionKernels(
        dimension=2,
        components=IN_2D.components,
        parts={
            "relative_velocity": rolling_rows_2d.relative_velocity,
            "push": rolling_rows_2d.push,
            "local_problem": rolling_rows_2d.local_problem,
        },
        driver={"momentum": rolling_rows_2d.momentum},
        momentum=Kernel(rolling_rows_2d.momentum),
        relative_velocities=Kernel(rolling_rows_2d.relative_velocities),
    ),
    3: DimensionKernels(
        dimension=3,
        components=IN_3D.components,
        parts={
            "relative_velocity": rolling_rows_3d.relative_velocity,
            "push": rolling_rows_3d.push,
            "local_problem": rolling_rows_3d.local_problem,
        },
        driver={"momentum": rolling_rows_3d.momentum},
        momentum=Kernel(rolling_rows_3d.momentum),
        relative_velocities=Kernel(rolling_rows_3d.relative_velocities),
    ),
}
"""The same where a scene has contacts with rolling friction."""
GEOMETRY: dict[int, dict[str, Callable]] = {
    2: {"flow": cell_rows.flow_2d, "in_frame": cell_rows.in_frame_2d, "in_space": cell_rows.in_space_2d},
    3: {"flow": cell_rows.flow_3d, "in_frame": cell_rows.in_frame_3d, "in_space": cell_rows.in_space_3d},
}
"""Slots of ``cell_rows``."""


@cache
def dimension_kernels(dimension: int, rolls: bool, deforms: bool) -> DimensionKernels:
    """The kernels of a dimension; ``rolls``: where a scene has contacts with rolling friction, ``deforms``: where a
    periodic cell deforms."""
    plain = (ROLLING if rolls else DIMENSIONS)[dimension]
    if not deforms:
        return plain
    slots = {**GEOMETRY[dimension], "row": small_matrices(dimension)["row"]}
    momentum = Kernel(cell_rows.momentum, {**slots, "base_momentum": plain.momentum})
    velocities = Kernel(cell_rows.relative_velocities, {**slots, "base_velocities": plain.relative_velocities})
    return replace(plain, driver={"momentum": momentum}, momentum=momentum, relative_velocities=velocities)


def with_cell(parts: dict[str, Callable], dimension: int, rows: int) -> dict[str, Callable]:
    """Parts of a dimension, of ``rows`` components, with what a deforming cell adds."""
    geometry = {**GEOMETRY[dimension], "plus_first": cell_rows.sum_of_first(dimension, rows)}
    velocity = Kernel(cell_rows.relative_velocity, {**geometry, "base_velocity": parts["relative_velocity"]})
    push = Kernel(cell_rows.push, {**geometry, "base_push": parts["push"]})
    return {**parts, "relative_velocity": velocity, "push": push}


def template_slots(
    dimension: int,
    constants: dict[str, Any],
    parts: dict[str, Callable] | None = None,
    rows: int = 0,
    *,
    deforms: bool = False,
) -> dict[str, Any]:
    """The slots of a template of contacts or links: ``constants``, which its parts see as well, the parts of the dimension
    or the ``parts`` given, and functions of vectors; ``rows``: how many the law has, with rolling ones if they are more
    than the dimension; ``deforms``: in a periodic cell that deforms."""
    own = {**small_matrices(dimension), **constants}
    if rows > dimension:
        seen = {**small_matrices(rows), **constants}
        given = parts or ROLLING[dimension].parts
        rolling: dict[str, Callable] = {name: Kernel(part, seen if parts else own) for name, part in given.items()}
        if deforms:
            rolling = with_cell(rolling, dimension, rows)
        return {**seen, **rolling}
    link: dict[str, Callable] = {"normal_velocity": contact_block.normal_velocity, "push_normal": contact_block.push_normal}
    slots: dict[str, Callable]
    slots = {name: Kernel(part, own) for name, part in (parts or DIMENSIONS[dimension].parts).items()}
    if deforms:
        slots = with_cell(slots, dimension, dimension)
    return {**own, **slots, **{name: Kernel(part, {**own, **slots}) for name, part in link.items()}}
