"""The rows of a CSV file, as every reader here takes them: header, separator, comments, cells and their lines.

Lines that begin with `#` are comments; empty ones are passed over. The first other line names the columns, each once.
The separator is found there: tab or semicolon where there is one, else comma; only with the first two may a number have
a decimal comma. A quote that is not closed ends with its line.
"""

import csv
import difflib
import math
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import read_text
from trueloop.units import SIGNALS

NOTE = "note"
"""A column that any file may have: it is not read."""

MOST = 1e15
"""No length, time or temperature is as large in any unit here; its square is still a number."""


@dataclass(frozen=True)
class CsvKind:
    """Error codes of a kind of file, as a whole, for its columns, for its numbers; and a hint at how it should look."""

    file: Code
    column: Code
    number: Code
    hint: str
    any_case: bool = False


@dataclass(frozen=True)
class CsvFile:
    """A file whose columns are yet to be separated: `lines` are numbers and texts without comments."""

    path: Path
    kind: CsvKind
    header: tuple[str, ...]
    separator: str
    lines: Sequence[tuple[int, str]]
    comments: Sequence[tuple[int, str]]

    def rows(self, names: Collection[str], endings: tuple[str, ...] = ()) -> "Rows":
        """Returns the rows. Raises for a column that is neither known nor ends so: mistyped, it would be ignored."""
        for place, name in enumerate(self.header, 1):
            if name in self.header[: place - 1]:
                raise self.refusal(
                    f"column {name!r} is there {self.header.count(name)} times", place, "keep one of them"
                )
            if name not in names and name != NOTE and not name.endswith(endings):
                raise self.refusal(f"column {name!r} is not one of {len(names)} known", place, _instead(name, names))
        cells = [self._cells(line, text) for line, text in self.lines[1:]]
        return Rows(
            path=self.path,
            kind=self.kind,
            header=self.header,
            separator=self.separator,
            lines=[line for line, _ in self.lines[1:]],
            cells=cells,
        )

    def refusal(self, why: str, column: int | None = None, hint: str | None = None) -> TrueloopError:
        """Returns the refusal of the header."""
        place = Place(str(self.path), self.lines[0][0], column)
        return self.kind.column.refusal(why, hint=hint or self.kind.hint, place=place)

    def _cells(self, line: int, text: str) -> list[str]:
        """As many as there are columns; what is beyond them may be there and empty, as spreadsheets write it."""
        cells, most = _split(self.path, self.kind, line, text, self.separator), len(self.header)
        if len(cells) < most or any(cells[most:]):
            code = self.kind.number if len(cells) < most else self.kind.column
            raise code.refusal(
                f"{len(cells)} cells under {most} columns",
                hint="decimal commas need semicolons or tabs between the columns",
                place=Place(str(self.path), line, min(len(cells), most) + 1),
            )
        return cells[:most]


@dataclass(frozen=True)
class Rows:
    """Rows of known columns: `lines` are their lines in the file, `cells` their texts without blanks around them."""

    path: Path
    kind: CsvKind
    header: tuple[str, ...]
    separator: str
    lines: Sequence[int]
    cells: Sequence[Sequence[str]]

    def __len__(self) -> int:
        return len(self.cells)

    def texts(self, name: str) -> list[str]:
        """Returns a column's texts, empty where the file lacks it."""
        if name not in self.header:
            return [""] * len(self)
        place = self.header.index(name)
        return [cells[place] for cells in self.cells]

    def numbers(self, name: str, otherwise: float | None = None) -> Array:
        """Returns a column of finite numbers, (n,); all `otherwise` where the file lacks it. Raises with the line."""
        if name not in self.header:
            if otherwise is not None:
                return np.full(len(self), otherwise)
            place = Place(str(self.path), 1)
            raise self.kind.column.refusal(
                f"none of its {len(self.header)} columns is {name}", hint=self.kind.hint, place=place
            )
        texts = self.texts(name)
        decimal = "." if self.separator == "," else ","
        values = np.array([number_of(text.replace(decimal, ".")) for text in texts])
        for row in np.flatnonzero(~(np.abs(values) <= MOST))[:1]:
            why = "not a finite number" if not np.isfinite(values[row]) else f"beyond ±{MOST:g}"
            raise self.refusal(
                int(row), f"{name} is {texts[row]!r}, {why}", name, "write a number, or leave out the row"
            )
        return values

    def refusal(self, row: int, why: str, column: str | None = None, hint: str | None = None) -> TrueloopError:
        """Returns the refusal of a row, counted from 0."""
        at = None if column is None else self.header.index(column) + 1
        place = Place(str(self.path), self.lines[row], at)
        return self.kind.number.refusal(why, hint=hint or self.kind.hint, place=place)


def read_csv(path: Path, kind: CsvKind) -> CsvFile:
    """Reads a file's header and lines. Raises `kind.file` for one that is not a CSV, and where there is no row."""
    return csv_of(read_text(path, kind.file, hint=kind.hint), path, kind)


def csv_of(text: str, path: Path, kind: CsvKind) -> CsvFile:
    """Parses the text of a CSV file."""
    lines = list(enumerate(text.splitlines(), 1))
    kept = [(k, line) for k, line in lines if line.strip() and not line.lstrip().startswith("#")]
    if len(kept) < 2:
        why = "it has a header and no rows" if kept else "it is empty: it has 0 rows"
        raise kind.file.refusal(why, hint=kind.hint, place=Place(str(path), kept[0][0] if kept else 1))
    separator = next((mark for mark in "\t;" if mark in kept[0][1]), ",")
    header = _split(path, kind, *kept[0], separator)
    while not header[-1] and len(header) > 1:
        header.pop()
    names = tuple(name.lower() if kind.any_case else name for name in header)
    comments = [(k, line.strip()) for k, line in lines if line.lstrip().startswith("#")]
    return CsvFile(path=path, kind=kind, header=names, separator=separator, lines=kept, comments=comments)


def _split(path: Path, kind: CsvKind, line: int, text: str, separator: str) -> list[str]:
    try:
        return [cell.strip() for cell in next(csv.reader([text], delimiter=separator))]
    except csv.Error as error:
        place = Place(str(path), line)
        raise kind.file.refusal(f"no CSV: {error}", hint="save it as plain CSV", place=place) from error


def csv_cell(text: str) -> str:
    """Returns a text as RFC 4180 wants it: quoted when it holds a comma, a quote or a line end."""
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"\r\n') else text


def number_of(text: str) -> float:
    """Returns a text as a number; nan for one that is none."""
    try:
        return float(text)
    except ValueError:
        return math.nan


_OTHER_UNITS: Final = {
    *("nm", "um", "mm", "cm", "m", "in", "mil", "mils", "thou", "microns", "rad", "mrad", "urad", "deg", "arcmin"),
    *("arcsec", "c", "k", "f", "degc", "degf", "celsius", "mk", "rpm", "hz", "s", "ms", "min", "h"),
}


def _instead(name: str, names: Collection[str]) -> str:
    """Hint: a name that is nearly right. One in another unit would take the values for what they are not."""
    stem, _, unit = name.lower().rpartition("_")
    lowered = {other.lower(): other for other in names}
    if stem and unit in _OTHER_UNITS and name.lower() not in lowered:
        of_unit = [other for other in names if other.lower().rpartition("_")[2] == unit]
        near = difflib.get_close_matches(name.lower(), map(str.lower, of_unit), n=1, cutoff=0.8)
        units = [other for other in names if other.lower().rpartition("_")[0] == stem]
        if not near:
            return f"convert it: known are {', '.join(units or names)}, and signals in {', '.join(SIGNAL_UNITS)}"
    else:
        near = difflib.get_close_matches(name.lower(), lowered, n=1)
    return f"did you mean {lowered[near[0]]!r}?" if near else f"take it out; known are {', '.join(names)}"


SIGNAL_UNITS: Final = tuple(SIGNALS)
WRONG_UNITS: Final = ("_in", "_degF", "_inch", "_ft", "_K", "_min", "_h", "_ms")
BARE: Final = (*"XYZABC", "reading", "u", "temperature", "time")
HINT: Final = "a header such as X_mm,travel_X,along,reading_um,T1_degC and a row a reading"
KIND: Final = CsvKind(Code.MCH_FILE, Code.MCH_FILE, Code.MCH_FILE, HINT)


def read_measured(path: Path, *, inches: bool = False) -> CsvFile:
    """Reads the file and checks its units; `inches` may be. Raises MCH-FILE, MCH-UNIT: a unit not used here."""
    file = read_csv(path, KIND)
    for name in file.header:
        if (name.endswith(WRONG_UNITS) and not (inches and name.endswith("_in"))) or name in BARE:
            why = f"column {name!r} is in a unit that is not mm, µm, µrad, °, °C, s, or says none"
            raise wrong_unit(path, why)
    return file


def signals_in(rows: Rows) -> dict[str, Array]:
    """Temperatures and speeds by name without unit, (n,)."""
    return {name: values for unit in SIGNAL_UNITS for name, values in named_by(unit, rows).items()}


def units_in(rows: Rows) -> dict[str, str]:
    """Returns the units of the signals, by name."""
    return {name.removesuffix(end): unit for name in rows.header for end, unit in SIGNALS.items() if name.endswith(end)}


def named_by(unit: str, rows: Rows) -> dict[str, Array]:
    """Columns whose names end in that unit, by their name without it, (n,)."""
    return {name.removesuffix(unit): rows.numbers(name) for name in rows.header if name.endswith(unit)}


def vectors(rows: Rows, names: Iterable[str], otherwise: float | None = None) -> Array:
    """Returns three columns as vectors, (n, 3)."""
    return np.stack([rows.numbers(name, otherwise) for name in names], axis=-1)


def wrong_unit(path: Path, why: str) -> TrueloopError:
    """Returns the error MCH-UNIT."""
    return Code.MCH_UNIT.refusal(
        f"{path.name!r}: {why}",
        hint="name every column with its unit: X_mm, reading_um, T1_degC; one file, one kind of reading",
        place=Place(str(path), 1),
    )
