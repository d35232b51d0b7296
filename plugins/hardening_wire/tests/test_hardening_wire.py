"""The hardening wire: its curve, the local solve, and wires of it."""

import math
import runpy
from decimal import Decimal, localcontext
from pathlib import Path

import numpy as np
import pytest
from lmgcpy_law_hardening_wire import HardeningWire, elongation, hardening_wire, tension

import lmgcpy as lm
import lmgcpy.testing

EXAMPLE = runpy.run_path(str(Path(__file__).parent.parent / "examples" / "pulled.py"))
ROUND_OFF = 1e-15
"""Relative: four to five units of round-off."""


@lmgcpy.testing.conformance(
    HardeningWire(axial_rigidity=1e4, toe_rigidity=10.0, crimp=0.02),
    HardeningWire(axial_rigidity=1e10, toe_rigidity=0.0, crimp=1e-4),
    HardeningWire(axial_rigidity=50.0, toe_rigidity=50.0, crimp=1.0),
)
def test_it_keeps_what_a_law_promises(check):
    check()


def test_it_is_found_by_name():
    assert lm.laws.get("hardening-wire") is HardeningWire
    assert lm.laws.registrations()["hardening-wire"].distribution == "lmgcpy-law-hardening-wire 1.0.0"


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"axial_rigidity": 0.0, "toe_rigidity": 0.0, "crimp": 0.1}, "axial_rigidity of law 'hardening-wire'"),
        ({"axial_rigidity": 1.0, "toe_rigidity": -1.0, "crimp": 0.1}, "toe_rigidity of law 'hardening-wire'"),
        ({"axial_rigidity": 1.0, "toe_rigidity": 2.0, "crimp": 0.1}, r"must be at most axial_rigidity, 1 N, got 2 N"),
        ({"axial_rigidity": 1.0, "toe_rigidity": 0.5, "crimp": 0.0}, "crimp of law 'hardening-wire'"),
        ({"axial_rigidity": 1.0, "crimp": 0.1}, r"needs toe_rigidity \[N\]"),
    ],
)
def test_wrong_input_is_told_in_a_sentence(given, words):
    with pytest.raises((ValueError, TypeError), match=words):
        HardeningWire(**given)


# ---------------------------------------------------------------------------------------------------------- the curve


@pytest.mark.parametrize("order", [1, 2, 3])
def test_the_remainder_has_all_its_digits(order):
    """Against the exponential series in 60 digits, over 14 decades of x; at order 3 two subtractions above 1/2 cost a
    few more."""
    for x in np.geomspace(1e-12, 1e2, 500):
        with localcontext() as context:
            context.prec = 60
            d = Decimal(float(x))
            e = (-d).exp()
            exact = {1: 1 - e, 2: e - 1 + d, 3: 1 - d + d * d / 2 - e}[order]
            off = abs(Decimal(hardening_wire.remainder(float(x), order)) / exact - 1)
        assert off <= (4 if order == 3 else 1) * ROUND_OFF


def test_the_curve_is_that_of_a_bundle_of_fibres():
    """T(e) = k0 e + (k1 - k0) integral_0^e (e - s) exp(-s/d)/d ds, a fibre that is straight from s on; Gauss, 40
    points."""
    parameters = k0, rise, d = 3.0, 500.0, 0.02
    nodes, weights = np.polynomial.legendre.leggauss(40)
    for e in (1e-4, 0.01, 0.02, 0.1):
        s = 0.5 * e * (nodes + 1.0)
        straight = 0.5 * e * weights @ ((e - s) * np.exp(-s / d) / d)
        assert tension(e, parameters) == pytest.approx(k0 * e + rise * straight, rel=1e-13)
    assert tension(-0.01, parameters) == 0.0
    # long after: a straight wire of k1, longer by (1 - k0/k1) d
    k1 = k0 + rise
    assert tension(2.0, parameters) == pytest.approx(k1 * (2.0 - (1.0 - k0 / k1) * d), rel=1e-15)


def test_elongation_is_the_inverse_of_tension():
    parameters = 3.0, 500.0, 0.02
    for e in np.geomspace(1e-8, 1e3, 60):
        assert elongation(tension(e, parameters), parameters) == pytest.approx(e, rel=1e-14)


# ---------------------------------------------------------------------------------------------------- the local solve


LOADS, GAINS = np.geomspace(1e-20, 1e20, 41), np.geomspace(1e-20, 1e30, 51)


def test_the_local_solve_is_exact():
    """x + gain R_2(x) = load over 40 decades of load and 50 of gain: one Newton step in 160 digits moves x by
    round-off."""
    for load in LOADS:
        for gain in GAINS:
            x = hardening_wire.straightened(float(load), float(gain))
            with localcontext() as context:
                context.prec = 160
                y, g, b = Decimal(x), Decimal(float(gain)), Decimal(float(load))
                e = (-y).exp()
                step = (y + g * (e - 1 + y) - b) / (1 + g * (1 - e))
                assert abs(step / y) <= ROUND_OFF, (load, gain)


def test_five_newton_steps_do(monkeypatch):
    """The bound on the steps only guards: with five the bits are the same everywhere."""
    many = [hardening_wire.straightened(float(load), float(gain)) for load in LOADS for gain in GAINS]
    monkeypatch.setattr(hardening_wire, "STEPS", 5)
    assert many == [hardening_wire.straightened(float(load), float(gain)) for load in LOADS for gain in GAINS]


def test_without_a_toe_it_is_the_elastic_wire():
    """k0 = k1: the same impulse and slope as lmgcpy's own, to round-off, from soft to rigid."""
    for rigidity in (1.0, 1e5, 1e10):
        law, elastic = (
            HardeningWire(axial_rigidity=rigidity, toe_rigidity=rigidity, crimp=0.1),
            lm.ElasticWire(stiffness=rigidity),
        )
        for u in (-1.0, -0.2, 0.3, 5.0):
            given = 0.101, 0.1, (0.0,), 1e-2
            mine = law.prepare(*given, tuple(law.table(np.array([1.0]))[0]), ())
            theirs = elastic.prepare(*given, (rigidity,), ())
            for function in ("react", "slope"):
                answers = [getattr(one, function)(((2.0,),), (u,), p) for one, p in ((law, mine), (elastic, theirs))]
                assert np.ravel(answers[0]) == pytest.approx(np.ravel(answers[1]), rel=1e-14)


# -------------------------------------------------------------------------------------------------------------- wires


def test_a_link_pulled_slowly_follows_the_curve():
    """At theta = 1 the predicted gap is the gap at the end of the step: tension and elongation lie on T(e).

    To the solver's tolerance of 1e-12 of up to 500 N.
    """
    points = EXAMPLE["pull"]()
    law = EXAMPLE["LAW"]
    parameters = law.table(np.array([1.0]))[0]
    assert points[:, 1] == pytest.approx([tension(e, parameters) for e in points[:, 0]], abs=5e-10)
    # and slowly: the load, 1 N a step, is the tension, up to what accelerates 0.1 kg
    assert points[-100:, 1] == pytest.approx(np.arange(400.5, 500.0), abs=0.5)


def test_a_hanging_wire_is_in_balance():
    """100 beads under their weight and 50 N: the strain of each link is that of the weight below it.

    The wire is at rest to 1e-9 of its forces, the tolerance; strains are some 1 %.
    """
    _, strain = EXAMPLE["hang"](100, 50.0)
    assert strain == pytest.approx(EXAMPLE["hang_at_rest"](100, 50.0), abs=1e-8)


def test_the_answer_does_not_depend_on_the_beads():
    """Loaded by 200 N, ten times its weight, a wire of 10 beads is as long as one of 100, but for the weight that
    hangs on its last half link: 10 N of 200 less in the mean of the links, of which a tenth differs, so 0.5 % of the
    tension."""
    few, many = EXAMPLE["hang"](10, 200.0)[1].mean(), EXAMPLE["hang"](100, 200.0)[1].mean()
    assert few == pytest.approx(many, rel=5e-3)
    assert few != pytest.approx(many, rel=1e-6)


def whip(law, *, solver=None):
    """60 beads of 0.01 kg in zigzag, the first held, the last of 5 kg thrown off: taut, slack, and taut again."""
    rng = np.random.default_rng(0)
    angles = rng.uniform(-1.2, 1.2, 59)
    places = np.vstack([[0.0, 0.0], np.cumsum(0.05 * np.stack([np.cos(angles), np.sin(angles)], axis=1), axis=0)])
    scene = lm.Scene(dimension=2, gravity=(0.0, -9.81))
    beads = [
        scene.add(lm.disk(radius=0.005, position=place, mass=5.0 if i == 59 else 0.01, velocity=(5.0 * (i == 59), 0.0)))
        for i, place in enumerate(places)
    ]
    beads[0].fix()
    scene.chain(beads, law, reference_gap=0.04)
    solver = solver or lm.GaussSeidel(tolerance=1e-7, max_iterations=50, force=1.0)
    return lm.Simulation(scene, time_step=1e-3, solver=solver)


@pytest.mark.parametrize("toe", [0.0, 1e-3, 1.0])
@pytest.mark.parametrize("rigidity", [1e2, 1e6, 1e10])
def test_a_wire_is_solved_as_one_block(rigidity, toe):
    """At any stiffness one visit of the block, or two, to 1e-7 of the error of doing nothing, in every step of a whip.

    The identity of energy closes to round-off of the kinetic energy, 62.5 J at the start.
    """
    sim = whip(HardeningWire(axial_rigidity=rigidity, toe_rigidity=toe * rigidity, crimp=0.02))
    for _ in range(150):
        sim.step()
        assert sim.report.status == "converged"
        assert sim.report.iterations <= 2 * sim.report.solves  # again where the tensions call for geometric stiffness
        assert abs(sim.energy.defect) <= 1e-13 * 100.0
    assert sim.interactions.force[:, 0].min() < 0.0


def test_the_block_answers_as_the_links_one_by_one():
    """Both to 1e-10 of the error of doing nothing; forces of 59 links of mass ratio 500 lose some five digits of it."""
    law = HardeningWire(axial_rigidity=1e4, toe_rigidity=10.0, crimp=0.02)
    block = whip(law, solver=lm.GaussSeidel(tolerance=1e-10, force=1.0))
    single = whip(law, solver=lm.GaussSeidel(tolerance=1e-10, max_iterations=1_000_000, wire_blocks=False, force=1.0))
    assert {block.step().status, single.step().status} <= {"converged", "round-off"}
    assert single.report.iterations > 10 * block.report.iterations
    greatest = -block.interactions.force[:, 0].min()
    assert greatest > 1.0
    assert block.interactions.force == pytest.approx(single.interactions.force, abs=1e-5 * greatest)


@pytest.mark.parametrize("rigidity", [1e2, 1e4, 1e6, 1e8, 1e10])
def test_no_stiffness_explodes(rigidity):
    """A straight wire whose last bead of 5 kg is thrown along it at 3 m/s, 22.5 J: it tightens and throws it back.

    Along a line elongations are linear in positions and the step is one of implicit Euler with a convex energy:
    kinetic and stored energy together can only fall. Round-off of positions of 3 m times the tension is below 1e-11 J
    a step.
    """
    scene = lm.Scene(dimension=2)
    beads = [
        scene.add(
            lm.disk(radius=0.005, position=(0.05 * i, 0.0), mass=5.0 if i == 59 else 0.01, velocity=(3.0 * (i == 59), 0.0))
        )
        for i in range(60)
    ]
    beads[0].fix()
    law = HardeningWire(axial_rigidity=rigidity, toe_rigidity=1e-2 * rigidity, crimp=0.02)
    scene.chain(beads, law, reference_gap=0.041)
    sim = lm.Simulation(scene, time_step=1e-3, solver=lm.GaussSeidel(tolerance=1e-6, max_iterations=50))
    energy, speed = [22.5], []
    for _ in range(400):
        sim.step()
        energy.append(sim.energy.mechanical)
        speed.append(sim.velocities[-1, 0])
        assert abs(sim.energy.defect) <= 1e-13 * 22.5
    assert np.diff(energy).max() <= 1e-11
    assert max(speed) <= 3.0 + 1e-12
    if rigidity >= 1e4:  # softer, it is still on its way out
        assert min(speed) < 0.0


def test_a_run_from_a_file_has_the_bits_of_the_whole_run(tmp_path):
    law = HardeningWire(axial_rigidity=1e6, toe_rigidity=1e3, crimp=0.02)
    whole = whip(law).run(steps=60)
    whip(law).run(steps=25, record=tmp_path / "run.h5")
    rest = lm.resume(tmp_path / "run.h5").run(steps=35)
    assert np.array_equal(whole.positions, rest.positions)
    assert np.array_equal(whole.interactions.force, rest.interactions.force)


def test_the_example_draws_its_figure(tmp_path, capsys):
    EXAMPLE["main"](tmp_path)
    told = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in told] == ["one", "wire", "wire", "wire"]
    assert (tmp_path / "hardening_wire.png").stat().st_size > 10_000
    assert math.isfinite(float(told[0].split()[8]))


def test_the_readme_runs(capsys):
    readme = (Path(__file__).parent.parent / "README.md").read_text()
    block = readme.split("```python\n")[1].split("```")[0]
    exec(compile(block, "README.md", "exec"), {})
    assert capsys.readouterr().out == "[29.43 19.62  9.81]\n"
