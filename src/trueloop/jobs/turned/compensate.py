"""From a turned part's job to its corrected programs, tables, reports and records: all set-ups and edges, or none."""

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from trueloop.domain.option import Language, LengthUnit, MemoryUse, PageOptions
from trueloop.errors import Code
from trueloop.formats.input_file import FilePath
from trueloop.formats.outputs import write_all
from trueloop.jobs.store.opened import Beside, Choice, Keeping, kept_all_the_same, store_of
from trueloop.jobs.turned.job import ReadCuts, ReadJob, read_cuts, read_job
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.turned.outputs import METRIC, as_first_made, new_tables, outputs_of, outputs_of_part
from trueloop.jobs.turned.shares import require_edges_named, stored_inputs
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.part import PartCorrection, correct_part
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.match.own_contour import OwnContour

if TYPE_CHECKING:
    from trueloop.jobs.store.keep_facts import KeptFacts
    from trueloop.storage.store import Store


@dataclass(frozen=True)
class CorrectedEdge:
    """One edge of a part: what calls it (`T5 (left corner)`), the features that it cuts, and its correction.

    `setup` is the name of its set-up, "" where the job has none. `correction` is None where nothing was measured of
    what the edge cuts; its positions are those of the program that the edge cuts by, which the corrections of all of
    its edges share: `correction.name_to_run` names the file that carries them.

    >>> part = trueloop.compensate_part(trueloop.example("grooved/grooved.toml"), "out")
    >>> left = part.edge("T5")
    >>> left.tool, left.features, left.correction.decision.by_offset, left.correction.name_to_run
    ('T5 (left corner)', ('left-wall', 'floor-left'), True, 'corrected.nc')
    """

    tool: str
    features: tuple[str, ...]
    correction: Correction | None
    setup: str = ""


@dataclass(frozen=True)
class CorrectedPart:
    """The corrections of a part by edge, in the job's order, and the files written.

    >>> part = trueloop.compensate_part(trueloop.example("modbas2/job.toml"), "out")
    >>> [(edge.tool, edge.features[-1]) for edge in part.edges], part.files[-1].name
    ([('T1', 'dome')], 'record.json')
    """

    edges: tuple[CorrectedEdge, ...]
    files: tuple[Path, ...]

    def __repr__(self) -> str:
        """Returns a line an edge."""
        return "\n".join(
            f"{edge.setup} {edge.tool}: {edge.correction or 'nothing measured'}".strip() for edge in self.edges
        )

    def _repr_html_(self) -> str:
        """Returns, for a notebook, each edge's figure before and after with its features and what to expect of them."""
        from trueloop.report.markup import esc, table
        from trueloop.report.still import svg
        from trueloop.report.turned.figures.whiskers import before_and_after
        from trueloop.report.turned.summary import feature_summaries

        parts: list[str] = []
        for edge in self.edges:
            name = esc(f"{edge.setup} {edge.tool}".strip())
            if edge.correction is None:
                parts.append(f"<p>{name}: nothing was measured of what it cuts</p>")
                continue
            rows = [
                (esc(one.feature), esc(one.correction), esc(one.expected)) for one in feature_summaries(edge.correction)
            ]
            head = (name, "correction", "expected with U (95 %)")
            parts += [svg(before_and_after(edge.correction), name), table(head, rows, words=(0, 1))]
        return "\n".join(parts)

    def edge(self, tool: str, setup: str = "") -> CorrectedEdge:
        """Returns an edge by what calls it, T5, and its set-up. Raises NC-NO-TOOL: there is none, or several."""
        asked = [one for one in self.edges if tool in (one.tool, one.tool.partition(" (")[0])]
        found = [one for one in asked if not setup or one.setup == setup]
        if len(found) != 1:
            count = len(found)
            there = ", ".join(f"{one.tool} in {one.setup!r}" if one.setup else one.tool for one in self.edges)
            where = f" in set-up {setup!r}" if setup else ""
            raise Code.NC_NO_TOOL.refusal(
                f"{count} edges of the part are {tool!r}{where}; its edges are {there}",
                hint="name the tool as it is called, and its set-up where several cut with it",
                values={"tool": tool},
            )
        return found[0]


def compensate_part(
    job: FilePath,
    output: FilePath | None = None,
    *,
    language: Language | None = None,
    unit: LengthUnit | None = None,
    pdf: bool = False,
    store: Choice = None,
) -> CorrectedPart:
    """The corrections of a job by edge, of any number of tools and set-ups, and their files: all of them or none.

    As `trueloop compensate`: `output` is the folder, else that which the job names; `language` and `unit` are of the
    pages, where they are not to be the job's; `store` is that of the job or the one beside it, which is made; False:
    none. Raises what reading and correcting refuse, and OUT errors.

    >>> part = trueloop.compensate_part(trueloop.example("two-sides/two-sides.toml"), "out")
    >>> [(edge.setup, edge.tool) for edge in part.edges]
    [('first', 'T1'), ('second', 'T2'), ('second', 'T4')]
    >>> part.edge("T4").correction.wear.words  # of the boring bar; Z as the program of its set-up has it
    'tool 4: wear X −0.0100 (diameter), Z −0.0055 mm (X ± 0.0113, Z ± 0.0081)'
    """
    done = compensate_and_keep(job, output, Keeping(store), language=language, unit=unit, pdf=pdf)
    edges = tuple(
        CorrectedEdge(edge.tool, edge.features, edge.correction, setup.frame.name)
        for setup in done.corrected.setups
        for edge in setup.edges
    )
    return CorrectedPart(edges, tuple(done.files))


def compensate_job(
    job: FilePath,
    output: FilePath | None = None,
    *,
    language: Language | None = None,
    unit: LengthUnit | None = None,
    pdf: bool = False,
    store: Choice = None,
) -> tuple[Correction, list[Path]]:
    """The correction of a job of one tool and the files written: into `output`, or the folder that the job names; all
    or none.

    `language` and `unit` of the page, where they are not to be the job's; `pdf`: the page as PDF besides; `store` as
    for `compensate_part`.

    Raises what reading and correcting refuse, and OUT errors.

    >>> correction, files = trueloop.compensate_job(trueloop.example("modbas2/job.toml"), "out")
    >>> [file.name for file in files]
    ['corrected.nc', 'offsets.nc', 'table.csv', 'report.html', 'report.json', 'record.json']
    """
    assert JobFiles.of(Path(job)).tool  # refused where there are several
    done = compensate_and_keep(job, output, Keeping(store), language=language, unit=unit, pdf=pdf)
    return done.correction, done.files


@dataclass(frozen=True)
class Done:
    """The corrections of a job, the files written, and what was kept in a store; None: nothing was kept."""

    corrected: PartCorrection
    files: list[Path]
    kept: "KeptFacts | None" = None

    @property
    def correction(self) -> Correction:
        """Returns the correction of a job of one tool."""
        assert self.corrected.alone is not None
        return self.corrected.alone


def compensate_and_keep(
    job: FilePath,
    output: FilePath | None,
    keeping: Keeping,
    *,
    language: Language | None = None,
    unit: LengthUnit | None = None,
    pdf: bool = False,
    memory: MemoryUse | None = None,
) -> Done:
    """Corrects a job, keeps that in a store and writes its files.

    The store is the one that `keeping` names, else the job's, else the one beside the job, which is made where there is
    none. In that the part needs a serial number: without one, nothing is kept.

    All is computed before anything is kept, and kept before it is written: no program can be run of which the store
    knows nothing. Where writing is refused then, the refusal states that the correction is kept. `memory`: how earlier
    parts of the edges take part, where that is not to be the job's choice. Raises what reading and correcting refuse,
    STO, EDG, MEM and OUT errors.
    """
    files = JobFiles.of(Path(job)).with_serial(keeping.serial).with_output(output)
    cuts = read_cuts(files)
    beside: Beside = "made" if any(inspection.part.serial for inspection in cuts.measured.inspections) else "unused"
    store = store_of(files.path.parent, keeping.db, files.job.store.db, beside)
    folder = Path(output or _from_here(files.output_folder))
    return corrected_into(
        *(folder, files, cuts, store, keeping), page=files.page_options(language, unit), pdf=pdf, memory=memory
    )


def corrected_into(
    folder: Path,
    files: JobFiles,
    cuts: ReadCuts,
    store: "Store | None",
    keeping: Keeping | None,
    *,
    page: PageOptions,
    pdf: bool = False,
    memory: MemoryUse | None = None,
) -> Done:
    """Corrects a job as read, with what an open store knows, and writes its files into a folder.

    That is kept in the store as `keeping` says; None: nothing is kept. Raises what correcting refuses, STO, EDG, MEM
    and OUT errors.
    """
    corrected = as_first_made(_corrected(cuts, store, memory), folder)
    contents = [*new_tables(files, corrected), *outputs_of_part(corrected, page, pdf).items()]
    kept = None if store is None or keeping is None else _kept(store, files, corrected, keeping)
    with kept_all_the_same(kept):
        return Done(corrected, write_all(folder, contents, files.sources.files), kept)


def corrected_part(files: JobFiles) -> PartCorrection:
    """Computes a job's corrections; nothing is written or kept. Raises what reading and correcting refuse."""
    return _corrected(read_cuts(files), None, None)


def _corrected(cuts: ReadCuts, store: "Store | None", memory: MemoryUse | None) -> PartCorrection:
    """With what a store knows of each edge."""
    profile, measured = cuts.read.profile, cuts.measured

    def known(inputs: Inputs, own: OwnContour | None) -> Inputs:
        own_inputs = inputs if store is None else stored_inputs(inputs, profile, own, measured.characteristics)
        return with_memory(store, own_inputs, memory)

    asked, vectors = measured.characteristics, measured.vectors
    return correct_part(profile, cuts.setups, asked, vectors, cuts.read.found.uncut, cuts.notes, known)


def _kept(store: "Store", files: JobFiles, corrected: PartCorrection, keeping: Keeping) -> "KeptFacts":
    """The share that each edge has of the part, as a part of its own: all of them or none."""
    from trueloop.jobs.store.keep_correction import keep_corrections  # slow to import, and some jobs have no store

    require_edges_named(files, corrected)
    edges = [(edge.inputs, edge.correction) for edge in corrected.edges]
    return keep_corrections(store, [(i, c) for i, c in edges if i is not None and c is not None], keeping)


@dataclass(frozen=True)
class Corrected:
    """A job of one tool as read, its store, the inputs with what that knows, the correction; nothing is written."""

    read: ReadJob
    store: "Store | None"
    inputs: Inputs
    correction: Correction


def correct_job(job: FilePath, keeping: Keeping, memory: MemoryUse | None = None) -> Corrected:
    """Computes the correction of a job; nothing is kept or written. Raises what reading and correcting refuse."""
    read = read_job(job, serial=keeping.serial)
    beside: Beside = "used" if any(inspection.part.serial for inspection in read.inputs.inspections) else "unused"
    return corrected_of(read, store_of(Path(job).parent, keeping.db, read.store_db, beside), memory)


def corrected_of(read: ReadJob, store: "Store | None", memory: MemoryUse | None = None) -> Corrected:
    """Computes the correction of a job that was read, with what a store knows. Raises what correcting refuses."""
    inputs = with_memory(store, read.inputs, memory)
    return Corrected(read, store, inputs, compensate(inputs))


def with_memory(store: "Store | None", inputs: Inputs, memory: MemoryUse | None) -> Inputs:
    """Returns the inputs with the store's knowledge of part and edge; `memory` replaces the job's choice."""
    if memory is not None:
        inputs = replace(inputs, memory=replace(inputs.memory, memory=memory))
    if store is None:
        return inputs
    from trueloop.jobs.store.keep_correction import part_of
    from trueloop.jobs.store.tool_history import with_history
    from trueloop.jobs.tools import with_edge
    from trueloop.jobs.turned.stored_cut import with_stored_cut  # slow to import, and some jobs have no store

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


def _from_here(folder: Path) -> Path:
    """The folder as seen from where the program runs, without a detour by the job's folder."""
    resolved = folder.resolve()
    return resolved.relative_to(Path.cwd()) if resolved.is_relative_to(Path.cwd()) else resolved
