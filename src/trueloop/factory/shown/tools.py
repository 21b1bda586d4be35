"""Edges of tools in a list."""

from sqlalchemy import func, select

from trueloop.domain.tool import Edge, Setting
from trueloop.factory.load import Known
from trueloop.factory.shown.paging import known_of
from trueloop.factory.views.series import ToolRow
from trueloop.storage.kinds import joined, kind_of, searchable
from trueloop.storage.reading import Query, found
from trueloop.storage.store import Store
from trueloop.storage.tables import TABLES


def tool_rows(store: Store) -> tuple[ToolRow, ...]:
    """All edges; `parts`: how many parts each has cut."""
    cut = TABLES["cut"]
    with known_of(store) as known:
        count = select(cut.c.edge, func.count(cut.c.serial.distinct())).where(cut.c.edge.is_not(None))
        parts = dict(known.rows(count.group_by(cut.c.edge)))
        settings = _settings(known)
        edges = list(found(known.connection, known.codec, Query(kind_of(Edge))))
    rows = []
    for one in edges:
        edge: Edge = one.value
        key = searchable(joined(edge.identity)) or ""
        set_at = None if key not in settings else settings[key].set_at
        insert = " ".join(filter(None, (edge.insert, edge.corner)))
        rows.append(
            ToolRow(one.row, edge.tool.identity[0], insert, edge.tool.corner_radius_mm, set_at, parts.get(key, 0))
        )
    return tuple(rows)


def _settings(known: Known) -> dict[str, Setting]:
    """The latest of each edge."""
    every: list[Setting] = known.values(Setting)
    dated = sorted((one for one in every if one.set_at is not None), key=lambda one: str(one.set_at))
    return {searchable(joined(one.edge.identity)) or "": one for one in dated}
