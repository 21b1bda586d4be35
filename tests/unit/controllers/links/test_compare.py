"""What counts as another program."""

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from trueloop.controllers.links.compare import Change, differences, differing_words
from trueloop.nc.program.dialect import DIALECTS

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


def test_lines_alike_before_and_after_are_no_part_of_the_alignment() -> None:
    lines = [b"X%d\n" % k for k in range(30_000)]
    (one,) = differences(b"".join(lines), b"".join([*lines[:15_000], b"Z1\n", *lines[15_000:]]))
    assert (one.line, one.other_line, one.after) == (None, 15_001, "Z1\n")


def test_changed_lines_are_paired_with_their_new_versions() -> None:
    sent = b"N10 G0 X50\nN20 G1 X10. Z-5.\nN30 G1 Z-7.\nM30\n"
    at_control = b"N10 G0 X50\nG4 P2\nN20 G1 X9.9 Z-5.\nN30 G1 Z-7.1\nM30\n"
    found = [(one.line, one.other_line) for one in differences(sent, at_control)]
    assert found == [(None, 2), (2, 3), (3, 4)]


def words(before: str, after: str, dialect: str = "fanuc-lathe", *passes: Change) -> list[tuple[object, ...]]:
    found = differing_words(before, after, dialect, frozenset(passes))
    return [(one.what, one.column, one.before, one.other_column, one.after) for one in found]


def test_words_that_differ_are_named_with_their_columns_and_both_values() -> None:
    assert words("N20 G1 X10.0 Z-5.", "N20G1X10. Z-5.") == [("X", 8, "X10.0", 6, "X10.")]
    assert words("G1 X10. Z5.", "G1 Z5. F.2") == [("X", 4, "X10.", None, None), ("F", None, None, 8, "F.2")]
    assert words("G0 G90 X1", "G90 X1") == [("G", 1, "G0", None, None)]
    assert words("M30 (END)", "M30 (ENDE)") == [("comment", 5, "(END)", 5, "(ENDE)")]
    assert words("#101=10.", "#101=11.") == [("#", 1, "#101=10.", 1, "#101=11.")]
    assert words("g1 x1. (a)", "G1 X2. (A)", "fanuc-lathe", Change.CAPITALS) == [("X", 4, "x1.", 4, "X2.")]
    assert words("L X+1,5 FMAX", "L X+1,6 FMAX", "heidenhain") == [("X", 3, "X+1,5", 3, "X+1,6")]
    assert words("N1 X=IC(5)", "N1 X=AC(5)", "siemens") == [("X", 4, "X=IC(5)", 4, "X=AC(5)")]
    assert words("M30", "M30\x80") == [("text", None, None, 4, "\x80")]


def test_blanks_and_line_ends_are_named_where_nothing_else_differs() -> None:
    assert words("G1 X1\n", "G1 X1\r\n") == [("line end", 1, "G1 X1\n", 1, "G1 X1\r\n")]
    assert words("G1 X1\n", "G1X1\n") == [("blanks", 1, "G1 X1\n", 1, "G1X1\n")]


DIALECT_NAMES = st.sampled_from(sorted(DIALECTS))
LINE = st.text(st.characters(max_codepoint=255, exclude_characters="\r\n"), max_size=40)


@given(LINE, LINE, DIALECT_NAMES)
def test_every_line_that_differs_has_a_word_that_does(before: str, after: str, dialect: str) -> None:
    assume(before != after)
    found = differing_words(before, after, dialect, frozenset())
    assert found and all(one.before != one.after for one in found)
    for one in found:
        for line, column, text in ((before, one.column, one.before), (after, one.other_column, one.after)):
            assert column is None or (text is not None and line[column - 1 :].startswith(text))
            assert (column is None) == (text is None)
