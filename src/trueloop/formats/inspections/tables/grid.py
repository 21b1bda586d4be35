"""A table as cells of text, whatever it was written by: CSV with any separator, or a sheet of a workbook.

A sheet of a workbook (.xlsx, .xlsm, .xlsb, .xls, .ods) as cells of text.

Only cells are read: neither macros nor the document's properties, in which names of people are kept. A cell holds what
was computed last; an error, such as #REF!, is an empty cell. Dates become text as ISO 8601 writes them.
"""

import csv
import datetime
import io
import re
import zipfile
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final, TypeAlias

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import readable
from trueloop.formats.inspections.shared.text import HINT

if TYPE_CHECKING:
    from python_calamine import CalamineSheet

Row: TypeAlias = Sequence[str]
SEPARATORS: Final = ("\t", ";", "|", ",")
"""Separators in the order of trust: a comma may be a decimal mark."""
SAMPLE: Final = 60
"""Rows that are looked at to find the separator and the headings."""


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


def grid_of_text(
    text: str, path: Path, encoding: str, separator: str, scored: Callable[[Sequence[Row]], float]
) -> Grid:
    """Splits a text into cells. Without a stated separator, the one whose rows have the best score is taken.

    Raises MSR-FILE where it is not a CSV.
    """
    body, stated = _without_separator_line(text)
    head = "\n".join(body.splitlines()[: 2 * SAMPLE])
    sure = separator or stated
    mark = sure or max(
        SEPARATORS,
        key=lambda one: (scored(_split(head, one, path)[0][:SAMPLE]), sum(one in line for line in head.splitlines())),
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


def _split(text: str, separator: str, path: Path) -> tuple[list[list[str]], list[int]]:
    reader = csv.reader(io.StringIO(text, newline=""), delimiter=separator, skipinitialspace=True)
    rows, lines, begin = [], [], 1
    try:
        for row in reader:
            rows.append([cell.strip() for cell in row])
            lines.append(begin)
            begin = reader.line_num + 1
    except csv.Error as error:
        raise Code.MSR_FILE.refusal(f"no table: {error}", hint=HINT, place=Place(str(path), reader.line_num)) from error
    return rows, lines


Cell: TypeAlias = int | float | str | bool | datetime.time | datetime.date | datetime.datetime | datetime.timedelta
ZIP: Final = b"PK\x03\x04"
OLE: Final = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
SUFFIXES: Final = frozenset((".xlsx", ".xlsm", ".xlsb", ".xls", ".ods"))
LARGEST: Final = 400_000_000
"""Bytes that a workbook may unpack to: a sheet of a million cells has about 50 million."""
MOST_PACKED: Final = 200.0
"""Times that a file in it may be larger than packed; sheets of real workbooks are 5 to 30 times."""
SMALL: Final = 10_000_000
"""Bytes below which it does not matter how a file is packed."""
MOST_CELLS: Final = 20_000_000
WIDE_OR_TALL: Final = re.compile(rb"""\sr=["'](?:[A-Z]{2,3}\d|[A-Z]\d{6})""")
CELL: Final = re.compile(rb"""\sr=["']([A-Z]{1,3})(\d{1,7})["']""")


def is_workbook(path: Path, head: bytes) -> bool:
    """Returns whether name and first bytes are a workbook's: other kinds of file are archives as well."""
    return path.suffix.lower() in SUFFIXES and head.startswith((ZIP, OLE))


def sheets_of(path: Path) -> dict[str, Grid]:
    """Returns the sheets by their names, hidden ones and those without cells left out.

    Raises MSR-FILE for one that is damaged, locked by a password, or unpacks to more than is read.
    """
    from python_calamine import CalamineError, CalamineWorkbook, SheetVisibleEnum

    with readable(path, Code.MSR_FILE, hint=HINT):
        content = path.read_bytes()
    if content.startswith(ZIP):
        _require_harmless(content, path)
    try:
        with CalamineWorkbook.from_filelike(io.BytesIO(content)) as book:
            seen = [metadata.name for metadata in book.sheets_metadata if metadata.visible == SheetVisibleEnum.Visible]
            sheets = {name: book.get_sheet_by_name(name) for name in seen}
            cells = {name: _unmerged(sheet) for name, sheet in sheets.items() if sheet.height}
    except CalamineError as error:
        raise _refusal(path, f"cannot be read as a workbook: {error}") from error
    except BaseException as error:
        if type(error).__name__ != "PanicException":  # what a fault of the library becomes, no Exception
            raise
        raise _refusal(path, "cannot be read as a workbook: it is damaged") from error
    return {
        name: Grid(
            path,
            [[text_of(cell) for cell in row] for row in rows],
            range(1, len(rows) + 1),
            path.suffix[1:].lower(),
            sheet=name,
        )
        for name, rows in cells.items()
    }


def _unmerged(sheet: "CalamineSheet") -> list[list[Cell]]:
    """The cells of a sheet; one that spans several rows holds its value in each of them."""
    rows: list[list[Cell]] = sheet.to_python(skip_empty_area=False)
    for (top, left), (bottom, _) in sheet.merged_cell_ranges or ():
        for row in rows[top + 1 : bottom + 1]:
            row[left] = rows[top][left]
    return rows


def text_of(cell: Cell) -> str:
    """Returns a cell as text: numbers as short as they are exact, dates as ISO 8601.

    >>> text_of(12.0), text_of(0.1), text_of(datetime.datetime(2026, 3, 5, 7, 30))
    ('12', '0.1', '2026-03-05 07:30:00')
    """
    if isinstance(cell, str):
        return cell.strip()
    if isinstance(cell, float):
        return str(int(cell)) if cell.is_integer() and abs(cell) < 1e15 else repr(cell)
    return str(cell)


def _require_harmless(content: bytes, path: Path) -> None:
    """By the archive's directory, before anything is unpacked; then by how large a sheet its cells span."""
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            files = archive.infolist()
            total = sum(zip_info.file_size for zip_info in files)
            packed = max((zip_info for zip_info in files if zip_info.file_size > SMALL), key=_ratio, default=None)
            if total > LARGEST:
                raise _refusal(path, f"unpacks to {total / 1e6:.0f} MB; {LARGEST / 1e6:.0f} MB are read")
            if packed is not None and _ratio(packed) > MOST_PACKED:
                raise _refusal(
                    path,
                    f"holds a file that unpacks to {_ratio(packed):.0f} times its size; {MOST_PACKED:.0f} is the most",
                )
            for zip_info in files:
                if "/worksheets/" in zip_info.filename or zip_info.filename == "content.xml":
                    _require_small(archive.read(zip_info), path)
    except (zipfile.BadZipFile, zlib.error, RuntimeError, OSError, EOFError, ValueError) as error:
        raise _refusal(path, f"is a damaged workbook: {error}") from error


def _ratio(entry: zipfile.ZipInfo) -> float:
    return entry.file_size / max(entry.compress_size, 1)


def _require_small(sheet: bytes, path: Path) -> None:
    """A cell far to the right and one far below would make a sheet of all cells between."""
    if WIDE_OR_TALL.search(sheet):
        columns, rows = zip(*CELL.findall(sheet), strict=True)
        cells = max(map(int, rows)) * max(map(_column, set(columns)))
        if cells > MOST_CELLS:
            raise _refusal(path, f"has a sheet that spans {cells:.3g} cells; {MOST_CELLS:.3g} are read")


def _column(letters: bytes) -> int:
    number = 0
    for letter in letters:
        number = 26 * number + letter - 64
    return number


def _refusal(path: Path, why: str) -> TrueloopError:
    return Code.MSR_FILE.refusal(f"{path.name!r} {why}", hint="save the sheet as CSV in UTF-8", place=Place(str(path)))
