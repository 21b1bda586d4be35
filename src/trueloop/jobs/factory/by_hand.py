"""A part that a person measures and corrects without an order: shown, and corrected by what the store knows of it."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Final

from trueloop.domain.option import PageOptions
from trueloop.errors import Code, TrueloopError
from trueloop.factory.views.by_hand import (
    About,
    CorrectedByHand,
    FeatureExpected,
    FileMade,
    PartByHand,
    Picture,
    SizeToMeasure,
    Unstated,
    Way,
    WayToCut,
)
from trueloop.factory.views.uploads import Remarked
from trueloop.formats.input_file import read_source
from trueloop.jobs.factory.hand_job import JOB, MAPPING, SHEET, AskedPart, AskedReadings, HandJob, written_job
from trueloop.jobs.factory.job_folder import unnamed_folder, without_folder
from trueloop.jobs.factory.made_before import name_before, require_all_shown, ways_of
from trueloop.jobs.factory.uploads import Handed, add_upload, safe_name, upload_of
from trueloop.jobs.store.keeping import Keeping
from trueloop.jobs.turned.compensate import Done, corrected_into
from trueloop.jobs.turned.gauge_sheet import gauge_sheet_of
from trueloop.jobs.turned.job import read_cuts
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.correction import Correction
from trueloop.memory.edge.options import Use
from trueloop.nc.program.along import feed_moves
from trueloop.nc.program.called import called
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import read_program
from trueloop.report import still
from trueloop.report.markup import esc
from trueloop.report.shape import known
from trueloop.report.texts.texts import Texts
from trueloop.report.turned.features import feature_summaries
from trueloop.report.turned.figures import whiskers
from trueloop.report.turned.page import WIDTHS
from trueloop.report.turned.part import all_notes
from trueloop.report.turned.summary import headline
from trueloop.report.turned.touch_sheet import places_figure
from trueloop.storage.store import Store
from trueloop.units import UM_PER_MM

QUESTIONS: Final[Mapping[Code, About]] = {
    Code.NC_DIALECT: "dialect",
    Code.NC_UNIT: "unit",
    Code.NC_PARAMETER: "parameters",
    Code.NC_AMBIGUOUS: "lines",
    Code.GEO_DXF_CHOICE: "outline",
    Code.NC_WORD: "accept_unknown_words",
    Code.NC_CODE: "accept_unknown_words",
}
"""The statement of the request that answers a refusal of a program or drawing."""
OUT: Final = "out"
OWN: Final = (OUT, JOB, SHEET, MAPPING, "sheet.html")
"""Names in the folder of a job that no file of a person has there."""
ALONE: Final[Use] = "off"
"""How earlier parts take part in the correction of one without a serial number: it may be one of them."""


@dataclass(frozen=True)
class Asked:
    """The request of a person: a part, and what was measured of it; None: it is to be shown."""

    part: AskedPart
    measured: AskedReadings | None
    by: str
    say: Texts


@contextmanager
def hand_files(store: Store, asked: Asked) -> Iterator[Handed]:
    """Yields the program in a temporary folder, with drawing and measurement beside it: files of this account alone.

    The folder lies in another one that has nothing else: what lies near a job counts as its own. Raises FAC-UNKNOWN.
    """
    part, measured = asked.part, asked.measured
    program = upload_of(store, part.program, asked.by)
    with unnamed_folder() as outer:
        folder = outer / "part"
        folder.mkdir()
        names = list[str]()
        files = {"program": part.program, "drawing": part.drawing, "measured": measured.file if measured else ""}
        for of, sha in files.items():
            upload = upload_of(store, sha, asked.by) if sha else None
            names.append("" if upload is None else _free_name(of, upload.name, names))
            if upload is not None:
                (folder / names[-1]).write_bytes(upload.content)
        path, drawing, file = folder / names[0], *names[1:]
        name = part.name or name_before(store, part.program) or Path(program.name).stem or "part"
        job = HandJob(part, name, measured, drawing, file, asked.by, asked.say.language, asked.say.unit)
        try:
            yield Handed(str(path), program.name, program.sha256, hand=job)
        except TrueloopError as refused:
            raise without_folder(refused, folder) from refused


def part_by_hand(handed: Handed) -> PartByHand:
    """Returns the part that a program cuts, and what to measure of it; what it is refused for stands in the view."""
    asked = _of(handed)
    try:
        job, made = written_job(handed.file, asked)
        return replace(_shown(job, Texts(asked.language, asked.unit)), notes=made.notes)
    except TrueloopError as refused:
        said = without_folder(refused, handed.file.parent)
        where = f"{said.place}: " if str(said.place) else ""
        problem = Remarked("error", said.code.value, f"{where}{said.message}", said.hint, said.place.line)
        return PartByHand(asked.name, asked.part.dialect or "", problem=problem, question=_question(handed, refused))


def tried_by_hand(handed: Handed) -> int:
    """Reads the job and corrects by it without a store, to see that it can be done within limits; returns its touches.

    Raises what reading raises; what correcting refuses may be different with a store.
    """
    job, _ = written_job(handed.file, _of(handed))
    files = JobFiles.of(job)
    cuts = read_cuts(files)
    with suppress(TrueloopError):
        corrected_into(job.parent / OUT, files, cuts, None, None, page=files.page_options())
    return len(cuts.measured.vectors.error_mm)


def correct_by_hand(
    store: Store, asked: Asked, now: datetime, first: Callable[[Handed], object] | None = None
) -> CorrectedByHand:
    """Corrects by the readings of a person, as `trueloop compensate` does with the store; its files are kept for a day.

    A part with a serial number is kept in the store. One without is corrected by itself; what cut it has to be stated
    all the same where the store has corrections of its program, and of all of these. `first` does it before this
    process does, where it may take any time and memory. Raises what correcting refuses, and STO errors; CMP-CUT-WITH
    for a statement that was made without a correction that the store has.
    """
    with hand_files(store, asked) as handed:
        if first is not None:
            first(handed)
        for left in (JOB, SHEET, "sheet.html"):
            (handed.file.parent / left).unlink(missing_ok=True)
        job, _ = written_job(handed.file, _of(handed))
        files = JobFiles.of(job)
        require_all_shown(store, asked.part, asked.measured, _tools(files))
        cuts = read_cuts(files)
        serials = [one.part.serial for one in cuts.measured.inspections if one.part.serial]
        keeping, memory = (Keeping(), None) if serials else (None, ALONE)
        page = PageOptions(asked.say.language, asked.say.unit)
        done = corrected_into(job.parent / OUT, files, cuts, store, keeping, page=page, memory=memory)
        beside = [path for path in (job.parent / name for name in OWN) if path.is_file()]
        made = [(path.name, path.read_bytes()) for path in (*done.files, *beside)]
    kept = [add_upload(store, name, content, asked.by, now) for name, content in made]
    return _corrected(done, asked.say, tuple(FileMade(one.name, one.sha256) for one in kept))


def _free_name(of: str, name: str, taken: Sequence[str]) -> str:
    """The name of a person's file in the folder of the job: its own, unless the folder has such a file."""
    safe = safe_name(name)
    return f"{of}-{safe}" if of != "program" or safe.lower() in OWN or safe in taken else safe


def _tools(files: JobFiles) -> tuple[str, ...]:
    """Names the tools that cut, as the program calls them."""
    program = files.finish_program()
    path = files.run.of(program)
    calls = [called(program.dialect, path, move.index) for move in feed_moves(path)]
    return tuple(dict.fromkeys(one.words for one in calls if one is not None))


def _of(handed: Handed) -> HandJob:
    assert handed.hand is not None
    return handed.hand


def _question(handed: Handed, refused: TrueloopError) -> Unstated | None:
    about, part = QUESTIONS.get(refused.code), _of(handed).part
    if about is None or (about == "unit" and part.unit) or (about == "dialect" and part.dialect):
        return None
    choices: tuple[str, ...] = {"dialect": tuple(DIALECTS), "unit": ("mm", "inch")}.get(about, ())
    if about == "parameters":
        with suppress(TrueloopError):
            source, dialect = read_source(handed.file, part.dialect)
            choices = read_program(source, dialect, handed.name, part.unit).parameters_used()
    return Unstated(about, choices)


def _shown(job: Path, say: Texts) -> PartByHand:
    sheet, files = gauge_sheet_of(job), JobFiles.of(job)

    def drawn(width: int) -> str:
        figure = places_figure(sheet.profile, sheet.planned, sheet.inch, width)
        return still.svg(figure, esc(sheet.part))

    return PartByHand(
        sheet.part,
        files.finish_program().dialect.name,
        "inch" if sheet.inch else "mm",
        sheet.profile.names,
        _tools(files),
        tuple(
            SizeToMeasure(
                *(number, one.name, one.quantity.value, one.feature, one.other, one.at_z_mm),
                *(one.nominal, one.lower_limit, one.upper_limit),
            )
            for number, one in enumerate(sheet.planned, 1)
        ),
        picture=Picture(drawn(WIDTHS["wide"]), drawn(WIDTHS["narrow"]), ", ".join(sheet.profile.names)),
    )


def _corrected(done: Done, say: Texts, files: tuple[FileMade, ...]) -> CorrectedByHand:
    of = done.correction
    decided = (of.decision.x.words, of.decision.z.words, *of.notes, *all_notes(done.corrected))

    def drawn(width: int) -> str:
        return still.svg(whiskers.before_and_after(of, width, say), esc(headline(of, say)))

    found = [] if done.kept is None else done.kept.findings
    return CorrectedByHand(
        of.record.id,
        done.kept is not None,
        headline(of, say),
        tuple(_way(of, way, say) for way in ways_of(of)),
        tuple(
            FeatureExpected(
                *(one.feature, one.figures.touches, known(one.figures.before_worst_um)),
                *(one.expected_um, one.expanded_u_um, one.correction),
            )
            for one in feature_summaries(of, say)
        ),
        tuple(say.note(words) for words in dict.fromkeys(decided)),
        tuple(Remarked(one.severity.value, one.code.value, one.message, one.hint) for one in found),
        Picture(drawn(WIDTHS["wide"]), drawn(WIDTHS["narrow"]), headline(of, say)),
        files,
    )


def _way(of: Correction, way: Way, say: Texts) -> WayToCut:
    if way != "wear":
        name = of.offsets_name if way == "offsets" else of.corrected_name
        return WayToCut(way, "", (), name, False, "")
    left_um = max(abs(of.left_by_offset_mm)) * UM_PER_MM
    leaves = "" if of.decision.by_offset else f"{say.size(left_um)} {say.um}"
    return WayToCut(way, say.note(of.wear.answer), of.wear.blocks, of.source_name, True, leaves)
