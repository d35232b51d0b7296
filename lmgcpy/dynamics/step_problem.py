"""The problem of one time step as dynamics makes it, and as solvers get it; and its Delassus operator, if one asks."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from lmgcpy.compiled.kernel import CompilerError, Kernel, kernel
from lmgcpy.compiled.reference import by_reference
from lmgcpy.contact.detector import Group
from lmgcpy.contact.frames import local_frames
from lmgcpy.dynamics.schedule import schedule
from lmgcpy.errors import told
from lmgcpy.laws import Law
from lmgcpy.solve.kernels.forms.form import Form
from lmgcpy.solve.kernels.law_kernels import LawKernels, StepData, law_kernels, not_compiled
from lmgcpy.solve.kernels.system import System
from lmgcpy.solve.problems.problem import Problem, Split, cone_of
from lmgcpy.solve.problems.report import Worst
from lmgcpy.solve.sweeps.step import Step

if TYPE_CHECKING:
    import scipy.sparse as sparse


NO_MOBILITY = float(np.finfo(float).tiny)
"""Replaces ``W_nn = 0``, by which a law may divide. It is negligible beside any compliance."""


@by_reference
class Frames(NamedTuple):
    """The arrays of a :class:`System <lmgcpy.solve.kernels.system.System>` that relative velocities need: to hand them to a
    kernel takes half as long as to hand it all."""

    candidate: np.ndarray
    antagonist: np.ndarray
    normal: np.ndarray
    tangent: np.ndarray
    arm: np.ndarray
    lateral: np.ndarray
    lever: np.ndarray
    moment: np.ndarray
    axes: np.ndarray
    rolling: np.ndarray
    branch: np.ndarray
    cell: np.ndarray
    corner: np.ndarray
    weight: np.ndarray


@dataclass(kw_only=True, eq=False, repr=False)
class StepProblem(Step):
    """The step that a solver gets, with what only dynamics reads of it: the laws of its groups, and their data."""

    system: System
    by_law: list[Group]
    """The groups of one law each, or one chain; ``groups`` has the same for kernels, cut into pieces."""
    kernels: list[LawKernels]
    """Of each group."""
    offset: np.ndarray
    """First number of each group in ``System.prepared``."""
    data: StepData
    inverse_mass: np.ndarray
    """Inverse of the bodies' own masses and inertias, not of the masses in the sweep, which ``system`` has; with drag the
    mobilities, (n, k)."""
    keeps_gap: np.ndarray
    """Whether an interaction is a contact whose law keeps the gap that it predicts, (m,) bool."""
    takes_back_later: np.ndarray
    """Whether its law has the rest of what turning closed added to that gap, (m,) bool."""
    yielding: np.ndarray
    """Rows of links whose law yields."""
    carried: np.ndarray | None
    """Velocities across links if heavy bodies carry light ones [m/s], (L, d - 1), NaN for links of wires that turn as a
    whole; None: all do."""

    def group_of(self, row: int) -> Group:
        """The group of an interaction."""
        return next(group for group in self.by_law if row < group.stop)

    def on(self, system: System, **changes: Any) -> StepProblem:
        """The same step on another system, with changes of the keys of its kernels; ``stiffened`` concerns chains alone."""
        kernels = []
        for group, own in zip(self.by_law, self.kernels, strict=True):
            chain = group.chain is not None and not group.jointed
            here = {name: value for name, value in changes.items() if name != "stiffened" or chain}
            kernels.append(law_kernels(type(group.law), replace(own.key, **here)))
        groups = schedule(self.by_law, kernels, self.offset)
        return replace(self, system=system, kernels=kernels, groups=groups)

    def prepare(self) -> None:
        """Let each law prepare its numbers, into ``system.prepared``; FloatingPointError if a number is not finite."""
        system, data = self.system, self.data
        for group, kernels, where in zip(self.by_law, self.kernels, self.offset, strict=True):
            arguments = group.start, group.stop, where, data, group.parameters.ravel(), system.prepared
            functions = "initial or prepare" if group.law.initial else "prepare"
            row = ask(group, kernels.prepare, functions, system, data, arguments)
            if row == -1:
                continue
            at = row if row >= 0 else -2 - row
            bodies = f"bodies {system.candidate[at]} and {system.antagonist[at]}"
            fault = f"In the step from t = {data.time:g} s {{}} of law '{group.law.NAME}' between {bodies} returned {{}}."
            if row < 0:
                raise FloatingPointError(fault.format("initial", "a state that is not finite"))
            first = where + (row - group.start) * len(group.law.PREPARED)
            numbers = system.prepared[first : first + len(group.law.PREPARED)].tolist()
            prepared = dict(zip(group.law.PREPARED, numbers, strict=True))
            raise FloatingPointError(fault.format("prepare", f"{prepared} at a gap of {data.gap[row]:g} m"))

    def begin(self) -> None:
        """Write into the guess the impulses of links whose two bodies are held or driven along the link. No solver computes
        them, as they change no velocity along it; across it the geometric stiffness of their tension acts."""
        stuck = self._stuck()
        if len(stuck):
            self._bear(stuck, self.relative_velocities(self.free_velocity), self.guess)

    def end(self) -> None:
        """Enter the relative velocities at the end of the step into the data of the laws, and the impulses of :meth:`begin`
        once more, as a solver need not keep the guess."""
        self.relative_velocities(self.system.velocity, self.data.after)
        stuck = self._stuck()
        if len(stuck):
            self._bear(stuck, self.data.after, self.system.impulse)

    def _stuck(self) -> np.ndarray:
        """Rows of links whose law yields and whose bodies are held or driven along them."""
        return self.yielding[self.system.delassus[self.yielding, 0] == 0.0] if len(self.yielding) else self.yielding

    def _bear(self, stuck: np.ndarray, relative: np.ndarray, impulse: np.ndarray) -> None:
        """Enter the impulses of the laws of these rows at the ``relative`` velocities (m, d) into ``impulse`` (m, d)."""
        groups = np.searchsorted([group.stop for group in self.by_law], stuck, side="right")
        for i, k in zip(stuck.tolist(), groups.tolist(), strict=True):
            group = self.by_law[k]
            at = self.offset[k] + (i - group.start) * len(group.law.PREPARED)
            prepared = tuple(self.system.prepared[at : at + len(group.law.PREPARED)].tolist())
            with self._asking(group, "react"):
                (impulse[i, 0],) = group.law.react(((NO_MOBILITY,),), (float(relative[i, 0]),), prepared)

    def relative_velocities(self, velocities: np.ndarray, result: np.ndarray | None = None) -> np.ndarray:
        """Relative velocities of all interactions in their local frames, (m, d), for velocities of the bodies (n, k)."""
        result = np.empty_like(self.data.before) if result is None else result
        if result.shape[1] > self.dimension:
            result[:, self.dimension :] = 0.0
        for form, start, stop in self.spans:
            form.relative_velocities(start, stop, self.frames, velocities, result)
        return result

    def momentum(self) -> np.ndarray:
        """``H r``: momentum that the impulses give to the bodies [N s, N m s], (n, k)."""
        given = self.system._replace(velocity=np.zeros_like(self.system.velocity))
        for form, start, stop in self.spans:
            form.add_momentum(start, stop, given, self.kernels[0].key.system_type)
        return given.velocity

    @cached_property
    def frames(self) -> Frames:
        """The arrays of the system that relative velocities need."""
        return Frames(*(getattr(self.system, name) for name in Frames._fields))

    @cached_property
    def spans(self) -> list[tuple[Form, int, int]]:
        """Rows (start, stop) of the interactions of one form."""
        spans: list[tuple[Form, int, int]] = []
        for group, kernels in zip(self.by_law, self.kernels, strict=True):
            form, start = kernels.key.form, group.start
            if spans and spans[-1][0] is form:
                start = spans.pop()[1]
            spans.append((form, start, group.stop))
        return spans

    @cached_property
    def spans_of_laws(self) -> list[tuple[type[Law], int, int]]:
        """Rows (start, stop) of the interactions of one law, of groups one after another."""
        spans: list[tuple[type[Law], int, int]] = []
        for group in self.by_law:
            law, start = type(group.law), group.start
            if spans and spans[-1][0] is law:
                start = spans.pop()[1]
            spans.append((law, start, group.stop))
        return spans

    def components(self) -> np.ndarray:
        """Whether the law of an interaction has a component of the impulse, (m, d) bool."""
        d = self.dimension
        there = np.zeros(self.system.impulse.shape, dtype=bool)
        for group in self.by_law:
            there[group.start : group.stop, : group.law.rows(d)] = True
        stiff = self.system.geometric > 0.0  # of the links, which come first
        there[: len(stiff), 1:d] |= stiff[:, None]
        return there

    def commit(self) -> None:
        """Let each law commit its states at the end of the step; FloatingPointError if a state is not finite."""
        for group, kernels in zip(self.by_law, self.kernels, strict=True):
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
        data, result = self.data, np.empty(len(self.data.gap))
        predict(data.gap, data.reference_gap, data.after, data.time_step, self.keeps_gap, self.takes_back_later, result)
        return result

    def worst(self) -> Worst | None:
        """The interaction with the largest slip, as the solver measured it."""
        system = self.system
        _, _, row, error, _, _ = system.measured.tolist()
        if len(system.candidate) == 0 or error == 0.0:
            return None
        return Worst(self.group_of(row).law.NAME, int(system.candidate[int(row)]), int(system.antagonist[int(row)]), error)

    @property
    def law_without_conic(self) -> str | None:
        """Name of the first law without a conic form; None if all laws have one."""
        return next((group.law.NAME for group in self.by_law if group.law.conic is None), None)

    def conic(self) -> tuple[Problem, np.ndarray]:
        """``W = H^T M^-1 H`` and ``q = H^T v_free + biases``, and which interactions act.

        Interactions that cannot act in this step are left out: restitution across an open gap, a link between two held
        bodies, whose impulse moves nothing. Raises TypeError if a law has no conic form, RuntimeError if the function
        ``conic`` of a law raises, and FloatingPointError if numbers grew without bound.
        """
        import scipy.sparse as sparse  # takes as long to import as the rest of lmgcpy

        system = self.system
        count = len(system.candidate)
        bias, friction, compliance, rolling, torsion = np.zeros((5, count))
        names: list[str] = []
        if self.law_without_conic is not None:
            law = f"Law '{self.law_without_conic}'"
            raise TypeError(f"{law} has no conic form, so that this step cannot be written as a problem of its own.")
        for group, where in zip(self.by_law, self.offset, strict=True):
            assert group.law.conic is not None
            part = slice(group.start, group.stop)
            with self._asking(group, "conic"):
                prepared = self._columns(group, where)
                bias[part], friction[part], compliance[part], *turning = group.law.conic(prepared.T)
                if group.law.rows(self.dimension) > self.dimension:
                    rolling[part], torsion[part] = turning if self.dimension == 3 else (turning[0], 0.0)
            names += [group.law.NAME] * (group.stop - group.start)
        geometric, links = np.zeros(count), len(system.geometric)
        geometric[:links] = system.geometric
        moves = (system.delassus[:, 0] > 0.0) | ((geometric > 0.0) & (system.delassus[:, 1:] > 0.0).any(axis=1))
        acting = np.isfinite(bias) & moves
        H = self.interaction_matrix()
        d, width = self.dimension, system.impulse.shape[1]
        H = H[np.repeat(acting, width)]
        inverse_mass, split = self.inverse_mass.copy(), None
        if system.deforms:
            inverse_mass[system.edges] = 0.0
        W = (H @ sparse.diags_array(inverse_mass.ravel()) @ H.T).tocsr()
        columns = cell_columns(H, system)
        if columns.shape[1]:
            split = Split(W, columns)
            W = sparse.csr_array(W + columns @ columns.T)
        q = H @ self.free_velocity.ravel()
        q[::width] += bias[acting]
        if links:
            carried = np.zeros((count, d - 1))
            carried[:links] = system.carried
            q.reshape(-1, width)[:, 1:d] -= (carried * (geometric > 0.0)[:, None])[acting]
        try:
            problem = Problem(
                W=sparse.csr_array(W),
                q=q,
                mu=friction[acting],
                dimension=d,
                laws=tuple(name for name, here in zip(names, acting, strict=True) if here),
                compliance=compliance[acting],
                guess=self.guess[acting],
                geometric=geometric[acting],
                scale=system.scale[acting],
                split=split,
                cone_by_law={group.law.NAME: cone_of(type(group.law)) for group in self.by_law},
                **({"rolling": rolling[acting], "torsion": torsion[acting]} if width > d else {}),
            )
        except ValueError as error:
            when = f"In the step from t = {self.data.time:g} s"
            raise FloatingPointError(f"{when} numbers grew without bound: {error}") from error
        return problem, acting

    def compliance(self, count: int) -> np.ndarray:
        """Compliance of the first ``count`` interactions, links [1/kg], (count,); 0 if a law has no conic form."""
        result = np.zeros(count)
        for group, where in zip(self.by_law, self.offset, strict=True):
            if group.stop <= count and group.law.conic is not None:
                with self._asking(group, "conic"):
                    result[group.start : group.stop] = group.law.conic(self._columns(group, where).T)[2]
        return result

    @property
    def resists(self) -> bool:
        return any(group.law.resisted for group in self.by_law)

    def resist(self, acting: np.ndarray, a: np.ndarray, w: np.ndarray, friction: np.ndarray, slip: np.ndarray) -> None:
        place = np.cumsum(acting) - 1
        for group, where in zip(self.by_law, self.offset, strict=True):
            if group.law.resisted is not None:
                here = acting[group.start : group.stop]
                rows = place[group.start : group.stop][here]
                columns = self._columns(group, where)[here].T
                with self._asking(group, "resisted"):
                    friction[rows], across = group.law.resisted(columns, a[rows, : self.dimension].T, w[rows])
                    slip[rows] = across.T

    @contextmanager
    def _asking(self, group: Group, function: str) -> Iterator[None]:
        """RuntimeError that names the law if its ``function`` raises."""
        try:
            yield
        except Exception as error:
            raise RuntimeError(
                f"In the step from t = {self.data.time:g} s {function} of law '{group.law.NAME}' raised {told(error)}."
            ) from error

    def _columns(self, group: Group, where: int) -> np.ndarray:
        """Prepared numbers of a group, a row an interaction."""
        size = len(group.law.PREPARED) * (group.stop - group.start)
        return self.system.prepared[where : where + size].reshape(group.stop - group.start, -1)

    def interaction_matrix(self, first: int | None = None) -> sparse.csr_array:
        """``H^T``, (D m, k n): from velocities of the bodies to the relative velocities of each interaction, (u_n,
        u_t(, u_s)) and rolling ones; with zeros for all but the ``first`` ones if given.

        A row of a form has entries for both bodies. In a periodic cell that deforms, a row of the local frame, e, also has
        the entries ``e l_b`` in the columns of the velocity gradient.
        """
        import scipy.sparse as sparse

        s = self.system
        (count, d), k, width = s.normal.shape, s.inverse_mass.shape[1], s.impulse.shape[1]
        parts = [(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros(0))]
        for form, start, end in self.spans:
            stop = end if first is None else min(end, first)
            if stop <= start:
                break
            part = slice(start, stop)
            assert form.rows is not None
            both = np.column_stack([s.candidate[part], s.antagonist[part]])
            bodies = both if form.bodies is None else form.bodies(s, part)
            values = form.rows(s, part)
            columns = (k * bodies.astype(np.int64)[:, :, None] + np.arange(k)).reshape(len(bodies), -1)
            if s.deforms:
                cell = np.zeros((len(bodies), form.width, d * len(s.edges)))
                branch = s.branch[part, None, :, None]
                cell[:, :d] = (local_frames(s.normal[part])[:, :, None, :] * branch).reshape(len(bodies), d, -1)
                edges = (k * s.edges[:, None] + np.arange(d)).ravel()
                values = np.concatenate([values, cell], axis=2)
                columns = np.hstack([columns, np.tile(edges, (len(bodies), 1))])
            rows = width * np.arange(start, stop)[:, None, None] + np.arange(form.width)[:, None]
            shape = values.shape
            parts.append(
                (np.broadcast_to(rows, shape).ravel(), np.broadcast_to(columns[:, None], shape).ravel(), values.ravel())
            )
        of_row, of_column, value = (np.concatenate(column) for column in zip(*parts, strict=True))
        return sparse.csr_array((value, (of_row, of_column)), shape=(width * count, s.inverse_mass.size))


@kernel
def predict(gap, reference_gap, after, time_step, keeps_gap, takes_back_later, result):
    """Write the gaps of the next detection as laws predict them, see :meth:`StepProblem.predicted_gaps`."""
    for i in range(gap.shape[0]):
        if not keeps_gap[i]:
            result[i] = np.nan
            continue
        way = time_step * after[i, 0]
        result[i] = gap[i] + way
        if takes_back_later[i] and gap[i] <= 0.0:
            left = reference_gap[i] - gap[i] - max(way, 0.0)
            if left > 0.0:  # not so for new contacts: their reference is NaN
                result[i] += left


def cell_columns(H: sparse.csr_array, system: System) -> np.ndarray:
    """``H^T M^(-1/2)`` of the components of a periodic cell that yield, (m d, q). They add this times its transpose to
    W."""
    if not system.deforms:
        return np.zeros((H.shape[0], 0))
    k = system.inverse_mass.shape[1]
    component = (k * system.edges[:, None] + np.arange(k)).ravel()
    mobile = component[system.inverse_mass.ravel()[component] > 0.0]
    return np.asarray(H[:, mobile].todense()) * np.sqrt(system.inverse_mass.ravel()[mobile])


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
