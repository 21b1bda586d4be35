"""Contours drawn with less than every point, written out: the tool goes the same way, by blocks that say it."""

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.support.drawn_contours import DRAWING, drawn_contours
from tests.support.linuxcnc import interpret
from tests.support.nc_judge import assert_same_moves, leading_somewhere
from tests.support.plain_moves import plain_program
from trueloop.arrays import Array
from trueloop.nc.edit.changes import composed, is_shaped
from trueloop.nc.edit.edit import Edit, apply_edits
from trueloop.nc.expand.expand import WrittenOut, written_out
from trueloop.nc.program.along import points_along
from trueloop.nc.program.program import Program, read_program
from trueloop.nc.program.tool_path import ToolPath

SHARES = np.linspace(0.0, 1.0, 9)
STEPS = 2.0
"""An end may be off by half a step on either axis, an arc between two such ends by what its radius makes of that."""


def run(program: Program) -> ToolPath:
    return program.run()


def explicit(text: str, dialect: str) -> tuple[Program, ToolPath, WrittenOut]:
    program = read_program(text.encode(), dialect)
    path = run(program)
    assert not path.findings
    return program, path, written_out(program, path, range(len(path)), run)


def along(path: ToolPath) -> Array:
    return np.array([points_along(path, np.intp(k), SHARES) for k in range(len(path))])


@pytest.mark.parametrize("dialect", DRAWING)
@settings(max_examples=25, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_the_tool_goes_the_same_way(dialect: str, data: st.DataObject) -> None:
    program, path, done = explicit(data.draw(drawn_contours(dialect)), dialect)
    after = run(read_program(done.program.source, dialect))
    assert not after.findings
    assert not any(is_shaped(done.program, after, k) for k in range(len(after)))
    step_mm = program.dialect.step_mm(bool(path.inch[0]))
    assert np.abs(path.end_mm - after.end_mm).max() <= 0.5 * step_mm + 1e-9
    assert np.linalg.norm(along(path) - along(after), axis=2).max() <= STEPS * step_mm
    assert path.feed.tolist() == pytest.approx(after.feed.tolist(), nan_ok=True)
    assert apply_edits(program, done.edits) == done.program.source
    again = written_out(done.program, after, range(len(after)), run)
    assert again.edits == ()


@pytest.mark.parametrize("dialect", DRAWING)
@settings(max_examples=8, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_linuxcnc_goes_the_way_that_was_drawn(dialect: str, data: st.DataObject) -> None:
    """Its interpreter is given the moves of the written-out program."""
    program, path, done = explicit(data.draw(drawn_contours(dialect)), dialect)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "program.ngc")
        file.write_bytes(plain_program(done.path))
        judged = interpret(file)
    step_mm = program.dialect.step_mm(bool(path.inch[0]))
    assert_same_moves(done.path, judged, same_lines=False, within_mm=1e-6)
    ours, theirs = leading_somewhere(done.path, judged)
    assert np.abs(np.array([move.end_mm for move in theirs]) - path.end_mm[ours]).max() <= 0.5 * step_mm + 1e-6


Found = tuple[int, int, str]
edits_of = st.lists(st.tuples(st.integers(0, 40), st.integers(0, 6), st.text("xyz", max_size=4)), max_size=5)


def apart(found: list[Found], size: int) -> list[Edit]:
    """Edits that do not overlap."""
    edits: list[Edit] = []
    for start, length, text in sorted(found):
        if start + length <= size and (not edits or start >= edits[-1].end):
            edits.append(Edit(start, start + length, text))
    return edits


@given(st.text("abcdefgh", min_size=10, max_size=40), edits_of, edits_of)
def test_edits_of_edits_are_edits_of_the_source(text: str, one: list[Found], other: list[Found]) -> None:
    program = read_program(text.encode(), "linuxcnc")
    first = apart(one, len(text))
    between = read_program(apply_edits(program, first), "linuxcnc")
    second = apart(other, len(between.source))
    wanted = apply_edits(between, second)
    assert apply_edits(program, composed(program.source, first, second)) == wanted
