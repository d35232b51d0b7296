"""The tables of a campaign: what is in them, and that Parquet and CSV hold the same."""

import csv
import errno
import math
import sys

import numpy as np
import pytest
from made_up import case, to_come

from lmgcpy.experiment.campaign.cases import FAILED, CampaignResults, in_words
from lmgcpy.experiment.campaign.report import file_word
from lmgcpy.experiment.campaign.tables import cases_table, has_pyarrow, name_and_unit, write_tables

THIRD = 1.0 / 3.0


def example():
    """Parameters of all kinds, cases that lack something, curves of two kinds."""
    curve = {"strain": np.array([0.0, 0.1, THIRD]), "deviator [Pa]": np.array([0.0, THIRD * 1e5, math.nan])}
    fall = {"time [s]": np.array([0.0, 1e-9]), "height [m]": np.array([1.0, 2.0])}
    first = {"count": 200, "axes": ("x", "z"), "law": "rigid-wire", "mu": 0.3, "roll": True, "size": 1, "seed": 0}
    second = {"count": 400, "axes": "z", "law": None, "mu": 1, "roll": False, "size": "big", "seed": 1}
    cases = [
        case(first, {"peak deviator [Pa]": THIRD, "steps": 60.0}, {"x": curve, "z": fall}),
        case(second, {"steps": 1e300}, {"": curve}),
        case({"count": 1}, status=FAILED, error='ValueError: "a", b', versions={"lmgcpy": "0.1"}),
        to_come({"count": 2}),
    ]
    return CampaignResults("example", cases)


def read_csv(path):
    with open(path, newline="", encoding="utf-8") as file:
        head, *rows = csv.reader(file)
    return head, [dict(zip(head, row, strict=True)) for row in rows]


@pytest.fixture
def without_pyarrow(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)


@pytest.fixture
def pq():
    return pytest.importorskip("pyarrow.parquet")


def test_cases_in_parquet(tmp_path, pq):
    cases, _ = write_tables(example(), tmp_path / "new" / "folder")
    table = pq.read_table(cases)
    parameters = ["count", "axes", "law", "mu", "roll", "size", "seed"]
    others = ["status", "seconds", "error", "peak deviator", "steps", "version of lmgcpy", "version of numpy"]
    assert table.column_names == ["case", *parameters, *others]
    kinds = {field.name: str(field.type) for field in table.schema}
    assert [kinds[name] for name in parameters] == ["int64", "string", "string", "double", "bool", "string", "int64"]
    assert {field.name: field.metadata for field in table.schema if field.metadata} == {
        "seconds": {b"unit": b"s"},
        "peak deviator": {b"unit": b"Pa"},
    }
    first, second, third, last = table.to_pylist()
    assert (first["axes"], first["size"], first["mu"], first["roll"]) == ("x+z", "1", 0.3, True)
    assert (second["axes"], second["size"], second["law"], second["mu"]) == ("z", "big", None, 1.0)
    assert first["peak deviator"] == THIRD
    assert second["peak deviator"] is None
    assert (third["status"], third["error"], third["version of numpy"]) == ("failed", 'ValueError: "a", b', None)
    assert (last["status"], last["seconds"], last["axes"], last["version of lmgcpy"]) == ("to come", 0.0, None, None)


def test_curves_in_parquet(tmp_path, pq):
    """A value that is NaN is one; one that the curve does not have is null."""
    _, curves = write_tables(example(), tmp_path)
    table = pq.read_table(curves)
    assert table.column_names == ["case", "test", "strain", "deviator", "time", "height"]
    units = [field.metadata[b"unit"].decode() if field.metadata else "" for field in table.schema]
    assert units == ["", "", "", "Pa", "s", "m"]
    rows = table.to_pylist()
    assert [row["test"] for row in rows] == ["x", "x", "x", "z", "z", "", "", ""]
    assert len({row["case"] for row in rows}) == 2
    assert rows[1] == {**rows[0], "strain": 0.1, "deviator": THIRD * 1e5}
    assert math.isnan(rows[2]["deviator"])
    assert (rows[3]["strain"], rows[3]["time"], rows[4]["time"], rows[4]["height"]) == (None, 0.0, 1e-9, 2.0)


def test_csv_holds_the_same(tmp_path, pq, request):
    """All digits, so that the numbers are the same bits."""
    parquet = write_tables(example(), tmp_path)
    request.getfixturevalue("without_pyarrow")
    assert not has_pyarrow()
    texts = write_tables(example(), tmp_path)
    assert [path.name for path in texts] == ["cases.csv", "curves.csv"]
    for binary, text in zip(parquet, texts, strict=True):
        table = pq.read_table(binary)
        units = {f.name: f" [{f.metadata[b'unit'].decode()}]" if f.metadata else "" for f in table.schema}
        head, rows = read_csv(text)
        assert head == [name + unit for name, unit in units.items()]
        assert len(rows) == table.num_rows
        for row, expected in zip(rows, table.to_pylist(), strict=True):
            for name, value in expected.items():
                entry = row[name + units[name]]
                if value is None or isinstance(value, (str, bool)):
                    assert entry == ("" if value is None else str(value))
                else:
                    assert float(entry) == value or (entry == "nan" and math.isnan(value))


def test_csv_has_seventeen_digits(tmp_path, without_pyarrow):
    _, rows = read_csv(write_tables(example(), tmp_path)[0])
    assert rows[0]["peak deviator [Pa]"] == "0.33333333333333331"
    assert (rows[0]["steps"], rows[0]["count"], rows[0]["mu"]) == ("60", "200", "0.29999999999999999")


def test_names_that_meet_are_told_apart(tmp_path, pq, request):
    """A parameter like a column of its own, a result like a parameter, one name with two units."""
    results = CampaignResults("", [case({"status": 3, "length": 4}, {"length [m]": 1.0, "x [m]": 2.0, "x [mm]": 3.0})])
    table = pq.read_table(write_tables(results, tmp_path)[0])
    row = table.to_pylist()[0]
    assert (row["status (parameter)"], row["length"], row["length (result)"]) == (3, 4, 1.0)
    assert (row["status"], row["x [m]"], row["x [mm]"]) == ("finished", 2.0, 3.0)
    assert table.schema.field("x [mm]").metadata == {b"unit": b"mm"}
    request.getfixturevalue("without_pyarrow")
    head, _ = read_csv(write_tables(results, tmp_path)[0])
    assert head[-5:-2] == ["length (result) [m]", "x [m]", "x [mm]"]


@pytest.mark.parametrize("pyarrow", [True, False])
@pytest.mark.parametrize("cases", [[], [to_come({"seed": 0})]])
def test_nothing_finished_yet(tmp_path, request, pyarrow, cases):
    request.getfixturevalue("pq" if pyarrow else "without_pyarrow")
    for path in write_tables(CampaignResults("", cases), tmp_path):
        if pyarrow:
            rows = request.getfixturevalue("pq").read_table(path).num_rows
        else:
            rows = len(read_csv(path)[1])
        assert rows == (len(cases) if path.stem == "cases" else 0)


def test_numbers_that_no_column_of_numbers_holds_are_words():
    column = next(c for c in cases_table([case({"n": 2**70}), case({"n": 1})]) if c.name == "n")
    assert list(column.values) == [str(2**70), "1"]
    mixed = next(c for c in cases_table([case({"n": True}), case({"n": 1})]) if c.name == "n")
    assert list(mixed.values) == ["True", "1"]
    plain = next(c for c in cases_table([case({"n": np.int64(2)}), case({"n": 0.5})]) if c.name == "n")
    assert list(plain.values) == [2.0, 0.5]


def test_a_full_disk_leaves_the_old_tables(tmp_path, pq, monkeypatch):
    old = [path.read_bytes() for path in write_tables(example(), tmp_path)]

    def full(table, path):
        path.write_bytes(b"half")
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(pq, "write_table", full)
    with pytest.raises(OSError, match=r"cases\.parquet' could not be written: No space left on device"):
        write_tables(example(), tmp_path)
    assert [path.read_bytes() for path in sorted(tmp_path.iterdir())] == old


@pytest.mark.parametrize(
    ("value", "words"),
    [(("x", "z"), "x+z"), ((), ""), (0.1, "0.1"), (THIRD, repr(THIRD)), (1.0, "1"), (np.float64(2.0), "2"), (None, "None")],
)
def test_parameters_in_words(value, words):
    assert in_words(value) == words


@pytest.mark.parametrize(
    ("heading", "parts"),
    [
        ("peak deviator [Pa]", ("peak deviator", "Pa")),
        ("none-x: speed [m/s] ", ("none-x: speed", "m/s")),
        ("steps", ("steps", "")),
        ("[Pa]", ("[Pa]", "")),
        ("a [1] of b", ("a [1] of b", "")),
    ],
)
def test_units(heading, parts):
    assert name_and_unit(heading) == parts


def test_words_in_names_of_files():
    assert file_word("../a b/c|d:é") == "a-b-c-d"
    assert len(file_word("x" * 300)) == 80
