"""Stiffness of levers: the moment on a body that answers its turning under a link at a point of it, within the step.

A link pulls at the point ``p = x + l`` with the impulse r, and ``l x r`` is its moment at the detection. The body turns by
``a = h omega`` in the step, and l with it, so that the moment changes by

    (a x l) x r = -G a,    G = (l . r) 1 - (l r^T + r l^T)/2,    in 2D  l . r.

(The half that is not symmetric is left out: it does work on no closed path of a single pull.) A body that is drawn out has
G >= 0: its turning is held, as by a spring. A step takes r at the detection, so that the spring is explicit, and its steps
are a leapfrog, unstable beyond ``h G = 4 I``: a light body that bears a heavy one would be turned over and over. The remedy
is that of :mod:`lmgcpy.dynamics.geometric_stiffness`: an implicit moment in the step,

    j = -kappa (omega+ - omega_c),     kappa = max(0, h G - 2 I)    for each axis of the body,

omega_c the spin that heavy bodies give to the light one that they carry. With ``I + kappa`` in place of the inertia and
``(I omega_free + kappa omega_c)/(I + kappa)`` in place of the free velocity, the step is solved as any other.

**Heavy bodies carry light ones.** The velocities w, with omega_c, minimise

    |w - v|^2_M / 2 + sum kappa omega(w)^2 / 2 + sum kappa_l |u_t(w)|^2 / 2 + sum |J w|^2 / (2 C),

if v are the velocities before the step, J the map to the velocities along the links and joints that bear impulses, C their
compliance, 0 if they are rigid, and kappa_l the stiffness across the links (:mod:`lmgcpy.dynamics.geometric_stiffness`),
which takes u_t(w) in place of the turning of a wire. Bodies with masses beyond kappa keep their velocities, and light ones
follow. So a swing, a spin or a blow of heavy bodies is not resisted, and light bodies that whip are.

Components that are held or driven have the velocities of the end in v. If a body of a taut line has just been fixed, its
velocity before the step asks a straight line between two held bodies to get longer, and w would be up to the inverse of the
line's slope times that: bodies that moved with 0.7 m/s were given 20 m/s.

Heavy bodies are slowed by the part ``x/(1 + x)``, x = kappa/M, in a mode. With ``D v = v - w`` so far, ``v - D D v`` has
the square of it: two balls that circle on rods between wires would lose 2.5e-4 of their angular momentum in 4 rad at 4 ms,
and lose 4e-7. So ``kappa c^2 = x (1 + 2 x)^2 / (1 + x)^4 |v|^2_M``, no more than 0.62 of it, and the moments make no more
than ``sum kappa c^2 / 4`` in a step (:mod:`lmgcpy.dynamics.turning_stretch`). With c from the light bodies themselves there
is no bound: a pair of balls that jerk light rods straight had 18 J in place of 2 J.

In space G is taken by its diagonal along the axes of the body, which is enough for a pull along its lever: then
``2 diag(G) - G >= 0`` along any axes. Light bodies turn into their pulls. The elements off the diagonal would hold the
twist of a fibre about its axis, which no pull at a point of the axis resists.

**Stability.** If the bodies hang together at points, the quantity ``v.(M + C/2 - h^2 K/4) v / 2 + x.K x / 2`` does not grow
(C: all kappa; K = G/h), as for links, and ``C/2 >= h^2 K/4 - M`` holds body by body. Bodies that are pressed together get
nothing: they buckle.

**kappa and r.** kappa comes from the impulses of the last step, and is compared with the kappa of the impulses found. If
they differ, the step is solved again from these impulses. It is at most ``MOST I``, as of links: in steps that are not
solved impulses may be anything.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lmgcpy.contact.frames import local_frames
from lmgcpy.contact.interactions import levers
from lmgcpy.dynamics.geometric_stiffness import MOST, connected
from lmgcpy.dynamics.model import Model
from lmgcpy.dynamics.step_problem import StepProblem

TWICE = 2
"""How often D is applied, see the module's text."""
SMALL = 1e-12
"""Compliance of links that carry, in parts of their W_nn: in closed polygons they may depend on each other."""


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
    ends: np.ndarray
    """Rows of the two bodies of each link, (L, 2)."""
    law: np.ndarray
    """Name of the law of each link, (L,)."""

    @classmethod
    def of(cls, model: Model) -> LeverStiffness:
        """Gather the links of a model."""
        d = model.dimension
        share = model.inverse_mass[:, d:]
        together = np.zeros(len(share), dtype=np.int64)
        if all(links.form == "central" for links in model.links):
            return cls(0, d, share, together, np.zeros((0, 2), np.int64), np.zeros(0, dtype="<U1"))
        pairs = np.concatenate([links.bodies[np.stack(links.ends)] for links in model.links], axis=1)
        moves = model.inverse_mass.max(axis=1, initial=0.0) > 0.0
        a, c = pairs[:, moves[pairs].all(axis=0)]
        together = connected(a, c, len(share))
        law = np.concatenate([[links.law.NAME] * links.link_count for links in model.links])
        return cls(len(law), d, share, together, pairs.T, law)

    def stiffness(self, problem: StepProblem, impulse: np.ndarray) -> np.ndarray:
        """kappa of each body by axis [kg m^2], (n, k - d), for impulses of the interactions (m, d)."""
        excess = np.minimum(problem.data.time_step * self._held(problem, impulse) * self.share - 2.0, MOST)
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

    def carrying(
        self,
        problem: StepProblem,
        impulse: np.ndarray,
        stiffness: np.ndarray,
        of_links: np.ndarray,
        mobility: np.ndarray,
        before: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray]:
        """w, see the module's text, (n, k), and the links that get their c from it, (L,) bool: those of components in which
        a lever has stiffness.

        ``impulse``: of the interactions (m, d); ``stiffness`` of the levers (n, k - d) and ``of_links`` of chains, which
        come first; ``mobility``: inverse masses without these, (n, k); ``before``: velocities before the step (n, k).
        """
        from scipy.sparse import block_array, csr_array, diags_array
        from scipy.sparse.linalg import splu

        d, width = self.dimension, problem.system.impulse.shape[1]
        here = np.zeros(len(before), dtype=bool)
        here[self.together[stiffness.any(axis=1)]] = True
        moves: np.ndarray = here[self.together][:, None] & (mobility > 0.0)
        links = moves[self.ends].any(axis=(1, 2))
        rows = problem.interaction_matrix(self.count)
        along = np.flatnonzero(links & (impulse[: self.count, 0] != 0.0))
        across = np.flatnonzero(links[: len(of_links)] & (of_links > 0.0))
        J, B = rows[width * along], rows[(width * across[:, None] + np.arange(1, d)).ravel()]
        held = diags_array(np.repeat(of_links[across], d - 1))
        own = np.zeros_like(before)
        own[:, d:] = stiffness
        start = np.where(mobility > 0.0, before, problem.free_velocity)
        free, v, own = np.flatnonzero(moves), start.ravel(), own.ravel()
        loose = problem.compliance(self.count)[along] + SMALL * problem.system.delassus[along, 0]
        M = diags_array(1.0 / mobility.ravel()[free] + own[free])
        stiff = csr_array(B[:, free].T @ held @ B[:, free] + M)
        factors = splu(block_array([[stiff, J[:, free].T], [J[:, free], diags_array(-loose)]]).tocsc())
        left = v
        for _ in range(TWICE):
            slope, parting = B.T @ (held @ (B @ left)) + own * left, J @ left
            left = np.zeros_like(v)
            left[free] = factors.solve(np.concatenate([slope[free], parting]))[: len(free)]
        return (v - left).reshape(before.shape), links

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
