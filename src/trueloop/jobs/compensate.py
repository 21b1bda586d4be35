"""From a turned part's job file to its corrected programs, table, report and record."""

from collections.abc import Iterable, Mapping
from pathlib import Path

from trueloop.formats.input_file import FilePath
from trueloop.formats.outputs import write_all
from trueloop.formats.tables.table_csv import table_to_csv
from trueloop.formats.tables.tool_tables.new_table import new_table
from trueloop.formats.tables.tool_tables.tool_table import ToolTable
from trueloop.jobs.turned import read_job
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.report.turned.page import page


def compensate_job(job: FilePath, output: FilePath | None = None) -> tuple[Correction, list[Path]]:
    """The correction of a job and the files written: into `output`, or the folder that the job names; all or none.

    Raises what reading and correcting refuse, and OUT errors.

    >>> correction, files = trueloop.compensate_job(trueloop.example("modbas2/job.toml"), "out")
    >>> [file.name for file in files]
    ['corrected.nc', 'offsets.nc', 'table.csv', 'report.html', 'record.json']
    """
    read = read_job(job)
    correction = compensate(read.inputs)
    folder = Path(output or _from_here(read.output_folder))
    contents = {**_new_table(read.tool_table, correction), **outputs_of(correction)}
    return correction, write_all(folder, contents.items(), read.files)


def write_correction(correction: Correction, folder: FilePath, inputs: Iterable[Path] = ()) -> list[Path]:
    """Writes programs, table, report and record into a folder: all or none.

    `inputs` are files that must not be overwritten, those that the correction was made from. Raises OUT errors.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> correction = trueloop.compensate(replace(job.inputs, options=trueloop.Options(weight=0.5)))
    >>> len(trueloop.write_correction(correction, "half", job.files))
    5
    """
    return write_all(Path(folder), outputs_of(correction).items(), inputs)


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


def outputs_of(correction: Correction) -> Mapping[str, bytes | None]:
    """File name to bytes, None for one that there shall not be. The record comes last: then its set is complete."""
    return {
        correction.corrected_name: None if correction.runs_as_given else correction.corrected_program,
        correction.offsets_name: correction.offsets_program,
        "table.csv": table_to_csv(correction.table),
        "report.html": page(correction).encode(),
        "record.json": correction.record.to_json().encode(),
    }
