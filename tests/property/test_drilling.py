"""Drilling cycles: LinuxCNC's own interpreter makes the same moves of them."""

import tempfile
from pathlib import Path

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.support.linuxcnc import interpret
from tests.support.nc_judge import assert_same_moves
from trueloop.nc.program import read_program

AXES = {17: ("X", "Y", "Z"), 18: ("Z", "X", "Y"), 19: ("Y", "Z", "X")}
CYCLES = ["G81", "G82 P.1", "G83 Q{}", "G73 Q{}", "G85", "G86 P.1", "G89 P.1"]


@st.composite
def programs(draw: st.DrawFn) -> str:
    """Series of holes in any plane, with both retractions, absolute and by increments, repeated or not."""
    plane = draw(st.sampled_from(sorted(AXES)))
    first, second, third = AXES[plane]
    places = st.integers(-30, 30)
    height = st.integers(4, 12)
    blocks = [f"G{plane} G21 F100 S500 M3", f"G0 {third}{draw(height)}"]
    for _ in range(draw(st.integers(1, 3))):
        incremental = draw(st.booleans())
        cycle = draw(st.sampled_from(CYCLES)).format(draw(st.sampled_from(["1.5", "2", "7"])))
        plane_r, bottom = draw(st.integers(-1, 3)), -draw(st.integers(2, 9))
        mode = f"{'G91' if incremental else 'G90'} {draw(st.sampled_from(['G98', 'G99', '']))}"
        repeats = f" L{draw(st.integers(1, 3))}" if draw(st.booleans()) else ""
        blocks.append(
            f"{mode} {cycle} {first}{draw(places)} {second}{draw(places)} {third}{bottom} R{plane_r}{repeats}"
        )
        blocks += [f"{draw(st.sampled_from([first, second]))}{draw(places)}" for _ in range(draw(st.integers(0, 3)))]
        if draw(st.booleans()):
            blocks.append(f"G80 G90 G0 {third}{draw(height)}")
    return "\n".join([*blocks, "G80", "G90 G0 X0 Y0 Z20", "M2", ""])


@given(text=programs())
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_linuxcnc_makes_the_same_moves(text: str) -> None:
    path = read_program(text.encode(), "linuxcnc").run(inch=False)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "case.ngc")
        file.write_text(text)
        assert_same_moves(path, interpret(file, startup="G17 G21 G40 G90 G94"))
