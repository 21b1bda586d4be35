"""Rows of the store as people look for them: by type of part, serial number, edge and time."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Final

from sqlalchemy import select

from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut
from trueloop.domain.record import Correction
from trueloop.domain.tool import Edge
from trueloop.errors import Code, TrueloopError
from trueloop.storage.encoded import Kept
from trueloop.storage.factory_tables import TRANSFER
from trueloop.storage.kinds import KINDS, Kind, kind_of
from trueloop.storage.reading import Query, found
from trueloop.storage.store import Store
from trueloop.storage.store import find as find_values

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
    columns = {
        name: value for name, value in (("part_type", sought.part_type), ("serial", sought.serial)) if value is not None
    }
    for name in (*columns, *(["edge"] if sought.edge is not None else [])):
        if name not in (*kind.names, *(["edge"] if kind.type is Edge else [])):
            raise _no_column(what, name)
    kept: list[Kept[Any]] = find_values(store, kind.type, superseded=sought.superseded, **columns)
    return [_row(kind, one, sought.superseded) for one in kept if _wanted(one, kind, sought)]


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
