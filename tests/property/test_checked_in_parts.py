"""A program run in parts, of a line or of some, is the program run whole: the same findings in the same order, and the
same moves.
"""

from hypothesis import given
from hypothesis import strategies as st

from trueloop.nc.check.check import check, check_in_parts
from trueloop.nc.program.parts import stretches
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import csv_text

X = st.sampled_from(["0", "4.", "5.", "9.9", "10.", "10.005", "12.5"])
Y = st.sampled_from(["", "", "", " Y0.", " Y1."])
Z = st.sampled_from(["0", "-5.", "-10.", "-10.01", "2.", "30."])
RAPIDS = st.builds("G0 X{}{} Z{}".format, X, Y, Z)
LINES = st.builds("G1 X{}{} Z{}{}".format, X, Y, Z, st.sampled_from(["", " F0.2", " F100."]))
ARCS = st.builds("G{} X{} Z{} R{}".format, st.sampled_from("23"), X, Z, st.sampled_from(["2.", "5.", "5.003", "20."]))
OTHER = st.sampled_from([
    "T1", "T2", "T0101", "G61", "G64", "G64 P0.002", "G28 U0 W0", "G53 X0", "G17", "G18", "G90", "G92 X3.", "G20",
    "G21", "G94", "G95", "M3 S500", "M8", "(X1.23456)", "/G1 X3.", "", "X10. Z-5.", "Z-12 Z-13.", "G04 X1.", "M30",
])  # fmt: skip
BLOCKS = st.lists(st.one_of(RAPIDS, LINES, ARCS, OTHER), min_size=2, max_size=40)
DIALECTS = st.sampled_from(["linuxcnc", "fanuc-lathe", "haas-lathe", "fanuc-mill", "ge2000t"])


@given(st.sampled_from(["G21 G18\n", "G20\n", "G21 G18 G90 F100.\nT1\nG0 X20. Z30.\n"]), BLOCKS, DIALECTS, st.data())
def test_parts_say_what_the_whole_program_says(head: str, blocks: list[str], dialect: str, data: st.DataObject) -> None:
    source = (head + "\n".join(blocks) + "\n").encode()
    size = data.draw(st.integers(1, 80))
    program = read_program(source, dialect, "part.nc")
    checked = check_in_parts(source, dialect, "part.nc", None, {}, size=size)
    if checked is not None:
        assert checked.findings == check(program)
        assert checked.block_count == program.block_count
    path = program.run(strict=False)
    if not any(found.code == "NC-UNIT" for found in path.findings):
        printed = "".join(row for of in stretches(source, dialect, "part.nc", None, {}, size=size)
                          for row in csv_text(of.path, of.first))  # fmt: skip
        assert printed == "".join(csv_text(path))
