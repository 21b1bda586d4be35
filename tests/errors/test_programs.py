"""Programs with one fault each: their first line holds what is said of them, its place and code.

`(check fanuc-mill 3:1 NC-CODE: G777 …)`: how the program is used, its dialect, line and column, code and message.
"""

import re
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

import numpy as np
import pytest

from trueloop.errors import Code, Finding, TrueloopError
from trueloop.jobs.machine.mapped_program import map_program
from trueloop.nc.check.check import check
from trueloop.nc.edit.edit import displace_word, set_offset
from trueloop.nc.field import table_field
from trueloop.nc.match.contour import contour_of_program
from trueloop.nc.match.difference import path_difference
from trueloop.nc.program.along import feed_moves
from trueloop.nc.program.program import read_program

PROGRAMS: Final = sorted(Path(__file__).with_name("programs").iterdir())
PRODUCERS: Final[dict[Code, Callable[[], object]]] = {}
FIRST_LINE: Final = re.compile(r"(?P<how>\w+) (?P<dialect>\S+) (?P<said>\d+:\d+ (?P<code>[A-Z-]+): .*)")
BY_MORE_THAN_A_PROGRAM: Final = {
    Code.NC_FILE,  # a file that is not there
    *(Code.NC_COMPENSATED, Code.NC_NO_MATCH, Code.NC_AMBIGUOUS),  # a profile
    *(Code.NC_TOOL, Code.NC_GOUGE, Code.NC_ENTRY),  # a tool
    *(Code.NC_TOOLS, Code.NC_EDGE, Code.NC_NO_TOOL),  # several tools of a job
    Code.NC_BLEND,  # what the move before and after were corrected to
}
"""Codes that a program alone does not bring about; `PRODUCERS` of the other files do."""
STEP: Final = table_field(  # 0 up to x 50, from there by 100 µm/mm
    np.array([0.0, 50.0, 60.0, 100.0]),
    np.zeros(1),
    np.zeros(1),
    np.column_stack([[0.0, 0.0, 1.0, 1.0], np.zeros(4), np.zeros(4)]),
)


def first_line(file: Path) -> re.Match[str]:
    """The comment in the first line, taken apart."""
    comment = file.read_text().splitlines()[0]
    found = FIRST_LINE.fullmatch(comment[1:-1] if comment.startswith("(") else comment.removeprefix("; "))
    assert found, comment
    return found


def said(file: Path) -> list[str]:
    """All that is said of a program when it is used as its first line says: `line:column CODE: message`."""
    head = first_line(file)
    try:
        findings = list(_used(file, head["how"], head["dialect"]))
    except TrueloopError as refused:
        return [_line(refused)]
    return [_line(finding) for finding in findings]


def _line(item: TrueloopError | Finding) -> str:
    return f"{item.place.line or 0}:{item.place.column or 0} {item.code}: {item.message}"


def _used(file: Path, how: str, dialect: str) -> Iterator[Finding]:
    program = read_program(file.read_bytes(), dialect)
    if how == "check":
        yield from check(program, block_limit=1000)
    elif how == "map":
        with tempfile.TemporaryDirectory() as folder:
            map_program(file, Path(folder, "out"), STEP, dialect=dialect)
    elif how == "diff":
        path_difference(program.run(), program.run())
    elif how == "contour":
        contour_of_program(feed_moves(program.run()), 0.4)
    elif how == "displace":
        path = program.run()
        displace_word(program, program.word(int(path.word[0].max())), 0.1, path.coordinate_state(0))
    else:
        assert how == "offset"
        set_offset(program, "X", 0.01, program.run().coordinate_state(0))


@pytest.mark.parametrize("file", PROGRAMS, ids=[file.name for file in PROGRAMS])
def test_what_is_said_is_what_its_first_line_says(file: Path) -> None:
    assert first_line(file)["said"] in said(file)


def test_every_code_of_a_program_has_one() -> None:
    produced = {first_line(file)["code"] for file in PROGRAMS}
    wanted = {code for code in Code if code.name.startswith("NC_")} - BY_MORE_THAN_A_PROGRAM
    assert wanted <= produced
