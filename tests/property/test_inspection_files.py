"""Inspections written and read again are the same, and what is written keeps the rules of its format."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.support.inspections import inspections
from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import CmmPoint, Inspection, Reading
from trueloop.domain.part import Part, PartType
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import MeasuredFile, StatedFacts
from trueloop.formats.inspections.qdas.writer import dfq_of
from trueloop.formats.inspections.qif.writer import qif_of

IDENTIFIER = "[0-9]+"
RULES = {
    "QIFDocument": "QPId StandardsDefinitions FileUnits (MeasurementResources )?Product (Characteristics )?Results",
    "Standard": "Organization Designator Year",
    "PrimaryUnits": "AngularUnit LinearUnit",
    "LinearUnit": "SIUnitName UnitName UnitConversion",
    "Product": "PartSet ComponentSet AsmPaths",
    "Part": "((ModelNumber )?(Version )?|Id )",
    "Component": "Part",
    "Characteristics": "FormalStandardId CharacteristicDefinitions CharacteristicNominals CharacteristicItems",
    "Tolerance": "((MaxValue )(MinValue )?|MinValue )DefinedAsLimit",
    "Results": "MeasurementResultsSet ActualComponentSets",
    "MeasurementResults": "(InspectionTraceability )?(MeasuredPointSets )?(MeasuredCharacteristics )?"
    "InspectionStatus ActualComponentIds",
    "InspectionTraceability": "(InspectionStart )?(InspectionOperator )?",
    "MeasuredPointSet": "Points Compensated (ProbeRadius )?",
    "ActualComponent": "(SerialNumber )?Status AsmPathId",
}
KINDS = (
    ("CharacteristicDefinition", "(Tolerance|NonTolerance)( WhatToMeasure)?"),
    ("CharacteristicNominal", "CharacteristicDefinitionId( TargetValue)?( Direction)?"),
    ("CharacteristicItem", "(Attributes )?Name CharacteristicNominalId"),
    (
        "CharacteristicMeasurement",
        "Status CharacteristicItemId( TimeStamp)?( MeasurementDeviceIds)?( TypeOfCoordinates)? Value",
    ),
)
REFERENCES = {
    "CharacteristicDefinitionId": "CharacteristicDefinitions",
    "CharacteristicNominalId": "CharacteristicNominals",
    "CharacteristicItemId": "CharacteristicItems",
    "FormalStandardId": "StandardsDefinitions",
    "AsmPathId": "AsmPaths",
}
LISTS = {
    "MeasurementDeviceIds": "MeasurementDevices",
    "ActualComponentIds": "ActualComponentSet",
    "ComponentIds": "ComponentSet",
    "Part": "PartSet",
}
"""Sequences and references of the types of QIF 3.0 that are written, as its schema defines them."""
DECIMALS = {"Value", "TargetValue", "MaxValue", "MinValue", "Factor", "ProbeRadius"}


def _name(element: ElementTree.Element) -> str:
    return element.tag.removeprefix("{http://qifstandards.org/xsd/qif3}")


def _keeps_the_rules(content: bytes) -> None:
    root = ElementTree.fromstring(content)
    every = list(root.iter())
    identifiers = [int(one.attrib["id"]) for one in every if "id" in one.attrib]
    assert len(set(identifiers)) == len(identifiers) and max(identifiers) == int(root.attrib["idMax"])
    members = {_name(one): {part.get("id") for part in one} for one in every}
    for element in every:
        name, parts = _name(element), " ".join(_name(part) for part in element)
        assert "{" not in name, "in the namespace of QIF 3"
        rule = RULES.get(name) or next((rule for ending, rule in KINDS if name.endswith(ending)), None)
        if rule is not None:
            assert re.fullmatch(f"({rule})", parts) or re.fullmatch(f"({rule})", f"{parts} "), (name, parts)
        if "n" in element.attrib:
            assert int(element.attrib["n"]) == len(element) > 0
        if name in REFERENCES:
            assert element.text in members[REFERENCES[name]]
        for one in element.findall("{*}Id") if name in LISTS else ():
            assert one.text in members[LISTS[name]]
        if name in DECIMALS:
            assert re.fullmatch(r"[+-]?([0-9]+(\.[0-9]*)?|\.[0-9]+)", element.text or "")


def _read(folder: Path, name: str, content: bytes) -> MeasuredFile:
    path = folder / name
    path.write_bytes(content)
    return read_measured_file(path, StatedFacts())


def _without_origin(one: Inspection) -> Inspection:
    """Without the lines and the hash of its file."""
    values = tuple(value if isinstance(value, CmmPoint) else replace(value, line=None) for value in one.values)
    return replace(one, values=values, sha256="")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("written")


@given(st.lists(inspections(places=True), min_size=1, max_size=3))
def test_qif_is_read_as_it_was_written(folder: Path, written: list[Inspection]) -> None:
    content = qif_of(written)
    _keeps_the_rules(content)
    found = _read(folder, "part.qif", content)
    assert [_without_origin(one) for one in found.inspections] == [_without_origin(one) for one in written]
    again = qif_of(found.inspections)
    assert [_without_origin(one) for one in _read(folder, "again.qif", again).inspections] == [
        _without_origin(one) for one in written
    ]


def _as_qdas_orders(written: list[Inspection]) -> list[Inspection]:
    """Pieces of one part, device and operator follow each other; those stand in the order of their first."""
    groups = list(dict.fromkeys((one.part.part_type, one.device, one.operator) for one in written))
    return sorted(written, key=lambda one: groups.index((one.part.part_type, one.device, one.operator)))


@given(st.lists(inspections(places=False), min_size=1, max_size=3))
def test_q_das_is_read_as_it_was_written(folder: Path, written: list[Inspection]) -> None:
    found = _read(folder, "part.dfq", dfq_of(written))
    assert [_in_order(one) for one in found.inspections] == [_in_order(one) for one in _as_qdas_orders(written)]
    assert all("below 0" in remark.text for remark in found.remarks)  # forms below 0 are drawn too


def _in_order(one: Inspection) -> Inspection:
    """Its readings by name, and the time of the first."""
    values = sorted(_without_origin(one).readings, key=lambda reading: reading.characteristic)
    time = next((reading.measured_at for reading in values if reading.measured_at is not None), None)
    return replace(one, values=tuple(values), sha256="", measured_at=time)


def test_repeated_readings_are_pieces_of_one_serial_number(folder: Path) -> None:
    readings = (Reading("D1", Quantity.DIAMETER, 10.01), Reading("D1", Quantity.DIAMETER, 10.02, repeat=2))
    written = Inspection(Part(PartType("shaft"), "S1"), "readings", "0" * 64, 2, readings)
    found = _read(folder, "repeated.dfq", dfq_of([written]))
    assert [(one.part.serial, one.readings[0].actual) for one in found.inspections] == [("S1", 10.01), ("S1", 10.02)]


@pytest.mark.parametrize(("name", "write"), [("devices.qif", qif_of), ("devices.dfq", dfq_of)])
def test_the_device_of_each_characteristic_is_read_as_it_was_written(
    folder: Path, name: str, write: Callable[[list[Inspection]], bytes]
) -> None:
    readings = tuple(Reading(f"D{k}", Quantity.DIAMETER, 10.0 + k) for k in range(4))
    by = {"D0": "CMM 1", "D1": "micrometer", "D2": "CMM 1, micrometer", "D3": ""}
    several = Inspection(
        *(Part(PartType("shaft"), "S1"), "readings", "0" * 64, 4, readings), device="CMM 1, micrometer", devices=by
    )
    alone = replace(several, part=Part(PartType("shaft"), "S2"), device="Gauge, left", devices={})
    found = {one.part.serial: one for one in _read(folder, name, write([several, alone])).inspections}
    assert [found["S1"].device_of(f"D{k}") for k in range(4)] == list(by.values())
    assert found["S1"].device == "CMM 1, micrometer"
    assert (found["S2"].device, dict(found["S2"].devices)) == ("Gauge, left", {})


def test_points_are_written_with_their_ball(folder: Path) -> None:
    points = tuple(CmmPoint((0.1 * k, -2.0, 1e-7 * k), name=f"points 9.{k}") for k in range(1, 4))
    written = Inspection(Part(PartType("cover")), "CMM points", "0" * 64, 3, points, ball_radius_mm=1.5)
    content = qif_of([written])
    _keeps_the_rules(content)
    (found,) = _read(folder, "points.qif", content).inspections
    assert [one.measured_mm for one in found.points] == [one.measured_mm for one in points]
    assert found.ball_radius_mm == 1.5 and found.count == 3


@pytest.mark.corpus
def test_the_twenty_covers_written_again(folder: Path, corpus: Path) -> None:
    found = read_measured_file(corpus / "data/public/qif/nist-cover-20-parts.QIF", StatedFacts("mm"))
    content = qif_of(found.inspections)
    _keeps_the_rules(content)
    again = _read(folder, "cover.qif", content)
    assert [_without_origin(one) for one in again.inspections] == [_without_origin(one) for one in found.inspections]
