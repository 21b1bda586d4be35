"""Tools and their edges in the store: events kept, and which edge a job means."""

import math
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime, timedelta
from difflib import get_close_matches
from typing import Final

from trueloop.domain.life import (
    Cut,
    EdgeEvent,
    EdgeEventKind,
    EdgeLife,
    edge_name,
    in_pockets,
    life_of,
    lives,
    of_one_insert,
    time,
    time_of,
    tool_name,
    where,
)
from trueloop.domain.tool import Edge, Machine, Setting, Tool
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.loops.turned.correction import Inputs
from trueloop.storage.kinds import joined
from trueloop.storage.store import Store, find, keep
from trueloop.wording import shell_word

STATED = ("holder", "insert", "corner")


def lives_in(store: Store) -> tuple[EdgeLife, ...]:
    """Returns the lives of all edges that the store has events of."""
    return lives(kept.value for kept in find(store, EdgeEvent))


def edge_of(
    store: Store,
    stated: Edge | None,
    number: int | None,
    at: datetime,
    *,
    set_at: datetime | None = None,
    machine: Machine | None = None,
    groove_corner: str | None = None,
) -> Setting | None:
    """Returns the edge that cuts with tool `number` at that time, and when it was set.

    Where the tool is mounted in the store, a job may state its number alone; what it states besides has to agree.
    Where the store has no event of the tool, the job's word counts, `set_at` and `groove_corner` with it. None where
    neither says which edge cuts. Raises EDG-OTHER for a job that contradicts the store, EDG-ENDED for an edge that was
    turned away or removed before, EDG-POCKET for a number in several machines.
    """
    known = lives_in(store)
    mounted = _mounted(known, stated, number, at, machine)
    if mounted is not None:
        # Requires that a job's statements agree with the mounted edge; what it leaves open agrees
        there = mounted.edge
        if stated is not None:
            pairs = zip(STATED, _names(stated), _names(there), strict=True)
            differing = [(name, said, held) for name, said, held in pairs if said and said != held]
            if differing:
                said = ", ".join(f"{name} {said!r}" for name, said, _ in differing)
                held = ", ".join(f"{name} {held!r}" for name, _, held in differing)
                raise _other(mounted, said, held)
        if set_at is not None and set_at != mounted.set_at:
            raise _other(mounted, f"set at {time(set_at)}", f"set at {time(mounted.set_at)}")
        return mounted.setting
    if stated is None:
        return None
    stated = apart(stated, groove_corner)
    life = life_of(known, stated, at)
    if life is not None and (then := life.before(at)) is not None and then.ended is not None:
        raise ended(then, at)
    return Setting(stated, set_at)


def apart(edge: Edge, groove_corner: str | None) -> Edge:
    """Names an edge without a stated corner by its corner of a groove insert: the two differ in form."""
    return edge if edge.corner or groove_corner is None else replace(edge, corner=groove_corner)


def require_touches_since(setting: Setting, measured_at: datetime | None) -> None:
    """Raises EDG-SETTING for touches taken before the tool was set: its tip lies elsewhere now."""
    if measured_at is not None and setting.set_at is not None and measured_at < setting.set_at:
        raise Code.EDG_SETTING.refusal(
            f"{tool_name(setting.edge)} was set at {time(setting.set_at)}, after the touches of {time(measured_at)}",
            hint="cut the semi-finish pass with the tool as it is set now and touch it, or correct without memory",
            values={"set_at": time(setting.set_at), "measured_at": time(measured_at)},
        )


def ended(life: EdgeLife, at: datetime) -> TrueloopError:
    """Makes the refusal of a cut by an edge that is not mounted any more."""
    end = life.ended or life.events[-1]
    return Code.EDG_ENDED.refusal(
        f"{edge_name(life.edge)} was {end.kind} at {time(end.at)}, before this cut of {time(at)}",
        hint="name the edge that cut; `trueloop tool list` shows what is mounted",
        values={"edge": edge_name(life.edge), "ended_at": time(end.at)},
    )


def _mounted(
    edges: Sequence[EdgeLife], stated: Edge | None, number: int | None, at: datetime, machine: Machine | None
) -> EdgeLife | None:
    """By the number; without one by the holder that the job states."""
    mounted = in_pockets(edges, at, machine)
    if number is not None:
        mounted = tuple(life for life in mounted if life.edge.tool.number == number)
    else:
        name = "" if stated is None else stated.tool.name
        mounted = tuple(life for life in mounted if name and life.edge.tool.name == name)
    if len(mounted) > 1:
        raise several(mounted)
    return mounted[0] if mounted else None


def several(mounted: Sequence[EdgeLife]) -> TrueloopError:
    """Makes the refusal of a name that several mounted edges have."""
    name = tool_name(mounted[0].edge)
    return Code.EDG_POCKET.refusal(
        f"{len(mounted)} edges would be mounted as {name}: {'; '.join(map(where, mounted))}",
        hint="name the machine, in the job by programs.machine, at the command line by --machine; else remove one",
        values={"tool": name, "held": [where(life) for life in mounted]},
    )


def _names(edge: Edge) -> tuple[str, str, str]:
    return edge.tool.name, edge.insert, edge.corner


def _other(mounted: EdgeLife, text: str, held: str) -> TrueloopError:
    return Code.EDG_OTHER.refusal(
        f"the job states {text} for {tool_name(mounted.edge)}; by the store it is {held}",
        hint="correct [tool] of the job, or keep what happened to the tool: `trueloop tool mount`, `turn` or `set`",
        override="state the tool's number alone in [tool]",
        values={"stated": text, "mounted": held},
    )


NUMBER: Final = re.compile(r"[Tt]?(\d{1,6})")


def number_of(tool: str) -> int | None:
    """Returns the number of a tool that is called by it; None for a name."""
    found = NUMBER.fullmatch(tool.strip())
    return int(found[1]) if found else None


def mounted_as(edges: Sequence[EdgeLife], tool: str, at: datetime, machine: Machine | None = None) -> EdgeLife:
    """Returns the edge of a tool that is mounted at that time. Raises EDG-UNKNOWN with those that are, EDG-POCKET."""
    mounted = in_pockets(edges, at, machine)
    found = [life for life in mounted if _called(life.edge, tool)]
    if not found:
        raise _unknown(tool, mounted, "is mounted")
    if len(found) > 1:
        raise several(found) if number_of(tool) is not None else _named_alike(found, tool)
    return found[0]


def edges_of(
    edges: Sequence[EdgeLife],
    tool: str,
    corner: str | None = None,
    machine: Machine | None = None,
    cutting: Callable[[], Iterable[Edge]] = tuple,
) -> tuple[EdgeLife, ...]:
    """Returns all lives of a tool's edges, of one corner where it is named. `cutting` gives the edges of kept cuts:
    of one that was never mounted the refusal states how its cuts are shown.

    Raises EDG-UNKNOWN with those that there are, EDG-POCKET for a name by which several mounted tools go, as both
    corners of a groove insert.
    """
    own = [life for life in edges if _called(life.edge, tool) and (machine is None or life.of_machine(machine))]
    if not own:
        raise _unknown(tool, edges, "is in the store", [edge for edge in cutting() if _called(edge, tool)])
    found = tuple(life for life in own if corner is None or life.edge.corner == corner)
    if not found:
        corners = list(dict.fromkeys(life.edge.corner for life in own))
        raise Code.EDG_UNKNOWN.refusal(
            f"{tool_name(own[-1].edge)} has no corner {corner!r} in the store",
            hint=f"its corners there are {', '.join(map(repr, corners))}",
            values={"tool": tool, "known": corners},
        )
    mounted = [life for life in found if life.ended is None and life.until is None]
    if len({life.edge.tool.number for life in mounted}) > 1:
        raise _named_alike(mounted, tool)
    return found


def _named_alike(mounted: Sequence[EdgeLife], tool: str) -> TrueloopError:
    return Code.EDG_POCKET.refusal(
        f"{len(mounted)} mounted edges go by {tool!r}: {'; '.join(map(where, mounted))}",
        hint=f"name one by its number: {' or '.join(tool_name(life.edge) for life in mounted)}",
        values={"tool": tool, "held": [where(life) for life in mounted]},
    )


def _called(edge: Edge, tool: str) -> bool:
    number, own = number_of(tool), edge.tool
    return own.name == tool or (number is not None and own.number == number)


def _unknown(tool: str, others: Sequence[EdgeLife], what: str, cutting: Sequence[Edge] = ()) -> TrueloopError:
    names = list(dict.fromkeys(name for life in others for name in (tool_name(life.edge), life.edge.tool.name) if name))
    near = get_close_matches(tool, names, n=2)
    known = f"those that are: {', '.join(names)}" if names else "none is"
    return Code.EDG_UNKNOWN.refusal(
        f"no tool {tool!r} {what}; {known}",
        hint=_never_mounted(cutting)
        or (f"did you mean {' or '.join(near)}?" if near else "`trueloop tool mount` keeps a tool's edge"),
        values={"tool": tool, "known": names},
    )


def _never_mounted(cutting: Sequence[Edge]) -> str:
    """How the cuts of edges are shown that jobs alone have named; "" where there are none."""
    names = list(dict.fromkeys(map(edge_name, cutting)))
    if not names:
        return ""
    return (
        f"cuts by {' and '.join(names)} are kept, never mounted: `trueloop tool mount` with the same holder, insert "
        "and corner, and `--at` a time before them, shows what they taught"
    )


CLOCKS_DIFFER: Final = timedelta(minutes=1)
"""The clocks of two computers of a shop may differ by this much."""


@dataclass(frozen=True)
class Happened:
    """The fields that all events share: time, person, machine, and lengths and times by name."""

    at: datetime
    by: str = ""
    machine: Machine | None = None
    values: dict[str, float] = field(default_factory=dict)

    def to(self, edge: Edge, kind: EdgeEventKind, *, valued: bool = True) -> EdgeEvent:
        """Makes the event of an edge."""
        return EdgeEvent(
            edge=edge, kind=kind, at=self.at, by=self.by, values=self.values if valued else {}, machine=self.machine
        )


@dataclass(frozen=True)
class Mounting:
    """The edge mounted as `tool`. `nose_radius_mm` None: not stated. `again`: the same edge, removed before."""

    tool: str
    holder: str = ""
    insert: str = ""
    corner: str = ""
    nose_radius_mm: float | None = None
    again: bool = False


def mounting(edges: Sequence[EdgeLife], wanted: Mounting, happened: Happened) -> tuple[EdgeEvent, ...]:
    """Mounts a new insert, or with `again` one that was removed: then its form is known, its setting is not.

    What the same holder had in that pocket is removed with it. Raises EDG-POCKET for a pocket that holds another
    holder, or an edge that is mounted elsewhere, EDG-VALUE without nose radius, EDG-UNKNOWN for `again` of what was
    never mounted.
    """
    edge = _wanted_edge(edges, wanted)
    events = list[EdgeEvent]()
    for life in in_pockets(edges, happened.at, happened.machine):
        same_pocket = life.edge.tool.number == edge.tool.number and edge.tool.number is not None
        if not same_pocket and life.edge.identity != edge.identity:
            continue
        if not same_pocket or life.edge.tool.name != edge.tool.name:
            raise _held(life, edge)
        same_edge = life.edge.identity == edge.identity
        if not same_edge or (not wanted.again and life.began < happened.at):
            events.append(happened.to(life.edge, EdgeEventKind.REMOVED, valued=False))
    _require_free(edges, edge, happened)
    return (*events, happened.to(edge, EdgeEventKind.SET if wanted.again else EdgeEventKind.MOUNTED))


def turning(
    edges: Sequence[EdgeLife], tool: str, corner: str, happened: Happened, *, again: bool = False
) -> tuple[EdgeEvent, ...]:
    """Indexes the insert: `corner` cuts from now on, of which nothing is known unless it cut before (`again`).

    Raises EDG-CORNER for the corner that cuts already, and without `again` for one of this insert that did before.
    """
    life = mounted_as(edges, tool, happened.at, happened.machine)
    edge = replace(life.edge, corner=corner)
    used = [edge_life for edge_life in of_one_insert(edges, life) if edge_life.edge.corner == corner]
    if not corner or corner == life.edge.corner or (used and not again) or (again and not used):
        raise _corner(life, corner, used)
    begins = EdgeEventKind.SET if used else EdgeEventKind.MOUNTED
    return happened.to(life.edge, EdgeEventKind.TURNED, valued=False), happened.to(edge, begins)


def of_mounted(edges: Sequence[EdgeLife], tool: str, kind: EdgeEventKind, happened: Happened) -> tuple[EdgeEvent, ...]:
    """Returns the event of a mounted edge: set, wear measured, removed. Raises EDG-VALUE for wear without a value."""
    if kind is EdgeEventKind.WORN and not happened.values:
        raise Code.EDG_VALUE.refusal(
            f"0 values of the wear of {tool} are stated",
            hint="give --flank-mm, --minutes-in-cut or both",
            values={"name": "flank_wear_mm"},
        )
    return (happened.to(mounted_as(edges, tool, happened.at, happened.machine).edge, kind),)


def _wanted_edge(edges: Sequence[EdgeLife], wanted: Mounting) -> Edge:
    number = number_of(wanted.tool)
    name = wanted.holder or ("" if number is not None else wanted.tool)
    edge = Edge(Tool(number, name, wanted.nose_radius_mm), wanted.insert, wanted.corner)
    before = life_of(edges, edge)
    if wanted.again and before is None:
        raise Code.EDG_UNKNOWN.refusal(
            f"{edge_name(edge)} was never mounted: nothing is known that could hold again",
            hint="leave out --again; `trueloop tool list --all` shows every edge that was mounted",
            values={"tool": wanted.tool, "known": list(map(where, edges))},
        )
    if wanted.nose_radius_mm is None and wanted.again and before is not None:
        return replace(edge, tool=replace(edge.tool, corner_radius_mm=before.edge.tool.corner_radius_mm))
    if wanted.nose_radius_mm is None:
        raise Code.EDG_VALUE.refusal(
            f"nose_radius_mm of {edge_name(edge)} is missing",
            hint="give --nose-radius-mm: on the insert's box, RE of ISO 13399; 0 for a pointed tool",
            values={"name": "nose_radius_mm"},
        )
    return edge


def _require_free(edges: Sequence[EdgeLife], edge: Edge, happened: Happened) -> None:
    """An edge of these names must not cut elsewhere: what one learns would be taken for the other's."""
    for life in in_pockets(edges, happened.at):
        in_other_machine = happened.machine is not None and not life.of_machine(happened.machine)
        if life.edge.identity == edge.identity and in_other_machine:
            raise _held(life, edge)


def _held(life: EdgeLife, edge: Edge) -> TrueloopError:
    same = life.edge.identity == edge.identity
    hint = (
        "remove it there first; of two alike, name one otherwise: number the inserts or the holders"
        if same
        else f"remove it first: `trueloop tool remove {shell_word(tool_name(life.edge))}`; "
        "in another machine, use --machine"
    )
    return Code.EDG_POCKET.refusal(
        f"{edge_name(edge)} cannot be mounted: {where(life)} is, since {time(life.set_at)}",
        hint=hint,
        values={"tool": tool_name(edge), "held": [where(life)]},
    )


def _corner(life: EdgeLife, corner: str, used: Sequence[EdgeLife]) -> TrueloopError:
    name = tool_name(life.edge)
    if not corner:
        said, hint = f"{name}: the corner has no name", "name it as it is marked on the insert: --corner 2"
    elif corner == life.edge.corner:
        said = f"corner {corner!r} of {name} is already mounted, since {time(life.set_at)}"
        hint = f"name the new corner; for a new insert `trueloop tool mount {shell_word(name)}`"
    elif used:
        end = used[-1].events[-1]
        said = f"corner {corner!r} of {name} cut before, until {time(end.at)}"
        hint = (
            f"with --again its form is taken as it was then; for a new insert `trueloop tool mount {shell_word(name)}`"
        )
    else:
        said = f"corner {corner!r} of {name} never cut: nothing is known that could hold again"
        hint = "leave out --again"
    return Code.EDG_CORNER.refusal(said, hint=hint, values={"corner": corner})


Decide = Callable[[Sequence[EdgeLife]], tuple[EdgeEvent, ...]]


def keep_events(store: Store, decide: Decide, now: datetime, *, late: bool = False) -> tuple[EdgeEvent, ...]:
    """Keeps what `decide` makes of the lives known, all or none; gives the events, those that were kept before too.

    late: an event earlier than facts kept of the same tool is taken; cuts are then judged anew by all events.
    Raises EDG-TIME for events later than `now`, EDG-PAST without `late`, EDG-VALUE, EDG-POCKET, and STO errors.
    """
    known = lives_in(store)
    events = decide(known)
    for event in events:
        # Raises EDG-TIME for an event that has not happened yet by the clock
        if event.at > now + CLOCKS_DIFFER:
            raise Code.EDG_TIME.refusal(
                f"the event is of {time(event.at)}, and it is {time(now)} now",
                hint="an event is kept when it has happened: give its time by --at, or set this computer's clock",
                values={"at": time(event.at), "now": time(now)},
            )
        # Raises EDG-VALUE for anything that is not a finite number, and for a radius, wear or time below 0
        for name, value in dict(event.values).items():
            signed = name in ("x_mm", "z_mm")
            if not math.isfinite(value) or (value < 0 and not signed):
                raise Code.EDG_VALUE.refusal(
                    f"{name} is {value:g}",
                    hint="give a finite number" if signed else "give a finite number, 0 or more",
                    values={"name": name},
                )
    kept = {event.identity for life in known for event in life.events}
    new = [event for event in events if event.identity not in kept]
    if not late:
        _require_latest(store, known, new)
    _require_apart([*(event for life in known for event in life.events), *new], new)
    keep(store, new)
    return events


def cuts_of(store: Store, edge: Edge) -> tuple[Cut, ...]:
    """Returns the cuts by all edges of these names, oldest first as they were kept."""
    return tuple(kept.value for kept in find(store, Cut, edge=joined(edge.identity)))


def cuts_after_end(life: EdgeLife, cuts: Sequence[Cut]) -> Iterator[Finding]:
    """Yields EDG-ENDED for every cut that is stated to be by an edge turned away or removed at that time."""
    for cut in cuts:
        at = time_of(cut)
        if at is None or not life.holds(at):
            continue
        then = life.before(at)
        if then is not None and then.ended is not None:
            error = ended(then, at)
            message = f"part {part_name(cut)}: {error.message}"
            yield Finding(Severity.WARNING, error.code, message, error.hint, values=error.values)


def part_name(cut: Cut) -> str:
    """Returns part type and serial number, as far as they are stated."""
    return " ".join(text for text in cut.part.identity if text)


def _require_latest(store: Store, edges: Sequence[EdgeLife], new: Sequence[EdgeEvent]) -> None:
    for event in new:
        later = [
            (edge_event.at, f"{edge_event.kind} of {edge_name(edge_event.edge)}")
            for life in edges
            for edge_event in life.events
            if _one_tool(edge_event, event) and edge_event.at > event.at
        ]
        for cut in cuts_of(store, event.edge):
            at = time_of(cut)
            if at is not None and at > event.at:
                later.append((at, f"{cut.stage} cut of part {part_name(cut)}"))
        if later:
            raise _past(event, *max(later))


def _past(event: EdgeEvent, at: datetime, what: str) -> TrueloopError:
    return Code.EDG_PAST.refusal(
        f"{tool_name(event.edge)} {event.kind} at {time(event.at)} is before what is kept already: {what}, {time(at)}",
        hint="look at the time, at the clock, and at `trueloop tool show`",
        override="--late takes it: cuts are then judged by the edge and the setting of their time",
        values={"at": time(event.at), "kept_at": time(at)},
    )


def _one_tool(one: EdgeEvent, other: EdgeEvent) -> bool:
    if one.edge.identity == other.edge.identity:
        return True
    a, b = one.edge.tool.number, other.edge.tool.number
    machines = {event.machine.name for event in (one, other) if event.machine is not None}
    return a is not None and a == b and len(machines) < 2


def _require_apart(events: Sequence[EdgeEvent], new: Sequence[EdgeEvent]) -> None:
    """Two tools in one pocket, at the time of the new events or of any later one: a late event may make it so."""
    together = lives(events)
    first = min((event.at for event in new), default=None)
    for event in events:
        if first is None or event.at < first:
            continue
        then = in_pockets(together, event.at, event.machine)
        own = life_of(then, event.edge)
        same = [life for life in then if own is not None and _one_tool(life.events[-1], own.events[-1])]
        if len(same) > 1:
            raise several(same)


def with_edge(store: Store, inputs: Inputs) -> Inputs:
    """Returns the job with its edge and setting as the store knows them; unchanged where neither names the edge.

    The finish cut of touches after a semi-finish cut is still to be made: the edge is the one that is mounted as the
    correction is made. That of a finished part was made before its touches. Raises EDG errors, EDG-SETTING for touches
    of a semi-finished part that are older than the setting.
    """
    stated, number = inputs.edge, inputs.options.tool
    measured = [inspection.measured_at for inspection in inputs.inspections if inspection.measured_at is not None]
    finished = inputs.measured_finished
    at: datetime = min(measured) if finished and measured else inputs.made_at
    corner = None if inputs.called is None else inputs.called.corner
    setting = edge_of(
        store, stated, number, at, set_at=inputs.edge_set_at, machine=inputs.machine_tool, groove_corner=corner
    )
    if setting is None:
        return inputs
    if not finished and inputs.edge_set_at is None:
        require_touches_since(setting, min(measured, default=None))
    return replace(inputs, edge=_as_mounted(setting.edge, stated), edge_set_at=setting.set_at)


def _as_mounted(edge: Edge, stated: Edge | None) -> Edge:
    """The mounted edge; of the tool nothing that the job does not state itself, as the record has the job's radius."""
    number = edge.tool.number if stated is None or stated.tool.number is None else stated.tool.number
    return replace(edge, tool=Tool(number, edge.tool.name))
