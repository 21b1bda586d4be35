"""Measuring logs of Heidenhain's cycles 400 to 431, `TCHPR421.TXT`: nominal values, limits, actual values, deviations.

    Measuring log from touch probe cycle 421 Hole Measuring
    Nominal values:
    Diameter: 12.0000
    Given limit values:
    Maximum dimension for hole: 12.0450
    Actual values:
    Diameter: 12.0259

From memory of the manual's example; sections and names are matched by their beginnings, in English and in German. The
ball is taken off by the cycle. Lines of numbers that FN 15 and FN 16 write are read as a log of positions.
"""

import re
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path
from typing import Final, Literal

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Inspection, Reading
from trueloop.formats.inspections.controls.meaning import MM_PER, Meaning, inspection_of, meaning_of, unit_of
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Remark, StatedFacts
from trueloop.formats.inspections.shared.checks import stated_deviations
from trueloop.formats.inspections.shared.text import NUMBER, beginning, number_in, read_decoded

HEADING: Final = re.compile(
    r"\s*(?:Measuring log from touch probe cycle|Messprotokoll (?:vom )?Tastsystem-?zyklus)\b.*", re.I
)
SECTIONS: Final = {
    "nominal": "nominal",
    "sollwert": "nominal",
    "given limit": "limits",
    "limit": "limits",
    "vorgegebene grenz": "limits",
    "grenzwert": "limits",
    "actual": "actual",
    "istwert": "actual",
    "deviation": "deviation",
    "abweichung": "deviation",
    "further": "further",
    "weitere": "further",
    "end of": "end",
    "ende": "end",
}
"""Beginnings of the headings of sections."""
UPPER: Final = re.compile(r"(?:Max|Größt|Groesst)\S*\s+", re.I)
LOWER: Final = re.compile(r"(?:Min|Kleinst)\S*\s+", re.I)
AXES: Final[dict[str, Literal["x", "y"]]] = {"reference": "x", "haupt": "x", "minor": "y", "neben": "y"}
ROW: Final = re.compile(rf"\s*([^:]+?)\s*:\s*({NUMBER.pattern})\s*(?:°|mm|inch)?\s*")
LAST_DIGIT: Final = 1e-4
"""The last digit of the values in a log."""
WHEN: Final = re.compile(r"\s*(?:Date|Datum)\s*:\s*(\d\d)[-.](\d\d)[-.](\d{4})\s*", re.I)
AT: Final = re.compile(r"\s*(?:Time|Uhrzeit|Zeit)\s*:\s*(\d{1,2}):(\d\d):(\d\d)\s*", re.I)


@dataclass
class _Log:
    """One log while its lines are read: by section, what its rows say, in the file's unit."""

    line: int
    rows: dict[str, list[tuple[str, float, int]]] = field(default_factory=dict)
    date: tuple[int, int, int] | None = None
    time: tuple[int, int, int] = (0, 0, 0)


def recognises(path: Path, head: bytes) -> bool:
    """Returns whether a line is the heading of such a log."""
    return any(HEADING.fullmatch(line) for line in beginning(head).splitlines())


def read(path: Path, stated: StatedFacts) -> MeasuredFile:
    """Reads one inspection a log: a file may have several. Raises MSR-UNIT, MSR-MAPPING."""
    text, encoding = read_decoded(path)
    meaning = meaning_of(stated)
    unit = unit_of(stated, meaning, path)
    logs, remarks = _logs(text, path)
    parts = tuple(_inspection(path, meaning, log, MM_PER[unit], remarks) for log in logs)
    return MeasuredFile(path, FORMAT.name, encoding, unit, parts, remarks=tuple(remarks))


FORMAT: Final = Format("measuring log of Heidenhain cycles", recognises, read)


def _logs(text: str, path: Path) -> tuple[list[_Log], list[Remark]]:
    logs: list[_Log] = []
    remarks: list[Remark] = []
    section = ""
    for number, line in enumerate(text.splitlines(), 1):
        if HEADING.fullmatch(line):
            logs.append(_Log(number))
            section = ""
        elif logs and (row := ROW.fullmatch(line.replace("\N{DEGREE SIGN}", " "))) and section:
            logs[-1].rows.setdefault(section, []).append((row[1], number_in(row[2], path, number), number))
        elif logs and (date := WHEN.fullmatch(line)):
            logs[-1].date = int(date[3]), int(date[2]), int(date[1])
        elif logs and (time := AT.fullmatch(line)):
            logs[-1].time = int(time[1]), int(time[2]), int(time[3])
        elif named := _section(line):
            section = named
        elif line.strip() and section:
            remarks.append(Remark(f"not understood: {line.strip()[:60]!r}", number))
    return logs, remarks


def _section(line: str) -> str:
    start = line.strip().lower()
    return next((section for beginning, section in SECTIONS.items() if start.startswith(beginning)), "")


def _inspection(path: Path, meaning: Meaning, log: _Log, mm_per_unit: float, remarks: list[Remark]) -> Inspection:
    nominal = {name: value for name, value, _ in log.rows.get("nominal", [])}
    deviations = {name: value for name, value, _ in log.rows.get("deviation", [])}
    limits = _limits(log)
    readings: list[Reading] = []
    stated = []
    for name, actual, line in log.rows.get("actual", []):
        quantity = _quantity(name)
        scale = 1.0 if quantity is Quantity.ANGLE else mm_per_unit
        lower, upper = limits.get(_kind(name), (None, None))
        readings.append(
            Reading(
                characteristic=name,
                quantity=quantity,
                actual=actual * scale,
                nominal=nominal[name] * scale if name in nominal else None,
                lower_limit=None if lower is None else lower * scale,
                upper_limit=None if upper is None else upper * scale,
                axis=_axis(name) if quantity is Quantity.POSITION else "",
                line=line,
            )
        )
        if name in deviations:
            stated.append((readings[-1], deviations[name] * scale, 1.5 * LAST_DIGIT * scale))
    remarks += stated_deviations(stated)
    inspection = inspection_of(path, meaning, readings)
    return inspection if log.date is None else replace(inspection, measured_at=_moment(log.date, log.time))


def _limits(log: _Log) -> dict[str, tuple[float | None, float | None]]:
    """Absolute limits (lower, upper) by what they are limits of: x, y or the size."""
    found: dict[str, tuple[float | None, float | None]] = {}
    for name, value, _ in log.rows.get("limits", []):
        lower, upper = found.get(_kind(name), (None, None))
        if UPPER.match(name):
            found[_kind(name)] = lower, value
        elif LOWER.match(name):
            found[_kind(name)] = value, upper
    return found


def _kind(name: str) -> str:
    return _axis(name) or "size"


def _axis(name: str) -> Literal["", "x", "y"]:
    """The axis of the working plane that a name is of; it is taken to be XY."""
    return next((axis for word, axis in AXES.items() if word in name.lower()), "")


def _quantity(name: str) -> Quantity:
    low = name.lower()
    if _axis(name):
        return Quantity.POSITION
    if "diameter" in low or "durchmesser" in low:
        return Quantity.DIAMETER
    if "angle" in low or "winkel" in low:
        return Quantity.ANGLE
    return Quantity.LENGTH if any(word in low for word in ("length", "width", "länge", "breite")) else Quantity.OTHER


def _moment(date: tuple[int, int, int], time: tuple[int, int, int]) -> datetime | None:
    """Local time of the control; None where there is no such day."""
    try:
        return datetime(*date, *time).astimezone()
    except (ValueError, OverflowError):
        return None
