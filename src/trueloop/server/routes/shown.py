"""Views read from the store by `factory/shown`, each list with its place signed."""

import hmac
import json
from base64 import urlsafe_b64decode, urlsafe_b64encode
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Annotated, Any, Final, TypeVar

from fastapi import Query, Response
from fastapi.responses import PlainTextResponse
from pydantic import TypeAdapter

from trueloop.described import filled_from
from trueloop.domain.factory import PartState
from trueloop.domain.option import Language
from trueloop.errors import Code, TrueloopError
from trueloop.factory.shown import machines, orders, parts, programs, records, series
from trueloop.factory.shown.orders import today
from trueloop.factory.tasks import task_of
from trueloop.factory.views.orders import (
    LinksView,
    OrderRow,
    OrderView,
    Page,
    ProgramDiff,
    ProgramRow,
    Today,
    TransferView,
)
from trueloop.factory.views.parts import CertificateRow, EventView, PartLife, PartRow
from trueloop.factory.views.series import AlarmView, ProposalView, SeriesRow, SeriesView, ToolMemory, ToolRow
from trueloop.jobs.factory.correction_page import correction_curves, correction_page, curve_picture, sources_picture
from trueloop.jobs.factory.runners import links_view
from trueloop.jobs.tool_life import tool_memory
from trueloop.report.turned.figures.curves import CurvePicture
from trueloop.server import etags, pages
from trueloop.server.etags import Say
from trueloop.server.guarded import Here, RowPath, Service, router

Limit = Annotated[int, Query(ge=1, le=500)]
Cursor = Annotated[str | None, Query(max_length=1000)]
_SIGNED: Final = 16


def cursor_of(secret: bytes, of: str, after: Sequence[str | int]) -> str:
    """Makes the cursor of the list `of` (its address and the request), after the row with these values."""
    said = json.dumps(list(after)).encode()
    return urlsafe_b64encode(_signature(secret, of, said) + said).decode().rstrip("=")


def place_of(secret: bytes, of: str, cursor: str) -> list[str | int]:
    """Returns the values that `cursor_of` was given. Raises SRV-CURSOR for anything else."""
    try:
        raw = urlsafe_b64decode(cursor + "=" * (-len(cursor) % 4))
    except ValueError:
        raise _refused(cursor) from None
    signature, said = raw[:_SIGNED], raw[_SIGNED:]
    if not hmac.compare_digest(signature, _signature(secret, of, said)):
        raise _refused(cursor)
    found: list[str | int] = json.loads(said)
    return found


def _signature(secret: bytes, of: str, text: bytes) -> bytes:
    return hmac.digest(secret, of.encode() + b"\n" + text, "sha256")[:_SIGNED]


def _refused(cursor: str) -> TrueloopError:
    return Code.SRV_CURSOR.refusal(
        f"{cursor[:40]!r} is not a cursor of this list that the service has issued since its start",
        hint="ask for the list from its beginning, without cursor",
    )


@dataclass(frozen=True)
class TaskView:
    """`state`: waiting, running, done, failed; `progress` 0 to 1; `problem`: code, message and hint of a refusal."""

    id: int
    kind: str
    subject: str
    state: str
    progress: float
    said: str
    problem: Mapping[str, Any] | None
    result: Mapping[str, str] | None


T = TypeVar("T")
routes = router()
_LIFE: Final = TypeAdapter(PartLife)


class Svg(Response):
    """A picture."""

    media_type = "image/svg+xml"


def signed(here: Service, of: str, cursor: str | None, read: Callable[..., Page[T]]) -> Page[T]:
    """Returns a page of the list `of`: its name and what was asked for. Raises SRV-CURSOR."""
    page = read(cursor=None if cursor is None else str(place_of(here.secret, of, cursor)[0]))
    return Page(page.items, None if page.next is None else cursor_of(here.secret, of, [page.next]))


@routes.get("/today")
def show_today(here: Here) -> Today:
    """Open tasks by person, the machines' states, the finished parts."""
    return today(here.store, here.clock())


@routes.get("/parts")
def list_parts(
    here: Here,
    part_type: str | None = None,
    serial: str | None = None,
    state: PartState | None = None,
    limit: Limit = 50,
    cursor: Cursor = None,
) -> Page[PartRow]:
    """Parts, the latest first."""
    read = partial(parts.part_rows, here.store, part_type=part_type, serial=serial, state=state, limit=limit)
    return signed(here, f"parts {part_type!r} {serial!r} {state!r}", cursor, read)


@routes.get("/parts/{id}/life", response_model=PartLife)
def show_life(id: RowPath, here: Here) -> Response:
    """All that is known of a part."""
    found = parts.part_life(here.store, id)  # as JSON from here: the framework would take another thread to check it
    answer = Response(_LIFE.dump_json(found), media_type="application/json")
    etags.tag(answer, found.etag)
    return answer


@routes.get("/corrections/{id}/report", response_class=Response)
def show_correction(id: str, here: Here, language: Language = "en") -> Response:
    """A correction's report, in a sandbox."""
    return pages.report(correction_page(here.store, id, language))


@routes.get("/corrections/{id}/curves")
def list_curves(id: str, here: Here, say: Say) -> Page[CurvePicture]:
    """The error curves of a correction that have a picture, each in words."""
    return Page(correction_curves(here.store, id, say))


@routes.get("/corrections/{id}/curves/{number}", response_class=Svg)
def show_curve(id: str, number: RowPath, here: Here, say: Say, narrow: bool = False, dark: bool = False) -> Response:
    """The picture of one error curve: red is material left on, blue too much taken; touches with ±U, 95 % band."""
    return pages.picture(curve_picture(here.store, id, number, say, narrow=narrow, dark=dark))


@routes.get("/corrections/{id}/sources", response_class=Svg)
def show_sources(id: str, here: Here, say: Say, narrow: bool = False, dark: bool = False) -> Response:
    """The sources of the errors in a picture: a bar for the share of each in a feature's error, with ±U (95 %)."""
    return pages.picture(sources_picture(here.store, id, say, narrow=narrow, dark=dark))


@routes.get("/series")
def list_series(here: Here, part_type: str | None = None) -> Page[SeriesRow]:
    """Series, whole: there are as many as characteristics."""
    return Page(series.series_rows(here.store, part_type))


@routes.get("/series/{part_type}/{characteristic:path}")
def show_series(part_type: str, characteristic: str, here: Here, say: Say, revision: str | None = None) -> SeriesView:
    """One series."""
    return series.series_view(here.store, part_type, characteristic, revision, say)


@routes.get("/tools")
def list_tools(here: Here) -> Page[ToolRow]:
    """Tools' edges."""
    return Page(machines.tool_rows(here.store))


@routes.get("/tools/{id}/memory")
def show_memory(id: RowPath, here: Here, say: Say) -> ToolMemory:
    """The memory of an edge."""
    return tool_memory(here.store, id, say)


@routes.get("/orders")
def list_orders(here: Here, state: str | None = None, limit: Limit = 50, cursor: Cursor = None) -> Page[OrderRow]:
    """Orders, the latest first."""
    return signed(here, f"orders {state!r}", cursor, partial(orders.order_rows, here.store, state=state, limit=limit))


@routes.get("/orders/{id}")
def show_order(id: str, here: Here, response: Response) -> OrderView:
    """One order."""
    found = orders.order_view(here.store, id)
    etags.tag(response, found.etag)
    return found


@routes.get("/proposals")
def list_proposals(here: Here, state: str | None = None) -> Page[ProposalView]:
    """Proposals; `state`: open, accepted, rejected, superseded."""
    return Page(programs.proposal_views(here.store, here.clock(), state))


@routes.get("/proposals/{id}")
def show_proposal(id: str, here: Here, response: Response) -> ProposalView:
    """One proposal."""
    found = programs.proposal_view(here.store, id, here.clock())
    etags.tag(response, found.etag)
    return found


@routes.get("/proposals/{id}/picture", response_class=Svg)
def show_effects(id: str, here: Here, say: Say, dark: bool = False) -> Response:
    """The picture of what a proposal does to the next part."""
    return pages.picture(programs.proposal_picture(here.store, id, say, dark=dark))


@routes.get("/alarms")
def list_alarms(
    here: Here, only_open: Annotated[bool, Query(alias="open")] = False, limit: Limit = 50, cursor: Cursor = None
) -> Page[AlarmView]:
    """Alarms, the latest first; `open`: those that nobody has acknowledged."""
    return signed(
        here, f"alarms {only_open}", cursor, partial(records.alarm_rows, here.store, open_only=only_open, limit=limit)
    )


@routes.get("/programs")
def list_programs(here: Here, limit: Limit = 50, cursor: Cursor = None) -> Page[ProgramRow]:
    """Programs, the latest first."""
    return signed(here, "programs", cursor, partial(programs.program_rows, here.store, limit=limit))


@routes.get("/programs/{sha}", response_class=PlainTextResponse)
def show_program(sha: str, here: Here) -> Response:
    """A program's text, byte for byte."""
    return Response(programs.text_of(here.store, sha), media_type="text/plain; charset=utf-8")


@routes.get("/programs/{a}/diff/{b}")
def diff(a: str, b: str, here: Here) -> ProgramDiff:
    """Two programs compared."""
    return programs.program_diff(here.store, a, b)


@routes.get("/transfers")
def list_transfers(
    here: Here, control: str | None = None, limit: Limit = 50, cursor: Cursor = None
) -> Page[TransferView]:
    """Transfers to and from controls, the latest first."""
    return signed(
        here, f"transfers {control!r}", cursor, partial(records.transfer_rows, here.store, control=control, limit=limit)
    )


@routes.get("/links")
def list_links(here: Here) -> LinksView:
    """Links to controls: those of the settings that the service reads, and those that transfers were recorded of."""
    return links_view(here.store, here.settings.links, here.clock())


@routes.get("/certificates")
def list_certificates(here: Here, limit: Limit = 50, cursor: Cursor = None) -> Page[CertificateRow]:
    """Certificates, the latest first."""
    return signed(here, "certificates", cursor, partial(records.certificate_rows, here.store, limit=limit))


@routes.get("/certificates/{id}", response_class=Response)
def show_certificate(id: RowPath, here: Here) -> Response:
    """A certificate's page, in a sandbox."""
    return pages.report(records.certificate_content(here.store, id))


@routes.get("/tasks/{id}")
def show_task(id: RowPath, here: Here) -> TaskView:
    """How far a slow task is."""
    return filled_from(TaskView, task_of(here.store, id))


@routes.get("/event-log")
def event_log(here: Here, limit: Limit = 50, cursor: Cursor = None) -> Page[EventView]:
    """The events, the latest first."""
    return signed(here, "event-log", cursor, partial(records.event_rows, here.store, limit=limit))
