"""Inspection files as they were read, and what of them is on a part: rows of a table, and JSON."""

import math
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, replace

from trueloop.domain.inspection import CmmPoint, Inspection, Reading, Touch
from trueloop.errors import Finding
from trueloop.formats.inspections.measured_file import MeasuredFile
from trueloop.formats.inspections.shared.checks import within
from trueloop.turned.readings.matches import MatchedReading, MatchedTouch, Matches


@dataclass(frozen=True)
class OnPart:
    """One inspection of a file, its `run`-th from 1; `matches` and `findings` where a part is given."""

    run: int
    inspection: Inspection
    matches: Matches | None = None
    findings: tuple[Finding, ...] = ()


@dataclass(frozen=True)
class FileOnPart:
    """A file, its inspections that are meant, and the part that they were matched with: its name, its features."""

    file: MeasuredFile
    on_part: tuple[OnPart, ...]
    part: str = ""
    features: tuple[str, ...] = ()


@dataclass(frozen=True)
class ValueRow:
    """One value. `nominal`, `actual`, `deviation` and limits are in `unit`, of touches the deviation alone, along n.

    `feature` is that of the part where `by` says how it was found ("name" or "geometry", `distance_mm` away), else that
    of the file; `reason` says why it was not found. `within`: whether it is inside its limits, None without limits.
    """

    characteristic: str
    quantity: str
    feature: str = ""
    by: str = ""
    distance_mm: float | None = None
    nominal: float | None = None
    actual: float | None = None
    deviation: float | None = None
    lower_limit: float | None = None
    upper_limit: float | None = None
    within: bool | None = None
    unit: str = "mm"
    place_mm: tuple[float, ...] = ()
    repeat: int = 1
    line: int | None = None
    reason: str = ""
    is_error: bool = True
    candidates: tuple[str, ...] = ()


def rows_of(file: FileOnPart, on_part: OnPart) -> Iterator[ValueRow]:
    """Yields all values: those that were matched, in order along the part, then the others with the reason."""
    matches = on_part.matches
    if matches is None:
        yield from map(_row, on_part.inspection.values)
        return
    found: tuple[MatchedReading | MatchedTouch, ...] = (*matches.readings, *matches.touches)
    yield from (_matched(file, one) for one in sorted(found, key=lambda one: one.feature_index))
    for left in matches.left:
        yield replace(_row(left.value), reason=left.reason, is_error=left.is_error, candidates=left.candidates)


def measured_as_dict(files: Iterable[FileOnPart]) -> dict[str, object]:
    """Converts files to a dict: lengths mm, angles degrees, deviations actual − nominal, x a radius."""
    return {"files": [_file_as_dict(part) for part in files]}


def _file_as_dict(on_part: FileOnPart) -> dict[str, object]:
    file = on_part.file
    return {
        "file": str(file.path),
        "format": file.format,
        "encoding": file.encoding,
        "unit": file.unit,
        "part_of_job": on_part.part or None,
        "inspections": [_inspection_as_dict(on_part, each) for each in on_part.on_part],
        "characteristics": [asdict(each) for each in file.characteristics],
        "remarks": [asdict(each) for each in file.remarks],
    }


def _inspection_as_dict(file: FileOnPart, on_part: OnPart) -> dict[str, object]:
    inspection, matches = on_part.inspection, on_part.matches
    moment = inspection.measured_at
    return {
        "run": on_part.run,
        "part": inspection.part.part_type.name,
        "serial": inspection.part.serial,
        "measured": inspection.measured,
        "count": inspection.count,
        "measured_at": None if moment is None else moment.isoformat(),
        "device": inspection.device,
        "operator": inspection.operator,
        "frame": inspection.frame,
        "ball_radius_mm": inspection.ball_radius_mm,
        "temperatures": dict(inspection.temperatures),
        "matched": None if matches is None else matches.count,
        "not_matched": None if matches is None else len(matches.unmatched),
        "kept": None if matches is None else len(matches.kept),
        "spindle_axis": None if matches is None else matches.axis,
        "values": [_finite(vars(row)) for row in rows_of(file, on_part)],
        "findings": [
            {"severity": f.severity, "code": f.code, "message": f.message, "hint": f.hint, "values": dict(f.values)}
            for f in on_part.findings
        ],
    }


def _finite(row: dict[str, object]) -> dict[str, object]:
    """JSON has no nan and no infinity: null."""
    return {key: None if isinstance(one, float) and not math.isfinite(one) else one for key, one in row.items()}


def _matched(file: FileOnPart, match: MatchedReading | MatchedTouch) -> ValueRow:
    name = file.features[match.feature_index]
    if isinstance(match, MatchedReading) and match.other_index is not None:
        name = f"{name} to {file.features[match.other_index]}"
    value = match.reading if isinstance(match, MatchedReading) else match.touch
    return replace(_row(value), feature=name, by=match.by, distance_mm=match.distance_mm)


def _row(value: Reading | Touch | CmmPoint) -> ValueRow:
    """A value as the file has it."""
    if isinstance(value, CmmPoint):
        return ValueRow(value.name, "point", place_mm=value.nominal_mm or value.measured_mm)
    if isinstance(value, Touch):
        error_mm, name = value.error_mm, value.feature or ""
        return ValueRow(value.point, "touch", name, deviation=error_mm, place_mm=value.nominal_mm, line=value.line)
    return ValueRow(
        value.characteristic,
        value.quantity.value,
        value.feature,
        nominal=value.nominal,
        actual=value.actual,
        deviation=None if value.nominal is None else value.actual - value.nominal,
        lower_limit=value.lower_limit,
        upper_limit=value.upper_limit,
        within=within(value),
        unit=value.quantity.unit,
        place_mm=value.place_mm,
        repeat=value.repeat,
        line=value.line,
    )
