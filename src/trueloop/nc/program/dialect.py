"""The dialects that the Rust core reads, and what differs between them for whoever writes programs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any, Final, Literal

from trueloop._core import nc_dialects
from trueloop.errors import Code
from trueloop.units import MM_PER_INCH


@dataclass(frozen=True)
class Dialect:
    """The way one control writes numbers, comments and expressions.

    `resolution_inch` and `resolution_mm` are the smallest programmable steps of an inch and of a metric program.
    `radius_address` is what stands before the radius of an arc: `R`, `CR=`. `lead_along_thread`: the lead of a tapered
    thread counts along it, else along the axis on which it is longer. `tips`: by the number of a tip's orientation, 0
    to 9, where the tip of a nose of radius 1 lies from its centre, (x, z). `like` is the control of which this one is a
    variant, and `marks` are points and pattern of lines that only its programs have. `decimal_comma`: the program at
    hand writes `X+2,5`.

    `file_ending` of programs that no other control uses. `klartext`: moves are `L X+1 Y+2`, without G words.
    `plane_of_points`: X and Y are positions of a plane, X no diameter. `line_angle`: A is the angle of a line.
    `plain_corners`: R, I and K of a straight move round or break its corner.
    `splines`: G5 to G5.3 cut splines. `blends_corners`: corners are rounded without a bound until G61, or G64 with P.
    `radius_within_quadrant`: as delivered, an arc with R may not leave its quadrant [6811 §A.1.1].
    `contours_by_number`: G70 to G73 run the contour between two block numbers. `offset_in_t`: T0312 calls tool 3 with
    offset 12. `edge_by_d`: D2 calls the second edge of its tool, of an Okuma `TG=6 OG=2`.

    `contour_shift` is what moves a contour by an offset: a shift of its frame, or the update of the tool's offset
    (UPD); empty where neither is known. `one_shift`: G52 and G92 set one and the same shift; elsewhere G92 stays below
    G52. `wear_words`: the control whose words add to a tool's wear offset; empty where none are known. `offset_x`:
    whether offsets on X are radii, are always read as words on X are, or as the control is set up.
    """

    name: str
    resolution_inch: float
    resolution_mm: float
    comment_open: str
    comment_close: str
    bracket_open: str
    radius_address: str
    lead_along_thread: bool
    tips: Sequence[Sequence[float]] = field(compare=False)
    like: str = ""
    marks: Sequence[tuple[int, str]] = field(compare=False, default=())
    decimal_comma: bool = False
    file_ending: str | None = None
    klartext: bool = False
    plane_of_points: bool = False
    line_angle: bool = False
    plain_corners: bool = False
    splines: bool = False
    blends_corners: bool = False
    radius_within_quadrant: bool = False
    contours_by_number: bool = False
    offset_in_t: bool = False
    edge_by_d: bool = False
    contour_shift: Literal["", "G52", "ATRANS", "UPD"] = ""
    one_shift: bool = False
    wear_words: Literal["", "fanuc", "haas", "linuxcnc", "siemens", "ge2000t"] = ""
    offset_x: Literal["set-up", "radius", "words"] = "set-up"

    def step(self, inch: bool) -> float:
        """Returns the smallest programmable step, in the unit of the program."""
        return self.resolution_inch if inch else self.resolution_mm

    @property
    def radius_letter(self) -> str:
        """Returns the letter of the word of an arc's radius; `CR=` is read as R."""
        return self.radius_address if len(self.radius_address) == 1 else "R"

    def step_mm(self, inch: bool) -> float:
        """Returns the smallest programmable step in mm."""
        return self.step(inch) * (MM_PER_INCH if inch else 1.0)

    def with_decimals(self, decimals: int) -> "Dialect":
        """Returns the dialect with steps of that many decimals where its own are coarser."""
        finest = float(f"1e-{decimals}")
        inch, metric = min(self.resolution_inch, finest), min(self.resolution_mm, finest)
        return replace(self, resolution_inch=inch, resolution_mm=metric)

    def comment(self, text: str) -> str:
        """Returns the text as a comment on one line."""
        kept = " ".join(text.split())
        if self.comment_close:
            kept = kept.replace(self.comment_open, "[").replace(self.comment_close, "]")
        return f"{self.comment_open}{kept}{self.comment_close}"


_LATHE: Final[Mapping[str, Any]] = {
    "line_angle": True, "plain_corners": True, "contours_by_number": True, "offset_in_t": True, "contour_shift": "G52",
}  # fmt: skip
_MILL: Final[Mapping[str, Any]] = {"plane_of_points": True, "contour_shift": "G52"}
_WRITTEN: Final[Mapping[str, Mapping[str, Any]]] = {
    "ge2000t": {
        "radius_within_quadrant": True, "offset_in_t": True, "contour_shift": "UPD", "wear_words": "ge2000t",
    },
    "linuxcnc": {
        **_MILL, "file_ending": ".ngc", "splines": True, "blends_corners": True, "one_shift": True,
        "wear_words": "linuxcnc", "offset_x": "words",
    },
    "fanuc-lathe": {**_LATHE, "wear_words": "fanuc"},
    "fanuc-lathe-b": _LATHE,
    "fanuc-mill": _MILL,
    "haas-lathe": {**_LATHE, "wear_words": "haas"},
    "haas-mill": _MILL,
    "siemens": {
        "edge_by_d": True, "contour_shift": "ATRANS", "wear_words": "siemens",
        "offset_x": "radius",
    },
    "heidenhain": {"klartext": True},
    "okuma-lathe": {"offset_in_t": True, "edge_by_d": True},
}  # fmt: skip


def _dialect(row: tuple[Any, ...]) -> Dialect:
    """Returns a dialect; a variant is written as the control that it is like, but for words that set its offsets."""
    dialect = Dialect(*row)
    return replace(dialect, **_WRITTEN.get(dialect.name) or {**_WRITTEN[dialect.like], "wear_words": ""})


DIALECTS: Mapping[str, Dialect] = MappingProxyType({row[0]: _dialect(row) for row in nc_dialects()})
"""Every dialect by its name."""


def dialect_named(name: str) -> Dialect:
    """Returns the dialect of that name. Raises NC-DIALECT when there is none."""
    if name not in DIALECTS:
        raise Code.NC_DIALECT.refusal(f"unknown NC dialect {name!r}", hint=f"choose one of: {', '.join(DIALECTS)}")
    return DIALECTS[name]
