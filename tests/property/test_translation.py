"""Generated programs, each in its dialect's own words, translated: the machine makes the same moves of them."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.support.linuxcnc import interpret
from tests.support.machine_moves import MachineMove, machine_moves
from tests.support.nc_judge import assert_same_moves
from tests.support.spelled_moves import EITHER, GIVEN_UNIT, MILLING, TURNING, programs
from trueloop.errors import Severity
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import Motion
from trueloop.nc.translate.translate import translate
from trueloop.units import MM_PER_INCH

PAIRS = [
    (source, target)
    for kind in (TURNING + EITHER, MILLING + EITHER)
    for source in kind
    for target in kind
    if source != target
]


HELIX_STEPS = 2.2
"""Klartext gives a helix no end: rounded start and pole, both up to 0.71 steps off, lead to it."""


def assert_same_to_the_step(
    found: list[MachineMove], wanted: list[MachineMove], step_mm: float, rounded_mm: float
) -> None:
    """Kind, feed, end within the rounding that is told, centre within what rounding of start and centre adds up to."""
    assert [move.motion for move in found] == [move.motion for move in wanted]
    for move, true in zip(found, wanted, strict=True):
        assert np.abs(move.end_mm - true.end_mm).max() <= rounded_mm + 1e-9
        if true.motion == Motion.RAPID:
            continue
        assert move.feed == pytest.approx(true.feed, rel=1e-5, nan_ok=True)
        if true.motion == Motion.ARC:
            radius_mm = np.nanmax(np.abs(true.centre_mm - true.end_mm))
            assert np.abs(move.centre_mm - true.centre_mm).max() <= step_mm + 1e-9
            assert move.sweep_rad == pytest.approx(true.sweep_rad, abs=5 * step_mm / radius_mm)


def test_every_dialect_is_one_of_turning_milling_or_either() -> None:
    assert set(TURNING + MILLING + EITHER) == DIALECTS.keys()


@pytest.mark.parametrize(("source", "target"), sorted(set(PAIRS)))
@settings(max_examples=12, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_the_machine_makes_the_same_moves(source: str, target: str, data: st.DataObject) -> None:
    program = read_program(data.draw(programs(source, target)).encode(), source, unit=GIVEN_UNIT.get(source))
    decimals = data.draw(st.sampled_from([None, 3, 4, 5, 9]))
    made = translate(program, target, decimals=decimals)
    assert not [loss for loss in made.losses if loss.severity is Severity.ERROR]
    written = read_program(made.source, target, unit=GIVEN_UNIT.get(target))
    inch = target != "heidenhain" and bool(program.run().inch.any())
    step_mm = 10.0**-made.decimals * (MM_PER_INCH if inch else 1.0)
    assert_same_to_the_step(machine_moves(written), machine_moves(program), step_mm, made.rounded_mm)
    helix = target == "heidenhain" and b"CP " in made.source
    assert made.rounded_mm <= (HELIX_STEPS if helix else 0.5) * step_mm + 1e-9
    assert not written.findings


@settings(max_examples=20, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_linuxcnc_s_own_interpreter_makes_the_moves_of_a_translation(data: st.DataObject) -> None:
    dialect = data.draw(st.sampled_from(sorted(set(DIALECTS) - {"linuxcnc"})))
    program = read_program(data.draw(programs(dialect, "linuxcnc")).encode(), dialect, unit=GIVEN_UNIT.get(dialect))
    made = translate(program, "linuxcnc", decimals=9).source
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "program.ngc")
        file.write_bytes(made)
        judged = interpret(file)
    assert_same_moves(read_program(made, "linuxcnc").run(), judged)


@st.composite
def straight_blocks(draw: st.DrawFn) -> list[str]:
    """Blocks of a mill that only move straight, some of increments, some that move nothing or wait for a feed mode."""
    length = st.decimals(-50, 50, places=4).map(lambda value: f"{value:f}")
    coordinate = st.tuples(st.sampled_from("XYZ"), length).map("".join)
    words = st.tuples(
        st.sampled_from(["", "", "N7", "G90", "G91", "G40", "M08", "S900", "G93", "G94 F300."]),
        st.sampled_from(["", "G00", "G01"]),
        st.lists(coordinate, max_size=3, unique_by=lambda word: word[0]).map(" ".join),
        st.sampled_from(["", "", "F100.", "F250.5"]),
    )
    return draw(st.lists(words.map(lambda found: " ".join(filter(None, found))), min_size=1, max_size=12))


@pytest.mark.parametrize("target", sorted(MILLING + EITHER))
@settings(max_examples=20, suppress_health_check=[HealthCheck.too_slow])
@given(blocks=straight_blocks(), head=st.sampled_from(["G21", "G20", "G21 G90 G01 X1. Y1. Z1. F50."]), data=st.data())
def test_straight_moves_are_written_alike_with_and_without_comments_between(
    target: str, blocks: list[str], head: str, data: st.DataObject
) -> None:
    """A comment in a block has it read by itself: without one it is part of a stretch."""
    decimals = data.draw(st.sampled_from([None, 0, 3]))
    spoken = [f"{block} (BETWEEN)" for block in blocks]
    alone, together = (
        translate(read_program("\n".join([head, *lines, "M30"]).encode(), "fanuc-mill"), target, decimals=decimals)
        for lines in (spoken, blocks)
    )

    def unnumbered(source: bytes) -> list[str]:
        lines = [line.split(" ", 1)[-1] if target == "heidenhain" else line for line in source.decode().splitlines()]
        return [line for line in lines if "BETWEEN" not in line and "sha256" not in line]

    assert unnumbered(together.source) == unnumbered(alone.source)
    assert (together.rounded_mm, together.decimals) == (alone.rounded_mm, alone.decimals)
    assert [(loss.code, loss.severity, loss.place) for loss in together.losses] == [
        (loss.code, loss.severity, loss.place) for loss in alone.losses
    ]
