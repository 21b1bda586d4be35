"""Units as headings and cells name them."""

import re
import unicodedata
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
    """A cell that is a unit's name and nothing else, in the spelling of the tables above; else empty."""
    name = unicodedata.normalize("NFKC", text).casefold().strip().strip("[](){}<> ")
    return name if name in KNOWN else ""


def unit_in_heading(heading: str) -> str:
    """The unit that a heading ends with or has in brackets; empty where it names none.

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
    """The heading without the unit it ends with."""
    last = TRAILING.search(heading)
    return heading[: last.start()] if last and unit_named(last[1]) else heading


def unit_stated_in(text: str) -> Unit | None:
    """What a title line says of all lengths: `Unit: mm`, `Maße in mm`."""
    found = STATED.search(unicodedata.normalize("NFKC", text))
    if found is None or found[1].casefold() in ("μm", "um"):
        return None
    return "inch" if LENGTH_MM[found[1].casefold()] == 25.4 else "mm"
