"""Generated RS-274 programs: LinuxCNC's own interpreter makes the same moves of them."""

import tempfile
from pathlib import Path

from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from tests.support.linuxcnc import ProgramRefusedError, interpret
from tests.support.nc_judge import assert_same_moves
from trueloop.nc.program.program import read_program

PARAMETERS = range(1, 10)
NAMES = "abc"
PLANES = {17: ("X", "Y", "IJ", "Z"), 18: ("X", "Z", "IK", "Y"), 19: ("Y", "Z", "JK", "X")}

numbers = st.floats(-20, 20).map(lambda value: f"{value:.5f}")
axes = st.lists(st.sampled_from("XYZ"), min_size=1, max_size=3, unique=True)
leaves = numbers | st.sampled_from([f"#{n}" for n in PARAMETERS]) | st.sampled_from([f"#<{name}>" for name in NAMES])


def _compound(inner: st.SearchStrategy[str]) -> st.SearchStrategy[str]:
    operators = st.sampled_from(["+", "-", "*", "EQ", "NE", "GT", "GE", "LT", "LE", "AND", "OR", "XOR"])
    binary = st.builds("[{} {} {}]".format, inner, operators, inner)
    chain = st.builds("[{} {} {} {} {}]".format, inner, operators, inner, operators, inner)
    function = st.builds("{}[{}]".format, st.sampled_from(["SIN", "cos", "ABS", "round", "FIX", "fup"]), inner)
    others = st.sampled_from(["SQRT[ABS[{}]]", "-[{}]", "[{} MOD 3.7]", "ATAN[{}]/[2.5]", "[{} / 7]"])
    return binary | chain | function | st.builds(str.format, others, inner)


values = st.recursive(leaves, _compound, max_leaves=5)


@st.composite
def coordinates(draw: st.DrawFn) -> str:
    return " ".join(letter + draw(numbers | values) for letter in draw(axes))


@st.composite
def arcs(draw: st.DrawFn) -> str:
    """A plane, then a full turn (or several, or a helix) or an arc by its radius."""
    plane = draw(st.sampled_from(sorted(PLANES)))
    first, second, centres, third = PLANES[plane]
    code = draw(st.sampled_from(["G2", "G3"]))
    if draw(st.booleans()):
        ends = f"{first}{draw(numbers)} {second}{draw(numbers)} R{draw(st.sampled_from(['', '-']))}90"
        return f"G{plane} {code} {ends}"
    turn = " ".join(letter + draw(numbers) for letter in centres)
    helix = draw(st.sampled_from(["", f" {third}{draw(numbers)}", " P3"]))
    return f"G{plane} {code} {turn}{helix}"


@st.composite
def loops(draw: st.DrawFn) -> str:
    label, turns = draw(st.integers(100, 999)), draw(st.integers(0, 4))
    text = f"#10=0\no{label} while [#10 LT {turns}]\n#10=[#10+1]\no{label + 1000} if [#10 EQ 2]\nG1 {{}}\n"
    text += f"o{label + 1000} elseif [#10 GT 2]\nG1 {{}}\no{label + 1000} else\nG1 {{}}\n"
    return (text + f"o{label + 1000} endif\no{label} endwhile").format(*(draw(coordinates()) for _ in range(3)))


blocks = st.one_of(
    st.builds("G0 {}".format, coordinates()),
    st.builds("G1 {}".format, coordinates()),
    arcs(),
    loops(),
    st.sampled_from(["G20", "G21", "G90", "G91", "G7", "G8", "G92.1", "G92.2", "G92.3", "G54", "G55", "G59.3", "G28"]),
    st.builds("G92 {}".format, coordinates()),
    st.builds("G10 L{} P{} {}".format, st.sampled_from([2, 20]), st.sampled_from([0, 1, 2, 9]), coordinates()),
    st.builds("G90 G53 G{} {}".format, st.sampled_from([0, 1]), coordinates()),
    st.builds("G28 {}".format, coordinates()),
    st.builds("#{}={} #{}={}".format, st.sampled_from(PARAMETERS), values, st.sampled_from(PARAMETERS), values),
)
HEAD = [f"#{n}={0.7 * n - 2}" for n in PARAMETERS] + [f"#<{name}>={ord(name) - 95}" for name in NAMES]


@settings(max_examples=40, suppress_health_check=[HealthCheck.too_slow, HealthCheck.filter_too_much])
@given(st.lists(blocks, min_size=1, max_size=25))
def test_linuxcnc_makes_the_same_moves(body: list[str]) -> None:
    text = "\n".join([*HEAD, "G18 G21 F100", *body, "M2", ""])
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "program.ngc")
        file.write_text(text)
        try:
            judged = interpret(file)
        except ProgramRefusedError:
            assume(False)
    assert_same_moves(read_program(text.encode(), "linuxcnc").run(plane=18), judged)
