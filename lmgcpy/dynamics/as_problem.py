"""The last step of a simulation as a problem of its own, with an assembled Delassus operator."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lmgcpy.contact.frames import local_frames
from lmgcpy.dynamics.assembly import StepProblem
from lmgcpy.solve.problem import Conic, Problem, cone_of
from lmgcpy.solve.step import ConicForm
from lmgcpy.solve.system import System

if TYPE_CHECKING:
    import scipy.sparse as sparse


def law_without_conic(step: StepProblem) -> str | None:
    """Name of a law of the step that has no conic form; None where all have one."""
    return next((group.law.NAME for group in step.groups if group.law.conic is None), None)


def as_problem(step: StepProblem) -> Conic:
    """``W = H^T M^-1 H`` and ``q = H^T v_free + biases`` of a step.

    Interactions that cannot act in this step, such as restitution across an open gap, are left out. Raises TypeError for
    a law that has no conic form, RuntimeError where that of a law raises.
    """
    import scipy.sparse as sparse  # takes as long to import as the rest of lmgcpy

    system = step.system
    count = len(system.candidate)
    bias, friction, compliance = np.zeros(count), np.zeros(count), np.zeros(count)
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
            bias[part], friction[part], compliance[part] = group.law.conic(prepared.T)
        except Exception as error:
            raise RuntimeError(
                f"In the step from t = {step.data.time:g} s conic of law '{group.law.NAME}' raised {error!r}."
            ) from error
        names += [group.law.NAME] * (group.stop - group.start)
    acting = np.isfinite(bias)
    H = interaction_matrix(step)
    d = step.space.dimension
    H = H[np.repeat(acting, d)]
    W = (H @ sparse.diags_array(system.inverse_mass.ravel()) @ H.T).tocsr()
    q = H @ step.free_velocity.ravel()
    q[::d] += bias[acting]
    geometric, links = np.zeros(count), len(system.geometric)
    geometric[:links] = system.geometric
    if links:
        carried = np.zeros((count, d - 1))
        carried[:links] = system.carried
        q.reshape(-1, d)[:, 1:] -= (carried * (geometric > 0.0)[:, None])[acting]
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
        cone_by_law={group.law.NAME: cone_of(type(group.law)) for group in step.groups},
    )
    return Conic(problem, acting)


def conic_form(step: StepProblem) -> ConicForm:
    """What makes the problem of a step in conic form, for solvers that need it."""
    return ConicForm(lambda: as_problem(step), law_without_conic(step))


def interaction_matrix(step: StepProblem) -> sparse.csr_array:
    """``H^T``: relative velocities (u_n, u_t(, u_s) of each interaction) from those of the bodies, (d m, k n)."""
    import scipy.sparse as sparse

    s = step.system
    count = len(s.candidate)
    if step.space.dimension == 3:
        return interaction_matrix_in_space(s)
    n_x, n_y = s.normal.T
    lateral = s.lateral if len(s.lateral) else np.zeros((count, 2))
    c, a = (3 * ids.astype(np.int64)[:, None] + np.arange(3) for ids in (s.candidate, s.antagonist))
    along = np.column_stack([n_x, n_y, -lateral[:, 0], -n_x, -n_y, lateral[:, 1]])
    across = np.column_stack([-n_y, n_x, -s.arm[:, 0], n_y, -n_x, -s.arm[:, 1]])
    values = np.stack([along, across], axis=1).reshape(2 * count, 6)
    columns = np.repeat(np.hstack([c, a]), 2, axis=0)
    rows = np.repeat(np.arange(2 * count), 6)
    shape = (2 * count, s.inverse_mass.size)
    return sparse.csr_array((values.ravel(), (rows, columns.ravel())), shape=shape)


def interaction_matrix_in_space(s: System) -> sparse.csr_array:
    """``H^T`` in 3D, (3 m, 6 n)."""
    import scipy.sparse as sparse

    count = len(s.candidate)
    n, t, b = np.moveaxis(local_frames(s.normal), 1, 0)
    nothing = np.zeros((count, 3))
    rows = []
    for along, turning in ((n, nothing), (t, -b), (b, t)):
        rows.append(np.hstack([along, s.arm[:, :1] * turning, -along, s.arm[:, 1:] * turning]))
    values = np.stack(rows, axis=1).reshape(3 * count, 12)
    c, a = (6 * ids.astype(np.int64)[:, None] + np.arange(6) for ids in (s.candidate, s.antagonist))
    columns = np.repeat(np.hstack([c, a]), 3, axis=0)
    where = np.repeat(np.arange(3 * count), 12)
    return sparse.csr_array((values.ravel(), (where, columns.ravel())), shape=(3 * count, s.inverse_mass.size))
