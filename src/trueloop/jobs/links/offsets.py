"""The tool table of a control through its link: fetched whole, and written back with the offset of a correction."""

from dataclasses import dataclass, replace
from pathlib import Path

from trueloop.controllers.links.link import checked_name
from trueloop.errors import Code, TrueloopError
from trueloop.formats.tables.tool_tables.known import tool_table_of
from trueloop.formats.tables.tool_tables.new_table import NewTable, new_table
from trueloop.formats.tables.tool_tables.tool_table import ToolTable, Unit
from trueloop.jobs.links.opened import Opened
from trueloop.jobs.links.send import send
from trueloop.jobs.links.sent import Sent, require_idle
from trueloop.jobs.turned.tool_offsets import offset_of


@dataclass(frozen=True)
class AtControl:
    """A tool table as it was in force, the one that took its place, by which correction, and how it was sent."""

    record_id: str
    table: ToolTable
    new: NewTable
    sent: Sent


def with_table(opened: Opened, table: str | None, unit: Unit | None) -> Opened:
    """The link with another name of its tool table, or another unit, than its settings have. Raises LNK-NAME."""
    name = table or opened.tool_table
    if not name:
        raise TrueloopError(
            Code.LNK_NAME,
            f"nothing says which program at {opened.link.where} is the tool table",
            hint="name it with --table, or as `tool_table` in the settings",
            values={"name": name},
        )
    return replace(opened, tool_table=checked_name(name), table_unit=unit or opened.table_unit)


def fetched_table(opened: Opened) -> ToolTable:
    """The control's tool table in force. Raises LNK and OFS errors."""
    content = opened.link.read(opened.tool_table)
    return tool_table_of(Path(opened.tool_table), content, opened.table_unit)


def apply_at(opened: Opened, correction: Path, *, not_running: bool = False) -> AtControl:
    """Writes the control's tool table with the offset of a correction changed; the one before it is kept first.

    Only the table that was read is replaced, and only while no program runs (`not_running`: the user's word for
    links that cannot know). Raises what `send` and `apply_offset` raise.
    """
    record, offset = offset_of(correction)
    require_idle(opened.tool_table, opened, not_running)
    read = fetched_table(opened)
    new = new_table(read, offset, record.id)
    before = read.text.encode("latin-1")
    sent = send(opened, new.content, opened.tool_table, replace=before, not_running=not_running)
    return AtControl(record.id, read, new, sent)
