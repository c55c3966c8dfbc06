"""How tables look in a notebook."""

from __future__ import annotations

from html import escape
from typing import Any

#: The rows of a table that are shown.
SHOWN = 10


def table_html(table: Any) -> str:
    """The first rows of a table, without the columns that have no value in any row."""
    head, empty = table.head(SHOWN), set(table.empty_columns)
    names = [name for name in table.column_names if name not in empty]
    columns = [[_cell(value) for value in head[name]] for name in names]
    titles = "".join(f"<th>{escape(name)}</th>" for name in names)
    rows = "".join(f"<tr>{''.join(row)}</tr>" for row in zip(*columns))
    size = f"{len(table):,} rows, {len(table.column_names)} columns"
    if empty:
        size += f", of which {len(empty)} have no value and are not shown"
    return f"<table><thead><tr>{titles}</tr></thead><tbody>{rows}</tbody></table><p>{size}</p>"


def _cell(value: Any) -> str:
    if value is None:
        return "<td></td>"
    text = f"{value:.6g}" if isinstance(value, float) else str(value)
    return f"<td>{escape(text)}</td>"
