"""The change of a tool's offset as numbers, as its control shows them.

A tool stands at machine = program + work offset + tool offset: by what is added to its offset, the tool moves.

The words of controls that add to a tool's offset: in a program of its own, or by hand at the control.

All of them add, so that nothing else of the offset is lost, but those of the GE 2000T, which set it.

The tool offset as numbers to enter at the control, whatever else is written [4773 §2.1, Fig. 9].

A tool stands at machine = program + work offset + tool offset: by what is added to its offset, the tool moves.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final, Literal, TypeAlias, get_args

from trueloop.domain.proposal import ExpandedU, HeldTool, ToolOffset
from trueloop.errors import Code
from trueloop.nc.edit.edit import rounded_mm
from trueloop.nc.program.dialect import Dialect
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import ToolPath
from trueloop.turned.program.offsets import offset_state, tool_offset_updates
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
            return wording("the finishing tool (its number is not known)")
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
        x, z = (
            None if u is None else wording("{value:.{decimals}f}", value=u, decimals=self.decimals)
            for u in self.expanded_u
        )
        return known_to(numbers, x, z)

    def number(self, value: float) -> str:
        """Formats a value with its sign and all decimals."""
        return f"{value:+.{self.decimals}f}"

    def as_offset(self, makes_the_correction: bool, measured_sha256: str, held: HeldTool) -> ToolOffset:
        """Returns it as a record keeps it: in mm, x as a radius; of what is `held` with its own edge."""
        unit_mm = MM_PER_INCH if self.unit == "inch" else 1.0
        x_is: Literal["radius", "diameter"] = "diameter" if self.x_is_diameter else "radius"
        x_radius_mm = self.x * unit_mm / (2 if self.x_is_diameter else 1)
        return ToolOffset(
            tool=self.tool,
            x_radius_mm=x_radius_mm,
            z_mm=self.z * unit_mm,
            makes_the_correction=makes_the_correction,
            x_is=x_is,
            unit=self.unit,
            measured_sha256=measured_sha256,
            held=replace(held, edge=self.edge),
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
        return cls(
            tool=kept.tool,
            x=x,
            z=z,
            x_is_diameter=is_diameter,
            unit=kept.unit,
            decimals=kept.decimals,
            edge=kept.held.edge,
            blocks=blocks,
            expanded_u=u,
        )

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


Control: TypeAlias = Literal["fanuc", "haas", "siemens", "heidenhain", "linuxcnc", "ge2000t", "okuma"]
CONTROLS: Final[tuple[Control, ...]] = get_args(Control)


def blocks_of(control: Control | Literal[""], wear: WearOffset) -> tuple[str, ...]:
    """Returns the blocks of a control; () where it has no words for these numbers, or not of a second edge."""
    if control != "siemens" and wear.edge != 1:
        return ()
    return BLOCKS[control](wear) if control in BLOCKS else ()


def own_control(dialect: Dialect) -> Control | None:
    """Returns the control of a dialect, `okuma` of `okuma-lathe`; None where its words for offsets are not known."""
    others: tuple[Control, ...] = ("okuma", "heidenhain")
    if dialect.wear_words != "":
        return dialect.wear_words
    return next((control for control in others if dialect.name.startswith(control)), None)


def updates(wear: WearOffset, own: Mapping[str, float]) -> tuple[str, ...]:
    """GE 2000T: an update sets the offset, to what the program itself sets, in its unit, and the wear."""
    values = {"X": own["X"] + wear.x, "Z": own["Z"] + wear.z}
    return tuple(f"(UPD, {wear.tool}, TOV({axis}), {value:.{wear.decimals}f})" for axis, value in values.items())


def counted(control: Control, stated: Literal["radius", "diameter"] | None) -> Literal["radius", "diameter"]:
    """Returns how a control counts offsets on X that another control's program was corrected for.

    LinuxCNC's words say it themselves, a Sinumerik counts radii as delivered. Raises OFS-WORDS for the others, which
    are set up in either way, where it is not stated.
    """
    if stated is not None or control in ("siemens", "linuxcnc", "heidenhain", "ge2000t"):
        return stated or "radius"
    raise Code.OFS_WORDS.refusal(
        f"{control!r}: whether offsets on X are radii or diameters is not stated; twice the offset would be wrong",
        hint="state it: `--x-is radius` or `--x-is diameter`",
        values={"control": control},
    )


def offset_program(control: Control, wear: WearOffset, record_id: str) -> str:
    """Returns a program, run once, that adds the offset; a GE 2000T takes `wear.blocks`. Raises OFS-WORDS."""
    blocks = wear.blocks if control == "ge2000t" else blocks_of(control, wear)
    if not blocks:
        raise Code.OFS_WORDS.refusal(
            f"{control!r}: {WHY.get(control, EDGES)} ({wear.words})",
            hint="enter the numbers at the control, or write its tool table: `trueloop offsets apply`",
            values={"control": control},
        )
    return "\n".join([*_framed(control, blocks, f"trueloop offset {record_id}, run once"), ""])


def _framed(control: Control, blocks: tuple[str, ...], comment: str) -> Iterator[str]:
    """Yields the blocks with a comment and an end, as the control loads programs."""
    if control == "siemens":
        yield from (f"; {comment}", *blocks, "M30")
    elif control == "ge2000t":
        yield from (f"! {comment}", *blocks, "M30")
    elif control == "linuxcnc":
        yield from (f"({comment})", *blocks, "M2")
    elif control == "okuma":
        yield from (f"({comment.upper()})", *blocks, "M02")
    else:
        yield from ("%", f"({comment.upper()})", *blocks, "M30", "%")


def _unit(wear: WearOffset) -> str:
    return "G20" if wear.unit == "inch" else "G21"


def _fanuc(wear: WearOffset, code: str = "G10") -> tuple[str, ...]:
    """U and W are increments; P from 1 on are wear offsets."""
    x, z = (wear.number(value).removeprefix("+") for value in (wear.x, wear.z))
    return (f"{_unit(wear)} {code} P{wear.tool} U{x} W{z}",)


def _haas(wear: WearOffset) -> tuple[str, ...]:
    return _fanuc(wear, "G10 L11")


def _siemens(wear: WearOffset) -> tuple[str, ...]:
    """Of a turning tool length 1 lies along X, length 2 along Z."""
    if wear.unit == "inch":  # whether the control keeps its tools in inches is not in the program
        return ()
    return _added((f"$TC_DP{number}[{wear.tool},{wear.edge}]" for number in (12, 13)), wear)


def _okuma(wear: WearOffset) -> tuple[str, ...]:
    """The unit is the control's: G20 and G21 are other codes there."""
    return _added((f"{name}[{wear.tool}]" for name in ("VTOFX", "VTOFZ")), wear)


def _added(keys: Iterator[str], wear: WearOffset) -> tuple[str, ...]:
    return tuple(f"{key}={key}{wear.number(value)}" for key, value in zip(keys, (wear.x, wear.z), strict=True))


def _linuxcnc(wear: WearOffset) -> tuple[str, ...]:
    """Under the offset in force, the place where the tool stands is called by that much less: the table follows.

    Unlike G10 L1 with what #5401 holds, this does not depend on the unit of the table. #<_x> is a radius always, the
    X of G10 a diameter under G7.
    """
    mode, here = ("G7", "2*#<_x>") if wear.x_is_diameter else ("G8", "#<_x>")
    x, z = (wear.number(value).removeprefix("+") for value in (wear.x, wear.z))
    change = f"G10 L10 P{wear.tool} X[{here}-[{x}]] Z[#<_z>-[{z}]]"
    return f"{_unit(wear)} {mode} G40 T{wear.tool} M6", "G43", change, "G43"


BLOCKS: Final[Mapping[str, Callable[[WearOffset], tuple[str, ...]]]] = {
    "fanuc": _fanuc,
    "haas": _haas,
    "linuxcnc": _linuxcnc,
    "siemens": _siemens,
    "okuma": _okuma,
}
WHY: Final[Mapping[Control, str]] = {
    "heidenhain": "no words of a program are known that change the tool table",
    "siemens": "whether the control keeps its tools in inch is not in the program",
    "ge2000t": "an update sets the whole offset, which a program for another control does not say",
}
"""The reasons why a control has no words for an offset."""
EDGES: Final = "its words that are known count no edges of a tool, and this offset is of another edge than the first"


def wear_offset(
    program: Program,
    path: ToolPath,
    cut: int,
    offset_mm: tuple[float, float],
    tool: int,
    is_diameter: bool | None,
    edge: int = 1,
    *,
    expanded_u_mm: ExpandedU | None = None,
) -> WearOffset:
    """Returns the tool's offset changed by (x as a radius, z) mm, in the words of the program's control.

    `cut` is a move of the finish pass: the unit is that of its words. `is_diameter` says how the control reads offsets
    on X; None: as the words on X, on Sinumerik as a radius. LinuxCNC always reads them as words. `edge` is the tool's.
    `tool` 0: its number is not known; there are no words for that offset then. `expanded_u_mm`: of both offsets, as
    they are given.
    """
    dialect, words = program.dialect, path.coordinate_state(cut)
    if dialect.offset_x == "words":
        is_diameter = None
    elif is_diameter is None and dialect.offset_x == "radius":
        is_diameter = False
    state = offset_state(words, is_diameter)
    decimals = max(0, round(-math.log10(dialect.step(state.inch))))
    mm = {axis: rounded_mm(dialect, axis, value, state) for axis, value in zip("XZ", offset_mm, strict=True)}
    x, z = (round(mm[axis] / state.unit_mm(axis), decimals) for axis in "XZ")
    u = None
    if expanded_u_mm is not None:
        x_u, z_u = (None if v is None else v / state.unit_mm(a) for a, v in zip("XZ", expanded_u_mm, strict=True))
        u = (x_u, z_u)
    wear = WearOffset(
        tool=tool,
        x=x,
        z=z,
        x_is_diameter=state.diameter,
        unit="inch" if state.inch else "mm",
        decimals=decimals,
        edge=edge,
        expanded_u=u,
    )
    if not tool:
        return wear
    if dialect.wear_words == "ge2000t":
        own_mm = tool_offset_updates(program, state, (0.0, 0.0), tool)
        own = {axis: value_mm / state.unit_mm(axis) for axis, value_mm in own_mm.items()}
        return replace(wear, blocks=updates(wear, own))
    return replace(wear, blocks=blocks_of(dialect.wear_words, wear))
