"""The correction that cut a job's measured part: stated in the job, known to its store, or asked for."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import UTC, datetime
from os import scandir
from os.path import relpath
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Ran
from trueloop.domain.option import latest_time
from trueloop.domain.record import Product, Record, sha256_of
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.jobs.tool_tables import ToolsTable
from trueloop.formats.record_file import read_record, record_of_edge
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.in_force import InForce, in_force
from trueloop.nc.program.called import CalledOffset
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.units import UM_PER_MM
from trueloop.wording import wording

GIVEN: Final = "given"
"""`programs.cut_with` of a part that the finish program cut as it is."""
ID: Final = re.compile(r"[0-9a-f]{16}")
FEWEST: Final = 3
ACROSS: Final = 0.75
"""Normals whose product is no more (41 degrees) look in two directions."""
ALIKE: Final = 0.25
"""Errors that differ by no more than this share of their mean are one amount."""
SURE: Final = 3.0
"""Standard uncertainties that the mean error has to be beyond."""
DEEPEST: Final = 4
"""Levels of folders that are searched for corrections, below those that job, outputs and program are in."""
MOST_FOLDERS: Final = 2000
"""Folders searched at most: a job may lie in the root of a large disk."""
OF_ALL: Final = "part.json"
"""File that names the corrections of several edges or set-ups; their records are beside it."""


def with_cut(files: JobFiles, inputs: Inputs) -> Inputs:
    """Inputs with what cut the measured part, as far as the job and the corrections beside it say.

    Raises MSR-OLD for measurements from before the correction that the job names, CMP-CUT-WITH and REC errors for what
    it states and cannot be, CMP-OTHER-PROGRAM for a correction of another program.
    """
    programs, after = files.job.own_programs, files.job.gauging.after_record
    if after is not None:
        file = _of_edge(files, inputs, Path(after))
        if file is not None:
            require_later(read_record(file), inputs.inspections, files.path, time_needed=True)
    stated = programs.cut_with or ("" if after is None else str(after))
    if not inputs.measured_finished:
        if programs.cut_with:
            raise Code.CMP_CUT_WITH.refusal(
                f"programs.cut_with is {programs.cut_with!r}, and the part was measured before its finish cut: what "
                "cut it is the semi-finish program",
                hint="leave `programs.cut_with` out, or, where the finished part was measured, `programs.semifinish` "
                "and the allowances",
                place=Place(str(files.path)),
                values={"corrections": [programs.cut_with]},
            )
        return inputs
    if not stated:
        with in_file(files.path):
            _require_no_allowance(inputs.touches)
        # Folders near the job, its outputs and its program
        program = files.path.parent / files.job.own_programs.finish
        homes = [files.path.parent.resolve(), files.output_folder.resolve(), program.resolve().parent]
        within = folders_near([*homes, *(home.parent for home in homes)])
        if len(within) == MOST_FOLDERS:
            note = wording(
                "Corrections of the program were looked for in {n} folders near the job, and there are more: state "
                "`programs.cut_with` if one of them was in force.",
                n=MOST_FOLDERS,
            )
            inputs = replace(inputs, notes=(*inputs.notes, note))
        return with_possible(inputs, tuple(_near(files, inputs, within)))
    by = None if programs.cut_by is None else Ran(programs.cut_by)
    with in_file(files.path):
        return replace(inputs, in_force=_stated(files, inputs, stated, by))


def _stated(files: JobFiles, inputs: Inputs, stated: str, by: Ran | None) -> InForce:
    if stated == GIVEN and by is not None:
        raise Code.CMP_CUT_WITH.refusal(
            f'programs.cut_with is "{GIVEN}", the finish program as it is, and programs.cut_by is {by.value!r}, of a '
            "correction that was in force",
            hint="leave `programs.cut_by` out, or name that correction in `programs.cut_with`",
            values={"corrections": []},
        )
    if stated == GIVEN:
        return InForce(stated=True)
    if ID.fullmatch(stated) and not (files.path.parent / stated).exists():
        return InForce(stored=stated, by=by)
    file = _of_edge(files, inputs, Path(stated))
    if file is None:
        return InForce(stated=True)
    record = read_record(file)
    tool = files.job.tool
    if isinstance(tool, ToolsTable) and not is_of_edge(record, tool.called):
        return InForce(stated=True)
    if not isinstance(tool, ToolsTable):
        require_tool(record, inputs)
    require_later(record, inputs.inspections, files.path, time_needed=False)
    found = in_force(record, by, inputs.program, inputs.lines, _sha256_beside(file, record, by))
    require_another_part(record, inputs.inspections)
    return replace(found, stated=True)


def _of_edge(files: JobFiles, inputs: Inputs, name: Path) -> Path | None:
    """Returns the record of the job's tool by a `part.json`, None: it lists none; another file as it is. Raises REC."""
    file = files.sources.file(name)
    if name.name != OF_ALL or not isinstance(files.job.tool, ToolsTable):
        return file
    called = files.job.tool.called
    sha256 = sha256_of(inputs.program.source)
    wanted = record_of_edge(file, files.setup, (called.number, called.edge), sha256)
    if wanted is None:
        return None
    label = called.words.replace(" ", "-")
    record = files.sources.file(name.with_name(f"record-{f'{files.setup}-' if files.setup else ''}{label}.json"))
    if read_record(record).id != wanted:
        raise Code.REC_FILE.refusal(
            f"{record.name!r} is not the record of correction {wanted}, which {file.name!r} lists",
            hint=f"name a {OF_ALL} beside the records that were written with it",
            place=Place(str(file)),
        )
    return record


def require_tool(record: Record, inputs: Inputs) -> None:
    """Refuses, for a job of one tool, the correction of another one: CMP-CUT-WITH."""
    number = None if record.tool is None else record.tool.number
    if number is None or inputs.options.tool in (None, number):
        return
    raise Code.CMP_CUT_WITH.refusal(
        f"correction {record.id} is of tool {number}, and this job corrects tool {inputs.options.tool}: what it writes "
        "would lose that correction",
        hint="list both tools in one job, each in its [[tools]]; an offset of the other tool that was entered at the "
        'control stays there: cut_with = "given"',
        values={"corrections": [record.id]},
    )


def is_of_edge(record: Record, called: CalledOffset) -> bool:
    """Returns whether a correction moves what an edge of a job with several cuts: not that of another tool's own job.

    Raises CMP-CUT-WITH for the correction of another edge of such a job: what was in force of this one is not stated.
    """
    edge = record.options.get("edge")
    if edge is None:
        return record.tool is None or record.tool.number in (None, called.number)
    if str(edge).partition(" (")[0] == called.words:  # without the corner of a groove insert
        return True
    raise Code.CMP_CUT_WITH.refusal(
        f"correction {record.id} is of {edge} alone; which corrections of the job's other edges were in force is not "
        "stated",
        hint=f'name the `{OF_ALL}` that was written with it, which lists those of all edges: cut_with = "o1/{OF_ALL}"',
        values={"corrections": [record.id]},
    )


def _sha256_beside(file: Path, record: Record, by: Ran | None) -> str:
    """The hash of the program that was written beside a record, known by its mark; "" where there is none."""
    stem = "offsets" if by is Ran.OFFSETS else "corrected"
    if by is Ran.WEAR:
        return ""
    for one in sorted(file.parent.glob(f"{stem}*")):
        content = one.read_bytes() if one.is_file() else b""
        if record.id.encode() in content:
            return sha256_of(content)
    return ""


def with_possible(inputs: Inputs, records: Sequence[tuple[Record, str]]) -> Inputs:
    """Returns inputs with the corrections that may have cut the part; a note where all are younger: a wrong clock."""
    measured_at = inputs.measured_at
    possible = tuple(
        words
        for record, words in records
        if measured_at is None or datetime.fromisoformat(record.made_at).astimezone(UTC) <= latest_time(measured_at)
    )
    notes = inputs.notes
    if records and not possible and measured_at is not None:
        note = wording(
            "The part was measured {when}, before its program's corrections were made, by the clock of what measured "
            "it: it is taken as cut by the given program. Else state `programs.cut_with`.",
            when=measured_at.isoformat(timespec="minutes"),
        )
        notes = (*notes, note)
    return replace(inputs, in_force=replace(inputs.in_force, possible=possible), notes=notes)


def _near(files: JobFiles, inputs: Inputs, within: Sequence[Path]) -> Iterator[tuple[Record, str]]:
    """Corrections of the job's program in folders, and their words."""
    given, folder = sha256_of(inputs.program.source), files.path.parent.resolve()
    for file in sorted({file for one in within for file in one.glob("record*.json")}):
        try:
            if given in file.read_text(errors="replace"):
                record = read_record(file)
                if is_of_cut(record, inputs):
                    whole = file.with_name(OF_ALL)
                    shown = whole if "edge" in record.options and whole.is_file() else file
                    yield record, f"{_seen_from(folder, shown)} ({record.id})"
        except (OSError, TrueloopError):
            continue


def _seen_from(folder: Path, file: Path) -> str:
    """The path of a file from a folder; where it lies on another drive, the whole."""
    try:
        return Path(relpath(file, folder)).as_posix()
    except ValueError:
        return file.as_posix()


def folders_near(starts: Sequence[Path]) -> list[Path]:
    """Returns the folders given and those within them to a depth of DEEPEST, nearest first; at most MOST_FOLDERS."""
    found = dict.fromkeys(starts)
    level = list(found)
    for _ in range(DEEPEST):
        deeper: list[Path] = []
        for one in level:
            if len(found) + len(deeper) >= MOST_FOLDERS:
                break
            try:
                deeper += [Path(entry) for entry in scandir(one) if (not entry.name.startswith(".") and entry.is_dir())]
            except OSError:
                continue
        level = [one for one in deeper if one not in found]
        found.update(dict.fromkeys(level))
    return list(found)[:MOST_FOLDERS]


def is_of_cut(record: Record, inputs: Inputs) -> bool:
    """Returns whether a correction is of the program and tool that cut the part, and not made from this measurement."""
    if record.product is not Product.TURNED or record.program is None:
        return False
    if record.program.sha256 != sha256_of(inputs.program.source):
        return False
    numbers = {inputs.options.tool, None if record.tool is None else record.tool.number} - {None}
    if inputs.called is None and len(numbers) > 1:
        return False
    if inputs.called is not None and record.options.get("edge") not in (None, inputs.called.words):
        return False
    return not _is_from(record, inputs.inspections)


def _is_from(record: Record, inspections: Sequence[Inspection], *, one_part: bool = False) -> bool:
    """Returns whether a correction was made from these measurements: equal files, not of two parts by serial number.

    one_part: the same rows without another time are one measurement, whatever serial number the job states.
    """
    return any(
        inspection.sha256 == other.sha256
        and (
            inspection.part.serial == other.part.serial
            or not (inspection.part.serial and other.part.serial)
            or (one_part and inspection.measured_at == other.measured_at and _rows(inspection) == _rows(other))
        )
        for inspection in inspections
        for other in record.inspections
    )


def _rows(of: Inspection) -> list[object]:
    return [*((value.line, value.actual) for value in of.readings), *of.touches, *of.points]


def require_later(record: Record, inspections: Sequence[Inspection], job: Path, *, time_needed: bool) -> None:
    """Refuses measurements from before a correction, and, where `time_needed`, those of no known time: MSR-OLD."""
    corrected_at = datetime.fromisoformat(record.made_at).astimezone(UTC)
    hint = (
        "a part that was cut before it was cut without it: leave out `gauging.after_record`, and state what was in "
        "force then by `programs.cut_with`; `gauging.measured_at` states when a part was measured"
        if time_needed
        else "what was measured before a correction was made was not cut with it: state what did cut it in "
        "`cut_with`; if the clock of what measured it was wrong, `gauging.measured_at` states when it was"
    )
    for measured_at in (inspection.measured_at for inspection in inspections):
        if time_needed if measured_at is None else latest_time(measured_at) < corrected_at:
            when = "" if measured_at is None else measured_at.isoformat(timespec="seconds")
            raise Code.MSR_OLD.refusal(
                wording(
                    "the part was measured at {when}, correction {correction} was made at {corrected_at}",
                    when=when or "a time that is not stated",
                    correction=record.id,
                    corrected_at=corrected_at.isoformat(timespec="minutes"),
                ),
                hint=hint,
                place=Place(str(job)),
                values={"measured_at": when, "corrected_at": corrected_at.isoformat()},
            )


def require_another_part(record: Record, inspections: Sequence[Inspection]) -> None:
    """Refuses a correction made from the finished part that it is stated to have cut: CMP-CUT-WITH."""
    serials = {inspection.part.serial for inspection in inspections if inspection.part.serial}
    own = sorted(serials & {inspection.part.serial for inspection in record.inspections})
    if record.cut_with is not None and (own or _is_from(record, inspections, one_part=True)):
        part = f"finished part {own[0]!r}" if own else "this very measurement of a finished part"
        raise Code.CMP_CUT_WITH.refusal(
            wording(
                "correction {correction} was made from {part}, which is stated to be cut with it",
                correction=record.id,
                part=part,
            ),
            hint=f"state in programs.cut_with what cut the part: {record.cut_with.words}; if it was cut again with "
            "this correction, or is another part, measure it anew and give it a serial number of its own",
            values={"corrections": [record.id]},
        )


def _require_no_allowance(measured: ErrorVectors) -> None:
    """Refuses a finished part that is too large by about one amount in several directions: CMP-ALLOWANCE.

    An allowance that is still on leaves the same on cylinders, faces, cones and arcs; an offset of a tool leaves other
    amounts there, but by chance.
    """
    rows = np.flatnonzero(measured.standard_u_mm > 0.0)
    error_mm, normal = measured.error_mm[rows], measured.outward_normal[rows]
    if len(rows) < FEWEST or np.min(error_mm) <= 0.0 or np.min(normal @ normal.T) > ACROSS:
        return
    middle_mm = float(np.mean(error_mm))
    beyond = middle_mm > SURE * float(np.max(measured.standard_u_mm[rows]))
    if beyond and float(np.ptp(error_mm)) <= ALIKE * middle_mm:
        size_um = middle_mm * UM_PER_MM
        raise Code.CMP_ALLOWANCE.refusal(
            wording(
                "all {n} measured places, which look in several directions, are too large by about {size_um:.1f} "
                "µm: is an allowance still on?",
                n=len(rows),
                size_um=size_um,
            ),
            hint=f"if it is: gauging.measured_allowance_mm = {middle_mm:.3f}, as it was meant; if the part is "
            'finished: programs.cut_with = "given", or the record of the correction in force',
            values={"size_um": size_um},
        )


def stored_words(record: Record) -> str:
    """Names a correction that only the store knows, as a possible one."""
    return f"{record.id} of {record.made_at[:16]}, in the store"
