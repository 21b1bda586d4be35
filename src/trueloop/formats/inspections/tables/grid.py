"""A table as cells of text, whatever it was written by: CSV with any separator, or a sheet of a workbook."""

import csv
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, TypeAlias

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.shared.text import HINT

Row: TypeAlias = Sequence[str]
SEPARATORS: Final = ("\t", ";", "|", ",")
"""Separators in the order of trust: a comma may be a decimal mark."""
SAMPLE: Final = 60
"""Rows that are looked at to find the separator and the headings."""
EMPTY: Final = frozenset(("", "-", "--", "---", "n/a", "na", "nan", "null", "none", "*", "***", "...", "?"))
"""Cells that state nothing, in lower case; errors of a workbook, such as #REF!, as well."""


@dataclass(frozen=True)
class Grid:
    """Rows of cells without blanks around them, and the line (of a workbook the row) that each stands in."""

    path: Path
    rows: Sequence[Row]
    lines: Sequence[int]
    encoding: str = ""
    separator: str = ""
    sheet: str = ""

    def at(self, row: int, column: int | None = None) -> Place:
        """Returns the place of a cell, row and column counted from 0."""
        return Place(str(self.path), self.lines[row], None if column is None else column + 1)


def is_empty(cell: str) -> bool:
    """Returns whether a cell states nothing."""
    return cell.lower() in EMPTY or (cell.startswith("#") and cell.rstrip("!?").isupper())


def grid_of_text(
    text: str, path: Path, encoding: str, separator: str, scored: Callable[[Sequence[Row]], float]
) -> Grid:
    """Splits a text into cells. Without a stated separator, the one whose rows have the best score is taken.

    Raises MSR-FILE where it is no CSV.
    """
    body, stated = _without_separator_line(text)
    head = "\n".join(body.splitlines()[: 2 * SAMPLE])
    sure = separator or stated
    mark = sure or max(
        SEPARATORS, key=lambda one: (scored(_split(head, one, path)[0][:SAMPLE]), _lines_with(one, head))
    )
    rows, lines = _split(body, mark, path)
    skipped = 1 if stated else 0
    return Grid(path, rows, [line + skipped for line in lines], encoding, mark)


def _without_separator_line(text: str) -> tuple[str, str]:
    """A first line such as `sep=;`, which a spreadsheet program writes and reads."""
    first, _, rest = text.partition("\n")
    stated = first.strip().strip('"')
    if stated.lower().startswith("sep=") and len(stated) == 5:
        return rest, stated[4]
    return text, ""


def _lines_with(separator: str, text: str) -> int:
    return sum(separator in line for line in text.splitlines())


def _split(text: str, separator: str, path: Path) -> tuple[list[list[str]], list[int]]:
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, skipinitialspace=True)
    rows, lines, begin = [], [], 1
    try:
        for row in reader:
            rows.append([cell.strip() for cell in row])
            lines.append(begin)
            begin = reader.line_num + 1
    except csv.Error as error:
        raise TrueloopError(
            Code.MSR_FILE, f"no table: {error}", hint=HINT, place=Place(str(path), reader.line_num)
        ) from error
    return rows, lines
