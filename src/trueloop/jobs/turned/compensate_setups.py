"""From the job of a part with several set-ups to a corrected program each, with reports and records: all or none."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from trueloop.domain.page_options import Language, LengthUnit, PageOptions
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import FilePath
from trueloop.formats.outputs import write_all
from trueloop.jobs.store.keeping import Keeping
from trueloop.jobs.store.where import place_of_store
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.turned.setups import read_cuts_of_setups
from trueloop.jobs.turned.several import label_of, outputs_of_edge, texts_of
from trueloop.loops.turned.setup_corrections import CorrectedSetups, correct_setups
from trueloop.report.turned.setups import setups_json, setups_page


@dataclass(frozen=True)
class DoneSetups:
    """The corrections of a part's set-ups, and the files written."""

    corrected: CorrectedSetups
    files: list[Path]


def has_setups(job: FilePath) -> bool:
    """Whether a job lists set-ups. Raises JOB errors."""
    return bool(JobFiles.of(Path(job)).job.setups)


def corrected_setups(files: JobFiles) -> CorrectedSetups:
    """The corrections of a job's set-ups, nothing written. Raises what reading and correcting refuse."""
    cuts = read_cuts_of_setups(files)
    return correct_setups(cuts.read.profile, cuts.read.found, cuts.cuts, cuts.measured.characteristics, cuts.notes)


def compensate_setups(
    job: FilePath,
    output: FilePath | None,
    keeping: Keeping,
    *,
    language: Language | None = None,
    unit: LengthUnit | None = None,
    pdf: bool = False,
) -> DoneSetups:
    """Corrects and writes: the files of all set-ups, or none.

    Raises what correcting an edge refuses, SET errors, JOB-SETUPS where there is a store, and OUT errors.
    """
    files = JobFiles.of(Path(job)).with_serial(keeping.serial)
    _require_no_store(files, keeping.db)
    corrected = corrected_setups(files)
    options = files.page_options(language, unit)
    folder = files.output_folder if output is None else Path(output)
    contents = outputs_of_setups(corrected, options, pdf)
    return DoneSetups(corrected, write_all(folder, contents.items(), files.sources.files))


def _require_no_store(files: JobFiles, db: str | None) -> None:
    place = place_of_store(files.path.parent, db, files.job.store.db)
    if place is not None:
        raise TrueloopError(
            Code.JOB_SETUPS,
            f"the job has {len(files.job.setups)} set-ups, and the store {place!r} keeps one finish program of a part",
            hint="`--db none` corrects without keeping: the records of the edges are among the results",
            place=Place(str(files.path)),
            values={"setups": [one.name for one in files.job.setups]},
        )


def outputs_of_setups(corrected: CorrectedSetups, options: PageOptions, pdf: bool) -> Mapping[str, bytes | None]:
    """File name to bytes; `part.json` comes last: then the set is complete."""
    contents: dict[str, bytes | None] = {one.name: one.joint.program for one in corrected.setups}
    reports: dict[tuple[str, str], str] = {}
    for setup in corrected.setups:
        for edge in setup.joint.edges:
            label = f"{setup.frame.name}-{label_of(edge)}"
            contents |= outputs_of_edge(edge, label, options, pdf)
            reports[setup.frame.name, edge.tool] = f"report-{label}.html"
    texts = texts_of([one.joint for one in corrected.setups], options)
    contents["report.html"] = setups_page(corrected, reports, texts).encode()
    contents["part.json"] = setups_json(corrected).encode()
    return contents
