"""From a correction's record or job to a new tool table, or to the control's own words for the offset."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from trueloop.domain.option import Limits
from trueloop.domain.proposal import ToolOffset
from trueloop.domain.record import Record
from trueloop.errors import Code, Place, in_file
from trueloop.formats.outputs import write_all
from trueloop.formats.record_file import read_record
from trueloop.formats.tables.tool_tables.known import NewTable, new_table, read_tool_table
from trueloop.formats.tables.tool_tables.tool_table import ToolTable, Unit, XIs
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.program.dialect import dialect_named
from trueloop.turned.compensation.limits import check_offset
from trueloop.turned.program.wear_numbers import WearOffset
from trueloop.turned.program.wear_words import Control, counted, offset_program


@dataclass(frozen=True)
class Applied:
    """A tool table that was read and the one that was written, by which correction."""

    record_id: str
    table: ToolTable
    new: NewTable
    written: Path


def apply_offset(correction: Path, table: Path, target: Path, unit: Unit | None = None) -> Applied:
    """Writes the table with the offset of a correction changed.

    correction: its record (`.json`), or the job, which is computed anew. Raises REC, JOB, OFS and OUT errors, and
    CMP-SIZE where the offset is beyond the limit that the correction was made with.
    """
    record, offset = offset_of(correction)
    read = read_tool_table(table, unit)
    new = new_table(read, offset, record.id)
    (written,) = write_all(target.parent, [(target.name, new.content)], [table, correction])
    return Applied(record.id, read, new, written)


def offset_words(correction: Path, control: Control | None, x_is: XIs | None = None) -> str:
    """Writes the offset of a correction as a small program of its own control, or of another.

    `x_is` states how that other one counts offsets on X. Raises REC, JOB and OFS errors.
    """
    record, offset = offset_of(correction)
    own = "" if record.program is None else dialect_named(record.program.dialect).wear_words
    control = control or own or "heidenhain"
    counts = (x_is or offset.x_is) if control == own else counted(control, x_is)
    with in_file(correction):
        return offset_program(control, WearOffset.of(offset, counts), record.id)


def offset_of(correction: Path) -> tuple[Record, ToolOffset]:
    """Returns the record of a correction, and the tool offset that makes it. Raises OFS-NONE where no offset does."""
    is_record = correction.suffix.lower() == ".json"
    record = read_record(correction) if is_record else compensate(read_job(correction).inputs, sources=False).record
    offset = record.tool_offset
    if offset is None or not offset.makes_the_correction:
        what = "the contour" if offset is not None else "no tool offset"
        raise Code.OFS_NONE.refusal(
            f"correction {record.id} is made by {what}: its program is run with the tool's offset as it is",
            hint='to correct by the offset instead: `compensation.by = "offset"` in the job',
            place=Place(str(correction)),
        )
    with in_file(correction):
        check_offset((offset.x_radius_mm, offset.z_mm), Limits(correction_mm=_limit_mm(record)))
    return record, offset


def _limit_mm(record: Record) -> float:
    """The limit that the correction was made with."""
    limits = record.options.get("limits")
    value = limits.get("correction_mm") if isinstance(limits, Mapping) else None
    return float(value) if isinstance(value, int | float) else Limits.correction_mm
