"""The tool tables that are known, and a file read by whichever of them recognises it."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from decimal import ROUND_HALF_EVEN, Decimal
from pathlib import Path
from typing import Final, Literal, TypeAlias

from trueloop.domain.proposal import HeldTool, TableRow, ToolOffset
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import read_input
from trueloop.formats.tables.tool_tables import fanuc_g10, haas_ofs, heidenhain_t, linuxcnc_tbl, siemens_toa
from trueloop.formats.tables.tool_tables.tool_table import (
    HINT,
    MARK,
    UNIT_MM,
    Number,
    ToolRow,
    ToolTable,
    Unit,
    XIs,
    replaced,
)
from trueloop.wording import first_of


def row_of(table: ToolTable, tool: int, edge: int = 1, name: str = "") -> ToolRow:
    """The tool's row of wear where the table has one with places for x or z, else that of its geometry.

    Raises OFS-TOOL (no such tool or edge), OFS-ROWS (two rows of one kind) and OFS-NAME (a tool of another name).
    """
    rows = [row for row in table.rows if (row.tool, row.edge) == (tool, edge)]
    if not rows:
        raise _missing(table, tool, edge)
    if name and name.casefold() != rows[0].name.casefold():
        raise Code.OFS_NAME.refusal(
            f"tool {tool} of the table is {rows[0].name!r}, not {name!r}",
            hint="the magazine was loaded anew, or `tool.number` is another's: compare them at the control",
            place=table.place(rows[0]),
            values={"tool": float(tool), "expected": name, "found": rows[0].name},
        )
    wear = _only(table, [row for row in rows if row.kind == "wear"])
    geometry = _only(table, [row for row in rows if row.kind == "geometry"])
    found = wear if wear is not None and (wear.x or wear.z) else geometry
    if found is None or not (found.x or found.z):
        raise Code.OFS_ROW.refusal(
            f"tool {tool} has no offsets along x and z in the table: it is no turning tool there",
            hint="name the turning tool's number, or the table of turning tools",
            place=table.place(rows[0]),
        )
    return found


def geometry_of(table: ToolTable, row: ToolRow) -> ToolRow:
    """The row that holds the nose of the same tool and edge."""
    same = (
        tool_row
        for tool_row in table.rows
        if (tool_row.tool, tool_row.edge) == (row.tool, row.edge) and tool_row.nose is not None
    )
    return next(iter(sorted(same, key=lambda tool_row: tool_row.kind == "wear")), row)


def _only(table: ToolTable, rows: list[ToolRow]) -> ToolRow | None:
    if len(rows) > 1:
        lines = [str(row.line) for row in rows]
        raise Code.OFS_ROWS.refusal(
            f"tool {rows[0].tool} has {len(rows)} rows of {rows[0].kind}, in lines {', '.join(lines)}",
            hint="keep the one that is in force",
            place=table.place(rows[1]),
            values={"tool": float(rows[0].tool), "lines": lines},
        )
    return rows[0] if rows else None


def _missing(table: ToolTable, tool: int, edge: int) -> TrueloopError:
    known = sorted({row.tool for row in table.rows})
    what = f"tool {tool}" + (f", edge {edge}" if edge != 1 else "")
    return Code.OFS_TOOL.refusal(
        f"the table has no {what}; it has {len(known)} tools: {first_of(known, 20)}",
        hint="`tool.number` of the job names the tool's offset; else the T word of the finish pass does",
        place=Place(str(table.path)),
        values={"tool": float(tool)},
    )


SAME_NOSE_MM: Final = 0.0005


@dataclass(frozen=True)
class NewNumber:
    """A number of a row before and after, in the table's unit, and what it is: `X`, a radius or a diameter, or `Z`."""

    axis: Literal["X", "Z"]
    before: Decimal
    after: Decimal
    counts: XIs


@dataclass(frozen=True)
class NewTable:
    """A table with a tool's offset changed: the row, its numbers, and the whole file."""

    row: ToolRow
    numbers: tuple[NewNumber, ...]
    content: bytes


def nose_radius_mm(table: ToolTable, tool: int, edge: int, name: str, stated_mm: float | None) -> float:
    """The nose radius of the table, else of the job. Raises OFS-NOSE where they differ, or neither has it."""
    row = geometry_of(table, row_of(table, tool, edge, name))
    if row.nose is None or row.nose.value == 0:
        if stated_mm is not None:
            return stated_mm
        raise Code.OFS_NOSE.refusal(
            f"tool {tool} has no nose radius above 0 in the table, and the job states none",
            hint="state it in the job: `tool.nose_radius_mm`; 0 is a pointed tool",
            place=table.place(row),
            values={"tool": float(tool), "table_mm": float("nan"), "job_mm": float("nan")},
        )
    found_mm = in_mm(row.nose.value, UNIT_MM[table.known_unit], table.convention.nose_is)
    if stated_mm is not None and abs(found_mm - stated_mm) > SAME_NOSE_MM:
        raise Code.OFS_NOSE.refusal(
            f"the nose radius of tool {tool} is {found_mm:.4f} mm in the table and {stated_mm:.4f} mm in the job",
            hint="measure the insert; leave the radius out of the job to take the table's",
            place=table.place(row),
            values={"tool": float(tool), "table_mm": found_mm, "job_mm": stated_mm},
        )
    return found_mm


def held_tool(name: str, edge: int, tool: int | None, table: ToolTable | None) -> HeldTool:
    """The tool with what the table has of it at present, x as the table counts it. `edge` 0: of a table 1."""
    if table is None or tool is None:
        return HeldTool(name, edge)
    edge = edge or 1
    row = row_of(table, tool, edge, name)
    numbers = {"x": row.x, "z": row.z}
    x, z = (None if number is None else str(number.value) for number in numbers.values())
    return HeldTool(name, edge, TableRow(table.path.name, row.kind, x, z, table.known_unit))


def new_table(table: ToolTable, offset: ToolOffset, record_id: str) -> NewTable:
    """The table with the tool's offset changed.

    Raises OFS errors: the tool is not in it, is another, its numbers have changed since the correction was made, or the
    correction is in the table already.
    """
    unit_mm, step = UNIT_MM[table.known_unit], table.step
    row = row_of(table, offset.tool, offset.held.edge, offset.held.name)
    if table.convention.read_only:
        raise Code.OFS_ROW.refusal(
            f"{table.path.name!r} ({table.convention.name}) is read only: {table.convention.read_only}",
            hint="`trueloop offsets program` writes the control's words",
            place=table.place(row),
        )
    counts: XIs = table.convention.x_is or offset.x_is
    changes: tuple[tuple[Literal["X", "Z"], Number | None, float, XIs], ...] = (
        ("X", row.x, offset.x_radius_mm, counts),
        ("Z", row.z, offset.z_mm, "radius"),
    )
    edits, numbers = [], []
    for axis, number, change_mm, counted in changes:
        old = Decimal(0) if number is None else number.value
        new = changed_number(old, change_mm, unit_mm, counted, step)
        numbers.append(NewNumber(axis, old, new, counted))
        if new == old:
            continue
        if number is None:
            raise Code.OFS_ROW.refusal(
                f"the row of tool {row.tool} has no number for {axis}",
                hint="enter a 0 there at the control and save the table anew",
                place=table.place(row),
            )
        edits.append((number, new))
    _refuse_twice(table, row, offset, record_id, numbers)
    mark = f"{MARK} {record_id} {_measured(offset)}"
    content = replaced(table, edits, row, mark) if edits else table.text.encode("latin-1")
    return NewTable(row, tuple(numbers), content)


def _measured(offset: ToolOffset) -> str:
    """The measured quantity, as the mark names it."""
    return f"of {offset.measured_sha256[:16]}" if offset.measured_sha256 else ""


def _refuse_twice(table: ToolTable, row: ToolRow, offset: ToolOffset, record_id: str, numbers: list[NewNumber]) -> None:
    """By the mark that the row carries, and by what the row held when the correction was made."""
    recorded, now = offset.held.row, [number.before for number in numbers]
    line = table.text[table.text.rfind("\n", 0, row.line_end) + 1 : row.line_end]
    if f"{MARK} {record_id}" in line or (offset.measured_sha256 and _measured(offset) in line):
        raise _twice(table, row, record_id, f"its comment says so, {line.strip()!r}")
    if recorded is None:
        return
    was = [Decimal(text) if text is not None else Decimal(0) for text in (recorded.x, recorded.z)]
    if recorded.unit != table.known_unit or recorded.kind != row.kind:
        found = f"{row.kind} in {table.known_unit} here, {recorded.kind} in {recorded.unit} then"
        raise _changed(table, row, found)
    if now == was:
        return
    then = [before + (number.after - number.before) for before, number in zip(was, numbers, strict=True)]
    if now == then:
        raise _twice(table, row, record_id, f"X {now[0]}, Z {now[1]} is what it makes of X {was[0]}, Z {was[1]}")
    raise _changed(table, row, f"X {now[0]}, Z {now[1]} now, X {was[0]}, Z {was[1]} then")


def _twice(table: ToolTable, row: ToolRow, record_id: str, why: str) -> TrueloopError:
    return Code.OFS_TWICE.refusal(
        f"correction {record_id} is in the row of tool {row.tool} already: {why}",
        hint="measure again before the next correction",
        place=table.place(row),
        values={"tool": float(row.tool), "record": record_id},
    )


def _changed(table: ToolTable, row: ToolRow, text: str) -> TrueloopError:
    return Code.OFS_CHANGED.refusal(
        f"the offsets of tool {row.tool} have changed since the correction was made: {text}",
        hint="the touches belong to the offsets of then: measure again, or put them back",
        place=table.place(row),
        values={"tool": float(row.tool)},
    )


Reader: TypeAlias = Callable[[Path, str, Unit | None], ToolTable]
KNOWN: Final[tuple[tuple[Callable[[Path, bytes], bool], Reader], ...]] = (
    (heidenhain_t.recognises, heidenhain_t.read),
    (haas_ofs.recognises, haas_ofs.read),
    (siemens_toa.recognises, siemens_toa.read),
    (fanuc_g10.recognises, fanuc_g10.read),
    (linuxcnc_tbl.recognises, linuxcnc_tbl.read),
)
"""In the order in which they are asked: how a table is recognised, and its reader."""
NAMES: Final = (linuxcnc_tbl.LINUXCNC, fanuc_g10.FANUC, haas_ofs.HAAS, siemens_toa.SIEMENS, heidenhain_t.HEIDENHAIN)


def read_tool_table(path: Path, unit: Unit | None = None) -> ToolTable:
    """Reads a control's tool table; `unit` as stated. Raises OFS-FILE, OFS-FORMAT, OFS-NUMBER, OFS-UNIT (another)."""
    return tool_table_of(path, read_input(path, Code.OFS_FILE, hint=HINT), unit)


def tool_table_of(path: Path, source: bytes, unit: Unit | None = None) -> ToolTable:
    """Parses the bytes of a tool table; `path` names it in errors. Raises what `read_tool_table` does."""
    for recognises, read in KNOWN:
        if recognises(path, source):
            table = read(path, source.decode("latin-1"), unit)
            return replace(table, unit=table.with_unit(unit))
    names = ", ".join(convention.name for convention in NAMES)
    raise Code.OFS_FORMAT.refusal(
        f"{path.name!r}, {len(source)} bytes, is not one of the {len(NAMES)} kinds of tool table that are read: "
        f"{names}",
        hint=HINT,
        place=Place(str(path)),
    )


def changed_number(
    old: Decimal, change_mm: float, unit_mm: float, counts: Literal["radius", "diameter"], step: Decimal
) -> Decimal:
    """Returns `old` plus a change along an axis, rounded to `step`; a table that counts diameters gets twice the
    change.

    `change_mm` of x is that of the radius; `unit_mm` is the table's unit.
    """
    factor = 2 if counts == "diameter" else 1
    return old + Decimal(factor * change_mm / unit_mm).quantize(step, ROUND_HALF_EVEN)


def in_mm(value: Decimal, unit_mm: float, counts: Literal["radius", "diameter"]) -> float:
    """Returns a number of a table in mm, a diameter as a radius."""
    return float(value) * unit_mm / (2 if counts == "diameter" else 1)
