"""Bodies that overlap at the start: told once, with how many pairs and the worst, and without any influence on the run."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from mixed_scene import mixed_scene

import lmgcpy as lm


def disk(x, y, radius=0.1, **more):
    return lm.disk(**{"radius": radius, "position": (x, y), "mass": 1.0, **more})


def scene(*bodies, law=None):
    made = lm.Scene(dimension=2)
    for body in bodies:
        made.add(body)
    made.see("GRAIN", "GRAIN", law or lm.Coulomb(friction=0.3))
    if any(body.color == "WALL" for body in bodies):
        made.see("GRAIN", "WALL", lm.Signorini())
    return made


def told(made, **options):
    """What the simulation of a scene says of overlaps, None where it says nothing."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        lm.Simulation(made, time_step=1e-3, **options).run(steps=2)
    assert len(caught) <= 1
    if not caught:
        return None
    assert caught[0].category is RuntimeWarning
    assert caught[0].filename == __file__  # the line that made the simulation
    return str(caught[0].message)


def test_the_number_of_pairs_and_the_worst_are_told():
    """Depths 0.02 (20 % of 0.1) and 0.015 (30 % of the smaller radius 0.05): the worst is the one of the larger share."""
    sentence = told(scene(disk(0, 0), disk(0.18, 0), disk(1, 0), disk(1.135, 0, radius=0.05), disk(2, 0), disk(2.3, 0)))
    assert sentence.startswith("2 pairs of bodies overlap at the start by more than 5 % of the smaller radius; the worst: ")
    assert "body 2 ('GRAIN') and body 3 ('GRAIN') by 0.015 m, 30 % of 0.05 m, under the law 'coulomb'" in sentence
    assert sentence.endswith("Move the bodies, or say overlap='ignore'.")


def test_a_disk_in_a_wall_is_told():
    sentence = told(scene(disk(0, 0.04), lm.wall(point=(0, 0), normal=(0, 1))))
    assert "1 pair of bodies overlaps" in sentence
    assert "body 0 ('GRAIN') and body 1 ('WALL') by 0.06 m, 60 % of 0.1 m, under the law 'signorini'" in sentence


def test_clusters_count_as_one_pair_by_the_radius_of_their_parts():
    """Both disks of a dumbbell are in the grain, by a quarter and by half of their radius of 0.04."""
    parts = [(lm.DiskContactor(0.04), (0.0, 0.03)), (lm.DiskContactor(0.04), (0.0, -0.03))]
    dumbbell = lm.RigidBody(parts, mass=1.0, inertia=1e-3, position=(0.12, 0.05), color="GRAIN")
    sentence = told(scene(disk(0, 0), dumbbell))
    assert sentence.startswith("1 pair of bodies overlaps")
    depth = 0.14 - np.hypot(0.12, 0.02)
    assert f"by {depth:.3g} m, {100 * depth / 0.04:.3g} % of 0.04 m" in sentence


@pytest.mark.parametrize(
    "bodies",
    [
        (lambda: (disk(0, 0), disk(0.1951, 0))),  # 4.9 % of the radius
        (lambda: (disk(0, 0), disk(0.1, 0, color="OTHER"))),  # who do not see each other
        (lambda: (disk(0, 0).fix(), disk(0.1, 0).fix())),  # neither can move
        (lambda: (disk(0, 0),)),
    ],
    ids=["shallow", "unseen", "fixed", "alone"],
)
def test_what_is_no_overlap_or_meant_is_not_told(bodies):
    assert told(scene(*bodies())) is None


def test_it_may_be_ignored_or_refused():
    def made():
        return scene(disk(0, 0), disk(0.1, 0))

    assert told(made(), overlap="ignore") is None
    assert "by 0.1 m, 100 % of 0.1 m" in told(made(), overlap="warn")
    refused = made()
    with pytest.raises(ValueError, match="1 pair of bodies overlaps at the start"):
        lm.Simulation(refused, time_step=1e-3, overlap="stop")
    refused.bodies[1].position[0] = 0.2
    lm.Simulation(refused, time_step=1e-3, overlap="stop")


def test_looking_changes_no_bit():
    """The first step and its impulses are those of a simulation that did not look."""
    runs = [
        lm.Simulation(mixed_scene(), time_step=1e-3, overlap=how, on_unconverged="ignore") for how in ("warn", "ignore")
    ]
    for _ in range(30):
        for sim in runs:
            sim.step()
        assert np.array_equal(runs[0].state.positions, runs[1].state.positions)
    assert np.array_equal(runs[0].interactions.impulse, runs[1].interactions.impulse)
    assert runs[0]._detector.rebuilds == runs[1]._detector.rebuilds


def test_a_run_that_goes_on_is_not_told_again(tmp_path):
    path = tmp_path / "run.h5"
    with pytest.warns(RuntimeWarning, match="overlap"):
        sim = lm.Simulation(scene(disk(0, 0), disk(0.1, 0)), time_step=1e-3)
    sim.run(steps=2, record=path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        again = lm.resume(path).run(steps=2)
    assert np.array_equal(again.positions, sim.run(steps=2).positions)


class Forgetful(lm.Signorini):
    """Leaves what turning closed."""

    NAME = "forgetful"

    @staticmethod
    def prepare(gap, reference_gap, velocity, time_step, parameters, state):
        return (max(gap, 0.0) / time_step,)


@pytest.mark.parametrize("overlap", [0.0, 0.2])
def test_a_run_tells_contacts_that_sink_in(overlap):
    """A ball round a pipe sinks by ``(h v)^2/(2 a)`` a step, 0.8 % of its radius, if the law leaves that: it is told when
    it has sunk by a tenth, beyond where it began, with its number."""
    scene = lm.Scene(dimension=3)
    scene.add(lm.cylinder_wall(point=(0, 0, 0), axis=(0, 0, 1), radius=0.5))
    scene.add(lm.sphere(radius=0.1, position=(0.4 + 0.1 * overlap, 0.0, 0.0), velocity=(0.0, 2.0, 0.0), mass=1.0))
    scene.see("GRAIN", "WALL", Forgetful())
    sim = lm.Simulation(scene, time_step=4e-3, overlap="ignore")
    sim.run(steps=10)
    with pytest.warns(RuntimeWarning, match=r"bodies 1 and 0 overlap by [\d.]+ m, [\d.]+ % of the smaller radius") as told:
        sim.run(steps=200)
    share = float(str(told[0].message).split(" m, ")[1].split(" %")[0])
    assert 100.0 * (overlap + 0.1) <= share < 100.0 * (overlap + 0.12)  # of three digits
    assert len(told) == 1


def test_bodies_inside_each_other_stop_unless_they_are_allowed():
    """By 0.11 m, 110 % of the smaller radius: refused by default. At 99 % it is a warning."""

    def made(distance):
        return scene(disk(0, 0, radius=0.2), disk(distance, 0), disk(1, 0))

    with pytest.raises(
        ValueError, match=r"body 0 .* body 1 .* by 0.11 m, 110 % of 0.1 m.* Move the bodies apart, or allow"
    ):
        lm.Simulation(made(0.19), time_step=1e-3)
    assert told(made(0.19), overlap="ignore") is None
    assert "99 % of 0.1 m" in told(made(0.201))


def test_a_body_that_is_added_inside_another_one_is_refused():
    """And the simulation goes on without it; with overlaps ignored it is taken."""
    for overlap in ("warn", "ignore"):
        made = scene(disk(0, 0, radius=0.2))
        sim = lm.Simulation(made, time_step=1e-3, overlap=overlap).run(steps=1)
        if overlap == "warn":
            with pytest.raises(ValueError, match=r"overlaps with what was added .* 110 %"):
                made.add(disk(0.19, 0))
        else:
            made.add(disk(0.19, 0))
        assert len(sim.run(steps=1).positions) == len(made.bodies) == (1 if overlap == "warn" else 2)
