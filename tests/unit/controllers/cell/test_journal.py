"""A journal holds what it took, through a crash, and says what it lost of a last line."""

from pathlib import Path

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from trueloop.controllers.linuxcnc.cell.journal import Entry, Journal, read
from trueloop.errors import Code, TrueloopError

FILE = Path("cell.journal")
LINES = [Entry(k + 1, "fact", {"run": f"O1.{k}", "why": "ü\n"}).line() for k in range(5)]


@given(st.integers(0, len(b"".join(LINES))))
def test_whatever_a_crash_leaves_all_whole_lines_are_read(cut: int) -> None:
    left = b"".join(LINES)[:cut]
    entries, end = read(left, FILE)
    assert len(entries) == left.count(b"\n")
    assert left[end:] == left.rpartition(b"\n")[2]


@given(st.integers(0, len(b"".join(LINES[:4])) - 1), st.integers(1, 255))
@example(LINES[0].index(b","), ord(",") ^ ord("\r"))
@example(len(b"".join(LINES[:4])) - 1, ord("\n") ^ ord(" "))
def test_a_damaged_line_before_the_last_is_refused(where: int, change: int) -> None:
    content = bytearray(b"".join(LINES))
    content[where] ^= change
    with pytest.raises(TrueloopError, match=Code.CEL_JOURNAL.value):
        read(bytes(content), FILE)


def test_a_torn_line_is_named_and_the_next_takes_its_place(tmp_path: Path) -> None:
    file = tmp_path / "cell.journal"
    file.write_bytes(LINES[0] + LINES[1] + LINES[2][:20])
    journal = Journal(file)
    assert (len(journal.entries), journal.torn) == (2, LINES[2][:20])
    journal.add("fact", run="O1.2", what="ended")
    journal.close()
    assert [one.no for one in read(file.read_bytes(), file)[0]] == [1, 2, 3]


def test_a_journal_has_one_client(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "cell.journal")
    with pytest.raises(TrueloopError, match=Code.CEL_JOURNAL.value):
        Journal(tmp_path / "cell.journal")
    journal.close()
    Journal(tmp_path / "cell.journal").close()
