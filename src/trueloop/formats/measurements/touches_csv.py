"""Touches as CSV: `point`, `feature` (optional), a nominal point, and a measured point or an error.

Columns carry their unit: `nominal_x_mm`, `nominal_x_in`, `nominal_x_diameter_mm`, `nominal_x_diameter_in`,
`nominal_z_mm`, `nominal_z_in`; the same with `measured_`; or `error_um`, `error_mm`, `error_in`. Lines beginning with
`#` are comments. Separator comma, semicolon or tab, found from the header; a decimal comma needs the semicolon or tab.

The log of a control while probing: one position a touch.

LinuxCNC writes nine numbers a line, X a radius always. The others write lines with `X…` and `Z…` as the probing program
has them, X in the program's mode; blanks within a number's field are Fanuc's leading zeros.
"""

import csv
import io
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

from trueloop.arrays import Array
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading, Touch
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import FilePath, read_text
from trueloop.formats.measurements.rows import CsvFile, CsvKind, Rows, csv_cell, read_csv
from trueloop.geometry.feature import Point
from trueloop.units import MM_PER_INCH, UM_PER_MM

COLUMNS: Final = (
    *("characteristic", "feature", "from", "quantity", "z_mm", "x_mm", "value_mm", "value_deg"),
    *("nominal", "lower_limit", "upper_limit", "serial", "measured_at", "temperature_c"),
)


def readings_to_csv(inspections: Iterable[tuple[Inspection, Iterable[Reading]]]) -> str:
    """Returns the readings of inspections; mm, angles in degrees, x a radius. Limits are absolute."""
    text = io.StringIO()
    out = csv.writer(text, lineterminator="\n")
    out.writerow(COLUMNS)
    for inspection, readings in inspections:
        for reading in readings:
            out.writerow(_row(inspection, reading))
    return text.getvalue()


def _row(inspection: Inspection, reading: Reading) -> list[str]:
    """One reading; what is not stated is empty."""
    value, angle = _number(reading.actual), reading.quantity is Quantity.ANGLE
    place = reading.place_mm[-2:]
    moment = reading.measured_at or inspection.measured_at
    return [
        *(reading.characteristic, reading.feature, reading.other, reading.quantity.value),
        _number(place[-1]) if place else "",
        _number(place[0]) if len(place) == 2 else "",
        *(("", value) if angle else (value, "")),
        *(_number(one) for one in (reading.nominal, reading.lower_limit, reading.upper_limit)),
        inspection.part.serial,
        "" if moment is None else moment.isoformat(),
        _number(reading.temperature_c),
    ]


def _number(value: float | None) -> str:
    """To a nanometre: below what any gauge reads."""
    return "" if value is None else f"{value:.6f}".rstrip("0").rstrip(".")


LENGTH_MM: Final = {"um": 1 / UM_PER_MM, "mm": 1.0, "in": MM_PER_INCH}
X_SUFFIXES: Final = {"x_mm": 1.0, "x_in": MM_PER_INCH, "x_diameter_mm": 0.5, "x_diameter_in": MM_PER_INCH / 2}
Z_SUFFIXES: Final = {"z_mm": 1.0, "z_in": MM_PER_INCH}
ERROR_COLUMNS: Final = {f"error_{unit}": factor for unit, factor in LENGTH_MM.items()}

HINT: Final = (
    "`gauging.touches` in the job names a CSV file in UTF-8, relative to the job: point,feature,nominal_x_mm, …"
)
KIND: Final = CsvKind(Code.TCH_FILE, Code.TCH_COLUMN, Code.TCH_NUMBER, HINT)
KNOWN: Final = (
    *("point", "feature", *ERROR_COLUMNS),
    *(prefix + name for prefix in ("nominal_", "measured_") for name in (*X_SUFFIXES, *Z_SUFFIXES)),
)


def read_touches(path: FilePath) -> list[Touch]:
    """Touches of a CSV file in its order. Raises TCH errors with line (and column) of what cannot be read.

    >>> touches = trueloop.read_touches(trueloop.example("modbas2/touches.csv"))
    >>> touches[0].point, touches[0].feature, touches[0].nominal_mm, round(touches[0].error_mm, 6)
    ('1', 'cone', (63.87211, -149.1631), 0.090297)
    """
    file = read_csv(Path(path), KIND)
    rows = file.rows(KNOWN)
    measured, errors = _points(file, rows, "measured_"), _column(file, rows, "", ERROR_COLUMNS)
    if measured is None and errors is None:
        raise _incomplete(file, rows)
    return _touches(file, rows, measured, errors)


def read_planned(path: Path) -> list[Touch]:
    """Reads the points of such a file that are to be touched, with errors of 0, whatever its cells for what is measured
    hold. Raises TCH errors.
    """
    file = read_csv(path, KIND)
    rows = file.rows(KNOWN)
    return _touches(file, rows, None, [0.0] * len(rows))


def holds_touches(path: Path) -> bool:
    """Returns whether a file is there and has a measured value. Raises TCH errors."""
    if not path.exists():
        return False
    rows = read_csv(path, KIND).rows(KNOWN)
    return any(any(rows.texts(name)) for name in rows.header if name.startswith(("measured_", "error_")))


def _incomplete(file: CsvFile, rows: Rows) -> TrueloopError:
    return file.refusal(
        f"the header {list(rows.header)} does not say point, nominal x and z, and measured x and z or an error",
        hint="for instance: point,feature,nominal_x_mm,nominal_z_mm,error_um",
    )


def _touches(
    file: CsvFile, rows: Rows, measured: Sequence[Point] | None, errors: Sequence[float] | None
) -> list[Touch]:
    nominal = _points(file, rows, "nominal_")
    if "point" not in rows.header or nominal is None:
        raise _incomplete(file, rows)
    return [
        Touch(
            point=point,
            nominal_mm=nominal[k],
            feature=feature or None,
            measured_mm=None if measured is None else measured[k],
            error_mm=None if errors is None else errors[k],
            line=rows.lines[k],
        )
        for k, (point, feature) in enumerate(zip(rows.texts("point"), rows.texts("feature"), strict=True))
    ]


def touches_to_csv(touches: Sequence[Touch]) -> str:
    """Touches whose part errors are known, as the CSV that `read_touches` reads, with `error_um`."""
    lines = ["point,feature,nominal_x_mm,nominal_z_mm,error_um"]
    for touch in touches:
        assert touch.error_mm is not None
        x, z = touch.nominal_mm
        lines.append(
            f"{csv_cell(touch.point)},{csv_cell(touch.feature or '')},{x:.6f},{z:.6f},{touch.error_mm * UM_PER_MM:.3f}"
        )
    return "\n".join([*lines, ""])


def empty_touches_csv(features: Sequence[str], nominal_mm: Array, unit: Literal["mm", "inch"] = "mm") -> str:
    """Points (n, 2) that are to be touched, numbered from 1, with empty cells for what is measured there."""
    ending, per = ("in", MM_PER_INCH) if unit == "inch" else ("mm", 1.0)
    places = [f"{what}_{axis}_{ending}" for what in ("nominal", "measured") for axis in "xz"]
    rows = [
        f"{k},{csv_cell(feature)},{x / per:.6f},{z / per:.6f},,"
        for k, (feature, (x, z)) in enumerate(zip(features, nominal_mm.tolist(), strict=True), 1)
    ]
    return "\n".join([",".join(["point", "feature", *places]), *rows, ""])


def _points(file: CsvFile, rows: Rows, prefix: str) -> list[Point] | None:
    """Points (x, z) in mm, x a radius; None where the file has none of that kind."""
    x, z = (_column(file, rows, prefix, suffixes) for suffixes in (X_SUFFIXES, Z_SUFFIXES))
    return None if x is None or z is None else list(zip(x, z, strict=True))


def _column(file: CsvFile, rows: Rows, prefix: str, factors: Mapping[str, float]) -> list[float] | None:
    """The values in mm of the one column that says it, in whichever unit; None where none does."""
    found = [(prefix + name, factor) for name, factor in factors.items() if prefix + name in rows.header]
    if len(found) > 1:
        why = f"{found[0][0]!r} and {found[1][0]!r} say the same thing in {len(found)} columns"
        raise file.refusal(why, hint="keep one of them")
    values: list[float] | None = (rows.numbers(found[0][0]) * found[0][1]).tolist() if found else None
    return values


NUMBER: Final = r"([-+]?\s*[\d.]+(?:EX?[-+]?\d+)?)"
"""Fanuc may write blanks for leading zeros, behind the sign; Siemens an exponent as EX."""
WORDS: Final = re.compile(rf"X\s*{NUMBER}\s*Z\s*{NUMBER}(?![\w.])", re.IGNORECASE)
LINUXCNC_NUMBERS: Final = 9


@dataclass(frozen=True)
class LoggedTouch:
    """A position as logged, (x, z) in mm with x a radius, and its line."""

    position_mm: Point
    line: int


def read_probe_log(path: Path, control: str, *, inch: bool = False, diameter: bool = True) -> list[LoggedTouch]:
    """Reads the touches of a log in its order. Raises PRB-LOG for lines that are none, and for a log without any."""
    text = read_text(path, Code.PRB_LOG, hint="name the file that the probing program wrote")
    return parse_probe_log(text, str(path), control, inch=inch, diameter=diameter)


def parse_probe_log(
    text: str, name: str, control: str, *, inch: bool = False, diameter: bool = True
) -> list[LoggedTouch]:
    """Parses the text of a probe log; `name` is used in errors."""
    scale = MM_PER_INCH if inch else 1.0
    x_scale = scale if control == "linuxcnc" or not diameter else scale / 2
    touches = []
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip() or line.strip() in ("%", "MISSED"):
            continue
        pair = _numbers(line) if control == "linuxcnc" else _words(line)
        if pair is None or not all(map(math.isfinite, pair)):
            raise Code.PRB_LOG.refusal(
                f"{line.strip()!r} is no touch as {control} writes it",
                hint="LinuxCNC writes nine numbers a line, the others X and Z; name the control with --control",
                place=Place(name, number),
            )
        touches.append(LoggedTouch((pair[0] * x_scale, pair[1] * scale), number))
    if not touches:
        raise Code.PRB_LOG.refusal(
            f"{name!r} holds 0 touches",
            hint="did the program run to its end? LinuxCNC writes the file when it comes to LOGCLOSE",
            place=Place(name),
        )
    return touches


def _numbers(line: str) -> Point | None:
    words = line.split()
    try:
        values = [float(word) for word in words]
    except ValueError:
        return None
    return (values[0], values[2]) if len(values) == LINUXCNC_NUMBERS else None


def _words(line: str) -> Point | None:
    found = WORDS.search(line)
    try:
        return (_value(found[1]), _value(found[2])) if found else None
    except ValueError:
        return None


def _value(text: str) -> float:
    return float("".join(text.upper().split()).replace("EX", "E"))
