"""Forms of the rows of H: each against its rows as a matrix, and one that is added from outside."""

import sys

import numpy as np
import pytest

import lmgcpy as lm
from lmgcpy.contact import register_pair
from lmgcpy.contact.contactor_pairs import disk_disk
from lmgcpy.contact.frames import local_frames
from lmgcpy.scene.contactor import DiskContactor
from lmgcpy.solve.kernels.forms import form

WEIGHT = 0.5


# A toy: the surface of the antagonist moves with half of its velocity, as if a block and tackle stood between them. Its
# rows are n: (n, 0) (-n/2, 0) and t: (t, 0) (-t/2, 0): the bodies do not turn.


def relative_velocity(i, s):
    c, a = s.candidate[i], s.antagonist[i]
    n_x, n_y = s.normal[i, 0], s.normal[i, 1]
    v_x = s.velocity[c, 0] - WEIGHT * s.velocity[a, 0]
    v_y = s.velocity[c, 1] - WEIGHT * s.velocity[a, 1]
    return n_x * v_x + n_y * v_y, n_x * v_y - n_y * v_x


def push(i, s, d):
    c, a = s.candidate[i], s.antagonist[i]
    n_x, n_y = s.normal[i, 0], s.normal[i, 1]
    force = n_x * d[0] - n_y * d[1], n_y * d[0] + n_x * d[1]
    for k in range(2):
        s.velocity[c, k] += s.inverse_mass[c, k] * force[k]
        s.velocity[a, k] -= WEIGHT * s.inverse_mass[a, k] * force[k]


def local_problem(i, s, u, r):
    w = s.inverse_mass[s.candidate[i], 0] + WEIGHT**2 * s.inverse_mass[s.antagonist[i], 0]
    return ((w, 0.0), (0.0, w)), (u[0] - w * r[0], u[1] - w * r[1])


def momentum(start, stop, walls, s):
    for i in range(start, stop):
        n_x, n_y = s.normal[i, 0], s.normal[i, 1]
        force = n_x * s.impulse[i, 0] - n_y * s.impulse[i, 1], n_y * s.impulse[i, 0] + n_x * s.impulse[i, 1]
        for k in range(2):
            s.velocity[s.candidate[i], k] += force[k]
            s.velocity[s.antagonist[i], k] -= WEIGHT * force[k]
    return 0.0


def relative_velocities(start, stop, s, velocity, result):
    for i in range(start, stop):
        n_x, n_y = s.normal[i, 0], s.normal[i, 1]
        v_x = velocity[s.candidate[i], 0] - WEIGHT * velocity[s.antagonist[i], 0]
        v_y = velocity[s.candidate[i], 1] - WEIGHT * velocity[s.antagonist[i], 1]
        result[i, 0], result[i, 1] = n_x * v_x + n_y * v_y, n_x * v_y - n_y * v_x


def rows(s, part):
    frame = local_frames(s.normal[part])
    nothing = np.zeros((len(frame), 2, 1))
    return np.concatenate([frame, nothing, -WEIGHT * frame, nothing], axis=2)


class HalfDisk(DiskContactor):
    """A disk that meets others of its kind through a block and tackle."""

    KIND = "half"


def half_narrow(position_c, shape_c, position_a, shape_a):
    return disk_disk(position_c, shape_c, position_a, shape_a)


@pytest.fixture
def toy(monkeypatch):
    """The toy is known to the table of forms and to one pair of contactors."""
    monkeypatch.setitem(form.FORMS, (2, "toy"), form.written_in(sys.modules[__name__], 2, 2))
    register_pair("half", "half", half_narrow, form="toy")


def meeting():
    """Two bodies that fly at each other, and a third that lies on the second as usual disks do."""
    scene = lm.Scene(dimension=2)
    for x, y, speed, mass, contactor in (
        (-0.0101, 0.0, 1.0, 1.0, HalfDisk(0.01)),
        (0.0101, 0.0, -2.0, 3.0, HalfDisk(0.01)),
        (0.0303, 0.0, -4.0, 2.0, DiskContactor(0.01)),
    ):
        color = "HALF" if isinstance(contactor, HalfDisk) else "DISK"
        scene.add(
            lm.RigidBody([contactor], mass=mass, inertia=1e-4, position=(x, y), velocity=(speed, 0.3 * speed), color=color)
        )
    scene.see("HALF", "HALF", lm.Coulomb(friction=0.3))
    return scene


@pytest.mark.parametrize("solver", [lm.GaussSeidel, lm.AcceleratedGaussSeidel, lm.Newton, lm.Auto])
def test_a_form_from_outside(toy, solver):
    """By hand: W = 1/m_0 + 1/(4 m_1), and the jump v_0 - v_1/2 is stopped along n and slowed by friction across it."""
    sim = lm.Simulation(meeting(), time_step=1e-3, theta=0.5, solver=solver(tolerance=1e-12))
    before = sim.velocities.copy()
    sim.step()
    (r,) = sim.interactions.impulse
    n, t = sim.interactions.frame[0]
    W = 1.0 + WEIGHT**2 / 3.0
    jump = before[0] - WEIGHT * before[1]
    gap = sim.interactions.gap[0]
    r_n = -(jump @ n + max(gap, 0.0) / 1e-3) / W
    r_t = -np.clip(jump @ t / W, -0.3 * r_n, 0.3 * r_n)
    np.testing.assert_allclose(r, [r_n, r_t], rtol=1e-10)
    given = r[0] * n + r[1] * t
    np.testing.assert_allclose(sim.velocities[0] - before[0], given, rtol=1e-10)
    np.testing.assert_allclose(3.0 * (sim.velocities[1] - before[1]), -WEIGHT * given, rtol=1e-10)
    np.testing.assert_array_equal(sim.spins, 0.0)
    np.testing.assert_array_equal(sim.velocities[2], before[2])


def test_the_functions_of_the_toy_agree_with_its_rows(toy):
    agree(lm.Simulation(meeting(), time_step=1e-3).run(steps=1))


def heap(dimension, law, clump=False):
    """Disks or spheres, in the plane with clusters among them and in space if asked, that fall on a floor."""
    scene = lm.Scene(dimension=dimension, gravity=(0.0,) * (dimension - 1) + (-9.81,))
    down = np.eye(dimension)[-1]
    make = lm.disk if dimension == 2 else lm.sphere
    for k in range(6):
        at = 0.021 * k * down + 0.004 * np.eye(dimension)[0] * (k % 2) + 0.0101 * down
        scene.add(make(radius=0.01, position=at, mass=0.1, color="G", spin=(1.0 if dimension == 2 else (1.0, 2.0, 3.0))))
    if dimension == 2:
        pair = [(DiskContactor(0.01), (-0.01, 0.0)), (DiskContactor(0.012), (0.01, 0.004))]
        scene.add(lm.RigidBody(pair, mass=0.2, inertia=1e-5, position=(0.035, 0.013), color="G", spin=2.0))
    if clump:
        pair = [(lm.SphereContactor(0.01), (-0.01, 0.0, 0.0)), (lm.SphereContactor(0.012), (0.01, 0.004, -0.003))]
        start = {"position": (0.035, 0.003, 0.027), "color": "G", "spin": (2, -1, 3), "rotation": (0.5, 0.5, -0.5, 0.5)}
        scene.add(lm.RigidBody(pair, mass=0.2, inertia=(1e-5, 2e-5, 2.5e-5), **start))
    scene.add(lm.wall(point=(0.0,) * dimension, normal=tuple(down), color="W"))
    scene.see("G", "G", law)
    scene.see("G", "W", lm.Coulomb(friction=0.4))
    return scene


def agree(sim):
    """The relative velocities and the momentum of a step are those of the rows as a matrix, to round-off."""
    problem = sim.last_step.problem
    H = problem.interaction_matrix()
    velocity = np.random.default_rng(0).normal(size=problem.system.velocity.shape)
    u = problem.relative_velocities(velocity)
    np.testing.assert_allclose(H @ velocity.ravel(), u.ravel(), rtol=0.0, atol=1e-14 * np.abs(velocity).max() * 10.0)
    r = problem.system.impulse
    assert np.abs(r).max() > 0.0
    np.testing.assert_allclose(H.T @ r.ravel(), problem.momentum().ravel(), rtol=0.0, atol=1e-14 * np.abs(r).sum())


    # the blocks of W on the diagonal, of which the local solves and their velocities come
    inverse, width = problem.inverse_mass.ravel(), r.shape[1]
    rows = H.toarray().reshape(len(r), width, -1)
    for group in problem.by_law:
        wide = group.law.rows(problem.dimension)
        for i in range(group.start, group.stop):
            W = (rows[i, :wide] * inverse) @ rows[i, :wide].T
            if group.form == "lever" and problem.dimension == 3 and not problem.system.deforms:
                s = problem.system
                found = np.diag(s.delassus[i, :wide])
                found[0, 1], found[0, 2:3], found[1, 2:3] = s.coupling[i], s.shear[i, :1], s.shear[i, 1:]
                sure = np.ones_like(W, dtype=bool)
                sure[3:, :] = sure[:, 3:] = False  # couplings of rolling components are made in the kernel
                np.fill_diagonal(sure, True)
                found = np.triu(found) + np.triu(found, 1).T
                np.testing.assert_allclose(found[sure], W[sure], rtol=0.0, atol=1e-13 * np.abs(W).max())


@pytest.mark.default_parameters("False-False-2", "True-False-3")
@pytest.mark.parametrize("dimension", [2, 3, "clump"])
@pytest.mark.parametrize("rolls", [False, True])
@pytest.mark.parametrize("cell", [False, True])
def test_the_functions_of_a_form_agree_with_its_rows(dimension, rolls, cell):
    law = lm.RollingCoulomb(friction=0.3, rolling_friction=0.1) if rolls else lm.Coulomb(friction=0.3)
    scene = heap(3, law, clump=True) if dimension == "clump" else heap(dimension, law)
    if cell:
        edges = scene.periodic(x=0.2)
        edges.impose_rate(xx=-0.5)
    agree(lm.Simulation(scene, time_step=1e-3, on_unconverged="ignore").run(steps=60))
