"""The row of a tool table that a tool's offset is kept in."""

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.tables.tool_tables.tool_table import Kind, ToolRow, ToolTable


def row_of(table: ToolTable, tool: int, edge: int = 1, name: str = "") -> ToolRow:
    """The tool's row of wear where the table has one with places for x or z, else that of its geometry.

    Raises OFS-TOOL (no such tool or edge), OFS-ROWS (two rows of one kind) and OFS-NAME (a tool of another name).
    """
    rows = [row for row in table.rows if (row.tool, row.edge) == (tool, edge)]
    if not rows:
        raise _missing(table, tool, edge)
    if name and name.casefold() != rows[0].name.casefold():
        raise TrueloopError(
            Code.OFS_NAME,
            f"tool {tool} of the table is {rows[0].name!r}, not {name!r}",
            hint="the magazine was loaded anew, or `tool.number` is another's: compare them at the control",
            place=table.place(rows[0]),
            values={"tool": float(tool), "expected": name, "found": rows[0].name},
        )
    wear = _only(table, [row for row in rows if row.kind == "wear"])
    geometry = _only(table, [row for row in rows if row.kind == "geometry"])
    found = wear if wear is not None and (wear.x or wear.z) else geometry
    if found is None or not (found.x or found.z):
        raise TrueloopError(
            Code.OFS_ROW,
            f"tool {tool} has no offsets along x and z in the table: it is no turning tool there",
            hint="name the turning tool's number, or the table of turning tools",
            place=table.place(rows[0]),
        )
    return found


def geometry_of(table: ToolTable, row: ToolRow) -> ToolRow:
    """The row that holds the nose of the same tool and edge."""
    same = (one for one in table.rows if (one.tool, one.edge) == (row.tool, row.edge) and _has_nose(one))
    return next(iter(sorted(same, key=_is_wear)), row)


def _has_nose(row: ToolRow) -> bool:
    return row.nose is not None


def _is_wear(row: ToolRow) -> bool:
    kinds: tuple[Kind, Kind] = ("geometry", "wear")
    return bool(kinds.index(row.kind))


def _only(table: ToolTable, rows: list[ToolRow]) -> ToolRow | None:
    if len(rows) > 1:
        lines = [str(row.line) for row in rows]
        raise TrueloopError(
            Code.OFS_ROWS,
            f"tool {rows[0].tool} has {len(rows)} rows of {rows[0].kind}, in lines {', '.join(lines)}",
            hint="keep the one that is in force",
            place=table.place(rows[1]),
            values={"tool": float(rows[0].tool), "lines": lines},
        )
    return rows[0] if rows else None


def _missing(table: ToolTable, tool: int, edge: int) -> TrueloopError:
    known = sorted({row.tool for row in table.rows})
    shown = ", ".join(map(str, known[:20])) + (", …" if len(known) > 20 else "")
    what = f"tool {tool}" + (f", edge {edge}" if edge != 1 else "")
    return TrueloopError(
        Code.OFS_TOOL,
        f"the table has no {what}; it has {len(known)} tools: {shown}",
        hint="`tool.number` of the job names the tool's offset; else the T word of the finish pass does",
        place=Place(str(table.path)),
        values={"tool": float(tool)},
    )
