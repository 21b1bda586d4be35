"""Inspections made of the results of a QIF document when all of it has been read."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading, Values
from trueloop.domain.part import Part, PartType
from trueloop.formats.inspections.qif.own import place_in
from trueloop.formats.inspections.qif.plan import Item, Plan
from trueloop.formats.inspections.qif.results import Result, ResultSet
from trueloop.formats.inspections.shared.checks import Said, numbered, within

NO_PLAN = "results refer to characteristics that are not in this file: no nominal value, no limits"


@dataclass(frozen=True)
class Document:
    """What all results of a document have in common, and where remarks and wrong verdicts are gathered."""

    sha256: str
    part_types: Mapping[str, PartType]
    plan: Plan
    serials: Mapping[str, str]
    devices: Mapping[str, str]
    said: Said
    wrong_verdicts: list[tuple[Reading, bool]]


def inspections_of(one: ResultSet, document: Document) -> Iterator[Inspection]:
    """One for each part of a result set: of those that its results name, else of the one that the set names."""
    by_component: defaultdict[str, list[Result]] = defaultdict(list)
    default = one.components[0] if len(one.components) == 1 else ""
    if len(one.components) > 1 and any(not result.component for result in one.results):
        document.said.add("results of a set for several parts do not say of which they are", one.line)
    for result in one.results:
        by_component[result.component or default].append(result)
    radius, points = _points(one, document)
    for number, component in enumerate(by_component or {default: []}):
        of_set = ((), 0) if number else (points, one.unkept)
        inspection = _inspection(one, component, by_component[component], *of_set, radius, document)
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
    readings, numbers, devices = [], set[str](), dict[str, None]()
    for result in results:
        item = document.plan.items.get(result.item)
        if item is not None and item.numbers:
            numbers.add(result.text)
            document.said.add(f"{item.name!r} numbers the parts: no reading", result.line)
            continue
        if item is not None and item.set_only:
            document.said.add("results are set to their nominal value, not measured: left out", result.line)
            continue
        devices |= dict.fromkeys(result.devices or (() if item is None else item.devices))
        readings.append(_reading(result, item, one, document))
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
        device=", ".join(name for each in devices if (name := document.devices.get(each, ""))),
        operator=one.operator,
        measured_at=one.measured_at or next(times, None),
        ball_radius_mm=radius if points else 0.0,
    )


def _reading(result: Result, item: Item | None, one: ResultSet, document: Document) -> Reading:
    if item is None:
        document.said.add(NO_PLAN, result.line)
        item = Item(f"characteristic {result.item or 'of another file'}", Quantity.OTHER)
    plan = document.plan
    features = item.features or tuple(one.feature_of.get(each, "") for each in result.features)
    feature, other = item.features_in(plan, features)
    place = plan.places.get(features[0], ()) if len(features) == 1 else place_in(item.kept.get("place", ""))
    reading = Reading(
        item.name,
        item.quantity,
        result.value,
        item.nominal,
        item.lower_limit,
        item.upper_limit,
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


def _points(one: ResultSet, document: Document) -> tuple[float, tuple[CmmPoint, ...]]:
    """The points of the most frequent ball radius, named by their features: an inspection has one ball."""
    for missing in one.referred - one.held:
        document.said.add(f"features refer to points that are not in this file: {missing!r}", one.line)
    if not one.points:
        return 0.0, ()
    radius = max(one.points, key=lambda each: len(one.points[each]))
    for other, points in one.points.items():
        if other != radius:
            text = f"points of a ball of {other:g} mm are left out beside those of one of {radius:g} mm"
            document.said.add(text, one.line, len(points))
    by_item: defaultdict[str, list[CmmPoint]] = defaultdict(list)
    for point in one.points[radius]:
        by_item[one.feature_of.get(point.name, point.name)].append(point)
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
