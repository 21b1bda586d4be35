"""A field is asked at places of the work offset, whatever the program's own shifts call them."""

from pathlib import Path

import numpy as np
import pytest

from tests.support.mapped import mapped
from trueloop.nc.field import function_field, table_field

RISING = table_field(
    np.array([-100.0, 0.0, 100.0]),
    np.zeros(1),
    np.zeros(1),
    np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.1, 0.0, 0.0]]),
)
"""1 µm along x for each mm of x above 0, nothing below."""
FANUC = (
    "G21 G90 G17 G94\nG54\nG0 X0. Y0. Z50.\nG52 X50. Y0.\nG1 X0. Y0. Z0. F100\nX10. Y0.\nG52 X0. Y0.\nG0 Z50.\nM30\n"
)
SIEMENS = "G90 G17 G71 G94\nG54\nG0 X0 Y0 Z50\n{0}\nG1 X0 Y0 Z0 F100\nX10 Y0\n{1}\nG0 Z50\nM30\n"
KLARTEXT = (
    "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S8000\n2 L X+0 Y+0 Z+50 R0 FMAX\n3 CYCL DEF 7.0 NULLPUNKT\n4 CYCL DEF 7.1 X+50\n"
    "5 L X+0 Y+0 Z+0 R0 F100\n6 L X+10 Y+0\n7 CYCL DEF 7.0 NULLPUNKT\n8 CYCL DEF 7.1 X+0\n9 L Z+50 R0 FMAX\n"
    "10 END PGM A MM\n"
)


@pytest.mark.parametrize(
    ("program", "dialect", "words"),
    [
        (FANUC, "fanuc-mill", ("X0.050", "X10.060")),
        (FANUC, "linuxcnc", ("X0.05000", "X10.06000")),
        (SIEMENS.format("TRANS X50", "TRANS"), "siemens", ("X0.0500", "X10.0600")),
        (SIEMENS.format("TRANS X20\nATRANS X30", "TRANS"), "siemens", ("X0.0500", "X10.0600")),
        (KLARTEXT, "heidenhain", ("X+0.0500", "X+10.0600")),
    ],
)
def test_one_place_is_displaced_one_way(program: str, dialect: str, words: tuple[str, str], tmp_path: Path) -> None:
    """Under a shift of 50 local 0 and 10 are x 50 and 60: 50 and 60 µm. The retract from x 60 stays where it is."""
    text, _ = mapped(tmp_path, program, RISING, dialect=dialect)
    before, after = program.splitlines(), [line for line in text.splitlines() if "corrected" not in line]
    changed = [new for old, new in zip(before, after, strict=True) if old != new]
    assert len(changed) == 2 and all(word in line.split() for word, line in zip(words, changed, strict=True))


def test_a_function_is_called_with_places_of_the_work_offset(tmp_path: Path) -> None:
    asked: list[np.ndarray] = []

    def field(points: np.ndarray) -> np.ndarray:
        asked.append(points)
        return points * [0.001, 0.0, 0.0]

    text, _ = mapped(tmp_path, FANUC, function_field(field, "rising"), dialect="fanuc-mill")
    assert "X10.060 " in text and "G0 Z50.\nM30" in text
    assert max(points[:, 0].max() for points in asked) == 60.0


def test_after_g92_positions_count_from_its_zero(tmp_path: Path) -> None:
    """The register calls x 0 of the offset 40: the table is that of the program, which G92 begins."""
    program = "G21 G90 G17 G94\nG54\nG0 X0. Y0. Z50.\nG92 X40. Y0.\nG1 X60. Y0. Z0. F100\nG0 X40. Y0. Z50.\nM30\n"
    text, _ = mapped(tmp_path, program, RISING, dialect="fanuc-mill")
    assert "G1 X60.060 Y0. Z0. F100" in text


def test_a_shift_that_is_put_aside_comes_back_as_the_shift_that_it_was(tmp_path: Path) -> None:
    """G92.3 brings back what G92.2 put aside: with it local 10 is x 60 of the work offset, as before."""
    program = "G21 G90 G17 G94\nG54\nG0 X0 Y0 Z50\nG52 X50 Y0\n{}G1 X10 Y0 Z0 F100\nG0 X0 Y0 Z50\nG52 X0 Y0\nM30\n"
    plain, aside = (
        mapped(tmp_path, program.format(codes), RISING, dialect="linuxcnc")[0] for codes in ("", "G92.2\nG92.3\n")
    )
    assert "G1 X10.06000 Y0 Z0 F100" in plain
    assert "G1 X10.06000 Y0 Z0 F100" in aside
