"""The change of a tool's offset as numbers, as its control shows them.

A tool stands at machine = program + work offset + tool offset: by what is added to its offset, the tool moves.
"""

from dataclasses import dataclass
from typing import Literal

from trueloop.domain.tool_offset import HeldTool, ToolOffset
from trueloop.units import MM_PER_INCH
from trueloop.wording import Signed, wording


@dataclass(frozen=True)
class WearOffset:
    """What to add to one tool's wear offset, as its control shows it, rounded to the control's step.

    `x` is a diameter where `x_is_diameter`; both are in `unit`, "mm" or "inch". `blocks` add it, from a program or by
    hand at the control; empty where no words for that are known. `edge` is the tool's, where a control counts edges.
    `tool` is the number of its offset, 0 where neither job nor program states one: such an offset is not entered.
    """

    tool: int
    x: float
    z: float
    x_is_diameter: bool
    unit: Literal["mm", "inch"]
    decimals: int
    edge: int = 1
    blocks: tuple[str, ...] = ()

    @property
    def called(self) -> str:
        """`T3`, `T3 D2` of a second edge; of a tool without a known number words that say so."""
        if not self.tool:
            return wording("the finishing tool (no number stated)")
        return f"T{self.tool}" if self.edge == 1 else f"T{self.tool} D{self.edge}"

    @property
    def words(self) -> str:
        """`tool 3: wear X −0.024 (diameter), Z +0.004 mm`."""
        x, z = (Signed(value, self.decimals) for value in (self.x, self.z))
        x_is = wording("diameter") if self.x_is_diameter else wording("radius")
        who = wording("tool {number}", number=self.tool) if self.tool else self.called
        return wording("{who}: wear X {x} ({x_is}), Z {z} {unit}", who=who, x=x, x_is=x_is, z=z, unit=self.unit)

    @property
    def answer(self) -> str:
        """`T3 wear X −0.024 mm (diameter), Z +0.004`."""
        x, z = (Signed(value, self.decimals) for value in (self.x, self.z))
        x_is, who = wording("diameter") if self.x_is_diameter else wording("radius"), self.called
        return wording("{who} wear X {x} {unit} ({x_is}), Z {z}", who=who, x=x, unit=self.unit, x_is=x_is, z=z)

    def number(self, value: float) -> str:
        """A value with its sign and all decimals."""
        return f"{value:+.{self.decimals}f}"

    def as_offset(self, makes_the_correction: bool, measured_sha256: str, held: HeldTool) -> ToolOffset:
        """As a record keeps it: in mm, x as a radius."""
        unit_mm = MM_PER_INCH if self.unit == "inch" else 1.0
        x_is: Literal["radius", "diameter"] = "diameter" if self.x_is_diameter else "radius"
        x_radius_mm = self.x * unit_mm / (2 if self.x_is_diameter else 1)
        return ToolOffset(
            *(self.tool, x_radius_mm, self.z * unit_mm, makes_the_correction, x_is, self.unit, measured_sha256, held),
            decimals=self.decimals,
            blocks=self.blocks,
        )

    @classmethod
    def of(cls, kept: ToolOffset, x_is: Literal["radius", "diameter"]) -> "WearOffset":
        """What a record keeps, with X as a control counts it that may be another; its own words stay with its own."""
        unit_mm = MM_PER_INCH if kept.unit == "inch" else 1.0
        is_diameter, blocks = x_is == "diameter", kept.blocks if x_is == kept.x_is else ()
        x, z = kept.x_radius_mm / unit_mm * (2 if is_diameter else 1), kept.z_mm / unit_mm
        x, z = (round(value, kept.decimals) + 0.0 for value in (x, z))
        return cls(kept.tool, x, z, is_diameter, kept.unit, kept.decimals, kept.held.edge, blocks)

    def as_dict(self) -> dict[str, object]:
        """For JSON."""
        x_is = "diameter" if self.x_is_diameter else "radius"
        offset: dict[str, object] = {"tool": self.tool, "x": self.x, "x_is": x_is, "z": self.z, "unit": self.unit}
        return {**offset, "words": self.words, "blocks": list(self.blocks)}
