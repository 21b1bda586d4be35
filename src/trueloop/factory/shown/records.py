"""Events, alarms, transfers, certificates and temperatures as they are shown."""

import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from datetime import datetime
from typing import Any, Final, TypeVar

from sqlalchemy import ColumnElement, Select, bindparam, func, select

from trueloop.described import filled_from
from trueloop.domain.part import Part
from trueloop.errors import Code
from trueloop.factory.known import unknown
from trueloop.factory.load import StoreReader
from trueloop.factory.views.orders import Page, TransferView
from trueloop.factory.views.parts import CertificateRow, EventView
from trueloop.factory.views.series import AlarmView
from trueloop.storage.schema import ALARM, ALARM_ACKNOWLEDGED, CERTIFICATE, EVENT, TABLES, TRANSFER
from trueloop.storage.store import Store
from trueloop.wording import wording

LIMIT: Final = 50
MOST: Final = 500
T = TypeVar("T")


@contextmanager
def known_of(store: Store) -> Iterator[StoreReader]:
    """Yields what is known in a transaction that reads."""
    with store.reading() as connection:
        yield StoreReader(connection, store.codec)


def before(query: Select[Any], key: ColumnElement[int], limit: int, cursor: str | None) -> Select[Any]:
    """Selects newest first, from the cursor on, one row more than `limit`. Raises FAC-UNKNOWN for no cursor of ours."""
    if cursor is not None:
        if not cursor.isascii() or not cursor.isdigit() or len(cursor) > 18:
            raise Code.FAC_UNKNOWN.refusal(
                f"{cursor[:40]!r} is no cursor",
                hint="take the cursor of the page before as it is, or none",
                values={"what": "cursor", "name": cursor[:40]},
            )
        query = query.where(key < int(cursor))
    return query.order_by(key.desc()).limit(size(limit) + 1)


def size(limit: int) -> int:
    """Returns the size of a page: at least one row, at most `MOST`."""
    return min(max(limit, 1), MOST)


def page_of(rows: list[Any], limit: int, key: Callable[[Any], int], make: Callable[[Any], T]) -> Page[T]:
    """Makes a page of the rows but the one that was read to know of a next page."""
    shown = rows[: size(limit)]
    more = len(rows) > len(shown)
    return Page(tuple(make(one) for one in shown), str(key(shown[-1])) if more else None)


def time(text: str) -> datetime:
    """Converts a time of the tables."""
    return datetime.fromisoformat(text)


_CERTIFICATES = select(
    *(CERTIFICATE.c.id, CERTIFICATE.c.at, CERTIFICATE.c.who, CERTIFICATE.c.verdict, CERTIFICATE.c.sha256),
    TABLES["part"].c.document,
).join(TABLES["part"], TABLES["part"].c.id == CERTIFICATE.c.part)
_OF_PART = _CERTIFICATES.where(CERTIFICATE.c.part == bindparam("number")).order_by(CERTIFICATE.c.id)


def event_rows(store: Store, *, limit: int = LIMIT, cursor: str | None = None) -> Page[EventView]:
    """Returns the event log, newest first."""
    with known_of(store) as known:
        rows = known.rows(before(select(EVENT), EVENT.c.id, limit, cursor))
    return page_of(rows, limit, _id, event_view)


def events_after(store: Store, last: int, most: int = 200) -> tuple[EventView, ...]:
    """Returns what happened after an event, oldest first, for whoever listens."""
    with known_of(store) as known:
        rows = known.rows(select(EVENT).where(EVENT.c.id > last).order_by(EVENT.c.id).limit(most))
    return tuple(event_view(row) for row in rows)


def event_view(row: Any) -> EventView:
    """Makes an event from its row."""
    return filled_from(EventView, row, at=time(row.at), values=json.loads(row.document))


def alarm_rows(
    store: Store, *, open_only: bool = False, limit: int = LIMIT, cursor: str | None = None
) -> Page[AlarmView]:
    """Alarms, newest first."""
    with known_of(store) as known:
        rows = known.rows(before(alarms(open_only=open_only), ALARM.c.id, limit, cursor))
    return page_of(rows, limit, _id, alarm_view)


def alarms(*, open_only: bool) -> Select[Any]:
    """Selects all alarms with who acknowledged them, or only those that nobody did."""
    done = ALARM_ACKNOWLEDGED
    query = select(ALARM, done.c.who.label("seen_by"), done.c.at.label("seen_at"))
    query = query.select_from(ALARM.outerjoin(done, done.c.alarm == ALARM.c.id))
    return query.where(done.c.alarm.is_(None)) if open_only else query


def alarm_view(row: Any) -> AlarmView:
    """Makes an alarm from its row."""
    seen = None if row.seen_at is None else time(row.seen_at)
    said = (row.id, time(row.at), row.source, row.code, row.said, json.loads(row.document))
    return AlarmView(*said, row.seen_by or "", seen)


def transfer_rows(
    store: Store, *, control: str | None = None, limit: int = LIMIT, cursor: str | None = None
) -> Page[TransferView]:
    """Transfers, newest first."""
    query = select(TRANSFER) if control is None else select(TRANSFER).where(TRANSFER.c.control == control)
    with known_of(store) as known:
        rows = known.rows(before(query, TRANSFER.c.id, limit, cursor))
    return page_of(rows, limit, _id, transfer_view)


def last_transfers(reader: StoreReader) -> Mapping[str, TransferView]:
    """Returns the latest transfer of each control, by its name."""
    latest = select(func.max(TRANSFER.c.id)).group_by(TRANSFER.c.control)
    rows = reader.rows(select(TRANSFER).where(TRANSFER.c.id.in_(latest)))
    return {row.control: transfer_view(row) for row in rows}


def transfer_view(row: Any) -> TransferView:
    """Makes a transfer from its row."""
    return filled_from(TransferView, row, at=time(row.at), program=row.name)


def certificate_rows(store: Store, *, limit: int = LIMIT, cursor: str | None = None) -> Page[CertificateRow]:
    """Certificates, newest first."""
    with known_of(store) as known:
        rows = known.rows(before(_CERTIFICATES, CERTIFICATE.c.id, limit, cursor))
        return page_of(rows, limit, _id, lambda row: _certificate(known, row))


def certificate_rows_of(reader: StoreReader, part: int) -> tuple[CertificateRow, ...]:
    """Returns the certificates of a part, oldest first."""
    return tuple(_certificate(reader, row) for row in reader.rows(_OF_PART, number=part))


def certificate_row(store: Store, part: int, sha256: str) -> CertificateRow:
    """Returns the last certificate of a part with this page. Raises FAC-UNKNOWN."""
    with known_of(store) as known:
        found = [row for row in certificate_rows_of(known, part) if row.sha256 == sha256]
    if not found:
        raise unknown(wording("certificate"), sha256, wording("the store has none of that page"))
    return found[-1]


def certificate_content(store: Store, number: int) -> bytes:
    """Returns the page as it was certified. Raises FAC-UNKNOWN."""
    with known_of(store) as known:
        found = known.connection.scalar(select(CERTIFICATE.c.content).where(CERTIFICATE.c.id == number))
    if found is None:
        raise unknown(wording("certificate"), str(number), wording("the store has none of that number"))
    return bytes(found)


def _certificate(reader: StoreReader, row: Any) -> CertificateRow:
    part = reader.codec.from_json(row.document, Part)
    return CertificateRow(
        id=row.id,
        part_type=part.part_type.name,
        serial=part.serial,
        made_at=time(row.at),
        made_by=row.who,
        verdict=row.verdict,
        sha256=row.sha256,
    )


def _id(row: Any) -> int:
    return int(row.id)
