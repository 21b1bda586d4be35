"""The change of a tool's offset that a correction asks for, as its record keeps it."""

from dataclasses import dataclass, field
from typing import Literal

ExpandedU = tuple[float | None, float | None]
"""Of an offset's X and Z; None: not determined."""


@dataclass(frozen=True)
class TableRow:
    """What a row of a control's tool table held when it was read: its numbers as they stand in the file.

    `x`, `z` are in the table's `unit`, x a radius or a diameter as the table counts it; None: not in the table.
    """

    file: str
    kind: Literal["geometry", "wear"]
    x: str | None
    z: str | None
    unit: Literal["mm", "inch"]


@dataclass(frozen=True)
class HeldTool:
    """The finishing tool as a control knows it: its name and edge, and its row of the tool table that is in force."""

    name: str = ""
    edge: int = 1
    row: TableRow | None = None


@dataclass(frozen=True)
class ToolOffset:
    """What is added to one tool's offset, mm, x as a radius, rounded to the control's step.

    A tool stands at machine = program + work offset + tool offset: by what is added to its offset, the tool moves.
    `makes_the_correction`: the offset is the correction; else the contour is, and the offset takes its place only by
    choice. `x_is` says how the control counts its offsets on X, `unit` and `decimals` are those of its numbers,
    `blocks` its own words for the change. `measured_sha256` names the measurements it comes from: what was measured
    before an offset was changed says nothing of the part after it. `expanded_u_mm` (95 %; x as a radius, z) is how well
    both are known, None of an axis that the measurements do not determine; None: not stated.
    """

    tool: int
    x_radius_mm: float
    z_mm: float
    makes_the_correction: bool
    x_is: Literal["radius", "diameter"]
    unit: Literal["mm", "inch"]
    measured_sha256: str = ""
    held: HeldTool = field(default_factory=HeldTool)
    decimals: int = 4
    blocks: tuple[str, ...] = ()
    expanded_u_mm: ExpandedU | None = None
    schema: Literal[1] = field(default=1, kw_only=True)
