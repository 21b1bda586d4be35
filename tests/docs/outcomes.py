"""What is there after the snippets of a page have run: more than they print."""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import pytest

from tests.support.cli import invoke

Known = dict[str, Any]


def first_part(known: Known) -> None:
    """By hand: the journal reads Ø 24.013, so X 23.987; the seat Ø 44.031 and Ø 44.027, so X 43.971 in its middle."""
    before, now = (
        [float(word) for word in re.findall(r"X(-?[\d.]+)", Path(name).read_text(encoding="utf-8"))]
        for name in ("finish.nc", "shaft/out/corrected.nc")
    )
    assert 24.0 in before and 23.987 in now
    ends = [x for x in now if 43.9 < x < 44.0]  # at Z-80 and Z-112: the readings' middle is the cylinder's
    assert len(ends) == 2 and sum(ends) / 2 == pytest.approx(44.0 - 0.029, abs=0.0006)
    assert ends[0] > ends[1], "thicker at the chuck: more is taken off there"
    invoke("new", "finish.nc", "--dialect", "fanuc-lathe", "--nose-radius-mm", "0.8", "--folder", "again", status=0)
    written, filled = (Path(name, "readings.csv").read_text(encoding="utf-8") for name in ("again", "shaft"))
    assert places_in(written) == places_in(filled), "the rows of the page are those that are written"


def places_in(readings: str) -> list[str]:
    """The rows of a file of readings without their values."""
    return [row.rpartition(",")[0] for row in readings.splitlines() if row[0] != "#"]


def python(known: Known) -> None:
    """The files are those that the values say."""
    assert Path("out/corrected.nc").read_bytes() == known["correction"].corrected_program
    assert known["difference"].distance_mm == pytest.approx(0.02)
    assert Path("surface/record.json").is_file()


def series(known: Known) -> None:
    """The accepted offset, in the words of the job's control."""
    assert "G21 G10 P3 U-0.019 W0.000" in Path("offset.nc").read_text(encoding="utf-8")
    assert Path("replayed/replay.html").is_file()


OUTCOMES: Final[dict[str, Callable[[Known], None]]] = {
    "first-part.md": first_part,
    "python.md": python,
    "series.md": series,
}
"""By page."""
