"""Tool tables, and what was changed in one, in words and as JSON."""

from pathlib import Path
from typing import Final

from trueloop.formats.tables.tool_tables.known import NewNumber, NewTable
from trueloop.formats.tables.tool_tables.tool_table import Number, ToolRow, ToolTable

HEADINGS: Final = ("tool", "kind", "X", "Z", "nose", "tip", "name", "further numbers")


def table_lines(table: ToolTable) -> list[str]:
    """Returns the headings and a line a row, in columns; numbers as they stand in the file."""
    rows = [HEADINGS, *map(_row, table.rows)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]


def heading_words(table: ToolTable) -> str:
    """Describes what the table is, and how it counts."""
    convention = table.convention
    x_is = "X as the control is set up" if convention.x_is is None else f"X is a {convention.x_is}"
    return (
        f"{table.path.name}: {convention.name}, {len(table.rows)} rows, {table.unit or 'unit not stated'}; {x_is}, the "
        f"nose a {convention.nose_is}"
    )


def table_as_dict(table: ToolTable) -> dict[str, object]:
    """Converts a tool table to a dict; numbers in its unit, as it counts them; what it does not hold is None."""
    return {
        "file": str(table.path),
        "format": table.convention.name,
        "unit": table.unit,
        "x_is": table.convention.x_is,
        "nose_is": table.convention.nose_is,
        "rows": [
            {
                "tool": row.tool,
                "edge": row.edge,
                "kind": row.kind,
                "line": row.line,
                "x": _value(row.x),
                "z": _value(row.z),
                "nose": _value(row.nose),
                "tip": row.tip,
                "name": row.name,
                "others": dict(row.others),
            }
            for row in table.rows
        ],
        "remarks": list(table.remarks),
    }


def change_words(table: ToolTable, new: NewTable) -> list[str]:
    """Describes what was changed: a line a number, its old and its new value."""
    name = f" ({new.row.name})" if new.row.name else ""
    where = f"tool {new.row.tool}{name}, {new.row.kind}, line {new.row.line}"
    return [f"{where}: {_change(number)} {table.known_unit}" for number in new.numbers]


def change_as_dict(record_id: str, table: ToolTable, new: NewTable, written: Path | str) -> dict[str, object]:
    """Returns a change as JSON-ready values. `written`: the file, or the table's name at its control."""
    return {
        "record_id": record_id,
        "tool": new.row.tool,
        "edge": new.row.edge,
        "name": new.row.name,
        "kind": new.row.kind,
        "line": new.row.line,
        "unit": table.known_unit,
        "numbers": [
            {"axis": number.axis, "is": number.counts, "before": float(number.before), "after": float(number.after)}
            for number in new.numbers
        ],
        "written": str(written),
    }


def _row(row: ToolRow) -> tuple[str, ...]:
    tool = f"T{row.tool}" + (f" D{row.edge}" if row.edge != 1 else "")
    others = " ".join(f"{name} {value}" for name, value in row.others.items())
    numbers = ["–" if number is None else f"{number.value:f}" for number in (row.x, row.z, row.nose)]
    return tool, row.kind, *numbers, "" if row.tip is None else str(row.tip), row.name, others


def _value(number: Number | None) -> float | None:
    return None if number is None else float(number.value)


def _change(number: NewNumber) -> str:
    counts = f" ({number.counts})" if number.axis == "X" else ""
    if number.after == number.before:
        return f"{number.axis}{counts} stays {number.before:f}"
    return f"{number.axis}{counts} {number.before:f} → {number.after:f}"
