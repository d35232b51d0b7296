"""The results of a campaign as two tidy tables: a row a case, and a row a case and place of a curve."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from lmgcpy.experiment.campaign.cases import CampaignResults, CaseResult, in_words
from lmgcpy.writing import make_folder, new_file, write_table

INTEGERS = range(-(2**63), 2**63)
"""Whole numbers that a table holds as such."""


@dataclass(frozen=True)
class TableColumn:
    """A column of a table."""

    name: str
    unit: str
    values: np.ndarray
    """Truth values, whole numbers, floats, or words as objects."""
    present: np.ndarray
    """Whether a row has a value."""

    @property
    def heading(self) -> str:
        """The name, with the unit in brackets."""
        end = f" [{self.unit}]"
        return self.name if not self.unit or self.name.endswith(end) else self.name + end

    def texts(self) -> list[str]:
        """The values with all their digits; empty if there is none."""
        form = "{:.17g}" if self.values.dtype.kind == "f" else "{}"
        return [form.format(v) if there else "" for v, there in zip(self.values, self.present, strict=True)]


def write_tables(results: CampaignResults, folder: Path) -> list[Path]:
    """Write ``cases.parquet`` and ``curves.parquet`` into a folder, which is made if it is missing; returns the files.

    Names of columns have no unit; it is in the metadata of the field, ``{"unit": "Pa"}``. Without pyarrow the tables are
    ``cases.csv`` and ``curves.csv``, with the units in the headings. Former tables are replaced.
    """
    folder = make_folder(folder)
    tables = {"cases": cases_table(results.cases), "curves": curves_table(results.cases)}
    write, suffix = (_write_parquet, ".parquet") if has_pyarrow() else (_write_csv, ".csv")
    written = []
    for name, columns in tables.items():
        written.append(folder / f"{name}{suffix}")
        write(written[-1], columns)
    return written


def has_pyarrow() -> bool:
    """Whether Parquet can be written."""
    try:
        import pyarrow.parquet  # noqa: F401
    except ImportError:
        return False
    return True


# --------------------------------------------------------------------------------------------------------------- columns


def cases_table(cases: Sequence[CaseResult]) -> list[TableColumn]:
    """A row a case: its name, its parameters, what became of it, its numbers, and the versions used."""
    names = Names(["case", "status", "seconds", "error"])
    parameters, numbers, versions = (
        all_keys(getattr(case, what) for case in cases) for what in ("parameters", "numbers", "versions")
    )
    columns = [_words("case", [case.name for case in cases])]
    columns += [
        _parameter(names.new(name, "parameter"), [case.parameters.get(name) for case in cases]) for name in parameters
    ]
    columns.append(_words("status", [case.status for case in cases]))
    columns.append(_floats("seconds", "s", [case.seconds for case in cases]))
    columns.append(_words("error", [case.error for case in cases]))
    for heading, (name, unit) in names_and_units(numbers).items():
        columns.append(_floats(names.new(name, "result"), unit, [case.numbers.get(heading) for case in cases]))
    for name in versions:
        own = names.new(f"version of {name}", "version")
        columns.append(_words(own, [case.versions.get(name) for case in cases]))
    return columns


def curves_table(cases: Sequence[CaseResult]) -> list[TableColumn]:
    """A row a case, test and value of the abscissa: all columns that any curve has."""
    names = Names(["case", "test"])
    curves = [(case.name, test, curve) for case in cases for test, curve in case.curves.items() if curve]
    lengths = [len(next(iter(curve.values()))) for _, _, curve in curves]
    columns = [
        _words("case", np.repeat(np.array([name for name, _, _ in curves], dtype=object), lengths)),
        _words("test", np.repeat(np.array([test for _, test, _ in curves], dtype=object), lengths)),
    ]
    rows = np.concatenate([[0], np.cumsum(lengths, dtype=np.int64)])
    for heading, (name, unit) in names_and_units(all_keys(curve for _, _, curve in curves)).items():
        values, present = np.full(rows[-1], np.nan), np.zeros(rows[-1], dtype=bool)
        for k, (_, _, curve) in enumerate(curves):
            if heading in curve:
                values[rows[k] : rows[k + 1]] = curve[heading]
                present[rows[k] : rows[k + 1]] = True
        columns.append(TableColumn(names.new(name, "result"), unit, values, present))
    return columns


class Names:
    """Names of the columns of a table, each given once."""

    def __init__(self, taken: Iterable[str]):
        self._taken = set(taken)

    def new(self, name: str, kind: str) -> str:
        """The name; if it is taken, with its kind behind it: "steps (result)"."""
        while name in self._taken:
            name = f"{name} ({kind})"
        self._taken.add(name)
        return name


def name_and_unit(heading: str) -> tuple[str, str]:
    """The name and the unit of "peak deviator [Pa]"; the unit is empty if there is none."""
    found = re.fullmatch(r"(.*\S)\s*\[([^\[\]]+)\]", heading.strip())
    return (found[1], found[2]) if found else (heading, "")


def names_and_units(headings: Sequence[str]) -> dict[str, tuple[str, str]]:
    """Names and units by heading. If a name has several units, the names are the headings."""
    split = {heading: name_and_unit(heading) for heading in headings}
    names = [name for name, _ in split.values()]
    return {heading: (name if names.count(name) == 1 else heading, unit) for heading, (name, unit) in split.items()}


def all_keys(mappings: Iterable[Mapping[str, Any]]) -> list[str]:
    """The keys of all mappings, in the order in which they come first."""
    return list(dict.fromkeys(key for mapping in mappings for key in mapping))


def _words(name: str, values: Iterable[str | None]) -> TableColumn:
    column = np.array(list(values), dtype=object)
    return TableColumn(name, "", column, np.array([value is not None for value in column], dtype=bool))


def _floats(name: str, unit: str, values: Sequence[float | None]) -> TableColumn:
    present = np.array([value is not None for value in values], dtype=bool)
    return TableColumn(name, unit, np.array([np.nan if v is None else v for v in values], dtype=np.float64), present)


def _parameter(name: str, values: Sequence[Any]) -> TableColumn:
    """A parameter: truth values, whole numbers or numbers if all are, else words."""
    plain = [value.item() if isinstance(value, np.generic) else value for value in values]
    given = [value for value in plain if value is not None]
    kinds = {type(value) for value in given}
    fit = all(value in INTEGERS for value in given if type(value) is int)
    if not given or not kinds <= {bool, int, float} or (bool in kinds and len(kinds) > 1) or not fit:
        return _words(name, [None if value is None else in_words(value) for value in plain])
    if float in kinds:
        return _floats(name, "", plain)
    present = np.array([value is not None for value in plain], dtype=bool)
    kind = np.bool_ if bool in kinds else np.int64
    return TableColumn(name, "", np.array([0 if v is None else v for v in plain], dtype=kind), present)


# --------------------------------------------------------------------------------------------------------------- writing


def _write_parquet(path: Path, columns: Sequence[TableColumn]) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    arrays, fields = [], []
    for column in columns:
        kind = pa.string() if column.values.dtype.kind == "O" else pa.from_numpy_dtype(column.values.dtype)
        arrays.append(pa.array(column.values, type=kind, mask=~column.present))
        fields.append(pa.field(column.name, kind, metadata={"unit": column.unit} if column.unit else None))
    table = pa.Table.from_arrays(arrays, schema=pa.schema(fields))
    with new_file(path) as new:
        pq.write_table(table, new)


def _write_csv(path: Path, columns: Sequence[TableColumn]) -> None:
    write_table(path, [column.heading for column in columns], zip(*(column.texts() for column in columns), strict=True))
