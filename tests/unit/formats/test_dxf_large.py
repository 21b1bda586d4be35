"""Drawings of thousands of lines: the time goes by their number. Compared all with all these take over a minute."""

import math
import time
from itertools import pairwise
from pathlib import Path

import pytest

from trueloop.formats.cad.dxf import read_dxf

XY = tuple[float, float]
LIMIT_S = 10.0
"""Seconds of the processor: ten times what is needed."""


def drawn(path: Path, lines: list[tuple[XY, XY]], axis: bool) -> Path:
    """A drawing in mm, of R12, with a centre line along y = 0."""
    text = "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$INSUNITS\n70\n4\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n"
    for (x0, y0), (x1, y1) in lines:
        text += f"0\nLINE\n8\n0\n10\n{x0}\n20\n{y0}\n11\n{x1}\n21\n{y1}\n"
    if axis:
        text += "0\nLINE\n8\nachse\n10\n-5\n20\n0\n11\n45\n21\n0\n"
    path.write_text(f"{text}0\nENDSEC\n0\nEOF\n", "ascii")
    return path


def ring() -> list[tuple[XY, XY]]:
    """The section of a ring whose outside is a wave of 4,000 lines, on both sides of its axis."""
    wave = [(k * 0.01, 15 + math.sin(k / 50)) for k in range(4001)]
    upper = list(pairwise([*wave, (40.0, 10.0), (0.0, 10.0), wave[0]]))
    return [*upper, *(((x0, -y0), (x1, -y1)) for (x0, y0), (x1, y1) in upper)]


def hatching() -> list[tuple[XY, XY]]:
    """12,000 lines of one length, one above the other, and a shaft."""
    level = [((0.0, 100.0 + 3 * k), (30.0, 100.0 + 3 * k)) for k in range(12_000)]
    return [*level, *pairwise([(0.0, 0.0), (0.0, 8.0), (30.0, 8.0), (30.0, 0.0)])]


@pytest.mark.parametrize(("lines", "axis", "greatest_mm"), [(ring(), True, 16.0), (hatching(), False, 8.0)])
def test_thousands_of_lines(lines: list[tuple[XY, XY]], axis: bool, greatest_mm: float, tmp_path: Path) -> None:
    path = drawn(tmp_path / "part.dxf", lines, axis)
    began = time.process_time()
    read = read_dxf(path)
    seconds = time.process_time() - began
    assert seconds < LIMIT_S
    assert max(feature.start_mm[0] for feature in read.features) == pytest.approx(greatest_mm, abs=1e-3)
