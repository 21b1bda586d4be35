"""Meanings of the columns of a table, and units as headings and cells name them."""

import re
import unicodedata
from enum import StrEnum
from typing import Final

from trueloop.formats.inspections.measured_file import Unit

LENGTH_MM: Final = {
    **dict.fromkeys(("mm", "millimeter", "millimetre", "millimeters", "millimetres"), 1.0),
    **dict.fromkeys(("cm",), 10.0),
    **dict.fromkeys(("μm", "um", "micron", "microns", "mikrometer", "micrometer", "mikron"), 0.001),
    **dict.fromkeys(("in", "inch", "inches", "zoll", '"', "in."), 25.4),
    **dict.fromkeys(("mil", "thou"), 0.0254),
}
ANGLE_DEG: Final = {
    **dict.fromkeys(("°", "deg", "degree", "degrees", "grad"), 1.0),
    **dict.fromkeys(("rad",), 57.29577951308232),
}
TEMPERATURES: Final = ("°c", "c", "degc", "grad c", "°f", "f", "degf")
KNOWN: Final = frozenset((*LENGTH_MM, *ANGLE_DEG, *TEMPERATURES))
BRACKETED: Final = re.compile(r"[\[(<{]\s*([^\])>}]*?)\s*[\])>}]")
TRAILING: Final = re.compile(r"(?:\bin\s+|[\s_/,])(\S+)\s*$", re.IGNORECASE)
STATED: Final = re.compile(
    r"(?:\b(?:units?|einheit(?:en)?|ma(?:ß|ss)einheit)\b\s*[:=;,]?\s*"
    r"|\b(?:all )?dimensions(?: are)? in |\bma(?:ß|ss)e in )"
    r"(mm|millimet(?:er|re)s?|in|inch(?:es)?|zoll|μm|um)\b",
    re.IGNORECASE,
)


def unit_named(text: str) -> str:
    """Returns a cell that is a unit's name and nothing else, in the spelling of the tables above; else empty."""
    name = unicodedata.normalize("NFKC", text).casefold().strip().strip("[](){}<> ")
    return name if name in KNOWN else ""


def unit_in_heading(heading: str) -> str:
    """Returns the unit that a heading ends with or has in brackets; empty where it names none.

    >>> unit_in_heading("Abw. [µm]"), unit_in_heading("Ist in mm"), unit_in_heading("Ist_inch"), unit_in_heading("Ist")
    ('μm', 'mm', 'inch', '')
    """
    for inside in BRACKETED.findall(heading):
        if unit := unit_named(inside):
            return unit
    last = TRAILING.search(heading)
    name = unit_named(last[1]) if last else ""
    return "" if name in ("c", "f", "in") and not re.search(r"[_/]\S+$|\bin\s+\S+$", heading, re.IGNORECASE) else name


def without_unit(heading: str) -> str:
    """Returns the heading without the unit it ends with."""
    last = TRAILING.search(heading)
    return heading[: last.start()] if last and unit_named(last[1]) else heading


def unit_stated_in(text: str) -> Unit | None:
    """Returns the unit of all lengths in a title line: `Unit: mm`, `Maße in mm`; None: none."""
    found = STATED.search(unicodedata.normalize("NFKC", text))
    if found is None or found[1].casefold() in ("μm", "um"):
        return None
    return "inch" if LENGTH_MM[found[1].casefold()] == 25.4 else "mm"


class Role(StrEnum):
    """The role of a column. Limits are absolute, tolerances are counted from the nominal value."""

    CHARACTERISTIC = "characteristic"
    FEATURE = "feature"
    QUANTITY = "quantity"
    NOMINAL = "nominal"
    ACTUAL = "actual"
    DEVIATION = "deviation"
    UPPER_LIMIT = "upper_limit"
    LOWER_LIMIT = "lower_limit"
    UPPER_TOLERANCE = "upper_tolerance"
    LOWER_TOLERANCE = "lower_tolerance"
    TOLERANCE = "tolerance"  # ±0.02, or +0.02/-0.01
    UNIT = "unit"
    X = "x"
    Y = "y"
    Z = "z"
    NOMINAL_X = "nominal_x"
    NOMINAL_Y = "nominal_y"
    NOMINAL_Z = "nominal_z"
    I = "i"  # noqa: E741  the normal's components are named so
    J = "j"
    K = "k"
    PART = "part"
    SERIAL = "serial"
    DATE = "date"
    TIME = "time"
    OPERATOR = "operator"
    DEVICE = "device"
    TEMPERATURE = "temperature"
    REPEAT = "repeat"
    VERDICT = "verdict"
    OUTSIDE = "outside"  # by how much a value is beyond its limits, 0: not

    @property
    def is_number(self) -> bool:
        """Returns whether its cells are numbers."""
        return self in NUMBERS


POINT: Final = (Role.X, Role.Y, Role.Z)
NOMINAL_POINT: Final = (Role.NOMINAL_X, Role.NOMINAL_Y, Role.NOMINAL_Z)
NORMAL: Final = (Role.I, Role.J, Role.K)
LIMITS: Final = (Role.UPPER_LIMIT, Role.LOWER_LIMIT, Role.UPPER_TOLERANCE, Role.LOWER_TOLERANCE)
LENGTHS: Final = frozenset((Role.NOMINAL, Role.ACTUAL, Role.DEVIATION, *LIMITS, *POINT, *NOMINAL_POINT))
"""Roles of values in a unit of length, or of angle."""
NUMBERS: Final = LENGTHS | {*NORMAL, Role.TEMPERATURE, Role.OUTSIDE}
