"""The unit of a program's lengths and its source, for records and for people."""

from pathlib import Path

from trueloop.domain.record import Program
from trueloop.nc.program.program import Unit
from trueloop.nc.program.tool_path import ToolPath


def unit_told(unit: Unit | None, stated: tuple[int, bool] | None) -> dict[str, str]:
    """Returns the unit in force at the first length, and its source. stated: the line (from 1) that states it before
    any length, and whether it is the inch. Without either the program has no length that needs one.
    """
    if stated is not None:
        line, inch = stated
        return {"unit": "inch" if inch else "mm", "stated_by": f"the program, line {line}"}
    if unit is not None:
        return {"unit": unit, "stated_by": "--unit or programs.unit"}
    return {"unit": "none", "stated_by": "nothing: it has no length"}


def unit_of_path(unit: Unit | None, path: ToolPath) -> dict[str, str]:
    """Returns the unit at the first length, and its source, of a program that was run."""
    stated = path.unit_stated
    return unit_told(unit, None if stated is None else (stated[0] + 1, stated[1]))


def recorded_program(file: str, dialect: str, sha256: str, unit: dict[str, str]) -> Program:
    """Returns a program as a record names it; `unit` as `unit_told` returns it."""
    known: tuple[Unit, ...] = ("mm", "inch")
    return Program(Path(file).name, dialect, sha256, next((one for one in known if one == unit["unit"]), None))
