"""The turning loop: a finish pass that is corrected must not be cut with a rotary axis turned."""

import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.nc.program.program import read_program
from trueloop.nc.program.understood import require_unturned


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("G21 G0 C0. X20. Z1.\nG1 Z-5. F.1\nG0 C90.\nG1 Z-9.\n", 4),
        ("G21 G0 C0. X20. Z1.\nG1 Z-5. F.1\nG0 H30.\nG1 Z-9.\n", 4),
        ("G21 G0 X20. Z1.\nG1 Z-5. F.1\nG0 C0.\nG1 Z-9.\n", 2),
    ],
)
def test_a_corrected_cut_with_c_turned_or_not_known_is_refused(text: str, line: int) -> None:
    path = read_program(text.encode(), "fanuc-lathe").run()
    with pytest.raises(TrueloopError, match="C does not stand at 0 degrees") as refused:
        require_unturned(path, [move for move in range(len(path)) if not path.rapid[move]])
    assert (refused.value.code, refused.value.place.line) == (Code.NC_MAP, line)


def test_at_zero_and_by_whole_turns_nothing_is_refused() -> None:
    path = read_program(b"G21 G0 C0. X20. Z1.\nG1 Z-5. F.1\nG0 H360.\nG1 Z-9.\n", "fanuc-lathe").run()
    require_unturned(path, [move for move in range(len(path)) if not path.rapid[move]])
