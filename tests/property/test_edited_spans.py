"""Generated programs of every dialect: written back byte for byte, and after edits only the edited spans differ."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.support.spelled_moves import GIVEN_UNIT, programs
from trueloop.errors import TrueloopError
from trueloop.nc.edit.edit import Edit, apply_edits, displace_word
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import Program, read_program

deltas_mm = st.floats(-0.2, 0.2)
line_ends = st.sampled_from(["\n", "\r\n"])


def displaced(program: Program, data: st.DataObject) -> tuple[list[Edit], dict[int, float]]:
    """Edits of some coordinates, and what each edited word of a plain number then has to say, in program units."""
    path, edits, values = program.run(), {}, {}
    for move in data.draw(st.lists(st.integers(0, len(path) - 1), unique=True)):
        for axis in range(3):
            if (index := int(path.word[move, axis])) < 0:
                continue
            word, state = program.word(index), path.coordinate_state(move)
            delta_mm = data.draw(deltas_mm)
            try:
                edit = displace_word(program, word, delta_mm, state)
            except TrueloopError:
                continue  # an increment: what it refuses is held elsewhere
            if edit is not None and not word.is_expression:
                edits[index] = edit
                values[index] = word.value + delta_mm / state.unit_mm(word.letter)
    return list(edits.values()), values


@pytest.mark.parametrize("dialect", DIALECTS)
@settings(max_examples=25, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_only_the_edited_spans_differ(dialect: str, data: st.DataObject) -> None:
    text = data.draw(programs(dialect, dialect)).replace("\n", data.draw(line_ends))
    program = read_program(text.encode(), dialect, unit=GIVEN_UNIT.get(dialect))
    assert program.core.source() == apply_edits(program, []) == text.encode()
    edits, values = displaced(program, data)
    written = read_program(apply_edits(program, edits), dialect)
    kept, at, after = [], 0, 0
    for edit in sorted(edits, key=lambda edit: edit.start):
        kept.append((text[at : edit.start], written.source[after : after + edit.start - at].decode()))
        after += edit.start - at + len(edit.text)
        at = edit.end
    kept.append((text[at:], written.source[after:].decode()))
    assert all(old == new for old, new in kept)
    resolution = max(program.dialect.resolution_inch, program.dialect.resolution_mm)
    for index, value in values.items():
        assert written.word(index).value == pytest.approx(value, abs=resolution / 2 + 1e-9)
