"""Server-sent events: news out of the event table, for as long as the session holds and the service runs.

The table is asked, so that several services on one database, and commands beside them, all are heard. Events are
numbered in the order in which they were written, on both databases: writers take turns.
"""

import asyncio
import json
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import contextmanager
from datetime import datetime
from threading import Event
from typing import Any, Final

from fastapi.responses import StreamingResponse
from fastapi.sse import format_sse_event
from sqlalchemy import func, select
from starlette.concurrency import run_in_threadpool

from trueloop.factory.views.parts import EventView
from trueloop.server.figures import Figures
from trueloop.server.guarded import Service
from trueloop.server.identity import sessions
from trueloop.server.identity.attempts import too_early
from trueloop.server.identity.who import Who
from trueloop.storage.factory_tables import EVENT
from trueloop.storage.store import Store

AT_ONCE: Final = 200
Read = Callable[[int], tuple[int, list[bytes]]]


def events_after(store: Store, after: int, limit: int = AT_ONCE) -> list[EventView]:
    """Of the event log, oldest first."""
    with store.reading() as connection:
        rows = connection.execute(select(EVENT).where(EVENT.c.id > after).order_by(EVENT.c.id).limit(limit)).all()
    return [view(one) for one in rows]


def view(row: Any) -> EventView:
    """A row of the event table as it is shown."""
    at = datetime.fromisoformat(row.at)
    values = {str(name): str(value) for name, value in json.loads(row.document or "{}").items()}
    return EventView(row.id, at, row.who, row.what, row.subject, values)


def last_event(store: Store) -> int:
    """The number of the newest one, 0: there is none."""
    with store.reading() as connection:
        return int(connection.execute(select(func.max(EVENT.c.id))).scalar_one() or 0)


def event_bytes(one: EventView) -> bytes:
    """As the stream has it."""
    shown = {
        "id": one.id,
        "at": one.at.isoformat(),
        "who": one.who,
        "what": one.what,
        "subject": one.subject,
        "values": one.values,
    }
    return format_sse_event(data_str=json.dumps(shown), id=str(one.id))


def stream(here: Service, who: Who, figures: Figures, stopping: Event, after: int, read: Read) -> StreamingResponse:
    """What `read` finds after a number, again and again. Raises SRV-DELAY where too many are open."""
    if figures.streams >= here.settings.limits.streams:
        raise too_early(here.settings.heartbeat_s)
    return StreamingResponse(
        _pieces(here, who, figures, stopping, after, read),
        media_type="text/event-stream",
        headers={"X-Accel-Buffering": "no"},
    )


async def _pieces(
    here: Service, who: Who, figures: Figures, stopping: Event, after: int, read: Read
) -> AsyncIterator[bytes]:
    settings = here.settings
    with _counted(figures):
        yield b": hello\n\nretry: 1000\n\n"
        quiet_s = 0.0
        while not stopping.is_set() and await run_in_threadpool(_still_in, here, who):
            after, news = await run_in_threadpool(read, after)
            for piece in news:
                yield piece
            quiet_s = 0.0 if news else quiet_s + settings.poll_s
            if quiet_s >= settings.heartbeat_s:
                yield b": still here\n\n"
                quiet_s = 0.0
            await asyncio.sleep(settings.poll_s)


def _still_in(here: Service, who: Who) -> bool:
    """A role that was taken away, or a session that ended, ends its streams; looking on is not using the session."""
    now = sessions.still_open(here.store, here.settings, who.session, here.clock(), seen=False)
    return now is not None and now.role == who.role


@contextmanager
def _counted(figures: Figures) -> Iterator[None]:
    figures.streams += 1
    try:
        yield
    finally:
        figures.streams -= 1
