"""The report of a campaign: its page and its figures."""

import math
import re

import numpy as np
import pytest
from made_up import case, strengths, to_come
from matplotlib.backends.backend_agg import FigureCanvasAgg

from lmgcpy.experiment.campaign.cases import FAILED, CampaignResults
from lmgcpy.experiment.campaign.report import (
    MOST,
    NONE_FINISHED,
    campaign_figures,
    escaped,
    estimate_words,
    parts,
    to_digit,
    write_report,
)
from lmgcpy.experiment.campaign.statistics import Estimate, mean_and_interval, mean_curves

nan = math.nan


def page_of(files):
    return files[0].read_text(encoding="utf-8")


def drawn(results):
    """The figures of a campaign by their names."""
    return {name: figure for of in mean_curves(results) for name, figure in campaign_figures(of)}


def table_below(page, heading):
    """The entries of the first table below a heading."""
    lines = page.split(f"\n{heading}\n")[1].split("\n|", 1)[1].split("\n\n")[0].strip().split("\n")
    rows = [[entry.strip() for entry in re.split(r"(?<!\\)\|", line)] for line in lines]
    return [[entry for entry in row if entry] for row in (rows[0], *rows[2:])]


def test_a_campaign_that_has_ended(tmp_path):
    results = strengths(law=("rigid-wire", "none"), friction=(0.1, 0.3))
    files = write_report(results, tmp_path / "report")
    assert [file.name for file in files] == ["report.md", "strain-deviator.png", "strain-change-of-volume.png"]
    assert all(file.exists() for file in files)
    page = page_of(files)
    assert page.startswith(
        "# Campaign made up\n\n20 cases: 20 finished, 0 failed, 0 to come. Those that ended took 40 s in"
    )
    assert "2 s on the average" in page
    assert "failed\n" not in page
    assert "not at its end" not in page
    head, *rows = table_below(page, "### friction angle [deg]")
    assert head == ["law", "friction", "seeds", "mean", "standard error", "95 % interval"]
    assert [row[:3] for row in rows] == [[law, mu, "5"] for law in ("rigid-wire", "none") for mu in ("0.1", "0.3")]
    values = [case.numbers["friction angle [deg]"] for case in results.cases[:5]]
    assert float(rows[0][3]) == pytest.approx(np.mean(values), abs=0.005)
    assert float(rows[0][4]) == pytest.approx(np.std(values, ddof=1) / math.sqrt(5), abs=0.005)
    assert table_below(page, "## Versions")[1:] == [["lmgcpy", "0.2.0", "20"], ["numpy", "2.1.0", "20"]]
    for file in files[1:]:
        assert f"]({file.name})" in page
        assert file.read_bytes().startswith(b"\x89PNG")


def test_a_campaign_under_way(tmp_path):
    results = strengths(law=("none", "rigid-wire"))
    cases = list(results.cases)
    cases[1] = to_come(cases[1].parameters)
    error = "ValueError: a|b\n of <Scene>"
    cases[2] = case(cases[2].parameters, status=FAILED, error=error, seconds=1.0, versions={"lmgcpy": "0.1"})
    page = page_of(write_report(CampaignResults("half", cases, left_out=1), tmp_path))
    assert "10 cases: 8 finished, 1 failed, 1 to come. Those that ended took 17 s in all, 1.889 s" in page
    assert "not at its end" in page
    assert "A line of cases.jsonl does not count" in page
    assert "| law=none,seed=2 | ValueError: a\\|b of \\<Scene> |" in page
    assert [row[1] for row in table_below(page, "### peak deviator [Pa]")[1:]] == ["3", "5"]
    assert table_below(page, "## Versions")[1:] == [
        ["lmgcpy", "0.2.0", "8"],
        ["lmgcpy", "0.1", "1"],
        ["numpy", "2.1.0", "8"],
    ]


@pytest.mark.parametrize("cases", [[], [to_come({"seed": 0}), case({"seed": 1}, status=FAILED, error="no")]])
def test_no_case_is_finished(tmp_path, cases):
    files = write_report(CampaignResults("begun", cases), tmp_path)
    assert [file.name for file in files] == ["report.md"]
    assert NONE_FINISHED in page_of(files)
    assert "## Results" not in page_of(files)


def test_numbers_that_are_missing_or_none(tmp_path):
    """Seeds without a value do not count; a parameter that a group lacks has a dash."""
    cases = [case({"n": 1, "seed": k}, {"a": value, "b": nan}) for k, value in enumerate((1.0, nan, 3.0, 1e300))]
    cases += [case({"n": 2, "seed": 0}), case({"m": 2, "seed": 0}, {"a": 5.0})]
    page = page_of(write_report(CampaignResults("", cases), tmp_path))
    assert table_below(page, "### a")[1:] == [["1", "–", "2", "2.0", "1.0", "1.0 to 3.0"], ["–", "2", "1", "5", "–", "–"]]
    assert "### b\n\nNo case has a finite value." in page


def test_curves_that_are_left_out_are_named(tmp_path):
    cases = [case({"seed": k}, curves={"": {"x": np.array([k, k + 0.5]), "y": np.zeros(2)}}) for k in (0, 1)]
    files = write_report(CampaignResults("", cases), tmp_path)
    assert len(files) == 1
    assert "* y over x, all cases: the runs have no part of the abscissa in common." in page_of(files)


@pytest.mark.long
def test_names_of_figures_are_safe_and_differ(tmp_path):
    x = np.linspace(0.0, 1.0, 5)
    curve = {"time [s]": x, "../q/p [-]": x, "..//q p": x, "Q/P": x, "$\\frac": x, "é": x}
    files = write_report(CampaignResults("", [case({"seed": 0}, curves={"": curve})]), tmp_path)
    names = ["time-q-p.png", "time-q-p-2.png", "time-Q-P-3.png", "time-frac.png", "time-curve.png"]
    assert [file.name for file in files[1:]] == names
    assert sorted(file.name for file in tmp_path.iterdir()) == sorted(["report.md", *names])


# --------------------------------------------------------------------------------------------------------------- figures


def test_few_groups_are_one_figure():
    figures = drawn(strengths(tests=("x", "z"), law=("none", "rigid-wire"), friction=(0.1, 0.3)))
    assert list(figures) == ["strain-deviator", "strain-change-of-volume"]
    figure = figures["strain-deviator"]
    (axes,), (legend,) = figure.axes, figure.legends
    assert len(axes.lines) == len(axes.collections) == 8
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("strain", "deviator [Pa]")
    assert legend.get_title().get_text() == "law, friction, kind of test"
    assert [text.get_text() for text in legend.get_texts()][:3] == ["none, 0.1, x", "none, 0.1, z", "none, 0.3, x"]
    assert axes.get_title() == "mean of 5 runs, with the 95 % interval"


def test_many_groups_are_a_figure_for_each_value_of_the_first_parameter():
    figures = drawn(strengths(seeds=2, count=(100, 200), law=("a", "b"), friction=(0.1, 0.3, 0.5)))
    names = [f"strain-{column}-count={count}" for column in ("deviator", "change-of-volume") for count in (100, 200)]
    assert list(figures) == names
    figure = figures["strain-deviator-count=200"]
    assert figure.axes[0].get_title() == "count = 200; mean of 2 runs, with the 95 % interval"
    assert figure.legends[0].get_title().get_text() == "law, friction"
    assert len(figure.axes[0].lines) == 6


def test_parts_hold_every_curve_once():
    (of, _) = mean_curves(strengths(seeds=1, one=("same",), a=(1, 2, 3), b=tuple(range(11)), c=("x", "y")))
    found = list(parts(of.curves))
    assert all(len(some) <= MOST for _, some in found)
    assert sorted(id(curve) for _, some in found for curve in some) == sorted(map(id, of.curves))
    assert found[0][0] == {"a": "1", "b": "0"}


def test_one_parameter_of_many_values_is_cut_in_its_order():
    (of, _) = mean_curves(strengths(seeds=1, friction=tuple(range(19))))
    said = [part["friction"] for part, _ in parts(of.curves)]
    assert said == ["0 to 7", "8 to 15", "16 to 18"]


@pytest.mark.long
def test_names_of_figures_have_a_length_that_systems_allow(tmp_path):
    """Two values, as long as they may be, of a column with a long name; parts that read alike are told apart."""
    long = ["a" * 100 + end for end in "bc"]
    results = strengths(seeds=1, first=long, second=long, third=long, fourth=(1, 2))
    cases = [
        case(each.parameters, {}, {"": {"x" * 100: np.arange(2.0), "y" * 100: np.arange(2.0)}}) for each in results.cases
    ]
    names = [file.name for file in write_report(CampaignResults("", cases), tmp_path)[1:]]
    assert len(names) == len(set(names)) == 2
    assert max(map(len, names)) <= 206


def test_one_run_has_no_band_and_no_legend():
    figure = drawn(strengths(seeds=1))["strain-deviator"]
    assert len(figure.axes[0].collections) == 0
    assert not figure.legends
    assert figure.axes[0].get_title() == "one run each"


def test_groups_of_several_sizes_say_theirs():
    results = strengths(seeds=2, law=("a", "b"))
    figure = drawn(CampaignResults("", results.cases[:3]))["strain-deviator"]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["a (2 runs)", "b (1 run)"]
    assert "several runs" in figure.axes[0].get_title()


@pytest.mark.parametrize(
    "laws",
    [
        tuple("abcdefgh"),
        tuple(f"elastic-wire-of-stiffness-{k}e6-and-length-{k}" for k in range(8)),
        ("_hidden", "", "$x$", "a " * 100),
    ],
)
def test_the_legend_is_within_the_figure_and_below_the_axes(laws):
    """Every curve is in it, and there is room left for the axes: 2.5 of at least 4.4 inches."""
    figure = drawn(strengths(seeds=2, law=laws, axes=(("x", "y", "z"),)))["strain-deviator"]
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw_without_rendering()
    legend, axes = figure.legends[0].get_window_extent(renderer), figure.axes[0].get_window_extent(renderer)
    assert len(figure.legends[0].get_texts()) == len(laws)
    assert legend.x0 >= 0.0
    assert legend.x1 <= figure.bbox.width
    assert legend.y0 >= 0.0
    assert legend.y1 <= axes.y0
    assert axes.height >= 2.5 * figure.dpi


# ----------------------------------------------------------------------------------------------------------------- words


@pytest.mark.parametrize(
    ("estimate", "words"),
    [
        (Estimate(123456.7, 2345.6, 119000.0, 128000.0, 5), ["123500", "2300", "119000 to 128000"]),
        (Estimate(30.123, 0.456, 29.3, 31.0, 5), ["30.12", "0.46", "29.30 to 31.00"]),
        (Estimate(-0.001, 0.5, -1.0, 1.0, 5), ["0.00", "0.50", "-1.00 to 1.00"]),
        (Estimate(1.2364e-12, 2e-14, 1.2e-12, 1.3e-12, 5), ["1.236e-12", "2.0e-14", "1.200e-12 to 1.300e-12"]),
        (Estimate(1.2364e12, 2e10, 1.2e12, 1.3e12, 5), ["1.236e+12", "2.0e+10", "1.200e+12 to 1.300e+12"]),
        (Estimate(1000.0, 0.0, 1000.0, 1000.0, 5), ["1000", "0", "1000 to 1000"]),
        (Estimate(1 / 3, 1e-17, 1 / 3, 1 / 3, 5), ["0.333333", "0", "0.333333 to 0.333333"]),
        (Estimate(1 / 3, nan, nan, nan, 1), ["0.333333", "–", "–"]),
    ],
)
def test_estimates_have_two_digits_of_their_error(estimate, words):
    assert estimate_words(estimate) == words


@pytest.mark.parametrize("power", range(-70, 70, 7))
def test_numbers_of_any_size_keep_their_digits(power):
    """Two digits of the error: the rounding is at most a twentieth of it."""
    found = mean_and_interval(10.0**power * np.array([1.0, 2.0, 4.0, 4.5]))
    mean, error, _ = estimate_words(found)
    assert float(mean) == pytest.approx(found.mean, abs=0.051 * found.error)
    assert float(error) == pytest.approx(found.error, rel=0.051)
    assert to_digit(0.0, -power) is not None


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("a|b", r"a\|b"),
        ("a\\|b", r"a\\\|b"),
        ("two\nlines\tof", "two lines of"),
        ("__init__ of bead_count", r"\_\_init\_\_ of bead_count"),
        ("<b> *x* `y`", r"\<b> \*x\* \`y\`"),
    ],
)
def test_signs_of_markdown_are_escaped(text, line):
    assert escaped(text) == line
