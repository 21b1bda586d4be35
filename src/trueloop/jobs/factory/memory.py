"""The memory of a tool's edge, as it is shown: computed from its parts, never kept."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from trueloop.domain.tool import Edge
from trueloop.errors import TrueloopError
from trueloop.factory.known import unknown
from trueloop.factory.shown.machines import tool_rows
from trueloop.factory.views.series import MemoryCurve, MemoryPoint, NextPart, ToolEvent, ToolMemory, ToolRow
from trueloop.jobs.store.tool_history import history_of_tool
from trueloop.jobs.tool_life import angles_deg
from trueloop.jobs.tools import lives_in
from trueloop.memory.edge.expect import expect
from trueloop.memory.edge.learnt import Learned, Learnt, learnt
from trueloop.memory.edge.options import MemoryOptions
from trueloop.memory.made_part import MadePart
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.statistics import NORMAL_95
from trueloop.storage.store import Store, find
from trueloop.units import UM_PER_MM

OPTIONS: Final = MemoryOptions()


def tool_memory(store: Store, row: int, say: Texts = ENGLISH) -> ToolMemory:
    """Returns an edge's errors over the contact angle, by the number of its row, and what a next part would need.

    Raises FAC-UNKNOWN, and what the store's records refuse.
    """
    tool = next((one for one in tool_rows(store) if one.id == row), None)
    edge: Edge | None = next((one.value for one in find(store, Edge) if one.row == row), None)
    if tool is None or edge is None:
        raise unknown("tool", str(row), "the store has no edge in that row")
    parts = history_of_tool(store, edge)
    history = [one for one in parts if one.order >= 0]
    found = learnt(history, np.radians(angles_deg(history))) if history else None
    return _view(tool, parts, found, _events(store, edge), say)


def _events(store: Store, edge: Edge) -> tuple[ToolEvent, ...]:
    of_edge = [life for life in lives_in(store) if life.edge.identity == edge.identity]
    every = [event for life in of_edge for event in life.events]
    return tuple(ToolEvent(one.at, str(one.kind), one.by, dict(one.values)) for one in every)


def _view(
    tool: ToolRow, parts: Sequence[MadePart], found: Learnt | None, events: tuple[ToolEvent, ...], say: Texts
) -> ToolMemory:
    """Returns the page of an edge: of `parts` it shows its own, and predicts from those of earlier edges as well."""
    history = [one for one in parts if one.order >= 0]
    if found is None:
        return ToolMemory(tool, (), (), (), (), len(history), 0, (), (), (), events)
    types = list(found.in_all)
    return ToolMemory(
        tool,
        tuple(np.degrees(found.contact_angle_rad).tolist()),
        tuple((found.nearest_rad <= OPTIONS.unseen_rad).tolist()),
        (_curve("", found.form), *(_curve(name, found.in_all[name]) for name in types)),
        tuple(_points(found)),
        *(found.parts, found.inspected),
        tuple((UM_PER_MM * found.setting_mm).tolist()),
        tuple((NORMAL_95 * UM_PER_MM * found.setting_u_mm).tolist()),
        tuple(_next(parts, name, say) for name in types),
        events,
    )


def _curve(name: str, term: Learned) -> MemoryCurve:
    error, band = UM_PER_MM * term.mean_mm, NORMAL_95 * UM_PER_MM * term.u_mm
    return MemoryCurve(name, tuple(error.tolist()), tuple(band.tolist()))


def _points(found: Learnt) -> Iterator[MemoryPoint]:
    """How the parts scatter about the form (touches) and about the finish error of their type (inspections)."""
    behind = found.behind
    about = np.where(behind.finish, found.in_all_at_mm, found.form_at_mm) + behind.left_mm
    rows = zip(
        *(behind.part_type, behind.serial, behind.finish.tolist(), np.degrees(behind.contact_angle_rad).tolist()),
        (UM_PER_MM * about).tolist(),
        strict=True,
    )
    return (MemoryPoint(*row) for row in rows)


def _next(history: Sequence[MadePart], part_type: str, say: Texts) -> NextPart:
    """Of a next part that is touched where the last one of its type was. Which values are found there does not matter
    to how well the rest is known.
    """
    last = next(part for part in reversed(history) if part.part_type == part_type)
    after = max(part.order for part in history) + 1.0
    today = replace(last, serial="", order=after, setting=history[-1].setting, finish=None, correction_mm=None)
    asked = last.semifinish if last.finish is None else last.finish
    of = len(today.semifinish.error_mm)
    try:
        expected = expect(history, today, asked, OPTIONS)
    except TrueloopError as refused:
        return NextPart(part_type, of, of, None, f"{refused.code}: {refused.message}", ())
    left_um = UM_PER_MM * float(np.sqrt(np.mean(np.diag(expected.covariance_mm2))))
    return NextPart(part_type, expected.enough_touches, of, left_um, "", tuple(map(say.note, expected.notes)))
