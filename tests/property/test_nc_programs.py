"""Generated programs: what is written can be read, what is read can be written back, and only edited spans change."""

import codecs
import string

from hypothesis import given
from hypothesis import strategies as st

from trueloop.nc.edit.edit import Edit, apply_edits
from trueloop.nc.program.dialect import DIALECTS
from trueloop.nc.program.program import read_program

numbers = st.from_regex(r"[-+]?[0-9]{1,3}(\.[0-9]{0,6})?", fullmatch=True)
spaces = st.sampled_from(["", " ", "  ", "\t"])
line_ends = st.sampled_from(["\n", "\r\n"])
dialects = st.sampled_from(sorted(DIALECTS))
comment_texts = st.text(string.ascii_letters + string.digits + " .,+é\xff", max_size=20)


@st.composite
def programs(draw: st.DrawFn) -> tuple[str, str, list[tuple[str, str]]]:
    """A dialect, a program in it, and its words: letter and number text, in order."""
    name = draw(dialects)
    dialect = DIALECTS[name]
    letters = "GXZIKFSTM" if name == "heidenhain" else "GXZIKRFSTM"  # Klartext's R0 is one of its words
    text, words = "", []
    for _ in range(draw(st.integers(0, 8))):
        for letter in draw(st.lists(st.sampled_from(letters), max_size=6)):
            number = draw(numbers)
            words.append((letter, number))
            text += draw(st.sampled_from([letter, letter.lower()])) + number + draw(spaces)
        if draw(st.booleans()):
            text += dialect.comment_open + draw(comment_texts) + dialect.comment_close
        text += draw(line_ends)
    return name, text, words


@given(programs())
def test_words_are_found_as_they_were_written(made: tuple[str, str, list[tuple[str, str]]]) -> None:
    name, text, words = made
    program = read_program(text.encode("latin-1"), name)
    found = [word for block in program.blocks for word in block.words]
    assert [(word.letter, word.value) for word in found] == [(letter, float(number)) for letter, number in words]
    assert all(program.source[w.value_start : w.end].decode() == n for w, (_, n) in zip(found, words, strict=True))


@given(st.binary(max_size=300), dialects)
def test_any_bytes_are_written_back(source: bytes, name: str) -> None:
    program = read_program(source, name)
    assert program.core.source() == apply_edits(program, []) == source
    marked = source.removeprefix(codecs.BOM_UTF8)  # which is before the first block
    assert b"".join(_block_bytes(source, block.start, block.end) for block in program.blocks) == marked
    program.run(strict=False, block_limit=1000)


def _block_bytes(source: bytes, start: int, end: int) -> bytes:
    """A block with the line end that follows it."""
    after = next((n for n in (2, 1) if source[end : end + n] == b"\r\n"[-n:]), 0)
    return source[start : end + after]


@given(st.binary(min_size=1, max_size=200), st.data())
def test_only_edited_spans_change(source: bytes, data: st.DataObject) -> None:
    cuts = sorted(data.draw(st.lists(st.integers(0, len(source)), min_size=2, max_size=8)))
    spans = list(zip(cuts[::2], cuts[1::2], strict=False))
    texts = [data.draw(st.text(string.ascii_uppercase, max_size=5)) for _ in spans]
    edits = [Edit(start, end, text) for (start, end), text in zip(spans, texts, strict=True)]
    expected, done = b"", 0
    for edit in edits:
        expected += source[done : edit.start] + edit.text.encode()
        done = edit.end
    program = read_program(source, "ge2000t")
    assert apply_edits(program, reversed(edits)) == expected + source[done:] or _share_a_place(spans)


def _share_a_place(spans: list[tuple[int, int]]) -> bool:
    """Insertions at one place keep the order in which they are given, which the reversal changes."""
    return len({place for span in spans for place in span}) < 2 * len(spans)
