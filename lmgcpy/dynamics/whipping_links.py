"""Links that whip: light bodies end a step at places where their links have the length that the laws predict.

A law keeps its link to the length L that it predicts along the normal of the detection. A link that moves by ``h u_t``
across itself ends at ``sqrt(L^2 + (h u_t)^2)``. If the step resolves the motion, the next step pulls this excess e back.
But a light body between two rods that straighten or buckle moves by its length and more in a step, and the rods would end
at twice their length.

So if a rigid link between centres ends too long by more than a tenth, positions are projected together with all rigid links
of its component (the links that free bodies join): the bodies move on by the ways d that minimise ``|d|^2_M / 2``, with the
masses M, under the constraints

    |x_c + d_c - x_a - d_a| = L for rods,    <= max(L, reference) for wires.

Velocities do not change. (Positions as in SHAKE: Ryckaert, Ciccotti, Berendsen 1977, J. Comput. Phys. 23; there the normals
are taken at the start, which fails from a right angle on, and the impulses change velocities too.)

**Newton steps.** With the vectors x of the links, pulls p, and b the map from ways of bodies to the relative way of a link,
a step solves

    (M + sum max(p, 0) b b^T) dd + J^T dp = -(M d + J^T p),    J dd = -(|x|^2 - L^2)/2,    J = x b^T.

The second term is geometric stiffness: without it Newton steps go astray if a chain ends stretched out, as light bodies run
off across it before a heavy one follows.

**No energy is made**: rigid links have no excess then, and the next step starts at their reference, as an inelastic law
does. It takes the velocity along the new normal. For a link that turned by phi, ``cos(phi) = L/(L + e)``, that is the part
``sin(phi)^2`` of the energy of its turning. If all the kinetic energy T of a component were in its turning, as in a pair of
bodies that spins, its ways would have

    |d/h|^2_M / 2 = tan(phi/2)^2 T,    tan(phi/2)^2 = e/(2 L + e).

So a component is projected only if ``|d/h|^2_M / 2`` is a small part of that, that is, if what turns is light. If heavy
bodies turn by as much in a step, the step is too long, and the run warns.
"""

from __future__ import annotations

import numpy as np

from lmgcpy.contact.frames import local_frames
from lmgcpy.dynamics.model import Model
from lmgcpy.dynamics.step_problem import StepProblem

BEYOND = 0.1
"""Part of its length by which a rigid link must be too long at the end of a step. A link that turns by 0.43 rad is."""
TURNING = 0.5
"""Part of the kinetic energy of a component, in the sense above, that may be in the turning of links that whip. (Elbows at
mass ratios of 1e6 and 1e7: up to 0.35. A pair of bodies that spins: 1.)"""
TURNING_OF_WIRES = 0.1
"""Limit for a component of wires alone. A whip that cracks has its energy in its light end, which must not be put back.
(One tapered to 1e-6: between 0.2 and 0.3; put back, its greatest speed changed by 29 %. Elbows of wires: below 0.1.)"""
STEPS = 60
"""Most Newton steps. (A bead 15 lengths away takes nine. If a chain ends stretched out, each halves the error.)"""
ACCURACY = 1e-10
"""Newton steps end if links are off by no more than this part of their length, and the balance of ways and pulls by no more
than this part of the largest way."""
KEPT = 1e-6
"""A component with a link that is off by more than this part of its length after the Newton steps is left as it was."""
SMALL = 1e-12
"""Compliance of the links in a Newton step, the lightest mass being 1: in closed polygons they may depend on each other."""


class WhippingLinks:
    """Projects the displacements of a step. L links, as the detector orders them."""

    def __init__(self, model: Model):
        count = [chain.link_count for chain in model.chains]
        self._rigid, self._pull = (
            np.repeat(np.array([trait in chain.law.TRAITS for chain in model.chains], dtype=bool), count)
            for trait in ("rigid", "pull")
        )
        for chain, stop in zip(model.chains, np.cumsum(count).tolist(), strict=True):
            if chain.points is not None:  # ways of centres are not ways of points that turn
                self._rigid[stop - chain.link_count : stop] &= ~(chain.points.turns[:-1] | chain.points.turns[1:])
        self._radius_sum = np.concatenate([np.zeros(0), *(chain.radius_sum for chain in model.chains)])

    def put_back(
        self, solved: StepProblem, displacement: np.ndarray, before: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray | None]:
        """The displacements of a step (n, k), projected if light bodies whip, and the impulses (m, d) that would give the
        ways added; else the displacements as they were, and None.

        ``solved``: has the velocities ``after``; ``before``: velocities at the start of the step (n, k).
        """
        system, data, d, count = solved.system, solved.data, solved.dimension, len(self._rigid)
        c, a = system.candidate[:count], system.antagonist[:count]
        along = data.gap[:count] + self._radius_sum
        move = data.time_step * data.after[:count, :d]
        predicted = along + move[:, 0]
        length = np.sqrt(predicted * predicted + (move[:, 1:] * move[:, 1:]).sum(axis=1))
        reference = data.reference_gap[:count] + self._radius_sum
        aim = np.where(self._pull, np.maximum(predicted, reference), predicted)
        off = self._rigid & (aim > 0.0) & (length > (1.0 + BEYOND) * aim)
        if not off.any() or system.deforms:  # in a cell that deforms, bodies move with it as well
            return displacement, None
        inverse = system.inverse_mass[:, :d]
        free: np.ndarray = inverse.max(axis=1) > 0.0
        label, of_link = components(c, a, free)
        ratio = np.zeros(len(free))  # tan(phi/2)^2 of the worst link, by component as all that follows
        np.maximum.at(ratio, of_link[off], ((length - aim) / (length + aim))[off])
        rows = np.flatnonzero(self._rigid & (ratio[of_link] > 0.0) & (free[c] | free[a]))
        way = displacement[:, :d]
        arrow = system.normal[:count] * along[:, None] + way[c] - way[a]
        push = project(arrow[rows], c[rows], a[rows], aim[rows], ~self._pull[rows], inverse)
        added = np.zeros_like(way)
        np.add.at(added, c[rows], inverse[c[rows]] * push)
        np.add.at(added, a[rows], -inverse[a[rows]] * push)
        wrong = excess(arrow[rows] + added[c[rows]] - added[a[rows]], aim[rows])
        whips: np.ndarray = ratio > 0.0
        whips[of_link[rows[np.where(self._pull[rows], wrong, np.abs(wrong)) > KEPT]]] = False
        held = np.zeros(len(free), dtype=bool)
        held[of_link[((inverse[c] == 0.0) | (inverse[a] == 0.0)).any(axis=1)]] = True
        start, by_loads = before[:, :d], solved.free_velocity[:, :d] - before[:, :d]
        energy = kinetic(start, inverse, label, held) + kinetic(by_loads, inverse, label, held)
        turning = np.full(len(free), TURNING_OF_WIRES)
        turning[of_link[rows[~self._pull[rows]]]] = TURNING
        whips &= kinetic(added / data.time_step, inverse, label, held) <= turning * ratio * energy
        whips[self._met(solved, added, rows, label)] = False
        if not whips.any():
            return displacement, None
        displacement = displacement.copy()
        displacement[:, :d] += np.where(whips[label][:, None], added, 0.0)
        given = np.where(whips[of_link[rows]][:, None], push, 0.0) / data.time_step
        pushed = np.zeros_like(system.impulse)
        pushed[rows, :d] = np.einsum("lij,lj->li", local_frames(system.normal[rows]), given)
        return displacement, pushed

    def _met(self, solved: StepProblem, added: np.ndarray, rows: np.ndarray, label: np.ndarray) -> np.ndarray:
        """Components in which ways ``added`` (n, d) would close a contact further than the step does, which nothing opens
        again, or change a link that is not among the ``rows``."""
        system, data, count = solved.system, solved.data, len(self._rigid)
        velocity = np.zeros_like(solved.free_velocity)
        velocity[:, : solved.dimension] = added
        change = solved.relative_velocities(velocity)[:, 0]
        gap = data.gap + data.time_step * data.after[:, 0]
        met = gap + change < np.minimum(gap, 0.0)
        met[:count] = change[:count] != 0.0
        met[rows] = False
        return label[np.concatenate([system.candidate[met], system.antagonist[met]])]


def components(c: np.ndarray, a: np.ndarray, free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The component of each body (n,) and of each link (L,), numbers below n: free bodies that links join."""
    from scipy.sparse import coo_array  # takes as long to import as the rest of lmgcpy
    from scipy.sparse.csgraph import connected_components

    both = free[c] & free[a]
    graph = coo_array((np.ones(int(both.sum())), (c[both], a[both])), shape=(len(free), len(free)))
    label = connected_components(graph, directed=False)[1]
    return label, label[np.where(free[c], c, a)]


def kinetic(velocity: np.ndarray, inverse: np.ndarray, label: np.ndarray, held: np.ndarray) -> np.ndarray:
    """Kinetic energy of each component [J], (n,), relative to its centre of mass if it is not ``held``; velocities and
    inverse masses (n, d)."""
    mass = np.where(inverse > 0.0, 1.0 / np.where(inverse > 0.0, inverse, 1.0), 0.0)

    def total(of_bodies: np.ndarray) -> np.ndarray:
        return np.stack([np.bincount(label, column, len(label)) for column in of_bodies.T], axis=1)

    masses = total(mass)
    mean = total(mass * velocity) / np.where(masses > 0.0, masses, 1.0)
    relative = velocity - np.where(held[:, None], 0.0, mean)[label]
    return total(0.5 * mass * relative * relative).sum(axis=1)


def excess(arrow: np.ndarray, aim: np.ndarray) -> np.ndarray:
    """``(|x|^2 / L^2 - 1)/2`` of vectors (r, d) and lengths (r,): if it is small, the part by which a link is too long."""
    return 0.5 * ((arrow * arrow).sum(axis=1) / (aim * aim) - 1.0)


def project(
    start: np.ndarray, c: np.ndarray, a: np.ndarray, aim: np.ndarray, held: np.ndarray, inverse: np.ndarray
) -> np.ndarray:
    """Pushes on the candidates of links [kg m], (r, d), and in the other direction on the antagonists, that give their
    vectors ``start`` (r, d) the lengths ``aim`` (r,).

    ``c``, ``a``: rows of the bodies (r,); ``held``: whether a link may not be shorter either, (r,); ``inverse``: inverse
    masses (n, d). Wires that were too long once stay at their length.
    """
    from scipy.sparse import block_array, csr_array, diags_array
    from scipy.sparse.linalg import splu

    count, d = start.shape
    bodies, ends = np.unique(np.concatenate([c, a]), return_inverse=True)
    lightest = inverse[bodies].max()
    root = np.sqrt(inverse[bodies] / lightest).ravel()
    # ways are root z, and |z|^2 is |way|^2_M over the lightest mass; "across" takes z to the ways across links
    column = np.stack([ends[:count], ends[count:]], axis=1)[:, None, :] * d + np.arange(d)[:, None]
    begins = 2 * np.arange(count * d + 1)
    across = csr_array((np.tile([1.0, -1.0], count * d), column.ravel(), begins), shape=(count * d, len(root)))
    across = across @ diags_array(root)
    pull, z = np.zeros(count), np.zeros(len(root))
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(STEPS):
            arrow = start + (across @ z).reshape(count, d)
            x = arrow / aim[:, None]
            of_links = csr_array((x.ravel(), np.arange(count * d), begins[: count + 1] // 2 * d), (count, count * d))
            jacobian = of_links @ across
            wrong = excess(arrow, aim)
            held = held | (wrong > ACCURACY)
            slope = z + jacobian.T @ pull
            if np.abs(wrong[held]).max(initial=0.0) <= ACCURACY and np.abs(slope).max() <= ACCURACY * np.abs(z).max():
                break
            rows = np.flatnonzero(held)
            stiff = across.T @ diags_array(np.repeat(np.maximum(pull, 0.0) / aim, d)) @ across
            loose = diags_array(np.full(len(rows), -SMALL))
            matrix = block_array([[stiff + diags_array(np.ones(len(z))), jacobian[rows].T], [jacobian[rows], loose]])
            found = splu(matrix.tocsc()).solve(-np.concatenate([slope, wrong[rows] * aim[rows]]))
            if not np.isfinite(found).all():
                break
            z += found[: len(z)]
            pull[rows] += found[len(z) :]
    return -pull[:, None] * x / lightest
