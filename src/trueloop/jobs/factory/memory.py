"""What a tool's edge remembers, as it is shown: worked out from its parts, never kept."""

import numpy as np

from trueloop.domain.tool import Edge
from trueloop.factory.known import unknown
from trueloop.factory.shown.tools import tool_rows
from trueloop.factory.views.series import ToolMemory
from trueloop.jobs.store.history import history_of
from trueloop.jobs.tool_life import angles_deg
from trueloop.jobs.tools.edge import lives_in
from trueloop.memory.edge.learnt import learnt
from trueloop.report.tool.summary import event_line
from trueloop.storage.store import Store, find
from trueloop.units import UM_PER_MM

COVERAGE = 1.96
"""Of a 95 % band."""


def tool_memory(store: Store, row: int) -> ToolMemory:
    """The form of an edge over the contact angle, by the number of its row. Raises FAC-UNKNOWN."""
    tool = next((one for one in tool_rows(store) if one.id == row), None)
    edge: Edge | None = next((one.value for one in find(store, Edge) if one.row == row), None)
    if tool is None or edge is None:
        raise unknown("tool", str(row), "the store has no edge in that row")
    history = history_of(store, edge)
    events = tuple(
        event_line(event) for life in lives_in(store) if life.edge.identity == edge.identity for event in life.events
    )
    angles = angles_deg(history) if history else np.array([])
    found = learnt(history, np.radians(angles)) if history else None
    if found is None:
        return ToolMemory(tool, (), (), (), len(history), events)
    error, band = found.form.mean_mm * UM_PER_MM, COVERAGE * found.form.u_mm * UM_PER_MM
    return ToolMemory(tool, tuple(angles.tolist()), tuple(error.tolist()), tuple(band.tolist()), len(history), events)
