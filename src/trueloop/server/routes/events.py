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
from typing import Annotated

from fastapi import Header, Request
from fastapi.responses import StreamingResponse
from fastapi.sse import format_sse_event
from sqlalchemy import func, select
from starlette.concurrency import run_in_threadpool

from trueloop.factory.shown.records import events_after
from trueloop.factory.views.parts import EventView
from trueloop.server.gates import Figures
from trueloop.server.guarded import By, Here, Service, router
from trueloop.server.identity import sessions
from trueloop.server.identity.attempts import too_early
from trueloop.server.identity.keys import Who
from trueloop.storage.schema import EVENT, MACHINE_HEARD
from trueloop.storage.store import Store

routes = router()
_LARGEST = (1 << 53) - 1


@routes.get("/events", response_class=StreamingResponse)
def events(
    here: Here, who: By, request: Request, last_event_id: Annotated[int | None, Header(ge=0, le=_LARGEST)] = None
) -> StreamingResponse:
    """Events as they happen (server-sent events); after a break those since `Last-Event-ID`."""
    after = last_event(here.store) if last_event_id is None else last_event_id

    def read(after: int) -> tuple[int, list[bytes]]:
        news = events_after(here.store, after)
        return (news[-1].id if news else after), [event_bytes(new) for new in news]

    state = request.app.state
    return stream(here, who, state.figures, state.stopping, after, read)


Read = Callable[[int], tuple[int, list[bytes]]]


def last_event(store: Store) -> int:
    """Returns the number of the newest event, 0: there is none."""
    with store.reading() as connection:
        return int(connection.execute(select(func.max(EVENT.c.id))).scalar_one() or 0)


def event_bytes(event: EventView) -> bytes:
    """Returns an event as the stream has it."""
    shown = {
        "id": event.id,
        "at": event.at.isoformat(),
        "who": event.who,
        "what": event.what,
        "subject": event.subject,
        "values": event.values,
    }
    return format_sse_event(data_str=json.dumps(shown), id=str(event.id))


def trace_after(store: Store, machine: str, after: int) -> tuple[int, list[bytes]]:
    """Returns what the machine's cell reported last, if that was after that time (ms since 1970)."""
    with store.reading() as connection:
        row = connection.execute(select(MACHINE_HEARD).where(MACHINE_HEARD.c.machine == machine)).one_or_none()
    if row is None or (at := int(datetime.fromisoformat(row.at).timestamp() * 1000)) <= after:
        return after, []
    said = json.loads(row.document)
    numbers = {name: said.get(name) for name in ("line", "progress")} | (said.get("temperatures_c") or {})
    values = {name: value for name, value in numbers.items() if isinstance(value, int | float)}
    shown = {"at": row.at, "values": values}
    return at, [format_sse_event(data_str=json.dumps(shown), id=str(at))]


def stream(here: Service, who: Who, figures: Figures, stopping: Event, after: int, read: Read) -> StreamingResponse:
    """Streams what `read` returns after a number, again and again. Raises SRV-DELAY where too many are open."""
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
