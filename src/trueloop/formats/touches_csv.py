"""Touches as CSV: `point`, `feature` (optional), a nominal point, and a measured point or an error.

Columns carry their unit: `nominal_x_mm`, `nominal_x_in`, `nominal_x_diameter_mm`, `nominal_x_diameter_in`,
`nominal_z_mm`, `nominal_z_in`; the same with `measured_`; or `error_um`, `error_mm`, `error_in`. Lines beginning with
`#` are comments. Separator comma, semicolon or tab, found from the header; a decimal comma needs the semicolon or tab.
"""

import csv
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final, TypeAlias

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import read_text
from trueloop.gauging.touch import Touch
from trueloop.geometry.feature import Point
from trueloop.units import MM_PER_INCH, UM_PER_MM

LENGTH_MM: Final = {"um": 1 / UM_PER_MM, "mm": 1.0, "in": MM_PER_INCH}
X_SUFFIXES: Final = {
    "x_mm": 1.0,
    "x_in": MM_PER_INCH,
    "x_diameter_mm": 0.5,
    "x_diameter_in": MM_PER_INCH / 2,
}
Z_SUFFIXES: Final = {"z_mm": 1.0, "z_in": MM_PER_INCH}
ERROR_COLUMNS: Final = {f"error_{unit}": factor for unit, factor in LENGTH_MM.items()}

Line: TypeAlias = tuple[int, str]


def read_touches(path: Path) -> list[Touch]:
    """Touches of a CSV file in its order. Raises TCH errors with line (and column) of what cannot be read."""
    first, *others = _lines_of(path)
    separator = next((s for s in "\t;" if s in first[1]), ",")
    columns = _Columns([cell.strip() for cell in _cells(first, separator, path)], path)
    return [columns.touch(line[0], _row(line, columns.header, separator, path), separator) for line in others]


def _lines_of(path: Path) -> list[Line]:
    """The lines that hold something, with their numbers; at least one."""
    hint = "`gauging.touches` in the job names a CSV file in UTF-8, relative to the job"
    lines = read_text(path, Code.TCH_FILE, hint=hint).splitlines()
    kept = [(k, line) for k, line in enumerate(lines, start=1) if line.strip() and not line.lstrip().startswith("#")]
    if not kept:
        raise TrueloopError(
            Code.TCH_FILE,
            f"{str(path)!r} has 0 rows",
            hint="the first row names the columns",
            place=Place(str(path)),
        )
    return kept


def _row(line: Line, header: Sequence[str], separator: str, path: Path) -> dict[str, str]:
    cells = _cells(line, separator, path)
    if any(cell.strip() for cell in cells[len(header) :]):
        raise TrueloopError(
            Code.TCH_COLUMN,
            f"the row has {len(cells)} cells, the header {len(header)}",
            hint="decimal commas need semicolons or tabs between the columns",
            place=Place(str(path), line[0]),
        )
    return dict(zip(header, cells, strict=False))


def _cells(line: Line, separator: str, path: Path) -> list[str]:
    """The cells of one line; a quote that is not closed ends with its line."""
    number, text = line
    try:
        return next(csv.reader([text], delimiter=separator))
    except csv.Error as error:
        raise TrueloopError(
            Code.TCH_FILE,
            f"row {number} is no CSV: {error}",
            hint="save it as plain CSV",
            place=Place(str(path), number),
        ) from error


class _Columns:
    """Which column holds what: found once from the header."""

    def __init__(self, header: Sequence[str], path: Path) -> None:
        self.header, self.path = header, path
        self.nominal = self._pair("nominal_")
        self.measured = self._pair("measured_")
        self.error = self._one(ERROR_COLUMNS, "")
        if "point" not in header or self.nominal is None or (self.measured is None and self.error is None):
            raise TrueloopError(
                Code.TCH_COLUMN,
                f"the header {list(header)} does not say point, nominal x and z, and measured x and z or an error",
                hint="for instance: point,feature,nominal_x_mm,nominal_z_mm,error_um",
                place=Place(str(path), 1),
            )

    def touch(self, line: int, row: Mapping[str, str], separator: str) -> Touch:
        """One row."""
        nominal = self._point(self.nominal, line, row, separator)
        assert nominal is not None
        measured = self._point(self.measured, line, row, separator)
        error = None
        if self.error is not None:
            name, factor = self.error
            error = self._number(name, line, row, separator) * factor
        return Touch(
            point=row.get("point", "").strip(),
            nominal_mm=nominal,
            feature=(row.get("feature") or "").strip() or None,
            measured_mm=measured,
            error_mm=error,
            line=line,
        )

    def _one(self, factors: Mapping[str, float], prefix: str) -> tuple[str, float] | None:
        found = [(prefix + name, factor) for name, factor in factors.items() if prefix + name in self.header]
        if len(found) > 1:
            raise TrueloopError(
                Code.TCH_COLUMN,
                f"{found[0][0]!r} and {found[1][0]!r} say the same thing in {len(found)} columns",
                hint="keep one of them",
                place=Place(str(self.path), 1),
            )
        return found[0] if found else None

    def _pair(self, prefix: str) -> tuple[tuple[str, float], tuple[str, float]] | None:
        x, z = self._one(X_SUFFIXES, prefix), self._one(Z_SUFFIXES, prefix)
        return None if x is None or z is None else (x, z)

    def _point(
        self,
        columns: tuple[tuple[str, float], tuple[str, float]] | None,
        line: int,
        row: Mapping[str, str],
        separator: str,
    ) -> Point | None:
        if columns is None:
            return None
        (x_name, x_factor), (z_name, z_factor) = columns
        return (
            self._number(x_name, line, row, separator) * x_factor,
            self._number(z_name, line, row, separator) * z_factor,
        )

    def _number(self, name: str, line: int, row: Mapping[str, str], separator: str) -> float:
        text = (row.get(name) or "").strip()
        try:
            value = float(text.replace(",", ".") if separator != "," else text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise TrueloopError(
                Code.TCH_NUMBER,
                f"{name} is {text!r}, not a finite number",
                hint="leave out the row of a touch that failed",
                place=Place(str(self.path), line, self.header.index(name) + 1),
            )
        return value
