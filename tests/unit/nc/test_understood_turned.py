"""The turning loop refuses finish passes that a rotary axis turns, or that a macro which is not seen interrupts."""

import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.nc.program.program import read_program
from trueloop.nc.program.understood import require_seen, require_unturned


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


@pytest.mark.parametrize(
    ("after", "missing"),
    [
        ("G65 P9810 X9.\nG1 Z-9.\n", "XZ stand"),
        ("G65 P9810 X9.\nG0 X20.\nG1 Z-9.\n", "Z stands"),
        ("G66 P9810\nG0 X20. W1.\nG1 Z-9.\n", "Z stands"),
        ("G65 P9810 X9.\nG0 X20. Z1.\nG1 Z-#501\n", "the value of Z-#501"),
        ("G65 P9810 X9.\nG0 X20. Z1.\nG1 Z-9.\n", ""),
        ("G65 P9810 X9.\nG0 X20. Z1.\nG1 Z-#1\n", ""),
    ],
)
def test_after_a_macro_of_another_file_each_axis_is_named_again(after: str, missing: str) -> None:
    program = read_program(f"G21 #1=9.\n#501=9.\nG0 X20. Z1.\nG1 Z-5. F.1\n{after}".encode(), "fanuc-lathe")
    path = program.run()
    moves = [move for move in range(len(path)) if not path.rapid[move]]
    if not missing:
        return require_seen(program, path, moves, "XZ")
    with pytest.raises(TrueloopError, match=f"between cuts that are corrected: .*{missing}") as refused:
        require_seen(program, path, moves, "XZ")
    assert (refused.value.code, refused.value.place.line) == (Code.NC_OPAQUE, 5)
    require_seen(program, path, moves[:1], "XZ")  # behind the last one nothing depends on it
    return None


@pytest.mark.parametrize(("after", "refused"), [("L Z-2\n", True), ("L X+1 Y+1 Z+9 FMAX\nL Z-2\n", False)])
def test_after_a_way_of_the_control_s_own_each_axis_is_named_again(after: str, refused: bool) -> None:
    text = f"BEGIN PGM A MM\nL X+1 Y+1 Z-1 R0 F9\nAPPR PLT PA+90 PR+10 LEN15 RL\n{after}L X+3 Y+1\n"
    program = read_program(text.encode(), "heidenhain")
    path = program.run()
    moves = [move for move in range(len(path)) if not path.rapid[move]]
    if refused:
        with pytest.raises(TrueloopError, match=r"APPR PLT .* between cuts that are corrected: where XYZ stand"):
            require_seen(program, path, moves, "XYZ")
    else:
        require_seen(program, path, moves, "XYZ")
