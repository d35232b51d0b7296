"""Who is the candidate, where the normal points, what a lever is, in which order interactions stand."""

from __future__ import annotations

import numpy as np
import pytest

import lmgcpy as lm


def disk(x, y, color, **more):
    return lm.disk(radius=0.5, position=(x, y), mass=1.0, color=color, **more)


def one_step(bodies, *rows, chains=(), **options):
    """Interactions after one step of 1 ms without gravity."""
    scene = lm.Scene(dimension=2)
    for body in bodies:
        scene.add(body)
    for row in rows:
        scene.see(*row)
    for members, law in chains:
        scene.chain([bodies[i] for i in members], law, neighbours_collide=True)
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-12), **options)
    sim.step()
    return sim


LAW = lm.Coulomb(friction=0.5)


@pytest.mark.parametrize("swap", [False, True])
@pytest.mark.parametrize("first", ["RED", "BLUE"])
def test_with_two_colours_the_candidate_is_the_first_of_see(swap, first):
    """Whatever the ids. The normal points to it."""
    bodies = [disk(0.0, 0.0, "RED"), disk(0.0, 1.01, "BLUE")]
    if swap:
        bodies.reverse()
    second = "BLUE" if first == "RED" else "RED"
    view = one_step(bodies, (first, second, LAW)).interactions
    assert len(view) == 1
    assert bodies[view.candidate[0]].color == first
    assert bodies[view.antagonist[0]].color == second
    assert view.normal[0].tolist() == [0.0, 1.0 if first == "BLUE" else -1.0]
    assert view.gap[0] == pytest.approx(0.01, abs=1e-15)


@pytest.mark.parametrize("swap", [False, True])
def test_with_one_colour_the_candidate_is_the_lower_id(swap):
    bodies = [disk(0.0, 0.0, "RED"), disk(0.0, 1.01, "RED")]
    if swap:
        bodies.reverse()
    view = one_step(bodies, ("RED", "RED", LAW)).interactions
    assert (view.candidate.tolist(), view.antagonist.tolist()) == ([0], [1])
    assert view.normal[0].tolist() == [0.0, 1.0 if swap else -1.0]


def test_a_link_leads_from_one_body_to_the_next():
    bodies = [disk(0.0, 0.0, "RED"), disk(5.0, 0.0, "RED"), disk(0.0, 2.0, "RED")]
    view = one_step(bodies, chains=[((0, 2, 1), lm.RigidRod())]).interactions
    assert view.candidate.tolist() == [2, 1]
    assert view.antagonist.tolist() == [0, 2]
    assert view.normal[0].tolist() == [0.0, 1.0]
    assert view.gap == pytest.approx([1.0, np.hypot(5.0, 2.0) - 1.0])
    # both levers lead to one point on the line between the centres
    assert view.lever[:, 1] - view.lever[:, 0] == pytest.approx(np.array([[0.0, 2.0], [5.0, -2.0]]), abs=1e-15)
    assert np.linalg.det(view.lever) == pytest.approx(0.0, abs=1e-15)


def test_a_frame_is_normal_and_tangent_turned_to_the_left_and_levers_meet():
    """Both levers lead to one point, the middle of the gap."""
    bodies = [disk(0.0, 0.0, "RED"), disk(0.6, 0.85, "BLUE")]
    sim = one_step(bodies, ("BLUE", "RED", LAW))
    view = sim.interactions
    n, t = view.frame[0]
    distance = np.hypot(0.6, 0.85)
    assert n == pytest.approx(np.array([0.6, 0.85]) / distance, abs=1e-15)
    assert t == pytest.approx([-n[1], n[0]], abs=0.0)
    assert view.lever[0, 0] == pytest.approx(-0.5 * distance * n, abs=1e-15)
    assert view.lever[0, 1] == pytest.approx(0.5 * distance * n, abs=1e-15)


def test_the_impulse_pushes_the_candidate_along_the_normal():
    """A disk of 1 kg thrown at 2 m/s onto a held one: 2 N s on the candidate, 2000 N over 1 ms."""
    bodies = [disk(0.0, 0.0, "RED").fix(), disk(0.0, 1.0, "BLUE", velocity=(0.0, -2.0))]
    for row in [("RED", "BLUE", LAW), ("BLUE", "RED", LAW)]:
        bodies = [disk(0.0, 0.0, "RED").fix(), disk(0.0, 1.0, "BLUE", velocity=(0.0, -2.0))]
        sim = one_step(bodies, row, theta=1.0)
        view = sim.interactions
        assert view.impulse[0] == pytest.approx([2.0, 0.0], abs=1e-14)
        assert view.force[0] == pytest.approx([2000.0, 0.0], abs=1e-11)
        assert sim.velocities[1] == pytest.approx([0.0, 0.0], abs=1e-14)


@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_a_wall_as_candidate_is_the_mirror_of_a_wall_as_antagonist(friction):
    """see("WALL", "GRAIN") flips the normal, keeps t to its left, and gives the same motion to the bit."""
    results = []
    for row in [("GRAIN", "WALL"), ("WALL", "GRAIN")]:
        bodies = [lm.wall(point=(0, 0), normal=(0.6, 0.8)), disk(0.3, 0.4, "GRAIN", velocity=(1.0, -2.0), spin=3.0)]
        sim = one_step(bodies, (*row, lm.Coulomb(friction=friction)))
        results.append((sim.interactions, sim.velocities.copy(), sim.spins.copy()))
    (right, v, spin), (flipped, v_flipped, spin_flipped) = results
    assert (right.candidate[0], right.antagonist[0]) == (1, 0)
    assert (flipped.candidate[0], flipped.antagonist[0]) == (0, 1)
    assert right.normal[0] == pytest.approx([0.6, 0.8])
    assert np.array_equal(flipped.frame, -right.frame)
    assert np.array_equal(flipped.lever[0, ::-1], right.lever[0])
    assert np.array_equal(flipped.impulse, right.impulse)
    assert np.array_equal(v, v_flipped)
    assert np.array_equal(spin, spin_flipped)
    assert right.impulse[0, 0] > 0.0


def test_interactions_stand_in_canonical_order():
    """Chains as made, then rows of the table as given, then by the ids of candidate and antagonist."""
    bodies = [disk(1.0 * i, 0.5, color) for i, color in enumerate(["RED", "BLUE", "RED", "RED", "BLUE"])]
    bodies.insert(2, lm.wall(point=(0, 0), normal=(0, 1)))
    rows = [("RED", "WALL", LAW), ("RED", "RED", lm.Signorini()), ("BLUE", "RED", LAW)]
    chains = [((5, 4), lm.RigidWire()), ((0, 1), lm.RigidRod())]
    view = one_step(bodies, *rows, chains=chains).interactions
    found = list(zip(view.law.tolist(), view.candidate.tolist(), view.antagonist.tolist(), strict=True))
    assert found == [
        ("rigid-wire", 4, 5),
        ("rigid-rod", 1, 0),
        ("coulomb", 0, 2),
        ("coulomb", 3, 2),
        ("coulomb", 4, 2),
        ("signorini", 3, 4),
        ("coulomb", 1, 0),
        ("coulomb", 1, 3),
        ("coulomb", 5, 4),
    ]


def test_alert_bounds_the_gap():
    """A pair is an interaction up to the alert distance; the default is a fifth of the smallest radius concerned."""
    for gap, alert, seen in [(0.05, 0.06, 1), (0.05, 0.04, 0), (0.09, None, 1), (0.11, None, 0)]:
        scene = lm.Scene(dimension=2)
        scene.add(disk(0.0, 0.0, "RED"))
        scene.add(disk(0.0, 1.0 + gap, "RED"))
        scene.see("RED", "RED", LAW, alert=alert)
        sim = lm.Simulation(scene, time_step=1e-3)
        sim.step()
        assert len(sim.interactions) == seen


def test_pairs_without_a_free_component_are_not_built():
    bodies = [disk(0.0, 0.5, "RED").fix(), disk(1.0, 0.5, "RED").fix(), lm.wall(point=(0, 0), normal=(0, 1))]
    assert len(one_step(bodies, ("RED", "RED", LAW), ("RED", "WALL", LAW)).interactions) == 0


def test_a_pair_that_cannot_move_along_its_normal_is_not_built():
    """A disk that moves in x only, on a floor: no impulse along y changes anything."""
    bodies = [disk(0.0, 0.5, "RED").fix("y", "spin"), lm.wall(point=(0, 0), normal=(0, 1))]
    assert len(one_step(bodies, ("RED", "WALL", LAW)).interactions) == 0


@pytest.mark.parametrize("again", [("RED", "BLUE"), ("BLUE", "RED")])
def test_a_pair_of_colours_is_seen_once(again):
    """Two rows would be two interactions of the same bodies, each with an impulse of its own: nobody asks for that."""
    bodies = [disk(0.0, 0.0, "RED"), disk(0.0, 1.0, "BLUE")]
    with pytest.raises(ValueError, match=r"'RED' and 'BLUE' touch under Signorini.* already.*Coulomb.* act on the same"):
        one_step(bodies, ("RED", "BLUE", lm.Signorini()), (*again, LAW))


def test_before_the_first_step_there_are_no_interactions():
    scene = lm.Scene(dimension=2)
    scene.add(disk(0.0, 0.5, "RED"))
    view = lm.Simulation(scene, time_step=1e-3).interactions
    assert len(view) == 0
    assert view.frame.shape == (0, 2, 2)
    assert view.normal.shape == view.impulse.shape == (0, 2)
