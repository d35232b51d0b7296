"""The continuous model beside the runs: wires, samples and curves whose answer is known, and a small study end to end."""

import csv
import json
import shutil
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

import lmgcpy as lm
from lmgcpy.cli import main
from lmgcpy.continuum import MeasuredCompression, fit_sand, spans_of
from lmgcpy.experiment.box import Sample
from lmgcpy.experiment.continuum import comparison as model
from lmgcpy.experiment.continuum.comparison import Curves, Prediction, driven, mean_curves, miss
from lmgcpy.experiment.continuum.wire import Anchorage, LaidWire, mean_anchorage, measured_anchorage

TINY = ["--laws", "none,elastic-wire,rigid-wire", "--grains", "30", "--beads", "12", "--strain", "5", "--tolerance", "0.1"]


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def constant(laid, span, strength):
    """An anchorage of this wire that does not grow."""
    return Anchorage(laid.width, span, np.zeros(1), np.array([strength]))


def zigzag(links, half_angle, *, slack=0.0, grains=0):
    """A sample whose wire goes along x in links of 1 mm that turn up and down by ``half_angle``; grains are 2 mm wide."""
    step = 1e-3 * np.array([np.cos(half_angle), np.sin(half_angle)])
    moves = np.array([step * (1.0, 1.0 if k % 2 else -1.0) for k in range(links)])
    beads = np.array([2e-3, 5e-3]) + np.vstack([np.zeros(2), np.cumsum(moves, axis=0)])
    box = np.array([beads[-1, 0] + 2e-3, 1e-2])
    extra = np.column_stack([np.linspace(1e-3, box[0] - 1e-3, grains), np.full(grains, 8e-3)])
    radii = np.concatenate([np.full(len(beads), 1e-4), np.full(grains, 1e-3)])
    gap = 1e-3 / (1.0 - slack) - 2e-4
    return Sample(np.vstack([beads, extra]), radii, wires=(len(beads),), reference_gap=gap, box=box)


# --------------------------------------------------------------------------------------------------------- the wire


def test_a_straight_wire_lies_along_its_axis():
    sample = zigzag(10, 0.0, grains=4)
    laid = LaidWire.of(sample)
    np.testing.assert_allclose(laid.direction, [[1.0, 0.0]] * 10, atol=1e-12)
    assert laid.content == pytest.approx(10e-3 / np.prod(sample.box))
    np.testing.assert_allclose(laid.slack, 0.0, atol=1e-12)


def test_links_have_their_own_slack():
    laid = LaidWire.of(zigzag(10, 0.3, slack=0.01, grains=4))
    np.testing.assert_allclose(laid.slack, 0.01, rtol=1e-9)


def test_networks_have_what_was_laid():
    laid = LaidWire.of(zigzag(10, 0.3, grains=4))
    local, held = laid.local(50.0), laid.anchored(50.0, constant(laid, 2e-3, 1e-3))
    assert local.length == held.length == laid.content
    assert held.anchorage.piece(0.0)[0] == 1e-3
    # a span of two links has the mean of both directions: c^2 along x, s^2 along y, and no product
    np.testing.assert_allclose(held.products[4], [np.cos(0.3) ** 2, np.sin(0.3) ** 2, 0.0], atol=0.06)
    strain = np.array([0.01, 0.0, 0.0])
    assert local.stress(strain)[0] == pytest.approx(laid.content * 50.0 * 0.01 * np.cos(0.3) ** 4)


def test_a_sample_without_a_wire_gets_a_sentence():
    sample = Sample(np.array([[1.0, 1.0]]), np.array([0.5]), wires=(), reference_gap=0.0, box=np.array([2.0, 2.0]))
    with pytest.raises(ValueError, match="has no wire"):
        LaidWire.of(sample)


def test_the_mean_of_what_was_measured():
    """At every slip of both; beyond the last of one its last strength counts. If the mean falls, it is levelled."""
    one = Anchorage(5.0, 1.0, np.array([0.0, 0.02]), np.array([2.0, 4.0]))
    other = Anchorage(5.0, 3.0, np.array([0.01, 0.04]), np.array([6.0, 3.0]))
    mean = mean_anchorage([one, other])
    assert (mean.width, mean.span) == (5.0, 2.0)
    np.testing.assert_allclose(mean.slip, [0.0, 0.01, 0.02, 0.04])
    np.testing.assert_allclose(mean.strength, [4.0, 12.5 / 3, 12.5 / 3, 12.5 / 3])  # 4, 4.5, 4.5 and 3.5


def test_anchorage_goes_with_the_square_of_the_width():
    """The mean tension of a wire that is held in proportion to its way along the sand, integrated link by link."""
    stiffness, stretch = 3.0, 0.01  # k [-] and e

    def mean_tension(width):
        s = np.linspace(0.0, 0.5 * width, 20_001)
        tension = np.cumsum((stiffness * stretch * s)[::-1])[::-1] * s[1]  # from the free end inward
        return tension.mean()

    one = Anchorage(0.02, 0.005, np.array([stretch]), np.array([mean_tension(0.02)]))
    other = one.at(0.03)
    assert other.strength[0] == pytest.approx(mean_tension(0.03), rel=1e-3)
    assert other.strength[0] == pytest.approx(stiffness * stretch * 0.015**2 / 3.0, rel=1e-3)
    assert (other.width, other.span) == pytest.approx((0.03, 0.0075))
    assert mean_anchorage([one, other]).strength[0] == pytest.approx(one.at(0.025).strength[0], rel=1e-12)


def test_the_width_is_the_length_of_the_box_along_the_wire():
    laid = LaidWire.of(zigzag(10, 0.3, grains=4))
    along = np.cos(0.3) ** 2
    assert laid.width == pytest.approx(along * laid.box[0] + (1.0 - along) * laid.box[1])
    wider = laid.anchored(50.0, Anchorage(0.5 * laid.width, 1e-3, np.zeros(1), np.array([1e-3])))
    assert wider.anchorage.piece(0.0)[0] == pytest.approx(4e-3)


# ------------------------------------------------------------------------------------------------------- predictions


def sand():
    """A fitted sand: q/p rises to 0.6 within 1 %, and dilates by 0.2 of its shear."""
    crushing = np.linspace(0.0005, 0.1, 200)
    friction, pressure = 0.6 * -np.expm1(-crushing / 0.002), 1e5
    # q = M p, p = p_lateral + q / 2 in 2D
    deviator = friction * pressure / (1.0 - 0.5 * friction)
    stress = np.column_stack([np.full(200, -pressure), -pressure - deviator])
    strain = np.column_stack([1.2 * crushing, -crushing])
    return fit_sand(MeasuredCompression(axis="y", strain=strain, stress=stress)).sand()


def test_without_a_wire_the_sand_is_found_again():
    found = driven(sand(), None, "y", 0.1, 1e5)
    assert found.deviator[-1] == pytest.approx(0.6e5 / 0.7, rel=1e-3)
    assert found.volume[-1] == pytest.approx(0.02, rel=0.02)  # the first moment is not at zero
    assert not found.wire.any()


def test_a_wire_that_is_drawn_taut_confines():
    """All tension at its bound: sigma_xx of the wire is L chi p, and q grows as if the lateral pressure did by that."""
    laid = LaidWire.of(zigzag(10, 0.0, grains=4))
    held = constant(laid, 1e-2, 0.1 / laid.content)
    found = driven(sand(), laid.anchored(1e6, held), "y", 0.1, 1e5)
    # p = (axial + lateral)/2, lateral = p_0 + 0.1 p, axial - lateral = 0.6 p: p = p_0 / (1 - 0.3 - 0.1)
    pressure = 1e5 / 0.6
    assert found.wire[-1, 0] == pytest.approx(0.1 * pressure, rel=2e-3)
    assert found.deviator[-1] == pytest.approx(0.7 * pressure, rel=2e-3)  # axial - p_0


def test_the_rigid_limit_is_reached():
    laid = LaidWire.of(zigzag(10, 0.2, grains=4))
    held, scale = constant(laid, 4e-3, 0.1 / laid.content), 1e5 * 2e-3
    ends = [driven(sand(), laid.anchored(k * model.RIGID * scale, held), "y", 0.08, 1e5).deviator for k in (1.0, 10.0)]
    # where the wire is drawn taut the curves differ by the strain that takes
    assert np.abs(ends[0] - ends[1]).mean() < 0.01 * ends[1].mean()


def test_what_has_no_solution_ends_where_it_does(monkeypatch):
    original = model.biaxial
    monkeypatch.setattr(model, "biaxial", lambda *arguments, **options: fails(original, *arguments, **options))
    assert driven(sand(), None, "y", 0.1, 1e5).crushing[-1] == pytest.approx(0.1 * 76 / 150)


def fails(original, material, strain, **options):
    if -strain[-1] > 0.051:
        error = model.NoSolution()
        error.solved = int(np.count_nonzero(-strain <= 0.051))
        raise error
    return original(material, strain, **options)


def test_the_gain_in_friction_is_that_of_the_contacts():
    """q/p of 0.6 without the wire and of 0.66 beside it, at pressures that differ, whatever the wire bears itself."""
    crushing, records = np.linspace(0.0, 0.1, 101), {}
    for law, friction, pressure in (("none", 0.6, 1e5), ("rigid-wire", 0.66, 1.4e5)):
        # q = M p, p = lateral + q/3 in 3D
        normal = -pressure * np.array([1.0 - friction / 3, 1.0 - friction / 3, 1.0 + 2.0 * friction / 3])
        stress = {"sand": np.tile(np.diag(normal), (101, 1, 1)), "wire": np.ones((101, 3, 3))}
        size = np.exp(np.outer(crushing, [0.5, 0.5, -1.0]))
        records[f"{law}-z"] = SimpleNamespace(axis="z", law=law, stress=stress, size=size, smooth=lambda values: values)
    result = SimpleNamespace(records=records, sample=SimpleNamespace(box=np.ones(3)))
    assert model.friction_gain(result, "rigid-wire-z") == pytest.approx(1.1, rel=1e-12)


@pytest.mark.parametrize("gain", [1.0, 1.1, 0.95])
def test_what_sand_gains_in_friction_goes_into_dilation(gain):
    weak = sand()
    strong = model.stronger(weak, gain)
    for kappa in (0.0, 1e-3, 0.02, 0.2):
        gained = strong.friction(kappa) - weak.friction(kappa)
        assert gained == pytest.approx((gain - 1.0) * weak.friction(kappa), abs=1e-12)
        assert strong.dilatancy(kappa) - weak.dilatancy(kappa) == pytest.approx(gained, abs=1e-12)


def test_sand_that_would_carry_a_deviator_without_pressure_is_none():
    weak = sand()
    limit = 2.0 / (weak.critical + weak.peak)
    assert model.stronger(weak, 0.999 * limit) is not None
    assert model.stronger(weak, 1.001 * limit) is None


def curves(factor=1.0, last=0.1):
    crushing = np.linspace(0.0, last, 50)
    return Curves(
        crushing, factor * 1e5 * crushing, factor * crushing, factor * np.column_stack([1e4 * crushing, crushing])
    )


def test_the_miss_of_a_model():
    one = Prediction("y", "rigid-wire", 0, curves(), curves(), curves(1.2), curves(last=0.05), curves())
    assert miss(one, one.run).deviator == 0.0
    found = miss(one, one.local)
    mean = np.mean(one.judged())
    assert found.deviator == pytest.approx(0.2)
    assert found.volume == pytest.approx(0.2 * mean)
    np.testing.assert_allclose(found.wire, [0.2e4 * mean, 0.2 * mean])
    assert miss(one, one.anchored).deviator == np.inf  # it ended half-way


def test_means_over_seeds_end_with_the_shortest():
    mean, scatter = mean_curves([curves(1.0), curves(2.0, last=0.05)])
    assert mean.crushing[-1] == 0.05
    assert mean.deviator[-1] == pytest.approx(1.5 * 1e5 * 0.05)
    assert scatter.deviator[-1] == pytest.approx(np.sqrt(0.5) * 1e5 * 0.05)
    assert mean_curves([curves()])[1].deviator.max() == 0.0


# ------------------------------------------------------------------------------------------------------- end to end


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    out = tmp_path_factory.mktemp("continuum") / "study"
    done = run("texsol", *TINY, "--seed", "3", "--out", out)
    assert done.exit_code == 0, done.output
    return out


@pytest.mark.long
def test_a_study_is_predicted(study, tmp_path):
    done = run("continuum", study, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.output
    names = ("elastic-wire", "rigid-wire")
    figures = [f"prediction-{name}.png" for name in names]
    assert {path.name for path in (tmp_path / "out").iterdir()} == {*figures, "curves.csv", "errors.csv", "continuum.md"}
    with (tmp_path / "out" / "errors.csv").open() as file:
        rows = list(csv.DictReader(file))
    models = ("local", "anchored", "stronger")
    assert [(row["test"], row["model"]) for row in rows] == [(n, m) for n in names for m in models]
    with (tmp_path / "out" / "curves.csv").open() as file:
        assert len(list(csv.DictReader(file))) == 200
    page = (tmp_path / "out" / "continuum.md").read_text()
    assert "measured in the test elastic-wire; so that this test is no prediction" in page
    again = run("continuum", study, "--out", tmp_path / "out")
    assert again.exit_code == 1
    assert "is not empty" in again.output


@pytest.mark.long
def test_what_is_measured_is_what_the_run_holds(study):
    """All tension, shared out among the stretched spans, over the pressure of the sand, and the mean stretch of the spans
    less the stretch by this tension, from the interactions of the frames by hand."""
    from lmgcpy.experiment import StudyFolder, carry_out_study
    from lmgcpy.experiment.texsol.study import TexSolStudy

    folder = StudyFolder(study, TexSolStudy)
    result = carry_out_study(folder.read(), None, folder, resume=True)
    record, rigidity = result.records["elastic-wire"], result.study.axial_rigidity
    laid, ratios, slips, slip = LaidWire.of(result.sample), [], [], 0.0
    with lm.io.open_run(folder.run_file("elastic-wire")) as test:
        found = measured_anchorage(test, record, result.sample, rigidity)
        spans = spans_of(laid.direction, laid.length, found.span, laid.chain)
        for frame in np.flatnonzero(test.steps > 0):
            net, step = test.interactions(frame), test.steps[frame] - 1
            pull = np.maximum(-net.force[net.law == "elastic-wire", 0], 0.0)
            stretch = spans.products @ np.append(np.log(record.size[step] / result.sample.box), 0.0)
            if pull.any() and (stretch > 0.0).any():
                tension = pull @ laid.length / laid.length[stretch > 0.0].sum()
                ratios.append(tension / (-np.trace(record.stress["sand"][step]) / 2))
                slip = np.maximum(slip, stretch - tension / rigidity)
                slips.append(spans.weights @ slip)
    np.testing.assert_allclose(found.slip, np.unique(slips), rtol=1e-9, atol=1e-15)
    assert found.strength[-1] == pytest.approx(ratios[-1], rel=1e-12)
    by_slip = [np.mean(np.array(ratios)[np.array(slips) == slip]) for slip in np.unique(slips)]
    np.testing.assert_allclose(found.strength, by_slip, rtol=1e-12)
    assert found.span > 0.0


@pytest.mark.long
def test_a_size_is_predicted_from_another(study, tmp_path):
    larger = tmp_path / "larger"
    done = run("texsol", *TINY, "--grains", "60", "--beads", "18", "--out", larger)
    assert done.exit_code == 0, done.output
    done = run("continuum", study, "--measured-in", larger, "--out", tmp_path / "out")
    assert done.exit_code == 0, done.output
    here, there = model.compare([study]), model.compare([larger])
    moved = model.compare([study], source=there)
    held, gain = moved.for_sample(0, "rigid-wire")
    np.testing.assert_array_equal(held.strength, mean_anchorage(there.anchorages).strength)
    assert gain - 1.0 == pytest.approx(here.content / there.content * (there.gains["rigid-wire"][0] - 1.0), rel=1e-12)
    ratio = (here.wires[0].width / there.wires[0].width) ** 2
    assert f"here, by the square of the width, {ratio:.2f} times as much" in (tmp_path / "out" / "continuum.md").read_text()
    # the bound of the wire in the model, in the smaller sample
    network = here.wires[0].anchored(1.0, held)
    assert network.anchorage.piece(1.0)[0] == pytest.approx(ratio * held.strength[-1], rel=1e-12)
    # a source must be of the same kind, and have the test
    other = replace(there.studies[0], friction=0.3)
    for source, words in (
        (SimpleNamespace(studies=[other], gains=there.gains), "differs from the first in friction"),
        (SimpleNamespace(studies=there.studies, gains={}), "has the test elastic-wire, and the studies to measure in have"),
    ):
        with pytest.raises(ValueError, match=words):
            model.compare([study], source=source)


@pytest.mark.long
def test_mistakes_get_sentences(study, tmp_path):
    def told(*folders):
        done = run("continuum", *folders, "--out", tmp_path / "out")
        assert done.exit_code == 1
        return done.output

    assert "There is no study" in told(tmp_path / "nothing")
    lacking = shutil.copytree(study, tmp_path / "lacking")
    (lacking / "runs" / "none.h5").unlink()
    assert "is not complete" in told(lacking)
    assert "cannot be predicted from itself" in told(study, study)
    changes = ("laws", ["rigid-wire"], "fitted to 'none'"), ("friction", 0.3, "differs from the first in friction")
    for field, value, words in changes:
        other = shutil.copytree(study, tmp_path / field)
        about = json.loads((other / "study.json").read_text())
        about["study"][field] = value
        (other / "study.json").write_text(json.dumps(about))
        assert words in told(study, other)
    assert "cannot be predicted from itself" in told(study, "--measured-in", study)
