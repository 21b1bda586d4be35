"""Programs that position rotary axes between cuts: the tool in the work, by a machine written apart in 4×4 matrices."""

import math
import re

import numpy as np
import pytest

from tests.support.forward_model import ForwardMachine
from tests.support.machined_path import corrected, known_machine, physical
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.machine.correct import Setup

ZERO, TOOL = (30.0, -20.0, -150.0), (5.0, -8.0, -110.0)

ONCE = """G21 G90 G54
G0 A-30. C45.
G0 X-20 Y10 Z60
G1 Z5 F200
X40 Y25
X10 Y-30 Z8
G3 X30 Y-10 I0 J20
G0 Z80
"""
BETWEEN = f"""{ONCE}G0 A-15 C-60
X-10 Y0
G1 Z12
X30 Y20
Y-25
G0 Z80 A0 C0
G1 X35 F100
Z20
M30
"""


def _cuts(source: str, rotary: str) -> list[tuple[Array, Array, bool]]:
    """Start and end of every cut, mm and degrees of the rotary axes, by the words alone; whether an arc."""
    at = dict.fromkeys(f"XYZ{rotary}", 0.0)
    motion, found = 0, []
    for line in source.splitlines():
        words = re.findall(r"([A-Z])\s*(-?[\d.]+)", re.sub(r"\(.*?\)", "", line))
        codes = [int(float(value)) for letter, value in words if letter == "G"]
        motion = next((code for code in codes if code in (0, 1, 2, 3)), motion)
        before = np.array(list(at.values()))
        given = {letter: float(value) for letter, value in words if letter in at}
        at |= given
        if motion and set(given) & set("XYZ"):
            found.append((before, np.array(list(at.values())), motion > 1))
    return found


def _in_work(truth: ForwardMachine, rotary: str, sense: float, points: Array, share: float) -> Array:
    """The tool in work coordinates with that share of the machine's errors, at (n, 5) program positions."""
    axes = points[:, :3] + np.array(ZERO) - np.array(TOOL)
    at = {name: axes[:, k] for k, name in enumerate("XYZ")}
    at |= {name: np.radians(points[:, 3 + k]) for k, name in enumerate(rotary)}
    tool = np.tile([*TOOL, 1.0], (len(points), 1))[:, :, None]
    seen: Array = (truth.pose(physical(at, sense), share) @ tool)[:, :3, 0]
    return seen


def _off_um(structure: str, sense: float, source: str, written: str, *, ends: bool = False) -> tuple[float, float]:
    """Largest distance of starts and ends (or `ends` alone) of straight cuts, as the machine goes, from the lines
    that the program states: as written, and of the program as it was.
    """
    _, truth = known_machine(structure, sense)
    rotary = "".join(sorted(set(structure[-2:].upper())))
    wanted = [cut for cut in _cuts(source, rotary) if not cut[2]]
    lines = [
        _in_work(truth, rotary, sense, np.stack([start if (start[3:] == end[3:]).all() else end, end]), 0.0)
        for start, end, _ in wanted
    ]

    def off(cuts: list[tuple[Array, Array, bool]]) -> float:
        points = np.array([point for start, end, arc in cuts if not arc for point in (start, end)[ends:]])
        at = _in_work(truth, rotary, sense, points, 1.0)
        return 1e3 * max(min(_to_line(point, *line) for line in lines) for point in at)

    return off(_cuts(written, rotary)), off(wanted)


def _to_line(point: Array, start: Array, end: Array) -> float:
    way = end - start
    share = np.clip((point - start) @ way / (way @ way), 0, 1) if way.any() else 0.0
    return float(np.linalg.norm(point - start - share * way))


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("structure", ["five-axis-table-table-ac", "five-axis-table-table-bc"])
def test_the_program_itself_positions_the_tables(structure: str, sense: float) -> None:
    """Once, with --at before it, and between cuts: the tool goes where the program states, in the work."""
    model, _ = known_machine(structure, sense)
    first = structure[-2].upper()
    for source, fixed in ((ONCE, {first: math.radians(-30), "C": math.radians(45)}), (BETWEEN, {})):
        text = source.replace("A", first)
        written = corrected(text, model, Setup({1: ZERO}, {-1: TOOL}, fixed=fixed), 0.0002)
        after, before = _off_um(structure, sense, text, written)
        assert before > 10
        assert after < 0.5


def test_where_the_axes_stand_before_the_program_positions_them() -> None:
    """It is --at's until a word states it; without either the first move is refused, not taken to be at 0."""
    model, _ = known_machine("five-axis-table-table-ac", 1.0)
    text = "G21 G90 G54\nG0 X0 Y0 Z20\nG1 Z5 F100\nG0 Z50\nA-30\nG1 X10 F100\n"
    fixed = {"A": math.radians(10), "C": math.radians(45)}
    written = corrected(text, model, Setup({1: ZERO}, {-1: TOOL}, fixed=fixed))
    after, before = _off_um("five-axis-table-table-ac", 1.0, f"G0 A10 C45\n{text}", f"G0 A10 C45\n{written}", ends=True)
    assert before > 10 and after < 0.5
    assert len(_cuts(written, "AC")) == len(_cuts(text, "AC")) + 1  # to the start of the cut, as A-30 displaces it
    with pytest.raises(TrueloopError, match="rotary axis C has no stated position") as refused:
        corrected(text, model, Setup({1: ZERO}, {-1: TOOL}, fixed={"A": 0.0}))
    assert refused.value.code is Code.MCH_FRAME and "--at C=0" in (refused.value.hint or "")


HEAD = "G21 G90 G54\nG0 A0 C0\nG0 X0 Y0 Z20\nG1 Z5 F100\n"
POINTS = "G21 G90 G54\nG0 A0. C0.\nG0 X0. Y0. Z20.\nG1 Z5. F100.\nG0 Z30.\n"
SINUMERIK = "G71 G90 G54\nG0 A0 C0\nG0 X0 Y0 Z20\nG1 Z5 F100\nG0 Z30\n"


@pytest.mark.parametrize(
    ("dialect", "text", "words"),
    [
        ("linuxcnc", HEAD + "X10 A-5\n", "A turns at feed"),
        ("linuxcnc", HEAD + "C30\n", "C turns at feed"),
        ("linuxcnc", HEAD + "G2 X10 Y0 I5 J0 C3\n", "C turns at feed"),
        ("linuxcnc", HEAD + "G0 Z30\nG28 A0\nG0 X0 Y0 Z9\n", "A is at a place that is not known"),
        ("linuxcnc", "G21 G90 G54\nG91 G0 A5\nG90 C0\nX0 Y0 Z20\nG1 Z5 F100\n", "A is at a place that is not known"),
        ("linuxcnc", HEAD + "G92 A5\nG0 A-30 Z30\n", "A is at a place that is not known"),
        ("siemens", SINUMERIK + "TRANS A5\nG0 A-30 X5\n", "A is at a place that is not known"),
        ("linuxcnc", HEAD + "G0 Z30 B10\nG1 X5\n", "B does not stand at 0"),
        ("fanuc-mill", POINTS + "G43.4 H1\nG1 X5.\n", r"G43\.4"),
        ("fanuc-mill", POINTS + "G68.2 X0. Y0. Z0. I10. J20. K0.\nG53.1\nG1 X5.\n", r"G68\.2"),
        ("siemens", SINUMERIK + "TRAORI\nG1 X5\n", "TRAORI"),
        ("siemens", SINUMERIK + "G0 A1=30\nG1 X5\n", "an axis with a number"),
        ("heidenhain", "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+20 A+0 C+0 R0 FMAX\n2 M128\n3 L X+5 F100\n", "M128"),
        (
            "heidenhain",
            "0 BEGIN PGM A MM\n1 L X+0 Y+0 Z+20 A+0 C+0 R0 FMAX\n2 PLANE SPATIAL SPA+10 SPB+0 SPC+0 TURN FMAX\n"
            "3 L X+5 F100\n",
            "PLANE SPATIAL",
        ),
    ],
)
def test_what_linear_words_do_not_follow_is_refused_by_name(dialect: str, text: str, words: str) -> None:
    model, _ = known_machine("five-axis-table-table-ac", 1.0)
    setup = Setup({1: ZERO}, {-1: TOOL}, fixed={"A": 0.0, "C": 0.0})
    with pytest.raises(TrueloopError, match=words) as refused:
        corrected(text, model, setup, dialect=dialect)
    assert refused.value.place.line is not None


def test_a_head_that_the_program_turns_is_refused() -> None:
    model, _ = known_machine("five-axis-head-table-bc", 1.0)
    text = "G21 G90 G54\nG0 B0 C0\nX0 Y0 Z20\nG1 Z5 F100\nG0 Z20\nB10\nG1 X5\n"
    with pytest.raises(TrueloopError, match="B turns the tool") as refused:
        corrected(text, model, Setup({1: ZERO}, {-1: TOOL}))
    assert refused.value.code is Code.MCH_FRAME
