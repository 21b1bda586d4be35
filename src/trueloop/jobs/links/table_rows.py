"""Two tool tables compared by what they say of each tool, for controls that keep numbers and no text."""

from pathlib import Path
from typing import TypeAlias

from trueloop.controllers.links.compare import Difference
from trueloop.formats.tables.tool_tables.known import tool_table_of
from trueloop.formats.tables.tool_tables.tool_table import Number, ToolRow, ToolTable, Unit

Key: TypeAlias = tuple[int, int, str, int]
"""Tool, edge, kind, and which of the rows of these."""


def differing_rows(name: str, first: bytes, second: bytes, unit: Unit | None) -> list[Difference]:
    """The rows whose numbers differ, or that one table alone has. Comments and the spelling of numbers do not count.

    Raises OFS errors for what is no tool table.
    """
    one, other = (tool_table_of(Path(name), content, unit) for content in (first, second))
    if one.unit != other.unit:
        return [Difference(None, f"unit {one.unit}", None, f"unit {other.unit}")]
    rows, others = _keyed(one), _keyed(other)
    keys = [*rows, *(key for key in others if key not in rows)]
    pairs = [(rows.get(key), others.get(key)) for key in keys]
    return [_difference(one, a, other, b) for a, b in pairs if _said(a) != _said(b)]


def _keyed(table: ToolTable) -> dict[Key, ToolRow]:
    keyed = dict[Key, ToolRow]()
    for row in table.rows:
        of = (row.tool, row.edge, row.kind)
        keyed[*of, sum(key[:3] == of for key in keyed)] = row
    return keyed


def _said(row: ToolRow | None) -> object:
    if row is None:
        return None
    return [*map(_value, (row.x, row.z, row.nose)), row.tip, dict(row.others)]


def _value(number: Number | None) -> object:
    """A number that stands in no row yet is none."""
    return None if number is None or number.start == number.end else number.value


def _difference(one: ToolTable, a: ToolRow | None, other: ToolTable, b: ToolRow | None) -> Difference:
    return Difference(*_place(one, a), *_place(other, b))


def _place(table: ToolTable, row: ToolRow | None) -> tuple[int, str] | tuple[None, None]:
    return (None, None) if row is None else (row.line, table.text.split("\n")[row.line - 1].rstrip("\r"))
