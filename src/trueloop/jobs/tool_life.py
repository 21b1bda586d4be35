"""A tool's edge out of the store, with what it has taught, as it is shown."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.life import Cut, EdgeLife, time_of
from trueloop.domain.tool import Edge, Machine
from trueloop.jobs.store.history import history_of
from trueloop.jobs.tools import cuts_after_end, cuts_of, edges_of, lives_in
from trueloop.memory.edge.learnt import learnt
from trueloop.memory.edge.options import MemoryOptions
from trueloop.memory.made_part import MadePart
from trueloop.report.tool import ShownEdge
from trueloop.storage.store import Store, find

BEYOND_DEG: Final = 20
"""So far beyond the angles seen, what was learnt is shown too, in grey."""


def shown_edge(store: Store, tool: str, corner: str | None = None, machine: Machine | None = None) -> ShownEdge:
    """Returns the edge of a tool mounted last, or its `corner`. Raises EDG-UNKNOWN with those that there are."""
    life = latest(edges_of(lives_in(store), tool, corner, machine, lambda: edges_that_cut(store)))
    every = cuts_of(store, life.edge)
    cuts = tuple(cut for cut in every if (at := time_of(cut)) is None or life.holds(at))
    history = history_of(store, life.edge)
    found = learnt(history, np.radians(angles_deg(history))) if history else None
    findings = tuple(cuts_after_end(life, cuts))
    return ShownEdge(life, cuts, found, findings, minutes_in_cut(life, cuts), MemoryOptions().unseen_rad)


def edges_that_cut(store: Store) -> list[Edge]:
    """Returns the edges that kept cuts are by, whether they were ever mounted or not."""
    settings = [kept.value.setting for kept in find(store, Cut)]
    return list(dict.fromkeys(setting.edge for setting in settings if setting is not None))


def listed(store: Store, machine: Machine | None, *, every: bool) -> tuple[EdgeLife, ...]:
    """Lists the edges that are mounted, or all that ever were, by tool number."""
    known = [life for life in lives_in(store) if machine is None or life.of_machine(machine)]
    chosen = known if every else [life for life in known if life.ended is None and life.until is None]
    return tuple(sorted(chosen, key=lambda life: (life.edge.tool.number or 0, life.began)))


def latest(known: Sequence[EdgeLife]) -> EdgeLife:
    """Returns the life with the latest event; of several at one time that which goes on."""
    return max(known, key=lambda life: (life.events[-1].at, life.ended is None))


def minutes_in_cut(life: EdgeLife, cuts: Sequence[Cut]) -> float | None:
    """Returns how long an edge has cut, min: as stated last with its wear, and by the cuts since; None: not stated."""
    stated = [event for event in life.events if "minutes_in_cut" in event.values]
    base, since = (stated[-1].values["minutes_in_cut"], stated[-1].at) if stated else (0.0, life.began)
    later = [cut for cut in cuts if (at := time_of(cut)) is None or at >= since]
    own = [cut.conditions.time_in_cut_min for cut in later]
    times = [minutes for minutes in own if minutes is not None]
    return None if not stated and not times else base + sum(times)


def angles_deg(history: Sequence[MadePart]) -> Array:
    """Returns whole degrees about the angles seen."""
    errors = [part.semifinish for part in history] + [part.finish for part in history if part.finish is not None]
    seen = np.degrees(np.concatenate([one.contact_angle_rad for one in errors]))
    if len(seen) == 0:
        return np.empty(0)
    low, high = np.floor(seen.min()) - BEYOND_DEG, np.ceil(seen.max()) + BEYOND_DEG
    return np.arange(low, high + 0.5)
