"""Measures with a row for each body or interaction, as tables of pandas."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from lmgcpy.writing import dataframe, html_table

SHOWN = 5
"""Rows that a notebook shows."""


class Table:
    """A measure whose fields are columns of one length; vectors and tensors are several columns."""

    def __len__(self) -> int:
        first: np.ndarray = getattr(self, fields(self)[0].name)  # type: ignore[arg-type]
        return len(first)

    def to_dataframe(self) -> Any:
        """A pandas.DataFrame of the :meth:`columns`.

        Raises ImportError with a sentence if pandas is missing.
        """
        return dataframe(self.columns())

    def columns(self) -> dict[str, np.ndarray]:
        """The columns by name: one for each field, and for each component of a vector (``_x``) or tensor (``_xy``)."""
        columns: dict[str, np.ndarray] = {}
        for field in fields(self):  # type: ignore[arg-type]
            values = getattr(self, field.name)
            for index in np.ndindex(values.shape[1:]):
                axes = "".join("xyz"[k] for k in index) if field.name != "pairs" else ("candidate", "antagonist")[index[0]]
                name = axes if field.name == "pairs" else f"{field.name}_{axes}" if axes else field.name
                columns[name] = values[(slice(None), *index)]
        return columns

    def _repr_html_(self) -> str:
        columns = self.columns()
        rows = zip(*(values[:SHOWN] for values in columns.values()), strict=True)
        more = f"and {len(self) - SHOWN} more" if len(self) > SHOWN else ""
        return html_table(f"{type(self).__name__} of {len(self)} rows", columns, rows, more)

    def __repr__(self) -> str:
        return f"<{type(self).__name__} of {len(self)} rows: {', '.join(field.name for field in fields(self))}>"  # type: ignore[arg-type]
