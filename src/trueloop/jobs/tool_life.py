"""A tool's edge out of the store with what it has taught, as it is shown: computed from its parts, never kept."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.life import Cut, EdgeLife, time_of
from trueloop.domain.tool import Edge, Machine
from trueloop.errors import TrueloopError
from trueloop.factory.known import unknown
from trueloop.factory.shown.machines import tool_rows
from trueloop.factory.views.series import MemoryCurve, MemoryPoint, NextPart, ToolEvent, ToolMemory, ToolRow
from trueloop.jobs.store.history import history_of
from trueloop.jobs.store.tool_history import history_of_tool
from trueloop.jobs.tools import cuts_after_end, cuts_of, edges_of, lives_in
from trueloop.memory.edge.learnt import EdgeKnowledge, Learned, MemoryOptions, learnt
from trueloop.memory.edge.predict import expect
from trueloop.memory.made_part import MadePart
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.report.tool import ShownEdge
from trueloop.statistics import NORMAL_95
from trueloop.storage.store import Store, find
from trueloop.units import UM_PER_MM

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
    return ShownEdge(
        life=life,
        cuts=cuts,
        learnt=found,
        findings=findings,
        minutes_in_cut=minutes_in_cut(life, cuts),
        unseen_rad=MemoryOptions().unseen_rad,
    )


def edges_that_cut(store: Store) -> list[Edge]:
    """Returns the edges that kept cuts are by, whether they were ever mounted or not."""
    settings = [kept.value.setting for kept in find(store, Cut)]
    return list(dict.fromkeys(setting.edge for setting in settings if setting is not None))


def listed(store: Store, machine: Machine | None, *, every: bool) -> tuple[EdgeLife, ...]:
    """Lists the edges that are mounted, or all that ever were, by tool number."""
    known = [life for life in lives_in(store) if machine is None or life.of_machine(machine)]
    chosen = known if every else [life for life in known if life.ended is None and life.until is None]
    return tuple(sorted(chosen, key=lambda life: (life.edge.tool.number or 0, life.began)))


def latest(edges: Sequence[EdgeLife]) -> EdgeLife:
    """Returns the life with the latest event; of several at one time that which goes on."""
    return max(edges, key=lambda life: (life.events[-1].at, life.ended is None))


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
    seen = np.degrees(np.concatenate([error.contact_angle_rad for error in errors]))
    if len(seen) == 0:
        return np.empty(0)
    low, high = np.floor(seen.min()) - BEYOND_DEG, np.ceil(seen.max()) + BEYOND_DEG
    return np.arange(low, high + 0.5)


OPTIONS: Final = MemoryOptions()


def tool_memory(store: Store, row: int, say: Texts = ENGLISH) -> ToolMemory:
    """Returns an edge's errors by contact angle, and what a next part needs. Raises FAC-UNKNOWN, and the records'."""
    tool = next((tool_row for tool_row in tool_rows(store) if tool_row.id == row), None)
    edge: Edge | None = next((stored.value for stored in find(store, Edge) if stored.row == row), None)
    if tool is None or edge is None:
        raise unknown("tool", str(row), "the store has no edge in that row")
    parts = history_of_tool(store, edge)
    history = [part for part in parts if part.order >= 0]
    found = learnt(history, np.radians(angles_deg(history))) if history else None
    of_edge = [life for life in lives_in(store) if life.edge.identity == edge.identity]
    every = [event for life in of_edge for event in life.events]
    return _view(
        tool,
        parts,
        found,
        tuple(
            ToolEvent(edge_event.at, str(edge_event.kind), edge_event.by, dict(edge_event.values))
            for edge_event in every
        ),
        say,
    )


def _view(
    tool: ToolRow, parts: Sequence[MadePart], knowledge: EdgeKnowledge | None, events: tuple[ToolEvent, ...], say: Texts
) -> ToolMemory:
    """Returns the page of an edge: of `parts` it shows its own, and predicts from those of earlier edges as well."""
    history = [part for part in parts if part.order >= 0]
    if knowledge is None:
        return ToolMemory(
            tool=tool,
            contact_angle_deg=(),
            seen=(),
            curves=(),
            points=(),
            parts=len(history),
            inspected=0,
            setting_um=(),
            setting_band_um=(),
            next_parts=(),
            events=events,
        )
    types = list(knowledge.in_all)
    return ToolMemory(
        tool=tool,
        contact_angle_deg=tuple(np.degrees(knowledge.contact_angle_rad).tolist()),
        seen=tuple((knowledge.nearest_rad <= OPTIONS.unseen_rad).tolist()),
        curves=(_curve("", knowledge.form), *(_curve(name, knowledge.in_all[name]) for name in types)),
        points=tuple(_points(knowledge)),
        parts=knowledge.parts,
        inspected=knowledge.inspected,
        setting_um=tuple((UM_PER_MM * knowledge.setting_mm).tolist()),
        setting_band_um=tuple((NORMAL_95 * UM_PER_MM * knowledge.setting_u_mm).tolist()),
        next_parts=tuple(_next(parts, name, say) for name in types),
        events=events,
    )


def _curve(name: str, term: Learned) -> MemoryCurve:
    error, band = UM_PER_MM * term.mean_mm, NORMAL_95 * UM_PER_MM * term.u_mm
    return MemoryCurve(name, tuple(error.tolist()), tuple(band.tolist()))


def _points(knowledge: EdgeKnowledge) -> Iterator[MemoryPoint]:
    """How the parts scatter about the form (touches) and about the finish error of their type (inspections)."""
    behind = knowledge.behind
    about = np.where(behind.finish, knowledge.in_all_at_mm, knowledge.form_at_mm) + behind.left_mm
    rows = zip(
        *(behind.part_type, behind.serial, behind.finish.tolist(), np.degrees(behind.contact_angle_rad).tolist()),
        (UM_PER_MM * about).tolist(),
        strict=True,
    )
    return (MemoryPoint(*row) for row in rows)


def _next(history: Sequence[MadePart], part_type: str, say: Texts) -> NextPart:
    """Returns vectors of a next part, touched where the last part of its type was; their values do not count."""
    last = next(part for part in reversed(history) if part.part_type == part_type)
    after = max(part.order for part in history) + 1.0
    today = replace(last, serial="", order=after, setting=history[-1].setting, finish=None, correction_mm=None)
    asked = last.semifinish if last.finish is None else last.finish
    of = len(today.semifinish.error_mm)
    try:
        expected = expect(history, today, asked, OPTIONS)
    except TrueloopError as refused:
        return NextPart(
            part_type=part_type, touches=of, of=of, left_um=None, refusal=f"{refused.code}: {refused.message}", notes=()
        )
    left_um = UM_PER_MM * float(np.sqrt(np.mean(np.diag(expected.covariance_mm2))))
    return NextPart(
        part_type=part_type,
        touches=expected.enough_touches,
        of=of,
        left_um=left_um,
        refusal="",
        notes=tuple(map(say.note, expected.notes)),
    )
