"""nc check: what it finds, and what it leaves alone."""

from collections.abc import Iterator
from pathlib import Path

import pytest

from trueloop.errors import Code, Finding
from trueloop.nc.check.check import check
from trueloop.nc.check.rapid import cutting_rapids
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import ToolPath

EXAMPLES = Path(__file__).parents[3] / "examples"
LATHE = "G21 G18 G8 G90 F100\n"


def found(text: str, code: Code, dialect: str = "linuxcnc", **options: float) -> list[tuple[int | None, str]]:
    findings = check(read_program(text.encode(), dialect), **options)  # type: ignore[arg-type]
    return [(finding.place.line, finding.message) for finding in findings if finding.code is code]


def test_an_arc_whose_end_is_off_its_circle() -> None:
    """5 µm along the circle change its radius by 2.5 nm, 5 µm across it by 5 µm."""
    assert found(f"{LATHE}G0 X10 Z0\nG2 X5.0050 Z5 I-5 K0.0000\n", Code.NC_ARC_FIT) == []
    ((line, message),) = found(f"{LATHE}G0 X10 Z0\nG2 X5 Z5.0050 I-5 K0.0000\n", Code.NC_ARC_FIT)
    assert line == 3
    assert "+0.00500 mm (+0.000197 in)" in message


def test_the_rounding_of_the_programs_decimals_is_granted() -> None:
    """The end is 0.7 µm off: nothing to say with three decimals, too much with four."""
    assert found(f"{LATHE}G0 X7.071 Z7.071\nG3 X10 Z0 I-7.071 K-7.071\n", Code.NC_ARC_FIT) == []
    assert found(f"{LATHE}G0 X7.0700 Z7.0710\nG3 X10 Z0 I-7.0700 K-7.0710\n", Code.NC_ARC_FIT) != []


def test_the_tolerance_can_be_named() -> None:
    text = f"{LATHE}G0 X10 Z0\nG2 X5 Z5.0050 I-5 K0\n"
    assert found(text, Code.NC_ARC_FIT, arc_tolerance_mm=0.0051) == []
    assert len(found(text, Code.NC_ARC_FIT, arc_tolerance_mm=0.0049)) == 1


def test_a_chord_a_little_longer_than_the_diameter() -> None:
    ((_, message),) = found("G70\nG00 X0 Z0\nG02 X0 Z2.00010 R1.0 F1\n", Code.NC_ARC_FIT, "ge2000t")
    assert "+0.000050 in" in message


@pytest.mark.parametrize(("rise", "is_found"), [(0.0, False), (0.001, False), (0.5, True), (0.9, False)])
def test_a_tangency_a_little_broken(rise: float, is_found: bool) -> None:
    """A line along z of 10 mm that rises: 0.5 mm are 2.86°, 0.001 mm are rounding, 0.9 mm (5.14°) is a corner."""
    text = f"{LATHE}G0 X{10 - rise} Z-10\nG1 X10 Z0\nG2 X5 Z5 I-5 K0\n"
    assert (found(text, Code.NC_TANGENT) != []) is is_found


def test_short_lines_may_be_kinked_by_their_rounding() -> None:
    """A line of 0.02 mm with a step of 0.001 mm has no direction to speak of."""
    assert found(f"{LATHE}G0 X9.999 Z-0.02\nG1 X10.000 Z0\nG2 X5 Z5 I-5 K0\n", Code.NC_TANGENT) == []


def test_a_cut_without_feed() -> None:
    ((line, message),) = found("G21\nG0 X1\nG1 X2\nG1 X3 F10\nG95\nG1 X4\n", Code.NC_FEED)
    assert line == 3
    assert "2 of 3" in message


def test_every_undefined_parameter_is_listed() -> None:
    assert [line for line, _ in found("G70\nG00 X(P1)\nZ(P2+P3)", Code.NC_PARAMETER, "ge2000t")] == [2, 3, 3]


def test_a_finding_of_a_loop_is_said_once() -> None:
    text = f"{LATHE}o1 repeat [5]\nG1 X9 Z-10\nG1 X10 Z0\nG2 X5 Z5 I-5.5 K0\no1 endrepeat\n"
    assert len(found(text, Code.NC_ARC_FIT)) == 1


def test_findings_come_in_order_of_place_and_name_the_file() -> None:
    program = read_program(b"G21 G61 ??\nG1 X1\nG1 X2 X3 G123\n", "linuxcnc", "a.ngc")
    places = [finding.place for finding in check(program)]
    assert [(place.file, place.line) for place in places] == [("a.ngc", 1), ("a.ngc", 2), ("a.ngc", 3), ("a.ngc", 3)]


FACED = LATHE + "G0 X20 Z0\nG1 X0\nG0 Z1\nG0 X15\nG1 Z-30\nG1 X20\nG0 Z1\n"
"""A bar faced and turned to radius 15."""


@pytest.mark.parametrize(
    ("then", "depth"),
    [
        ("G0 X15\nG0 Z-20\n", None),
        ("G0 X14.995\nG0 Z-20\n", None),
        ("G0 X14\nG0 Z-20\n", "1.000 mm"),
        ("G0 X10\nG1 Z-10\nG1 X14\nG0 Z-20\n", "1.000 mm"),
        ("G0 X10\nG1 Z-10\nG1 X20\nG0 X16\nG0 Z-25\n", None),
        ("G0 X10\nG1 Z-10\nG1 X20\nG0 X12 Z-5\n", None),
        ("G0 X10\nG1 Z-10\nG1 X20\nG0 X12 Z-15\n", "3.000 mm"),
    ],
)
def test_a_rapid_move_below_what_was_cut(then: str, depth: str | None) -> None:
    messages = [message for _, message in found(FACED + then, Code.NC_RAPID)]
    assert len(messages) == (depth is not None)
    assert all(depth is not None and depth in message for message in messages)


@pytest.mark.parametrize(("example", "diameter_in"), [("modbas2", 3.52), ("piecs11", 5.3), ("facetst", 5.62)])
def test_a_cut_of_the_contour_made_at_rapid(example: str, diameter_in: float) -> None:
    """Every line of the finish contour in turn, from the second on: the first is the approach."""
    source = (EXAMPLES / example / "finish.nc").read_text()
    parameters = dict.fromkeys(("P44", "P45", "P47", "P48"), 0.0) | {"P42": 20.0, "P46": diameter_in}
    lines = source.splitlines()
    cuts = [k for k, line in enumerate(lines) if " G01 " in line and "!" in line and "past" not in line][1:]
    assert len(cuts) >= 3
    for k in cuts:
        mistaken = [*lines[:k], lines[k].replace("G01", "G00"), *lines[k + 1 :]]
        findings = check(read_program("\n".join(mistaken).encode(), "ge2000t"), parameters)
        assert (k + 1, Code.NC_RAPID) in [(f.place.line, f.code) for f in findings], lines[k]


def test_boring_is_left_alone() -> None:
    """The bar is drilled to the axis and bored: the rapid moves run inside the bore."""
    text = LATHE + "G0 X0 Z5\nG1 Z-40\nG0 Z5\nG0 X10\nG1 Z-30\nG0 X9\nG0 Z5\nG0 X12\nG1 Z-30\nG0 X11\nG0 Z5\n"
    assert found(text, Code.NC_RAPID) == []


def test_a_groove_is_left_the_way_it_was_cut() -> None:
    text = LATHE + "G0 X10 Z0\nG1 X12\nG0 X9.9\nG1 Z-20\nG1 X8\nG0 X9\nG1 Z-30\n"
    assert found(text, Code.NC_RAPID) == []


@pytest.mark.parametrize("name", ["modbas2", "piecs11", "facetst", "linuxcnc"])
def test_the_examples_are_clean(name: str) -> None:
    parameters = dict.fromkeys(("P44", "P45", "P47", "P48"), 0.0) | {"P41": 20.0, "P42": 20.0, "P46": 3.52}
    for file in sorted((EXAMPLES / name).glob("*.n*c")):
        dialect = "linuxcnc" if file.suffix == ".ngc" else "ge2000t"
        findings = check(read_program(file.read_bytes(), dialect), parameters if dialect == "ge2000t" else None)
        assert [f for f in findings if f.code is not Code.NC_OPAQUE] == [], file


def test_check_gives_findings() -> None:
    assert all(isinstance(finding, Finding) for finding in check(read_program(b"G99", "ge2000t")))


@pytest.mark.parametrize(
    ("before", "said"),
    [
        ("", "no path mode before the first cut"),
        ("G64", "G64 without P"),
        ("G64 P0.002\nG64", "G64 without P"),
        ("/G64 P0.002", "no path mode before the first cut"),
    ],
)
def test_corners_that_linuxcnc_may_round(before: str, said: str) -> None:
    ((_, message),) = found(f"G21 F100\n{before}\nG0 X1\nG1 X2\nG61\n", Code.NC_BLEND)
    assert message.startswith(said)


@pytest.mark.parametrize("before", ["G61", "G61.1", "G64 P0.002", "G64\nG64 P0.002"])
def test_corners_that_linuxcnc_keeps(before: str) -> None:
    assert found(f"G21 F100\n{before}\nG0 X1\nG1 X2\nG64\n", Code.NC_BLEND) == []


def test_other_controls_keep_to_the_path() -> None:
    assert found("G71\nG00 X1.0\nG01 X2.0 F1\nG64\n", Code.NC_BLEND, "ge2000t") == []


def test_an_endless_program_is_looked_at_as_long_as_it_says_something_new(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each move is looked at for rapids in material: millions of turns of one loop took minutes and said the same."""
    looked_at: list[int] = []

    def spied(path: ToolPath, **options: bool) -> Iterator[tuple[int, float]]:
        looked_at.append(len(path))
        return cutting_rapids(path, **options)

    monkeypatch.setattr("trueloop.nc.check.check.cutting_rapids", spied)
    text = b"G21 G90 F100.\nG0 X0. Y0. Z0.\nN1 G1 X10.\nG3 X0. Y10. I-10.1 J0.\nG0 Y0.\nGOTO1\nM30\n"
    codes = [found.code for found in check(read_program(text, "fanuc-mill"), block_limit=300_000)]
    assert codes.count(Code.NC_LIMIT) == codes.count(Code.NC_ARC_FIT) == 1
    assert looked_at and max(looked_at) < 10_000
