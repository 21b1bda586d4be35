"""A part that a person measures and corrects without an order: shown, and corrected by what the store knows of it.

Corrections of a person's program that the store has, among which what cut the next part is chosen.
"""

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from datetime import datetime
from pathlib import Path
from typing import Any, Final, Protocol

from trueloop.described import filled_from
from trueloop.domain.characteristic import Characteristic
from trueloop.domain.life import Ran
from trueloop.domain.option import MemoryUse, PageOptions
from trueloop.domain.record import Correction as StoredCorrection
from trueloop.domain.record import Record
from trueloop.errors import Code, TrueloopError
from trueloop.factory.views.by_hand import (
    About,
    CorrectedByHand,
    FeatureExpected,
    FileMade,
    MadeBefore,
    PartByHand,
    Picture,
    ProgramToRun,
    SizeToMeasure,
    Unstated,
    Way,
    WayToCut,
)
from trueloop.formats.input_file import read_source
from trueloop.jobs.factory.hand_job import JOB, MAPPING, SHEET, AskedPart, AskedReadings, HandJob, written_job
from trueloop.jobs.factory.job_folder import unnamed_folder, without_folder
from trueloop.jobs.factory.uploads import HandedFile, add_upload, remarked, safe_name, upload_of
from trueloop.jobs.store.opened import Keeping
from trueloop.jobs.turned.characteristics import tolerance_name
from trueloop.jobs.turned.compensate import Done, corrected_into
from trueloop.jobs.turned.cut_with import OF_ALL
from trueloop.jobs.turned.inputs import read_setups
from trueloop.jobs.turned.job import read_cuts
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.jobs.turned.new import gauge_sheet_of
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.in_force import keeps_wear
from trueloop.loops.turned.part import SetupCorrection
from trueloop.nc.program.along import feed_moves
from trueloop.nc.program.called import CalledOffset, called
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import Unit, read_program
from trueloop.report import still
from trueloop.report.markup import esc
from trueloop.report.shape import known
from trueloop.report.texts.texts import Texts
from trueloop.report.turned.figures import whiskers
from trueloop.report.turned.page import WIDTHS
from trueloop.report.turned.part import all_notes, answer_of, answers
from trueloop.report.turned.summary import feature_summaries, headline
from trueloop.report.turned.touch_sheet import places_figure
from trueloop.storage.store import Store, find
from trueloop.units import MM_PER_INCH, UM_PER_MM
from trueloop.wording import wording

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
CUT: Final = "cut"
"""The folder of corrections that cut the part, in that of the job."""
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
    files = [*(("program", one.program) for one in part.programs), ("drawing", part.drawing)]
    files.append(("measured", measured.file if measured else ""))
    with unnamed_folder() as outer:
        folder = outer / "part"
        folder.mkdir()
        names = list[str]()
        for of, sha in files:
            upload = upload_of(store, sha, request.by) if sha else None
            names.append("" if upload is None else _free_name(of, upload.name, names))
            if upload is not None:
                (folder / names[-1]).write_bytes(upload.content)
        path, *then, drawing, file = names
        name = part.name or name_before(store, part.program) or Path(program.name).stem or "part"
        job = HandJob(
            part=part,
            name=name,
            measured=measured,
            drawing=drawing,
            file=file,
            then=tuple(then),
            cut=_written_cut(store, part, measured.cut_with, folder) if measured else "",
            operator=request.by,
            language=request.say.language,
        )
        try:
            yield HandedFile(
                str(folder / path),
                program.name,
                program.sha256,
                hand=job,
                language=request.say.language,
                unit=request.say.unit,
            )
        except TrueloopError as refused:
            raise without_folder(refused, folder) from refused


def part_by_hand(handed: HandedFile) -> PartByHand:
    """Returns the part that a program cuts, and what to measure of it; what it is refused for stands in the view."""
    asked = _of(handed)
    try:
        job, made = written_job(handed.file, asked)
        return replace(_shown(job, asked.part, handed.say), notes=tuple(map(handed.say.note, made.notes)))
    except TrueloopError as refused:
        said = without_folder(refused, handed.file.parent)
        names = (handed.file.name, *asked.then)
        k = next((k for k, name in enumerate(names) if said.place.file == name), 0)
        question = question_of(handed.file.with_name(names[k]), asked.stated(k), said, k)
        return PartByHand(asked.name, asked.part.dialect or "", problem=remarked(said, handed.say), question=question)


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
        serials = [inspection.part.serial for inspection in cuts.measured.inspections if inspection.part.serial]
        keeping, memory = (Keeping(), None) if serials else (None, ALONE)
        page = PageOptions(request.say.language, request.say.unit)
        done = corrected_into(job.parent / OUT, files, cuts, store, keeping, page=page, memory=memory)
        beside = [path for path in (job.parent / name for name in OWN) if path.is_file()]
        made = [(path.name, path.read_bytes()) for path in (*done.files, *beside)]
    kept = [add_upload(store, name, content, request.by, now) for name, content in made]
    return _corrected(done, request.say, tuple(FileMade(upload.name, upload.sha256) for upload in kept))


def _free_name(of: str, name: str, taken: Sequence[str]) -> str:
    """The name of a person's file in the folder of the job: its own, unless the folder has such a file."""
    safe = safe_name(name)
    first = f"{of}-{safe}" if of != "program" or safe.lower() in OWN or safe in taken else safe
    return next(one for one in (first, *(f"{of}{k}-{safe}" for k in range(2, 99))) if one not in taken)


def _written_cut(store: Store, part: AskedPart, cut_with: str, folder: Path) -> str:
    """Writes the corrections that cut a part of several tools or set-ups as the job names them: its list of all, beside
    the records. Returns the list's name; "" where there is nothing to write. Raises CMP-CUT-WITH.
    """
    if part.by_one_tool or cut_with in ("", "given"):
        return ""
    records = next((of for of in _sets_before(store, part) if of[0].id == cut_with), None)
    if records is None:
        raise Code.CMP_CUT_WITH.refusal(
            wording("the store has no correction {correction} of these programs", correction=cut_with),
            hint=wording("show the part again, and choose among its corrections what cut this part"),
            values={"corrections": [cut_with]},
        )
    (folder / CUT).mkdir()
    setups = []
    for k, of in enumerate(part.programs, 1):
        edges = []
        for number in [of.tool or 1, *(tool.number for tool in of.tools)]:
            words = CalledOffset(number, 1).words
            own = next((record for record in records if _is_of(record, of.program) and _edge_of(record) == words), None)
            edges.append({"number": number, "edge": 1, "record_id": own and own.id})
            if own is not None:
                setup = f"side{k}-" if part.then else ""
                (folder / CUT / f"record-{setup}{words.replace(' ', '-')}.json").write_text(own.to_json(), "utf-8")
        setups.append({"name": f"side{k}", "source_sha256": of.program, "edges": edges})
    content = {"setups": setups} if part.then else setups[0]
    (folder / CUT / OF_ALL).write_text(json.dumps(content), "utf-8")
    return f"{CUT}/{OF_ALL}"


def _is_of(record: Record, sha256: str) -> bool:
    return record.program is not None and record.program.sha256 == sha256


def _edge_of(record: Record) -> str:
    return str(record.options.get("edge", "")).partition(" (")[0]


def _sets_before(store: Store, part: AskedPart) -> list[list[Record]]:
    """The corrections of a part of several tools or set-ups that the store has, by what was measured, latest first."""
    found: dict[tuple[object, ...], list[Record]] = {}
    for of in part.programs:
        for correction in _before(store, of.program):
            measured = tuple((each.part.serial, each.sha256) for each in correction.record.inspections)
            if _edge_of(correction.record):
                found.setdefault(measured, []).append(correction.record)
    return sorted(found.values(), key=lambda records: records[0].made_at, reverse=True)


def _tools(files: JobFiles) -> tuple[str, ...]:
    """Names the tools that cut, as the programs call them."""
    found = list[str]()
    for of in files.of_setups:
        program = of.finish_program()
        path = of.run.of(program)
        calls = [called(program.dialect, path, move.index) for move in feed_moves(path)]
        found += [f"{of.setup}: {call.words}" if of.setup else call.words for call in calls if call is not None]
    return tuple(dict.fromkeys(found))


def _of(handed: HandedFile) -> HandJob:
    assert handed.hand is not None
    return handed.hand


class Stated(Protocol):
    """The statements on a program of a request."""

    @property
    def dialect(self) -> str | None:
        """Returns the stated dialect."""

    @property
    def unit(self) -> Unit | None:
        """Returns the stated unit."""


def question_of(program: Path, stated: Stated, refused: TrueloopError, k: int = 0) -> Unstated | None:
    """Returns the statement that is needed where a program, that of set-up k, is refused without it; None: no other."""
    about = QUESTIONS.get(refused.code)
    if about is None or (about == "unit" and stated.unit) or (about == "dialect" and stated.dialect):
        return None
    choices: tuple[str, ...] = {"dialect": tuple(DIALECTS), "unit": ("mm", "inch")}.get(about, ())
    if about == "parameters":
        with suppress(TrueloopError):
            source, dialect = read_source(program, stated.dialect)
            choices = read_program(source, dialect, program.name, stated.unit).parameters_used()
    return Unstated(about, choices, k)


def _shown(job: Path, asked: AskedPart, say: Texts) -> PartByHand:
    sheet, files = gauge_sheet_of(job), JobFiles.of(job)
    if not asked.by_one_tool:
        read_setups(files).found.require_plain()

    def drawn(width: int) -> str:
        figure = places_figure(sheet.profile, sheet.planned, sheet.inch, width)
        return still.svg(figure, esc(sheet.part))

    return PartByHand(
        name=sheet.part,
        dialect=files.of_setups[0].finish_program().dialect.name,
        unit="inch" if sheet.inch else "mm",
        features=sheet.profile.names,
        tools=_tools(files),
        sizes=tuple(
            filled_from(
                SizeToMeasure,
                characteristic,
                number=number,
                quantity=characteristic.quantity.value,
                tolerance_name=tolerance_name(characteristic),
            )
            for number, characteristic in enumerate(sheet.planned, 1)
        ),
        picture=Picture(drawn(WIDTHS["wide"]), drawn(WIDTHS["narrow"]), ", ".join(sheet.profile.names)),
    )


def _corrected(done: Done, say: Texts, files: tuple[FileMade, ...]) -> CorrectedByHand:
    of, alone = done.corrected, done.corrected.alone
    made = [(one.frame.name, edge.tool, edge.correction) for one in of.setups for edge in one.edges if edge.correction]
    cut_by = {id(one): "" if alone else ": ".join(filter(None, (setup, tool))) for setup, tool, one in made}
    decided = [(cut_by[id(one)], words) for _, _, one in made for words in (*one.decision.words, *one.notes)]
    notes = [f"{by}: {say.note(words)}" if by else say.note(words) for by, words in decided]
    found = [] if done.kept is None else done.kept.findings
    return CorrectedByHand(
        id=of.record_id if alone is None else alone.record.id,
        kept=done.kept is not None,
        headline="; ".join(map(say.note, answers(of))) if alone is None else headline(alone, say),
        ways=() if alone is None else tuple(_way(alone, way, say) for way in ways_of(alone)),
        to_run=() if alone else tuple(_to_run(one, say) for one in of.setups),
        features=tuple(
            filled_from(
                FeatureExpected,
                summary,
                touches=summary.figures.touches,
                before_um=known(summary.figures.before_worst_um),
                cut_by=cut_by[id(correction)],
            )
            for _, _, correction in made
            for summary in feature_summaries(correction, say)
        ),
        notes=tuple(dict.fromkeys([*notes, *map(say.note, all_notes(of))])),
        remarks=tuple(remarked(finding, say) for finding in found),
        pictures=tuple(_before_and_after(one, cut_by[id(one)], say) for _, _, one in made),
        files=files,
    )


def _before_and_after(of: Correction, cut_by: str, say: Texts) -> Picture:
    words = f"{cut_by}: {headline(of, say)}" if cut_by else headline(of, say)

    def drawn(width: int) -> str:
        return still.svg(whiskers.before_and_after(of, width, say), esc(words))

    return Picture(drawn(WIDTHS["wide"]), drawn(WIDTHS["narrow"]), words)


def _to_run(of: SetupCorrection, say: Texts) -> ProgramToRun:
    offsets = [edge for edge in of.edges if edge.correction is not None and edge.correction.decision.by_offset]
    return ProgramToRun(
        setup=of.frame.name,
        entered=tuple(say.note(answer_of(offset)) for offset in offsets),
        blocks=tuple(block for offset in offsets if offset.correction for block in offset.correction.wear.blocks),
        program=of.source_name if of.program is None else of.name,
        given=of.program is None,
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
    """Returns the stored corrections of a part's program, latest first, of its tool or of `tools`, if called."""
    if not part.by_one_tool:
        return tuple(
            MadeBefore(records[0].id, records[0].made_at, _serial(records[0]), (), ", ".join(map(_edge_of, records)))
            for records in _sets_before(store, part)
        )
    found = [
        MadeBefore(one.record.id, one.record.made_at, _serial(one.record), ways_of(one.payload), _tool_of(one.payload))
        for one in reversed(_before(store, part.program))
        if isinstance(one.payload, Correction)
    ]
    return tuple(before for before in found if _may_be_of(before.tool, part.tool, tools))


def _serial(record: Record) -> str:
    return next((of.part.serial for of in record.inspections if of.part.serial), "")


def _before(store: Store, sha256: str) -> list[StoredCorrection[Any]]:
    return [stored.value for stored in find(store, StoredCorrection, program_sha256=sha256)]


def name_before(store: Store, sha256: str) -> str:
    """Returns the name of the part type of the first correction of a program, by its hash; "" before that."""
    types = (correction.record.part_type for correction in _before(store, sha256))
    return next((part_type.name for part_type in types if part_type is not None), "")


def tolerances_before(store: Store, sha256: str, unit: Unit) -> dict[str, str]:
    """Returns the tolerances by which a program's last correction was judged, in its unit, as a drawing has them."""
    before = _before(store, sha256)
    asked = [characteristic.characteristic for characteristic in before[-1].record.characteristics] if before else []
    return {
        characteristic.name: characteristic.tolerance
        or _deviations(characteristic, MM_PER_INCH if unit == "inch" else 1.0)
        for characteristic in asked
    }


def _deviations(of: Characteristic, mm_per_unit: float) -> str:
    limits = (of.upper_limit, of.lower_limit)
    return "/".join(f"{(limit - of.nominal) / mm_per_unit:+.6g}" for limit in limits if limit is not None)


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
    """Refuses a statement of what cut the part by who was not shown all corrections that may have: CMP-CUT-WITH."""
    if measured is None or not measured.cut_with:
        return
    unseen = [before for before in made_before(store, part, tools) if before.id not in measured.made_before]
    if unseen:
        raise Code.CMP_CUT_WITH.refusal(
            wording(
                "correction {correction} of this program was made since the part was shown, on {made_at}",
                correction=unseen[0].id,
                made_at=unseen[0].made_at[:16],
            ),
            hint=wording("show the part again, and choose among all of its corrections what cut this part"),
            values={"corrections": [before.id for before in unseen]},
        )


def ways_of(of: Correction) -> tuple[Way, ...]:
    """Returns the ways of carrying a correction out, the recommended one first; a program may set an offset, too."""
    beside = of.by_tool is not None and of.by_tool.comes_first and of.options.by == "auto"
    enters = of.wear.tool and keeps_wear(of.record)
    wear: list[Way] = ["wear"] if enters and (of.decision.by_offset or beside) else []
    recommended: Mapping[Ran, Way] = {Ran.WEAR: "wear", Ran.OFFSETS: "offsets", Ran.CORRECTED: "corrected"}
    way = recommended[of.recommended]
    return tuple(dict.fromkeys([*wear, way] if of.decision.by_offset else [way, *wear]))
