"""A step as a problem of its own, with an assembled Delassus operator ``W = H^T M^-1 H``."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lmgcpy.contact.frames import local_frames
from lmgcpy.dynamics.assembly import StepProblem
from lmgcpy.errors import told
from lmgcpy.solve.kernels.system import System
from lmgcpy.solve.problems.problem import Conic, Problem, Split, cone_of
from lmgcpy.solve.sweeps.step import ConicForm

if TYPE_CHECKING:
    import scipy.sparse as sparse


def law_without_conic(step: StepProblem) -> str | None:
    """Name of the first law of the step without a conic form; None if all laws have one."""
    return next((group.law.NAME for group in step.groups if group.law.conic is None), None)


def as_problem(step: StepProblem) -> Conic:
    """``W = H^T M^-1 H`` and ``q = H^T v_free + biases`` of a step.

    Interactions that cannot act in this step, such as restitution across an open gap, are left out. Raises TypeError if a
    law has no conic form, and RuntimeError if the function ``conic`` of a law raises.
    """
    import scipy.sparse as sparse  # takes as long to import as the rest of lmgcpy

    system = step.system
    count = len(system.candidate)
    bias, friction, compliance, rolling, torsion = np.zeros((5, count))
    names: list[str] = []
    without = law_without_conic(step)
    if without is not None:
        raise TypeError(f"Law '{without}' has no conic form, so that this step cannot be written as a problem of its own.")
    for group, where in zip(step.groups, step.offset, strict=True):
        assert group.law.conic is not None
        part = slice(group.start, group.stop)
        size = len(group.law.PREPARED) * (group.stop - group.start)
        prepared = system.prepared[where : where + size].reshape(group.stop - group.start, -1)
        try:
            bias[part], friction[part], compliance[part], *turning = group.law.conic(prepared.T)
            if group.law.rows(step.dimension) > step.dimension:
                rolling[part], torsion[part] = turning if step.dimension == 3 else (turning[0], 0.0)
        except Exception as error:
            raise RuntimeError(
                f"In the step from t = {step.data.time:g} s conic of law '{group.law.NAME}' raised {told(error)}."
            ) from error
        names += [group.law.NAME] * (group.stop - group.start)
    acting = np.isfinite(bias)
    H = interaction_matrix(step)
    d, width = step.dimension, system.impulse.shape[1]
    H = H[np.repeat(acting, width)]
    inverse_mass, split = step.inverse_mass.copy(), None
    if system.deforms:
        inverse_mass[system.edges] = 0.0
    W = (H @ sparse.diags_array(inverse_mass.ravel()) @ H.T).tocsr()
    columns = cell_columns(H, system)
    if columns.shape[1]:
        split = Split(W, columns)
        W = sparse.csr_array(W + columns @ columns.T)
    q = H @ step.free_velocity.ravel()
    q[::width] += bias[acting]
    geometric, links = np.zeros(count), len(system.geometric)
    geometric[:links] = system.geometric
    if links:
        carried = np.zeros((count, d - 1))
        carried[:links] = system.carried
        q.reshape(-1, width)[:, 1:d] -= (carried * (geometric > 0.0)[:, None])[acting]
    problem = Problem(
        W=sparse.csr_array(W),
        q=q,
        mu=friction[acting],
        dimension=d,
        laws=tuple(name for name, here in zip(names, acting, strict=True) if here),
        compliance=compliance[acting],
        guess=step.guess[acting],
        geometric=geometric[acting],
        scale=system.scale[acting],
        split=split,
        cone_by_law={group.law.NAME: cone_of(type(group.law)) for group in step.groups},
        **({"rolling": rolling[acting], "torsion": torsion[acting]} if width > d else {}),
    )
    return Conic(problem, acting)


def cell_columns(H: sparse.csr_array, system: System) -> np.ndarray:
    """``H^T M^(-1/2)`` of the components of a periodic cell that yield, (m d, q). They add this times its transpose to
    W."""
    if not system.deforms:
        return np.zeros((H.shape[0], 0))
    k = system.inverse_mass.shape[1]
    component = (k * system.edges[:, None] + np.arange(k)).ravel()
    mobile = component[system.inverse_mass.ravel()[component] > 0.0]
    return np.asarray(H[:, mobile].todense()) * np.sqrt(system.inverse_mass.ravel()[mobile])


def conic_form(step: StepProblem) -> ConicForm:
    """The conic form of a step, made when a solver asks for it."""
    return ConicForm(lambda: as_problem(step), law_without_conic(step))


def interaction_matrix(step: StepProblem) -> sparse.csr_array:
    """``H^T``, (D m, k n): from velocities of the bodies to the relative velocities of each interaction, (u_n, u_t(, u_s))
    and rolling ones.

    A row of a form has entries for both bodies. In a periodic cell that deforms, a row of the local frame, e, also has the
    entries ``e l_b`` in the columns of the velocity gradient.
    """
    import scipy.sparse as sparse

    s = step.system
    (count, d), k, width = s.normal.shape, s.inverse_mass.shape[1], s.impulse.shape[1]
    values = np.zeros((count, width, 2 * k))
    for form, start, stop in step.spans:
        assert form.rows is not None
        values[start:stop, : form.width] = form.rows(s, slice(start, stop))
    columns = np.hstack([k * ids.astype(np.int64)[:, None] + np.arange(k) for ids in (s.candidate, s.antagonist)])
    if s.deforms:
        cell = np.zeros((count, width, d * len(s.edges)))
        cell[:, :d] = (local_frames(s.normal)[:, :, None, :] * s.branch[:, None, :, None]).reshape(count, d, -1)
        values = np.concatenate([values, cell], axis=2)
        edges = (k * s.edges[:, None] + np.arange(d)).ravel()
        columns = np.hstack([columns, np.tile(edges, (count, 1))])
    rows = np.repeat(np.arange(width * count), columns.shape[1])
    columns = np.repeat(columns, width, axis=0)
    return sparse.csr_array((values.ravel(), (rows, columns.ravel())), shape=(width * count, s.inverse_mass.size))
