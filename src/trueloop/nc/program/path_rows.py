"""The moves of a tool path as JSON has them."""

from trueloop.nc.program.tool_path import CSV_HEADER, ToolPath, csv_text

_WORDS = frozenset({"motion", "feed_unit"})
_WHOLE = frozenset({"line", "column", "tool"})


def rows_of(path: ToolPath) -> list[dict[str, object]]:
    """Returns the rows of `csv_text` as objects: numbers as numbers, empty cells as None."""
    return [
        {name: _value(name, cell) for name, cell in zip(CSV_HEADER, row.split(","), strict=True)}
        for text in csv_text(path)
        for row in text.splitlines()
    ]


def _value(name: str, cell: str) -> object:
    if name in _WORDS:
        return cell
    if not cell:
        return None
    return int(cell) if name in _WHOLE else float(cell)
