"""The problem of one time step is made: from interactions and laws to the arrays that a solver works on."""

from __future__ import annotations

import numpy as np

from lmgcpy.compiled.kernel import kernel
from lmgcpy.compiled.mode import mode
from lmgcpy.contact.detector import Detector, Group
from lmgcpy.contact.interactions import with_spare_rows
from lmgcpy.contact.narrow_phase import Interactions
from lmgcpy.dynamics.cell import CellMotion
from lmgcpy.dynamics.model import Model
from lmgcpy.dynamics.rolling import mark_isotropic, rolling_radius, with_rolling
from lmgcpy.dynamics.rotation import matrices
from lmgcpy.dynamics.schedule import most_at_once, schedule
from lmgcpy.dynamics.step_problem import StepProblem
from lmgcpy.laws.pair import asks_for_pair
from lmgcpy.solve.kernels.forms.form import FORMS, ROLLING, in_cell
from lmgcpy.solve.kernels.forms.lever_in_space import fill_moments
from lmgcpy.solve.kernels.law_kernels import KernelKey, LawKernels, StepData, law_kernels
from lmgcpy.solve.kernels.system import System
from lmgcpy.solve.sweeps.light_bodies import LightBodies, no_light_bodies


def kernels_of(group: Group, dimension: int, wire_blocks: bool, deforms: bool) -> LawKernels:
    """The kernels of a group in this step; ``deforms``: whether a periodic cell deforms."""
    rows = group.law.rows(dimension)
    form = FORMS[dimension, group.form]
    if rows > dimension:
        form = ROLLING[dimension, group.form if group.isotropic else f"{group.form}, unlike"]
    key = KernelKey(
        form=in_cell(form) if deforms else form,
        rows=rows,
        parameters=group.parameters.shape[1],
        diagonal=group.diagonal,
        block=group.chain is not None and wire_blocks and group.law.slope is not None,
        walls=group.walls if group.cuts is not None else -1,
    )
    return law_kernels(type(group.law), key)


KEPT = 2000
"""A step with at most this many interactions may leave its arrays to the next one. In a small scene, making the arrays
costs as much as all kernels; in a large one, interactions come and go at every step, and memory counts."""


class Assembler:
    """Makes the problem of each step of a simulation. It uses the same arrays again as long as the interactions of a small
    scene stay the same."""

    def __init__(self, model: Model):
        self._model = model
        self._size = model.size
        self._kept: StepProblem | None = None
        self._groups: list[Group] = []
        self._kind: tuple = ()
        """Slots, time step, wire blocks, diagonal blocks, masses of the sweep, and mode of the kernels, whose addresses it
        has, for which ``_kept`` was laid out."""

    def assemble(
        self,
        detector: Detector,
        interactions: Interactions,
        *,
        time: float,
        time_step: float,
        positions: np.ndarray,
        before: np.ndarray,
        written: np.ndarray | None,
        free_velocity: np.ndarray,
        mobility: np.ndarray,
        more: np.ndarray | None,
        wire_blocks: bool,
        threads: int,
    ) -> StepProblem:
        """The arrays of a step from its interactions, with the numbers that each law prepares.

        ``positions`` of the detection, (n, 3); ``before`` and ``free_velocity``: velocities of the bodies at the start of
        the step and without impulses, (n, k); ``written``: ways to this detection that the last step did not know of,
        (n, k), or None; ``mobility``: inverse masses in the step, (n, k), see :mod:`lmgcpy.dynamics.drag`; ``more``: see
        :func:`~lmgcpy.dynamics.sweep_mass.sweep_mass`.
        """
        model, groups = self._model, detector.groups
        cell = model.cell_in_step(before, free_velocity)
        axes = matrices(positions, model.turning)
        kept = self._kept
        swept = (b"" if more is None else more.tobytes()) + (b"" if mobility is model.inverse_mass else mobility.tobytes())
        diagonal = [group.diagonal for group in groups]
        kind = interactions.slot[:KEPT].tobytes(), time_step, wire_blocks, diagonal, swept, mode.plain
        if kept is None or groups is not self._groups or kind != self._kind or cell is not None:
            self._kept = kept = None  # frees its arrays before the new ones are made
            rate = time_step / self._size
            bodies = model, rate, mobility, axes
            kept = lay_out(detector, interactions, *bodies, more=more, wire_blocks=wire_blocks, cell=cell)
            # the terms of W from rolling contacts and from cells that deform are made at each detection
            if len(interactions.slot) <= KEPT and cell is None and not len(kept.system.rolling):
                self._kept, self._groups, self._kind = kept, groups, kind
        detector.recall(interactions, kept.guess, kept.data.state)
        kept.row = detector.place
        if kept.row is not None or len(kept.light.body) or kept.threads != threads:
            kept.crews.clear()  # what sweeps get is a copy of arrays of this step
        kept.threads, kept.carried = threads, None
        if len(axes):
            kept.system.axes[:] = axes
        if model.dimension == 3:
            for group in kept.by_law:  # before the relative velocities
                if group.form != "central":
                    fill_moments(group.start, group.stop, kept.system)
        fill(kept, time, time_step, positions, before, written, free_velocity)
        if cell is not None:
            kept.system.farness[cell.lattice.rows] = 0.0
        return kept


def lay_out(
    detector: Detector,
    interactions: Interactions,
    model: Model,
    rate: np.ndarray,
    mobility: np.ndarray,
    axes: np.ndarray,
    *,
    more: np.ndarray | None,
    wire_blocks: bool,
    cell: CellMotion | None,
) -> StepProblem:
    """The arrays of a step, filled with all that depends only on the set of its interactions.

    ``rate``: time step over the radius of the smallest contactor of each body [s/m], (n,); ``mobility``: inverse masses in
    the step, (n, k); ``axes`` of the bodies (n, 9); ``more``: mass in the sweep over mass, (n,); ``cell``: a periodic cell
    that deforms in this step.
    """
    dimension, (width, states) = interactions.normal.shape[1], detector.remembered
    groups = [group for group in detector.groups if group.stop > group.start]
    pairs = known_pairs(groups, interactions, model)
    rolls = width > dimension  # some contacts of the scene have rolling components
    inverse_mass, light = mobility, no_light_bodies(mobility.shape[1])
    if more is not None:
        mass = model.free_mass if mobility is model.inverse_mass else 1.0 / np.where(mobility > 0.0, mobility, np.inf)
        inverse_mass, light = mobility / more[:, None], light_bodies(more, rate, mass)
    if rolls:
        mark_isotropic(groups, interactions, inverse_mass)
    edges, branch = np.zeros(0, np.int64), np.zeros((0, 0))
    if cell is not None:
        edges, branch = cell.lattice.rows, cell.branches(groups, interactions)
        cell.add_to_blocks(branch, groups, interactions, inverse_mass, most_at_once(groups))
    # in a cell that yields each link is coupled with all others, by the cell: a wire in one block would overshoot
    wire_blocks = wire_blocks and not (cell is not None and cell.yields(inverse_mass))
    kernels = [kernels_of(group, dimension, wire_blocks, deforms=cell is not None) for group in groups]
    count, bodies = len(interactions.gap), model.inverse_mass.shape
    offset = np.zeros(len(groups) + 1, dtype=np.int64)
    np.cumsum([len(group.law.PREPARED) * (group.stop - group.start) for group in groups], out=offset[1:])
    rolling, delassus = np.zeros(0), interactions.delassus
    if rolls:
        rolling = rolling_radius(groups, pairs, dimension, count)
        delassus = with_rolling(delassus, rolling, groups, interactions, inverse_mass, axes)
    system = System(
        candidate=interactions.candidate,
        antagonist=interactions.antagonist,
        normal=interactions.normal,
        tangent=interactions.tangent,
        arm=interactions.arm,
        lateral=interactions.lateral,
        lever=interactions.lever,
        moment=with_spare_rows(len(interactions.lever), 18),
        axes=axes,
        rolling=rolling,
        edges=edges,
        branch=branch,
        cell=with_spare_rows(len(branch), fill=edges[0] if len(edges) else 0, dtype=np.uint32),
        delassus=delassus,
        coupling=interactions.coupling,
        shear=interactions.shear,
        corner=interactions.corner,
        weight=interactions.weight,
        prepared=with_spare_rows(int(offset[-1])),
        impulse=with_spare_rows(count, width),
        velocity=np.empty(bodies),
        inverse_mass=inverse_mass,
        geometric=np.zeros(0),
        carried=np.zeros((0, dimension - 1)),
        own=np.zeros((0, dimension, dimension)),
        following=np.zeros((0, dimension, dimension)),
        scratch=np.empty((sum(group.stop - group.start for group in groups if group.chain), 4)),
        scale=np.maximum(rate.take(interactions.candidate), rate.take(interactions.antagonist)),
        squared_error=with_spare_rows(count),
        noise=with_spare_rows(bodies[0], 4),
        floor=with_spare_rows(count),
        farness=with_spare_rows(bodies[0]),
        measured=np.empty(6),
    )
    data = StepData(
        gap=interactions.gap,
        reference_gap=with_spare_rows(count, fill=0.0),
        before=with_spare_rows(count, width),
        after=with_spare_rows(count, width),
        pairs=pairs,
        state=with_spare_rows(count, states),
        time=0.0,
        time_step=0.0,
        at=np.zeros(1, dtype=np.int64),
    )
    return StepProblem(
        system=system,
        by_law=groups,
        kernels=kernels,
        groups=schedule(groups, kernels, offset[:-1]),
        offset=offset[:-1],
        data=data,
        free_velocity=np.empty(bodies),
        light=light,
        inverse_mass=mobility,
        guess=with_spare_rows(count, width),
        keeps_gap=keeps_gap(groups),
        yielding=yielding(groups),
        takes_back_later=takes_back_later(groups),
        carried=None,
    )


def keeps_gap(groups: list[Group]) -> np.ndarray:
    """Whether an interaction is a contact whose law keeps the gap that it predicts, (m,) bool."""
    return of_interactions(groups, [group.chain is None and group.law.KEEPS_GAP for group in groups])


def takes_back_later(groups: list[Group]) -> np.ndarray:
    """Whether the rest of the overlap that a step leaves is added to the gap that the law predicts, (m,) bool."""
    return of_interactions(groups, [group.law.TAKES_BACK_LATER for group in groups])


def of_interactions(groups: list[Group], values: list[bool]) -> np.ndarray:
    """A value for each group as one for each of its interactions, (m,) bool."""
    return np.repeat(np.array(values, dtype=bool), [group.stop - group.start for group in groups])


def yielding(groups: list[Group]) -> np.ndarray:
    """Rows of links whose law yields."""
    links = [group for group in groups if group.chain is not None and "rigid" not in group.law.TRAITS]
    return np.concatenate([np.zeros(0, np.int64), *(np.arange(group.start, group.stop) for group in links)])


def light_bodies(more: np.ndarray, rate: np.ndarray, mass: np.ndarray) -> LightBodies:
    """The light bodies of a step, from M / m of all bodies (n,), the time step over their size [s/m], (n,), and their
    masses by component (n, k), zero for components that are held."""
    body = np.flatnonzero(more > 1.0)
    rows = {name: np.empty((len(body), mass.shape[1])) for name in ("free", "start", "centre", "best", "aside", "way")}
    share, stride, out = 1.0 / more[body], np.ones(len(body)), np.zeros(len(body))
    return LightBodies(body=body, rate=rate[body], share=share, mass=mass[body], stride=stride, out=out, **rows)


def fill(
    problem: StepProblem,
    time: float,
    time_step: float,
    positions: np.ndarray,
    before: np.ndarray,
    written: np.ndarray | None,
    free_velocity: np.ndarray,
) -> None:
    """Fill the arrays of a step, and let each law prepare its numbers; arguments as of :meth:`Assembler.assemble`."""
    system = problem.system
    # in a third of the time of _replace
    problem.data = data = StepData._make([*problem.data[:6], time, time_step, problem.data.at])
    if written is not None:  # a contact is closer by these ways, and not because anything turned
        data.state[:, -1] += problem.relative_velocities(written)[:, 0]
    of_bodies = problem.free_velocity, system.velocity, system.farness
    enter(time_step, problem.dimension, positions, free_velocity, *of_bodies, *data[:2], data.state, problem.keeps_gap)
    light = problem.light
    if len(light.body):
        light.free[:] = free_velocity[light.body]
        light.way[:] = 0.0
        light.stride[:] = 1.0
        light.start[:] = light.centre[:] = light.best[:] = before[light.body]
    system.impulse.fill(0.0)
    system.scratch.fill(0.0)
    system.measured.fill(0.0)
    problem.relative_velocities(before, data.before)
    for group in problem.by_law:
        if group.chain:
            data.reference_gap[group.start : group.stop] = group.chain.reference_gap_at(time)
    problem.prepare()


@kernel
def enter(time_step, dimension, positions, free_velocity, free, velocity, farness, gap, reference_gap, state, keeps_gap):
    """Enter the velocities without impulses (n, k) as those to begin with, the largest coordinates of the bodies over the
    time step (n,), and the gaps that laws keep as reference gaps, the detected ones if they were not predicted (m,)."""
    for b in range(free_velocity.shape[0]):
        for k in range(free_velocity.shape[1]):
            free[b, k] = free_velocity[b, k]
            velocity[b, k] = free_velocity[b, k]
        largest = 0.0
        for k in range(dimension):
            largest = max(largest, abs(positions[b, k]))
        farness[b] = largest / time_step
    for i in range(gap.shape[0]):
        if keeps_gap[i]:
            predicted = state[i, state.shape[1] - 1]
            reference_gap[i] = min(gap[i] if np.isnan(predicted) else predicted, 0.0)


def known_pairs(groups: list[Group], interactions: Interactions, model: Model) -> np.ndarray:
    """Radii [m] and masses [kg] of candidates and antagonists, (m, 4); (0, 4) if no law of the scene asks.

    Only the rows of laws that ask, and of laws with rolling components, are filled.
    """
    d = model.dimension
    asking = [group for group in groups if group.stop > group.start and (asks_for_pair(group.law) or group.law.rows(d) > d)]
    if not asking:
        return np.zeros((0, 4))
    result = np.full((len(interactions.gap), 4), np.nan)
    for group in asking:
        part = slice(group.start, group.stop)
        bodies = np.column_stack([interactions.candidate[part], interactions.antagonist[part]])
        if group.chain is not None:
            result[part, :2] = model.radius[bodies]
        else:
            result[part, :2] = model.contactors.radius[group.pairs[interactions.slot[part] - group.first_slot]]
        result[part, 2:] = model.movable_mass[bodies]
    return result
