"""News as they come."""

from typing import Annotated

from fastapi import Header, Request
from fastapi.responses import StreamingResponse

from trueloop.factory.shown.records import events_after
from trueloop.server import streams
from trueloop.server.guarded import By, Here, router

routes = router()
_LARGEST = (1 << 53) - 1


@routes.get("/events", response_class=StreamingResponse)
def events(
    here: Here, who: By, request: Request, last_event_id: Annotated[int | None, Header(ge=0, le=_LARGEST)] = None
) -> StreamingResponse:
    """Events as they happen (server-sent events); after a break those since `Last-Event-ID`."""
    after = streams.last_event(here.store) if last_event_id is None else last_event_id

    def read(after: int) -> tuple[int, list[bytes]]:
        news = events_after(here.store, after)
        return (news[-1].id if news else after), [streams.event_bytes(new) for new in news]

    state = request.app.state
    return streams.stream(here, who, state.figures, state.stopping, after, read)
