"""A QIF document read: its results as inspections, one for each part in each result set."""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Final

from trueloop.domain.characteristic import Characteristic
from trueloop.domain.inspection import Inspection
from trueloop.domain.part import PartType
from trueloop.formats.inspections.measured_file import Format, MeasuredFile, Remark, Stated
from trueloop.formats.inspections.qif.elements import Element, encoding_of, records
from trueloop.formats.inspections.qif.inspections import Document, inspections_of
from trueloop.formats.inspections.qif.plan import Parts, Plan, plan_of
from trueloop.formats.inspections.qif.results import ResultSet, take, traced
from trueloop.formats.inspections.qif.units import Units, units_of
from trueloop.formats.inspections.shared.checks import Said, filled_in, stated_verdicts

VERSIONS: Final = ("2.", "3.")


@dataclass
class _Read:
    """What has been read so far; units are settled when the first value needs them."""

    path: Path
    stated: Stated
    version: str = ""
    file_units: Element | None = None
    units: Units | None = None
    parts: Parts = field(default_factory=Parts)
    sets: list[ResultSet] = field(default_factory=list)
    traced: tuple[str, datetime | None] = ("", None)
    said: Said = field(default_factory=Said)

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


def read_qif(path: Path, stated: Stated) -> MeasuredFile:
    """A QIF document's results, in mm and degrees; remarks for what refers to nothing, is no size or was not measured.

    Raises MSR-FILE for what is no XML or has a DOCTYPE, MSR-UNIT for lengths without a unit that nobody states,
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
        path,
        f"QIF {read.version}".strip(),
        encoding,
        units.unit,
        inspections,
        _characteristics(plan),
        (*remarks, *stated_verdicts(document.wrong_verdicts), *filled_in(inspections)),
    )


def _document(read: _Read, plan: Plan) -> Document:
    with read.path.open("rb") as file:
        sha256 = hashlib.file_digest(file, "sha256").hexdigest()
    lists = read.parts.lists
    serials = {key: one.words("SerialNumber") for key, one in lists.get("ActualComponentSet", {}).items()}
    devices = {key: _name(one) for key, one in lists.get("MeasurementDevices", {}).items()}
    return Document(sha256, _part_types(read), plan, serials, devices, read.said, [])


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
            read.said.add("parts of a file of several part types do not say of which they are", made.line)
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
    return tuple(one for one in every if one is not None)


def _recognises(_: Path, head: bytes) -> bool:
    """By the name of its root element, in whatever encoding."""
    return b"QIFDocument" in head[:8192].replace(b"\0", b"")


FORMAT: Final = Format("QIF 2 and 3", _recognises, read_qif)
