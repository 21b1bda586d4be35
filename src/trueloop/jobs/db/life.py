"""The life of a part, entry by entry: what was measured, corrected and cut, with links and what stands no more."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any

from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, Quarantine
from trueloop.domain.part import Part
from trueloop.domain.record import Correction, Record
from trueloop.jobs.db.found import row_name, row_of
from trueloop.storage.kinds import joined
from trueloop.storage.life import Life, life
from trueloop.storage.store import Kept, Store, find


@dataclass(frozen=True)
class Entry:
    """One thing of a part's life: `row` names it, `at` says when it was so, `said` what it was, in words.

    `at` is None where nobody stated it. `links` name other rows, each with what it is to this one.
    """

    row: str
    at: datetime | None
    kept_at: datetime
    said: str
    links: tuple[str, ...] = ()

    @property
    def as_dict(self) -> dict[str, object]:
        """Returns JSON-ready values."""
        at = None if self.at is None else self.at.isoformat()
        stated = {"row": self.row, "at": at, "kept_at": self.kept_at.isoformat(), "said": self.said}
        return {**stated, "links": list(self.links)}


def life_of_part(store: Store, part: Part) -> tuple[Entry, ...]:
    """Returns all entries of a part by the time at which they happened, else were kept. Raises STO errors."""
    whole = life(store, part)
    entries = [*_inspections(whole), *_corrections(whole), *_cuts(whole), *_quarantines(store, whole)]
    entries += _superseded(store, part)
    return tuple(sorted(entries, key=lambda one: (_utc(one.at or one.kept_at), one.row)))


def _utc(at: datetime) -> datetime:
    return at if at.tzinfo else at.replace(tzinfo=UTC)


def _inspections(whole: Life) -> Iterator[Entry]:
    cuts = {link.value.inspection: link.value.cut for link in whole.links}
    for kept in whole.inspections:
        one = kept.value
        said = [f"{one.count} {one.measured}", *([one.device] if one.device else []), f"file {one.sha256[:12]}"]
        shown = [cut for cut in whole.cuts if cut.value.identity == cuts.get(one.identity)]
        links = [f"after {row_name(Cut, cut.row)} ({cut.value.stage})" for cut in shown]
        used = [c for c in whole.corrections if any(i.identity == one.identity for i in c.value.inspections)]
        links += [f"for {row_name(Correction, c.row)}" for c in used]
        yield _entry(kept, one.measured_at, "inspected: " + ", ".join(said), links)


def _corrections(whole: Life) -> Iterator[Entry]:
    for kept in whole.corrections:
        record: Record = kept.value
        program = [] if record.program is None else [f"of {record.program.name}"]
        said = " ".join(["corrected", *program, f"by record {record.id}"])
        cut = [f"run by {row_name(Cut, one.row)}" for one in whole.cuts if one.value.correction == record.id]
        at = datetime.fromisoformat(record.made_at) if record.made_at else None
        yield Entry(row_name(Correction, kept.row), at, kept.kept_at, said, tuple(cut))


def _cuts(whole: Life) -> Iterator[Entry]:
    for kept in whole.cuts:
        cut: Cut = kept.value
        edge = [] if cut.setting is None else ["edge " + "/".join(cut.setting.edge.identity)]
        program = [f"program {cut.program_sha256[:12]}"] if cut.program_sha256 else []
        order = [] if cut.order is None else [f"part {cut.order} of the edge"]
        doubt = ["order in doubt"] if cut.order_in_doubt else []
        links = [f"by record {cut.correction}"] if cut.correction else []
        said = ", ".join([f"{cut.stage} cut", *edge, *program, *order, *doubt])
        yield _entry(kept, cut.at, said, links)


def _quarantines(store: Store, whole: Life) -> Iterator[Entry]:
    for cut in whole.cuts:
        for kept in find(store, Quarantine, cut=joined(cut.value.identity)):
            word: Quarantine = kept.value
            said = "learned from again" if word.lifted else "in quarantine: nothing is learned from it"
            why = ", ".join([*([f"by {word.by}"] if word.by else []), *([word.why] if word.why else [])])
            text = f"{said} ({why})" if why else said
            yield _entry(kept, word.at, text, [f"of {row_name(Cut, cut.row)} ({cut.value.stage})"])


def _superseded(store: Store, part: Part) -> Iterator[Entry]:
    own: dict[str, Any] = {"part_type": part.part_type.name, "serial": part.serial}
    for kind in (Inspection, Cut):
        rows: list[Kept[Any]] = find(store, kind, superseded=True, **own)
        for kept in rows:
            if kept.superseded_by is not None and kept.value.part.identity == part.identity:
                by = row_of(store, kind, kept.superseded_by)
                assert by is not None, "a foreign key"
                who = ", ".join([*([by.by] if by.by else []), *([by.why] if by.why else [])])
                said = f"superseded by {row_name(kind, by.row)}" + (f": {who}" if who else "")
                yield _entry(kept, by.kept_at, said, [])


def _entry(kept: Kept[Any], at: datetime | None, said: str, links: Sequence[str]) -> Entry:
    return Entry(row_name(type(kept.value), kept.row), at, kept.kept_at, said, tuple(links))
