"""A warning if the step damps waves of a taut wire that it resolves.

If ``s = 4 h^2 T/(m l) > 2``, links have geometric stiffness, which resists bending of the wire
(``geometric_stiffness.py``). Waves that the step cannot resolve are gone within a step, as they should be. A slow wave of
the same wire, of a frequency w with ``h w << 1``, loses amplitude by the factor ``exp(-pi alpha h w)`` in each period, with
``alpha = 1 - 2/s``. This looks like friction.

**Modes.** Between bodies that hold it a wire swings in modes y of ``K y = w^2 M y`` with ``K = sum (T/l) b b^T``, b the map
from velocities to the relative velocity across a link. With ``C = sum kappa b b^T`` and ``c = y . C y / y . M y`` one step
maps position and velocity of a mode by a matrix of

    determinant d^2 = 1/(1 + c),      trace 2 d cos(theta) = (2 + c - (h w)^2)/(1 + c),

so that ``z = v - i a/w``, with v the velocity of the mode and a its acceleration in the middle of the step, is multiplied
by ``d exp(i theta)``. The rest position of the wire, sagging or not, does not enter. Modes in which the wire turns as a
whole (a pendulum) are left alone by the step and are not looked at.

**Closed chains.** If a bead is held, the chain begins and ends at it. If none is, as in a string that is closed across the
faces of a periodic cell or a ring that spins, it swings in pairs of modes, sin and cos of an even string. Its motion is
looked at in directions that are across all of its links, as out of the plane of a ring.

**Round rings in their plane.** A ring of radius R that spins with w_0, and may be blown up by a pressure p, has the
tension ``T0 = rho R^2 W^2``, rho its mass per length; without pressure W = w_0. If it bends, its beads move along it as
well. In the frame that spins let it be displaced by u outward and by v along itself. It keeps its length, ``u + v' = 0``,
and its links turn by ``phi = (u' - v)/R``; with dots by time and primes by angle

    rho (u.. - 2 w_0 v. - w_0^2 (R + u)) = (T0 phi' - T)/R + p,
    rho (v.. + 2 w_0 u. - w_0^2 v) = (T0 phi + T')/R - p phi.

``v ~ exp(i (n a + w t))``, a the angle, and the elimination of T give

    (1 + n^2) w^2 - 4 n w_0 w + 2 n^2 w_0^2 - n^2 (n^2 - 1) W^2 = 0,

without pressure ``w = n w_0``, a shape that rests in space, and ``-n w_0 (n^2 - 3)/(n^2 + 1)``. The term of the step lets
T0 act along links as they will have turned, by ``alpha h phi.`` further. The left side gets
``-i alpha h w W^2 (n^2 - 1)^2``, and to first order in h a motion decays at the rate

    alpha h W^2 / 2 (n^2 - 1)^2 w / ((1 + n^2) w - 2 n w_0).

**Waves.** A motion is told if it goes as these numbers predict, all modes together, at each quarter of the period of its
strongest mode: one standing wave, waves that travel, or the many modes of a string that was plucked. The motion of a wire
among grains, or of one that is being laid, does not.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from lmgcpy.dynamics.geometric_stiffness import LinkStiffness
from lmgcpy.dynamics.model import Model
from lmgcpy.dynamics.step_problem import StepProblem
from lmgcpy.dynamics.watch import Said
from lmgcpy.dynamics.watch.displacements import rounded_down

EVERY = 16
"""New waves are looked for once in this number of steps."""
RESOLVED = 0.5
"""Largest ``h w`` of a mode that a step resolves, twelve steps a period."""
SLOW = 1.0
"""Largest ``h w`` of a motion in the mean in which modes are looked for."""
MODES = 24
"""Most modes of a wire that are looked at, the slowest ones: a string that was plucked has 98 % of its energy in them."""
LOST = 0.02
"""Part of its amplitude that a motion may lose in a period before the run warns."""
ROUNDS = 10
"""Times that a block of modes is multiplied by the inverse: the last mode that is looked at is then off by ``(1/4)^10``."""
FLAT = 0.01
"""Mean square of the part of a closed chain's directions that may lie along a direction across it."""
AS_A_WHOLE = 0.1
"""A mode in which the wire turns as a whole loses less than this part of what its links would lose by turning each on its
own."""
FAINT = 1e-5
"""Least amplitude of a motion, in parts of the length of a link."""
EVEN = 0.05
"""Most difference of the links and beads of a ring from their means, in parts of these, with which it counts as round."""
APART = 0.3
"""Most difference of a motion from the predicted one, in parts of the latter, and of a motion from its slow modes."""
SEEN = 0.5
"""Least part of the predicted loss that is seen after a period: what drives a wire on and on keeps it from losing."""
CHECKS = 4
"""Times in a period at which a motion is compared with the predicted one."""


class Modes(NamedTuple):
    """The slow modes of a chain, k of them."""

    shape: np.ndarray
    """Velocities of the b beads times the roots of their masses, of length one; (b, k)."""
    frequency: np.ndarray
    """w [rad/s], (k,)."""
    damped: np.ndarray
    """Whether the wire bends in it, and swings, (k,)."""
    factor: np.ndarray
    """``d exp(i theta)`` of each step, (k,) complex."""


class RingModes(NamedTuple):
    """Motions of a round ring in its plane, j numbers n of waves around it with two each, k = 2 j."""

    number: np.ndarray
    """n, (j,)."""
    length: float
    """Of a link [m]."""
    exponent: np.ndarray
    """``i w - rate`` of the two of each number [1/s], (2, j) complex."""
    frequency: np.ndarray
    """Size of w [rad/s], (k,)."""
    damped: np.ndarray
    """Whether the step resolves it, (k,)."""
    factor: np.ndarray
    """Factor of each step, (k,) complex."""


class Wave(NamedTuple):
    """A motion that may be that of a free wire."""

    chain: int
    step: int
    """Step in which it was seen."""
    time_step: float
    modes: Modes | RingModes
    amplitude: np.ndarray
    """z of its modes at that time, (k, d) complex."""
    period: int
    """Steps in a period of its strongest mode."""
    lost: float
    """Part of its amplitude that it loses in that time."""
    checked: int = 0
    """How often it was found as predicted."""


class DampedWaves:
    """Looks for damped waves until the first one was reported."""

    def __init__(self, model: Model, said: Said):
        self._said = said
        self._steps = 0
        self._waves: tuple[Wave, ...] = ()
        self.look_at(model)

    def look_at(self, model: Model) -> None:
        """Go on with a model that has changed."""
        self._cuts = np.cumsum([0, *(chain.link_count for chain in model.chains)])
        self._mass = model.free_mass[:, : model.dimension].max(axis=1, initial=0.0)
        self._central = np.array([chain.form == "central" for chain in model.chains], dtype=bool)  # points have other waves
        self._chains, self._links = [], []
        for chain, first in zip(model.chains, self._cuts[:-1].tolist(), strict=True):
            bodies, links = chain.bodies, np.arange(first, first + chain.link_count)
            if chain.closed:
                bodies = bodies[:-1]
                held = np.flatnonzero(self._mass[bodies] == 0.0)
                if len(held):  # an open chain from this bead to itself
                    bodies, links = np.roll(bodies, -held[0]), np.roll(links, -held[0])
                    bodies = np.append(bodies, bodies[0])
            self._chains.append(bodies)
            self._links.append(links)
        self._waves = ()

    def after_step(self, problem: StepProblem, links: LinkStiffness, before: np.ndarray, time: float) -> list[str]:
        """A sentence on the first motion that the step damps; ``before``: velocities at the start of the step (n, k),
        ``time``: of its end [s]."""
        stiffness, h = problem.system.geometric, problem.data.time_step
        if "wave" in self._said or not len(stiffness):
            return []
        self._steps += 1
        kept = []
        for wave in self._waves:
            if h != wave.time_step:
                continue
            steps = self._steps - wave.step
            if steps == (wave.checked + 1) * wave.period // CHECKS:
                predicted = wave.amplitude * wave.modes.factor[:, None] ** steps
                now, quick = self._amplitude(problem, before, wave.chain, wave.modes)
                size = np.linalg.norm(predicted)
                if not np.hypot(np.linalg.norm(now - predicted), quick) <= APART * size:
                    continue
                wave = wave._replace(checked=wave.checked + 1)
                if wave.checked == CHECKS:
                    left = (predicted.conj() * now).real.sum() / size
                    if left <= (1.0 - SEEN * wave.lost) * np.linalg.norm(wave.amplitude) and self._said.first("wave"):
                        return [self._sentence(problem, links, wave, time)]
                    continue
            kept.append(wave)
        if self._steps % EVERY == 0:
            seen = {wave.chain for wave in kept}
            stiff = np.logical_or.reduceat(stiffness > 0.0, self._cuts[:-1]) & self._central
            for chain in (k for k in np.flatnonzero(stiff).tolist() if k not in seen):
                new = self._seen(problem, links, before, chain) or self._ring_seen(problem, links, before, chain)
                if new is not None:
                    kept.append(new)
        self._waves = tuple(kept)
        return []

    def _across(self, problem: StepProblem, velocity: np.ndarray, chain: int) -> np.ndarray:
        """Velocities of the beads of a chain across it [m/s], (b, d), from those of all bodies (n, k): relative to the line
        between ends that are held; of a closed chain relative to its centre of mass, and out of its line or plane."""
        bodies = self._chains[chain]
        velocity = velocity[bodies, : problem.dimension]
        normal = problem.system.normal[self._links[chain]]
        if len(normal) == len(bodies):
            mass, (across, _) = self._mass[bodies], directions(normal)
            return (velocity - mass @ velocity / mass.sum()) @ (across @ across.T)
        held = self._mass[bodies[[0, -1]]] == 0.0
        first, last = (velocity[end] if held[end] else velocity[~end] if held[~end] else 0.0 for end in (0, -1))
        share = np.linspace(0.0, 1.0, len(bodies))[:, None]
        return without(velocity - (1.0 - share) * first - share * last, np.concatenate([normal, normal[-1:]]))

    def _turned(self, problem: StepProblem, before: np.ndarray, chain: int, length: float) -> np.ndarray:
        """Angles in its plane between links of a ring and links of a round ring [rad], and how fast links turn [1/s],
        in the sense in which the chain goes around; (2, l)."""
        part, bodies, d = self._links[chain], self._chains[chain], problem.dimension
        plane = directions(problem.system.normal[part])[1]
        normal = problem.system.normal[part] @ plane
        velocity = 0.5 * (before + problem.system.velocity)[bodies, :d] @ plane
        angle = np.unwrap(np.arctan2(normal[:, 1], normal[:, 0]))
        rate = (normal[:, 0] * along(velocity, len(part))[:, 1] - normal[:, 1] * along(velocity, len(part))[:, 0]) / length
        sense = math.copysign(1.0, angle[-1] - angle[0])
        angle = sense * angle - 2.0 * math.pi / len(part) * np.arange(len(part))
        return np.stack([angle - angle.mean(), sense * rate])

    def _amplitude(
        self, problem: StepProblem, before: np.ndarray, chain: int, modes: Modes | RingModes
    ) -> tuple[np.ndarray, float]:
        """z of the modes of a chain that bend it and swing, zero of the others, (k, d); and the size of the rest of its
        motion, in quicker modes. Of a ring in its plane: the angles of its links in these modes, (k, 1)."""
        if isinstance(modes, RingModes):
            turned = self._turned(problem, before, chain, modes.length)
            angle, rate = 2.0 / turned.shape[1] * np.fft.fft(turned)[:, modes.number]
            first = (rate - modes.exponent[1] * angle) / (modes.exponent[0] - modes.exponent[1])
            z = np.concatenate([first, angle - first])[:, None]
            quick = 2.0 * float((turned[0] ** 2).mean()) - float((abs(angle) ** 2).sum())
            z[~modes.damped] = 0.0
            return z, math.sqrt(max(quick, 0.0))
        root = np.sqrt(self._mass[self._chains[chain]])[:, None]
        start, end = (root * self._across(problem, v, chain) for v in (before, problem.system.velocity))
        middle = 0.5 * (start + end)
        slow = modes.shape.T @ middle
        quick = (middle * middle).sum() - (slow * slow).sum()
        z = slow - 1j * (modes.shape.T @ (end - start)) / (problem.data.time_step * modes.frequency[:, None])
        z[~modes.damped] = 0.0
        return z, math.sqrt(max(quick, 0.0))

    def _seen(self, problem: StepProblem, links: LinkStiffness, before: np.ndarray, chain: int) -> Wave | None:
        """The motion of a chain, if it may be a wave that the step resolves and damps."""
        part, h = self._links[chain], problem.data.time_step
        mass = self._mass[self._chains[chain]]
        free = mass > 0.0
        length = problem.data.gap[part] + links.radius_sum[part]
        pull = np.maximum(-problem.system.impulse[part, 0], 0.0) / (h * length)
        across = self._across(problem, problem.system.velocity, chain)
        inertia = float(mass @ (across * across).sum(axis=1))
        if len(part) == len(mass) and not pull.all():
            return None  # a ring that is slack somewhere
        bent = without(along(across, len(part)), problem.system.normal[part])
        if not (inertia > 0.0 and h * h * float(pull @ (bent * bent).sum(axis=1)) < SLOW * SLOW * inertia):
            return None
        turning = length[:, None]
        if len(part) == len(mass):
            turning = turning * (problem.system.normal[part] @ directions(problem.system.normal[part])[1])
        modes = slow_modes(mass, pull, problem.system.geometric[part], turning, h)
        z, quick = self._amplitude(problem, before, chain, modes)
        energy = (abs(z) ** 2).sum(axis=1)
        whole = float(energy.sum())
        if not quick < APART * math.sqrt(whole):
            return None
        strongest = int(np.argmax(energy))
        fastest = float((np.linalg.norm(modes.shape @ z, axis=1)[free] / np.sqrt(mass[free])).max())
        if fastest < FAINT * float(modes.frequency[strongest] * length.min()):
            return None
        period = 2.0 * math.pi / float(np.angle(modes.factor[strongest]))
        lost = 1.0 - math.sqrt(float((energy * abs(modes.factor) ** (2.0 * period)).sum()) / whole)
        return Wave(chain, self._steps, h, modes, z, round(period), lost) if lost > LOST else None

    def _ring_seen(self, problem: StepProblem, links: LinkStiffness, before: np.ndarray, chain: int) -> Wave | None:
        """The motion of a round ring in its plane, if the step may resolve and damp it."""
        part, h = self._links[chain], problem.data.time_step
        mass, normal = self._mass[self._chains[chain]], problem.system.normal[part]
        if len(part) != len(mass) or directions(normal)[1].shape[1] != 2:
            return None
        length = problem.data.gap[part] + links.radius_sum[part]
        pull = np.maximum(-problem.system.impulse[part, 0], 0.0) / (h * length)
        if any((abs(x - x.mean()) > EVEN * x.mean()).any() for x in (mass, length, pull)):
            return None
        turned = self._turned(problem, before, chain, float(length.mean()))
        spin, share = float(turned[1].mean()), 4.0 * math.sin(math.pi / len(part)) ** 2 / float(mass.mean())
        numbers = np.arange(2, min(MODES // 2 + 1, len(part) // 4) + 1)
        if not len(numbers) or float((turned[0] ** 2).max()) > APART**2:
            return None
        tension, stiffness = share * float(pull.mean()), share * float(problem.system.geometric[part].mean())
        modes = ring_modes(numbers, float(length.mean()), spin, tension, stiffness, h)
        z, quick = self._amplitude(problem, before, chain, modes)
        energy = (abs(z) ** 2).sum(axis=1)
        whole = float(energy.sum())
        if not quick < APART * math.sqrt(whole) or whole < FAINT**2:
            return None
        period = 2.0 * math.pi / abs(float(np.angle(modes.factor[int(np.argmax(energy))])))
        lost = 1.0 - math.sqrt(float((energy * abs(modes.factor) ** (2.0 * period)).sum()) / whole)
        return Wave(chain, self._steps, h, modes, z, round(period), lost) if lost > LOST else None

    def _sentence(self, problem: StepProblem, links: LinkStiffness, wave: Wave, time: float) -> str:
        part, h = self._links[wave.chain], problem.data.time_step
        s = float(links.resolution(problem.system.impulse, problem.data.gap, h)[part].max())
        bodies = self._chains[wave.chain]
        closed = len(part) == len(bodies) or bodies[0] == bodies[-1]
        wire = f"closed wire of body {bodies[0]}" if closed else f"wire from body {bodies[0]} to body {bodies[-1]}"
        return (
            f"Until t = {time:g} s waves of the {wire} lost {100.0 * wave.lost:.2g} % of "
            f"their amplitude in a period of {wave.period * h:.3g} s: the step is long for its beads, "
            f"s = 4 h^2 T/(m l) = {s:.3g}, and geometric stiffness damps from 2 on. A time step of "
            f"{rounded_down(h * math.sqrt(2.0 / s))} s damps no wave. (Said once.)"
        )


def slow_modes(mass: np.ndarray, pull: np.ndarray, stiffness: np.ndarray, turning: np.ndarray, time_step: float) -> Modes:
    """The slowest modes of a chain of b beads that a step resolves: masses [kg], zero of beads that are held, (b,);
    ``T/l`` [N/m] and kappa [kg] of its links, (b - 1,), or (b,) if it is closed; velocities across the links if it turns as
    a whole at 1 rad/s, in all j ways to turn, [m/s], (links, j)."""
    free = mass > 0.0
    weight = np.where(free, 1.0 / np.sqrt(np.where(free, mass, 1.0)), 0.0)
    squares, shape = open_modes(weight, pull) if len(pull) < len(mass) else closed_modes(weight, pull)
    square = time_step * time_step * squares
    resolved = square < RESOLVED * RESOLVED
    squares, square, shape = squares[resolved], square[resolved], shape[:, resolved]
    bent = along(weight[:, None] * shape, len(pull))
    root = np.sqrt(stiffness)[:, None]
    straight = bent - turning @ np.linalg.lstsq(root * turning, root * bent, rcond=1e-10)[0]
    c = stiffness @ (straight * straight)
    damped = c > AS_A_WHOLE * (stiffness @ (bent * bent))
    d = 1.0 / np.sqrt(1.0 + c)
    theta = np.arccos(np.clip(0.5 * d * (2.0 + c - square), -1.0, 1.0))
    damped &= 2.0 * theta > c  # else exp(-2 pi) or less is left after a period, or it does not swing: no wave
    return Modes(shape, np.sqrt(squares), damped, d * np.exp(1j * theta))


def ring_modes(
    numbers: np.ndarray, length: float, spin: float, tension: float, stiffness: float, time_step: float
) -> RingModes:
    """The motions of a round ring in its plane with these ``numbers`` of waves, see the module's text; ``spin`` w_0,
    ``tension`` W^2, and ``stiffness`` alpha h^2 W^2."""
    n = numbers.astype(float)
    square = n * n
    root = np.sqrt(np.maximum(square * (square - 1.0) * ((square + 1.0) * tension - 2.0 * spin * spin), 0.0))
    w = (2.0 * n * spin + np.stack([root, -root])) / (1.0 + square)
    rate = 0.5 * stiffness / time_step * (square - 1.0) ** 2 * w / np.stack([root, -root])
    frequency, loss = abs(w).ravel(), rate.ravel()
    damped = (time_step * frequency < RESOLVED) & (frequency > loss)
    exponent = 1j * w - rate
    return RingModes(numbers, length, exponent, frequency, damped, np.exp(time_step * exponent).ravel())


def open_modes(weight: np.ndarray, pull: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Squares of the frequencies and shapes of the slowest modes of an open chain; weights, one over the roots of the
    masses, zero of beads that are held, (b,), and ``T/l`` (b - 1,)."""
    from scipy.linalg import eigh_tridiagonal  # takes long to import

    held_by = np.concatenate([pull, [0.0]]) + np.concatenate([[0.0], pull])
    nothing = int((weight == 0.0).sum())  # modes of no frequency
    squares, shape = eigh_tridiagonal(
        weight * weight * held_by,
        -pull * weight[:-1] * weight[1:],
        select="i",
        select_range=(0, min(nothing + MODES, len(weight)) - 1),
    )
    moves = squares > 1e-12 * squares[-1]
    return squares[moves], shape[:, moves]


def closed_modes(weight: np.ndarray, pull: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same of a closed chain in which no bead is held; weights and ``T/l`` of the link after each bead, (b,).

    Two modes may have one frequency, so that a block of twice as many is iterated by the inverse, in O(b).
    """
    from scipy.sparse import csc_array, eye_array
    from scipy.sparse.linalg import splu

    here = np.arange(len(weight))
    after = np.roll(here, -1)
    beside, own = -pull * weight * weight[after], weight * weight * (pull + np.roll(pull, 1))
    places = np.concatenate([here, here, after]), np.concatenate([here, after, here])
    matrix = csc_array((np.concatenate([own, beside, beside]), places))
    # a tenth of the square of the slowest frequency of an even string of this mass and length
    shift = 4.0 / ((1.0 / weight**2).sum() * (1.0 / pull).sum())
    inverse = splu(matrix + shift * eye_array(len(here), format="csc"))
    block = np.random.default_rng(0).normal(size=(len(here), min(len(here), 2 * MODES + 2)))
    for _ in range(ROUNDS):
        block = np.linalg.qr(inverse.solve(block))[0]
    squares, turned = np.linalg.eigh(block.T @ (matrix @ block))
    kept = slice(1, MODES + 1)  # the first moves it as a whole
    return squares[kept], block @ turned[:, kept]


def directions(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit vectors across all links of a closed chain (d, j), and those of its line or plane (d, d - j); from the normals
    of its links (links, d)."""
    part, axes = np.linalg.eigh(normal.T @ normal / len(normal))
    return axes[:, part < FLAT], axes[:, part >= FLAT]


def along(values: np.ndarray, links: int) -> np.ndarray:
    """Differences of values of beads (b, k) over the links of their chain, (links, k)."""
    return np.roll(values, -1, axis=0)[:links] - values[:links]


def without(vectors: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Vectors (k, d) less their parts along unit normals (k, d)."""
    return vectors - (vectors * normal).sum(axis=1)[:, None] * normal
