"""Events of tools, decided by what is known: mounted, turned, set, wear measured, removed. Each gives what to keep.

Nothing is written here: a refusal leaves the store as it was (`jobs.tools.keeping`).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime, timedelta
from typing import Final

from trueloop.domain.edge_life import EdgeLife, in_pockets, life_of, of_one_insert
from trueloop.domain.edge_names import edge_name, time, tool_name, where
from trueloop.domain.life import EdgeEvent, EdgeEventKind
from trueloop.domain.machine import Machine
from trueloop.domain.tool import Edge, Tool
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.tools.find import mounted_as, number_of

CLOCKS_DIFFER: Final = timedelta(minutes=1)
"""The clocks of two computers of a shop may differ by this much."""


@dataclass(frozen=True)
class Happened:
    """What is common to all events: when, by whom, in which machine, and lengths and times by name."""

    at: datetime
    by: str = ""
    machine: Machine | None = None
    values: dict[str, float] = field(default_factory=dict)

    def to(self, edge: Edge, kind: EdgeEventKind, *, valued: bool = True) -> EdgeEvent:
        """The event of an edge."""
        return EdgeEvent(edge, kind, self.at, self.by, self.values if valued else {}, self.machine)


@dataclass(frozen=True)
class Mounting:
    """What is mounted as `tool`. `nose_radius_mm` None: not stated. `again`: this very edge, which was removed."""

    tool: str
    holder: str = ""
    insert: str = ""
    corner: str = ""
    nose_radius_mm: float | None = None
    again: bool = False


def mounting(known: Sequence[EdgeLife], wanted: Mounting, happened: Happened) -> tuple[EdgeEvent, ...]:
    """A new insert mounted, or with `again` one that was removed: then its form is known, its setting is not.

    What the same holder had in that pocket is removed with it. Raises EDG-POCKET for a pocket that holds another
    holder, or an edge that is mounted elsewhere, EDG-VALUE without nose radius, EDG-UNKNOWN for `again` of what was
    never mounted.
    """
    edge = _wanted_edge(known, wanted)
    events = list[EdgeEvent]()
    for life in in_pockets(known, happened.at, happened.machine):
        same_pocket = life.edge.tool.number == edge.tool.number and edge.tool.number is not None
        if not same_pocket and life.edge.identity != edge.identity:
            continue
        if not same_pocket or life.edge.tool.name != edge.tool.name:
            raise _held(life, edge)
        same_edge = life.edge.identity == edge.identity
        if not same_edge or (not wanted.again and life.began < happened.at):
            events.append(happened.to(life.edge, EdgeEventKind.REMOVED, valued=False))
    _require_free(known, edge, happened)
    return (*events, happened.to(edge, EdgeEventKind.SET if wanted.again else EdgeEventKind.MOUNTED))


def turning(
    known: Sequence[EdgeLife], tool: str, corner: str, happened: Happened, *, again: bool = False
) -> tuple[EdgeEvent, ...]:
    """The insert indexed: `corner` cuts from now on, which nothing is known of unless it cut before (`again`).

    Raises EDG-CORNER for the corner that cuts already, and without `again` for one of this insert that did before.
    """
    life = mounted_as(known, tool, happened.at, happened.machine)
    edge = replace(life.edge, corner=corner)
    used = [one for one in of_one_insert(known, life) if one.edge.corner == corner]
    if not corner or corner == life.edge.corner or (used and not again) or (again and not used):
        raise _corner(life, corner, used)
    begins = EdgeEventKind.SET if used else EdgeEventKind.MOUNTED
    return happened.to(life.edge, EdgeEventKind.TURNED, valued=False), happened.to(edge, begins)


def of_mounted(known: Sequence[EdgeLife], tool: str, kind: EdgeEventKind, happened: Happened) -> tuple[EdgeEvent, ...]:
    """Set, wear measured, removed. Raises EDG-VALUE for wear without a value."""
    if kind is EdgeEventKind.WORN and not happened.values:
        raise TrueloopError(
            Code.EDG_VALUE,
            f"0 values of the wear of {tool} are stated",
            hint="give --flank-mm, --minutes-in-cut or both",
            values={"name": "flank_wear_mm"},
        )
    return (happened.to(mounted_as(known, tool, happened.at, happened.machine).edge, kind),)


def require_values(values: dict[str, float]) -> None:
    """Raises EDG-VALUE for what is no finite number, and for a radius, wear or time below 0."""
    for name, value in values.items():
        signed = name in ("x_mm", "z_mm")
        if not math.isfinite(value) or (value < 0 and not signed):
            raise TrueloopError(
                Code.EDG_VALUE,
                f"{name} is {value:g}",
                hint="give a finite number" if signed else "give a finite number, 0 or more",
                values={"name": name},
            )


def require_time(at: datetime, now: datetime) -> None:
    """Raises EDG-TIME for an event that has not happened yet by the clock."""
    if at > now + CLOCKS_DIFFER:
        raise TrueloopError(
            Code.EDG_TIME,
            f"the event is of {time(at)}, and it is {time(now)} now",
            hint="an event is kept when it has happened: give its time by --at, or set this computer's clock",
            values={"at": time(at), "now": time(now)},
        )


def _wanted_edge(known: Sequence[EdgeLife], wanted: Mounting) -> Edge:
    number = number_of(wanted.tool)
    name = wanted.holder or ("" if number is not None else wanted.tool)
    edge = Edge(Tool(number, name, wanted.nose_radius_mm), wanted.insert, wanted.corner)
    before = life_of(known, edge)
    if wanted.again and before is None:
        raise TrueloopError(
            Code.EDG_UNKNOWN,
            f"{edge_name(edge)} was never mounted: nothing is known that could hold again",
            hint="leave out --again; `trueloop tool list --all` shows every edge that was mounted",
            values={"tool": wanted.tool, "known": list(map(where, known))},
        )
    if wanted.nose_radius_mm is None and wanted.again and before is not None:
        return replace(edge, tool=replace(edge.tool, corner_radius_mm=before.edge.tool.corner_radius_mm))
    if wanted.nose_radius_mm is None:
        raise TrueloopError(
            Code.EDG_VALUE,
            f"nose_radius_mm of {edge_name(edge)} is missing",
            hint="give --nose-radius-mm: on the insert's box, RE of ISO 13399; 0 for a pointed tool",
            values={"name": "nose_radius_mm"},
        )
    return edge


def _require_free(known: Sequence[EdgeLife], edge: Edge, happened: Happened) -> None:
    """An edge of these names must not cut elsewhere: what one learns would be taken for the other's."""
    for life in in_pockets(known, happened.at):
        in_other_machine = happened.machine is not None and not life.of_machine(happened.machine)
        if life.edge.identity == edge.identity and in_other_machine:
            raise _held(life, edge)


def _held(life: EdgeLife, edge: Edge) -> TrueloopError:
    same = life.edge.identity == edge.identity
    hint = (
        "remove it there first; of two alike, name one otherwise: number the inserts or the holders"
        if same
        else f"remove it first: `trueloop tool remove {tool_name(life.edge)}`; in another machine, name it by --machine"
    )
    return TrueloopError(
        Code.EDG_POCKET,
        f"{edge_name(edge)} cannot be mounted: {where(life)} is, since {time(life.set_at)}",
        hint=hint,
        values={"tool": tool_name(edge), "held": [where(life)]},
    )


def _corner(life: EdgeLife, corner: str, used: Sequence[EdgeLife]) -> TrueloopError:
    name = tool_name(life.edge)
    if not corner:
        said, hint = f"{name}: the corner has no name", "name it as it is marked on the insert: --corner 2"
    elif corner == life.edge.corner:
        said = f"corner {corner!r} of {name} cuts already, since {time(life.set_at)}"
        hint = f"name the new corner; for a new insert `trueloop tool mount {name}`"
    elif used:
        end = used[-1].events[-1]
        said = f"corner {corner!r} of {name} cut before, until {time(end.at)}"
        hint = f"with --again its form is taken as it was then; for a new insert `trueloop tool mount {name}`"
    else:
        said = f"corner {corner!r} of {name} never cut: nothing is known that could hold again"
        hint = "leave out --again"
    return TrueloopError(Code.EDG_CORNER, said, hint=hint, values={"corner": corner})
