"""A picture for a dark page: the same drawing, its colours with as much contrast as they have on white."""

import re
from typing import Final

from trueloop.report import style

DARK: Final = {
    style.LEFT_ON: "#ff7a8a",
    style.TAKEN: "#7db4ff",
    style.AFTER: "#4fd1bd",
    style.IN: "#66b8ea",
    style.OUT: "#ff9d4d",
    style.INK: "#e8edf2",
    style.SOFT: "#b4bec8",
    style.FAINT: "#6d7a86",
    style.GRID: "#39424b",
    style.STEEL: "#3a4652",
    style.PALE_STEEL: "#2b343d",
    style.BAND: "rgba(232,237,242,0.2)",
    "#ffffff": "#242424",
}
"""By the colour on white; the last one is the ground, which fills open marks."""
_COLOUR: Final = re.compile("|".join(f'(?<="){re.escape(one)}(?=")' for one in DARK))


def in_the_dark(svg: str) -> str:
    """A still with its colours changed; red stays material left on, blue too much taken. Words stay as they are."""
    return _COLOUR.sub(lambda found: DARK[found.group()], svg)
