"""Machines as they are now, their cells and correctors. What is asked comes last: a name may hold a slash."""

from typing import Annotated, Final

from fastapi import Header, Request
from fastapi.responses import StreamingResponse

from trueloop.factory.shown.machines import machine_view, machines_now, require_known
from trueloop.factory.views.orders import MachineNow, Page
from trueloop.factory.views.parts import MachineView
from trueloop.server.guarded import By, Here, router
from trueloop.server.routes import events

routes = router()
_LARGEST: Final = (1 << 63) - 1


@routes.get("/machines")
def list_machines(here: Here) -> Page[MachineNow]:
    """Machines as they are now."""
    return Page(machines_now(here.store, here.clock()))


@routes.get("/machines/{name:path}/trace", response_class=StreamingResponse)
def trace(name: str, here: Here, who: By, request: Request) -> StreamingResponse:
    """The reports of its cell as they come (server-sent events)."""
    require_known(here.store, name, here.clock())

    def read(after: int) -> tuple[int, list[bytes]]:
        return events.trace_after(here.store, name, after)

    state = request.app.state
    return events.stream(here, who, state.figures, state.stopping, 0, read)


@routes.get("/machines/{name:path}/corrector", response_class=StreamingResponse)
def corrector(
    name: str,
    here: Here,
    who: By,
    request: Request,
    last_event_id: Annotated[int | None, Header(ge=0, le=_LARGEST)] = None,
) -> StreamingResponse:
    """The state of its corrector, from `trueloop realtime watch` (server-sent events)."""
    require_known(here.store, name, here.clock())
    state = request.app.state

    def read(after: int) -> tuple[int, list[bytes]]:
        told: tuple[int, list[bytes]] = state.traces.after(name, after)
        return told

    return events.stream(here, who, state.figures, state.stopping, last_event_id or 0, read)


@routes.get("/machines/{name:path}")
def show_machine(name: str, here: Here) -> MachineView:
    """One machine."""
    return machine_view(here.store, name, here.clock())
