"""Cuts, inspections and corrections for tests of what is kept in a store."""

from dataclasses import replace
from datetime import UTC, datetime, timedelta

from trueloop.domain.inspection import Inspection, Touch
from trueloop.domain.life import Cut, CuttingConditions, InspectionLink, Stage
from trueloop.domain.part import Part, PartType
from trueloop.domain.tool import Edge, Setting, Tool
from trueloop.loops.turned.correction import Correction

EDGE = Edge(Tool(1, "PCLNL"), "CNMG 120408", "2")
SET_AT = datetime(2026, 1, 5, tzinfo=UTC)
MADE_AT = datetime(2026, 1, 6, 8, tzinfo=UTC)
TYPE = PartType("MODBAS2", "B")


def cut_of(
    correction: Correction, serial: str = "2511.161", *, program_sha256: str = "", order: int | None = None
) -> Cut:
    """The finish cut of a part by the correction's program, an hour after the one before it."""
    return Cut(
        Part(TYPE, serial),
        Stage.FINISH,
        Setting(EDGE, SET_AT),
        program_sha256=program_sha256,
        correction=correction.record.id,
        at=None if order is None else MADE_AT + timedelta(hours=order),
        order=order,
        conditions=CuttingConditions(0.25, 0.1, time_in_cut_min=3.0),
    )


def of_part(correction: Correction, serial: str) -> Correction:
    """The same correction as that of another part: its record names that part and the edge."""
    part = Part(TYPE, serial)
    inspections = tuple(replace(one, part=part) for one in correction.record.inspections)
    record = replace(correction.record, id=f"{abs(hash(serial)):016x}"[:16], edge=EDGE, inspections=inspections)
    return replace(correction, record=replace(record, part_type=TYPE))


def inspected(
    correction: Correction, cut: Cut, error_um: float, hours: float = 0.5
) -> tuple[Inspection, InspectionLink]:
    """An inspection after a cut that finds one error at all touches of the correction."""
    touches = correction.touches
    names = correction.profile.names
    values = tuple(
        Touch(point, (float(x), float(z)), names[index], error_mm=error_um / 1000)
        for point, index, (x, z) in zip(touches.point, touches.feature_index, touches.nominal_mm, strict=True)
    )
    at = None if cut.at is None else cut.at + timedelta(hours=hours)
    made = Inspection(cut.part, "touches", f"{cut.part.serial}{error_um}", len(values), values, measured_at=at)
    return made, InspectionLink(made.identity, cut.identity)
