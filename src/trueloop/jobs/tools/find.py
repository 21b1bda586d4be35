"""Tools and edges by what a user calls them: T3, 3, or the holder's name."""

import re
from collections.abc import Callable, Iterable, Sequence
from datetime import datetime
from difflib import get_close_matches
from typing import Final

from trueloop.domain.edge_life import EdgeLife, in_pockets
from trueloop.domain.edge_names import edge_name, tool_name, where
from trueloop.domain.machine import Machine
from trueloop.domain.tool import Edge
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.tools.edge import several

NUMBER: Final = re.compile(r"[Tt]?(\d{1,6})")


def number_of(tool: str) -> int | None:
    """The number of a tool that is called by it; None for a name."""
    found = NUMBER.fullmatch(tool.strip())
    return int(found[1]) if found else None


def mounted_as(known: Sequence[EdgeLife], tool: str, at: datetime, machine: Machine | None = None) -> EdgeLife:
    """The edge of a tool that is mounted at that time. Raises EDG-UNKNOWN with those that are, EDG-POCKET."""
    mounted = in_pockets(known, at, machine)
    found = [life for life in mounted if _called(life.edge, tool)]
    if not found:
        raise _unknown(tool, mounted, "is mounted")
    if len(found) > 1:
        raise several(found) if number_of(tool) is not None else _named_alike(found, tool)
    return found[0]


def edges_of(
    known: Sequence[EdgeLife],
    tool: str,
    corner: str | None = None,
    machine: Machine | None = None,
    cutting: Callable[[], Iterable[Edge]] = tuple,
) -> tuple[EdgeLife, ...]:
    """All lives of a tool's edges, of one corner where it is named. `cutting` gives the edges that kept cuts are by:
    of one that was never mounted the refusal says how its cuts are shown.

    Raises EDG-UNKNOWN with those that there are, EDG-POCKET for a name by which several mounted tools go, as both
    corners of a groove insert.
    """
    own = [life for life in known if _called(life.edge, tool) and (machine is None or life.of_machine(machine))]
    if not own:
        raise _unknown(tool, known, "is in the store", [edge for edge in cutting() if _called(edge, tool)])
    found = tuple(life for life in own if corner is None or life.edge.corner == corner)
    if not found:
        corners = list(dict.fromkeys(life.edge.corner for life in own))
        raise TrueloopError(
            Code.EDG_UNKNOWN,
            f"{tool_name(own[-1].edge)} has no corner {corner!r} in the store",
            hint=f"its corners there are {', '.join(map(repr, corners))}",
            values={"tool": tool, "known": corners},
        )
    mounted = [life for life in found if life.ended is None and life.until is None]
    if len({life.edge.tool.number for life in mounted}) > 1:
        raise _named_alike(mounted, tool)
    return found


def _named_alike(mounted: Sequence[EdgeLife], tool: str) -> TrueloopError:
    return TrueloopError(
        Code.EDG_POCKET,
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
    return TrueloopError(
        Code.EDG_UNKNOWN,
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
