"""The results of a QIF document as they come, kept small: what they refer to may come later."""

from dataclasses import dataclass, field
from datetime import datetime
from typing import Final

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint
from trueloop.formats.inspections.qif.elements import Element
from trueloop.formats.inspections.qif.plan import KINDS, POINTS, kind_of
from trueloop.formats.inspections.qif.units import Units
from trueloop.formats.inspections.shared.checks import RemarkCounts
from trueloop.formats.inspections.shared.text import iso_time, number_in, numbers_in

MAX_POINTS: Final = 500_000
"""Points that are kept of one file: 150 MB. Of more the inspections have the count."""
VERDICTS: Final = {"PASS": True, "FAIL": False}


@dataclass(frozen=True, slots=True)
class Result:
    """One measured characteristic as reported; `value` in mm or degrees, `text` as it stands in the file."""

    item: str
    value: float
    text: str
    standard_u: float | None
    passed: bool | None
    measured_at: datetime | None
    component: str
    features: tuple[str, ...]
    devices: tuple[str, ...]
    line: int


@dataclass
class ResultSet:
    """One `MeasurementResults`: its results; its points with the radius of the ball whose centres they are, 0: none.

    `referred` and `held` are point sets by their identifiers, `feature_of` has the feature item of a measured feature
    or point set. `unkept` counts points beyond `MAX_POINTS`.
    """

    line: int
    results: list[Result] = field(default_factory=list)
    points: dict[float, list[CmmPoint]] = field(default_factory=dict)
    unkept: int = 0
    components: tuple[str, ...] = ()
    operator: str = ""
    measured_at: datetime | None = None
    feature_of: dict[str, str] = field(default_factory=dict)
    referred: set[str] = field(default_factory=set)
    held: set[str] = field(default_factory=set)


def take(results: ResultSet, around: str, element: Element, units: Units, remarks: RemarkCounts) -> None:
    """Adds what an element within `MeasurementResults` reports."""
    if element.name == "ActualComponentIds":
        results.components = tuple(part.text for part in element.parts)
    elif element.name == "InspectionTraceability":
        results.operator, results.measured_at = traced(element)
    elif around in {"CharacteristicActuals", "CharacteristicMeasurements"}:
        if (result := _result(element, units, remarks)) is not None:
            results.results.append(result)
    elif around in {"MeasuredPointSets", "PointSets"}:
        _take_points(results, element, units, remarks)
    else:
        _take_feature(results, element, units)


def traced(element: Element) -> tuple[str, datetime | None]:
    """Returns operator and time of an inspection; the time of its report is not that of its measurement."""
    times = (iso_time(element.words(name)) for name in ("InspectionStart", "InspectionEnd"))
    return element.words("InspectionOperator", "Name"), next((one for one in times if one is not None), None)


def _result(element: Element, units: Units, remarks: RemarkCounts) -> Result | None:
    kind, value = kind_of(element), element.first("Value")
    if kind not in KINDS:
        remarks.add(f"results of {element.name} are no lengths or angles: left out", element.line)
        return None
    if value is None or not value.text:
        verdict = element.words("Status", "CharacteristicStatusEnum") or "none"
        remarks.add(f"results have no value but a verdict, {verdict}: left out", element.line)
        return None
    number = units.value(value, KINDS[kind])
    if number is None:
        remarks.add("angles are left out: the file states no angular unit, degrees or radians", element.line)
        return None
    uncertainty = value.attributes.get("combinedUncertainty")
    factor = units.factor(value, KINDS[kind]) or 1.0
    item = element.first("CharacteristicItemId")
    return Result(
        item="" if item is None or "xId" in item.attributes else item.text,
        value=number,
        text=value.text if kind.startswith("UserDefined") else "",
        standard_u=None if uncertainty is None else factor * number_in(uncertainty, units.path, value.line),
        passed=VERDICTS.get(element.words("Status", "CharacteristicStatusEnum")),
        measured_at=iso_time(element.words("TimeStamp")),
        component=element.words("ActualComponentId"),
        features=_ids(element, "FeatureMeasurementIds", "FeatureActualIds"),
        devices=_ids(element, "MeasurementDeviceIds"),
        line=element.line,
    )


def _ids(element: Element, *names: str) -> tuple[str, ...]:
    return tuple(one.text for ids in element.parts if ids.name in names for one in ids.parts)


def _take_feature(results: ResultSet, element: Element, units: Units) -> None:
    """Of which item it is, the point sets that it was made of; of a point without such a set the point itself."""
    item = element.words("FeatureItemId")
    sets = [part.text for each in element.every("PointList") for part in each.parts]
    results.referred.update(sets)
    for identifier in (element.attributes.get("id", ""), *sets):
        results.feature_of.setdefault(identifier, item)
    if element.name.startswith(POINTS) and not sets:
        location = units.place(element.first("Location"))
        if location is not None:
            results.points.setdefault(0.0, []).append(CmmPoint(location, name=item))


def _take_points(results: ResultSet, element: Element, units: Units, remarks: RemarkCounts) -> None:
    """Points of a set, named by its identifier until the names of features are known."""
    points = element.first("Points")
    results.held.add(element.attributes.get("id", ""))
    if points is None:
        remarks.add("point sets are binary or empty: left out", element.line)
        return
    stated, words = element.attributes.get("count", ""), points.text.split()
    count = int(stated) if stated.isdecimal() else len(words) // 3
    if points.cut or sum(map(len, results.points.values())) + len(words) // 3 > MAX_POINTS:
        results.unkept += count
        remarks.add(f"point sets beyond {MAX_POINTS} points are counted, not kept", element.line)
        return
    if len(words) != 3 * count:
        remarks.add("point sets do not hold the count of coordinates that they state: left out", element.line)
        return
    factor = units.factor(points, Quantity.POSITION) or 1.0
    numbers = [factor * value for value in numbers_in(points.text, units.path, points.line)]
    radius = 0.0
    if element.words("Compensated") == "false":
        radius = units.value(element.first("ProbeRadius"), Quantity.RADIUS) or 0.0
    name = element.attributes.get("id", "")
    results.points.setdefault(radius, []).extend(
        CmmPoint((x, y, z), name=name) for x, y, z in zip(numbers[0::3], numbers[1::3], numbers[2::3], strict=True)
    )
