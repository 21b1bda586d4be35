"""From a turned part's job file to its corrected programs, table, report and record."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from trueloop.domain.page_options import Language, LengthUnit, PageOptions
from trueloop.formats.input_file import FilePath
from trueloop.formats.outputs import write_all
from trueloop.formats.tables.control_tables import table_to_csv
from trueloop.formats.tables.tool_tables.known import new_table
from trueloop.formats.tables.tool_tables.tool_table import ToolTable
from trueloop.jobs.store.keeping import Keeping, kept_all_the_same
from trueloop.jobs.store.where import store_of
from trueloop.jobs.turned.job import ReadJob, read_job
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.memory.edge.options import Use
from trueloop.report.pdf import as_pdf
from trueloop.report.texts.texts import Texts
from trueloop.report.turned.correction_json import json_text
from trueloop.report.turned.page import page as page_of

if TYPE_CHECKING:
    from trueloop.jobs.store.keep_facts import KeptFacts
    from trueloop.storage.store import Store

METRIC: Final = PageOptions(unit="mm")


@dataclass(frozen=True)
class Done:
    """A job's correction, the files written, and what was kept in its store; None: it has none."""

    correction: Correction
    files: list[Path]
    kept: "KeptFacts | None" = None


def compensate_job(
    job: FilePath,
    output: FilePath | None = None,
    *,
    language: Language | None = None,
    unit: LengthUnit | None = None,
    pdf: bool = False,
) -> tuple[Correction, list[Path]]:
    """The correction of a job and the files written: into `output`, or the folder that the job names; all or none.

    `language` and `unit` of the page, where they are not to be the job's; `pdf`: the page as PDF besides.

    Raises what reading and correcting refuse, and OUT errors.

    >>> correction, files = trueloop.compensate_job(trueloop.example("modbas2/job.toml"), "out")
    >>> [file.name for file in files]
    ['corrected.nc', 'offsets.nc', 'table.csv', 'report.html', 'report.json', 'record.json']
    """
    done = compensate_and_keep(job, output, Keeping(), language=language, unit=unit, pdf=pdf)
    return done.correction, done.files


def compensate_and_keep(
    job: FilePath,
    output: FilePath | None,
    keeping: Keeping,
    *,
    language: Language | None = None,
    unit: LengthUnit | None = None,
    pdf: bool = False,
    memory: Use | None = None,
) -> Done:
    """Corrects a job, writes its files, and stores the correction in the job's store or in that of `keeping`.

    All is computed before anything is kept, and kept before it is written: no program can be run of which the store
    knows nothing. Where writing is refused then, the refusal says that the correction is kept. `memory`: how earlier
    parts of the edge take part, where that is not to be the job's choice. Raises STO, EDG and MEM
    errors.
    """
    made = correct_job(job, keeping, memory)
    read, store, inputs, correction = made.read, made.store, made.inputs, made.correction
    folder = Path(output or _from_here(read.output_folder))
    options = PageOptions(language or read.page.language, unit or read.page.unit)
    contents = {**_new_table(read.tool_table, correction), **outputs_of(correction, options, pdf)}
    if store is None:
        return Done(correction, write_all(folder, contents.items(), read.files))
    from trueloop.jobs.store.keep_correction import keep_correction  # slow to import, and most jobs have no store

    kept = keep_correction(store, inputs, correction, keeping)
    with kept_all_the_same(kept):
        return Done(correction, write_all(folder, contents.items(), read.files), kept)


@dataclass(frozen=True)
class Corrected:
    """A job as read, its store, the inputs with what that knows of the edge, and the correction; nothing is written."""

    read: ReadJob
    store: "Store | None"
    inputs: Inputs
    correction: Correction


def correct_job(job: FilePath, keeping: Keeping, memory: Use | None = None) -> Corrected:
    """The correction of a job, nothing kept and nothing written. Raises what reading and correcting refuse."""
    read = read_job(job, serial=keeping.serial)
    return corrected_of(read, store_of(Path(job).parent, keeping.db, read.store_db), memory)


def corrected_of(read: ReadJob, store: "Store | None", memory: Use | None = None) -> Corrected:
    """The same of a job that was read, with what a store knows. Raises what correcting refuses."""
    inputs = with_memory(store, read.inputs, memory)
    return Corrected(read, store, inputs, compensate(inputs))


def with_memory(store: "Store | None", inputs: Inputs, memory: Use | None) -> Inputs:
    """The inputs with what the store knows of the part and the edge; `memory` takes the place of the job's choice."""
    if memory is not None:
        inputs = replace(inputs, memory=replace(inputs.memory, memory=memory))
    if store is None:
        return inputs
    from trueloop.jobs.store.keep_correction import part_of
    from trueloop.jobs.store.remembered import with_history
    from trueloop.jobs.tools import with_edge
    from trueloop.jobs.turned.stored_cut import with_stored_cut  # slow to import, and most jobs have no store

    return with_history(store, with_edge(store, with_stored_cut(store, inputs, part_of(inputs))))


def write_correction(
    correction: Correction, folder: FilePath, inputs: Iterable[Path] = (), page: PageOptions = METRIC, pdf: bool = False
) -> list[Path]:
    """Writes programs, table, report and record into a folder: all or none. `page`: how the report is shown.

    `inputs` are files that must not be overwritten, those that the correction was made from. Raises OUT errors.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> correction = trueloop.compensate(replace(job.inputs, options=trueloop.Options(weight=0.5)))
    >>> len(trueloop.write_correction(correction, "half", job.files))
    6
    """
    return write_all(Path(folder), outputs_of(correction, page, pdf).items(), inputs)


def _new_table(table: ToolTable | None, correction: Correction) -> Mapping[str, bytes | None]:
    """The job's tool table with the offset in it, where the offset makes the correction. Raises OFS errors."""
    if table is None:
        return {}
    offset = correction.record.tool_offset
    made = offset is not None and offset.makes_the_correction
    content = new_table(table, offset, correction.record.id).content if offset is not None and made else None
    return {f"new-{table.path.name}": content}


def _from_here(folder: Path) -> Path:
    """The folder as seen from where the program runs, without a detour by the job's folder."""
    resolved = folder.resolve()
    return resolved.relative_to(Path.cwd()) if resolved.is_relative_to(Path.cwd()) else resolved


def outputs_of(correction: Correction, options: PageOptions = METRIC, pdf: bool = False) -> Mapping[str, bytes | None]:
    """File name to bytes, None for one that there shall not be. The record comes last: then its set is complete."""
    program = correction.record.program
    html = page_of(correction, Texts.of(options, None if program is None else program.unit))
    return {
        correction.corrected_name: None if correction.runs_as_given else correction.corrected_program,
        correction.offsets_name: correction.offsets_program,
        "table.csv": table_to_csv(correction.table),
        "report.html": html.encode(),
        "report.pdf": as_pdf(html) if pdf else None,
        "report.json": json_text(correction).encode(),
        "record.json": correction.record.to_json().encode(),
    }
