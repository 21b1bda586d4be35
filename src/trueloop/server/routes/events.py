"""News as they come, and the log of what happened."""

from typing import Annotated

from fastapi import Header, Request
from fastapi.responses import StreamingResponse
from sqlalchemy import select

from trueloop.factory.views.parts import EventView
from trueloop.server import cursors, streams
from trueloop.server.cursors import Cursor, Limit, Page
from trueloop.server.guarded import By, Here, router
from trueloop.storage.factory_tables import EVENT

routes = router()


@routes.get("/events", response_class=StreamingResponse)
def events(
    here: Here, who: By, request: Request, last_event_id: Annotated[int | None, Header(ge=0)] = None
) -> StreamingResponse:
    """Events as they happen (server-sent events); after a break those since `Last-Event-ID`."""
    after = streams.last_event(here.store) if last_event_id is None else last_event_id

    def read(after: int) -> tuple[int, list[bytes]]:
        news = streams.events_after(here.store, after)
        return (news[-1].id if news else after), [streams.event_bytes(one) for one in news]

    state = request.app.state
    return streams.stream(here, who, state.figures, state.stopping, after, read)


@routes.get("/event-log")
def event_log(here: Here, limit: Limit = 50, cursor: Cursor = None, subject: str | None = None) -> Page[EventView]:
    """What happened, newest first; `subject`: to one thing, `part:12`."""
    of = f"event-log {subject}"
    wanted = select(EVENT).order_by(EVENT.c.id.desc()).limit(limit + 1)
    if subject is not None:
        wanted = wanted.where(EVENT.c.subject == subject)
    if cursor is not None:
        wanted = wanted.where(EVENT.c.id < int(cursors.place_of(here.secret, of, cursor)[0]))
    with here.store.reading() as connection:
        rows = connection.execute(wanted).all()
    shown = [streams.view(one) for one in rows[:limit]]
    more = cursors.cursor_of(here.secret, of, [shown[-1].id]) if len(rows) > limit else None
    return Page(shown, more)
