"""Events of tools kept in the store: decided by what is known, refused where they contradict it."""

from collections.abc import Callable, Iterator, Sequence
from datetime import datetime

from trueloop.domain.edge_life import EdgeLife, in_pockets, life_of, lives, time_of
from trueloop.domain.edge_names import edge_name, time, tool_name
from trueloop.domain.life import Cut, EdgeEvent
from trueloop.domain.tool import Edge
from trueloop.errors import Code, Finding, Severity, TrueloopError
from trueloop.jobs.tools.edge import ended, lives_in, several
from trueloop.jobs.tools.events import require_time, require_values
from trueloop.storage.kinds import joined
from trueloop.storage.store import Store, find, keep

Decide = Callable[[Sequence[EdgeLife]], tuple[EdgeEvent, ...]]


def keep_events(store: Store, decide: Decide, now: datetime, *, late: bool = False) -> tuple[EdgeEvent, ...]:
    """Keeps what `decide` makes of the lives known, all or none; gives the events, those that were kept before too.

    late: an event earlier than facts kept of the same tool is taken; cuts are then judged anew by all events.
    Raises EDG-TIME for events later than `now`, EDG-PAST without `late`, EDG-VALUE, EDG-POCKET, and STO errors.
    """
    known = lives_in(store)
    events = decide(known)
    for event in events:
        require_time(event.at, now)
        require_values(dict(event.values))
    kept = {event.identity for life in known for event in life.events}
    new = [event for event in events if event.identity not in kept]
    if not late:
        _require_latest(store, known, new)
    _require_apart([*(event for life in known for event in life.events), *new], new)
    keep(store, new)
    return events


def cuts_of(store: Store, edge: Edge) -> tuple[Cut, ...]:
    """The cuts by all edges of these names, oldest first as they were kept."""
    return tuple(kept.value for kept in find(store, Cut, edge=joined(edge.identity)))


def cuts_after_end(life: EdgeLife, cuts: Sequence[Cut]) -> Iterator[Finding]:
    """EDG-ENDED for every cut that is said to be by an edge which was turned away or removed at that time."""
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
    """Part type and serial number, as far as they are stated."""
    return " ".join(text for text in cut.part.identity if text)


def _require_latest(store: Store, known: Sequence[EdgeLife], new: Sequence[EdgeEvent]) -> None:
    for event in new:
        later = [
            (one.at, f"{one.kind} of {edge_name(one.edge)}")
            for life in known
            for one in life.events
            if _one_tool(one, event) and one.at > event.at
        ]
        for cut in cuts_of(store, event.edge):
            at = time_of(cut)
            if at is not None and at > event.at:
                later.append((at, f"{cut.stage} cut of part {part_name(cut)}"))
        if later:
            raise _past(event, *max(later))


def _past(event: EdgeEvent, at: datetime, what: str) -> TrueloopError:
    return TrueloopError(
        Code.EDG_PAST,
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
