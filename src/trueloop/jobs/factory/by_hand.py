"""A part that a person measures and corrects without an order: shown, and corrected by what the store knows of it.

Corrections of a person's program that the store has, among which what cut the next part is chosen.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Any, Final

from trueloop.described import filled_from
from trueloop.domain.characteristic import Characteristic
from trueloop.domain.life import Ran
from trueloop.domain.option import MemoryUse, PageOptions
from trueloop.domain.record import Correction as StoredCorrection
from trueloop.errors import Code, TrueloopError
from trueloop.factory.views.by_hand import (
    About,
    CorrectedByHand,
    FeatureExpected,
    FileMade,
    MadeBefore,
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
from trueloop.jobs.factory.uploads import HandedFile, add_upload, safe_name, upload_of
from trueloop.jobs.store.opened import Keeping
from trueloop.jobs.turned.characteristics import tolerance_name
from trueloop.jobs.turned.compensate import Done, corrected_into
from trueloop.jobs.turned.job import read_cuts
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.turned.new import gauge_sheet_of
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.in_force import keeps_wear
from trueloop.nc.program.along import feed_moves
from trueloop.nc.program.called import CalledOffset, called
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import Unit, read_program
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
from trueloop.storage.store import Store, find
from trueloop.units import MM_PER_INCH, UM_PER_MM

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
ALONE: Final[MemoryUse] = "off"
"""How earlier parts take part in the correction of one without a serial number: it may be one of them."""


@dataclass(frozen=True)
class HandRequest:
    """The request of a person: a part, and what was measured of it; None: it is to be shown."""

    part: AskedPart
    measured: AskedReadings | None
    by: str
    say: Texts


@contextmanager
def hand_files(store: Store, request: HandRequest) -> Iterator[HandedFile]:
    """Yields the program in a temporary folder, with drawing and measurement beside it: files of this account alone.

    The folder lies in another one that has nothing else: what lies near a job counts as its own. Raises FAC-UNKNOWN.
    """
    part, measured = request.part, request.measured
    program = upload_of(store, part.program, request.by)
    with unnamed_folder() as outer:
        folder = outer / "part"
        folder.mkdir()
        names = list[str]()
        files = {"program": part.program, "drawing": part.drawing, "measured": measured.file if measured else ""}
        for of, sha in files.items():
            upload = upload_of(store, sha, request.by) if sha else None
            names.append("" if upload is None else _free_name(of, upload.name, names))
            if upload is not None:
                (folder / names[-1]).write_bytes(upload.content)
        path, drawing, file = folder / names[0], *names[1:]
        name = part.name or name_before(store, part.program) or Path(program.name).stem or "part"
        job = HandJob(
            part=part,
            name=name,
            measured=measured,
            drawing=drawing,
            file=file,
            operator=request.by,
            language=request.say.language,
            unit=request.say.unit,
        )
        try:
            yield HandedFile(str(path), program.name, program.sha256, hand=job)
        except TrueloopError as refused:
            raise without_folder(refused, folder) from refused


def part_by_hand(handed: HandedFile) -> PartByHand:
    """Returns the part that a program cuts, and what to measure of it; what it is refused for stands in the view."""
    asked = _of(handed)
    try:
        job, made = written_job(handed.file, asked)
        say = Texts(asked.language, asked.unit)
        return replace(_shown(job, say), notes=tuple(map(say.note, made.notes)))
    except TrueloopError as refused:
        said = without_folder(refused, handed.file.parent)
        where = f"{said.place}: " if str(said.place) else ""
        problem = Remarked("error", said.code.value, f"{where}{said.message}", said.hint, said.place.line)
        return PartByHand(asked.name, asked.part.dialect or "", problem=problem, question=_question(handed, refused))


def tried_by_hand(handed: HandedFile) -> int:
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
    store: Store, request: HandRequest, now: datetime, first: Callable[[HandedFile], object] | None = None
) -> CorrectedByHand:
    """Corrects by the readings of a person, as `trueloop compensate` does with the store; its files are kept for a day.

    A part with a serial number is kept in the store. One without is corrected by itself; what cut it has to be stated
    all the same where the store has corrections of its program, and of all of these. `first` does it before this
    process does, where it may take any time and memory. Raises what correcting refuses, and STO errors; CMP-CUT-WITH
    for a statement that was made without a correction that the store has.
    """
    with hand_files(store, request) as handed:
        if first is not None:
            first(handed)
        for left in (JOB, SHEET, "sheet.html"):
            (handed.file.parent / left).unlink(missing_ok=True)
        job, _ = written_job(handed.file, _of(handed))
        files = replace(JobFiles.of(job), made_by=request.by)
        require_all_shown(store, request.part, request.measured, _tools(files))
        cuts = read_cuts(files)
        serials = [one.part.serial for one in cuts.measured.inspections if one.part.serial]
        keeping, memory = (Keeping(), None) if serials else (None, ALONE)
        page = PageOptions(request.say.language, request.say.unit)
        done = corrected_into(job.parent / OUT, files, cuts, store, keeping, page=page, memory=memory)
        beside = [path for path in (job.parent / name for name in OWN) if path.is_file()]
        made = [(path.name, path.read_bytes()) for path in (*done.files, *beside)]
    kept = [add_upload(store, name, content, request.by, now) for name, content in made]
    return _corrected(done, request.say, tuple(FileMade(one.name, one.sha256) for one in kept))


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


def _of(handed: HandedFile) -> HandJob:
    assert handed.hand is not None
    return handed.hand


def _question(handed: HandedFile, refused: TrueloopError) -> Unstated | None:
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
        name=sheet.part,
        dialect=files.finish_program().dialect.name,
        unit="inch" if sheet.inch else "mm",
        features=sheet.profile.names,
        tools=_tools(files),
        sizes=tuple(
            filled_from(
                SizeToMeasure, one, number=number, quantity=one.quantity.value, tolerance_name=tolerance_name(one)
            )
            for number, one in enumerate(sheet.planned, 1)
        ),
        picture=Picture(drawn(WIDTHS["wide"]), drawn(WIDTHS["narrow"]), ", ".join(sheet.profile.names)),
    )


def _corrected(done: Done, say: Texts, files: tuple[FileMade, ...]) -> CorrectedByHand:
    of = done.correction
    decided = (*of.decision.words, *of.notes, *all_notes(done.corrected))

    def drawn(width: int) -> str:
        return still.svg(whiskers.before_and_after(of, width, say), esc(headline(of, say)))

    found = [] if done.kept is None else done.kept.findings
    return CorrectedByHand(
        id=of.record.id,
        kept=done.kept is not None,
        headline=headline(of, say),
        ways=tuple(_way(of, way, say) for way in ways_of(of)),
        features=tuple(
            filled_from(FeatureExpected, one, touches=one.figures.touches, before_um=known(one.figures.before_worst_um))
            for one in feature_summaries(of, say)
        ),
        notes=tuple(say.note(words) for words in dict.fromkeys(decided)),
        remarks=tuple(Remarked(one.severity.value, one.code.value, one.message, one.hint) for one in found),
        picture=Picture(drawn(WIDTHS["wide"]), drawn(WIDTHS["narrow"]), headline(of, say)),
        files=files,
    )


def _way(of: Correction, way: Way, say: Texts) -> WayToCut:
    if way != "wear":
        name = of.offsets_name if way == "offsets" else of.corrected_name
        return WayToCut(by=way, enter="", blocks=(), program=name, given=False, leaves="")
    left_um = max(abs(of.left_by_offset_mm)) * UM_PER_MM
    leaves = "" if of.decision.by_offset else f"{say.size(left_um)} {say.um}"
    return WayToCut(
        by=way, enter=say.note(of.wear.answer), blocks=of.wear.blocks, program=of.source_name, given=True, leaves=leaves
    )


def made_before(store: Store, part: AskedPart, tools: Sequence[str] = ()) -> tuple[MadeBefore, ...]:
    """Returns the corrections of a part's program that the store has, the latest first.

    Those of another tool than the part's, or than `tools`, which the program calls, are left out.
    """
    found = [
        MadeBefore(
            one.record.id,
            one.record.made_at,
            next((of.part.serial for of in one.record.inspections if of.part.serial), ""),
            ways_of(one.payload),
            _tool_of(one.payload),
        )
        for one in reversed(_before(store, part.program))
        if isinstance(one.payload, Correction)
    ]
    return tuple(one for one in found if _may_be_of(one.tool, part.tool, tools))


def _before(store: Store, sha256: str) -> list[StoredCorrection[Any]]:
    return [one.value for one in find(store, StoredCorrection, program_sha256=sha256)]


def name_before(store: Store, sha256: str) -> str:
    """Returns the name of the part type of the first correction of a program, by its hash; "" before that."""
    types = (one.record.part_type for one in _before(store, sha256))
    return next((one.name for one in types if one is not None), "")


def tolerances_before(store: Store, sha256: str, unit: Unit) -> dict[str, str]:
    """Returns the tolerances by which the last correction of a program, by its hash, was judged, in the program's unit.

    By the name of the characteristic, as a drawing writes them.
    """
    before = _before(store, sha256)
    asked = [one.characteristic for one in before[-1].record.characteristics] if before else []
    return {one.name: one.tolerance or _deviations(one, MM_PER_INCH if unit == "inch" else 1.0) for one in asked}


def _deviations(of: Characteristic, mm_per_unit: float) -> str:
    limits = (of.upper_limit, of.lower_limit)
    return "/".join(f"{(one - of.nominal) / mm_per_unit:+.6g}" for one in limits if one is not None)


def _tool_of(of: Correction) -> str:
    """The edge that a correction is of, as programs call it; "" where neither job nor program states it."""
    edge, wear = of.record.options.get("edge"), of.wear
    if isinstance(edge, str):
        return edge
    return CalledOffset(wear.tool, wear.edge).words if wear.tool else ""


def _may_be_of(tool: str, stated: int | None, tools: Sequence[str]) -> bool:
    """Whether a correction of that tool can have cut a part of the tool stated, else of one of those called."""
    words = tool.partition(" (")[0]
    if not words or (stated is None and not tools):
        return True
    return words in tools if stated is None else words.partition(" ")[0] == f"T{stated}"


def require_all_shown(store: Store, part: AskedPart, measured: AskedReadings | None, tools: Sequence[str]) -> None:
    """Refuses a statement of what cut the part by somebody who was not shown all corrections that may have.

    Raises CMP-CUT-WITH.
    """
    if measured is None or not measured.cut_with:
        return
    unseen = [one for one in made_before(store, part, tools) if one.id not in measured.made_before]
    if unseen:
        raise Code.CMP_CUT_WITH.refusal(
            f"correction {unseen[0].id} of this program was made since the part was shown, on {unseen[0].made_at[:16]}",
            hint="show the part again, and choose among all of its corrections what cut this part",
            values={"corrections": [one.id for one in unseen]},
        )


def ways_of(of: Correction) -> tuple[Way, ...]:
    """Returns the ways of carrying a correction out, the recommended one first; a program may set an offset, too."""
    beside = of.by_tool is not None and of.by_tool.comes_first and of.options.by == "auto"
    enters = of.wear.tool and keeps_wear(of.record)
    wear: list[Way] = ["wear"] if enters and (of.decision.by_offset or beside) else []
    recommended: Mapping[Ran, Way] = {Ran.WEAR: "wear", Ran.OFFSETS: "offsets", Ran.CORRECTED: "corrected"}
    way = recommended[of.recommended]
    return tuple(dict.fromkeys([*wear, way] if of.decision.by_offset else [way, *wear]))
