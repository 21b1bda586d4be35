"""Programs of the store as they are shown, and compared."""

from collections.abc import Mapping, Sequence
from typing import Any

from sqlalchemy import select

from trueloop.domain.program import Program, ProgramText
from trueloop.factory.known import unknown
from trueloop.factory.load import Known, program_text
from trueloop.factory.shown.corrected import corrected_from
from trueloop.factory.shown.paging import LIMIT, before, known_of, page_of, time
from trueloop.factory.views.orders import CorrectedFrom, DiffLine, ProgramDiff, ProgramRow
from trueloop.factory.views.page import Page
from trueloop.report.program_diff import DiffLine as Line
from trueloop.report.program_diff import diff
from trueloop.storage.factory_tables import PROGRAM_RELEASE
from trueloop.storage.kinds import joined, searchable
from trueloop.storage.store import Store
from trueloop.storage.tables import TABLES

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


def program_row(known: Known, sha: str) -> ProgramRow:
    """One program. Raises FAC-UNKNOWN."""
    row = known.connection.execute(_ROWS.where(_TEXT.c.program_sha256 == sha)).first()
    if row is None:
        raise unknown("program", sha[:16], "the store has no text of that hash")
    return _row(known, row, _made(known, [row]))


def text_of(store: Store, sha: str) -> bytes:
    """A program's text. Raises FAC-UNKNOWN."""
    with known_of(store) as known:
        text = program_text(known, sha)
    if text is None:
        raise unknown("program", sha[:16], "the store has no text of that hash")
    return text


def program_diff(store: Store, one: str, other: str) -> ProgramDiff:
    """Two programs, their changed lines with a line around them. Raises FAC-UNKNOWN."""
    with known_of(store) as known:
        rows = program_row(known, one), program_row(known, other)
        texts = [known.first(ProgramText, sha).content for sha in (one, other)]
    lines = [line for hunk in diff(*texts) for line in hunk]
    return ProgramDiff(*rows, sum(map(_changes, lines)), tuple(map(_line, lines)))


def names_of(known: Known, shas: Sequence[str]) -> Mapping[str, str]:
    """Names of programs by their hashes."""
    wanted = [searchable(joined((one,))) for one in shas if one]
    documents = known.connection.scalars(select(_PROGRAM.c.document).where(_PROGRAM.c.identity.in_(wanted)))
    programs = [known.codec.from_json(one, Program) for one in documents]
    return {one.sha256: one.name for one in programs}


def _made(known: Known, rows: Sequence[Any]) -> Mapping[str, CorrectedFrom]:
    unnamed = [one.program_sha256 for one in rows if one.document is None]
    return corrected_from(known, [one.program_sha256 for one in rows], unnamed)


def _row(known: Known, row: Any, made: Mapping[str, CorrectedFrom]) -> ProgramRow:
    program = None if row.document is None else known.codec.from_json(row.document, Program)
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
