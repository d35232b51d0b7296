"""Newton's cradle: what the law of restitution makes of shocks at once, and of shocks one after the other."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm

R, SPEED = 0.05, 1.0


def cradle(gap, *, restitution=1.0, time_step=1e-3, theta=0.5, walls=None):
    """The first of five disks of 1 kg comes at 1 m/s from 0.0137 m away; ``gap`` between the others [m]. With ``walls``
    there is one so far [m] beyond each end."""
    scene = lm.Scene(dimension=2)
    places = [-2.0 * R - 0.0137, *((2.0 * R + gap) * i for i in range(4))]
    for i, x in enumerate(places):
        scene.add(lm.disk(radius=R, position=(x, 0.0), mass=1.0, velocity=(SPEED if i == 0 else 0.0, 0.0)))
    scene.see("GRAIN", "GRAIN", lm.Restitution(restitution=restitution))
    if walls is not None:
        scene.add(lm.wall(point=(places[0] - R - walls, 0.0), normal=(1, 0)))
        scene.add(lm.wall(point=(places[-1] + R + walls, 0.0), normal=(-1, 0)))
        scene.see("GRAIN", "WALL", lm.Restitution(restitution=restitution))
    solver = lm.GaussSeidel(tolerance=1e-12, max_iterations=20_000)
    # disks that fly side by side approach by round-off only, and no tolerance is met relative to that
    return lm.Simulation(scene, time_step=time_step, theta=theta, solver=solver, on_unconverged="ignore")


def after(sim, seconds):
    """Velocities along the row after the shocks [m/s], (5,)."""
    sim.run(duration=seconds)
    return sim.velocities[:5, 0].copy()


@pytest.mark.default_parameters(time_step=(4e-3, 5e-4), theta=(0.5,))
@pytest.mark.parametrize("time_step", [4e-3, 2e-3, 1e-3, 5e-4])
@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_disks_that_touch_leave_as_a_block(time_step, theta):
    """Overlaps of 1e-9 m close every contact at once: the first approaches the second at v, all others do not approach.

    Newton's law asks ``u+ = v`` of the first contact and ``u+ >= 0`` of the others, which end at zero: one disk bounces
    elastically from a block of four, v_1 = (1 - 4)/(1 + 4) v and v_2 = ... = v_5 = 2/(1 + 4) v. The energy is kept,
    4 x 0.4^2 + 0.6^2 = 1; tolerance 1e-12 on velocities, over a condition of some 20 of a row of five.
    """
    v = after(cradle(-1e-9, time_step=time_step, theta=theta), 0.1)
    assert v == pytest.approx([-0.6, 0.4, 0.4, 0.4, 0.4], abs=1e-9)
    assert (v**2).sum() == pytest.approx(1.0, abs=1e-9)


@pytest.mark.default_parameters(gap=(1e-12, 1e-4, 1.1e-3), time_step=(2e-3,), theta=(0.5,))
@pytest.mark.parametrize("gap", [1e-12, 1e-9, 1e-6, 1e-4, 9e-4, 1.1e-3, 2.5e-3])
@pytest.mark.parametrize("time_step", [4e-3, 2e-3, 1e-3, 5e-4])
@pytest.mark.parametrize("theta", [0.5, 1.0])
def test_gaps_put_the_shocks_into_steps_of_their_own(gap, time_step, theta):
    """A contact whose gap is open at the detection has no impulse in that step, however small the gap is.

    So in each step one disk hands its velocity to the next: two disks, one equation, exact to round-off.
    """
    v = after(cradle(gap, time_step=time_step, theta=theta), 0.2)
    assert v == pytest.approx([0.0, 0.0, 0.0, 0.0, SPEED], abs=1e-12)


@pytest.mark.default_parameters(time_step=(4e-3,), gap=(1e-9, 2e-3), restitution=(0.5,), theta=(0.5,))
@pytest.mark.parametrize("time_step", [4e-3, 2e-3, 1e-3, 5e-4])
@pytest.mark.parametrize("theta", [0.5, 1.0])
@pytest.mark.parametrize("restitution", [0.5, 0.7, 0.9])
@pytest.mark.parametrize("gap", [1e-9, 1e-6, 1e-4, 2e-3])
def test_with_less_restitution_each_shock_hands_on_its_part(gap, restitution, time_step, theta):
    """Each shock hands on (1 + e)/2 of the velocity: after four of them the last disk has ((1 + e)/2)^4.

    A shock falls where the disks overlap by up to h v, and they part by e h v a step. While the contact opens, though it is
    not yet open, the next shock passes it by. (When it took part, a gap of a micrometre left 0.39 at e = 0.5, not 0.32.)
    With e below 0.45 the first disk, which keeps (1 - e)/2, would come after the last one and push it on.
    """
    v = after(cradle(gap, restitution=restitution, time_step=time_step, theta=theta), 1.0)
    assert v[-1] == pytest.approx((0.5 * (1.0 + restitution)) ** 4, rel=1e-12)


@pytest.mark.long
def test_a_cradle_between_walls_keeps_its_gaps():
    """Ten passes of 0.2 m in 2 s: one disk flies and four rest, as each that is struck moves on by one step."""
    sim = cradle(1e-4, walls=0.1)
    flying = []
    for _ in range(2000):
        sim.step()
        v = sim.velocities[:5, 0]
        assert (v**2).sum() == pytest.approx(1.0, abs=1e-9)
        assert np.sort(np.abs(v)) == pytest.approx([0.0, 0.0, 0.0, 0.0, 1.0], abs=1e-9)
        flying.append(int(np.argmax(np.abs(v))))
    ends = [disk for disk in flying if disk in (0, 4)]
    assert np.count_nonzero(np.diff(ends)) >= 9
