"""The conformance kit: laws that are wrong on purpose are told from sound ones, by the property that they break."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import textwrap
from pathlib import Path

import broken_laws as broken
import numpy as np
import pytest
import sound_laws as sound

import lmgcpy as lm
import lmgcpy.testing
from lmgcpy.laws import registry
from lmgcpy.testing import PROPERTIES, Nonconformance
from lmgcpy.testing.case import CaseStep, LawCase
from lmgcpy.testing.invariance import declared_dimensions, other_units
from lmgcpy.testing.local_solve import satisfies
from lmgcpy.testing.runs import SmallRun

SOUND = [
    sound.Softening(stiffness=1e3, peak=1e-3, end=3e-3),
    sound.TangentialSpring(friction=0.4, stiffness=1e4),
    sound.Hertz(modulus=1e6),
    sound.Yielding(stiffness=1e4, stress=1e7, section=1e-6),
    sound.Gluey(stress=1e3, length=0.01),
]


@pytest.mark.default_parameters(*(f"test-tangential-spring-{name}" for name in ("compiled", "restart", "units")))
@lmgcpy.testing.conformance(SOUND[1])
def test_sound_laws_conform(check):
    check()


@pytest.mark.long
@lmgcpy.testing.conformance(SOUND[0], *SOUND[2:])
def test_other_sound_laws_conform(check):
    check()


BROKEN = [
    (broken.Forgetful(), "interface", r"commit returned \(.*,\), expected a tuple of 2, one for each state"),
    (broken.NoNumberAtZero(), "finite", r"prepare returned nan, expected a finite number[^$]*\n *gap 0\.0 m"),
    (broken.DividingByGap(), "finite", r"prepare raised ZeroDivisionError[^$]*\n *gap 0\.0 m"),
    (broken.DivergingState(), "finite", "commit returned inf"),
    (broken.Hesitating(), "fixed-point", r"r = react\(W, q\) = .* react\(w I, u - w r\) at w = .* expected r again"),
    (broken.DiagonalOnly(friction=0.3), "general-W", r"at W = \(\(.*\), \(.*\)\) 1/kg, react\(w I, u - w r\)"),
    (broken.WrongSlope(stiffness=1e3), "slope", "expected to lie between the derivatives of react"),
    (broken.SlopeOverTheKink(stiffness=1e3), "slope", "expected to lie between the derivatives of react"),
    (broken.FarReaching(strength=1.0, length=0.01), "reach", r"beyond acts_within\(.*\) = 0\.0 m: expected none"),
    (broken.WrongConic(stiffness=1e3), "conic", "with these r would be"),
    (broken.Pulling(), "push", r"r_n = -.* N s, expected r_n >= 0: it pulls"),
    (broken.PushingWire(), "pull", r"r_n = .* N s, expected r_n <= 0: it pushes"),
    (broken.BeyondItsCone(friction=0.3), "cone", r"expected at most friction \* r_n"),
    (broken.Dilating(friction=0.4), "no-dilatancy", "sliding changes the normal impulse"),
    (broken.CompliantRigid(stiffness=1e3), "rigid", "the law is compliant"),
    (broken.Bouncing(restitution=1.5), "dissipative", r"raises the kinetic energy by r \. \(u- \+ u\+\)/2 = "),
    (broken.Driving(force=1.0), "dissipative", r"r \. u = .* > 0 .*: the law gives energy"),
    (broken.WrongEnergy(stiffness=1e3), "potential", "expected minus the slope of the energy at the predicted gap"),
    (broken.WrongPowerOfStep(stiffness=1e3), "units", r"times times \d.* a power of the time step or of a length is wrong"),
    (broken.ForceForImpulse(strength=10.0), "units", "is declared with another unit than it has"),
    (broken.HiddenLength(), "units", "a number in the law has a hidden unit"),
    (broken.StressAsForce(stress=10.0), "units", "is declared with another unit than it has"),
    (broken.UnreadableUnit(stiffness=1e3), "units", r"'stiffness': Unit 'kip/furlong' holds 'kip', which is not known"),
    (broken.OneWay(friction=0.3), "mirror", "with the tangent reversed react gives"),
    (broken.Boxed(friction=0.3), "isotropy", r"with the tangents turned by \S+ rad react gives"),
    (broken.Counting(), "purity", "changed the global 'CALLS' of broken_laws"),
    (broken.Scattered(stiffness=1e3), "purity", "when it was asked again: it depends on more than its arguments"),
    (broken.Uncompilable(), "compiled", "cannot be compiled"),
    (broken.Overflowing(), "compiled", "prepare, compiled, gives"),
    (broken.Overshooting(), "scene", "steps of a run of four bodies were not solved"),
    (broken.Scattered(stiffness=1e3), "restart", "after a restart from a checkpoint positions differ"),
]


SLOW = (broken.SlopeOverTheKink, broken.StressAsForce, broken.ForceForImpulse)
FIRST = {name: law for law, name, _ in reversed(BROKEN) if not isinstance(law, SLOW)}
"""A law for each property; what others break these break as well."""


@pytest.mark.parametrize(
    ("law", "name", "words"),
    [pytest.param(law, name, *words, marks=[pytest.mark.long] * (law is not FIRST[name])) for law, name, *words in BROKEN],
    ids=[f"{type(law).__name__}-{name}" for law, name, _ in BROKEN],
)
def test_a_broken_law_is_told_by_the_property_that_it_breaks(law, name, words):
    """The message begins with the property and the law, and says the input where there is one."""
    with pytest.raises(Nonconformance, match=words) as caught:
        PROPERTIES[name].check(law)
    assert caught.value.property == name
    assert str(caught.value).startswith(f"{name} of {type(law).__name__}(")
    if name not in ("purity", "scene", "restart") and "kip" not in words:
        for part in ("parameters", "time step", "gap", "velocity before", "W = ", "free velocity u = "):
            assert part in caught.value.given


def test_every_property_has_a_law_that_breaks_it():
    assert {name for _, name, _ in BROKEN} == set(PROPERTIES)


@pytest.mark.long
def test_what_is_sound_in_a_broken_law_holds():
    """Associated friction solves what it says exactly, in its cone, and gives no energy. What slides fast is pushed apart
    before it touches: it acts at a distance that it does not declare."""
    assert lmgcpy.testing.report(broken.Dilating(friction=0.4)).broken == ["reach", "no-dilatancy"]


# ---------------------------------------------------------------------------------------------------- several answers


def stretched(law, W, q):
    """A link at its reference gap, new, with this free velocity."""
    step = CaseStep(gap=0.0, before=(0.0,), W=((W,),), q=(q,))
    return LawCase(law, time_step=1e-3, reference_gap=0.0, reference_length=0.1, birth=0.0, steps=(step,))


def test_a_law_with_several_answers_is_not_asked_for_one_of_them():
    """On the falling branch of the softening wire, h^2 k w a/(b - a) = w/2000: at w = 2 kg the line of the free problem
    crosses its graph once, at w = 20 000 three times, and react takes another crossing."""
    case = stretched(sound.Softening(stiffness=1e3, peak=1e-3, end=3e-3), 2.0, 2.0)
    elongation = case.time_step * case.velocity[0]
    assert 1e-3 < elongation < 3e-3
    w, r, u = 2e4, case.impulse[0], case.velocity[0]
    (again,) = case.react(((w,),), (u - w * r,), case.prepared)
    assert abs(again - r) > 0.1 * abs(r)
    assert satisfies(case, w) == ""


def test_an_answer_that_is_none_is_found_at_the_same_weight():
    case = stretched(sound.Softening(stiffness=1e3, peak=1e-3, end=3e-3), 2.0, 2.0)
    vars(case)["impulse"] = (1.01 * case.impulse[0],)
    assert "expected r again" in satisfies(case, 2e4)
    assert "expected r again" in satisfies(case, 0.2)


def test_units_are_read_in_space_or_in_the_plane():
    """A stress times a length is no force in space, and one per metre of depth in the plane."""
    law = SOUND[-1]
    step = CaseStep(gap=0.0, before=(0.0,), W=((1.0,),), q=(1.0,))
    case = LawCase(law, time_step=1e-3, reference_gap=0.0, reference_length=0.1, birth=0.0, steps=(step,))
    plain = declared_dimensions(law)
    planar = {name: of.in_the_plane() for name, of in plain.items()}

    def longer(strategy):
        return (16.0, 1.0, 1.0)

    assert "impulse[0]" in other_units(case, longer, plain)
    assert other_units(case, longer, planar) == ""


# ------------------------------------------------------------------------------------------------------- what it runs


@pytest.mark.parametrize("law", [lm.Coulomb(friction=0.3), lm.RigidWire()], ids=lambda law: law.NAME)
def test_in_the_small_runs_the_law_is_at_work(law):
    forces = SmallRun(law).run().forces
    assert sum(bool(np.abs(force).max() > 1.0) for force in forces.values()) >= 3


def test_a_law_for_other_contactors_has_no_scene():
    class Elsewhere(lm.Signorini):
        NAME = "test-elsewhere"
        PAIRS = frozenset({("polygon", "polygon")})

    class ForWalls(lm.Signorini):
        NAME = "test-for-walls"
        PAIRS = frozenset({("wall", "disk")})

    assert PROPERTIES["scene"].applies(Elsewhere()) == "the law is for contactors that are not lmgcpy's own"
    assert PROPERTIES["scene"].applies(ForWalls()) == ""
    PROPERTIES["scene"].check(ForWalls())


@pytest.mark.long
def test_the_registry_is_left_as_it_was():
    before = lm.laws.registrations()
    PROPERTIES["restart"].check(SOUND[0])
    assert lm.laws.registrations() == before
    assert SOUND[0].NAME not in registry.names()


# ----------------------------------------------------------------------------------------------------------- its faces

THREE_LINES = """
import lmgcpy.testing
from broken_laws import Bouncing


@lmgcpy.testing.conformance(Bouncing(restitution=1.5), skip=["compiled", "scene", "restart"])
def test_my_law(check):
    check()
"""


@pytest.mark.long
def test_three_lines_make_a_test_of_every_property(tmp_path):
    (tmp_path / "test_mine.py").write_text(THREE_LINES)
    command = [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-p", "broken_laws", "-W", "error", "-v", tmp_path]
    done = subprocess.run(command, cwd=tmp_path, env=with_path(), capture_output=True, text=True)
    assert "test_my_law[test-bouncing-fixed-point] PASSED" in done.stdout
    assert "test_my_law[test-bouncing-dissipative] FAILED" in done.stdout
    assert (
        "E       lmgcpy.testing.case.Nonconformance: dissipative of Bouncing(friction=0, restitution=1.5)" in done.stdout
    )
    assert "1 failed, 9 passed" in done.stdout
    assert "hypothesis" not in done.stdout.split("FAILURES")[1].lower()  # its traceback says nothing to an author
    assert "[test-bouncing-pull]" not in done.stdout  # not declared
    assert "[test-bouncing-scene]" not in done.stdout  # skipped


def with_path():
    """This process's environment, and its import path for a child."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}


def test_a_report_says_what_holds_what_is_broken_and_what_does_not_apply():
    report = lmgcpy.testing.report(broken.PushingWire(), skip=["compiled", "scene", "restart"])
    assert not report.conforms
    assert report.broken == ["conic", "pull"]
    text = str(report)
    assert text.startswith("PushingWire() (law 'test-pushing') breaks conic, pull.\n")
    assert "\nfixed-point   holds           with W = w I: react(w' I, u - w' r) = r for every w'\n" in text
    assert "\ngeneral-W     does not apply  the law has no tangential component\n" in text
    assert "\nscene         does not apply  skipped" in text
    assert "it pushes." in text
    assert "W = (" in text


def test_nothing_is_looked_at_before_the_interface_is_right():
    report = lmgcpy.testing.report(broken.Forgetful())
    assert report.broken == ["interface"]
    assert {finding.outcome for finding in report.findings} == {"broken", "not checked", "does not apply"}


def test_what_cannot_be_looked_at_before_something_else_says_so():
    class Nowhere(lm.Signorini):
        NAME = "test-nowhere"

        @staticmethod
        def react(W, u, prepared):
            return (u[0] * float("nan"),)

    report = lmgcpy.testing.report(Nowhere(), skip=["compiled", "scene", "restart"])
    assert report.broken == ["finite"]
    assert "\nfixed-point   not checked     finite comes first\n" in str(report)


def test_a_class_that_is_no_law_is_the_interfaces_affair():
    class Renamed(lm.Signorini):
        NAME = "test-renamed"

        @staticmethod
        def react(W, q, prepared):
            return (0.0,)

    report = lmgcpy.testing.report(Renamed())
    assert report.broken == ["interface"]
    assert "react must take (W, u, prepared), but it takes (W, q, prepared)" in str(report)


REFUSED = [
    (lambda: lmgcpy.testing.conformance(), TypeError, "conformance takes at least one law"),
    (lambda: lmgcpy.testing.conformance(lm.Coulomb), TypeError, r"with their parameters, as Coulomb\(\.\.\.\), got the cl"),
    (lambda: lmgcpy.testing.conformance("coulomb"), TypeError, "takes laws, as .* got 'coulomb'"),
    (lambda: lmgcpy.testing.report(lm.Signorini), TypeError, r"report takes laws with their parameters, as Signorini\("),
    (lambda: lmgcpy.testing.report(lm.Signorini(), skip=["puhs"]), ValueError, "did you mean 'push'"),
    (lambda: lmgcpy.testing.report(lm.Signorini(), skip="push"), TypeError, r"as skip=\['push'\]"),
]


@pytest.mark.parametrize(("call", "kind", "words"), REFUSED, ids=[str(i) for i in range(len(REFUSED))])
def test_a_wrong_call_gets_a_sentence(call, kind, words):
    with pytest.raises(kind, match=words):
        call()


@pytest.mark.long
def test_lmgcpy_does_not_bring_the_kit_and_the_kit_says_what_it_needs():
    code = """
    import sys
    import lmgcpy
    assert "lmgcpy.testing" not in sys.modules
    assert "hypothesis" not in sys.modules
    sys.modules["hypothesis"] = None
    try:
        import lmgcpy.testing
    except ImportError as error:
        print(error)
    """
    done = subprocess.run([sys.executable, "-c", textwrap.dedent(code)], capture_output=True, text=True, check=True)
    assert done.stdout == 'lmgcpy.testing needs hypothesis and pytest: pip install "lmgcpy[test]"\n'


@pytest.mark.long
def test_what_is_found_is_found_again():
    """The examples do not change from one run to the next."""
    told = []
    for _ in range(2):
        with pytest.raises(Nonconformance) as caught:
            PROPERTIES["fixed-point"].check(broken.Hesitating())
        told.append(str(caught.value))
    assert told[0] == told[1]


def test_the_page_on_conformance_lists_every_property():
    page = (Path(__file__).parents[2] / "docs" / "conformance.md").read_text()
    listed = set(re.findall(r"`([\w-]+)`", " ".join(re.findall(r"^\| (`.*?) \|", page, re.M))))
    assert listed == set(PROPERTIES)
