"""The diff shows every changed line, the changed words in it, and folds long replacements."""

import re

from trueloop.report.program_diff import changed_lines, program_diff

SOURCE = b"N1 G70\nN2 G01 X(P46+0.0625) Z-1.76\nN3 G02 X0.0 Z0.03125 R1.49125 ! Dome\nN4 G00 Z9.0\nN5 M05\nN6 M30\n"


def text_of(html: str) -> str:
    return re.sub(r"<[^>]+>", "", html)


def test_only_what_differs_in_a_line_is_marked() -> None:
    html = program_diff(SOURCE, SOURCE.replace(b"0.0625)", b"0.0625-0.00096)"))
    assert "X(P46+0.0625<ins>-0.00096</ins>)" in html
    assert "<del>" not in html
    assert html.count('class="line old"') == html.count('class="line new"') == 1


def test_two_changes_in_one_line_are_marked_apart() -> None:
    html = program_diff(SOURCE, SOURCE.replace(b"0.0625) Z-1.76", b"0.0623) Z-1.77"))
    assert "<ins>0.0623</ins>) Z-<ins>1.77</ins>" in html


def test_lines_keep_their_numbers_and_have_one_line_around_them() -> None:
    html = program_diff(SOURCE, SOURCE.replace(b"N4 G00", b"N4 G01"))
    numbers = re.findall(r"<b>(\d+)</b><i>(.)</i>", html)
    assert numbers == [("3", " "), ("4", "−"), ("4", "+"), ("5", " ")]


def test_an_arc_written_as_many_moves_is_folded_and_its_neighbours_stay_paired() -> None:
    moves = [b"N3 G01 X%d.5 Z-%d.25 F7" % (k, k) for k in range(12)]
    lines = SOURCE.splitlines()
    lines[2:3] = moves
    lines[1], lines[-2] = lines[1].replace(b"1.76", b"1.77"), lines[-2] + b"5"
    html = program_diff(SOURCE, b"\n".join(lines))
    assert "8 more lines</label><div class='folded'>" in html
    assert "Z-<ins>1.77</ins>" in html
    assert changed_lines(SOURCE, b"\n".join(lines)) == (3, 14)
    for move in moves:
        assert move.decode() in text_of(html)


def test_programs_are_text_not_markup() -> None:
    html = program_diff(SOURCE, SOURCE + b"(<script>alert(1)</script>)\n")
    assert "<script" not in html
    assert "&lt;script&gt;" in html


def test_a_program_in_another_encoding_is_shown_all_the_same() -> None:
    assert "ø" in program_diff(SOURCE, SOURCE + "(Ø ø)".encode("latin-1"))


def test_equal_programs_are_said_to_be_equal() -> None:
    assert program_diff(SOURCE, SOURCE) == "<p>No line differs from the source program.</p>"
