"""Stiffness of levers: the moment on a body that answers its turning under a link at a point of it, within the step.

A link pulls at the point ``p = x + l`` with the impulse r, and ``l x r`` is its moment at the detection. The body turns by
``a = h omega`` in the step, and l with it, so that the moment changes by

    (a x l) x r = -G a,    G = (l . r) 1 - (l r^T + r l^T)/2,    in 2D  l . r.

(The half that is not symmetric is left out: it does work on no closed path of a single pull.) A body that is drawn out has
G >= 0: its turning is held, as by a spring. A step takes r at the detection, so that the spring is explicit, and its steps
are a leapfrog, unstable beyond ``h G = 4 I``: a light body that bears a heavy one would be turned over and over. The remedy
is that of :mod:`lmgcpy.dynamics.geometric_stiffness`: an implicit moment in the step,

    j = -kappa (omega+ - omega_c),     kappa = max(0, h G - 2 I)    for each axis of the body,

omega_c the velocity with which all bodies that links join turn as one, the mean of their velocities before the step,
weighted by kappa. It resists what bends a chain of bodies, not what swings or spins all of it. With ``I + kappa`` in place
of the inertia and ``(I omega_free + kappa omega_c)/(I + kappa)`` in place of the free velocity, the step is solved as any
other.

In space G is taken by its diagonal along the axes of the body, which is enough for a pull along its lever: then
``2 diag(G) - G >= 0`` along any axes. Light bodies turn into their pulls. The elements off the diagonal would hold the
twist of a fibre about its axis, which no pull at a point of the axis resists.

**Stability.** If the bodies hang together at points, the quantity ``v.(M + C/2 - h^2 K/4) v / 2 + x.K x / 2`` does not grow
(C: all kappa; K = G/h), as for links, and ``C/2 >= h^2 K/4 - M`` holds body by body. Bodies that are pressed together get
nothing: they buckle.

**kappa and r.** kappa comes from the impulses of the last step, and is compared with the kappa of the impulses found. If
they differ, the step is solved again from these impulses.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.contact.frames import local_frames
from lmgcpy.contact.interactions import levers
from lmgcpy.dynamics.model import Model
from lmgcpy.dynamics.step_problem import StepProblem


@dataclass(frozen=True)
class LeverStiffness:
    """The links at points of bodies of a model, L links in all; n bodies, k components of a velocity."""

    count: int
    """L, of all chains and joints; 0 if none acts at a point that turns."""
    dimension: int
    share: np.ndarray
    """Inverse moments of inertia about the axes of the bodies [1/(kg m^2)], zero if the spin is driven, (n, k - d)."""
    together: np.ndarray
    """Number of the set of bodies that links join, (n,)."""
    law: np.ndarray
    """Name of the law of each link, (L,)."""

    @classmethod
    def of(cls, model: Model) -> LeverStiffness:
        """Gather the links of a model."""
        d = model.dimension
        share = model.inverse_mass[:, d:]
        together = np.zeros(len(share), dtype=np.int64)
        if all(links.form == "central" for links in model.links):
            return cls(0, d, share, together, np.zeros(0, dtype="<U1"))
        from scipy.sparse import coo_array  # takes as long to import as the rest of lmgcpy
        from scipy.sparse.csgraph import connected_components

        pairs = np.concatenate([links.bodies[np.stack(links.ends)] for links in model.links], axis=1)
        moves = model.inverse_mass.max(axis=1, initial=0.0) > 0.0
        a, c = pairs[:, moves[pairs].all(axis=0)]
        graph = coo_array((np.ones(len(a)), (a, c)), shape=(len(share),) * 2)
        together = connected_components(graph, directed=False)[1]
        law = np.concatenate([[links.law.NAME] * links.link_count for links in model.links])
        return cls(len(law), d, share, together, law)

    def stiffness(self, problem: StepProblem, impulse: np.ndarray) -> np.ndarray:
        """kappa of each body by axis [kg m^2], (n, k - d), for impulses of the interactions (m, d)."""
        excess = problem.data.time_step * self._held(problem, impulse) * self.share - 2.0
        return np.where(excess > 0.0, excess, 0.0) / np.where(self.share > 0.0, self.share, 1.0)

    def _held(self, problem: StepProblem, impulse: np.ndarray, of: np.ndarray | None = None) -> np.ndarray:
        """Diagonal of G of each body by axis [N s m], (n, k - d); of the links ``of`` (L,) bool alone if given."""
        s, d, part = problem.system, self.dimension, slice(self.count)
        r = np.einsum("le,lei->li", impulse[part, :d], local_frames(s.normal[part]))
        if of is not None:
            r = np.where(of[:, None], r, 0.0)
        lever, held = levers(s, part), np.zeros_like(self.share)
        for ids, l, f in ((s.candidate[part], lever[:, 0], r), (s.antagonist[part], lever[:, 1], -r)):
            if d == 3:  # along the axes of the body
                axes = s.axes[ids].reshape(-1, 3, 3)
                l, f = (np.einsum("lij,li->lj", axes, vector) for vector in (l, f))
            along = (l * f).sum(axis=1, keepdims=True)  # l . r, about an axis k less l_k r_k
            np.add.at(held, ids, along if d == 2 else along - l * f)
        return held

    def carried(self, stiffness: np.ndarray, axes: np.ndarray, spins: np.ndarray) -> np.ndarray:
        """omega_c of each body along its axes [rad/s], (n, k - d); ``spins`` before the step, (n, k - d)."""
        weight = stiffness.max(axis=1)
        turned = self.dimension == 3 and len(axes) > 0
        if turned:
            spins = np.einsum("bij,bj->bi", axes.reshape(-1, 3, 3), spins)
        total = np.bincount(self.together, weight, len(weight))
        columns = [np.bincount(self.together, weight * column, len(weight)) for column in spins.T]
        mean = (np.stack(columns, axis=1) / np.where(total > 0.0, total, 1.0)[:, None])[self.together]
        return np.einsum("bij,bi->bj", axes.reshape(-1, 3, 3), mean) if turned else mean

    def stiffened(
        self, stiffness: np.ndarray, carried: np.ndarray, mobility: np.ndarray, free: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Mobilities and velocities without impulses (n, k) in a step with these stiffnesses (n, k - d)."""
        d = self.dimension
        mobility, free = mobility.copy(), free.copy()
        less = 1.0 / (1.0 + stiffness * mobility[:, d:])
        free[:, d:] = np.where(
            mobility[:, d:] > 0.0, less * (free[:, d:] + stiffness * mobility[:, d:] * carried), free[:, d:]
        )
        mobility[:, d:] *= less
        return mobility, free

    def work(
        self, problem: StepProblem, stiffness: np.ndarray, carried: np.ndarray, before: np.ndarray
    ) -> np.ndarray:
        """Work of the moment of each body by axis in a step [J], (n, k - d), if it has the velocities ``before`` (n, k) at
        its start."""
        d, after = self.dimension, problem.system.velocity
        work: np.ndarray = -0.5 * stiffness * (after[:, d:] - carried) * (before[:, d:] + after[:, d:])
        return work

    def works(
        self, problem: StepProblem, stiffness: np.ndarray, carried: np.ndarray, before: np.ndarray
    ) -> list[tuple[str, float]]:
        """Works of the moments of a step by name of law [J], shared by what the links of each law hold of each body."""
        work = self.work(problem, stiffness, carried, before)
        names = np.unique(self.law).tolist()
        held = [np.maximum(self._held(problem, problem.system.impulse, self.law == name), 0.0) for name in names]
        total = sum(held)
        shares = [np.divide(part, total, out=np.full_like(part, 1.0 / len(names)), where=total > 0.0) for part in held]
        return [(name, float((work * share).sum())) for name, share in zip(names, shares, strict=True)]
