"""Which edge cuts: as the job states it and as the store knows what is mounted."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import datetime

from trueloop.domain.edge_life import EdgeLife, in_pockets, life_of, lives
from trueloop.domain.edge_names import edge_name, time, tool_name, where
from trueloop.domain.life import EdgeEvent
from trueloop.domain.machine import Machine
from trueloop.domain.tool import Edge, Setting
from trueloop.errors import Code, TrueloopError
from trueloop.storage.store import Store, find

STATED = ("holder", "insert", "corner")


def lives_in(store: Store) -> tuple[EdgeLife, ...]:
    """The lives of all edges that the store has events of."""
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
    """The edge that cuts with tool `number` at that time, and when it was set.

    Where the tool is mounted in the store, a job may state its number alone; what it states besides has to agree.
    Where the store has no event of the tool, the job's word counts, `set_at` and `groove_corner` with it. None where
    neither says which edge cuts. Raises EDG-OTHER for a job that contradicts the store, EDG-ENDED for an edge that was
    turned away or removed before, EDG-POCKET for a number in several machines.
    """
    known = lives_in(store)
    mounted = _mounted(known, stated, number, at, machine)
    if mounted is not None:
        _require_same(mounted, stated, set_at)
        return mounted.setting
    if stated is None:
        return None
    stated = apart(stated, groove_corner)
    life = life_of(known, stated, at)
    if life is not None and (then := life.before(at)) is not None and then.ended is not None:
        raise ended(then, at)
    return Setting(stated, set_at)


def apart(edge: Edge, groove_corner: str | None) -> Edge:
    """An edge as a job states it, by its corner of a groove insert where it names none: the two corners are two edges,
    whose forms must not be taken for each other's.
    """
    return edge if edge.corner or groove_corner is None else replace(edge, corner=groove_corner)


def require_touches_since(setting: Setting, measured_at: datetime | None) -> None:
    """Raises EDG-SETTING for touches taken before the tool was set: they do not tell where its tip lies now."""
    if measured_at is not None and setting.set_at is not None and measured_at < setting.set_at:
        raise TrueloopError(
            Code.EDG_SETTING,
            f"{tool_name(setting.edge)} was set at {time(setting.set_at)}, after the touches of {time(measured_at)}",
            hint="cut the semi-finish pass with the tool as it is set now and touch it, or correct without memory",
            values={"set_at": time(setting.set_at), "measured_at": time(measured_at)},
        )


def ended(life: EdgeLife, at: datetime) -> TrueloopError:
    """The refusal of a cut by an edge that is not mounted any more."""
    end = life.ended or life.events[-1]
    return TrueloopError(
        Code.EDG_ENDED,
        f"{edge_name(life.edge)} was {end.kind} at {time(end.at)}, before this cut of {time(at)}",
        hint="name the edge that cut; `trueloop tool list` shows what is mounted",
        values={"edge": edge_name(life.edge), "ended_at": time(end.at)},
    )


def _mounted(
    known: Sequence[EdgeLife], stated: Edge | None, number: int | None, at: datetime, machine: Machine | None
) -> EdgeLife | None:
    """By the number; without one by the holder that the job states."""
    mounted = in_pockets(known, at, machine)
    if number is not None:
        mounted = tuple(life for life in mounted if life.edge.tool.number == number)
    else:
        name = "" if stated is None else stated.tool.name
        mounted = tuple(life for life in mounted if name and life.edge.tool.name == name)
    if len(mounted) > 1:
        raise several(mounted)
    return mounted[0] if mounted else None


def several(mounted: Sequence[EdgeLife]) -> TrueloopError:
    """The refusal of a name that several mounted edges have."""
    name = tool_name(mounted[0].edge)
    return TrueloopError(
        Code.EDG_POCKET,
        f"{len(mounted)} edges would be mounted as {name}: {'; '.join(map(where, mounted))}",
        hint="name the machine, in the job by programs.machine, at the command line by --machine; else remove one",
        values={"tool": name, "held": [where(life) for life in mounted]},
    )


def _require_same(mounted: EdgeLife, stated: Edge | None, set_at: datetime | None) -> None:
    """What a job states has to agree with what is mounted; what it leaves open agrees."""
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


def _names(edge: Edge) -> tuple[str, str, str]:
    return edge.tool.name, edge.insert, edge.corner


def _other(mounted: EdgeLife, said: str, held: str) -> TrueloopError:
    return TrueloopError(
        Code.EDG_OTHER,
        f"the job states {said} for {tool_name(mounted.edge)}; by the store it is {held}",
        hint="correct [tool] of the job, or keep what happened to the tool: `trueloop tool mount`, `turn` or `set`",
        override="state the tool's number alone in [tool]",
        values={"stated": said, "mounted": held},
    )
