"""`trueloop nc diff`: how far the tool paths of two programs lie apart."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.failure import ExitStatus, guarded
from trueloop.cli.nc.not_understood import not_understood, tell_not_understood
from trueloop.cli.program_file import ProgramFile, Reading, Tables
from trueloop.cli.shared_options import not_negative
from trueloop.cli.terminal import AsJson, busy, print_json

if TYPE_CHECKING:
    from trueloop.formats.tables.offsets_toml import OffsetTables
    from trueloop.nc.program.program import Program
    from trueloop.nc.program.tool_path import ToolPath


@dataclass(frozen=True, kw_only=True)
class Other:
    """How the second program is read, where that is otherwise."""

    other_dialect: Annotated[
        str | None, typer.Option("--other-dialect", metavar="D", help="Dialect of the second.  [default: as the first]")
    ] = None
    other_unit: Annotated[
        Literal["mm", "inch"] | None, typer.Option("--other-unit", help="Unit of the second.  [default: as the first]")
    ] = None

    def reading(self, first: Reading) -> Reading:
        """That of the second program."""
        dialect = first.dialect if self.other_dialect is None else self.other_dialect
        return replace(first, dialect=dialect, unit=self.other_unit or first.unit)


@guarded
def difference_of_programs(
    file: ProgramFile,
    other: ProgramFile,
    reading: Reading,
    second: Other,
    tables: Tables,
    rapids: Annotated[bool, typer.Option("--rapids", help="Compare rapid moves as well as cuts.")] = False,
    tolerance_mm: Annotated[
        float | None,
        typer.Option("--tolerance-mm", callback=not_negative, help="Exit status 1 when they lie further apart."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Print where the tool paths of two programs lie furthest apart, and how far."""
    from trueloop.nc.match.difference import path_difference

    with busy(f"comparing {file} and {other}"):
        known = tables.read()
        both = [_run(file, reading, known, rapids), _run(other, second.reading(reading), known, rapids)]
        found = path_difference(*(path for _, path in both), rapids=rapids)
    here, there = (0, 1) if found.first else (1, 0)
    moves, positions = (found.move, found.nearest_move), (found.position_mm, found.nearest_mm)
    ends = [
        (str((file, other)[which]), int(both[which][1].line[move]), int(both[which][1].column[move]), at)
        for which, move, at in zip((here, there), moves, positions, strict=True)
    ]
    if as_json:
        unknown = [len(not_understood(*one)) for one in both]
        at, nearest = (dict(zip(("file", "line", "column", "position_mm"), end, strict=True)) for end in ends)
        print_json(
            {"distance_mm": found.distance_mm, "spacing_mm": found.spacing_mm, "at": at, "nearest": nearest}
            | {"not_understood": unknown}
        )
    else:
        for one in both:
            tell_not_understood(*one)
        print(f"largest distance {found.distance_mm:.6f} mm")
        for word, (name, line, column, at_mm) in zip(("at", "nearest"), ends, strict=True):
            position = " ".join(f"{axis} {value:.6f}" for axis, value in zip("xyz", at_mm, strict=True))
            print(f"  {word} {name}:{line}:{column}  {position} mm, x a radius")
    if tolerance_mm is not None and found.distance_mm > tolerance_mm:
        raise typer.Exit(ExitStatus.FINDINGS)


def _run(file: Path, reading: Reading, known: "OffsetTables", rapids: bool) -> "tuple[Program, ToolPath]":
    from trueloop.errors import in_file
    from trueloop.nc.match.difference import compared_moves

    program = reading.program(file)
    path = reading.run(program, known)
    with in_file(file):
        compared_moves(path, rapids)
    return program, path
