"""A form of the rows of ``H^T``: what an interaction reads of its bodies' velocities, and what its impulse does to them.

Each form has a file beside this one with the mathematics and six functions; :data:`FORMS` lists them. Sweeps, momentum,
Newton steps and measures know no other way to the velocities of the bodies.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from functools import cache, partial
from itertools import product
from types import ModuleType
from typing import Any

import numpy as np

from lmgcpy.compiled.by_address import call, group_signature
from lmgcpy.compiled.kernel import Kernel, kernel
from lmgcpy.compiled.small_matrices import small_matrices
from lmgcpy.contact.elements import elements_form
from lmgcpy.solve.kernels import contact_block
from lmgcpy.solve.kernels.forms import (
    cell,
    elements_in_plane,
    elements_in_space,
    lever_in_space,
    lever_rolling_in_space,
    plane,
    rolling_in_plane,
    rolling_in_space,
    space,
)


@dataclass(frozen=True, eq=False)
class Form:
    """The six functions of a form; the first three are templates of one interaction, for kernels that sweep."""

    dimension: int
    width: int
    """Components of an impulse."""
    relative_velocity: Callable
    """``(i, s)``: ``H^T v`` of interaction i, a tuple."""
    push: Callable
    """``(i, s, d)``: add ``M^-1 H d`` of an impulse d to ``s.velocity``."""
    local_problem: Callable
    """``(i, s, u, r)``: the local block of W, and ``u - W r``."""
    momentum: Kernel
    """``(start, stop, walls, s)``: add ``H r`` of some interactions [N s, N m s] to ``s.velocity``, which holds momenta
    then; not to candidates (``walls`` 0) or antagonists (1) that are held walls."""
    relative_velocities: Kernel
    """``(start, stop, s, velocity, result)``: ``H^T v`` of some interactions for velocities of the bodies (n, k)."""
    rows: Callable[[Any, slice], np.ndarray] | None = None
    """``(s, part)``: rows of ``H^T``, (m, width, b k): the columns of the candidate, then those of the antagonist, and of
    further bodies. None if there are no bodies."""
    bodies: Callable[[Any, slice], np.ndarray] | None = None
    """``(s, part)``: rows of these bodies, (m, b) int64; None if they are the candidate and the antagonist."""
    constants: dict[str, Any] = field(default_factory=dict)
    """Constants that its functions read."""
    seen: int | None = None
    """Number of components of the vectors and matrices that its functions work on; None: the dimension."""

    def parts(self, names: dict[str, Any]) -> dict[str, Callable]:
        """The first three functions as slots of a template whose other slots and constants are ``names``."""
        names = {**small_matrices(self.seen or self.dimension), **names, **self.constants}
        return {name: Kernel(getattr(self, name), names) for name in ("relative_velocity", "push", "local_problem")}

    def slots(self, constants: dict[str, Any]) -> dict[str, Any]:
        """The slots of a template of contacts or links: ``constants``, which the form's functions see as well, the parts of
        the form, and functions of vectors."""
        names = {**small_matrices(self.width), **constants, **self.constants, **self.parts(constants)}
        if self.width > self.dimension:
            return names
        links: dict[str, Callable] = {
            "normal_velocity": contact_block.normal_velocity,
            "push_normal": contact_block.push_normal,
        }
        return {**names, **{name: Kernel(function, names) for name, function in links.items()}}

    def add_momentum(self, start: int, stop: int, system: Any, system_type: Any) -> None:
        """Call ``momentum`` for all bodies; by its address, so that it is compiled once."""
        called(self.momentum_at(system_type).address, start, stop, -1, system)

    def momentum_at(self, system_type: Any) -> Any:
        """C function of ``momentum`` for systems of a numba type."""
        return _momentum_at(self, system_type)


@kernel
def called(address, start, stop, walls, s):
    """Call a kernel of a group by its address."""
    return call(address, start, stop, walls, s)


@cache
def _momentum_at(form: Form, system_type: Any) -> Any:
    return form.momentum.pointer(group_signature(system_type))


def written_in(file: ModuleType, dimension: int, width: int, **constants: Any) -> Form:
    """The form whose functions stand in a file."""
    functions: dict[str, Any] = {
        name: getattr(file, name) for name in ("relative_velocity", "push", "local_problem", "rows")
    }
    for name in ("momentum", "relative_velocities"):
        functions[name] = Kernel(getattr(file, name), {**small_matrices(dimension), **constants})
    return Form(dimension, width, **functions, constants=constants)


def on_elements(dimension: int, candidate: int, antagonist: int) -> Form:
    """The form of two sides of which at least one is an element, by their numbers of bodies."""
    file = elements_in_plane if dimension == 2 else elements_in_space
    corners = sum(count for count in (candidate, antagonist) if count > 1)
    form = written_in(file, dimension, dimension, CANDIDATE=candidate, ANTAGONIST=antagonist, BOTH=corners)
    rows = partial(file.rows, candidate=candidate, antagonist=antagonist)
    return replace(form, rows=rows, bodies=file.bodies)


FORMS: dict[tuple[int, str], Form] = {
    (2, "central"): written_in(plane, 2, 2, CENTRAL=True),
    (2, "lever"): written_in(plane, 2, 2, CENTRAL=False),
    (3, "central"): written_in(space, 3, 3),
    (3, "lever"): written_in(lever_in_space, 3, 3),
    **{
        (dimension, elements_form(*counts)): on_elements(dimension, *counts)
        for dimension in (2, 3)
        for counts in product((1, 2, 3), repeat=2)
        if max(counts) > 1
    },
}
"""By dimension and the name that a narrow phase gives: "central" where the contact point lies on the normal through both
centres."""
ROLLING: dict[tuple[int, str], Form] = {
    (2, "central"): written_in(rolling_in_plane, 2, 3, CENTRAL=True),
    (2, "lever"): written_in(rolling_in_plane, 2, 3, CENTRAL=False),
    (3, "central"): written_in(rolling_in_space, 3, 6, ISOTROPIC=True),
    (3, "central, unlike"): written_in(rolling_in_space, 3, 6, ISOTROPIC=False),
    (3, "lever"): written_in(lever_rolling_in_space, 3, 6),
}
"""Forms of contacts with rolling friction; "unlike" if bodies have different inertias about their axes."""


@dataclass(frozen=True, eq=False)
class FormInCell(Form):
    """A form in a periodic cell that deforms."""

    base: Form = field(kw_only=True)

    def parts(self, names: dict[str, Any]) -> dict[str, Callable]:
        parts = self.base.parts(names)
        geometry = {**GEOMETRY[self.dimension], "plus_first": cell.sum_of_first(self.dimension, self.width)}
        velocity = Kernel(cell.relative_velocity, {**geometry, "base_velocity": parts["relative_velocity"]})
        push = Kernel(cell.push, {**geometry, "base_push": parts["push"]})
        return {**parts, "relative_velocity": velocity, "push": push}


GEOMETRY: dict[int, dict[str, Callable]] = {
    2: {"flow": cell.flow_2d, "in_frame": cell.in_frame_2d, "in_space": cell.in_space_2d},
    3: {"flow": cell.flow_3d, "in_frame": cell.in_frame_3d, "in_space": cell.in_space_3d},
}
"""Functions of a dimension that ``cell`` calls."""


@cache
def in_cell(form: Form) -> FormInCell:
    """The form with what a periodic cell that deforms adds."""
    names = {**GEOMETRY[form.dimension], "row": small_matrices(form.dimension)["row"]}
    momentum = Kernel(cell.momentum, {**names, "base_momentum": form.momentum})
    velocities = Kernel(cell.relative_velocities, {**names, "base_velocities": form.relative_velocities})
    same = {name.name: getattr(form, name.name) for name in fields(form)}
    return FormInCell(**{**same, "momentum": momentum, "relative_velocities": velocities}, base=form)
