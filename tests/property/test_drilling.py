"""Drilling cycles: LinuxCNC's own interpreter makes the same moves of them, displaced ones in their places."""

import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.support.linuxcnc import Move, interpret
from tests.support.mapped import mapped
from tests.support.nc_judge import assert_same_moves
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.nc.field import Field, function_field
from trueloop.nc.program.program import read_program

AXES = {17: ("X", "Y", "Z"), 18: ("Z", "X", "Y"), 19: ("Y", "Z", "X")}
ELSEWHERE_MM = 0.1
"""Holes further apart are two: their places are whole millimetres, moved by some hundredths."""
CYCLES = ["G81", "G82 P.1", "G83 Q{}", "G73 Q{}", "G85", "G86 P.1", "G89 P.1"]


@st.composite
def programs(draw: st.DrawFn) -> str:
    """Series of holes in any plane, with both retractions, absolute and by increments, repeated or not."""
    plane = draw(st.sampled_from(sorted(AXES)))
    first, second, third = AXES[plane]
    places = st.integers(-30, 30)
    height = st.integers(4, 12)
    blocks = [f"G{plane} G21 F100 S500 M3", f"G0 {first}{draw(places)} {second}{draw(places)} {third}{draw(height)}"]
    for _ in range(draw(st.integers(1, 3))):
        incremental = draw(st.booleans())
        cycle = draw(st.sampled_from(CYCLES)).format(draw(st.sampled_from(["1.5", "2", "7"])))
        plane_r, bottom = draw(st.integers(-1, 3)), -draw(st.integers(2, 9))
        mode = f"{'G91' if incremental else 'G90'} {draw(st.sampled_from(['G98', 'G99', '']))}"
        repeats = f" L{draw(st.integers(1, 3))}" if draw(st.booleans()) else ""
        blocks.append(
            f"{mode} {cycle} {first}{draw(places)} {second}{draw(places)} {third}{bottom} R{plane_r}{repeats}"
        )
        blocks += [f"{draw(st.sampled_from([first, second]))}{draw(places)}" for _ in range(draw(st.integers(0, 3)))]
        if draw(st.booleans()):
            blocks.append(f"G80 G90 G0 {third}{draw(height)}")
    return "\n".join([*blocks, "G80", "G90 G0 X0 Y0 Z20", "M2", ""])


@given(text=programs())
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_linuxcnc_makes_the_same_moves(text: str) -> None:
    path = read_program(text.encode(), "linuxcnc").run(inch=False)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "case.ngc")
        file.write_text(text)
        assert_same_moves(path, interpret(file, startup="G17 G21 G40 G90 G94"))


@dataclass(frozen=True)
class _Hole:
    """Where the tool begins to cut, how deep it gets, and at which height it leaves to another place, if it does."""

    plane_mm: Array
    bottom_mm: Array
    left_mm: float | None = None


def _holes(moves: Sequence[Move], third: int) -> list[_Hole]:
    across = [axis for axis in range(3) if axis != third]
    holes: list[_Hole] = []
    for move in moves:
        start, end = np.array(move.start_mm), np.array(move.end_mm)
        if np.any(np.abs(end - start)[across] > ELSEWHERE_MM):
            if holes and holes[-1].left_mm is None:
                holes[-1] = replace(holes[-1], left_mm=start[third])
        elif move.kind == "line" and end[third] < start[third]:
            if not holes or np.any(np.abs(holes[-1].bottom_mm - end)[across] > ELSEWHERE_MM):
                holes.append(_Hole(start, end))
            elif end[third] < holes[-1].bottom_mm[third]:
                holes[-1] = replace(holes[-1], bottom_mm=end)
    return holes


def _bent_across(third: int) -> Field:
    """Bends in the plane, leans by 1e-5 of the depth, and moves along the axis by where it is and how deep."""
    first, second = (axis for axis in range(3) if axis != third)

    def displacement_mm(points: Array) -> Array:
        moved = np.zeros_like(points)
        moved[:, first] = 0.03 * np.sin(points[:, second] / 30) + 1e-5 * points[:, third]
        moved[:, second] = 0.02 * np.cos(points[:, first] / 25)
        moved[:, third] = 3e-4 * points[:, first] + 2e-4 * points[:, third]
        return moved

    return function_field(displacement_mm, "bent across")


@given(text=programs())
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_displaced_holes_are_where_they_shall_be(text: str) -> None:
    """Their places, planes and depths within the tolerance of 0.5 µm and a step of the last digit."""
    third = {"17": 2, "18": 1, "19": 0}[text[1:3]]
    field = _bent_across(third)
    with tempfile.TemporaryDirectory() as folder:
        try:
            mapped(Path(folder), text, field)
        except TrueloopError as refusal:
            assert refusal.code is Code.NC_MAP
            if "repeats" in refusal.message:
                assert " L" in text and "G91" in text
            else:
                assert "go down first" in refusal.message
            return
        source, written = (
            interpret(Path(folder, name), startup="G17 G21 G40 G90 G94") for name in ("program.ngc", "mapped.ngc")
        )
    ends = np.array([move.end_mm for move in source])
    highest_mm = np.abs(field.displacement_mm(ends)[:, third]).max() + 0.00001
    before, after = _holes(source, third), _holes(written, third)
    assert len(before) == len(after)
    for old, new in zip(before, after, strict=True):
        for was, now in ((old.plane_mm, new.plane_mm), (old.bottom_mm, new.bottom_mm)):
            assert now == pytest.approx(was + field.displacement_mm(was[None])[0], abs=0.0005 + 0.00001)
        # LinuxCNC goes up before it goes on where the displaced plane R comes to lie above the initial height.
        if old.left_mm is not None and new.left_mm is not None:
            assert new.left_mm > old.left_mm - highest_mm
    last = np.array(source[-1].end_mm)
    assert written[-1].end_mm == pytest.approx(last + field.displacement_mm(last[None])[0], abs=0.00001)
