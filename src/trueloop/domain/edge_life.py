"""The life of an edge from its events: when it was mounted, set, turned; which one is in a pocket at a time.

A life begins with a mounting and has all events of that edge up to the next one: a new insert of the same designation
is another life, of which nothing is known yet. An edge that was turned away or removed rests; set again, it goes on.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from datetime import datetime
from typing import Final

from trueloop.domain.life import Cut, EdgeEvent, EdgeEventKind
from trueloop.domain.machine import Machine
from trueloop.domain.tool import Edge, Setting

ENDS: Final = (EdgeEventKind.TURNED, EdgeEventKind.REMOVED)
SETS: Final = (EdgeEventKind.MOUNTED, EdgeEventKind.SET)


@dataclass(frozen=True)
class EdgeLife:
    """One edge from one mounting to the next: `events` in order of time, the first of them its mounting.

    `until` is the next mounting of an edge of the same designation, None for the latest.
    """

    events: tuple[EdgeEvent, ...]
    until: datetime | None = None

    @property
    def edge(self) -> Edge:
        """Returns the edge as the last event has it: a tool may go to another pocket."""
        return self.events[-1].edge

    @property
    def machine(self) -> Machine | None:
        """Returns the machine in which the edge is mounted, as it was stated last."""
        return next((event.machine for event in reversed(self.events) if event.machine is not None), None)

    @property
    def began(self) -> datetime:
        """Returns when it was mounted: what its form left on parts before is another edge's."""
        return self.events[0].at

    def before(self, when: datetime) -> "EdgeLife | None":
        """Returns the life as it was known then; None before the mounting."""
        known = tuple(event for event in self.events if event.at <= when)
        return EdgeLife(known, self.until) if known else None

    @property
    def ended(self) -> EdgeEvent | None:
        """Returns the event by which it cuts no more; None while it is mounted."""
        known = (event for event in reversed(self.events) if event.kind in (*ENDS, *SETS))
        last = next(known, None)
        return last if last is not None and last.kind in ENDS else None

    @property
    def set_at(self) -> datetime:
        """Returns when it was mounted, or measured and touched off, last."""
        return next((event.at for event in reversed(self.events) if event.kind in SETS), self.began)

    @property
    def setting(self) -> Setting:
        """Returns the latest setting."""
        return Setting(self.edge, self.set_at)

    def of_machine(self, machine: Machine) -> bool:
        """Returns whether the edge is mounted in that machine, as far as either is stated."""
        return _same_machine(self.machine, machine)

    def holds(self, when: datetime) -> bool:
        """Returns whether a fact of that time is of this life."""
        return self.began <= when and (self.until is None or when < self.until)


def lives(events: Iterable[EdgeEvent]) -> tuple[EdgeLife, ...]:
    """Returns the lives of all edges, in order of their mounting. Events before an edge's first mounting begin one."""
    found: list[list[EdgeEvent]] = []
    current: dict[tuple[str, ...], list[EdgeEvent]] = {}
    for event in sorted(events, key=_in_time):
        identity = event.edge.identity
        if event.kind is EdgeEventKind.MOUNTED or identity not in current:
            current[identity] = []
            found.append(current[identity])
        current[identity].append(event)
    return tuple(EdgeLife(tuple(one), _next(one, found[k + 1 :])) for k, one in enumerate(found))


def in_pockets(known: Iterable[EdgeLife], when: datetime, machine: Machine | None = None) -> tuple[EdgeLife, ...]:
    """Returns the lives of the edges mounted at that time, as they were known then; without a machine, of all."""
    then = [life.before(when) for life in known if life.until is None or when < life.until]
    return tuple(
        life for life in then if life is not None and life.ended is None and _same_machine(life.machine, machine)
    )


def life_of(known: Sequence[EdgeLife], edge: Edge, when: datetime | None = None) -> EdgeLife | None:
    """Returns the life of an edge that a time falls into, or its latest; None where nothing is known of it."""
    own = [life for life in known if life.edge.identity == edge.identity]
    if when is not None:
        own = [life for life in own if life.holds(when)]
    return own[-1] if own else None


def of_one_insert(known: Sequence[EdgeLife], life: EdgeLife) -> tuple[EdgeLife, ...]:
    """Returns the lives of all corners of the insert that this edge is one of, this one included.

    Turning ends one life and begins another at the same time; a mounting that no turning ends is a new insert.
    """
    insert = life.edge.identity[:-1]
    own = sorted((one for one in known if one.edge.identity[:-1] == insert), key=lambda one: one.began)
    inserts: list[list[EdgeLife]] = []
    for one in own:
        turned = any(
            event.at == one.began and event.kind is EdgeEventKind.TURNED for other in own for event in other.events
        )
        if turned and inserts:
            inserts[-1].append(one)
        else:
            inserts.append([one])
    return next(tuple(group) for group in inserts if life.began in [one.began for one in group])


def time_of(cut: Cut) -> datetime | None:
    """Returns when a cut was made: by its own time, else not before its setting; None where neither is stated."""
    if cut.at is not None:
        return cut.at
    return None if cut.setting is None else cut.setting.set_at


def _in_time(event: EdgeEvent) -> tuple[datetime, bool]:
    """What ends a life comes before what begins one at the same time."""
    return event.at, event.kind not in ENDS


def _next(one: Sequence[EdgeEvent], later: Iterable[Sequence[EdgeEvent]]) -> datetime | None:
    return next((other[0].at for other in later if other[0].edge.identity == one[0].edge.identity), None)


def _same_machine(one: Machine | None, other: Machine | None) -> bool:
    """A serial number that is not stated agrees with any."""
    if one is None or other is None:
        return True
    return one.name == other.name and (not one.serial or not other.serial or one.serial == other.serial)


def tool_name(edge: Edge) -> str:
    """Returns the tool's name: T3, or the holder where no number is known."""
    return f"T{edge.tool.number}" if edge.tool.number is not None else edge.tool.name


def edge_name(edge: Edge) -> str:
    """Returns tool, holder, insert and corner, as far as they are stated."""
    words = [tool_name(edge)]
    if edge.tool.name and edge.tool.number is not None:
        words.append(edge.tool.name)
    words += [edge.insert] if edge.insert else []
    return " ".join(words + ([f"corner {edge.corner}"] if edge.corner else []))


def time(at: datetime) -> str:
    """Returns a time as messages have it: to the second, with its zone."""
    return at.isoformat(sep=" ", timespec="seconds")


def where(life: EdgeLife) -> str:
    """Returns the edge with its machine, in words."""
    machine = "" if life.machine is None else f" in {life.machine.name}"
    return edge_name(life.edge) + machine
