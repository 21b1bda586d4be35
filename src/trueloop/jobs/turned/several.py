"""From the job of a part that several edges cut to one corrected program, with a report and a record an edge."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from trueloop.domain.page_options import Language, LengthUnit, PageOptions
from trueloop.formats.input_file import FilePath
from trueloop.formats.outputs import write_all
from trueloop.formats.tables.control_tables import table_to_csv
from trueloop.jobs.store.keeping import Keeping, kept_all_the_same
from trueloop.jobs.store.where import store_of
from trueloop.jobs.turned.compensate import with_memory
from trueloop.jobs.turned.job import decided_of, inputs_of, read_files
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.turned.new_tables import new_tables
from trueloop.jobs.turned.of_edge import require_kept_apart, stored_inputs
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.edges import contours_of
from trueloop.loops.turned.joint import Joint, OfEdge, correct_edges
from trueloop.memory.edge.options import Use
from trueloop.nc.match.own_contour import OwnContour
from trueloop.report.pdf import as_pdf
from trueloop.report.texts.texts import Texts
from trueloop.report.turned.correction_json import json_text
from trueloop.report.turned.joint import joint_json, joint_page
from trueloop.report.turned.page import page as page_of

if TYPE_CHECKING:
    from trueloop.jobs.store.keep_facts import KeptFacts
    from trueloop.storage.store import Store


@dataclass(frozen=True)
class DoneJoint:
    """The corrections of a job of several edges, the name of the program that carries them, the files written, and what
    was kept in the job's store; None: it has none.
    """

    joint: Joint
    name: str
    files: list[Path]
    kept: "KeptFacts | None" = None


def has_several(job: FilePath) -> bool:
    """Whether a job lists several edges. Raises JOB errors."""
    return bool(JobFiles.of(Path(job)).job.tools)


def correct_several(
    job: FilePath,
    output: FilePath | None,
    keeping: Keeping,
    *,
    language: Language | None = None,
    unit: LengthUnit | None = None,
    pdf: bool = False,
    memory: Use | None = None,
) -> DoneJoint:
    """Corrects, keeps and writes: all or none. Raises what correcting one edge refuses, NC-TOOLS, NC-EDGE, NC-NO-TOOL,
    JOB-TOOLS, STO, EDG, MEM and OUT errors.
    """
    files = JobFiles.of(Path(job)).with_serial(keeping.serial)
    store = store_of(files.path.parent, keeping.db, files.job.store.db)
    if store is not None:
        require_kept_apart(files)
    cuts = read_cuts(files)
    name = f"corrected{Path(cuts[0][1].program.file_name).suffix}"
    profile = cuts[0][1].profile

    def known(inputs: Inputs, own: OwnContour) -> Inputs:
        return with_memory(store, stored_inputs(inputs, profile, own), memory)

    joint = correct_edges(cuts, name, None if store is None else known)
    options = files.page_options(language, unit)
    folder = files.output_folder if output is None else Path(output)
    contents = [*new_tables([(files, joint)]), *outputs_of_edges(joint, name, options, pdf).items()]
    kept = None if store is None else keep_edges(store, joint.edges, keeping)
    with kept_all_the_same(kept):
        return DoneJoint(joint, name, write_all(folder, contents, files.sources.files), kept)


def keep_edges(store: "Store", edges: Sequence[OfEdge], keeping: Keeping) -> "KeptFacts":
    """The share that each edge has of the part, as a part of its own: all of them or none."""
    from trueloop.jobs.store.keep_correction import keep_corrections  # slow to import, and most jobs have no store

    made = [(one.inputs, one.correction) for one in edges if one.inputs is not None and one.correction is not None]
    return keep_corrections(store, made, keeping)


def read_cuts(files: JobFiles) -> list[tuple[OwnContour, Inputs]]:
    """Every edge of a job with its contour and the inputs of the whole part with that edge's tool."""
    read = read_files(files)
    decided = decided_of(files, read.profile)
    tables = {tool.called: tool for tool in files.job.tools}
    contours = contours_of(read.program, files.run, read.profile, files.edges, decided)
    return [(own, inputs_of(files.with_tool(tables[own.edge.called]), read)) for own in contours]


def label_of(of: OfEdge) -> str:
    """What stands for an edge in file names: `T5`, `T5-D2`."""
    return of.contour.edge.called.words.replace(" ", "-")


def outputs_of_edges(joint: Joint, name: str, options: PageOptions, pdf: bool) -> Mapping[str, bytes | None]:
    """File name to bytes; `part.json` comes last: then the set is complete."""
    contents: dict[str, bytes | None] = {name: joint.program}
    reports = {one.tool: f"report-{label_of(one)}.html" for one in joint.edges}
    for one in joint.edges:
        contents |= outputs_of_edge(one, label_of(one), options, pdf)
    contents["report.html"] = joint_page(joint, name, reports, texts_of([joint], options)).encode()
    contents["part.json"] = joint_json(joint, name).encode()
    return contents


def outputs_of_edge(of: OfEdge, label: str, options: PageOptions, pdf: bool) -> Mapping[str, bytes | None]:
    """The files of one edge, its `label` in their names; none where nothing was measured of what it cuts."""
    if of.correction is None:
        return {}
    program = of.correction.record.program
    html = page_of(of.correction, Texts.of(options, None if program is None else program.unit))
    return {
        f"table-{label}.csv": table_to_csv(of.correction.table),
        f"report-{label}.html": html.encode(),
        f"report-{label}.pdf": as_pdf(html) if pdf else None,
        f"report-{label}.json": json_text(of.correction).encode(),
        f"record-{label}.json": of.correction.record.to_json().encode(),
    }


def texts_of(joints: Sequence[Joint], options: PageOptions) -> Texts:
    """The texts of a page of all edges, in the unit of the first program that says its own."""
    records = [one.record for joint in joints for one in joint.corrections]
    units = [record.program.unit for record in records if record.program is not None]
    return Texts.of(options, units[0] if units else None)
