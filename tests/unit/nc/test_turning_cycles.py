"""Cycles of Fanuc and Haas lathes: every move worked out by hand, x a radius."""

import math

import pytest

from trueloop.errors import Code
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import Motion, ToolPath

Row = tuple[str, float, float]
START = "G21\nG00 X60. Z2.\n"


def run(text: str, dialect: str = "fanuc-lathe") -> ToolPath:
    return read_program((START + text).encode(), dialect).run()


def rows(path: ToolPath, first: int = 1) -> list[tuple[str, float, float]]:
    """Kind and end of the moves from the one of that index on that lead anywhere."""
    leads = (path.start_mm != path.end_mm).any(axis=1)
    leads[:first] = False
    return [
        (Motion(kind).name.lower(), float(round(x, 9)), float(round(z, 9)))
        for kind, (x, _, z) in zip(path.motion[leads], path.end_mm[leads].tolist(), strict=True)
    ]


def box(x: float, z: float, taper: float = 0.0, cut: str = "line", out: str = "line") -> list[tuple[str, float, float]]:
    """From radius 30 at z = 2, a pass that ends at radius x."""
    return [("rapid", x + taper, 2), (cut, x, z), (out, 30, z), ("rapid", 30, 2)]


@pytest.mark.parametrize(("code", "dialect"), [("G90", "fanuc-lathe"), ("G90", "haas-lathe"), ("G77", "fanuc-lathe-b")])
def test_passes_along_z_are_repeated_with_what_changes(code: str, dialect: str) -> None:
    """X is a diameter: X50. cuts at radius 25. R is a radius, so that R-1. begins 1 mm nearer the axis, not 0.5."""
    path = run(f"{code} X50. Z-20. F.2\nX40.\nX30. Z-10. R-1.\nG00 X70.", dialect)
    assert path.findings == ()
    assert rows(path) == [*box(25, -20), *box(20, -20), *box(15, -10, -1), ("rapid", 35, 2)]
    assert path.line.tolist() == [2, *[3] * 4, *[4] * 4, *[5] * 4, 6]


def test_increments_count_from_where_the_cycle_begins_and_u_on_the_diameter() -> None:
    assert rows(run("G90 U-10. W-22. F.2\nU-20.")) == [*box(25, -20), *box(20, -20)]


@pytest.mark.parametrize("taper", ["R-1.", "I-1."])
def test_a_threading_pass_runs_in_step_and_comes_out_at_rapid(taper: str) -> None:
    path = run(f"G92 X50. Z-20. {taper} F1.5\nX49.")
    threads = [*box(25, -20, -1, "thread", "rapid"), *box(24.5, -20, -1, "thread", "rapid")]
    assert rows(path) == threads
    assert path.feed[2] == 1.5
    (found,) = path.findings
    assert (found.code, found.severity) == (Code.NC_OPAQUE, "note")


@pytest.mark.parametrize("taper", ["R-3.", "K-3."])
def test_a_facing_pass_goes_in_along_x(taper: str) -> None:
    path = run(f"G94 X20. Z-5. F.2\nZ-6. {taper}")
    face = [("rapid", 30, -5), ("line", 10, -5), ("line", 10, 2), ("rapid", 30, 2)]
    taper_face = [("rapid", 30, -9), ("line", 10, -6), ("line", 10, 2), ("rapid", 30, 2)]
    assert rows(path) == face + taper_face


def test_a_pass_without_its_end_is_refused() -> None:
    (found,) = run("G90 Z-20. F.2").findings
    assert (found.code, found.message) == (
        Code.NC_MISPLACED,
        "a simple turning cycle without the X and the Z of its end",
    )


def test_a_thread_of_two_blocks() -> None:
    """Height 1 mm (P1000), first pass 0.5 mm (Q500), least step 0.1 mm, 0.1 mm left for the two finishing passes:
    depths 0.5, 0.5 sqrt 2, 0.5 sqrt 3 and the roughing's last at 0.9, then 1 and 1. The root is at radius 10: X20."""
    path = run("G76 P020060 Q100 R.1\nG76 X20. Z-20. P1000 Q500 F1.5")
    cut = [row for row in rows(path) if row[0] == "thread"]
    depths = [0.5, 0.5 * math.sqrt(2), 0.5 * math.sqrt(3), 0.9, 1.0, 1.0]
    assert [row[1] for row in cut] == pytest.approx([11 - depth for depth in depths])
    assert {row[2] for row in cut} == {-20}
    starts = path.start_mm[path.motion == Motion.THREAD]
    assert starts[:, 2] == pytest.approx([2 - depth * math.tan(math.radians(30)) for depth in depths])
    assert path.end_mm[-1].tolist() == [30, 0, 2]


def test_a_thread_of_one_block_with_its_taper_on_the_radius() -> None:
    path = run("G76 X20. Z-20. I-1. K1. D.5 A0 F1.5", "haas-lathe")
    thread = path.motion == Motion.THREAD
    depths = [0.5, 0.5 * math.sqrt(2), 0.5 * math.sqrt(3), 1.0]
    assert path.end_mm[thread, 0] == pytest.approx([11 - depth for depth in depths])
    assert path.start_mm[thread, 0] == pytest.approx([10 - depth for depth in depths])


def test_a_thread_inside() -> None:
    path = read_program(b"G21\nG00 X16. Z2.\nG76 P010000 Q100 R0\nG76 X20. Z-9. P1000 Q1000 F1.", "fanuc-lathe").run()
    assert path.end_mm[path.motion == Motion.THREAD, 0].tolist() == [10]


def test_a_thread_is_pulled_out_at_45_degrees_over_tenths_of_its_lead() -> None:
    """P0112..: 12 tenths of the lead 2 mm are 2.4 mm (HUST H6D-T manual, page 3-59); from z = -17.6 at radius 10."""
    path = run("G76 P011200 Q100 R0\nG76 X20. Z-20. P1000 Q1000 F2.")
    assert rows(path) == [
        ("rapid", 10, 2),
        ("thread", 10, -17.6),
        ("thread", 12.4, -20),
        ("rapid", 30, -20),
        ("rapid", 30, 2),
    ]
    assert path.findings == ()


def test_a_thread_in_inches_with_its_least_step() -> None:
    """G76 as a shop had it: height 0.0511, first 0.012, least 0.002 in. 0.012 (sqrt 9 - sqrt 8) is more than 0.002,
    0.012 (sqrt 10 - sqrt 9) less: from depth 0.036 on it is 0.002 a pass, seven more to 0.050, then 0.0511, twice."""
    words = b"G20\nG00 X2. Z.2\nG76 P020060 Q20 R0.\nG76 X1.6398 Z-2.275 P511 Q120 F.083333"
    path = read_program(words, "fanuc-lathe").run()
    cut = path.motion == Motion.THREAD
    depths = [0.012 * math.sqrt(n) for n in range(1, 10)] + [0.036 + 0.002 * n for n in range(1, 8)] + [0.0511] * 2
    assert path.end_mm[cut, 0] / 25.4 == pytest.approx([1.6398 / 2 + 0.0511 - depth for depth in depths])
    assert path.feed[cut] == pytest.approx(0.083333 * 25.4)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("G76 P010060 Q0 R0\nG76 X20. Z-20. P1000 Q500 F1.", "where its passes begin along Z"),
        ("G76 X20. Z-20. P1000 Q500 F1.", "how it is pulled out"),
        ("G76 X20. Z-20. K1. D.5 F1.", "the least step and what is left for finishing"),
    ],
)
def test_what_a_thread_leaves_to_the_control_is_said(words: str, said: str) -> None:
    (found,) = run(words).findings
    assert (found.code, found.severity) == (Code.NC_OPAQUE, "note")
    assert said in found.message


@pytest.mark.parametrize(
    "words",
    [
        "X20. Z-20. P1000 F1.",  # no first depth
        "X20. Z-20. P1000 Q2000 F1.",  # deeper than the thread
        "X20. P1000 Q500 F1.",  # no length
        "Z-20. P1000 Q500 F1.",  # no side on which the part is
        "X20. Z-20. K1. D.5 P7 F1.",  # no way of cutting
        "X20. Z-20. K1. D.5 A180 F1.",  # no point
    ],
)
def test_a_thread_whose_words_make_no_sense_is_refused(words: str) -> None:
    path = run(f"G76 {words}")
    assert [found.code for found in path.findings] == [Code.NC_MISPLACED]
    assert len(path) == 1


def test_more_left_for_finishing_than_the_thread_is_high_is_refused() -> None:
    path = run("G76 P010060 Q0 R2.\nG76 X20. Z-20. P1000 Q500 F1.")
    assert Code.NC_MISPLACED in [found.code for found in path.findings]
    assert len(path) == 1


def test_drilling_the_face_counts_r_from_the_start() -> None:
    """From z = 2 to R-1.: z = 1; to the bottom at feed, out to where it began. The second hole is given from R."""
    path = run("G00 X0.\nG83 Z-20. R-1. F.1\nG80\nG85 W-9. R-1.")
    down = [("rapid", 0, 1), ("line", 0, -20), ("rapid", 0, 2)]
    ream = [("rapid", 0, 1), ("line", 0, -8), ("line", 0, 1), ("rapid", 0, 2)]
    assert rows(path, 2) == down + ream
    assert path.findings == ()


def test_drilling_the_side_along_x_counts_its_bottom_on_the_diameter() -> None:
    """From radius 30: R-5. is a radius, so that the plane is at 25; X20. is radius 10."""
    path = run("G87 X20. Z-10. R-5. F.1")
    expected = [("rapid", 30, -10), ("rapid", 25, -10), ("line", 10, -10), ("rapid", 30, -10)]
    assert rows(path) == expected


def test_pecks_of_a_lathe_and_r_of_haas_is_a_position() -> None:
    path = run("G00 X0.\nG83 Z-4. R1. Q3. F.1", "haas-lathe")
    peck = [
        ("rapid", 0, 1),
        ("line", 0, -2),
        ("rapid", 0, 1),
        ("rapid", 0, -2 + 0.254),
        ("line", 0, -4),
        ("rapid", 0, 2),
    ]
    assert rows(path, 2) == peck
    assert [found.code for found in path.findings] == [Code.NC_OPAQUE]


def test_where_drilling_goes_back_to_in_code_system_b() -> None:
    assert rows(run("G00 X0.\nG99 G83 Z-20. R-1. F.1", "fanuc-lathe-b"), 2)[-1] == ("rapid", 0, 1)
