"""Drawings of thousands of lines: the time goes by their number. Compared all with all these take over a minute."""

import math
import time
from itertools import pairwise
from pathlib import Path

import ezdxf.filemanagement
import pytest

from tests.support.refusals import refused
from trueloop.errors import Code
from trueloop.formats.cad import dxf_entities
from trueloop.formats.cad.dxf import read_dxf, read_dxf_sheet

XY = tuple[float, float]
LIMIT_S = 6.0
"""Seconds of the processor: three times what the largest needs on an idle one, for tests run side by side."""
SHAFT = [*pairwise([(0.0, 0.0), (0.0, 8.0), (30.0, 8.0), (30.0, 0.0)])]


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
    """100,000 lines of one length, one above the other, and a shaft."""
    level = [((0.0, 100.0 + 3 * k), (30.0, 100.0 + 3 * k)) for k in range(100_000)]
    return [*level, *SHAFT]


def test_arcs_take_about_the_time_of_lines(tmp_path: Path) -> None:
    """A knob of 30,000 half circles with lines between them, beside as many lines of two lengths; each arc looked at by
    itself, they took ten times as long."""
    count = 30_000
    flat = [((0.1 * k, 10.0), (0.1 * k + 0.05, 10.0)) for k in range(count)]
    joints = [((0.1 * k + 0.05, 10.0), (0.1 * k + 0.1, 10.0)) for k in range(count)]
    ends = [((0.0, 0.0), (0.0, 10.0)), ((0.1 * count, 10.0), (0.1 * count, 0.0))]
    straight = drawn(tmp_path / "lines.dxf", [*ends, *flat, *joints], axis=False)
    path = drawn(tmp_path / "arcs.dxf", [*ends, *flat], axis=False)
    head, tail = path.read_text("ascii").rsplit("0\nENDSEC", 1)
    arcs = "".join(f"0\nARC\n8\n0\n10\n{0.1 * k + 0.075}\n20\n10\n40\n.025\n50\n0\n51\n180\n" for k in range(count))
    path.write_text(f"{head}{arcs}0\nENDSEC{tail}", "ascii")
    seconds = []
    for file in (straight, path):
        began = time.process_time()
        read = read_dxf_sheet(file)
        contours = read.sheet.candidates  # by its cells too, as of a drawing with more than the chain
        seconds.append(time.process_time() - began)
    assert seconds[1] < 3 * seconds[0]
    assert len(read.chosen().features) == len(contours[0].features) == 2 * count + 2


@pytest.mark.parametrize("step_mm", [0.0, 1e-3])
def test_a_hundred_thousand_lines_that_meet_in_one_place_are_refused_at_once(step_mm: float, tmp_path: Path) -> None:
    """One line, copied onto itself, and a fan of lines from one point."""
    fan = [((0.0, 20.0), (50.0, 20.0 + step_mm * k)) for k in range(100_000)]
    path = drawn(tmp_path / "part.dxf", fan, axis=False)
    began = time.process_time()
    refusal = refused(read_dxf, path)
    seconds = time.process_time() - began
    assert seconds < LIMIT_S
    assert refusal.code is Code.GEO_DXF and "lie in the same places" in refusal.message


@pytest.mark.parametrize(("lines", "axis", "greatest_mm"), [(ring(), True, 16.0), (hatching(), False, 8.0)])
def test_thousands_of_lines(lines: list[tuple[XY, XY]], axis: bool, greatest_mm: float, tmp_path: Path) -> None:
    path = drawn(tmp_path / "part.dxf", lines, axis)
    began = time.process_time()
    read = read_dxf(path)
    seconds = time.process_time() - began
    assert seconds < LIMIT_S
    assert max(feature.start_mm[0] for feature in read.features) == pytest.approx(greatest_mm, abs=1e-3)


def test_thousands_of_centre_lines_are_not_all_axes(tmp_path: Path) -> None:
    path = drawn(tmp_path / "part.dxf", SHAFT, axis=True)
    short = "".join(f"0\nLINE\n8\nachse\n10\n{2 * k}\n20\n{-5 - k % 3}\n11\n{2 * k}\n21\n20\n" for k in range(3000))
    head, tail = path.read_text("ascii").rsplit("0\nENDSEC", 1)
    path.write_text(f"{head}{short}0\nENDSEC{tail}", "ascii")
    began = time.process_time()
    read = read_dxf(path)
    seconds = time.process_time() - began
    assert seconds < LIMIT_S
    assert [feature.name for feature in read.features] == ["face-1", "cylinder-1", "face-2"]
    assert "2901 shorter centre lines were left out." in read.notes


def test_blocks_within_blocks_end(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ten in each of eight, one within the other, are 10⁷ lines in a small file."""
    monkeypatch.setattr(dxf_entities, "MOST_ENTITIES", 1000)
    document = ezdxf.filemanagement.new("R2010", units=4)
    document.blocks.new("0").add_line((0, 1), (2, 3))
    for k in range(1, 8):
        block = document.blocks.new(str(k))
        for j in range(10):
            block.add_blockref(str(k - 1), (j, 0))
    document.modelspace().add_blockref("7", (0, 0))
    document.saveas(tmp_path / "bomb.dxf")
    began = time.process_time()
    refusal = refused(read_dxf, tmp_path / "bomb.dxf")
    seconds = time.process_time() - began
    assert seconds < LIMIT_S
    assert refusal.code is Code.GEO_DXF and "more than 1000 entities" in refusal.message
