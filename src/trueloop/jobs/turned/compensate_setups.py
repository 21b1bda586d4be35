"""From the job of a part with several set-ups to a corrected program each, with reports and records: all or none."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from trueloop.domain.page_options import Language, LengthUnit, PageOptions
from trueloop.formats.input_file import FilePath
from trueloop.formats.outputs import write_all
from trueloop.jobs.store.keeping import Keeping, kept_all_the_same
from trueloop.jobs.store.where import store_of
from trueloop.jobs.turned.compensate import with_memory
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.turned.new_tables import new_tables
from trueloop.jobs.turned.of_edge import require_kept_apart, stored_inputs
from trueloop.jobs.turned.setups import read_cuts_of_setups
from trueloop.jobs.turned.several import keep_edges, label_of, outputs_of_edge, texts_of
from trueloop.jobs.turned.shared_edges import require_edges_named
from trueloop.loops.turned.correction import Inputs
from trueloop.loops.turned.setup_corrections import CorrectedSetups, correct_setups
from trueloop.memory.edge.options import Use
from trueloop.nc.match.own_contour import OwnContour
from trueloop.report.turned.setups import setups_json, setups_page

if TYPE_CHECKING:
    from trueloop.jobs.store.keep_facts import KeptFacts
    from trueloop.storage.store import Store


@dataclass(frozen=True)
class DoneSetups:
    """The corrections of a part's set-ups, the files written, and what its store kept; None: it has none."""

    corrected: CorrectedSetups
    files: list[Path]
    kept: "KeptFacts | None" = None


def has_setups(job: FilePath) -> bool:
    """Whether a job lists set-ups. Raises JOB errors."""
    return bool(JobFiles.of(Path(job)).job.setups)


def corrected_setups(files: JobFiles, store: "Store | None" = None, memory: Use | None = None) -> CorrectedSetups:
    """The corrections of a job's set-ups with what a store knows of each edge, nothing written and nothing kept.

    Raises what reading and correcting refuse.
    """
    cuts = read_cuts_of_setups(files)
    profile = cuts.read.profile

    def known(inputs: Inputs, own: OwnContour) -> Inputs:
        return with_memory(store, stored_inputs(inputs, profile, own), memory)

    asked, vectors = cuts.measured.characteristics, cuts.measured.vectors
    adds = None if store is None else known
    return correct_setups(profile, cuts.read.found, cuts.cuts, asked, vectors, cuts.notes, adds)


def compensate_setups(
    job: FilePath,
    output: FilePath | None,
    keeping: Keeping,
    *,
    language: Language | None = None,
    unit: LengthUnit | None = None,
    pdf: bool = False,
    memory: Use | None = None,
) -> DoneSetups:
    """Corrects, keeps and writes: all set-ups, or none.

    Raises what correcting an edge refuses, SET errors, JOB-SETUPS, STO, EDG, MEM and OUT errors.
    """
    files = JobFiles.of(Path(job)).with_serial(keeping.serial)
    store = store_of(files.path.parent, keeping.db, files.job.store.db)
    if store is not None:
        require_kept_apart(files)
    corrected = corrected_setups(files, store, memory)
    options = files.page_options(language, unit)
    folder = files.output_folder if output is None else Path(output)
    made = [(files.with_setup(of), one.joint) for of, one in zip(files.job.setups, corrected.setups, strict=True)]
    contents = [*new_tables(made), *outputs_of_setups(corrected, options, pdf).items()]
    kept = None if store is None else _kept(store, files, corrected, keeping)
    with kept_all_the_same(kept):
        return DoneSetups(corrected, write_all(folder, contents, files.sources.files), kept)


def _kept(store: "Store", files: JobFiles, corrected: CorrectedSetups, keeping: Keeping) -> "KeptFacts":
    """The share that each edge of each set-up has of the part: all of them or none."""
    require_edges_named(files, corrected)
    return keep_edges(store, [edge for one in corrected.setups for edge in one.joint.edges], keeping)


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
