"""A QIF document read: its results as inspections, one for each part in each result set."""

import hashlib
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime
from pathlib import Path
from typing import Final

from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading, Values
from trueloop.domain.part import Part, PartType
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Remark, StatedFacts
from trueloop.formats.inspections.qif.elements import Element, encoding_of, place_in, records
from trueloop.formats.inspections.qif.plan import KINDS, POINTS, Item, Parts, Plan, kind_of, plan_of
from trueloop.formats.inspections.qif.units import Units, units_of
from trueloop.formats.inspections.shared.checks import (
    RemarkCounts,
    devices_of,
    filled_in,
    numbered,
    stated_verdicts,
    within,
)
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
    return element.words("InspectionOperator", "Name"), next((time for time in times if time is not None), None)


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
    return tuple(part.text for ids in element.parts if ids.name in names for part in ids.parts)


def _take_feature(results: ResultSet, element: Element, units: Units) -> None:
    """Takes a feature's item and the point sets that it was made from; without such a set the point itself."""
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


NO_PLAN = "results refer to characteristics that are not in this file: no nominal value, no limits"


@dataclass(frozen=True)
class Document:
    """Data common to all results of a document, and its gathered remarks and wrong verdicts."""

    sha256: str
    part_types: Mapping[str, PartType]
    plan: Plan
    serials: Mapping[str, str]
    devices: Mapping[str, str]
    said: RemarkCounts
    wrong_verdicts: list[tuple[Reading, bool]]


def inspections_of(results: ResultSet, document: Document) -> Iterator[Inspection]:
    """Yields an inspection for each part of a result set: those that its results name, else the one of the set."""
    by_component: defaultdict[str, list[Result]] = defaultdict(list)
    default = results.components[0] if len(results.components) == 1 else ""
    if len(results.components) > 1 and any(not result.component for result in results.results):
        document.said.add("results of a set for several parts do not state their part", results.line)
    for result in results.results:
        by_component[result.component or default].append(result)
    radius, points = _points(results, document)
    for number, component in enumerate(by_component or {default: []}):
        of_set = ((), 0) if number else (points, results.unkept)
        inspection = _inspection(results, component, by_component[component], *of_set, radius, document)
        if inspection.count:
            yield inspection


def _inspection(
    one: ResultSet,
    component: str,
    results: Iterable[Result],
    points: tuple[CmmPoint, ...],
    unkept: int,
    radius: float,
    document: Document,
) -> Inspection:
    serial = document.serials.get(component, "")
    if component and component not in document.serials:
        document.said.add("results refer to parts that are not in this file: no serial number", one.line)
    readings, numbers, devices = [], set[str](), list[tuple[str, str]]()
    for result in results:
        item = document.plan.items.get(result.item)
        if item is not None and item.numbers:
            numbers.add(result.text)
            document.said.add(f"{item.name!r} numbers the parts: no reading", result.line)
            continue
        if item is not None and item.set_only:
            document.said.add("results are set to their nominal value, not measured: left out", result.line)
            continue
        readings.append(_reading(result, item, one, document))
        by = (document.devices.get(each, "") for each in result.devices or (() if item is None else item.devices))
        devices += [(readings[-1].characteristic, name) for name in by] or [(readings[-1].characteristic, "")]
    if serial and numbers and numbers != {serial}:
        document.said.add(f"part {serial!r} is numbered {', '.join(sorted(numbers))} by a result", one.line)
    serial = serial or (numbers.pop() if len(numbers) == 1 else "")
    times = (reading.measured_at for reading in readings if reading.measured_at is not None)
    values: Values = (*numbered(readings), *points)
    return Inspection(
        Part(document.part_types.get(component, document.part_types[""]), serial),
        "readings and CMM points" if readings and points else "readings" if readings else "CMM points",
        document.sha256,
        len(values) + unkept,
        values,
        device=", ".join(dict.fromkeys(name for _, name in devices if name)),
        operator=one.operator,
        measured_at=one.measured_at or next(times, None),
        ball_radius_mm=radius if points else 0.0,
        devices=devices_of(devices),
    )


def _reading(result: Result, item: Item | None, results: ResultSet, document: Document) -> Reading:
    if item is None:
        document.said.add(NO_PLAN, result.line)
        item = Item(f"characteristic {result.item or 'of another file'}", Quantity.OTHER)
    plan = document.plan
    features = item.features or tuple(results.feature_of.get(each, "") for each in result.features)
    feature, other = item.features_in(plan, features)
    place = plan.places.get(features[0], ()) if len(features) == 1 else place_in(item.kept.get("place", ""))
    reading = Reading(
        characteristic=item.name,
        quantity=item.quantity,
        actual=result.value,
        nominal=item.nominal,
        lower_limit=item.lower_limit,
        upper_limit=item.upper_limit,
        feature=feature,
        other=other,
        axis=item.axis,
        place_mm=place,
        standard_u=result.standard_u,
        measured_at=result.measured_at,
        line=result.line,
    )
    if result.passed is not None and within(reading) is (not result.passed):
        document.wrong_verdicts.append((reading, result.passed))
    return reading


def _points(results: ResultSet, document: Document) -> tuple[float, tuple[CmmPoint, ...]]:
    """The points of the most frequent ball radius, named by their features: an inspection has one ball."""
    for missing in results.referred - results.held:
        document.said.add(f"features refer to points that are not in this file: {missing!r}", results.line)
    if not results.points:
        return 0.0, ()
    radius = max(results.points, key=lambda each: len(results.points[each]))
    for other, points in results.points.items():
        if other != radius:
            text = f"points of a ball of {other:g} mm are left out beside those of one of {radius:g} mm"
            document.said.add(text, results.line, len(points))
    by_item: defaultdict[str, list[CmmPoint]] = defaultdict(list)
    for point in results.points[radius]:
        by_item[results.feature_of.get(point.name, point.name)].append(point)
    return radius, tuple(point for item, points in by_item.items() for point in _named(item, points, document.plan))


def _named(item: str, points: list[CmmPoint], plan: Plan) -> Iterator[CmmPoint]:
    """Points of one feature, numbered where there are several; a measured point feature has its nominal."""
    name = plan.feature_names.get(item, "") or f"points {item}"
    if len(points) == 1:
        nominal, normal = plan.nominal_points.get(item, (None, None))
        yield replace(points[0], name=name, nominal_mm=nominal, outward_normal=normal)
        return
    for number, point in enumerate(points, 1):
        yield CmmPoint(point.measured_mm, point.nominal_mm, point.outward_normal, f"{name}.{number}")


VERSIONS: Final = ("2.", "3.")


@dataclass
class _Read:
    """State of the reader; units are settled when the first value needs them."""

    path: Path
    stated: StatedFacts
    version: str = ""
    file_units: Element | None = None
    units: Units | None = None
    parts: Parts = field(default_factory=Parts)
    sets: list[ResultSet] = field(default_factory=list)
    traced: tuple[str, datetime | None] = ("", None)
    said: RemarkCounts = field(default_factory=RemarkCounts)

    def known_units(self) -> Units:
        if self.units is None:
            self.units = units_of(self.file_units, self.path, self.stated)
        return self.units

    def take(self, around: str, element: Element) -> None:
        if element.name == "QIFDocument":
            self.version = element.attributes.get("versionQIF", "")
        elif element.name == "FileUnits":
            self.file_units = element
        elif element.name == "MeasurementResults":
            self.sets.append(ResultSet(element.line))
        elif around == "Results" and element.name == "InspectionTraceability":
            self.traced = traced(element)
        elif around in OF_RESULTS and self.sets:
            take(self.sets[-1], around, element, self.known_units(), self.said)
        else:
            self.parts.add(around, element)


OF_RESULTS: Final = {
    "MeasurementResults",
    "MeasuredFeatures",
    "FeatureActuals",
    "FeatureMeasurements",
    "MeasuredPointSets",
    "PointSets",
    "CharacteristicActuals",
    "CharacteristicMeasurements",
}
"""Lists that belong to the result set around them."""


def read_qif(path: Path, stated: StatedFacts) -> MeasuredFile:
    """Reads a QIF document's results, in mm and degrees, with remarks on references to nothing, on what is not a size
    and on what was not measured.

    Raises MSR-FILE for anything that is not XML or has a DOCTYPE, MSR-UNIT for lengths whose unit is not stated,
    MSR-NUMBER and MSR-SIZE, each with the line.
    """
    read = _Read(path, stated)
    for around, element in records(path):
        read.take(around, element)
    units = read.known_units()
    plan = plan_of(read.parts, units)
    document = _document(read, plan)
    inspections = tuple(_inspections(read, document))
    remarks = (*_of_version(read), *plan.remarks, *document.said.remarks())
    with path.open("rb") as file:
        encoding = encoding_of(file.read(1024))
    return MeasuredFile(
        path=path,
        format=f"QIF {read.version}".strip(),
        encoding=encoding,
        unit=units.unit,
        inspections=inspections,
        characteristics=_characteristics(plan),
        remarks=(*remarks, *stated_verdicts(document.wrong_verdicts), *filled_in(inspections)),
    )


def _document(read: _Read, plan: Plan) -> Document:
    with read.path.open("rb") as file:
        sha256 = hashlib.file_digest(file, "sha256").hexdigest()
    lists = read.parts.lists
    serials = {key: one.words("SerialNumber") for key, one in lists.get("ActualComponentSet", {}).items()}
    devices = {key: _name(one) for key, one in lists.get("MeasurementDevices", {}).items()}
    return Document(
        sha256=sha256,
        part_types=_part_types(read),
        plan=plan,
        serials=serials,
        devices=devices,
        said=read.said,
        wrong_verdicts=[],
    )


def _part_types(read: _Read) -> dict[str, PartType]:
    """The part type of each actual component, by its path, component and part; of "" that of a file's only part."""
    parts = read.parts
    found = [one for name in ("PartSet", "AssemblySet") for one in parts.lists.get(name, {}).values()]
    types = {"": _part_type(found[0]) if len(found) == 1 else PartType("")}
    for identifier, made in parts.lists.get("ActualComponentSet", {}).items():
        path = parts.of("AsmPaths", made.first("AsmPathId"))
        last = None if path is None else next(iter([*path.every("Id")][-1:]), None)
        component = parts.of("ComponentSet", last)
        part = None if component is None else parts.of("PartSet", component.first("Part", "Id"))
        if part is not None:
            types[identifier] = _part_type(part)
        elif len(found) > 1:
            read.said.add("parts of a file of several part types do not state their type", made.line)
    return types


def _part_type(element: Element) -> PartType:
    return PartType(_name(element), element.words("Version"))


def _name(element: Element) -> str:
    ways = (("Name",), ("ModelNumber",), ("PartNumber",), ("Header", "Name"), ("Description",))
    return next(filter(None, (element.words(*way) for way in ways)), "")


def _inspections(read: _Read, document: Document) -> Iterator[Inspection]:
    """Each result set is dropped when its inspections are made: both are never held whole."""
    operator, measured_at = read.traced
    read.sets.reverse()
    while read.sets:
        one = read.sets.pop()
        one.operator, one.measured_at = one.operator or operator, one.measured_at or measured_at
        if one.results or one.points or one.unkept:
            yield from inspections_of(one, document)
        else:
            document.said.add("a result set holds no values", one.line)


def _of_version(read: _Read) -> tuple[Remark, ...]:
    if read.version.startswith(VERSIONS):
        return ()
    return (Remark(f"read as QIF 2 and 3: the file states version {read.version or 'none'}"),)


def _characteristics(plan: Plan) -> tuple[Characteristic, ...]:
    every = (item.characteristic(*item.features_in(plan)) for item in plan.items.values())
    return tuple(characteristic for characteristic in every if characteristic is not None)


def _recognises(_: Path, head: bytes) -> bool:
    """By the name of its root element, in whatever encoding."""
    return b"QIFDocument" in head[:8192].replace(b"\0", b"")


FORMAT: Final = Format("QIF 2 and 3", _recognises, read_qif)
