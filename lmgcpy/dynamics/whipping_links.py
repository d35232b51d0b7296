"""Links that whip: light bodies end a step at places where their links have the length that the laws predict, and their
joints are closed.

A law keeps its link to the length L that it predicts along the normal of the detection. A link that moves by ``h u_t``
across itself ends at ``sqrt(L^2 + (h u_t)^2)``. If the step resolves the motion, the next step pulls this excess e back.
But a light body between two rods that straighten or buckle moves by its length and more in a step, and the rods would end
at twice their length.

At a point off its centre a light body also turns by its length and more: a joint, which the law closes for points that go
straight on, ends open by ``|l| (1 - cos(phi))`` and more, if the body turns by phi and l is the vector to the point.

So if a rigid link ends too long by more than a tenth, or a joint open by more than a tenth of its lever, positions are
projected together with all rigid links and joints of the component (the links that free bodies join): the bodies move on
by the ways d that minimise ``|d|^2_M / 2``, with the masses M, under the constraints

    |x| = L for rods,    |x| <= max(L, reference) for wires,    x = s for joints.

Here ``x = x_c + d_c + l_c - x_a - d_a - l_a`` is the vector between the points of a link, s the one that the law of a joint
predicts, zero for a ball joint. Bodies with points off their centres turn on as well, by rotations Q about their axes, so
that ``l = R Q p``, R the rotation at the end of the step. Of their turning ``|d|^2_M / 2`` has half the integral of
``rho |way|^2``, ``tr(E) - tr(E Q)`` with the integrals E of ``rho x x^T``: for a small rotation vector d, ``d . I d / 2``.

Velocities do not change. (Positions as in SHAKE: Ryckaert, Ciccotti, Berendsen 1977, J. Comput. Phys. 23; there the normals
are taken at the start, which fails from a right angle on, and the impulses change velocities too.)

**Newton steps.** With the vectors x of the links, pulls p, and b the map from ways of bodies to the relative way of a link,
a step solves

    (M + sum max(p, 0) b b^T) dd + J^T dp = -(M d + J^T p),    J dd = -(|x|^2 - L^2)/2,    J = x b^T.

The second term is geometric stiffness: without it Newton steps go astray if a chain ends stretched out, as light bodies run
off across it before a heavy one follows. Rotations have the second slope of their ways and the stiffness G of levers under
the pulls (:mod:`lmgcpy.dynamics.lever_stiffness`), no eigenvalue below the inertia.

**No energy is made**: rigid links have no excess then, and the next step starts at their reference, as an inelastic law
does. It takes the velocity along the new normal. For a link that turned by phi, ``cos(phi) = L/(L + e)``, that is the part
``sin(phi)^2`` of the energy of its turning. If all the kinetic energy T of a component were in its turning, as in a pair of
bodies that spins, its ways would have

    |d/h|^2_M / 2 = tan(phi/2)^2 T,    tan(phi/2)^2 = e/(2 L + e).

So a component is projected only if ``|d/h|^2_M / 2`` is a small part of that, that is, if what turns is light. If heavy
bodies turn by as much in a step, the step is too long, and the run warns.

Points that turn know a limit to this. Their law closes them for points that go straight on: from a turn of 2 rad on, the
velocity ``|d/h|`` that pulls them back in the next step is more than the turning loses, and the energy grows from step to
step. So beyond a tenth of the kinetic energy they are projected in any case.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from lmgcpy.contact.detection_tables import JointTable
from lmgcpy.contact.frames import local_frames
from lmgcpy.contact.positions import axes_of, in_plane
from lmgcpy.dynamics.geometric_stiffness import connected
from lmgcpy.dynamics.model import Model
from lmgcpy.dynamics.step_problem import StepProblem

BEYOND = 0.1
"""Part of its length by which a rigid link must be too long at the end of a step, or of its lever by which a joint must be
open. A link that turns by 0.43 rad is, and a joint of a body that turns by 0.45."""
TURNING = 0.5
"""Part of the kinetic energy of a component, in the sense above, that may be in the turning of links that whip. (Elbows at
mass ratios of 1e6 and 1e7: up to 0.35. A pair of bodies that spins: 1.)"""
TURNING_OF_WIRES = 0.1
"""Limit for a component of wires alone. A whip that cracks has its energy in its light end, which must not be put back.
(One tapered to 1e-6: between 0.2 and 0.3; put back, its greatest speed changed by 29 %. Elbows of wires: below 0.1.)"""
WILD = 0.1
"""Part of the kinetic energy of a component with points that turn which pulling it back in the next step may take: from
here on it is projected though heavy bodies turn. (A rod that turns about its end by 0.7 rad in a step. Left alone, rods
that turn by 2 rad and more make energy.)"""
STEPS = 60
"""Most Newton steps. (A bead 15 lengths away takes nine. If a chain ends stretched out, each halves the error.)"""
STEPS_WITH_POINTS = 200
"""Most Newton steps if points turn with their bodies. (Rods flung about by up to 300 rad in a step: up to 100.)"""
ACCURACY = 1e-10
"""Newton steps end if links are off by no more than this part of their length, and the balance of ways and pulls by no more
than this part of the largest way."""
KEPT = 1e-6
"""A component with a link that is off by more than this part of its length after the Newton steps is left as it was."""
FARTHEST = 1.0
"""Greatest turn about an axis in a Newton step [rad]. (Without it a rod that has turned by 3 rad goes round in circles.)"""
LEAST = 1.0
"""Least stiffness of a rotation in a Newton step, in parts of the inertia about its axis."""
SMALL = 1e-12
"""Compliance of the links in a Newton step, the lightest mass being 1: in closed polygons they may depend on each other."""


class Arms(NamedTuple):
    """Points of links that turn with their bodies; r links, n bodies."""

    points: np.ndarray
    """Of the candidate and of the antagonist, along the axes of the body [m], (r, 2, d); zero if they do not turn."""
    ends: np.ndarray
    """Rows of the candidate and of the antagonist, (r, 2)."""
    axes: np.ndarray
    """Rotations from the axes of bodies to the axes of space, (n, d, d)."""

    def apart(self) -> np.ndarray:
        """Vectors to the points of the candidates less vectors to the points of the antagonists, along the axes of space
        [m], (r, d)."""
        candidate, antagonist = np.einsum("reij,rej->eri", self.axes[self.ends], self.points)
        return candidate - antagonist

    def turned(self, turn: np.ndarray) -> Arms:
        """These points after rotations of the bodies about their axes, ``exp([turn])``, (n, k - d)."""
        return self._replace(axes=self.axes @ rotations_by(turn))

    def slopes(self) -> np.ndarray:
        """Vectors to the points by rotation vectors of the bodies along their axes, (r, 2, d, k - d)."""
        if self.points.shape[2] == 2:
            return self.axes[self.ends] @ in_plane(np.array(0.5 * np.pi), self.points)[..., None]
        return -self.axes[self.ends] @ crosses(self.points)

    def stiffness(self, pull: np.ndarray) -> np.ndarray:
        """G of the bodies along their axes (n, k - d, k - d), if pulls draw the points of links together (r, d)."""
        f = np.einsum("reij,rei->rej", self.axes[self.ends], np.stack([-pull, pull], axis=1))
        l, k = self.points, 1 if self.points.shape[2] == 2 else 3
        each = (f * l).sum(axis=2)[..., None, None] * np.eye(k)
        if k == 3:
            outer = f[..., :, None] * l[..., None, :]
            each -= 0.5 * (outer + outer.swapaxes(2, 3))
        total = np.zeros((len(self.axes), k, k))
        np.add.at(total, self.ends, each)
        return total


class WhippingLinks:
    """Projects the displacements of a step. L links of chains and joints, as the detector orders them; ``turns``: whether
    some act at points that turn with their bodies."""

    def __init__(self, model: Model):
        count, d = [links.link_count for links in model.links], model.dimension
        self._rigid, self._pull = (
            np.repeat(np.array([trait in links.law.TRAITS for links in model.links], dtype=bool), count)
            for trait in ("rigid", "pull")
        )
        self._radius_sum = np.concatenate([np.zeros(0), *(links.radius_sum for links in model.links)])
        self._points = np.zeros((len(self._rigid), 2, d))
        self._axis = np.full(len(self._rigid), -1)
        for links, stop in zip(model.links, np.cumsum(count).tolist(), strict=True):
            if links.points is not None:
                part, (a, c) = slice(stop - links.link_count, stop), links.ends
                turned = np.where(links.points.turns[:, None], links.points.offset, 0.0)
                self._points[part] = np.stack([turned[c], turned[a]], axis=1)
                if isinstance(links, JointTable):
                    self._axis[part] = np.tile(range(d), links.link_count // d)
        self._tied = self._axis >= 0
        size = np.linalg.norm(self._points, axis=2).sum(axis=1)
        self._size = np.where(size > 0.0, size, 1.0)
        self._turns = size > 0.0
        self.turns = bool(self._turns.any())

    def put_back(
        self,
        solved: StepProblem,
        displacement: np.ndarray,
        before: np.ndarray,
        places: tuple[np.ndarray, np.ndarray],
        inverse_inertia: np.ndarray,
    ) -> tuple[np.ndarray | None, np.ndarray | None]:
        """The ways that bodies go on (n, k), and the impulses (m, d) that would give them, if light bodies whip; else None
        and None.

        ``solved``: has the velocities ``after``; ``displacement``: of its bodies (n, k); ``before``: velocities at the
        start of the step (n, k); ``places``: positions at this detection, and at the next one by the displacement, (n, w)
        both; ``inverse_inertia``: without the stiffness of levers (n, k - d).
        """
        system, data, d, count = solved.system, solved.data, solved.dimension, len(self._rigid)
        c, a = system.candidate[:count], system.antagonist[:count]
        along = data.gap[:count] + self._radius_sum
        move = data.time_step * data.after[:count, :d]
        predicted = along + move[:, 0]
        length = np.sqrt(predicted * predicted + (move[:, 1:] * move[:, 1:]).sum(axis=1))
        reference = data.reference_gap[:count] + self._radius_sum
        aim = np.where(self._pull, np.maximum(predicted, reference), predicted)
        way, inverse, arms = displacement[:, :d], system.inverse_mass[:, :d], None
        if self.turns:
            arrow, arms = self._arrows(solved, way, places, predicted)
            size = np.where(self._tied, self._size, 0.0)
            length = np.where(self._turns, np.sqrt((arrow * arrow).sum(axis=1)) + size, length)
            aim = np.where(self._tied, self._size, aim)
            inverse = np.hstack([inverse, inverse_inertia])
        off = self._rigid & (aim > 0.0) & (length > (1.0 + BEYOND) * aim)
        if not off.any() or system.deforms:  # in a cell that deforms, bodies move with it as well
            return None, None
        if arms is None:
            arrow = system.normal[:count] * along[:, None] + way[c] - way[a]
        free: np.ndarray = inverse.max(axis=1) > 0.0
        label, of_link = components(c, a, free)
        ratio = np.zeros(len(free))  # tan(phi/2)^2 of the worst link, by component as all that follows
        np.maximum.at(ratio, of_link[off], ((length - aim) / (length + aim))[off])
        rows = np.flatnonzero(self._rigid & (ratio[of_link] > 0.0) & (free[c] | free[a]))
        held, axis = ~self._pull[rows], self._axis[rows]
        arms = None if arms is None else arms._replace(points=arms.points[rows], ends=arms.ends[rows])
        push, turn = project(arrow[rows], c[rows], a[rows], aim[rows], held, inverse, arms, axis)
        added = np.zeros_like(displacement)
        added[:, d : d + turn.shape[1]] = turn
        np.add.at(added[:, :d], c[rows], inverse[c[rows], :d] * push)
        np.add.at(added[:, :d], a[rows], -inverse[a[rows], :d] * push)
        ends = arrow[rows] + added[c[rows], :d] - added[a[rows], :d]
        if arms is not None:
            ends += arms.turned(turn).apart() - arms.apart()
        wrong = excess(ends, aim[rows], axis)
        whips: np.ndarray = ratio > 0.0
        whips[of_link[rows[np.where(self._pull[rows], wrong, np.abs(wrong)) > KEPT]]] = False
        held = np.zeros(len(free), dtype=bool)
        held[of_link[((inverse[c, :d] == 0.0) | (inverse[a, :d] == 0.0)).any(axis=1)]] = True
        k = inverse.shape[1]
        start, by_loads = before[:, :k], solved.free_velocity[:, :k] - before[:, :k]
        energy = kinetic(start, inverse, label, held, d) + kinetic(by_loads, inverse, label, held, d)
        turning = np.full(len(free), TURNING_OF_WIRES)
        turning[of_link[rows[~self._pull[rows]]]] = TURNING
        pulled = kinetic(added[:, :k] / data.time_step, inverse, label, held, d)
        wild = np.zeros(len(free), dtype=bool)
        wild[of_link[self._turns]] = True
        whips &= (pulled <= turning * ratio * energy) | wild & (pulled > WILD * energy)
        whips[self._met(solved, added, rows, label)] = False
        if not whips.any():
            return None, None
        given = np.where(whips[of_link[rows]][:, None], push, 0.0) / data.time_step
        pushed = np.zeros_like(system.impulse)
        pushed[rows, :d] = np.einsum("lij,lj->li", local_frames(system.normal[rows]), given)
        return np.where(whips[label][:, None], added, 0.0), pushed

    def _arrows(
        self, solved: StepProblem, way: np.ndarray, places: tuple[np.ndarray, np.ndarray], predicted: np.ndarray
    ) -> tuple[np.ndarray, Arms]:
        """Vectors between the points of links at the next detection, of joints less the vector that their law predicts [m],
        (L, d); and the points with the rotations there."""
        system, data, d, count = solved.system, solved.data, solved.dimension, len(self._rigid)
        c, a = system.candidate[:count], system.antagonist[:count]
        ends = np.stack([c, a], axis=1)
        now, ahead = (Arms(self._points, ends, rotations(positions, d)) for positions in places)
        arrow = system.normal[:count] * (data.gap[:count] + self._radius_sum)[:, None]
        left = (data.gap[:count] - predicted)[self._tied].reshape(-1, d)
        arrow[self._tied] = np.repeat(left, d, axis=0)
        return arrow + way[c] - way[a] + ahead.apart() - now.apart(), ahead

    def _met(self, solved: StepProblem, added: np.ndarray, rows: np.ndarray, label: np.ndarray) -> np.ndarray:
        """Components in which ways ``added`` (n, k) would close a contact further than the step does, which nothing opens
        again, or change a link that is not among the ``rows``."""
        system, data, count = solved.system, solved.data, len(self._rigid)
        velocity = np.zeros_like(solved.free_velocity)
        velocity[:, : added.shape[1]] = added
        change = solved.relative_velocities(velocity)[:, 0]
        gap = data.gap + data.time_step * data.after[:, 0]
        met = gap + change < np.minimum(gap, 0.0)
        met[:count] = change[:count] != 0.0
        met[rows] = False
        return label[np.concatenate([system.candidate[met], system.antagonist[met]])]


def components(c: np.ndarray, a: np.ndarray, free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The component of each body (n,) and of each link (L,), numbers below n: free bodies that links join."""
    both = free[c] & free[a]
    label = connected(c[both], a[both], len(free))
    return label, label[np.where(free[c], c, a)]


def kinetic(velocity: np.ndarray, inverse: np.ndarray, label: np.ndarray, held: np.ndarray, d: int) -> np.ndarray:
    """Kinetic energy of each component [J], (n,), relative to its centre of mass if it is not ``held``; velocities and
    inverse masses (n, d), or (n, k) with the turning of the bodies."""
    mass = np.where(inverse > 0.0, 1.0 / np.where(inverse > 0.0, inverse, 1.0), 0.0)

    def total(of_bodies: np.ndarray) -> np.ndarray:
        return np.stack([np.bincount(label, column, len(label)) for column in of_bodies.T], axis=1)

    masses = total(mass)
    mean = total(mass * velocity) / np.where(masses > 0.0, masses, 1.0)
    mean[:, d:] = 0.0
    relative = velocity - np.where(held[:, None], 0.0, mean)[label]
    return total(0.5 * mass * relative * relative).sum(axis=1)


def excess(arrow: np.ndarray, aim: np.ndarray, axis: np.ndarray | None = None) -> np.ndarray:
    """``(|x|^2 / L^2 - 1)/2`` of vectors (r, d) and lengths (r,): if it is small, the part by which a link is too long. Of
    joints the component of x along an ``axis`` (r,), -1 for links, over the length."""
    off = 0.5 * ((arrow * arrow).sum(axis=1) / (aim * aim) - 1.0)
    if axis is None:
        return off
    return np.where(axis < 0, off, np.take_along_axis(arrow, np.maximum(axis, 0)[:, None], axis=1)[:, 0] / aim)


def rotations(positions: np.ndarray, dimension: int) -> np.ndarray:
    """Rotations from the axes of bodies to the axes of space, (n, d, d), at ``positions`` (n, w)."""
    return axes_of(positions) if dimension == 3 else rotations_by(positions[:, 2:])


def rotations_by(turn: np.ndarray) -> np.ndarray:
    """Matrices (n, d, d) of rotations by rotation vectors (n, k - d)."""
    if turn.shape[1] == 1:
        return in_plane(turn, np.eye(2)[None]).transpose(0, 2, 1)
    from scipy.spatial.transform import Rotation  # takes as long to import as the rest of lmgcpy

    return Rotation.from_rotvec(turn).as_matrix()


def rotation_vectors(matrices: np.ndarray) -> np.ndarray:
    """The shortest ones of rotations (n, d, d), (n, k - d)."""
    if matrices.shape[1] == 2:
        return np.arctan2(matrices[:, 1, 0], matrices[:, 0, 0])[:, None]
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(matrices).as_rotvec()


def crosses(vectors: np.ndarray) -> np.ndarray:
    """The matrices of ``v x``, (..., 3, 3), of vectors v (..., 3)."""
    return np.cross(vectors[..., None, :], np.eye(3)).swapaxes(-1, -2)


def spread(inverse_inertia: np.ndarray) -> np.ndarray:
    """Integrals of ``rho x_i^2`` along the axes of bodies [kg m^2], (n, d), from their inverse inertias (n, k - d)."""
    inertia = np.where(inverse_inertia > 0.0, 1.0 / np.where(inverse_inertia > 0.0, inverse_inertia, 1.0), 0.0)
    if inertia.shape[1] == 1:
        return np.tile(0.5 * inertia, 2)  # only their sum matters
    return 0.5 * inertia.sum(axis=1, keepdims=True) - inertia


def turning_ways(E: np.ndarray, turned: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Slope (n, k - d) and second slope (n, k - d, k - d), by rotation vectors along the axes, of half the integral of
    ``rho |way|^2`` over bodies that are turned by these rotations (n, d, d), ``tr(E) - tr(E Q)``; E from :func:`spread`."""
    A = E[:, :, None] * turned
    trace = np.einsum("nii->n", A)[:, None, None]
    if A.shape[1] == 2:
        return (A[:, 1, 0] - A[:, 0, 1])[:, None], trace
    slope = np.stack([A[:, 2, 1] - A[:, 1, 2], A[:, 0, 2] - A[:, 2, 0], A[:, 1, 0] - A[:, 0, 1]], axis=1)
    return slope, trace * np.eye(3) - 0.5 * (A + A.swapaxes(1, 2))


def project(
    start: np.ndarray,
    c: np.ndarray,
    a: np.ndarray,
    aim: np.ndarray,
    held: np.ndarray,
    inverse: np.ndarray,
    arms: Arms | None = None,
    axis: np.ndarray | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Pushes on the candidates of links [kg m], (r, d), and in the other direction on the antagonists, that give their
    vectors ``start`` (r, d) the lengths ``aim`` (r,), or close them; and rotation vectors of the bodies (n, k - d).

    ``c``, ``a``: rows of the bodies (r,); ``held``: whether a link may not be shorter either, (r,); ``inverse``: inverse
    masses (n, d), with ``arms`` (n, k); ``axis``: of joints, (r,), see :func:`excess`. Wires that were too long once stay
    at their length.
    """
    from scipy.sparse import block_array, block_diag, csr_array, diags_array, hstack
    from scipy.sparse.linalg import splu

    (count, d), k = start.shape, inverse.shape[1]
    bodies, ends = np.unique(np.concatenate([c, a]), return_inverse=True)
    lightest = inverse[bodies, :d].max()
    root = np.sqrt(inverse[bodies] / lightest)
    # ways are root z, and |z|^2 is |way|^2_M over the lightest mass; "across" takes z to the ways across links
    sides = np.stack([ends[:count], ends[count:]], axis=1)
    column = sides[:, None, :] * d + np.arange(d)[:, None]
    begins = 2 * np.arange(count * d + 1)
    across = csr_array((np.tile([1.0, -1.0], count * d), column.ravel(), begins), shape=(count * d, len(bodies) * d))
    across = moving = across @ diags_array(root[:, :d].ravel())  # to ways of centres alone
    tied = np.zeros(count, dtype=bool) if axis is None else axis >= 0
    pull, z, moved, swift = np.zeros(count), np.zeros(len(bodies) * d), len(bodies) * d, root[:, d:]
    if arms is not None:
        start = start - arms.apart()
        arms = there = Arms(arms.points, sides, arms.axes[bodies])
        columns = np.repeat(sides[:, None, :, None] * (k - d) + np.arange(k - d), d, axis=1)
        E = spread(inverse[bodies, d:]) * lightest
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(STEPS if arms is None else STEPS_WITH_POINTS):
            arrow = start + (moving @ z).reshape(count, d)
            balance = z
            if arms is not None:
                arrow += there.apart()
                slopes = (there.slopes() * swift[sides][:, :, None]).swapaxes(1, 2) * [[[1.0], [-1.0]]]
                turning = (slopes.ravel(), columns.ravel(), begins * (k - d))
                across = hstack([moving, csr_array(turning, shape=(count * d, swift.size))], format="csr")
                slope, second = turning_ways(E, arms.axes.swapaxes(1, 2) @ there.axes)
                balance = np.concatenate([z, (swift * slope).ravel()])
            x = arrow / aim[:, None] if axis is None else np.where(tied[:, None], np.eye(d)[axis], arrow / aim[:, None])
            of_links = csr_array((x.ravel(), np.arange(count * d), begins[: count + 1] // 2 * d), (count, count * d))
            jacobian = of_links @ across
            wrong = excess(arrow, aim, axis)
            held = held | (wrong > ACCURACY)
            slope = balance + jacobian.T @ pull
            if np.abs(wrong[held]).max(initial=0.0) <= ACCURACY and np.abs(slope).max() <= ACCURACY * np.abs(balance).max():
                break
            rows = np.flatnonzero(held)
            taut = np.where(tied, 0.0, np.maximum(pull, 0.0) / aim)
            stiff = across.T @ diags_array(np.repeat(taut, d)) @ across
            own = diags_array(np.ones(moved))
            if arms is not None:
                second += there.stiffness(pull[:, None] * x)
                values, vectors = np.linalg.eigh(swift[:, :, None] * second * swift[:, None])
                own = block_diag([own, *((vectors * np.maximum(values, LEAST)[:, None]) @ vectors.swapaxes(1, 2))])
            loose = diags_array(np.full(len(rows), -SMALL))
            matrix = block_array([[stiff + own, jacobian[rows].T], [jacobian[rows], loose]])
            found = splu(matrix.tocsc()).solve(-np.concatenate([slope, wrong[rows] * aim[rows]]))
            if not np.isfinite(found).all():
                break
            if arms is not None:
                on = swift * found[moved : len(slope)].reshape(swift.shape)
                part = FARTHEST / max(FARTHEST, np.abs(on).max())
                there, found = there.turned(part * on), part * found
            z += found[:moved]
            pull[rows] += found[len(slope) :]
    turn = np.zeros((len(inverse), k - d))
    if arms is not None:
        turn[bodies] = rotation_vectors(arms.axes.swapaxes(1, 2) @ there.axes)
    return -pull[:, None] * x / lightest, turn
