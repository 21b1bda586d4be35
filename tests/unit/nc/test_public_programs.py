"""LinuxCNC's sample programs: its own interpreter makes the same moves of them."""

from pathlib import Path

import pytest

from tests.support.linuxcnc import LATHE_STARTUP, Tool, interpret
from tests.support.nc_judge import assert_same_moves
from trueloop.nc.program import read_program

pytestmark = pytest.mark.corpus


@pytest.mark.parametrize(
    ("name", "plane", "moves"), [("linuxcnc-lathe-pawn.ngc", 18, 146), ("linuxcnc-3d-chips.ngc", 17, 4684)]
)
def test_linuxcnc_makes_the_same_moves(corpus: Path, name: str, plane: int, moves: int) -> None:
    file = corpus / "data" / "public" / "nc" / name
    path = read_program(file.read_bytes(), "linuxcnc", name).run(plane=plane)
    judged = interpret(file, tools=[Tool(1)], startup=LATHE_STARTUP.replace("G18", f"G{plane}"))
    assert len(path) == moves
    assert_same_moves(path, judged)
