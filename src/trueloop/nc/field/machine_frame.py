"""Positions of a program in the machine: machine = program + G52, G92 or TRANS + work offset + tool offset."""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.errors import Code
from trueloop.nc.field.field import Field, machine_field
from trueloop.nc.program.cutter_tool import CutterTool, tool_rows

_NO_NUMBER: Final = {-1: "before the first T", -2: "of a tool called by its name"}
HINT: Final = "give every work offset and tool that the program uses in the file of --offsets"


def field_in_machine(
    field: Field, tools: Sequence[CutterTool], work_mm: Mapping[int, tuple[float, float, float]]
) -> Field:
    """Makes a field of machine coordinates, for `map_program`, from the tools and the zeros of work offsets by number.

    It is evaluated at the machine's positions, and its displacement is added along the program's axes, which are the
    machine's. Its evaluation raises MCH-FRAME where a work offset or the tool's is not known.
    """

    def displace(points_mm: Array, work: Integers, tool: Integers, _: Array, offset_mm: Array, *__: Array) -> Array:
        require_offsets(tool, offset_mm, HINT)
        return field.displacement_mm(points_mm + looked_up(work, work_mm, "work offset", HINT) + offset_mm)

    identity: dict[str, object] = {
        "field": field.identity,
        "work_zero_mm": {str(number): list(zero) for number, zero in work_mm.items()},
        "tools": [list(row) for row in tool_rows(tools)],
    }
    return machine_field(displace, identity, tools=tools, work_mm=work_mm)


def require_offsets(tool: Integers, offset_mm: Array, hint: str) -> None:
    """Raises MCH-FRAME for the first tool (n,) whose offset (n, 3) is not known: NaN."""
    unknown = np.flatnonzero(np.isnan(offset_mm).any(axis=-1))
    if len(unknown):
        number = int(tool[unknown[0]])
        where = f"after T{number}" if number >= 0 else _NO_NUMBER.get(number, "here")
        raise Code.MCH_FRAME.refusal(f"the tool offset in force {where} is not known", hint=hint)


def looked_up(numbers: Integers, table: Mapping[int, tuple[float, float, float]], what: str, hint: str) -> Array:
    """Vectors (n, 3) by their numbers (n,). Raises MCH-FRAME for one that the table does not have."""
    vectors = np.zeros((len(numbers), 3))
    for number in np.unique(numbers):
        if int(number) not in table:
            given = ", ".join(str(n) for n in table) or "none"
            raise Code.MCH_FRAME.refusal(
                f"{what} {int(number)} is used, but only {given} is known in machine coordinates", hint=hint
            )
        vectors[numbers == number] = table[int(number)]
    return vectors
