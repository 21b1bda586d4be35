"""Programs of the store as they are shown, and compared."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from datetime import datetime
from typing import Any, Final

from sqlalchemy import select

from trueloop.described import filled_from
from trueloop.domain.part import Part
from trueloop.domain.proposal import Effect, Proposal, ProposalDecision
from trueloop.domain.record import MARK, Correction, Product, Program, ProgramText
from trueloop.errors import TrueloopError
from trueloop.factory.book import Book, read_book
from trueloop.factory.known import unknown
from trueloop.factory.load import StoreReader, program_text
from trueloop.factory.shown.records import LIMIT, before, known_of, page_of, time
from trueloop.factory.views.orders import CorrectedFrom, DiffLine, Page, ProgramDiff, ProgramRow
from trueloop.factory.views.series import EffectView, ProposalView
from trueloop.loops.post_process.decide import decide
from trueloop.loops.post_process.series import SeriesOptions
from trueloop.report.program_diff import DiffLine as Line
from trueloop.report.program_diff import diff
from trueloop.report.series.page import proposal_figure
from trueloop.report.still import svg
from trueloop.report.style import in_the_dark
from trueloop.report.texts.texts import Texts
from trueloop.storage.kinds import joined, searchable
from trueloop.storage.schema import PROGRAM_RELEASE, STEP, TABLES
from trueloop.storage.store import Store, life
from trueloop.units import UM_PER_MM
from trueloop.wording import wording

_RECORD: Final = re.compile(rb"\s+".join(f"{MARK}: record ([0-9a-f]{{16}})".encode().split()), re.IGNORECASE)
"""The mark of a correction in a program, with the id of its record."""


def corrected_from(reader: StoreReader, shas: Sequence[str], unnamed: Sequence[str]) -> Mapping[str, CorrectedFrom]:
    """Returns by hash the programs that a correction wrote. Of `unnamed` ones without an order, their mark is read."""
    made = _by_orders(reader, shas)
    made |= dict(_by_marks(reader, [one for one in unnamed if one not in made]))
    records = _records(reader, set(made.values()))
    found = {sha: records[record] for sha, record in made.items() if record in records}
    return {
        sha: _corrected_view(correction)
        for sha, correction in found.items()
        if correction.source_sha256 not in ("", sha)
    }


def _by_orders(reader: StoreReader, shas: Sequence[str]) -> dict[str, str]:
    """The correction behind a finish cut's program: the run of the step CORRECT of the part that got it."""
    correct = STEP.alias("correct")
    query = (
        select(STEP.c.program_sha256, correct.c.run)
        .join(correct, (correct.c.order == STEP.c.order) & (correct.c.part == STEP.c.part))
        .where(STEP.c.program_sha256.in_(shas), STEP.c.kind == "finish")
        .where(correct.c.kind == "correct", correct.c.run != "")
    )
    return {row.program_sha256: row.run for row in reader.rows(query)}


def _by_marks(reader: StoreReader, shas: Sequence[str]) -> Iterator[tuple[str, str]]:
    for sha in shas:
        text: ProgramText | None = reader.first(ProgramText, sha)
        mark = None if text is None else _RECORD.search(text.content)
        if mark is not None:
            yield sha, mark[1].decode().lower()


def _records(reader: StoreReader, ids: set[str]) -> Mapping[str, Correction[None]]:
    """Without their payloads, which may be large."""
    table = TABLES["correction"]
    wanted = [searchable(joined((one,))) for one in sorted(ids)]
    query = select(table.c.document).where(table.c.identity.in_(wanted)).order_by(table.c.id)
    found: list[Correction[Any]] = [
        reader.codec.from_json(scalar, Correction) for scalar in reader.connection.scalars(query)
    ]
    return {correction.record.id: correction for correction in found}


def _corrected_view(made: Correction[None]) -> CorrectedFrom:
    record = made.record
    part = record.inspections[0].part if record.inspections else None
    of = record.part_type if part is None else part.part_type
    name = "" if record.program is None else record.program.name
    named = ("", "") if of is None else (of.name, of.revision)
    return CorrectedFrom(record.id, name, made.source_sha256, *named, "" if part is None else part.serial)


def proposal_views(store: Store, now: datetime, state: str | None = None) -> tuple[ProposalView, ...]:
    """Returns all proposals of a state, the latest first; of open ones, why one may not be accepted now."""
    with known_of(store) as known:
        every = states_of(known)
    chosen = [one for one in every if state is None or one[1] == state]
    books = {
        name: read_book(store, name, SeriesOptions())
        for name in {one[0].part_type.name for one in chosen if one[1] == "open"}
    }
    return tuple(_view(*one, books.get(one[0].part_type.name), now) for one in reversed(chosen))


def proposal_view(store: Store, number: str, now: datetime) -> ProposalView:
    """Returns one proposal by its id, with the corrections behind its last part. Raises FAC-UNKNOWN."""
    found = next((view for view in proposal_views(store, now) if view.id == number), None)
    if found is None:
        raise _unknown(number)
    last = _proposal(store, number)
    records = life(store, Part(last.part_type, last.last_serial)).corrections
    made = tuple(record.value.id for record in records if record.value.product is Product.TURNED)
    return replace(found, last_serial=last.last_serial, corrections=made)


def proposal_picture(store: Store, number: str, say: Texts, *, dark: bool) -> str:
    """Draws what it does to the next part (SVG). Raises FAC-UNKNOWN."""
    title = say("What the proposal does to the next part: errors without it and with it, ± 95 %")
    drawn = svg(proposal_figure(_proposal(store, number).effects, say), title)
    return in_the_dark(drawn) if dark else drawn


def _proposal(store: Store, number: str) -> Proposal:
    with known_of(store) as known:
        found: Proposal | None = known.first(Proposal, number)
    if found is None:
        raise _unknown(number)
    return found


def _unknown(number: str) -> TrueloopError:
    return unknown(wording("proposal"), number, wording("the store has none of that id"))


def states_of(reader: StoreReader) -> Sequence[tuple[Proposal, str, ProposalDecision | None]]:
    """Returns every proposal as open, accepted, rejected or, where a later one came first, superseded; oldest first."""
    decisions = {one.proposal: one for one in reader.values(ProposalDecision)}
    proposals: list[Proposal] = reader.values(Proposal)
    later: set[tuple[str, ...]] = set()
    found: list[tuple[Proposal, str, ProposalDecision | None]] = []
    for proposal in reversed(proposals):
        series = {(proposal.changes.value, *effect.series) for effect in proposal.effects}
        decision = decisions.get(proposal.id)
        found.append((proposal, decision.verdict if decision else "superseded" if series & later else "open", decision))
        later |= series
    return found[::-1]


def _view(
    proposal: Proposal, state: str, decision: ProposalDecision | None, book: Book | None, now: datetime
) -> ProposalView:
    offset = proposal.tool_offset
    u_mm = None if offset is None else offset.expanded_u_mm
    dx_u_mm, dz_u_mm = u_mm or (None, None)
    return filled_from(
        ProposalView,
        proposal,
        etag=state,
        changes=proposal.changes.value,
        part_type=proposal.part_type.name,
        state=state,
        effects=tuple(map(_effect, proposal.effects)),
        tool="" if offset is None else f"T{offset.tool}",
        dx_mm=None if offset is None else offset.x_radius_mm,
        dz_mm=None if offset is None else offset.z_mm,
        u_stated=u_mm is not None,
        dx_u_mm=dx_u_mm,
        dz_u_mm=dz_u_mm,
        refusal=_refusal(proposal, book, now) if state == "open" and book is not None else "",
        decided_by="" if decision is None else decision.who,
        decided_at=None if decision is None else decision.at,
        decided_why="" if decision is None else decision.why,
    )


def _refusal(proposal: Proposal, book: Book, now: datetime) -> str:
    try:
        decide(proposal, "accepted", "", now, book.by_identity, book.decisions, SeriesOptions())
    except TrueloopError as refused:
        return f"{refused.code}: {refused.message}"
    return ""


def _effect(effect: Effect) -> EffectView:
    return EffectView(
        characteristic=effect.characteristic,
        size_change_um=effect.size_change_mm * UM_PER_MM,
        error_before_um=effect.error_before_mm * UM_PER_MM,
        error_after_um=effect.error_after_mm * UM_PER_MM,
        standard_u_um=effect.standard_u_mm * UM_PER_MM,
        in_tolerance_before=effect.probability_in_before,
        in_tolerance_after=effect.probability_in_after,
    )


_TEXT, _PROGRAM = TABLES["program_text"], TABLES["program"]
_ROWS = select(
    *(_TEXT.c.id, _TEXT.c.program_sha256, _TEXT.c.kept_at, _PROGRAM.c.document, PROGRAM_RELEASE.c.at)
).select_from(
    _TEXT.outerjoin(_PROGRAM, _PROGRAM.c.program_sha256 == _TEXT.c.program_sha256).outerjoin(
        PROGRAM_RELEASE, PROGRAM_RELEASE.c.program_sha256 == _TEXT.c.program_sha256
    )
)
_CHANGE = {"same": "same", "old": "before", "new": "after"}


def program_rows(store: Store, *, limit: int = LIMIT, cursor: str | None = None) -> Page[ProgramRow]:
    """Programs whose text the store has, the latest kept first."""
    with known_of(store) as known:
        rows = known.rows(before(_ROWS, _TEXT.c.id, limit, cursor))
        made = _made(known, rows)
        return page_of(rows, limit, lambda row: int(row.id), lambda row: _row(known, row, made))


def program_row(reader: StoreReader, sha: str) -> ProgramRow:
    """Returns one program. Raises FAC-UNKNOWN."""
    row = reader.connection.execute(_ROWS.where(_TEXT.c.program_sha256 == sha)).first()
    if row is None:
        raise unknown(wording("program"), sha[:16], wording("the store has no text of that hash"))
    return _row(reader, row, _made(reader, [row]))


def text_of(store: Store, sha: str) -> bytes:
    """Returns a program's text. Raises FAC-UNKNOWN."""
    with known_of(store) as known:
        text = program_text(known, sha)
    if text is None:
        raise unknown(wording("program"), sha[:16], wording("the store has no text of that hash"))
    return text


def program_diff(store: Store, before: str, other: str) -> ProgramDiff:
    """Compares two programs: their changed lines with a line around them. Raises FAC-UNKNOWN."""
    with known_of(store) as known:
        rows = program_row(known, before), program_row(known, other)
        texts = [known.first(ProgramText, sha).content for sha in (before, other)]
    lines = [line for hunk in diff(*texts) for line in hunk]
    return ProgramDiff(*rows, sum(map(_changes, lines)), tuple(map(_line, lines)))


def names_of(reader: StoreReader, shas: Sequence[str]) -> Mapping[str, str]:
    """Names of programs by their hashes."""
    wanted = [searchable(joined((sha,))) for sha in shas if sha]
    documents = reader.connection.scalars(select(_PROGRAM.c.document).where(_PROGRAM.c.identity.in_(wanted)))
    programs = [reader.codec.from_json(document, Program) for document in documents]
    return {program.sha256: program.name for program in programs}


def _made(reader: StoreReader, rows: Sequence[Any]) -> Mapping[str, CorrectedFrom]:
    unnamed = [row.program_sha256 for row in rows if row.document is None]
    return corrected_from(reader, [row.program_sha256 for row in rows], unnamed)


def _row(reader: StoreReader, row: Any, made: Mapping[str, CorrectedFrom]) -> ProgramRow:
    program = None if row.document is None else reader.codec.from_json(row.document, Program)
    named = ("", "", "") if program is None else (program.name, program.dialect, program.unit or "")
    return ProgramRow(row.program_sha256, *named, row.at is not None, made.get(row.program_sha256), time(row.kept_at))


def _changes(line: Line) -> int:
    """Changed words of a new version of a line; a line that has no counterpart is one change."""
    return (
        0
        if line.kind == "same" or (line.kind == "old" and "<del>" in line.content)
        else max(line.content.count("<ins>"), 1)
    )


def _line(line: Line) -> DiffLine:
    before_line = None if line.kind == "new" else line.number
    return DiffLine(_CHANGE[line.kind], before_line, line.number if line.kind == "new" else None, line.text)
