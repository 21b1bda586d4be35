"""Where the mark of a corrected program stands: behind what a control wants first, so that it is stored with it."""

import pytest

from trueloop.nc.edit.changes import insert_heading
from trueloop.nc.edit.edit import apply_edits
from trueloop.nc.program.program import read_program


@pytest.mark.parametrize(
    ("text", "dialect", "line"),
    [
        ("%\nO2004\n(PLUG)\nG0 X1\n", "fanuc-lathe", 3),
        ("\n%\nO4542(PLATE 4542)\n(ID, PLATE)\nG0 X1\n", "fanuc-mill", 5),
        (":2004\nG0 X1\n", "haas-mill", 2),
        ("%\n<PLUG> (ROUND)\nG0 X1\n", "fanuc-mill", 3),
        ("O0001;\nG0 X1;\n", "fanuc-mill", 2),
        ("O100 sub\nG0 X1\nO100 endsub\n", "linuxcnc", 1),
        ("%\nG21\n%\n", "linuxcnc", 2),
        ("G21\nG0 X1\n", "linuxcnc", 1),
        ("%_N_PART_MPF\n;$PATH=/_N_WKS_DIR\nG0 X1\n", "siemens", 3),
        ("0 BEGIN PGM A MM\n1 L X+1\n", "heidenhain", 2),
        ("N0010 (ID,PROG, 030021, Finish)\nN0020 ! (ID,\nN0030 G01 X1\n", "ge2000t", 2),
    ],
)
@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_it_stands_behind_what_has_to_be_first(text: str, dialect: str, line: int, ending: str) -> None:
    program = read_program(text.replace("\n", ending).encode(), dialect)
    mark = program.dialect.comment("mark")
    written = apply_edits(program, [insert_heading(program, [mark])]).decode()
    lines = written.splitlines()
    assert lines.pop(line - 1).endswith(mark)
    assert lines == text.splitlines()
    assert "\n" not in written.replace(ending, "")


def test_it_stands_behind_a_byte_order_mark() -> None:
    for text in ("G21\nG0 X1\n", ""):
        program = read_program(text.encode("utf-8-sig"), "fanuc-mill")
        mark = program.dialect.comment("mark")
        written = apply_edits(program, [insert_heading(program, [mark])])
        assert written.decode("utf-8-sig") == f"{mark}\n{text}"


def test_it_is_numbered_where_the_block_before_is() -> None:
    program = read_program(b"N0010 (ID,PROG, 1)\nN0020 G01 X1\n", "ge2000t")
    assert apply_edits(program, [insert_heading(program, ["! one", "! two"])]) == (
        b"N0010 (ID,PROG, 1)\nN0011 ! one\nN0012 ! two\nN0020 G01 X1\n"
    )
