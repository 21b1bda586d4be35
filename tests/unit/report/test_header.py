"""The header names what was stated, and leaves the rest empty."""

from dataclasses import replace
from datetime import UTC, datetime

from tests.support.correction import example_correction
from trueloop.domain.part import Part, PartType
from trueloop.domain.tool import Edge, Machine, Tool
from trueloop.report.markup import text_of
from trueloop.report.texts.texts import Texts
from trueloop.report.turned.summary import header, header_fields

RECORD = example_correction("modbas2").record
PART = PartType("shaft", "C", "6061-T6", "D-4711")
TOOL = Tool(3, "SVJBR", 0.8)
(INSPECTION,) = RECORD.inspections
STATED = replace(
    RECORD,
    part_type=PART,
    machine=Machine("Lathe 7", "M-99"),
    tool=TOOL,
    edge=Edge(TOOL, "VBMT 1604", "2"),
    edge_set_at=datetime(2026, 1, 30, 7, 5, tzinfo=UTC),
    inspections=(
        replace(
            INSPECTION,
            part=Part(PART, "S-0815"),
            device="probe 12",
            operator="K. <b>Meier",
            measured_at=datetime(2026, 1, 31, 6, tzinfo=UTC),
        ),
    ),
)


def test_all_that_is_stated_is_named() -> None:
    shown = header_fields(header(STATED), Texts("de"))
    said = text_of(shown.replace("</dt>", ": ").replace("</div>", "; ").replace("<br>", " "))
    for words in (
        "Teil: shaft", "Zeichnung: D-4711", "Änderungsstand: C", "Seriennummer: S-0815", "Werkstoff: 6061-T6",
        "Maschine: Lathe 7, M-99", "Werkzeug: T3, SVJBR, Schneidenradius 0,8000 mm",
        "Schneide: VBMT 1604, Ecke 2, 2026-01-30 07:05 UTC", "Messmittel: probe 12", "Gemessen: 2026-01-31 06:00 UTC",
        "Programm: finish.nc, ge2000t", RECORD.id, STATED.program.sha256 if STATED.program else "",
    ):  # fmt: skip
        assert words in said
    assert "K. &lt;b&gt;Meier" in shown


def test_what_is_not_stated_is_empty() -> None:
    of = header(RECORD)
    assert (of.serial, of.operator, of.machine, of.insert, of.edge_set_at, of.measured_at) == (
        "",
        "",
        "",
        "",
        None,
        None,
    )
    assert header_fields(of).count("<dd>–</dd>") == 9
