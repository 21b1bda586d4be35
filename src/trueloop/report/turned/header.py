"""Which part, machine, tool, gauge and program a correction is of: what a page is filed by."""

from collections.abc import Iterable
from datetime import datetime

from trueloop.domain.program import Program
from trueloop.domain.record import Record
from trueloop.report.markup import esc, fields
from trueloop.report.shape import Shape
from trueloop.report.texts.texts import ENGLISH, Texts


class Header(Shape):
    """What the job, its files and the record state; empty or null where they state nothing."""

    part: str
    """Name or number of the part type."""
    drawing: str
    """Number of the drawing, where it is not the name."""
    revision: str
    """Revision of the drawing."""
    material: str
    """What the part is made of."""
    serial: str
    """Serial number of the piece that was measured."""
    operator: str
    """Who measured."""
    device: str
    """What measured: probe, gauge or measuring machine."""
    machine: str
    """The machine tool."""
    machine_serial: str
    """Its serial number."""
    program: str
    """File name of the finish program that was corrected."""
    program_sha256: str
    """SHA-256 of that file."""
    dialect: str
    """Dialect of its control."""
    tool: str
    """Name of the finishing tool or its holder."""
    tool_number: int | None
    """Number of its offset at the control, where the job states it."""
    nose_radius_mm: float | None
    """Its nose radius."""
    insert: str
    """The insert."""
    corner: str
    """Which corner of it cuts."""
    edge_set_at: str | None
    """When that edge was mounted, ISO 8601."""
    measured_at: str | None
    """When the part was measured, ISO 8601."""
    corrected_at: str
    """When the correction was made, ISO 8601."""
    corrected_by: str
    """Who made it."""
    record_id: str
    """Id of the correction's record, which stands in the corrected program too."""
    trueloop_version: str
    """What made it."""


def header(record: Record) -> Header:
    """Makes the header of a record."""
    part, tool, edge, machine = record.part_type, record.tool, record.edge, record.machine
    program = record.program or Program("", "", "")
    inspections = record.inspections
    return Header(
        part=part.name if part else "",
        drawing=part.drawing if part else "",
        revision=part.revision if part else "",
        material=part.material if part else "",
        serial=_all(one.part.serial for one in inspections),
        operator=_all(one.operator for one in inspections),
        device=_all(one.device for one in inspections),
        machine=machine.name if machine else "",
        machine_serial=machine.serial if machine else "",
        program=program.name,
        program_sha256=program.sha256,
        dialect=program.dialect,
        tool=tool.name if tool else "",
        tool_number=tool.number if tool else None,
        nose_radius_mm=tool.corner_radius_mm if tool else None,
        insert=edge.insert if edge else "",
        corner=edge.corner if edge else "",
        edge_set_at=_iso(record.edge_set_at),
        measured_at=_iso(max((one.measured_at for one in inspections if one.measured_at), default=None)),
        corrected_at=record.made_at,
        corrected_by=record.made_by,
        record_id=record.id,
        trueloop_version=record.trueloop_version,
    )


def header_fields(of: Header, say: Texts = ENGLISH) -> str:
    """Writes the header as names and values (HTML); what is not stated is a dash."""
    number = None if of.tool_number is None else f"T{of.tool_number}"
    nose = None if of.nose_radius_mm is None else say("nose {r} {mm}", r=say.mm(of.nose_radius_mm, 4))
    edge = say("corner {corner}", corner=of.corner) if of.corner else ""
    digest = f'<br><code class="hash">{esc(of.program_sha256)}</code>' if of.program_sha256 else ""
    rows = [
        (say("Part"), esc(of.part)),
        (say("Drawing"), esc(of.drawing)),
        (say("Revision"), esc(of.revision)),
        (say("Serial number"), esc(of.serial)),
        (say("Material"), esc(of.material)),
        (say("Machine"), esc(_all([of.machine, of.machine_serial]))),
        (say("Tool"), esc(_all([number or "", of.tool, nose or ""]))),
        (say("Edge"), esc(_all([of.insert, edge, _moment(of.edge_set_at)]))),
        (say("Gauge"), esc(of.device)),
        (say("Operator"), esc(of.operator)),
        (say("Measured"), esc(_moment(of.measured_at))),
        (say("Corrected"), esc(_all([_moment(of.corrected_at), of.corrected_by]))),
        (say("Record"), f"<code>{esc(of.record_id)}</code>, trueloop {esc(of.trueloop_version)}"),
        (say("Program"), f"{esc(_all([of.program, of.dialect]))}{digest}"),
    ]
    return fields(rows)


def _all(texts: Iterable[str]) -> str:
    return ", ".join(dict.fromkeys(text for text in texts if text))


def _iso(moment: datetime | None) -> str | None:
    return None if moment is None else moment.isoformat(timespec="seconds")


def _moment(iso: str | None) -> str:
    """A date and time as people write it, with its zone."""
    if iso is None:
        return ""
    try:
        return datetime.fromisoformat(iso).strftime("%Y-%m-%d %H:%M %Z").replace("UTC+00:00", "UTC").strip()
    except ValueError:
        return iso
