"""A store with events of one tool, T3."""

from datetime import UTC, datetime
from typing import Final

from trueloop.domain.life import EdgeEvent, EdgeEventKind
from trueloop.domain.tool import Machine
from trueloop.jobs.tools import Happened, Mounting, keep_events, mounting, of_mounted, turning
from trueloop.storage.store import Store

DAY: Final = 2
NOW: Final = datetime(2026, 3, DAY, 18, tzinfo=UTC)
KINDS: Final = {"set": EdgeEventKind.SET, "wear": EdgeEventKind.WORN, "remove": EdgeEventKind.REMOVED}


def at(hour: int, minute: int = 0) -> datetime:
    """A time of the day of these tests."""
    return datetime(2026, 3, DAY, hour, minute, tzinfo=UTC)


def mount(
    store: Store,
    when: datetime,
    *,
    tool: str = "T3",
    holder: str = "SVJBR 2020",
    insert: str = "VBMT 160408",
    corner: str = "1",
    nose_radius_mm: float | None = 0.8,
    machine: str = "",
    again: bool = False,
    late: bool = False,
) -> tuple[EdgeEvent, ...]:
    wanted = Mounting(tool, holder, insert, corner, nose_radius_mm, again)
    happened = Happened(when, "", Machine(machine) if machine else None)
    return keep_events(store, lambda known: mounting(known, wanted, happened), NOW, late=late)


def turn(store: Store, corner: str, when: datetime, *, again: bool = False) -> tuple[EdgeEvent, ...]:
    return keep_events(store, lambda known: turning(known, "T3", corner, Happened(when), again=again), NOW)


def set_anew(store: Store, when: datetime, *, late: bool = False) -> tuple[EdgeEvent, ...]:
    return put(store, "set", when, late=late)


def put(
    store: Store, kind: str, when: datetime, *, tool: str = "T3", late: bool = False, **values: float
) -> tuple[EdgeEvent, ...]:
    happened = Happened(when, values=values)
    return keep_events(store, lambda known: of_mounted(known, tool, KINDS[kind], happened), NOW, late=late)
