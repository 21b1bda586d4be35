"""From which program, and for which part, a corrected program was made: `corrected_from`."""

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from sqlalchemy import select

from trueloop.domain.correction import Correction
from trueloop.domain.program import ProgramText
from trueloop.domain.record import MARK
from trueloop.factory.load import Known
from trueloop.factory.views.orders import CorrectedFrom
from trueloop.storage.factory_tables import STEP
from trueloop.storage.kinds import joined, searchable
from trueloop.storage.tables import TABLES

_RECORD: Final = re.compile(rb"\s+".join(f"{MARK}: record ([0-9a-f]{{16}})".encode().split()), re.IGNORECASE)
"""The mark of a correction in a program, with the id of its record."""


def corrected_from(known: Known, shas: Sequence[str], unnamed: Sequence[str]) -> Mapping[str, CorrectedFrom]:
    """By hash the programs that a correction wrote. Of `unnamed` ones that no order made, their own mark is read."""
    made = _by_orders(known, shas)
    made |= dict(_by_marks(known, [one for one in unnamed if one not in made]))
    records = _records(known, set(made.values()))
    found = {sha: records[record] for sha, record in made.items() if record in records}
    return {sha: _view(one) for sha, one in found.items() if one.source_sha256 not in ("", sha)}


def _by_orders(known: Known, shas: Sequence[str]) -> dict[str, str]:
    """The correction behind a finish cut's program: the run of the step CORRECT of the part that got it."""
    correct = STEP.alias("correct")
    query = (
        select(STEP.c.program_sha256, correct.c.run)
        .join(correct, (correct.c.order == STEP.c.order) & (correct.c.part == STEP.c.part))
        .where(STEP.c.program_sha256.in_(shas), STEP.c.kind == "finish")
        .where(correct.c.kind == "correct", correct.c.run != "")
    )
    return {row.program_sha256: row.run for row in known.rows(query)}


def _by_marks(known: Known, shas: Sequence[str]) -> Iterator[tuple[str, str]]:
    for sha in shas:
        text: ProgramText | None = known.first(ProgramText, sha)
        mark = None if text is None else _RECORD.search(text.content)
        if mark is not None:
            yield sha, mark[1].decode().lower()


def _records(known: Known, ids: set[str]) -> Mapping[str, Correction[None]]:
    """Without their payloads, which may be large."""
    table = TABLES["correction"]
    wanted = [searchable(joined((one,))) for one in sorted(ids)]
    query = select(table.c.document).where(table.c.identity.in_(wanted)).order_by(table.c.id)
    found: list[Correction[Any]] = [known.codec.from_json(one, Correction) for one in known.connection.scalars(query)]
    return {one.record.id: one for one in found}


def _view(made: Correction[None]) -> CorrectedFrom:
    record = made.record
    part = record.inspections[0].part if record.inspections else None
    of = record.part_type if part is None else part.part_type
    name = "" if record.program is None else record.program.name
    named = ("", "") if of is None else (of.name, of.revision)
    return CorrectedFrom(record.id, name, made.source_sha256, *named, "" if part is None else part.serial)
