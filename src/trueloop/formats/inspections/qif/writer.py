"""Inspections written as results of QIF 3.0 (ISO 23952): plan, parts and readings, in mm and degrees.

The order of elements is that of the schema's sequences, which do not allow another. What the standard has no element
for (the names of features without their geometry, places) is written as attributes whose names begin with `trueloop.`,
a quantity without a kind of its own in words; `read_qif` takes them back. Points are written as sets: coordinates and
ball.
"""

import uuid
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Final, TypeAlias
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from trueloop.domain.inspection import CmmPoint, Inspection, Reading
from trueloop.domain.part import PartType
from trueloop.formats.inspections.qif.elements import KEPT, kept_of, written_kind
from trueloop.formats.inspections.shared.checks import within

NAMESPACE: Final = "http://qifstandards.org/xsd/qif3"
DOCUMENT: Final = uuid.UUID("3a6f4f0e-3c0b-5b0e-9a55-6f2d3c1e7b10")
AXES: Final = {"x": "XAXIS", "y": "YAXIS", "z": "ZAXIS"}
UNITS: Final = (("AngularUnit", "radian", "degree", "0.017453292519943"), ("LinearUnit", "meter", "mm", "0.001"))
Asked: TypeAlias = tuple[object, ...]


@dataclass
class _Writing:
    """Elements that are filled as inspections come, and identifiers of what is referred to again."""

    definitions: Element = field(default_factory=lambda: Element("CharacteristicDefinitions"))
    nominals: Element = field(default_factory=lambda: Element("CharacteristicNominals"))
    items: Element = field(default_factory=lambda: Element("CharacteristicItems"))
    devices: Element = field(default_factory=lambda: Element("MeasurementDevices"))
    parts: Element = field(default_factory=lambda: Element("PartSet"))
    part_components: Element = field(default_factory=lambda: Element("ComponentSet"))
    paths: Element = field(default_factory=lambda: Element("AsmPaths"))
    results: Element = field(default_factory=lambda: Element("MeasurementResultsSet"))
    made: Element = field(default_factory=lambda: Element("ActualComponentSet"))
    known: dict[Asked, str] = field(default_factory=dict)
    last: int = 0

    def new(self) -> str:
        self.last += 1
        return str(self.last)


def qif_of(inspections: Sequence[Inspection]) -> bytes:
    """Returns a QIF 3.0 document of inspections, UTF-8: values, limits, parts, devices, times, operators and points.

    Temperatures and the frame of points are not written. Equal inspections give equal bytes.
    """
    writing = _Writing()
    standard = writing.new()
    for inspection in inspections:
        _add(writing, inspection)
    root = Element("QIFDocument", {"xmlns": NAMESPACE, "versionQIF": "3.0.0", "idMax": str(writing.last)})
    content = "|".join(f"{one.identity}{one.values}" for one in inspections)
    _text(root, "QPId", str(uuid.uuid5(DOCUMENT, content)))
    _standard(root, standard)
    primary = SubElement(SubElement(root, "FileUnits"), "PrimaryUnits")
    for name, si, unit, factor in UNITS:
        one = SubElement(primary, name)
        _text(one, "SIUnitName", si)
        _text(one, "UnitName", unit)
        _text(SubElement(one, "UnitConversion"), "Factor", factor)
    if len(writing.devices):
        _counted(SubElement(root, "MeasurementResources"), writing.devices)
    product = SubElement(root, "Product")
    for each in (writing.parts, writing.part_components, writing.paths):
        _counted(product, each)
    if len(writing.items):
        characteristics = SubElement(root, "Characteristics")
        _text(characteristics, "FormalStandardId", standard)
        for each in (writing.definitions, writing.nominals, writing.items):
            _counted(characteristics, each)
    found = SubElement(root, "Results")
    _counted(found, writing.results)
    sets = SubElement(found, "ActualComponentSets", {"n": "1"})
    _counted(sets, writing.made)
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def _standard(root: Element, identifier: str) -> None:
    """The schema asks which standard the limits are judged by: ISO 8015, each size by itself."""
    one = SubElement(SubElement(root, "StandardsDefinitions", {"n": "1"}), "Standard", {"id": identifier})
    _text(SubElement(one, "Organization"), "StandardsOrganizationEnum", "ISO")
    _text(one, "Designator", "8015")
    _text(one, "Year", "2011")


def _add(writing: _Writing, inspection: Inspection) -> None:
    path = _part(writing, inspection.part.part_type)
    devices = {one.characteristic: _devices(writing, inspection, one.characteristic) for one in inspection.readings}
    result = SubElement(writing.results, "MeasurementResults", {"id": writing.new()})
    if inspection.operator or inspection.measured_at is not None:
        traced = SubElement(result, "InspectionTraceability")
        if inspection.measured_at is not None:
            _text(traced, "InspectionStart", inspection.measured_at.isoformat())
        if inspection.operator:
            _text(SubElement(traced, "InspectionOperator"), "Name", inspection.operator)
    if inspection.points:
        _points(result, writing, inspection.points, inspection.ball_radius_mm)
    if inspection.readings:
        measured = Element("CharacteristicMeasurements")
        for reading in inspection.readings:
            _measurement(measured, writing, reading, devices[reading.characteristic])
        _counted(SubElement(result, "MeasuredCharacteristics"), measured)
    verdict = _verdict(inspection.readings)
    _text(SubElement(result, "InspectionStatus"), "InspectionStatusEnum", verdict)
    component = writing.new()
    _ids(result, "ActualComponentIds", component)
    made = SubElement(writing.made, "ActualComponent", {"id": component})
    if inspection.part.serial:
        _text(made, "SerialNumber", inspection.part.serial)
    _text(SubElement(made, "Status"), "InspectionStatusEnum", verdict)
    _text(made, "AsmPathId", path)


def _verdict(readings: Iterable[Reading]) -> str:
    verdicts = {within(reading) for reading in readings}
    return "FAIL" if False in verdicts else "PASS" if verdicts == {True} else "UNKNOWN"


def _part(writing: _Writing, part_type: PartType) -> str:
    """The path of a part type's component: what an actual component refers to."""
    if (key := ("part", part_type)) not in writing.known:
        part, component, path = writing.new(), writing.new(), writing.new()
        one = SubElement(writing.parts, "Part", {"id": part})
        if part_type.name:
            _text(one, "ModelNumber", part_type.name)
        if part_type.revision:
            _text(one, "Version", part_type.revision)
        _text(SubElement(SubElement(writing.part_components, "Component", {"id": component}), "Part"), "Id", part)
        _ids(SubElement(writing.paths, "AsmPath", {"id": path}), "ComponentIds", component)
        writing.known[key] = path
    return writing.known[key]


def _devices(writing: _Writing, inspection: Inspection, characteristic: str) -> list[str]:
    """The devices that measured a characteristic; where each has its own, several stand with commas."""
    name = inspection.device_of(characteristic)
    names = name.split(", ") if inspection.devices else [name]
    return [_device(writing, one) for one in names if one]


def _device(writing: _Writing, name: str) -> str:
    key = ("device", name)
    if key not in writing.known:
        writing.known[key] = writing.new()
        _text(SubElement(writing.devices, "MeasurementDevice", {"id": writing.known[key]}), "Name", name)
    return writing.known[key]


def _item(writing: _Writing, reading: Reading) -> str:
    """The item of a characteristic, with its nominal and definition, made when it is first measured."""
    kept = kept_of(reading)
    limits = reading.lower_limit, reading.upper_limit
    key = ("item", reading.characteristic, reading.quantity, reading.axis, reading.nominal, limits, *kept.items())
    if key not in writing.known:
        kind = written_kind(reading)
        definition, nominal, item = writing.new(), writing.new(), writing.new()
        one = SubElement(writing.definitions, f"{kind}CharacteristicDefinition", {"id": definition})
        _tolerance(one, *limits)
        if kind == "UserDefinedLinear":
            _text(one, "WhatToMeasure", reading.quantity.value)
        one = SubElement(writing.nominals, f"{kind}CharacteristicNominal", {"id": nominal})
        _text(one, "CharacteristicDefinitionId", definition)
        if reading.nominal is not None:
            _text(one, "TargetValue", _decimal(reading.nominal))
        if kind == "LinearCoordinate":
            _text(one, "Direction", AXES[reading.axis])
        one = SubElement(writing.items, f"{kind}CharacteristicItem", {"id": item})
        if kept:
            attributes = SubElement(one, "Attributes", {"n": str(len(kept))})
            for name, value in kept.items():
                SubElement(attributes, "AttributeStr", {"name": f"{KEPT}{name}", "value": _clean(value)})
        _text(one, "Name", reading.characteristic)
        _text(one, "CharacteristicNominalId", nominal)
        writing.known[key] = item
    return writing.known[key]


def _tolerance(definition: Element, lower: float | None, upper: float | None) -> None:
    if lower is None and upper is None:
        _text(definition, "NonTolerance", "MEASURED")
        return
    tolerance = SubElement(definition, "Tolerance")
    if upper is not None:
        _text(tolerance, "MaxValue", _decimal(upper))
    if lower is not None:
        _text(tolerance, "MinValue", _decimal(lower))
    _text(tolerance, "DefinedAsLimit", "true")


def _measurement(measured: Element, writing: _Writing, reading: Reading, devices: Sequence[str]) -> None:
    kind, item = written_kind(reading), _item(writing, reading)
    one = SubElement(measured, f"{kind}CharacteristicMeasurement", {"id": writing.new()})
    verdict, status = within(reading), SubElement(one, "Status")
    if verdict is None:
        _text(status, "OtherCharacteristicStatus", "not judged: no limits")
    else:
        _text(status, "CharacteristicStatusEnum", "PASS" if verdict else "FAIL")
    _text(one, "CharacteristicItemId", item)
    if reading.measured_at is not None:
        _text(one, "TimeStamp", reading.measured_at.isoformat())
    if devices:
        _ids(one, "MeasurementDeviceIds", *devices)
    if kind == "LinearCoordinate":
        _text(SubElement(one, "TypeOfCoordinates"), "CoordinateEnum", "CARTESIAN_3D")
    value = _text(one, "Value", _decimal(reading.actual))
    if reading.standard_u is not None:
        value.attrib |= {"combinedUncertainty": _decimal(reading.standard_u), "meanError": "0"}


def _points(result: Element, writing: _Writing, points: Sequence[CmmPoint], ball_radius_mm: float) -> None:
    sets = SubElement(result, "MeasuredPointSets", {"n": "1"})
    one = SubElement(sets, "MeasuredPointSet", {"id": writing.new(), "count": str(len(points))})
    _text(one, "Points", "\n".join(" ".join(map(_decimal, point.measured_mm)) for point in points))
    _text(one, "Compensated", "false" if ball_radius_mm > 0.0 else "true")
    if ball_radius_mm > 0.0:
        _text(one, "ProbeRadius", _decimal(ball_radius_mm))


def _ids(parent: Element, name: str, *identifiers: str) -> None:
    listed = SubElement(parent, name, {"n": str(len(identifiers))})
    for identifier in identifiers:
        _text(listed, "Id", identifier)


def _counted(parent: Element, members: Element) -> None:
    members.set("n", str(len(members)))
    parent.append(members)


def _text(parent: Element, name: str, text: str) -> Element:
    one = SubElement(parent, name)
    one.text = _clean(text)
    return one


def _clean(text: str) -> str:
    """Without the control characters that XML cannot hold."""
    return "".join(one if one >= " " or one in "\t\n" else "\N{REPLACEMENT CHARACTER}" for one in text)


def _decimal(number: float) -> str:
    """An xs:decimal, which has no exponent, that gives the number back."""
    return format(Decimal(repr(number)), "f")
