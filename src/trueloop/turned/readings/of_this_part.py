"""Implausible inspections: another part, another unit, limits that exclude, one name in two places."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Final

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading, Touch, Values, Vector
from trueloop.errors import Code, Finding, Place, Severity
from trueloop.geometry.feature import Point
from trueloop.geometry.profile import Profile
from trueloop.turned.readings.match import match_inspection
from trueloop.turned.readings.matches import Axis, Matches
from trueloop.units import MM_PER_INCH

OF_PART: Final = 0.5
"""An inspection of which less is matched is of another part."""
EXPLAINED: Final = 0.5
"""A factor explains an inspection where it makes this share of what fits nothing fit something."""
FEW: Final = 200
"""The largest number of values that are tried with a factor."""
SAME: Final = 1e-6
BLUNDERS: Final[tuple[tuple[float, str], ...]] = (
    (MM_PER_INCH, "inches taken for millimetres?"),
    (1.0 / MM_PER_INCH, "millimetres taken for inches?"),
)


def check_matches(
    profile: Profile, inspection: Inspection, matches: Matches, names: Mapping[str, str], axis: Axis | None
) -> tuple[Finding, ...]:
    """Returns findings on an inspection of a profile: errors where it must not be used, warnings else."""
    return (
        *_part(profile, inspection, matches, names, axis),
        *_limits(inspection.readings),
        *_two_places(inspection.readings),
    )


def _part(
    profile: Profile, inspection: Inspection, matches: Matches, names: Mapping[str, str], axis: Axis | None
) -> Iterator[Finding]:
    """MSR-SCALE where a factor explains why too little fits, else MSR-PART."""
    values = matches.count + len(matches.unmatched)
    if not matches.unmatched or matches.count >= OF_PART * values:
        return
    tried = replace(inspection, values=tuple(one.value for one in matches.unmatched[:FEW]))
    for factor, question in BLUNDERS:
        scaled = match_inspection(profile, _times(tried, factor), names, axis)
        fitting = scaled.count + sum(bool(one.candidates) for one in scaled.left)
        if fitting >= EXPLAINED * len(tried.values):
            yield Finding(
                Severity.ERROR,
                Code.MSR_SCALE,
                f"{fitting} of {len(tried.values)} values that fit nothing fit when multiplied by {factor:.5f}",
                f"{question} State the file's unit: --unit mm or --unit inch",
                values={"factor": factor, "fitting": fitting, "values": len(tried.values)},
            )
            return
    yield Finding(
        Severity.ERROR,
        Code.MSR_PART,
        f"{matches.count} of {values} values are of this part, by name or by size",
        "is it of another part, or in another frame? A mapping's [features] lists names that differ",
        values={"matched": matches.count, "values": values},
    )


def _times(inspection: Inspection, factor: float) -> Inspection:
    """Returns the inspection with all lengths multiplied."""

    def vector(at: Vector) -> Vector:
        return at[0] * factor, at[1] * factor, at[2] * factor

    def place(at: Point) -> Point:
        return at[0] * factor, at[1] * factor

    def value(one: Reading | Touch | CmmPoint) -> Reading | Touch | CmmPoint:
        if isinstance(one, CmmPoint):
            nominal = None if one.nominal_mm is None else vector(one.nominal_mm)
            return replace(one, measured_mm=vector(one.measured_mm), nominal_mm=nominal)
        if isinstance(one, Touch):
            measured = None if one.measured_mm is None else place(one.measured_mm)
            return replace(one, nominal_mm=place(one.nominal_mm), measured_mm=measured)
        scale = 1.0 if one.quantity is Quantity.ANGLE else factor
        size = None if one.nominal is None else one.nominal * scale
        at = tuple(each * factor for each in one.place_mm)
        return replace(one, actual=one.actual * scale, nominal=size, place_mm=at)

    values: Values = tuple(value(one) for one in inspection.values)
    return replace(inspection, values=values, ball_radius_mm=inspection.ball_radius_mm * factor)


def _limits(readings: tuple[Reading, ...]) -> Iterator[Finding]:
    """Each characteristic once: the wrong way round is an error, the nominal value outside a warning (a fit may)."""
    for reading in {(one.characteristic, one.feature): one for one in reversed(readings)}.values():
        lower, upper, nominal = reading.lower_limit, reading.upper_limit, reading.nominal
        if lower is not None and upper is not None and lower > upper:
            why, severity = f"the lower limit {lower:.4f} is above the upper {upper:.4f}", Severity.ERROR
        elif nominal is not None and (_outside(nominal, lower, min) or _outside(nominal, upper, max)):
            low, high = ("none" if limit is None else f"{limit:.4f}" for limit in (lower, upper))
            why, severity = f"limits {low} and {high} exclude the nominal {nominal:.4f}", Severity.WARNING
        else:
            continue
        yield Finding(
            severity,
            Code.MSR_EXCLUDED,
            f"{reading.characteristic!r}: {why} {reading.quantity.unit}",
            "a fit such as f7 excludes its nominal size; else look at the limits' signs, and whether they are relative",
            Place(line=reading.line),
            values={"characteristic": reading.characteristic},
        )


def _outside(nominal: float, limit: float | None, end: Callable[[float, float], float]) -> bool:
    return limit is not None and abs(nominal - limit) > SAME and end(nominal, limit) == nominal


def _two_places(readings: tuple[Reading, ...]) -> Iterator[Finding]:
    first: dict[tuple[str, str, str], Reading] = {}
    said: set[str] = set()
    for reading in readings:
        one = first.setdefault((reading.characteristic, reading.feature, reading.axis), reading)
        both = [(one.nominal, reading.nominal), *zip(one.place_mm, reading.place_mm, strict=False)]
        apart = [(a, b) for a, b in both if a is not None and b is not None and abs(a - b) > SAME]
        if not apart or reading.characteristic in said:
            continue
        said.add(reading.characteristic)
        what = "nominal values" if apart[0] == (one.nominal, reading.nominal) else "places, at"
        yield Finding(
            Severity.WARNING,
            Code.MSR_PLACES,
            f"{reading.characteristic!r} has two {what} {apart[0][0]:.4f} and {apart[0][1]:.4f}",
            "name them differently in the file, or give each its feature",
            Place(line=reading.line),
            values={"characteristic": reading.characteristic},
        )
