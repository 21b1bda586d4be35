"""The change of a tool's offset as numbers, as its control shows them.

A tool stands at machine = program + work offset + tool offset: by what is added to its offset, the tool moves.
"""

from dataclasses import dataclass
from typing import Literal

from trueloop.domain.proposal import ExpandedU, HeldTool, ToolOffset
from trueloop.units import MM_PER_INCH
from trueloop.wording import Signed, wording


@dataclass(frozen=True)
class WearOffset:
    """The change of one tool's wear offset, as its control shows it, rounded to the control's step.

    `x` is a diameter where `x_is_diameter`; both are in `unit`, "mm" or "inch". `blocks` add it, from a program or by
    hand at the control; empty where no words for that are known. `edge` is the tool's, where a control counts edges.
    `tool` is the number of its offset, 0 where neither job nor program states one: such an offset is not entered.
    `expanded_u` (95 %) is in the units of `x` and `z`, None of an axis that was not determined; None: not stated.
    """

    tool: int
    x: float
    z: float
    x_is_diameter: bool
    unit: Literal["mm", "inch"]
    decimals: int
    edge: int = 1
    blocks: tuple[str, ...] = ()
    expanded_u: ExpandedU | None = None

    @property
    def called(self) -> str:
        """Names the tool: `T3`, `T3 D2` of a second edge; of a tool without a known number words that state so."""
        if not self.tool:
            return wording("the finishing tool (no number stated)")
        return f"T{self.tool}" if self.edge == 1 else f"T{self.tool} D{self.edge}"

    @property
    def words(self) -> str:
        """Describes the change: `tool 3: wear X −0.024 (diameter), Z +0.004 mm (X ± 0.003, Z ± 0.002)`."""
        x, z = (Signed(value, self.decimals) for value in (self.x, self.z))
        x_is = wording("diameter") if self.x_is_diameter else wording("radius")
        who = wording("tool {number}", number=self.tool) if self.tool else self.called
        return self._known_to(
            wording("{who}: wear X {x} ({x_is}), Z {z} {unit}", who=who, x=x, x_is=x_is, z=z, unit=self.unit)
        )

    @property
    def answer(self) -> str:
        """Describes the answer: `T3 wear X −0.024 mm (diameter), Z +0.004 (X ± 0.003, Z ± 0.002)`."""
        x, z = (Signed(value, self.decimals) for value in (self.x, self.z))
        x_is, who = wording("diameter") if self.x_is_diameter else wording("radius"), self.called
        return self._known_to(
            wording("{who} wear X {x} {unit} ({x_is}), Z {z}", who=who, x=x, unit=self.unit, x_is=x_is, z=z)
        )

    def _known_to(self, numbers: str) -> str:
        if self.expanded_u is None:
            return numbers
        x, z = (None if u is None else f"{u:.{self.decimals}f}" for u in self.expanded_u)
        return known_to(numbers, x, z)

    def number(self, value: float) -> str:
        """Formats a value with its sign and all decimals."""
        return f"{value:+.{self.decimals}f}"

    def as_offset(self, makes_the_correction: bool, measured_sha256: str, held: HeldTool) -> ToolOffset:
        """Returns it as a record keeps it: in mm, x as a radius."""
        unit_mm = MM_PER_INCH if self.unit == "inch" else 1.0
        x_is: Literal["radius", "diameter"] = "diameter" if self.x_is_diameter else "radius"
        x_radius_mm = self.x * unit_mm / (2 if self.x_is_diameter else 1)
        return ToolOffset(
            *(self.tool, x_radius_mm, self.z * unit_mm, makes_the_correction, x_is, self.unit, measured_sha256, held),
            decimals=self.decimals,
            blocks=self.blocks,
            expanded_u_mm=_scaled(self.expanded_u, unit_mm / (2 if self.x_is_diameter else 1), unit_mm),
        )

    @classmethod
    def of(cls, kept: ToolOffset, x_is: Literal["radius", "diameter"]) -> "WearOffset":
        """Returns the offset of a record, with X as a control counts it that may be another, and its own words."""
        unit_mm = MM_PER_INCH if kept.unit == "inch" else 1.0
        is_diameter, blocks = x_is == "diameter", kept.blocks if x_is == kept.x_is else ()
        x, z = kept.x_radius_mm / unit_mm * (2 if is_diameter else 1), kept.z_mm / unit_mm
        x, z = (round(value, kept.decimals) + 0.0 for value in (x, z))
        u = _scaled(kept.expanded_u_mm, (2 if is_diameter else 1) / unit_mm, 1 / unit_mm)
        return cls(kept.tool, x, z, is_diameter, kept.unit, kept.decimals, kept.held.edge, blocks, u)

    def as_dict(self) -> dict[str, object]:
        """Returns it for JSON."""
        x_is = "diameter" if self.x_is_diameter else "radius"
        offset: dict[str, object] = {"tool": self.tool, "x": self.x, "x_is": x_is, "z": self.z, "unit": self.unit}
        known = dict(zip(("x_expanded_u", "z_expanded_u"), self.expanded_u or (None, None), strict=True))
        return {**offset, **known, "words": self.words, "blocks": list(self.blocks)}


def known_to(numbers: str, x_u: object | None, z_u: object | None) -> str:
    """Returns the numbers of an offset with ±U of X and Z; None: not determined."""
    x, z = (
        wording("{axis} not determined by what was measured", axis=axis)
        if u is None
        else wording("{axis} ± {u}", axis=axis, u=u)
        for axis, u in (("X", x_u), ("Z", z_u))
    )
    return wording("{numbers} ({x}, {z})", numbers=numbers, x=x, z=z)


def _scaled(u: ExpandedU | None, x: float, z: float) -> ExpandedU | None:
    if u is None:
        return None
    return (None if u[0] is None else u[0] * x), (None if u[1] is None else u[1] * z)
