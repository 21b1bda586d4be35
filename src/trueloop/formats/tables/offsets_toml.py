"""The offsets file (TOML): work offsets and the tool table of a machine, as its control has them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from pydantic import Field

from trueloop.errors import Code
from trueloop.formats.toml_tables import Count, Finite, Located, NotNegative, Table, read_located
from trueloop.nc.program.called import CutterTool, offset_number


@dataclass(frozen=True)
class OffsetTables:
    """Tools, and where the zeros of work offsets are in machine coordinates (x, y, z), mm, x a radius, by number."""

    tools: tuple[CutterTool, ...] = ()
    work_mm: tuple[tuple[int, tuple[float, float, float]], ...] = ()


class WorkTable(Table):
    """A work offset by name: G54, G59.1, G54.1P2, G505."""

    name: str
    """As programs call it: `G54`, `G59.1`, `G54.1P2`, `G505`."""
    x_radius_mm: Finite = 0.0
    """Where its zero is in machine coordinates, a radius."""
    y_mm: Finite = 0.0
    """Where its zero is along Y."""
    z_mm: Finite = 0.0
    """Where its zero is along Z."""


class ToolTable(Table):
    """A tool; x is half of what a control shows that counts diameters."""

    number: Count
    """Of the offset: the last two digits of T0101; D or H of a mill; T of a Sinumerik, TOOL CALL."""
    edge: Count | None = None
    """D of a Sinumerik; left out, any."""
    radius_mm: NotNegative
    """Of nose or cutter."""
    tip: Annotated[int, Field(ge=0, le=9, strict=True)] | None = None
    """The control's number of the tip's orientation."""
    length_mm: Finite | None = None
    """Length that G43 adds along Z, TOOL CALL along its axis, D of a Sinumerik's mill across the plane."""
    x_radius_mm: Finite | None = None
    """Offset of a lathe's tool along X, a radius."""
    z_mm: Finite | None = None
    """Offset along Z."""
    wear_x_radius_mm: Finite | None = None
    """Wear along X, a radius."""
    wear_z_mm: Finite | None = None
    """Wear along Z."""


class OffsetsFile(Table):
    """A whole offsets file."""

    work: tuple[WorkTable, ...] = ()
    tool: tuple[ToolTable, ...] = ()


def read_offsets(path: Path) -> OffsetTables:
    """Reads an offsets file. Raises NC-FILE, with the line, for anything wrong with it."""
    found = read_located(path, OffsetsFile, Code.NC_FILE, hint="its keys are in docs/cli.md")
    work = [_numbered(found, index, table) for index, table in enumerate(found.model.work)]
    for name, numbers in (
        ("work", [number for number, _ in work]),
        ("tool", [(tool.number, tool.edge) for tool in found.model.tool]),
    ):
        for index in (k for k, number in enumerate(numbers) if number in numbers[:k]):
            with found.at(name, index):
                raise Code.NC_FILE.refusal(f"{name} {index + 1} of the file is given before", hint="keep one")
    return OffsetTables(tuple(map(_tool, found.model.tool)), tuple(work))


def _numbered(found: Located[OffsetsFile], index: int, table: WorkTable) -> tuple[int, tuple[float, float, float]]:
    number = offset_number(table.name)
    if number is None:
        with found.at("work", index, "name"):
            hint = "write it as G54, G59.1, G54.1P2 or G505"
            raise Code.NC_FILE.refusal(f"{table.name!r} is no work offset", hint=hint)
    return number, (table.x_radius_mm, table.y_mm, table.z_mm)


def _tool(table: ToolTable) -> CutterTool:
    """Geometry and wear add up; with none of them the table is not known."""
    given = [(table.x_radius_mm, table.wear_x_radius_mm), (table.z_mm, table.wear_z_mm)]
    known = any(value is not None for pair in given for value in pair)
    x, z = (sum(value or 0.0 for value in pair) for pair in given)
    offset_mm = (x, 0.0, z) if known else None
    return CutterTool(
        radius_mm=table.radius_mm,
        tip=table.tip,
        number=table.number,
        length_mm=table.length_mm,
        offset_mm=offset_mm,
        edge=table.edge,
    )
