"""Readings of hand gauges as CSV: a row a reading, the columns named by what they hold and its unit.

    feature,z_mm,diameter_mm
    seat-1,-20,39.984

The value stands in one of `diameter`, `radius`, `length`, `runout` with `_mm`, `_um` or `_in`, or `angle_deg`; or in
`value_mm` (`value_um`, `value_in`, `value_deg`) beside `quantity`. Optional: `characteristic`, `from` (the feature a
length counts from; empty: the part's zero), `axis` (x, y or z, of a position), `z_mm` and `x_mm` (a radius), `nominal`,
`lower_limit`, `upper_limit` and `deviation` in the unit of the value, and what is in `STATED`. The latter also as
comments `# key: value` above, for all rows. A row without a value was not measured. Separator and decimal comma as in
every CSV file here.
The sheet that a person fills in beside the part is such a file with an empty cell for each value.
"""

import csv
import difflib
import io
import math
import re
from collections import defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from functools import cached_property
from pathlib import Path
from types import MappingProxyType
from typing import Final, Literal

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Remark, StatedFacts
from trueloop.formats.inspections.shared.checks import (
    by_reading,
    devices_of,
    filled_in,
    half_digits,
    listed,
    numbered,
    require_serials,
    stated_deviations,
)
from trueloop.formats.inspections.shared.quantities import characteristics_of
from trueloop.formats.inspections.shared.text import decoded, is_empty, number_in, read_decoded
from trueloop.formats.measurements.rows import NOTE, CsvFile, CsvKind, Rows, csv_of
from trueloop.units import MM_PER_INCH, UM_PER_MM

FACTORS: Final = {"_mm": 1.0, "_um": 1.0 / UM_PER_MM, "_in": MM_PER_INCH}
LENGTHS: Final = (Quantity.DIAMETER, Quantity.RADIUS, Quantity.LENGTH, Quantity.RUNOUT)
VALUES: Final = {f"{one}{unit}": (one, factor) for one in LENGTHS for unit, factor in FACTORS.items()} | {
    "angle_deg": (Quantity.ANGLE, 1.0)
}
OF_QUANTITY: Final = {"value_deg": 1.0} | {f"value{unit}": factor for unit, factor in FACTORS.items()}
PLACES: Final = {f"{axis}{unit}": (axis, factor) for axis in "xz" for unit, factor in FACTORS.items() if unit != "_um"}
READ: Final = (*VALUES, *OF_QUANTITY)
AXES: Final[tuple[Literal["", "x", "y", "z"], ...]] = ("", "x", "y", "z")
ALONG: Final = {axis: [name for name, (of, _) in PLACES.items() if of == axis] for axis in "xz"}
IN_ITS_UNIT: Final = ("nominal", "lower_limit", "upper_limit", "deviation")
STATED: Final = ("part", "serial", "instrument", "operator", "measured_at", "temperature_c")
UNCERTAINTIES: Final = {
    f"{name}{unit}": factor / k
    for name, k in (("uncertainty", 1.0), ("expanded_uncertainty", 2.0))
    for unit, factor in (*FACTORS.items(), ("_deg", 1.0))
}
"""Of a reading: the standard uncertainty, or the expanded one with k = 2, as certificates state it."""
NUMBERS: Final = frozenset((*READ, *PLACES, *UNCERTAINTIES, *IN_ITS_UNIT, "temperature_c"))
KEYS: Final = (*STATED, *UNCERTAINTIES)
COLUMNS: Final = (
    *("characteristic", "feature", "from", "quantity", "axis", *IN_ITS_UNIT),
    *(*VALUES, *OF_QUANTITY, *PLACES, *KEYS),
)
HINT: Final = "a header such as feature,z_mm,diameter_mm and a row a reading: docs/measurements.md, Gauge readings"
KIND: Final = CsvKind(Code.MSR_FILE, Code.MSR_COLUMN, Code.MSR_NUMBER, HINT, any_case=True)
STATEMENT: Final = re.compile(r"#\s*(\w+)\s*[:=]\s*(.*?)\s*")


def recognises(path: Path, head: bytes) -> bool:
    """A CSV whose header names a feature or a characteristic, and one of the columns of values.

    All other columns but one are known too, which is then mistyped; a table with more of its own is another format.
    """
    try:
        text, _ = decoded(head, path)
    except TrueloopError:
        return False
    line = next((line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")), "")
    separator = next((mark for mark in "\t;" if mark in line), ",")
    names = {name.strip().lower() for name in next(csv.reader([line], delimiter=separator), [])}
    named = bool(names & {"feature", "characteristic"}) and bool(names & (VALUES.keys() | OF_QUANTITY.keys()))
    return named and len(names - {*COLUMNS, NOTE, ""}) <= 1


def read(path: Path, stated: StatedFacts) -> MeasuredFile:
    """The readings, one inspection for each part. Raises MSR errors with line and column."""
    text, encoding = read_decoded(path)
    file = csv_of(text, path, KIND)
    endings = {"mm": ("_in",), "inch": ("_mm", "_um"), None: ()}[stated.unit]
    if others := [name for name in file.header if name in {*READ, *PLACES} and name.endswith(endings)]:
        raise Code.MSR_UNIT.refusal(
            f"the unit is stated as {stated.unit}, and the column {others[0]!r} states another",
            hint="leave out the stated unit (`gauging.readings_unit`, `--unit`): the columns of gauge readings have "
            "theirs; or correct the heading",
            place=Place(str(path), 1),
            values={"file": path.name},
        )
    table = _Table(file.rows(COLUMNS), _statements(file))
    rows = [row for k in range(len(table.rows)) if (row := _row(table, k)) is not None]
    require_serials([row.part[1] for row in rows], lambda k: Place(str(path), rows[k].reading.line))
    grouped: defaultdict[tuple[str, str], list[_Row]] = defaultdict(list)
    for row in rows:
        grouped[row.part].append(row)
    sha256 = sha256_of(path.read_bytes())
    inspections = tuple(_inspection(part, group, sha256) for part, group in grouped.items())
    empty = len(table.rows) - len(rows)
    stating = [(row.reading, *row.deviation) for row in rows if row.deviation is not None]
    remarks = (
        *((Remark(f"{empty} of {len(table.rows)} rows have no value: not measured"),) if empty else ()),
        *stated_deviations(stating),
        *filled_in(inspections),
    )
    inch = any(name.endswith("_in") for name in file.header)
    sizes = [reading for of in inspections for reading in of.readings if reading.characteristic]
    limited = [size for size in sizes if (size.lower_limit, size.upper_limit) != (None, None)]
    asked = characteristics_of(limited)
    return MeasuredFile(
        path=path,
        format=FORMAT.name,
        encoding=encoding,
        unit="inch" if inch else "mm",
        inspections=inspections,
        characteristics=asked,
        remarks=remarks,
        deviations=by_reading(one for one in stating if one[0].nominal is None),
    )


FORMAT: Final = Format("gauge readings (CSV)", recognises, read)


def holds_readings(path: Path) -> bool:
    """Returns whether a file is there and is more than a sheet without a value: also where it is of another kind."""
    if not path.exists():
        return False
    try:
        return not recognises(path, path.read_bytes()) or bool(read(path, StatedFacts()).inspections)
    except TrueloopError:
        return True


@dataclass(frozen=True)
class _Table:
    """The rows, and what comments above state for all of them, with their lines."""

    rows: Rows
    above: Mapping[str, tuple[str, int]]

    @cached_property
    def columns(self) -> Mapping[str, Sequence[str]]:
        """The texts of every column; of numbers, empty where a cell states none."""
        texts = {name: self.rows.texts(name) for name in self.rows.header}
        return {name: ["" if name in NUMBERS and is_empty(text) else text for text in of] for name, of in texts.items()}

    @cached_property
    def present(self) -> frozenset[str]:
        """All names under which anything is said."""
        return frozenset(self.rows.header) | self.above.keys()

    def cell(self, k: int, name: str) -> str:
        """The text of one column in row k; empty where there is no such column."""
        return self.columns[name][k] if name in self.columns else ""

    def text(self, k: int, name: str) -> str:
        """A cell of row k; where it is empty, what a comment states."""
        if name not in self.present:
            return ""
        return self.cell(k, name) or self.above.get(name, ("", 0))[0]

    def number(self, k: int, name: str) -> float | None:
        """Returns a cell as a number; None where it is empty. Raises MSR-NUMBER."""
        text = self.text(k, name)
        if not text:
            return None
        line, column = self.place(k, name)
        return number_in(text, self.rows.path, line, column)

    def place(self, k: int, name: str) -> tuple[int, int | None]:
        """Line and column of that."""
        if self.cell(k, name):
            return self.rows.lines[k], self.rows.header.index(name) + 1
        return self.above[name][1], None

    def refusal(self, k: int, why: str, name: str, hint: str) -> TrueloopError:
        """MSR-COLUMN at a cell."""
        column = self.rows.header.index(name) + 1 if name in self.rows.header else None
        return Code.MSR_COLUMN.refusal(why, hint=hint, place=Place(str(self.rows.path), self.rows.lines[k], column))

    def one_of(self, k: int, names: Collection[str], what: str) -> str | None:
        """The only one of these that has a value in row k; None where none has. Raises MSR-COLUMN for two."""
        found = [name for name in names if name in self.present and self.text(k, name)]
        if len(found) > 1:
            why = f"{found[0]!r} and {found[1]!r} both have a value: {len(found)} columns say {what}"
            raise self.refusal(k, why, found[1], "write one reading a row")
        return found[0] if found else None


@dataclass(frozen=True)
class _Row:
    """A reading of a part (type, serial) by an instrument and an operator, and the deviation that the file states."""

    reading: Reading
    part: tuple[str, str]
    device: str
    operator: str
    deviation: tuple[float, float] | None


def _row(table: _Table, k: int) -> _Row | None:
    """A row's reading; None where it has no value."""
    column = table.one_of(k, READ, "what was read")
    if column is None:
        return None
    quantity, factor = VALUES[column] if column in VALUES else (_quantity(table, k, column), OF_QUANTITY[column])
    value = table.number(k, column)
    assert value is not None
    nominal, lower, upper, deviation = (_scaled(table.number(k, name), factor) for name in IN_ITS_UNIT)
    feature, place = table.text(k, "feature"), _place(table, k)
    at = "".join(f" {axis} {number:g}" for axis, number in zip("xz"[-len(place) :], place, strict=False))
    uncertainty = table.one_of(k, UNCERTAINTIES, "the uncertainty")
    reading = Reading(
        characteristic=table.text(k, "characteristic") or f"{feature} {quantity}{at}",
        quantity=quantity,
        actual=value * factor,
        nominal=nominal,
        lower_limit=lower,
        upper_limit=upper,
        feature=feature,
        other=table.text(k, "from"),
        place_mm=place,
        axis=_axis(table, k),
        standard_u=None if uncertainty is None else _positive(table, k, uncertainty) * UNCERTAINTIES[uncertainty],
        measured_at=_moment(table, k),
        temperature_c=table.number(k, "temperature_c"),
        line=table.rows.lines[k],
    )
    part, serial, device, operator = (table.text(k, name) for name in ("part", "serial", "instrument", "operator"))
    printed = [table.text(k, name) for name in (column, "deviation")]  # a nominal of 20 is exact
    stated = None if deviation is None else (deviation, factor * half_digits(*printed))
    return _Row(reading, (part, serial), device, operator, stated)


def _quantity(table: _Table, k: int, column: str) -> Quantity:
    text = table.text(k, "quantity").lower()
    if text not in tuple(Quantity) or (Quantity(text) is Quantity.ANGLE) != (column == "value_deg"):
        why = f"quantity is {text!r}, which {column} is no value of"
        raise table.refusal(k, why, column, f"write one of {', '.join(Quantity)}; an angle's value is value_deg")
    return Quantity(text)


def _axis(table: _Table, k: int) -> Literal["", "x", "y", "z"]:
    text = table.text(k, "axis").lower()
    for one in AXES:
        if text == one:
            return one
    raise table.refusal(k, f"axis is {text!r}", "axis", "write x, y or z, or leave it empty")


def _place(table: _Table, k: int) -> tuple[float, ...]:
    """(z) or (x, z), mm, x a radius."""
    found = {}
    for axis in "xz":
        name = table.one_of(k, ALONG[axis], axis)
        found[axis] = None if name is None else _scaled(table.number(k, name), PLACES[name][1])
    x, z = found["x"], found["z"]
    if x is not None and z is None:
        raise table.refusal(k, f"x is {x:g} mm and z is empty: half a place", "feature", "give z, or z and x")
    return () if z is None else (z,) if x is None else (x, z)


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor


def _positive(table: _Table, k: int, name: str) -> float:
    value = table.number(k, name)
    if value is None or not 0.0 < value < math.inf:
        raise table.refusal(k, f"{name} is {value:g}: an uncertainty is above 0", name, "leave it empty if unknown")
    return value


def _moment(table: _Table, k: int) -> datetime | None:
    """Date and time; without a zone it is the clock on the wall here."""
    text = table.text(k, "measured_at")
    if not text:
        return None
    try:
        return datetime.fromisoformat(text).astimezone()
    except (ValueError, OverflowError, OSError) as error:
        line, column = table.place(k, "measured_at")
        raise Code.MSR_NUMBER.refusal(
            f"measured_at is {text!r}, no date with a time of 24 h",
            hint="write 2026-11-23 14:05, with the zone or without",
            place=Place(str(table.rows.path), line, column),
            values={"text": text},
        ) from error


def _inspection(part: tuple[str, str], rows: list[_Row], sha256: str) -> Inspection:
    readings = numbered(row.reading for row in rows)
    times = [reading.measured_at for reading in readings if reading.measured_at is not None]
    return Inspection(
        part=Part(PartType(part[0]), part[1]),
        measured="readings",
        sha256=sha256,
        count=len(readings),
        values=readings,
        device=listed(row.device for row in rows),
        operator=listed(row.operator for row in rows),
        measured_at=min(times, default=None),
        devices=devices_of((row.reading.characteristic, row.device) for row in rows),
    )


def _statements(file: CsvFile) -> dict[str, tuple[str, int]]:
    """Returns the values of comments `# key: value`, with their lines; other comments are left alone.

    Raises MSR-COLUMN for a key stated twice and for one that is nearly a known one: it would be ignored.
    """
    found: dict[str, tuple[str, int]] = {}
    for line, comment in file.comments:
        stated = STATEMENT.fullmatch(comment)
        key = stated[1].lower() if stated else ""
        near = difflib.get_close_matches(key, KEYS, n=1, cutoff=0.75)
        if stated and (key in found or (near and key not in KEYS)):
            why = f"{key!r} is stated twice" if key in found else f"{key!r} is not one of {len(KEYS)} keys"
            hint = "keep one of them" if key in found else f"did you mean {near[0]!r}?"
            raise Code.MSR_COLUMN.refusal(why, hint=hint, place=Place(str(file.path), line))
        if stated and key in KEYS:
            found[key] = stated[2], line
    return found


SHEET_STATED: Final = ("serial", "instrument", "expanded_uncertainty_um", "operator", "measured_at", "temperature_c")
"""Columns that may be stated once for all rows, as comments."""
DECIMALS: Final = {"mm": 4, "inch": 5}


def gauge_sheet_csv(
    planned: Sequence[Characteristic],
    unit: Literal["mm", "inch"] = "mm",
    values: Mapping[str, Sequence[str]] = MappingProxyType({}),
    stated: Mapping[str, str] = MappingProxyType({}),
) -> str:
    """Lengths and diameters as rows that `gauge_csv` reads once they have values; rows without are passed over.

    `values` as they were read, by the name of the size: a row for each. `stated` for all rows, by `SHEET_STATED`.
    """
    per, ending = (1.0, "mm") if unit == "mm" else (MM_PER_INCH, "in")

    def number(value: float | None) -> str:
        return "" if value is None else f"{value / per:.{DECIMALS[unit]}f}"

    out = io.StringIO()
    out.write("".join(f"# {key}: {stated.get(key, '')}".rstrip() + "\n" for key in SHEET_STATED))
    writer = csv.writer(out, lineterminator="\n")
    limits = (
        ("lower_limit", "upper_limit")
        if any(characteristic.lower_limit or characteristic.upper_limit for characteristic in planned)
        else ()
    )
    writer.writerow(
        ("characteristic", "feature", "from", "quantity", f"z_{ending}", "nominal", *limits, f"value_{ending}")
    )
    for characteristic in planned:
        row = (
            characteristic.name,
            characteristic.feature,
            characteristic.other,
            characteristic.quantity.value,
            number(characteristic.at_z_mm),
            number(characteristic.nominal),
        )
        bounds = [number(getattr(characteristic, name)) for name in limits]
        writer.writerows((*row, *bounds, value) for value in values.get(characteristic.name) or ("",))
    return out.getvalue()
