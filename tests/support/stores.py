"""Values for stores, made up: a shaft, its inspections and cuts."""

from datetime import UTC, datetime

from trueloop.domain.inspection import Inspection, Touch
from trueloop.domain.life import Cut, InspectionLink, Stage
from trueloop.domain.part import Part, PartType
from trueloop.domain.tool import Edge, Machine, Setting, Tool

TYPE = PartType("shaft", "B", "C45")
EDGE = Edge(Tool(3, "SVJBR 2020", 0.8), "VBMT 1604", "A")
AT = datetime(2026, 1, 2, 3, 4, 5, 678901, tzinfo=UTC)


def part(serial: str = "17") -> Part:
    return Part(TYPE, serial)


def touched(serial: str = "17", count: int = 3, sha256: str = "1" * 64, shift_mm: float = 0.0) -> Inspection:
    """Touches whose errors are numbers that no short decimal is."""
    touches = tuple(
        Touch(str(k), (10.0 + k / 3, -k / 7), "dome", error_mm=k / 1e3 / 7 + shift_mm, line=k + 2) for k in range(count)
    )
    return Inspection(part(serial), "touches", sha256, count, touches, measured_at=AT)


def cut(serial: str = "17", stage: Stage = Stage.FINISH, correction: str = "") -> Cut:
    return Cut(part(serial), stage, Setting(EDGE, AT), Machine("lathe", "7"), "2" * 64, correction, AT)


def link(inspection: Inspection, shown: Cut) -> InspectionLink:
    return InspectionLink(inspection.identity, shown.identity)
