"""Reports of drilled plates: a title with date, then a row a hole with measured, nominal and error of x, y, diameter.

    Meas X    Meas Y     Nom X     Nom Y     Err X     Err Y  Meas D   Nom D   Round

Errors are measured − nominal. The report names no unit. `formats/measurements/plate_report.py` reads the same rows as a
plate that a machine is identified from.
"""

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading
from trueloop.domain.part import Part, PartType
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Remark, StatedFacts
from trueloop.formats.inspections.shared.checks import filled_in, half_digits, numbered, stated_deviations
from trueloop.formats.inspections.shared.quantities import AXES, characteristics_of
from trueloop.formats.inspections.shared.text import beginning, moment, number_in, order_of, read_decoded
from trueloop.units import MM_PER_INCH

HEADING: Final = "Meas X Meas Y Nom X Nom Y Err X Err Y Meas D Nom D Round".lower().split()
COLUMNS: Final = 9
TITLE: Final = re.compile(r"\s*([A-Za-z ]+?)\s*:\s*(\S.*?)\s*")


def recognises(path: Path, head: bytes) -> bool:
    """Returns whether the file has the line of headings."""
    return any(_is_heading(line) for line in beginning(head).splitlines())


def read(path: Path, stated: StatedFacts) -> MeasuredFile:
    """Reads the plate as one part, four readings a hole. Raises MSR-UNIT, MSR-NUMBER, MSR-VALUE, MSR-TIME."""
    text, encoding = read_decoded(path)
    lines = list(enumerate(text.splitlines(), 1))
    at = next(k for k, (_, line) in enumerate(lines) if _is_heading(line))
    if stated.unit is None:
        raise _refusal(
            Code.MSR_UNIT, f"{path.name!r} names no unit", "state it: --unit mm or --unit inch", path, at + 1
        )
    rows = [(line, content.split()) for line, content in lines[at + 1 :] if content.strip()]
    holes = [(line, cells) for line, cells in rows if len(cells) == COLUMNS]
    if not holes:
        raise _refusal(
            Code.MSR_VALUE, f"{path.name!r} has 0 holes in {len(rows)} rows", "export it again", path, at + 1
        )
    title = {found[1]: found[2] for _, line in lines[:at] if (found := TITLE.fullmatch(line))}
    date, place = title.pop("Date", ""), Place(str(path), 1)
    kind, serial = next(iter(title.items()), ("", ""))
    factor = MM_PER_INCH if stated.unit == "inch" else 1.0
    read_holes = [_hole(number, cells, path, line, factor) for number, (line, cells) in enumerate(holes, 1)]
    readings = numbered(reading for hole in read_holes for reading, _, _ in hole)
    inspection = Inspection(
        part=Part(PartType(kind), serial),
        measured="readings",
        sha256=sha256_of(path.read_bytes()),
        count=len(readings),
        values=readings,
        measured_at=moment(date, order_of([date], place), place),
    )
    others = [line for line, cells in rows if len(cells) != COLUMNS]
    remarks = [Remark(f"{len(others)} rows have not {COLUMNS} numbers", others[0])] if others else []
    deviations = [
        (reading, error, rounding) for hole in read_holes for reading, error, rounding in hole if error is not None
    ]
    return MeasuredFile(
        path=path,
        format="report of a drilled plate",
        encoding=encoding,
        unit=stated.unit,
        inspections=(inspection,),
        characteristics=characteristics_of(readings),
        remarks=(*remarks, *stated_deviations(deviations), *filled_in([inspection])),
    )


def _hole(
    number: int, cells: Sequence[str], path: Path, line: int, factor: float
) -> list[tuple[Reading, float | None, float]]:
    """Two coordinates with their errors, the diameter, the roundness."""
    x, y, nominal_x, nominal_y, error_x, error_y, size, nominal_size, form = (
        number_in(cell, path, line, column) * factor for column, cell in enumerate(cells, 1)
    )
    name = f"hole {number}"
    rounding = half_digits(cells[0], cells[2], cells[4]) * factor

    def reading(what: str, quantity: Quantity, actual: float, nominal: float) -> Reading:
        return Reading(f"{name} {what}", quantity, actual, nominal, feature=name, axis=AXES.get(what, ""), line=line)

    return [
        (reading("x", Quantity.POSITION, x, nominal_x), error_x, rounding),
        (reading("y", Quantity.POSITION, y, nominal_y), error_y, rounding),
        (reading("diameter", Quantity.DIAMETER, size, nominal_size), None, rounding),
        (reading("roundness", Quantity.FORM, form, 0.0), None, rounding),
    ]


def _is_heading(line: str) -> bool:
    return line.lower().split() == HEADING


def _refusal(code: Code, why: str, hint: str, path: Path, line: int) -> TrueloopError:
    return code.refusal(why, hint=hint, place=Place(str(path), line))


FORMAT: Final = Format("report of a drilled plate", recognises, read)
