"""The problem of one time step: from interactions and laws to the arrays that a solver works on."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from lmgcpy.compiled.kernel import CompilerError, Kernel
from lmgcpy.contact.detector import Detector, Group
from lmgcpy.contact.narrow_phase import Interactions
from lmgcpy.contact.spare_rows import with_spare_rows
from lmgcpy.dynamics.cell import CellMotion
from lmgcpy.dynamics.known_pairs import known_pairs
from lmgcpy.dynamics.model import Model
from lmgcpy.dynamics.rolling import mark_isotropic, rolling_radius, with_rolling
from lmgcpy.dynamics.schedule import schedule
from lmgcpy.errors import told
from lmgcpy.solve.kernels.forms.form import FORMS, ROLLING, Form, in_cell
from lmgcpy.solve.kernels.law_kernels import KernelKey, LawKernels, StepData, law_kernels, not_compiled
from lmgcpy.solve.kernels.system import Groups, System
from lmgcpy.solve.problems.report import Worst
from lmgcpy.solve.sweeps.light_bodies import LightBodies, no_light_bodies
from lmgcpy.solve.sweeps.step import Step

NO_MOBILITY = float(np.finfo(float).tiny)
"""Replaces ``W_nn = 0``, by which a law may divide. It is negligible beside any compliance."""


@dataclass
class StepProblem:
    """A step as dynamics knows it: the arrays of its interactions, the groups with their laws, and the data of the laws.

    It stays in :mod:`lmgcpy.dynamics`. A solver gets a :class:`Step <lmgcpy.Step>` made from it, which knows no law by
    name; :class:`Problem <lmgcpy.Problem>` is the same step with an assembled W.
    """

    system: System
    groups: list[Group]
    kernels: list[LawKernels]
    table: Groups
    offset: np.ndarray
    """First number of each group in ``System.prepared``."""
    data: StepData
    free_velocity: np.ndarray
    """Velocities of the bodies without impulses, (n, k)."""
    guess: np.ndarray
    """Impulses to start from [N s], (m, d)."""
    wire_blocks: bool
    """Whether sweeps visit a wire as one block. In a cell that yields they do not: a block contains the coupling of links
    with their neighbours, not with all others through the cell, and would overshoot by up to the number of links."""
    light: LightBodies
    """Bodies that are swept with more than their own mass: ``system`` knows the masses of the sweep."""
    inverse_mass: np.ndarray
    """Inverse of the bodies' own masses and inertias, not of the masses in the sweep; with drag the mobilities, (n, k)."""
    keeps_gap: np.ndarray
    """Whether an interaction is a contact whose law keeps the gap that it predicts, (m,) bool."""
    stuck: list[tuple[Group, np.ndarray]]
    """Rows of the links, by group, whose law yields but whose bodies do not yield along them."""
    after: np.ndarray
    """Memory for the relative velocities at the end, (m, d); the problems that are solved in one step share it."""
    step: Step | None = field(default=None, init=False, compare=False)
    """The step that the solver was given, kept if the next step may use the same arrays."""

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.system.normal.shape[1])

    def kernels_with(self, **changes: Any) -> list[LawKernels]:
        """The kernels of the groups with changes of their keys; ``stiffened`` concerns chains alone."""
        result = []
        for group, kernels in zip(self.groups, self.kernels, strict=True):
            here = {name: value for name, value in changes.items() if name != "stiffened" or group.chain is not None}
            result.append(law_kernels(type(group.law), replace(kernels.key, **here)))
        return result

    def end(self) -> None:
        """Enter the relative velocities at the end of the step into the data of the laws. Links between bodies that are
        held or driven get the impulses of their laws at these velocities: no solver computes them, as they change no
        velocity."""
        self.data = self.data._replace(after=self.relative_velocities(self.system.velocity, self.after))
        for group, rows in self.stuck:
            width, first = len(group.law.PREPARED), self.offset[self.groups.index(group)]
            for i in rows.tolist():
                at = first + (i - group.start) * width
                prepared = tuple(self.system.prepared[at : at + width].tolist())
                (impulse,) = group.law.react(((NO_MOBILITY,),), (float(self.data.after[i, 0]),), prepared)
                self.system.impulse[i, 0] = impulse

    def relative_velocities(self, velocities: np.ndarray, result: np.ndarray | None = None) -> np.ndarray:
        """Relative velocities of all interactions in their local frames, (m, d), for velocities of the bodies (n, k)."""
        result = np.empty_like(self.data.before) if result is None else result
        result[:, self.dimension :] = 0.0
        for form, start, stop in self.spans:
            form.relative_velocities(start, stop, self.system, velocities, result)
        return result

    def momentum(self) -> np.ndarray:
        """``H r``: momentum that the impulses give to the bodies [N s, N m s], (n, k)."""
        given = self.system._replace(velocity=np.zeros_like(self.system.velocity))
        for form, start, stop in self.spans:
            form.momentum(start, stop, -1, given)
        return given.velocity

    @cached_property
    def spans(self) -> list[tuple[Form, int, int]]:
        """Rows (start, stop) of the interactions of one form."""
        spans: list[tuple[Form, int, int]] = []
        for group, kernels in zip(self.groups, self.kernels, strict=True):
            form, start = kernels.key.form, group.start
            if spans and spans[-1][0] is form:
                start = spans.pop()[1]
            spans.append((form, start, group.stop))
        return spans

    def components(self) -> np.ndarray:
        """Whether the law of an interaction has a component of the impulse, (m, d) bool."""
        d = self.dimension
        there = np.zeros(self.system.impulse.shape, dtype=bool)
        for group in self.groups:
            there[group.start : group.stop, : group.law.rows(d)] = True
        stiff = self.system.geometric > 0.0  # of the links, which come first
        there[: len(stiff), 1:d] |= stiff[:, None]
        return there

    def commit(self) -> None:
        """Let each law commit its states at the end of the step; FloatingPointError if a state is not finite."""
        for group, kernels in zip(self.groups, self.kernels, strict=True):
            if kernels.commit is not None:
                arguments = group.start, group.stop, self.data, self.system.impulse, group.parameters.ravel()
                row = ask(group, kernels.commit, "commit", self.system, self.data, arguments)
                if row >= 0:
                    raise FloatingPointError(
                        f"In the step from t = {self.data.time:g} s commit of law '{group.law.NAME}' between bodies "
                        f"{self.system.candidate[row]} and {self.system.antagonist[row]} returned a state that is not "
                        "finite."
                    )

    def predicted_gaps(self) -> np.ndarray:
        """Gaps of the next detection as laws predict them from the velocities ``after`` [m], (m,); NaN for laws that do not
        keep them. If a law may take back later what turning closed, the rest that this step left is added."""
        result = self.data.time_step * self.data.after[:, 0]
        result += self.data.gap
        result[~self.keeps_gap] = np.nan
        for group in self.groups:
            if group.law.KEEPS_GAP and group.law.TAKES_BACK_LATER:
                part = slice(group.start, group.stop)
                gap, up = self.data.gap[part], np.maximum(self.data.time_step * self.data.after[part, 0], 0.0)
                left = np.fmax(
                    self.data.reference_gap[part] - gap - up, 0.0
                )  # 0 for new contacts, whose reference is NaN
                result[part] += np.where(gap <= 0.0, left, 0.0)
        return result

    def worst(self) -> Worst | None:
        """The interaction with the largest slip, as the solver measured it."""
        system = self.system
        _, _, row, error, _, _ = system.measured.tolist()
        if len(system.candidate) == 0 or error == 0.0:
            return None
        law = next(group.law.NAME for group in self.groups if group.start <= row < group.stop)
        return Worst(law, int(system.candidate[int(row)]), int(system.antagonist[int(row)]), error)


def ask(group: Group, kernel: Kernel, functions: str, system: System, data: StepData, arguments: tuple) -> Any:
    """Call a kernel of a law; TypeError if it cannot be compiled, RuntimeError if the law raises."""
    try:
        return kernel(*arguments)
    except CompilerError as error:
        raise not_compiled(type(group.law), error) from error
    except Exception as error:
        c, a = system.candidate[data.at[0]], system.antagonist[data.at[0]]
        raise RuntimeError(
            f"In the step from t = {data.time:g} s {functions} of law '{group.law.NAME}' between bodies {c} and {a} raised "
            f"{told(error)}."
        ) from error


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
        """Slots, time step, wire blocks, diagonal blocks and masses of the sweep for which ``_kept`` was laid out."""

    def assemble(
        self,
        detector: Detector,
        interactions: Interactions,
        *,
        time: float,
        time_step: float,
        positions: np.ndarray,
        before: np.ndarray,
        free_velocity: np.ndarray,
        mobility: np.ndarray,
        more: np.ndarray | None,
        wire_blocks: bool,
    ) -> StepProblem:
        """The arrays of a step from its interactions, with the numbers that each law prepares.

        ``positions`` of the detection, (n, 3); ``before`` and ``free_velocity``: velocities of the bodies at the start of
        the step and without impulses, (n, k); ``mobility``: inverse masses in the step, (n, k), see
        :mod:`lmgcpy.dynamics.drag`; ``more``: see :func:`~lmgcpy.dynamics.sweep_mass.sweep_mass`.
        """
        model, groups = self._model, detector.groups
        cell = model.cell_in_step(before, free_velocity)
        kept = self._kept
        swept = (b"" if more is None else more.tobytes()) + (b"" if model.drag is None else mobility.tobytes())
        kind = interactions.slot[:KEPT].tobytes(), time_step, wire_blocks, [group.diagonal for group in groups], swept
        if kept is None or groups is not self._groups or kind != self._kind or cell is not None:
            self._kept = kept = None  # frees its arrays before the new ones are made
            rate = time_step / self._size
            bodies = model, rate, mobility
            kept = lay_out(detector, interactions, *bodies, more=more, wire_blocks=wire_blocks, cell=cell)
            # the terms of W from rolling contacts and from cells that deform are made at each detection
            if len(interactions.slot) <= KEPT and cell is None and not len(kept.system.rolling):
                self._kept, self._groups, self._kind = kept, groups, kind
        detector.recall(interactions, kept.guess, kept.data.state)
        fill(kept, time, time_step, before, free_velocity)
        kept.system.farness[:] = np.abs(positions[:, : model.dimension]).max(axis=1, initial=0.0) / time_step
        if cell is not None:
            kept.system.farness[cell.lattice.rows] = 0.0
        return kept


def lay_out(
    detector: Detector,
    interactions: Interactions,
    model: Model,
    rate: np.ndarray,
    mobility: np.ndarray,
    *,
    more: np.ndarray | None,
    wire_blocks: bool,
    cell: CellMotion | None,
) -> StepProblem:
    """The arrays of a step, filled with all that depends only on the set of its interactions.

    ``rate``: time step over the radius of the smallest contactor of each body [s/m], (n,); ``mobility``: inverse masses in
    the step, (n, k); ``more``: mass in the sweep over mass, (n,); ``cell``: a periodic cell that deforms in this step.
    """
    dimension, (width, states) = interactions.normal.shape[1], detector.remembered
    groups = [group for group in detector.groups if group.stop > group.start]
    pairs = known_pairs(groups, interactions, model)
    rolls = width > dimension  # some contacts of the scene have rolling components
    inverse_mass, light = mobility, no_light_bodies(mobility.shape[1])
    if more is not None:
        mass = model.free_mass if model.drag is None else 1.0 / np.where(mobility > 0.0, mobility, np.inf)
        inverse_mass, light = mobility / more[:, None], light_bodies(more, rate, mass)
    if rolls:
        mark_isotropic(groups, interactions, inverse_mass)
    edges, branch = np.zeros(0, np.int64), np.zeros((0, 0))
    if cell is not None:
        edges, branch = cell.lattice.rows, cell.branches(groups, interactions)
        cell.add_to_blocks(branch, groups, interactions, inverse_mass)
    wire_blocks = wire_blocks and not (cell is not None and cell.yields(inverse_mass))
    kernels = [kernels_of(group, dimension, wire_blocks, deforms=cell is not None) for group in groups]
    count, bodies = len(interactions.gap), model.inverse_mass.shape
    offset = np.zeros(len(groups) + 1, dtype=np.int64)
    np.cumsum([len(group.law.PREPARED) * (group.stop - group.start) for group in groups], out=offset[1:])
    rolling, delassus = np.zeros(0), interactions.delassus
    if rolls:
        rolling = rolling_radius(groups, pairs, dimension, count)
        delassus = with_rolling(delassus, rolling, interactions, inverse_mass)
    system = System(
        candidate=interactions.candidate,
        antagonist=interactions.antagonist,
        normal=interactions.normal,
        tangent=interactions.tangent,
        arm=interactions.arm,
        lateral=interactions.lateral,
        rolling=rolling,
        edges=edges,
        branch=branch,
        delassus=delassus,
        coupling=interactions.coupling,
        shear=interactions.shear,
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
        after=np.empty((0, width)),
        pairs=pairs,
        state=with_spare_rows(count, states),
        time=0.0,
        time_step=0.0,
        at=np.zeros(1, dtype=np.int64),
    )
    return StepProblem(
        system=system,
        groups=groups,
        kernels=kernels,
        table=schedule(groups, kernels, offset[:-1]),
        offset=offset[:-1],
        data=data,
        free_velocity=np.empty(bodies),
        wire_blocks=wire_blocks,
        light=light,
        inverse_mass=mobility,
        guess=with_spare_rows(count, width),
        keeps_gap=keeps_gap(groups),
        stuck=stuck_links(groups, interactions.delassus),
        after=with_spare_rows(count, width),
    )


def keeps_gap(groups: list[Group]) -> np.ndarray:
    """Whether an interaction is a contact whose law keeps the gap that it predicts, (m,) bool."""
    keeps = np.array([group.chain is None and group.law.KEEPS_GAP for group in groups], dtype=bool)
    return np.repeat(keeps, [group.stop - group.start for group in groups])


def stuck_links(groups: list[Group], delassus: np.ndarray) -> list[tuple[Group, np.ndarray]]:
    """Rows of the links, by group, whose law yields but whose bodies do not yield along them."""
    found = []
    for group in groups:
        if group.chain is not None and "rigid" not in group.law.TRAITS:
            rows = group.start + np.flatnonzero(delassus[group.start : group.stop, 0] == 0.0)
            if len(rows):
                found.append((group, rows))
    return found


def light_bodies(more: np.ndarray, rate: np.ndarray, mass: np.ndarray) -> LightBodies:
    """The light bodies of a step, from M / m of all bodies (n,), the time step over their size [s/m], (n,), and their
    masses by component (n, k), zero for components that are held."""
    body = np.flatnonzero(more > 1.0)
    rows = {name: np.empty((len(body), mass.shape[1])) for name in ("free", "start", "centre", "best", "aside", "way")}
    share, stride = 1.0 / more[body], np.ones(len(body))
    return LightBodies(body=body, rate=rate[body], share=share, mass=mass[body], stride=stride, **rows)


def fill(problem: StepProblem, time: float, time_step: float, before: np.ndarray, free_velocity: np.ndarray) -> None:
    """Fill the arrays of a step, and let each law prepare its numbers; arguments as of :meth:`Assembler.assemble`."""
    system = problem.system
    problem.data = data = problem.data._replace(after=problem.after[:0], time=time, time_step=time_step)
    problem.free_velocity[:] = system.velocity[:] = free_velocity
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
    for group in problem.groups:
        if group.chain:
            data.reference_gap[group.start : group.stop] = group.chain.reference_gap_at(time)
    predicted = data.state[:, -1]
    known = np.where(np.isnan(predicted), data.gap, predicted)
    np.minimum(known, 0.0, out=data.reference_gap, where=problem.keeps_gap)
    prepare(problem.groups, problem.kernels, problem.offset, system, data)


def prepare(groups: list[Group], kernels: list[LawKernels], offset: np.ndarray, system: System, data: StepData) -> None:
    """Let each law prepare its numbers, into ``system.prepared``; FloatingPointError if a number is not finite."""
    for group, kernel, where in zip(groups, kernels, offset, strict=False):
        arguments = group.start, group.stop, where, data, group.parameters.ravel(), system.prepared
        row = ask(group, kernel.prepare, "initial or prepare" if group.law.initial else "prepare", system, data, arguments)
        if row == -1:
            continue
        at = row if row >= 0 else -2 - row
        bodies = f"bodies {system.candidate[at]} and {system.antagonist[at]}"
        told = f"In the step from t = {data.time:g} s {{}} of law '{group.law.NAME}' between {bodies} returned {{}}."
        if row < 0:
            raise FloatingPointError(told.format("initial", "a state that is not finite"))
        first = where + (row - group.start) * len(group.law.PREPARED)
        numbers = system.prepared[first : first + len(group.law.PREPARED)].tolist()
        prepared = dict(zip(group.law.PREPARED, numbers, strict=True))
        raise FloatingPointError(told.format("prepare", f"{prepared} at a gap of {data.gap[row]:g} m"))
