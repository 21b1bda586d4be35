"""The tool offset as numbers to enter at the control, whatever else is written [4773 §2.1, Fig. 9].

A tool stands at machine = program + work offset + tool offset: by what is added to its offset, the tool moves.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal

from trueloop.domain.tool_offset import HeldTool, ToolOffset
from trueloop.nc.edit.number_text import resolution_of, rounded
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import ToolPath
from trueloop.turned.program.offsets import offset_state, tool_offset_updates
from trueloop.units import MM_PER_INCH
from trueloop.wording import Signed, wording


@dataclass(frozen=True)
class WearOffset:
    """What to add to one tool's wear offset, as its control shows it, rounded to the control's step.

    `x` is a diameter where `x_is_diameter`; both are in `unit`, "mm" or "inch". `blocks` add it, from a program or by
    hand at the control; empty where no words for that are known.
    """

    tool: int
    x: float
    z: float
    x_is_diameter: bool
    unit: Literal["mm", "inch"]
    decimals: int
    blocks: tuple[str, ...] = ()

    @property
    def words(self) -> str:
        """`tool 3: wear X −0.024 (diameter), Z +0.004 mm`."""
        x, z = (Signed(value, self.decimals) for value in (self.x, self.z))
        x_is = wording("diameter") if self.x_is_diameter else wording("radius")
        return wording(
            "tool {tool}: wear X {x} ({x_is}), Z {z} {unit}", tool=self.tool, x=x, x_is=x_is, z=z, unit=self.unit
        )

    @property
    def answer(self) -> str:
        """`T3 wear X −0.024 mm (diameter), Z +0.004`."""
        x, z = (Signed(value, self.decimals) for value in (self.x, self.z))
        x_is = wording("diameter") if self.x_is_diameter else wording("radius")
        return wording("T{tool} wear X {x} {unit} ({x_is}), Z {z}", tool=self.tool, x=x, unit=self.unit, x_is=x_is, z=z)

    def number(self, value: float) -> str:
        """A value with its sign and all decimals."""
        return f"{value:+.{self.decimals}f}"

    def as_offset(self, makes_the_correction: bool, measured_sha256: str, held: HeldTool) -> ToolOffset:
        """As a record keeps it: in mm, x as a radius."""
        unit_mm = MM_PER_INCH if self.unit == "inch" else 1.0
        x_is: Literal["radius", "diameter"] = "diameter" if self.x_is_diameter else "radius"
        x_radius_mm = self.x * unit_mm / (2 if self.x_is_diameter else 1)
        z_mm = self.z * unit_mm
        return ToolOffset(self.tool, x_radius_mm, z_mm, makes_the_correction, x_is, self.unit, measured_sha256, held)

    def as_dict(self) -> dict[str, object]:
        """For JSON."""
        x_is = "diameter" if self.x_is_diameter else "radius"
        offset: dict[str, object] = {"tool": self.tool, "x": self.x, "x_is": x_is, "z": self.z, "unit": self.unit}
        return {**offset, "words": self.words, "blocks": list(self.blocks)}


def wear_offset(
    program: Program, path: ToolPath, cut: int, offset_mm: tuple[float, float], tool: int, is_diameter: bool | None
) -> WearOffset:
    """The tool's offset changed by (x as a radius, z) mm, in the words of the program's control.

    `cut` is a move of the finish pass: the unit is that of its words. `is_diameter` says how the control reads offsets
    on X; None: as the words on X, on Sinumerik as a radius. LinuxCNC always reads them as words.
    """
    dialect, words = program.dialect, path.coordinate_state(cut)
    if dialect.offset_x == "words":
        is_diameter = None
    elif is_diameter is None and dialect.offset_x == "radius":
        is_diameter = False
    state = offset_state(words, is_diameter)
    step = resolution_of(dialect, state)
    x, z = (float(rounded(v / state.unit_mm(a), step)) for a, v in zip("XZ", offset_mm, strict=True))
    decimals = max(0, -int(step.as_tuple().exponent))
    wear = WearOffset(tool, x, z, state.diameter, "inch" if state.inch else "mm", decimals)
    if dialect.wear_words == "UPD":
        own = tool_offset_updates(program, state, (0.0, 0.0), tool)
        return _with(wear, _ge2000t(wear, {axis: value / state.unit_mm(axis) for axis, value in own.items()}))
    return _with(wear, BLOCKS[dialect.wear_words](wear))


def offset_number(program: Program, path: ToolPath, cut: int) -> int | None:
    """The number of the tool's offset in the finish pass, as its T word says; None before any."""
    word = int(path.tool[cut])
    if word <= 0:
        return None
    if program.dialect.offset_in_t and word >= 100:
        return word % 100 or word // 100
    return word


def _with(wear: WearOffset, blocks: tuple[str, ...]) -> WearOffset:
    return replace(wear, blocks=blocks)


def _unit(wear: WearOffset) -> str:
    return "G20" if wear.unit == "inch" else "G21"


def _fanuc(wear: WearOffset, code: str = "G10") -> tuple[str, ...]:
    """U and W are increments; P from 1 on are wear offsets."""
    x, z = (wear.number(value).removeprefix("+") for value in (wear.x, wear.z))
    return (f"{_unit(wear)} {code} P{wear.tool} U{x} W{z}",)


def _haas(wear: WearOffset) -> tuple[str, ...]:
    return _fanuc(wear, "G10 L11")


def _siemens(wear: WearOffset) -> tuple[str, ...]:
    """Of a turning tool length 1 lies along X, length 2 along Z; edge 1."""
    if wear.unit == "inch":  # whether the control keeps its tools in inches is not in the program
        return ()
    keys = (f"$TC_DP{number}[{wear.tool},1]" for number in (12, 13))
    pairs = zip(keys, (wear.x, wear.z), strict=True)
    return tuple(f"{key}={key}{wear.number(value)}" for key, value in pairs)


def _linuxcnc(wear: WearOffset) -> tuple[str, ...]:
    """Under the offset in force, the place where the tool stands is called by that much less: the table follows.

    Unlike G10 L1 with what #5401 holds, this does not depend on the unit of the table. #<_x> is a radius always, the
    X of G10 a diameter under G7.
    """
    mode, here = ("G7", "2*#<_x>") if wear.x_is_diameter else ("G8", "#<_x>")
    x, z = (wear.number(value).removeprefix("+") for value in (wear.x, wear.z))
    change = f"G10 L10 P{wear.tool} X[{here}-[{x}]] Z[#<_z>-[{z}]]"
    return f"{_unit(wear)} {mode} G40 T{wear.tool} M6", "G43", change, "G43"


def _ge2000t(wear: WearOffset, own: Mapping[str, float]) -> tuple[str, ...]:
    """An update sets the offset: what the program sets, and the wear."""
    values = {"X": own["X"] + wear.x, "Z": own["Z"] + wear.z}
    return tuple(f"(UPD, {wear.tool}, TOV({axis}), {value:.{wear.decimals}f})" for axis, value in values.items())


BLOCKS: Final[Mapping[str, Callable[[WearOffset], tuple[str, ...]]]] = {
    "": lambda wear: (),
    "G10": _fanuc,
    "G10 L11": _haas,
    "G10 L10": _linuxcnc,
    "$TC_DP": _siemens,
}
