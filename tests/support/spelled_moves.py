"""Generated programs in every dialect, spelt as their controls' programmers do: in each way that a control has.

Arcs go through points of a lattice circle (3² + 4² = 5²), so their ends and centres are exact in few decimals.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

from hypothesis import strategies as st

from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import Unit

TURNING: Final = ("ge2000t", "fanuc-lathe", "fanuc-lathe-b", "haas-lathe", "okuma-lathe")
MILLING: Final = ("fanuc-mill", "haas-mill", "heidenhain")
EITHER: Final = ("linuxcnc", "siemens")
CIRCLE: Final = (
    (5, 0),
    (4, 3),
    (3, 4),
    (0, 5),
    (-3, 4),
    (-4, 3),
    (-5, 0),
    (-4, -3),
    (-3, -4),
    (0, -5),
    (3, -4),
    (4, -3),
)
PLANES: Final = {17: ("X", "Y"), 18: ("X", "Z"), 19: ("Y", "Z")}
CENTRES: Final = dict(zip("XYZ", "IJK", strict=True))
TURNS: Final = {"linuxcnc": "P3", "siemens": "TURN=2"}
"""Two turns more than the arc has of itself."""
INCREMENTS: Final = dict(zip("XYZ", "UVW", strict=True))


@dataclass(frozen=True)
class Style:
    """How a program is written: its unit, what X is, the plane of its arcs."""

    dialect: str
    inch: bool
    diameter: bool
    plane: int

    @property
    def axes(self) -> str:
        """The axes that it moves."""
        return "XYZ" if self.plane != 18 or self.dialect in MILLING else "XZ"

    def value(self, axis: str, length: float) -> float:
        """A coordinate in program units; X doubled where it is a diameter."""
        return round(length * (2 if axis == "X" and self.diameter else 1), 6)

    def word(self, axis: str, length: float) -> str:
        """A number as the control writes it."""
        text = f"{length:.6f}".rstrip("0")
        return f"{axis}{'+' if self.dialect == 'heidenhain' and length >= 0 else ''}{text}"


@st.composite
def styles(draw: st.DrawFn, dialect: str, target: str) -> Style:
    """A way to write programs of that dialect, of a kind that the target can write."""
    inch = draw(st.booleans()) and "okuma-lathe" not in (dialect, target)
    if dialect == "heidenhain":
        return Style(dialect, False, False, 17)
    turning = dialect in TURNING or target in TURNING
    plane = 18 if turning else draw(st.sampled_from(sorted(PLANES)))
    choice = dialect in EITHER and plane == 18 and target not in MILLING
    return Style(dialect, inch, dialect in TURNING or (choice and draw(st.booleans())), plane)


HEADS: Final = {
    "ge2000t": "{unit} G90 G94",
    "linuxcnc": "{unit} G{plane} {x} G90 G91.1 G94",
    "fanuc-lathe": "{unit} G18 G98",
    "fanuc-lathe-b": "{unit} G18 G90 G94",
    "haas-lathe": "{unit} G18 G98",
    "fanuc-mill": "{unit} G{plane} G90 G94",
    "haas-mill": "{unit} G{plane} G90 G94",
    "siemens": "{unit} G{plane} {x} G90 G94",
    "heidenhain": "BEGIN PGM A MM",
    "okuma-lathe": "{unit} G18 G90 G94",
}
GIVEN_UNIT: Final[Mapping[str, Unit]] = {"okuma-lathe": "mm"}
"""Of controls whose programs do not state it."""
UNITS: Final = {"ge2000t": ("G71", "G70"), "siemens": ("G710", "G700"), "okuma-lathe": ("", "")}
X_IS: Final = {"linuxcnc": ("G8", "G7"), "siemens": ("DIAMOF", "DIAMON")}


def head(style: Style) -> str:
    """The first block: unit, plane, what X is."""
    unit = UNITS.get(style.dialect, ("G21", "G20"))[style.inch]
    x = X_IS.get(style.dialect, ("", ""))[style.diameter]
    return HEADS[style.dialect].format(unit=unit, plane=style.plane, x=x)


@st.composite
def programs(draw: st.DrawFn, dialect: str, target: str) -> str:
    """A program: lines, arcs and shifts of the zero, after a first position along all axes. A variant is spelled as the
    control that it is like.
    """
    style = draw(styles(*(DIALECTS[name].like or name for name in (dialect, target))))
    at = {axis: draw(lengths) for axis in style.axes}
    lines = [head(style), _straight(draw, style, at, dict.fromkeys(at, 0.0), first=True)]
    for _ in range(draw(st.integers(1, 8))):
        kind = draw(st.sampled_from(["straight", "straight", "arc", "arc", "shift"]))
        if kind == "straight":
            named = draw(st.lists(st.sampled_from(style.axes), min_size=1, unique=True))
            to = {**at, **{axis: draw(lengths) for axis in named}}
            lines.append(_straight(draw, style, {axis: to[axis] for axis in named}, at))
            at = to
        elif kind == "arc":
            text, at = _arc(draw, style, at)
            lines += text
        else:
            text, at = _shift(draw, style, at)
            lines += text
    return "\n".join([*lines, "M30", ""])


lengths = st.integers(-50_000, 50_000).map(lambda steps: steps / 1000)


def _positions(draw: st.DrawFn, style: Style, to: dict[str, float], at: dict[str, float], *, first: bool) -> list[str]:
    """Coordinates, each as a position or, where the control can say it in the word, as an increment."""
    words = []
    for axis, length in to.items():
        way = style.value(axis, length - at[axis])
        increment = not first and draw(st.booleans())
        if increment and style.dialect in ("fanuc-lathe", "fanuc-lathe-b", "haas-lathe"):
            words.append(style.word(INCREMENTS[axis], way))
        elif increment and style.dialect == "siemens":
            words.append(f"{axis}=IC({way:.6f})")
        elif increment and style.dialect == "heidenhain":
            words.append("I" + style.word(axis, way))
        else:
            words.append(style.word(axis, style.value(axis, length)))
    return words


def _straight(draw: st.DrawFn, style: Style, to: dict[str, float], at: dict[str, float], *, first: bool = False) -> str:
    rapid, feed = draw(st.booleans()), draw(st.integers(1, 400))
    words = " ".join(_positions(draw, style, to, at, first=first))
    if style.dialect == "heidenhain":
        return f"L {words} {'FMAX' if rapid else f'F{feed}'}"
    return f"G00 {words}" if rapid else f"G01 {words} F{feed}."


def _arc(draw: st.DrawFn, style: Style, at: dict[str, float]) -> tuple[list[str], dict[str, float]]:
    in_plane = PLANES[style.plane]
    size = draw(st.integers(20, 4000)) / 1000
    begin, end = draw(st.integers(0, 11)), draw(st.integers(0, 11))
    centre = {axis: at[axis] - size * CIRCLE[begin][k] for k, axis in enumerate(in_plane)}
    to = {axis: centre[axis] + size * CIRCLE[end][k] for k, axis in enumerate(in_plane)}
    third = next(axis for axis in "XYZ" if axis not in in_plane)
    helix = third in style.axes and draw(st.booleans())
    if style.dialect == "heidenhain" and helix:
        return _klartext_helix(draw, style, at, centre, third)
    if helix:
        to[third] = draw(lengths)
    code = draw(st.sampled_from(["G02", "G03"]))
    by_radius = begin != end and style.dialect not in ("ge2000t", "okuma-lathe") and draw(st.booleans())
    radius = 5 * size * draw(st.sampled_from([1, -1]))
    if style.dialect == "heidenhain":
        return _klartext_arc(draw, style, to, at, centre, radius if by_radius else None), {**at, **to}
    ends = " ".join(_positions(draw, style, to, at, first=False))
    if by_radius:
        address = "CR=" if style.dialect == "siemens" else "R"
        return [f"{code} {ends} {address}{radius:.6f} F77."], {**at, **to}
    before, after, words = _centres(draw, style, at, centre)
    turns = draw(st.sampled_from(["", TURNS.get(style.dialect, "")]))
    return [*before, f"{code} {ends} {' '.join(words)} {turns} F77.", *after], {**at, **to}


def _centres(
    draw: st.DrawFn, style: Style, at: dict[str, float], centre: dict[str, float]
) -> tuple[list[str], list[str], list[str]]:
    """Blocks before and after the arc, and its centre's words: from the start, or absolute where the control has it."""
    absolute = draw(st.booleans())
    if style.dialect == "siemens" and absolute:
        return [], [], [f"{CENTRES[axis]}=AC({style.value(axis, at_mm):.6f})" for axis, at_mm in centre.items()]
    if style.dialect == "linuxcnc" and absolute:
        # I is a radius in LinuxCNC, absolute or not.
        return ["G90.1"], ["G91.1"], [f"{CENTRES[axis]}{at_mm:.6f}" for axis, at_mm in centre.items()]
    return [], [], [f"{CENTRES[axis]}{at_mm - at[axis]:.6f}" for axis, at_mm in centre.items()]


def _klartext_arc(
    draw: st.DrawFn,
    style: Style,
    to: dict[str, float],
    at: dict[str, float],
    centre: dict[str, float],
    radius: float | None,
) -> list[str]:
    way = draw(st.sampled_from(["DR+", "DR-"]))
    ends = " ".join(_positions(draw, style, to, at, first=False))
    if radius is not None:
        return [f"CR {ends} {style.word('R', radius)} {way} F77"]
    pole = " ".join(style.word(axis, at_mm) for axis, at_mm in centre.items())
    return [f"CC {pole}", f"C {ends} {way} F77"]


def _klartext_helix(
    draw: st.DrawFn, style: Style, at: dict[str, float], centre: dict[str, float], third: str
) -> tuple[list[str], dict[str, float]]:
    """By the angle and the way along the axis: half turns, so that the end is exact; then back to the start's plane."""
    half_turns, rise = draw(st.integers(1, 5)), draw(lengths)
    sign = draw(st.sampled_from([1, -1]))
    pole = " ".join(style.word(axis, at_mm) for axis, at_mm in centre.items())
    turn = f"CP IPA{180 * sign * half_turns:+d} I{style.word(third, rise)} DR{'+' if sign > 0 else '-'} F77"
    to = {**at, **({axis: 2 * centre[axis] - at[axis] for axis in centre} if half_turns % 2 else {})}
    return [f"CC {pole}", turn], {**to, third: at[third] + rise}


SHIFTS: Final = {"siemens": "TRANS", "heidenhain": "CYCL DEF 7.1", "linuxcnc": "G92"}


def _shift(draw: st.DrawFn, style: Style, at: dict[str, float]) -> tuple[list[str], dict[str, float]]:
    """The zero shifted along Z, and the position that the tool then has; back to a position before the next block."""
    by = draw(lengths)
    if style.dialect in ("ge2000t", "okuma-lathe"):
        return [], at
    if style.dialect == "linuxcnc":
        return [f"G92 Z{by:.6f}"], {**at, "Z": by}
    code = SHIFTS.get(style.dialect, "G52")
    text = f"{code} {style.word('Z', by)}"
    shifted = [*(["CYCL DEF 7.0 DATUM SHIFT"] if style.dialect == "heidenhain" else []), text]
    to = draw(lengths)
    rapid = f"L {style.word('Z', to)} FMAX" if style.dialect == "heidenhain" else f"G00 {style.word('Z', to)}"
    return [*shifted, rapid], {**at, "Z": to}
