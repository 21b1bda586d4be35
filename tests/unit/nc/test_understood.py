"""Programs whose coordinates are not followed must not be changed."""

import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.nc.program.program import read_program
from trueloop.nc.program.understood import require_known_frame

TURNED = b"G21 G18\nG0 X50. Z2.\nG68 X0 Z0 R30.\nG1 X40. Z0 F0.1\nG69\nM30\n"


def test_a_rotated_frame_before_a_cut_is_refused() -> None:
    with pytest.raises(TrueloopError) as caught:
        require_known_frame(read_program(TURNED, "fanuc-mill").run())
    assert caught.value.code is Code.NC_OPAQUE
    assert caught.value.place.line == 3


def test_after_the_last_cut_it_does_not_matter() -> None:
    late = TURNED.replace(b"G68 X0 Z0 R30.\n", b"").replace(b"G69", b"G68")
    require_known_frame(read_program(late, "fanuc-mill").run())
