"""Cohesive contact: its strength in tension and in shear, its bonds, and columns of grains."""

import math
import runpy
from pathlib import Path

import numpy as np
import pytest
from lmgcpy_law_cohesive import Cohesive

import lmgcpy as lm
import lmgcpy.testing

H = 1e-3
"""Time step [s]."""
SOLVER = lm.GaussSeidel(tolerance=1e-12)


@lmgcpy.testing.conformance(
    Cohesive(adhesion=3.0, friction=0.5, reach=1e-3),
    Cohesive(adhesion=1e4, friction=5.0, reach=1e-6),
    Cohesive(adhesion=3.0, friction=0.0, reach=1e-3),
)
def test_it_keeps_what_a_law_promises(check):
    check()


def test_it_is_found_by_name():
    assert lm.laws.get("cohesive") is Cohesive
    assert lm.laws.registrations()["cohesive"].distribution == "lmgcpy-law-cohesive 1.0.0"


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"adhesion": -1.0, "friction": 0.3, "reach": 1e-4}, "adhesion of law 'cohesive'.*-1"),
        ({"adhesion": 1.0, "friction": -0.3, "reach": 1e-4}, "friction of law 'cohesive'.*-0.3"),
        ({"adhesion": 1.0, "friction": 0.3, "reach": 0.0}, "reach of law 'cohesive'.*0"),
        ({"adhesion": 1.0, "friction": 0.3}, r"needs reach \[m\]"),
    ],
)
def test_wrong_input_is_told_in_a_sentence(given, words):
    with pytest.raises((ValueError, TypeError), match=words):
        Cohesive(**given)


# ---------------------------------------------------------------------------------------------------- the local solve


def blocks(count=400, seed=1):
    """Random symmetric positive definite W with any coupling, free velocities, friction up to 5, bias and hold."""
    rng = np.random.default_rng(seed)
    for _ in range(count):
        w_nn, w_tt = np.exp(rng.uniform(-3.0, 3.0, 2))
        w_nt = rng.uniform(-0.99, 0.99) * math.sqrt(w_nn * w_tt)
        mu, hold = rng.choice([0.1, 0.5, 5.0]), rng.choice([0.0, 1e-3, 1.0])
        yield ((w_nn, w_nt), (w_nt, w_tt)), tuple(rng.normal(0.0, 1.0, 2)), mu, rng.choice([0.0, 0.5]), hold


def test_the_answer_satisfies_mohr_and_coulomb():
    """Each condition as it stands in the docstring of the law, to 1e-12 of the terms: 1e-2 of that is W's condition.

    Where mu |W_nt| > W_nn there may be no sliding answer on the side that opposes u_t; what the law then returns
    still keeps the cone and u_n (lmgcpy's Coulomb says why), so that opposition is looked at elsewhere.
    """
    kinds = set()
    for W, q, mu, bias, hold in blocks():
        r = np.array(Cohesive.react(W, q, (bias, mu, hold)))
        u = np.array(q) + np.array(W) @ r
        s, v = r[0] + hold, u[0] + bias
        size = 1e-12 * (np.abs(q).sum() + bias + np.abs(W).sum() * (np.abs(r).sum() + hold))
        lightest = min(W[0][0], W[1][1])
        assert s >= 0.0
        assert v >= -size
        assert min(s * lightest, v) <= size
        assert abs(r[1]) <= mu * s + size / lightest
        slides = abs(u[1]) > 1e3 * size
        kinds.add("open" if s == 0.0 else "slide" if slides else "stick")
        if slides and s > 0.0:
            assert abs(r[1]) == pytest.approx(mu * s, rel=1e-9)
            if mu * abs(W[0][1]) < W[0][0]:
                assert r[1] * u[1] < 0.0
    assert kinds == {"open", "slide", "stick"}


def test_without_a_bond_it_is_coulomb_to_the_bit():
    for W, q, mu, bias, _ in blocks():
        assert Cohesive.react(W, q, (bias, mu, 0.0)) == lm.Coulomb.react(W, q, (bias, mu))


def test_a_great_adhesion_takes_no_digits_from_what_sticks():
    """W = I, q = (-0.25, 0.125) kg m/s: r = -q exactly, whatever the hold."""
    for hold in (1.0, 1e6, 1e15):
        assert Cohesive.react(((1.0, 0.0), (0.0, 1.0)), (0.25, 0.125), (0.0, 0.5, hold)) == (-0.25, -0.125)


# ------------------------------------------------------------------------------------------------------------ strength


def apart(force, *, adhesion=10.0, reach=1e-3):
    """Two touching disks of 1 kg, drawn apart by ``force`` each."""
    scene = lm.Scene(dimension=2)
    a, b = (scene.add(lm.disk(radius=0.1, position=(x, 0.0), mass=1.0)) for x in (0.0, 0.2))
    a.impose_force(x=(lambda t: -force(t)) if callable(force) else -force)
    b.impose_force(x=force)
    scene.see("GRAIN", "GRAIN", Cohesive(adhesion=adhesion, friction=0.3, reach=reach))
    return lm.Simulation(scene, time_step=H, solver=SOLVER)


def gap(sim):
    return sim.positions[1, 0] - sim.positions[0, 0] - 0.2


def test_two_disks_hold_up_to_their_adhesion():
    """A force that grows by 1 N/s, 0.001 N a step: at rest up to 10 N, pulled by it exactly; parting from then on."""
    sim = apart(lambda t: t + 9.9)
    for step in range(99):
        sim.step()
        assert -sim.interactions.force[0, 0] == pytest.approx(9.9 + H * (step + 0.5), abs=1e-12)
    assert abs(gap(sim)) < 1e-15
    sim.run(steps=3)
    assert sim.velocities[1, 0] > 0.0
    assert sim.interactions.force[0, 0] == pytest.approx(-10.0, rel=1e-15)


def test_the_bond_pulls_until_it_is_out_of_reach_and_costs_its_work():
    """Drawn by 12 N against 10 N: relative acceleration 2 (12 - 10)/1 kg until the gap passes 1 mm, then 2 12/1 kg.

    From rest v = n h 4 m/s^2 after n steps and the gap at the end of step n is h^2 4 (n^2/2) at theta = 1/2. The bond
    sees the gap predicted for the middle of the next step, half a step ahead: 4 h^2 (n^2 + n)/2, which passes 1 mm
    with step 22. There 10 N has done the work of 10 N times that gap at the end of step 22.
    """
    sim = apart(12.0)
    sim.run(steps=21)
    assert sim.interactions.state["bonded"][0] == 1.0
    sim.step()
    assert sim.interactions.state["bonded"][0] == 0.0
    assert gap(sim) == pytest.approx(4.0 * H**2 * 22**2 / 2.0, rel=1e-9)
    assert sim.energy.total_interactions["cohesive"] == pytest.approx(-10.0 * gap(sim), rel=1e-9)
    speed = sim.velocities[1, 0]
    sim.run(steps=10)
    assert sim.velocities[1, 0] - speed == pytest.approx(10 * H * 12.0, rel=1e-12)
    assert sim.energy.total_interactions["cohesive"] == pytest.approx(-10.0 * 4.0 * H**2 * 22**2 / 2.0, rel=1e-9)


def test_within_reach_the_work_is_stored_and_given_back():
    """Drawn out by half the reach and let go: the bond closes the gap with the work that it took, and holds."""
    sim = apart(lambda t: 12.0 if t < 10 * H else 0.0)
    sim.run(steps=10)
    predicted = gap(sim) + 0.5 * H * (sim.velocities[1, 0] - sim.velocities[0, 0])
    assert sim.energy.stored["cohesive"] == pytest.approx(10.0 * predicted, rel=1e-9)
    sim.run(steps=40)
    assert sim.interactions.state["bonded"][0] == 1.0
    assert np.abs(sim.velocities).max() < 1e-12
    assert abs(gap(sim)) < 1e-12
    assert sim.energy.stored["cohesive"] < 1e-11


def test_a_lost_bond_is_lost_for_good():
    """Torn apart, pressed together again, and drawn apart by less than the adhesion: they part."""
    sim = apart(lambda t: 40.0 if t < 0.02 else (-100.0 if t < 0.05 else 5.0))
    sim.run(steps=20)
    assert sim.interactions.state["bonded"][0] == 0.0
    sim.run(steps=30)
    assert sim.interactions.force[0, 0] == pytest.approx(100.0, rel=1e-9)
    speed = sim.velocities[1, 0]
    sim.run(steps=10)
    assert (sim.interactions.force == 0.0).all()
    assert sim.velocities[1, 0] - speed == pytest.approx(5.0 * 10 * H, rel=1e-9)


def test_contacts_that_come_later_are_not_bonded():
    scene = lm.Scene(dimension=2)
    a = scene.add(lm.disk(radius=0.1, position=(0.0, 0.0), mass=1.0))
    b = scene.add(lm.disk(radius=0.1, position=(0.202, 0.0), mass=1.0, velocity=(-1.0, 0.0)))
    a.fix()
    b.impose_force(x=lambda t: 0.0 if t < 0.01 else 5.0)
    scene.see("GRAIN", "GRAIN", Cohesive(adhesion=10.0, friction=0.3, reach=1e-3))
    sim = lm.Simulation(scene, time_step=H, solver=SOLVER).run(steps=10)
    assert abs(gap(sim)) < 1e-12
    assert list(sim.interactions.state["bonded"]) == [0.0]
    sim.run(steps=10)
    assert sim.velocities[1, 0] == pytest.approx(5.0 * 10 * H, rel=1e-9)


@pytest.mark.parametrize("friction", [0.2, 0.8, 3.0])
@pytest.mark.parametrize("normal", [-9.0, 0.0, 5.0, 200.0])
def test_a_block_slides_at_mohr_and_coulombs_strength(normal, friction):
    """Pressed by N (drawn, where negative) against c = 10 N: at rest under 0.999 mu (N + c), and under 1.1 of it
    sliding with the acceleration 0.1 mu (N + c)/m. The block is a disk of 2 kg that cannot turn; the bond holds
    on."""
    strength = friction * (normal + 10.0)

    def slide(part):
        scene = lm.Scene(dimension=2)
        block = scene.add(lm.disk(radius=0.1, position=(0.0, 0.1), mass=2.0))
        block.fix("spin")
        block.impose_force(x=part * strength, y=-normal)
        scene.add(lm.wall(point=(0.0, 0.0), normal=(0, 1)))
        scene.see("GRAIN", "WALL", Cohesive(adhesion=10.0, friction=friction, reach=1e-3))
        return lm.Simulation(scene, time_step=H, solver=SOLVER).run(steps=20)

    still, sliding = slide(0.999), slide(1.1)
    assert np.abs(still.velocities[0]).max() < 1e-13
    assert still.interactions.force[0] == pytest.approx([normal, 0.999 * strength], rel=1e-9, abs=1e-9)
    assert sliding.velocities[0] == pytest.approx([20 * H * 0.1 * strength / 2.0, 0.0], rel=1e-9, abs=1e-12)
    assert sliding.interactions.force[0] == pytest.approx([normal, strength], rel=1e-9, abs=1e-9)
    assert sliding.interactions.state["bonded"][0] == 1.0


@pytest.mark.parametrize("adhesion", [29.0, 30.0])
def test_grains_hang_by_their_bonds(adhesion):
    """Three grains of 1 kg below a ceiling: 29.43 N at the top. 30 N hold them, each bond by the weight below it; 29
    N do not, and they fall as one, the lower bonds without a force once the upper one is gone."""
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    for i in range(3):
        scene.add(lm.disk(radius=0.1, position=(0.0, -0.1 - 0.2 * i), mass=1.0))
    scene.add(lm.wall(point=(0.0, 0.0), normal=(0, -1)))
    law = Cohesive(adhesion=adhesion, friction=0.3, reach=1e-4)
    scene.see("GRAIN", "GRAIN", law)
    scene.see("GRAIN", "WALL", law)
    # falling freely there is nothing to solve but round-off
    sim = lm.Simulation(scene, time_step=H, solver=SOLVER, on_unconverged="ignore").run(steps=60)
    if adhesion == 30.0:
        forces = sorted(-sim.interactions.force[:, 0])
        assert forces == pytest.approx([9.81, 2 * 9.81, 3 * 9.81], rel=1e-9)
        assert np.abs(sim.velocities).max() < 1e-12
    else:
        sim.run(steps=60)
        fallen = sim.velocities[:3, 1].copy()
        sim.run(steps=10)
        assert sim.velocities[:3, 1] - fallen == pytest.approx(-9.81 * 10 * H, rel=1e-9)
        assert sorted(sim.interactions.state["bonded"])[-2:] == [1.0, 1.0]


# ---------------------------------------------------------------------------------------------------------- assemblies


def crash(turn=0.0):
    """A bonded hexagon of seven disks thrown at a wall at 2 m/s, so that some bonds break; the whole turned by an
    angle."""
    c, s = math.cos(turn), math.sin(turn)
    rotation = np.array([[c, -s], [s, c]])
    scene = lm.Scene(dimension=2)
    places = [
        (0.0, 0.0),
        *((0.2 * math.cos(k * math.pi / 3 + 0.2), 0.2 * math.sin(k * math.pi / 3 + 0.2)) for k in range(6)),
    ]
    for place in places:
        velocity = rotation @ (2.0, -1.0)
        scene.add(lm.disk(radius=0.1, position=rotation @ place, mass=1.0, velocity=velocity, spin=1.0))
    scene.add(lm.wall(point=rotation @ (0.32, 0.0), normal=rotation @ (-1.0, 0.0)))
    scene.see("GRAIN", "GRAIN", Cohesive(adhesion=200.0, friction=0.5, reach=1e-3), alert=0.02)
    scene.see("GRAIN", "WALL", lm.Coulomb(friction=0.3), alert=0.02)
    # in flight the bonds carry next to nothing, and what a solver can do ends at round-off: it goes on to there
    solver = lm.GaussSeidel(tolerance=1e-13, max_iterations=100_000)
    return lm.Simulation(scene, time_step=H, solver=solver, on_unconverged="ignore")


def test_a_crash_closes_its_energy_and_breaks_some_bonds():
    """Kinetic energy is 17.5 + 7 0.005/2 J; the identity closes to its round-off, and bonds and friction only take."""
    sim = crash()
    bonds = []
    kinetic = sim.energy.kinetic
    for _ in range(60):
        sim.step()
        bonds.append(np.nansum(sim.interactions.state["bonded"]))
        assert abs(sim.energy.defect) <= 1e-14 * kinetic
    assert bonds[0] == 12
    assert 0 < bonds[-1] < 12
    assert (np.diff(bonds) <= 0).all()
    assert sim.energy.kinetic < kinetic


def test_a_crash_that_is_turned_is_the_same_crash():
    """By 0.7 rad, 60 steps of a few breaks: to 1e-9 m/s, what round-off of 1e-16 and the solver's 1e-13 grow to."""
    straight, turned = crash().run(steps=60), crash(0.7).run(steps=60)
    c, s = math.cos(0.7), math.sin(0.7)
    assert turned.velocities[:7] == pytest.approx(straight.velocities[:7] @ np.array([[c, s], [-s, c]]), abs=1e-9)
    assert turned.spins[:7] == pytest.approx(straight.spins[:7], abs=1e-8)
    assert np.array_equal(turned.interactions.state["bonded"], straight.interactions.state["bonded"], equal_nan=True)


def test_a_run_from_a_file_has_the_bits_of_the_whole_run(tmp_path):
    whole = crash().run(steps=60)
    half = crash().run(steps=20, record=tmp_path / "run.h5")
    rest = lm.resume(tmp_path / "run.h5").run(steps=40)
    assert np.nansum(whole.interactions.state["bonded"]) < np.nansum(half.interactions.state["bonded"])
    assert np.array_equal(whole.positions, rest.positions)
    assert np.array_equal(whole.interactions.state["bonded"], rest.interactions.state["bonded"], equal_nan=True)


def test_a_cut_stands_with_cohesion_and_falls_without(tmp_path):
    """The study of the README with half the grains, for 0.3 s: the foot is out by grains, or nine in ten have not
    moved by a hundredth of one (some lie loose at the cut)."""
    example = runpy.run_path(str(Path(__file__).parent.parent / "examples" / "cut.py"))
    falls, stands = cuts = example["study"](count=200, steps=300, adhesions=(0.0, 100.0))
    grain = 2.0 * falls.radii.mean()
    assert falls.toe > 5.0 * grain
    moved = np.linalg.norm(stands.sim.positions[:200] - stands.start, axis=1)
    assert np.quantile(moved, 0.9) < 0.01 * grain
    assert len(stands.bonds) > 300
    assert 10.0 < example["estimate"](stands) < 100.0
    assert "100" in example["table"](cuts)
    example["figure"](cuts).savefig(tmp_path / "cut.png")
    assert (tmp_path / "cut.png").stat().st_size > 10_000


def test_the_readme_runs(capsys):
    readme = (Path(__file__).parent.parent / "README.md").read_text()
    block = readme.split("```python\n")[1].split("```")[0]
    exec(compile(block, "README.md", "exec"), {})
    assert capsys.readouterr().out == "[-0.1 -0.3 -0.5]\n"
