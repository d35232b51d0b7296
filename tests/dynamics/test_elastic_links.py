"""Springs between two free beads: the damped oscillation that the scheme makes of them, digit by digit.

With w = 1/m_1 + 1/m_2, the elongation at the detection y = g_m - g_ref and U = h u_n, one step reads

    U' = U + w h r,   h r = -h^2 k (y + U') - h c U'      (Voigt; c = 0 for the elastic link)
    y' = y + U'

for every theta, as q_m moves by h u_n from step to step. With O = w h^2 k and D = w h c this is a linear map of (y, U)

    U' = (U - O y) / (1 + O + D),     y' = y + U'

of determinant 1/(1 + O + D) and trace 1 + (1 - O)/(1 + O + D). For c = 0 its eigenvalues are 1/(1 -+ i sqrt(O)): the
amplitude falls by 1/sqrt(1 + (h omega)^2) a step and the phase turns by atan(h omega), as with implicit Euler.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import lmgcpy as lm

M1, M2, R, GAP = 1.0, 2.5, 0.05, 0.3
W = 1.0 / M1 + 1.0 / M2


def pair(law, *, time_step, stretch, speed=0.0, theta=0.5, tolerance=1e-14):
    """Two beads on a line, their gap ``stretch`` beyond the reference of 0.3 m, parting at ``speed``."""
    scene = lm.Scene(dimension=2)
    a = scene.add(lm.disk(radius=R, position=(0.0, 0.0), mass=M1))
    b = scene.add(lm.disk(radius=R, position=(2 * R + GAP + stretch, 0.0), mass=M2, velocity=(speed, 0.0)))
    scene.chain([a, b], law, reference_gap=GAP)
    return lm.Simulation(scene, time_step=time_step, theta=theta, solver=lm.GaussSeidel(tolerance=tolerance))


def series(sim, steps):
    """Elongation at the detection and the relative velocity, at each of so many steps, (steps, 2)."""
    found = []
    for _ in range(steps):
        u = sim.velocities[1, 0] - sim.velocities[0, 0]
        sim.step()
        found.append((sim.interactions.gap[0] - GAP, u))
    return np.array(found)


def powers(h, stiffness, viscosity, start, steps):
    """The same from the eigenvalues and eigenvectors of the map in the head of this file."""
    O, D = W * h**2 * stiffness, W * h * viscosity
    step = np.array([[1.0 - O / (1.0 + O + D), 1.0 / (1.0 + O + D)], [-O / (1.0 + O + D), 1.0 / (1.0 + O + D)]])
    values, vectors = np.linalg.eig(step.astype(complex))
    parts = np.linalg.solve(vectors, np.array([start[0], h * start[1]], dtype=complex))
    n = np.arange(steps)[:, None]
    found = (values**n * parts) @ vectors.T
    return np.column_stack([found[:, 0].real, found[:, 1].real / h])


@pytest.mark.default_parameters("voigt-10.0-0.5")
@pytest.mark.parametrize("theta", [0.5, 0.8, 1.0])
@pytest.mark.parametrize("stiffness", [10.0, 1e3, 1e6])
@pytest.mark.parametrize(
    ("make", "viscosity"),
    [(lambda k, c: lm.ElasticRod(stiffness=k), 0.0), (lambda k, c: lm.VoigtRod(stiffness=k, viscosity=c), 7.0)],
    ids=["elastic", "voigt"],
)
def test_the_motion_is_that_of_the_linear_map(make, viscosity, stiffness, theta):
    """200 steps at h omega = 0.037, 0.37 and 12, to 1e-10 of the start: amplitude and phase alike.

    Positions are rounded at 1e-16 m; over h, at 200 steps and O up to 140, that is some 1e-11 of the 0.01 m.
    """
    h, steps, start = 1e-2, 200, (0.01, 0.05)
    stretch = start[0] - (1.0 - theta) * h * start[1]  # so that the first detection sees start[0]
    sim = pair(make(stiffness, viscosity), time_step=h, stretch=stretch, speed=start[1], theta=theta)
    found = series(sim, steps)
    expected = powers(h, stiffness, viscosity, start, steps)
    scale = np.array([abs(start[0]) + h * abs(start[1]), (abs(start[0]) + h * abs(start[1])) / h])
    assert (np.abs(found - expected) / scale).max() < 1e-10


def test_amplitude_and_phase_a_step():
    """Read off the motion itself: (y, U) turns as (1/(1 - i h omega))^n, whose modulus and angle are as documented.

    Two steps give the map, and the map its eigenvalues; at h omega = 0.37 all digits but three are left: 1e-10.
    """
    h, k = 1e-2, 1e3
    motion = series(pair(lm.ElasticRod(stiffness=k), time_step=h, stretch=0.01, speed=0.05), 3) * [1.0, h]
    step = np.linalg.solve(motion[:2], motion[1:]).T
    eigenvalue = np.linalg.eigvals(step)[0]
    omega = math.sqrt(W * k)
    assert abs(eigenvalue) == pytest.approx(1.0 / math.sqrt(1.0 + (h * omega) ** 2), rel=1e-10)
    assert abs(np.angle(eigenvalue)) == pytest.approx(math.atan(h * omega), rel=1e-10)


@pytest.mark.long
def test_the_period_is_right_in_the_limit():
    """atan(h omega)/h = omega (1 - (h omega)^2/3 ...): the frequency is of second order; zeros of y are counted.

    Of 6 half periods the step leaves an uncertainty of one step in 5000.
    """
    k, h = 1e3, 1e-4
    omega = math.sqrt(W * k)
    y = series(pair(lm.ElasticRod(stiffness=k), time_step=h, stretch=0.01), round(6.6 * math.pi / omega / h))[:, 0]
    crossings = np.flatnonzero(np.diff(np.sign(y)))
    assert len(crossings) == 7
    half = (crossings[-1] - crossings[0]) * h / 6
    assert half == pytest.approx(math.pi / omega, rel=1e-3)


def test_a_stiff_spring_does_not_explode():
    """What made the paper give elastic wires up. At h omega up to 1e6 the amplitude only falls."""
    for k in (1e4, 1e8, 1e16):
        sim = pair(lm.ElasticWire(stiffness=k), time_step=1e-2, stretch=0.01)
        fastest = 0.0
        for _ in range(50):
            sim.step()
            fastest = max(fastest, abs(sim.velocities[1, 0] - sim.velocities[0, 0]))
        # never faster than it takes to close the elongation within a step
        assert fastest <= 0.01 / 1e-2 * (1.0 + 1e-9)


def swing(law, steps=700):
    """A bead on a slack wire, thrown upwards, that falls into the wire and swings; positions at each step."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    a = scene.add(lm.disk(radius=R, position=(0.0, 0.0), mass=1.0)).fix()
    b = scene.add(lm.disk(radius=R, position=(0.7, 0.1), mass=1.0, velocity=(0.0, 1.0)))
    scene.chain([a, b], law, reference_gap=0.9)
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-13))
    path = []
    for _ in range(steps):
        sim.step()
        path.append(sim.positions[1].copy())
    return np.array(path)


@pytest.mark.long
def test_the_elastic_wire_tends_to_the_rigid_one():
    """As k grows: the compliance 1/(h^2 k) enters the answer beside W, so the difference falls as 1/k.

    Each hundredfold k takes the difference down a hundredfold, until round-off.
    """
    rigid = swing(lm.RigidWire())
    assert np.hypot(*rigid.T).max() == pytest.approx(1.0, rel=1e-5)
    difference = [np.abs(swing(lm.ElasticWire(stiffness=k)) - rigid).max() for k in (1e8, 1e10, 1e12)]
    ratios = np.divide(difference[:-1], difference[1:])
    assert ratios == pytest.approx([100.0, 100.0], rel=0.1)
    assert difference[-1] < 1e-6


@pytest.mark.parametrize("make", [lm.ElasticWire, lm.ElasticRod])
def test_a_slack_wire_pulls_nothing_and_a_rod_pushes(make):
    sim = pair(make(stiffness=1e3), time_step=1e-3, stretch=-0.02)
    sim.step()
    impulse = sim.interactions.impulse[0, 0]
    if make is lm.ElasticWire:
        assert impulse == 0.0
    else:
        # r = h k 0.02 / (1 + w h^2 k)
        assert impulse == pytest.approx(1e-3 * 1e3 * 0.02 / (1.0 + W * 1e-6 * 1e3), rel=1e-12)


def test_a_voigt_wire_that_is_drawn_taut_does_not_push():
    """Drawn from slack into tension and back: tension only, momentum kept, and never faster apart than it was thrown."""
    sim = pair(lm.VoigtWire(stiffness=1e3, viscosity=50.0), time_step=1e-3, stretch=-0.01, speed=2.0)
    tensions = []
    for _ in range(300):
        sim.step()
        tensions.append(-sim.interactions.impulse[0, 0])
        assert [M1, M2] @ sim.velocities[:, 0] == pytest.approx(5.0, abs=1e-12)
        assert sim.velocities[1, 0] - sim.velocities[0, 0] <= 2.0 + 1e-12
    tensions = np.array(tensions)
    assert (tensions >= 0.0).all()
    assert (tensions > 0.0).any()
    assert tensions[-1] == 0.0
    # it has thrown the beads back, with less than it was given
    assert -2.0 < sim.velocities[1, 0] - sim.velocities[0, 0] < -0.1


def test_stored_energy_is_that_of_the_spring():
    """k e^2/2 at the predicted elongation e; a heavily damped spring ends with all of it gone."""
    # at rest the error of doing nothing is itself round-off: no tight tolerance relative to it can be asked for
    sim = pair(lm.ElasticRod(stiffness=1e3), time_step=1e-2, stretch=0.01, tolerance=1e-3)
    sim.step()
    u = sim.velocities[1, 0] - sim.velocities[0, 0]
    e = sim.interactions.gap[0] - GAP + 1e-2 * u
    assert sim.energy.stored == {"elastic-rod": pytest.approx(0.5 * 1e3 * e**2, rel=1e-12)}
    assert sim.energy.mechanical == pytest.approx(sim.energy.kinetic + 0.5e3 * e**2, rel=1e-12)
    sim.run(steps=500)
    assert sim.energy.mechanical < 1e-12
