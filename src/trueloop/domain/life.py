"""Events of parts and edges between the files: cuts, the inspections that belong to them, and events of an edge.

The links between them are stated, never derived from numbers in labels: "finished = semi-finished + 1" fails on NIST's
own parts [6811 §4.3].

The life of an edge from its events: when it was mounted, set, turned; which one is in a pocket at a time.

A life begins with a mounting and has all events of that edge up to the next one: a new insert of the same designation
is another life, of which nothing is known yet. An edge that was turned away or removed rests; set again, it goes on.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime
from enum import StrEnum
from typing import Final, Literal, TypeAlias

from trueloop.domain.part import Part
from trueloop.domain.tool import Edge, Machine, Setting

Identity: TypeAlias = tuple[str, ...]
"""By which a stored value is found again and known as the same."""


class Stage(StrEnum):
    """How far a part has come."""

    ROUGH = "rough"
    SEMIFINISH = "semifinish"
    FINISH = "finish"


class Ran(StrEnum):
    """Which program a finish cut ran, of those that a correction gives."""

    CORRECTED = "corrected"  # the contour in the program is corrected
    OFFSETS = "offsets"  # the program that holds tool offsets
    AS_PROGRAMMED = "as-programmed"  # the given program, nothing corrected
    WEAR = "wear"  # the given program, the tool offset entered at the control


@dataclass(frozen=True)
class CuttingConditions:
    """Of one cut: depths and lengths in mm, radius for a depth on X; None: not stated.

    What was learned holds for the depth and feed that it was learned at.
    """

    depth_of_cut_mm: float | None = None
    feed_mm_per_rev: float | None = None
    speed_m_per_min: float | None = None
    time_in_cut_min: float | None = None
    material: str = ""


@dataclass(frozen=True)
class Cut:
    """One cut of one part, as it was made: `setting` is the edge with the time at which it was set.

    `program_sha256` is that of the text that ran, `correction` the id of the record in force; empty: none, as
    programmed. `offset_entered`: the correction is a tool offset that was entered at the control.
    `order` counts the parts of an edge as they were cut; None: by `at`. `order_in_doubt`: other facts contradict it.
    """

    part: Part
    stage: Stage
    setting: Setting | None = None
    machine: Machine | None = None
    program_sha256: str = ""
    correction: str = ""
    at: datetime | None = None
    order: int | None = None
    order_in_doubt: bool = False
    offset_entered: bool = False
    conditions: CuttingConditions = field(default_factory=CuttingConditions)
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> Identity:
        """Returns part, stage, and time: a part cut twice has two cuts."""
        return *self.part.identity, self.stage, "" if self.at is None else self.at.isoformat()


@dataclass(frozen=True)
class InspectionLink:
    """That an inspection shows what a cut left, both by identity; `released`: after unclamping, off the machine."""

    inspection: Identity
    cut: Identity
    released: bool = False
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> Identity:
        """Returns the identity of the inspection: it shows one cut."""
        return self.inspection


@dataclass(frozen=True)
class Quarantine:
    """That a cut is not to teach anything, or, `lifted`, may again; of several of one cut the latest counts."""

    cut: Identity
    at: datetime
    why: str = ""
    by: str = ""
    lifted: bool = False
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> Identity:
        """Returns the cut and the time."""
        return *self.cut, self.at.isoformat()


class EdgeEventKind(StrEnum):
    """The kinds of events of an edge."""

    MOUNTED = "mounted"  # a new insert or corner: nothing learned of its form holds any more
    TURNED = "turned"  # the insert indexed: another corner cuts, which is another edge
    SET = "set"  # measured or touched off anew: its form stays, where its tip lies does not
    WORN = "worn"  # flank wear measured
    REMOVED = "removed"


@dataclass(frozen=True)
class EdgeEvent:
    """One event of an edge. `values` by name with the unit in the name: {"flank_wear_mm": 0.12, "minutes_in_cut": 35}.

    Offsets among them are `x_mm`, a radius, and `z_mm`. `machine` tells tools of one number apart, in whose pockets
    they are; None: the store knows one machine.
    """

    edge: Edge
    kind: EdgeEventKind
    at: datetime
    by: str = ""
    values: Mapping[str, float] = field(default_factory=dict)
    machine: Machine | None = None
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> Identity:
        """Returns edge, kind and time."""
        return *self.edge.identity, self.kind, self.at.isoformat()


ENDS: Final = (EdgeEventKind.TURNED, EdgeEventKind.REMOVED)
SETS: Final = (EdgeEventKind.MOUNTED, EdgeEventKind.SET)


@dataclass(frozen=True)
class EdgeLife:
    """One edge from its mounting, the first of its `events`, to the next of its designation, `until` (None: latest)."""

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


def in_pockets(edges: Iterable[EdgeLife], when: datetime, machine: Machine | None = None) -> tuple[EdgeLife, ...]:
    """Returns the lives of the edges mounted at that time, as they were known then; without a machine, of all."""
    then = [life.before(when) for life in edges if life.until is None or when < life.until]
    return tuple(
        life for life in then if life is not None and life.ended is None and _same_machine(life.machine, machine)
    )


def life_of(edges: Sequence[EdgeLife], edge: Edge, when: datetime | None = None) -> EdgeLife | None:
    """Returns the life of an edge that a time falls into, or its latest; None where nothing is known of it."""
    own = [life for life in edges if life.edge.identity == edge.identity]
    if when is not None:
        own = [life for life in own if life.holds(when)]
    return own[-1] if own else None


def of_one_insert(edges: Sequence[EdgeLife], life: EdgeLife) -> tuple[EdgeLife, ...]:
    """Returns the lives of all corners of the insert that this edge is one of, this one included.

    Turning ends one life and begins another at the same time; a mounting that no turning ends is a new insert.
    """
    insert = life.edge.identity[:-1]
    own = sorted((edge for edge in edges if edge.edge.identity[:-1] == insert), key=lambda edge_life: edge_life.began)
    inserts: list[list[EdgeLife]] = []
    for edge_life in own:
        turned = any(
            event.at == edge_life.began and event.kind is EdgeEventKind.TURNED
            for other in own
            for event in other.events
        )
        if turned and inserts:
            inserts[-1].append(edge_life)
        else:
            inserts.append([edge_life])
    return next(tuple(group) for group in inserts if life.began in [edge_life.began for edge_life in group])


def time_of(cut: Cut) -> datetime | None:
    """Returns when a cut was made: by its own time, else not before its setting; None where neither is stated."""
    if cut.at is not None:
        return cut.at
    return None if cut.setting is None else cut.setting.set_at


def _in_time(event: EdgeEvent) -> tuple[datetime, bool]:
    """Sort key: by time, events that end a life before those that begin one."""
    return event.at, event.kind not in ENDS


def _next(events: Sequence[EdgeEvent], later: Iterable[Sequence[EdgeEvent]]) -> datetime | None:
    return next((other[0].at for other in later if other[0].edge.identity == events[0].edge.identity), None)


def _same_machine(machine: Machine | None, other: Machine | None) -> bool:
    """A serial number that is not stated agrees with any."""
    if machine is None or other is None:
        return True
    return machine.name == other.name and (not machine.serial or not other.serial or machine.serial == other.serial)


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
