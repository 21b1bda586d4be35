"""What counts as another program."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from trueloop.controllers.links.compare import Change, differences

EVERY = frozenset(Change)


@pytest.mark.parametrize(
    ("sent", "back", "passes"),
    [
        (b"g1 x10.\n", b"G1 X10.\n", {Change.CAPITALS}),
        (b"G1 X10.\n", b"G1X10.\n", {Change.BLANKS}),
        (b"G1X10.\nM30\n", b"G1X10.\r\nM30\r\n", {Change.LINE_ENDS}),
        (b"G1X10.\nM30\n", b"\0\nG1X10.\n\r\r\0M30", {Change.LINE_ENDS}),
    ],
)
def test_only_what_the_control_is_known_to_change_passes(sent: bytes, back: bytes, passes: set[Change]) -> None:
    assert differences(sent, back, frozenset(passes)) == []
    assert differences(sent, back, EVERY - passes)
    assert differences(sent, back)


def test_every_other_difference_is_found_with_its_lines() -> None:
    sent = b"N10 G0 X50\nN20 G1 X10.0\nN30 M30\n"
    (one,) = differences(sent, sent.replace(b"10.0", b"10."), EVERY)
    assert (one.line, one.before, one.other_line, one.after) == (2, "N20 G1 X10.0", 2, "N20 G1 X10.")
    (lost,) = differences(sent, b"N10 G0 X50\nN30 M30\n", EVERY)
    assert (lost.line, lost.after) == (2, None)
    (more,) = differences(sent, sent + b"X1\n", EVERY)
    assert (more.line, more.before, more.other_line) == (None, None, 4)


@given(st.binary(max_size=60).filter(lambda text: b"\0" not in text), st.data())
def test_one_byte_changed_is_a_difference(text: bytes, data: st.DataObject) -> None:
    text = b"G1 X1\n" + text
    k = data.draw(st.integers(0, len(text) - 1))
    other = data.draw(st.integers(0, 255).filter(lambda byte: byte != text[k]))
    assert differences(text, text[:k] + bytes([other]) + text[k + 1 :])


def test_a_program_of_many_lines_is_compared_line_by_line() -> None:
    sent = b"".join(b"X%d\n" % k for k in range(30_000))
    (one,) = differences(sent, sent.replace(b"X29999\n", b"X29998\n"))
    assert one.line == 30_000
