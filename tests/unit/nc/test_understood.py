"""Programs whose coordinates are not followed must not be changed."""

import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.nc.program.program import read_program
from trueloop.nc.program.understood import require_known_frame, require_unturned

TURNED = b"G21 G18\nG0 X50. Z2.\nG68 R30.\nG1 X40. Z0 F0.1\nG69\nM30\n"


def test_a_rotated_frame_before_a_cut_is_refused() -> None:
    with pytest.raises(TrueloopError) as caught:
        require_known_frame(read_program(TURNED, "fanuc-mill").run())
    assert caught.value.code is Code.NC_OPAQUE
    assert caught.value.place.line == 3


def test_after_the_last_cut_it_does_not_matter() -> None:
    late = TURNED.replace(b"G68 R30.\n", b"").replace(b"G69", b"G68")
    require_known_frame(read_program(late, "fanuc-mill").run())


def test_moves_in_turned_coordinates_are_not_corrected_by_their_words() -> None:
    """Those before and after stay open to it."""
    text = b"G21 G17 G90 G1 X5. Y0. F9.\nG68 X0. Y0. R30.\nX5. Y5.\nG69\nX0. Y0.\n"
    path = read_program(text, "fanuc-mill").run()
    require_unturned(path, [0, 2])
    with pytest.raises(TrueloopError, match="turned, mirrored or scaled in 1 of 2 moves") as caught:
        require_unturned(path, [0, 1])
    assert (caught.value.code, caught.value.place.line) == (Code.NC_MAP, 3)
