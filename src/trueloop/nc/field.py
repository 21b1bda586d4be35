"""Fields: a displacement for every position of a program, in its own coordinates or in the machine's: machine =
program + G52, G92 or TRANS + work offset + tool offset. Made here, applied by `loops.mapped_program`.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from trueloop._core import NcField
from trueloop.arrays import Array, Flags, Integers
from trueloop.errors import Code
from trueloop.nc.program.called import CutterTool, tool_rows

Displace = Callable[[Array], Array]
"""Positions (n, 3) to displacements (n, 3), both X (a radius on a lathe), Y, Z in mm."""


DisplaceInMachine = Callable[[Array, Integers, Integers, Array, Array, Array, Flags], Array]
"""`Displace` of a machine: it gets, beside positions, the work offset and tool in force (n,), which way each axis goes
there or went last, (n, 3): +1, −1, `FROM_REFERENCE`, `FROM_ELSEWHERE`, or 0 before its first move, what the tool's
offset adds, (n, 3) mm: NaN where that is not known, where A, B and C stand, (n, 3) degrees: NaN where the program has
not stated it, infinite where it went to a place that is not known, and which positions lie in a cut (n,)."""

FROM_REFERENCE: Final = 2
"""A way of travel from where the axis stands at the start and after a return to its reference point."""
FROM_ELSEWHERE: Final = 3
"""A way of travel from a place that the control alone knows, as that of G30."""


@dataclass(frozen=True)
class Field:
    """A displacement for every position, in the program's coordinates. `identity` names it in a corrected program.

    `follows` are letters of rotary axes with whose places it differs; they stand in every cut. One `of_machine` knows
    from outside where the program's zero lies: a program that sets that itself is refused too. `tools` and `work_mm`,
    the zeros of work offsets in machine coordinates by their number, are what it knows of the control's tables; without
    `tools` none of those is known.
    """

    identity: dict[str, object]
    core: NcField = field(repr=False, compare=False)
    follows: frozenset[str] = frozenset()
    of_machine: bool = False
    tools: tuple[CutterTool, ...] | None = None
    work_mm: Mapping[int, tuple[float, float, float]] = field(default_factory=dict)

    @property
    def is_shift(self) -> bool:
        """Returns whether every position has one displacement."""
        return self.identity.get("matrix") == np.eye(3).tolist()

    def displacement_mm(self, points_mm: Array) -> Array:
        """Returns displacements at (n, 3) positions. Raises NC-FIELD for one outside of where the field is known."""
        points = np.ascontiguousarray(points_mm, dtype=np.float64)
        try:
            return self.core.displacements(points)
        except ValueError as outside:
            index = outside.args[0]
            where = points[index].tolist() if isinstance(index, int) else index
            raise Code.NC_FIELD.refusal(
                f"the field is not known at {where} mm", hint="extend the table: there is no extrapolation"
            ) from None


def function_field(displace: Displace, name: str) -> Field:
    """Makes a field of any function of position, called for many positions at once; what it raises ends the mapping.

    >>> tapered = trueloop.function_field(lambda at_mm: at_mm * [0.0, 0.0, 1e-5], "10 µm/m along Z")
    >>> tapered.displacement_mm(np.array([[0.0, 0.0, 100.0]]))
    array([[0.   , 0.   , 0.001]])
    """
    return Field({"function": name}, NcField.function(displace))


def machine_field(
    displace: DisplaceInMachine,
    identity: dict[str, object],
    *,
    knows_travel: bool = False,
    follows: frozenset[str] = frozenset(),
    tools: Sequence[CutterTool] | None = None,
    work_mm: Mapping[int, tuple[float, float, float]] | None = None,
) -> Field:
    """Makes a machine's field; `knows_travel` cuts arcs where an axis reverses, and approaches a start that jumped."""
    core = NcField.function(displace, knows_travel, "".join(sorted(follows)))
    return Field(
        identity,
        core,
        follows,
        of_machine=True,
        tools=None if tools is None else tuple(tools),
        work_mm=dict(work_mm or {}),
    )


def affine_field(matrix: Array, shift_mm: Sequence[float]) -> Field:
    """Takes p to matrix·p + shift."""
    rows = [[float(value) for value in row] for row in matrix]
    shift = [float(value) for value in shift_mm]
    return Field({"matrix": rows, "shift_mm": shift}, NcField.affine(rows, shift))


def similarity_field(
    *,
    shift_mm: Sequence[float] = (0.0, 0.0, 0.0),
    rotation_rad: float = 0.0,
    axis: str = "Z",
    scale: float = 1.0,
    about_mm: Sequence[float] = (0.0, 0.0, 0.0),
) -> Field:
    """Makes a field that scales and turns about an axis through a point, then shifts.

    The rotation is right-handed: about +Z it turns +X to +Y, about +Y it turns +Z to +X.

    >>> shift = trueloop.similarity_field(shift_mm=(0.01, 0.0, -0.02))
    >>> shift.displacement_mm(np.zeros((1, 3)))
    array([[ 0.01,  0.  , -0.02]])
    """
    k = "XYZ".index(axis)
    i, j = (k + 1) % 3, (k + 2) % 3
    turn = np.eye(3)
    turn[i, i] = turn[j, j] = np.cos(rotation_rad)
    turn[j, i], turn[i, j] = np.sin(rotation_rad), -np.sin(rotation_rad)
    matrix = scale * turn
    about = np.asarray(about_mm, dtype=np.float64)
    return affine_field(matrix, about - matrix @ about + np.asarray(shift_mm))


def table_field(x_mm: Array, y_mm: Array, z_mm: Array, displacement_mm: Array) -> Field:
    """Makes a field that is linear between the nodes of a grid, and unknown outside.

    Node positions rise along each axis; an axis with one value stands for all: nothing depends on it. Displacements
    (nx·ny·nz, 3), z fastest, then y. Raises NC-FIELD where they do not fit together.
    """
    rows = np.ascontiguousarray(displacement_mm, dtype=np.float64)
    try:
        core = NcField.grid(x_mm.tolist(), y_mm.tolist(), z_mm.tolist(), rows)
    except ValueError as error:
        sizes = f"{len(x_mm)} × {len(y_mm)} × {len(z_mm)}"
        raise Code.NC_FIELD.refusal(
            f"{len(rows)} displacements do not make a grid of {sizes} nodes: {error}",
            hint="one displacement for each node, nodes rising along each axis",
        ) from None
    return Field({"nodes": [len(x_mm), len(y_mm), len(z_mm)]}, core)


_NO_NUMBER: Final = {-1: "before the first T", -2: "of a tool called by its name"}
HINT: Final = "give every work offset and tool that the program uses in the file of --offsets"


def field_in_machine(
    field: Field, tools: Sequence[CutterTool], work_mm: Mapping[int, tuple[float, float, float]]
) -> Field:
    """Makes a field of machine coordinates, for `map_program`, from the tools and the zeros of work offsets by number.

    It is evaluated at the machine's positions, and its displacement is added along the program's axes, which are the
    machine's. Its evaluation raises MCH-FRAME where a work offset or the tool's is not known.
    """

    def displace(points_mm: Array, work: Integers, tool: Integers, _: Array, offset_mm: Array, *__: object) -> Array:
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
