"""Rows of the store as people look for them: by type of part, serial number, edge and time.

The life of a part, entry by entry: what was measured, corrected and cut, with links and what stands no more.

Reads what a person names (a row, a part by serial number or label, a correction by the id of its record), and
replaces a stored row.
"""

import json
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

from sqlalchemy import select

from trueloop.domain.inspection import Inspection
from trueloop.domain.labels import NistPart, PartLabel, names_part, read_label
from trueloop.domain.life import Cut, InspectionLink, Quarantine
from trueloop.domain.option import in_utc
from trueloop.domain.part import Part
from trueloop.domain.record import Correction, Record
from trueloop.domain.tool import Edge
from trueloop.errors import Code, Place, TrueloopError, in_file
from trueloop.formats.input_file import read_text
from trueloop.storage.keeping import Query, found
from trueloop.storage.kinds import KINDS, Kind, joined, kind_of
from trueloop.storage.schema import TRANSFER
from trueloop.storage.store import Kept, Life, Store, find, keep, life
from trueloop.storage.store import find as find_values

HINT: Final = "take what `trueloop db show ROW --json` printed, with what was wrong in it changed"


def _refused(file: Path, why: str, line: int | None = None) -> TrueloopError:
    return Code.STO_IMPORT.refusal(f"{file.name!r}: {why}", hint=HINT, place=Place(str(file), line))


ROW: Final = re.compile(r"([a-z-]+):([0-9]{1,15})")


@dataclass(frozen=True)
class NamedRow:
    """A row that was asked for by its name."""

    kind: Kind
    kept: Kept[Any]


def named(store: Store, what: str) -> NamedRow | Part:
    """Finds a row by its name (`inspection:12`) or a record's id; or a part by serial number, TYPE/SERIAL or label.

    Raises STO-UNKNOWN where nothing in the store has that name, STO-SEVERAL where several parts have it.
    """
    if ROW.fullmatch(what):
        return named_row(store, what)
    corrections: list[Kept[Any]] = find(store, Correction, identity=joined((what,)))
    if corrections:
        return NamedRow(NAMES["correction"], corrections[-1])
    parts = {part.identity: part for part in _parts(store, what)}
    if not parts:
        raise _unknown(what)
    if len(parts) > 1:
        listed = [f"{part.part_type.name}/{part.serial}" for part in parts.values()]
        raise Code.STO_SEVERAL.refusal(
            f"{len(parts)} parts are called {what!r}: {', '.join(listed[:10])}",
            hint="name one by its type and serial number: TYPE/SERIAL",
            values={"name": what},
        )
    return next(iter(parts.values()))


def named_row(store: Store, what: str) -> NamedRow:
    """Finds a row by its name, also one that is superseded. Raises STO-UNKNOWN."""
    match = ROW.fullmatch(what)
    kind = NAMES.get(match[1]) if match else None
    if match is None or kind is None:
        raise _unknown(what)
    kept = row_of(store, kind.type, int(match[2]))
    if kept is None:
        raise _unknown(what)
    return NamedRow(kind, kept)


def _parts(store: Store, what: str) -> list[Part]:
    by_serial = [stored.value for stored in find(store, Part, serial=what)]
    kind, slash, serial = what.rpartition("/")
    typed = find(store, Part, part_type=kind, serial=serial) if slash else []
    return [*by_serial, *(stored.value for stored in typed), *_labelled(store, what)]


def _labelled(store: Store, what: str) -> list[Part]:
    """Those that a label means; none where it is not a label."""
    try:
        label = read_label(what)
    except TrueloopError:
        return []
    asked: list[dict[str, Any]] = []
    if isinstance(label, NistPart):
        asked = [{"serial": label.number}, {"part_type": label.number, "serial": label.inspection}]
    elif isinstance(label, PartLabel):
        asked = [{"serial": label.copy}] if label.copy else [{"part_type": label.number}]
    return [stored.value for by in asked for stored in find(store, Part, **by) if names_part(label, stored.value)]


def _unknown(what: str) -> TrueloopError:
    return Code.STO_UNKNOWN.refusal(
        f"nothing in the store is called {what!r}",
        hint="name a part by serial number, TYPE/SERIAL or label, a record by its id, a row as `trueloop db find` does",
    )


def shown_row(store: Store, row: NamedRow) -> dict[str, object]:
    """Returns a row as `replace` takes it back: its value in the form of the codec under "value"."""
    kept = row.kept
    stated = {"row": kept.row, "kept_at": kept.kept_at.isoformat(), "by": kept.by, "why": kept.why}
    links = {"supersedes": kept.supersedes, "superseded_by": kept.superseded_by}
    return {"kind": row.kind.table, **stated, **links, "value": store.codec.plain(kept.value)}


def replace_row(store: Store, row: NamedRow, file: Path, *, by: str, why: str) -> Kept[Any]:
    """Keeps the value in a file in the stead of a row.

    Raises STO-IMPORT for a file that holds no value of its kind or the very one that is there, STO-DIFFERS where the
    row is superseded already.
    """
    value = _value(store, file, row)
    if value == row.kept.value:
        raise _refused(file, f"it holds what row {row.kept.row} holds already")
    return keep(store, [value], row.kept.row, by=by, why=why)[0]


def left_behind(store: Store, row: NamedRow, kept: Kept[Any]) -> list[str]:
    """Links that still name a row that was replaced by one of another identity."""
    old = row.kept.value.identity
    if old == kept.value.identity or not isinstance(kept.value, Inspection | Cut):
        return []
    asked: dict[str, Any] = {"identity" if isinstance(kept.value, Inspection) else "cut": joined(old)}
    return [row_name(InspectionLink, stored.row) for stored in find(store, InspectionLink, **asked)]


def _value(store: Store, file: Path, row: NamedRow) -> Any:
    text = read_text(file, Code.STO_IMPORT, hint=HINT)
    try:
        content = json.loads(text)
    except (ValueError, RecursionError) as wrong:
        raise _refused(file, f"no JSON: {str(wrong)!r}", getattr(wrong, "lineno", None)) from wrong
    if not isinstance(content, dict) or "value" not in content:
        raise _refused(file, "an object with a 'value' is wanted")
    with in_file(file):
        value: Any = store.codec.value(content["value"], row.kind.type)
    return value


NAMES: Final = {kind.table.replace("_", "-"): kind for kind in KINDS}
"""Kinds of values as commands name them."""
TRANSFERS: Final = "transfer"
"""Programs sent to controls and fetched from them: facts of the factory, which nothing replaces."""
SEPARATOR: Final = "\x1f"


@dataclass(frozen=True)
class Sought:
    """Which rows are wanted. None: all. `edge` is TOOL[/INSERT[/CORNER]]; `since` is UTC where it has no zone."""

    part_type: str | None = None
    serial: str | None = None
    edge: str | None = None
    since: datetime | None = None
    superseded: bool = False


@dataclass(frozen=True)
class Row:
    """One row: `name` is its handle in commands, `cells` its text by column name."""

    kept_at: datetime
    name: str
    cells: dict[str, str]

    @property
    def as_dict(self) -> dict[str, object]:
        """Returns the row as a JSON-ready dict."""
        return {"row": self.name, "kept_at": self.kept_at.isoformat(), **self.cells}


def row_name(of: type, row: int) -> str:
    """Returns the name by which commands call a row of a type of values: `inspection:12`."""
    return next(f"{name}:{row}" for name, kind in NAMES.items() if kind.type is of)


def row_of(store: Store, of: type, row: int) -> Kept[Any] | None:
    """Returns a row of a type of values by its number, also one that is superseded; None: there is no such row."""
    with store.reading() as connection:
        return next(found(connection, store.codec, Query(kind_of(of), superseded=True, row=row)), None)


def found_rows(store: Store, what: str, sought: Sought) -> list[Row]:
    """Rows of a kind, oldest first. Raises STO-UNKNOWN where such rows have nothing of what is sought."""
    if what == TRANSFERS:
        return list(_transfers(store, sought))
    kind = NAMES[what]
    columns: dict[str, Any] = {
        name: value for name, value in (("part_type", sought.part_type), ("serial", sought.serial)) if value is not None
    }
    for name in (*columns, *(["edge"] if sought.edge is not None else [])):
        if name not in (*kind.names, *(["edge"] if kind.type is Edge else [])):
            raise _no_column(what, name)
    kept: list[Kept[Any]] = find_values(store, kind.type, superseded=sought.superseded, **columns)
    return [_row(kind, stored, sought.superseded) for stored in kept if _wanted(stored, kind, sought)]


def _transfers(store: Store, sought: Sought) -> Iterator[Row]:
    for name, asked in (("part_type", sought.part_type), ("serial", sought.serial), ("edge", sought.edge)):
        if asked is not None:
            raise _no_column(TRANSFERS, name)
    with store.reading() as connection:
        rows = connection.execute(select(TRANSFER).order_by(TRANSFER.c.id)).all()
    for row in rows:
        at = datetime.fromisoformat(row.at)
        if not _before(at, sought.since):
            hashes = {"sent_sha256": row.sent_sha256[:12], "read_back_sha256": row.read_back_sha256[:12]}
            said = {"control": row.control, "program": row.name, "direction": row.direction, "outcome": row.outcome}
            yield Row(at, f"{TRANSFERS}:{row.id}", {**said, **hashes, "by": row.who})


def _before(at: datetime, since: datetime | None) -> bool:
    return since is not None and at < (since if since.tzinfo else since.replace(tzinfo=UTC))


def _wanted(kept: Kept[Any], kind: Kind, sought: Sought) -> bool:
    if _before(kept.kept_at, sought.since):
        return False
    if sought.edge is None:
        return True
    edge = kept.value.identity if kind.type is Edge else (kind.columns(kept.value)["edge"] or "").split(SEPARATOR)
    asked = sought.edge.split("/")
    return list(edge)[: len(asked)] == asked


def _row(kind: Kind, kept: Kept[Any], superseded: bool) -> Row:
    columns = {name: (value or "").replace(SEPARATOR, "/") for name, value in kind.columns(kept.value).items()}
    cells = {**columns, **_more(kept.value)}
    if superseded:
        cells["superseded_by"] = "" if kept.superseded_by is None else row_name(kind.type, kept.superseded_by)
    return Row(kept.kept_at, row_name(kind.type, kept.row), cells)


def _more(value: object) -> dict[str, str]:
    """Columns of a row that a person reads beside those it is searched by."""
    if isinstance(value, Inspection):
        at = value.measured_at
        said = {"measured_at": "" if at is None else f"{at:%Y-%m-%d %H:%M}", "device": value.device}
        return {"file_sha256": value.sha256[:12], **said, "values": f"{value.count} {value.measured}"}
    if isinstance(value, Cut):
        at = value.at
        return {
            "at": "" if at is None else f"{at:%Y-%m-%d %H:%M}",
            "order": "" if value.order is None else str(value.order),
        }
    if isinstance(value, Correction):
        sha256 = value.source_sha256[:12]
        return {"program_sha256": sha256, "record": value.record.id, "made_at": value.record.made_at[:16]}
    if isinstance(value, Edge):
        return {"insert": value.insert, "corner": value.corner}
    return {}


def _no_column(what: str, name: str) -> TrueloopError:
    having: Iterable[str] = (one for one, kind in NAMES.items() if name in kind.names)
    asked = {"part_type": "--type", "serial": "--serial", "edge": "--edge"}[name]
    return Code.STO_UNKNOWN.refusal(
        f"rows of {what!r} cannot be found by {asked}", hint=f"leave it out, or look for one of {', '.join(having)}"
    )


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
    own: dict[str, Any] = {"part_type": part.part_type.name, "serial": part.serial}
    for kind in (Inspection, Cut):
        rows: list[Kept[Any]] = find(store, kind, superseded=True, **own)
        for kept in rows:
            if kept.superseded_by is not None and kept.value.part.identity == part.identity:
                by = row_of(store, kind, kept.superseded_by)
                assert by is not None, "a foreign key"
                who = ", ".join([*([by.by] if by.by else []), *([by.why] if by.why else [])])
                said = f"superseded by {row_name(kind, by.row)}" + (f": {who}" if who else "")
                entries.append(_entry(kept, by.kept_at, said, []))
    return tuple(sorted(entries, key=lambda entry: (in_utc(entry.at or entry.kept_at), entry.row)))


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
        cut = [f"run by {row_name(Cut, stored.row)}" for stored in whole.cuts if stored.value.correction == record.id]
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


def _entry(kept: Kept[Any], at: datetime | None, text: str, links: Sequence[str]) -> Entry:
    return Entry(row_name(type(kept.value), kept.row), at, kept.kept_at, text, tuple(links))
