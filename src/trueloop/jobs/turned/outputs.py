"""The files of a part's corrections: programs, tables, reports and records, and the tool tables with their offsets.

From a correction's record or job to a new tool table, or to the control's own words for the offset.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

from trueloop.domain.option import Limits, PageOptions
from trueloop.domain.proposal import ToolOffset
from trueloop.domain.record import Record
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.jobs.tool_tables import ToolTable as TableOfTool
from trueloop.formats.outputs import write_all
from trueloop.formats.record_file import read_record
from trueloop.formats.tables.control_tables import table_to_csv
from trueloop.formats.tables.tool_tables.known import NewTable, new_table, read_tool_table, tool_table_of
from trueloop.formats.tables.tool_tables.tool_table import ToolTable, Unit, XIs
from trueloop.jobs.turned.job import read_job
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.part import EdgeCorrection, PartCorrection, SetupCorrection
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.program.dialect import dialect_named
from trueloop.report.pdf import as_pdf
from trueloop.report.texts.texts import Texts
from trueloop.report.turned.correction_json import json_text
from trueloop.report.turned.page import page as page_of
from trueloop.report.turned.part import part_json, part_page
from trueloop.turned.compensation.limits import check_offset
from trueloop.turned.program.wear_numbers import CONTROLS, Control, WearOffset, counted, offset_program, own_control

METRIC: Final = PageOptions(unit="mm")
NAMES: Final = (("table", "csv"), ("report", "html"), ("report", "pdf"), ("report", "json"), ("record", "json"))
"""Files of one edge's correction; the record comes last."""


def as_first_made(corrected: PartCorrection, folder: Path) -> PartCorrection:
    """Returns corrections with the time of their records in the folder: written again they are no younger."""
    setups = [
        replace(setup, edges=tuple(_first_made(setup, edge, folder) for edge in setup.edges))
        for setup in corrected.setups
    ]
    return replace(corrected, setups=tuple(setups))


def _first_made(setup: SetupCorrection, edge: EdgeCorrection, folder: Path) -> EdgeCorrection:
    label, made = _label(setup, edge), edge.correction
    file = folder / (f"record-{label}.json" if label else "record.json")
    if made is None or not file.is_file():
        return edge
    try:
        before = read_record(file)
    except TrueloopError:
        return edge
    same = before.id == made.record.id
    return (
        replace(edge, correction=replace(made, record=replace(made.record, made_at=before.made_at))) if same else edge
    )


def outputs_of_part(corrected: PartCorrection, options: PageOptions, pdf: bool) -> Mapping[str, bytes | None]:
    """Returns bytes by file name, None: there shall be none; `part.json` or the only record completes the set."""
    if corrected.alone is not None:
        return outputs_of(corrected.alone, options, pdf)
    contents: dict[str, bytes | None] = {correction.name: correction.program for correction in corrected.setups}
    reports: dict[tuple[str, str], str] = {}
    for setup in corrected.setups:
        for edge in setup.edges:
            label = _label(setup, edge)
            contents |= _of_edge(edge, label, options, pdf)
            reports[setup.frame.name, edge.tool] = f"report-{label}.html"
    # The texts of a page of all edges, in the unit of the first program that says its own
    records = [correction.record for setup in corrected.setups for correction in setup.corrections]
    units = [record.program.unit for record in records if record.program is not None]
    contents["report.html"] = part_page(corrected, reports, Texts.of(options, units[0] if units else None)).encode()
    contents["part.json"] = part_json(corrected).encode()
    return contents


def outputs_of(correction: Correction, options: PageOptions = METRIC, pdf: bool = False) -> Mapping[str, bytes | None]:
    """Returns the outputs of a job of one tool; the record comes last."""
    return {
        correction.corrected_name: None if correction.runs_as_given else correction.corrected_program,
        correction.offsets_name: correction.offsets_program,
        **_of_correction(correction, "", options, pdf),
    }


def _label(setup: SetupCorrection, edge: EdgeCorrection) -> str:
    """Names an edge in file names: `T5`, `T5-D2`, `first-T5`."""
    called = "" if edge.contour is None else edge.contour.edge.called.words.replace(" ", "-")
    return "-".join(filter(None, (setup.frame.name, called)))


def _of_edge(of: EdgeCorrection, label: str, options: PageOptions, pdf: bool) -> Mapping[str, bytes | None]:
    """Those of one edge, labelled; where nothing was measured of it the record in force alone."""
    if of.correction is not None:
        return _of_correction(of.correction, f"-{label}", options, pdf)
    none: dict[str, bytes | None] = dict.fromkeys(_names(f"-{label}"))
    return none if of.kept is None else none | {f"record-{label}.json": of.kept.to_json().encode()}


def _names(ending: str) -> tuple[str, ...]:
    return tuple(f"{name}{ending}.{kind}" for name, kind in NAMES)


def _of_correction(correction: Correction, ending: str, options: PageOptions, pdf: bool) -> dict[str, bytes | None]:
    program = correction.record.program
    html = page_of(correction, Texts.of(options, None if program is None else program.unit))
    contents = (
        table_to_csv(correction.table),
        html.encode(),
        as_pdf(html) if pdf else None,
        json_text(correction).encode(),
        correction.record.to_json().encode(),
    )
    return dict(zip(_names(ending), contents, strict=True))


def new_tables(files: JobFiles, corrected: PartCorrection) -> list[tuple[str, bytes | None]]:
    """Returns contents by file name: of every table that the job's tools name `new-NAME`, of two of one name
    `new-FOLDER-NAME`; None where no offset changes.

    Edges that stand in one table are written into it one after the other. Raises OFS errors.
    """
    found: dict[Path, bytes | None] = {}
    for one, setup in zip(files.of_setups, corrected.setups, strict=True):
        tables = {tool.called: tool for tool in one.job.tools}
        for edge in setup.edges:
            own = one if edge.contour is None else one.with_tool(tables[edge.contour.edge.called])
            if own.tool.table is not None:
                found[own.tool.table] = _with_offset(own, own.tool, own.tool.table, edge, found.get(own.tool.table))
    names = [path.name for path in found]
    folders = {path: f"{path.resolve().parent.name}-" if names.count(path.name) > 1 else "" for path in found}
    return [(f"new-{folders[path]}{path.name}", content) for path, content in found.items()]


def _with_offset(
    files: JobFiles, tool: TableOfTool, path: Path, edge: EdgeCorrection, before: bytes | None
) -> bytes | None:
    """The table with one edge's offset more; `before`: with those of others."""
    offset = None if edge.correction is None else edge.correction.record.tool_offset
    if edge.correction is None or offset is None or not offset.makes_the_correction:
        return before
    return new_table(_read(files, tool, path, before), offset, edge.correction.record.id).content


def _read(files: JobFiles, tool: TableOfTool, path: Path, before: bytes | None) -> ToolTable:
    given = files.tool_table(path)
    return given if before is None else tool_table_of(given.path, before, tool.table_unit)


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
    """Writes a correction's offset as a program of its control or another, `x_is` as that counts: REC, JOB, OFS."""
    record, offset = offset_of(correction)
    own = None if record.program is None else own_control(dialect_named(record.program.dialect))
    control = control or own
    if control is None:
        raise Code.OFS_WORDS.refusal(
            f"{'' if record.program is None else record.program.dialect!r}: which words change an offset is not known",
            hint=f"state it: `--control`, one of {', '.join(CONTROLS)}",
            place=Place(str(correction)),
            values={"control": ""},
        )
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
        instead = 'to correct by the offset instead: `compensation.by = "offset"` in the job'
        raise Code.OFS_NONE.refusal(
            f"correction {record.id} is made by {what}: its program is run with the tool's offset as it is",
            hint=instead if offset is not None else "run the program of the correction: no offset can carry it",
            place=Place(str(correction)),
        )
    if not offset.tool:
        raise Code.OFS_TOOL.refusal(
            f"correction {record.id} is of a tool without a number in the control's table, or whose offset is not in "
            "force in the finish pass",
            hint="run the program with tool offsets that was written beside the record",
            place=Place(str(correction)),
            values={"tool": 0.0},
        )
    with in_file(correction):
        check_offset((offset.x_radius_mm, offset.z_mm), Limits(correction_mm=_limit_mm(record)))
    return record, offset


def _limit_mm(record: Record) -> float:
    """The limit that the correction was made with."""
    limits = record.options.get("limits")
    value = limits.get("correction_mm") if isinstance(limits, Mapping) else None
    return float(value) if isinstance(value, int | float) else Limits.correction_mm
