"""Splines of LinuxCNC under a field: written out as the chords that its interpreter makes, then displaced."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.support.cli import invoke
from tests.support.linuxcnc import interpret
from tests.support.mapped import MIXED, displaced_path, mapped, path_of
from tests.support.splines import splines
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.nc.field import affine_field, similarity_field
from trueloop.nc.match.difference import path_difference
from trueloop.nc.program.program import read_program

TURNED = similarity_field(shift_mm=(0.013, -0.021, 0.0), rotation_rad=2e-4, scale=1.0003, about_mm=(3.0, 4.0, 0.0))
HEAD = "G17 G21 G90 F100\nG0 X1 Y2 Z3\n"


def ends_mm(folder: Path, text: str) -> Array:
    """Of LinuxCNC's feed moves."""
    file = folder / "judged.ngc"
    file.write_text(text)
    moves = interpret(file, startup="G17 G21 G40 G90 G94")
    return np.array([move.end_mm for move in moves if move.kind == "line"])


@given(splines, st.sampled_from(["G20", "G21"]), st.sampled_from(["G90", "G91"]), st.booleans())
@settings(max_examples=20, deadline=None, suppress_health_check=list(HealthCheck))
def test_linuxcnc_goes_to_every_displaced_chord_end(
    tmp_path: Path, drawn: list[list[str]], unit: str, mode: str, numbered: bool
) -> None:
    blocks = [
        f"G17 {unit} G90 F100",
        "G0 X1 Y2 Z3",
        mode,
        *(block for spline in drawn for block in spline),
        "G1 X1 Y1",
        "M2",
    ]
    text = "".join(f"{f'N{10 * n} ' * numbered}{block} (kept {n})\n" for n, block in enumerate(blocks))
    before = ends_mm(tmp_path, text)
    written, done = mapped(tmp_path, text, TURNED)
    after = ends_mm(tmp_path, written)
    assert len(before) == len(after)
    step_mm = read_program(b"", "linuxcnc").dialect.step_mm(unit == "G20")
    assert np.abs(after - before - TURNED.displacement_mm(before)).max() <= 1.001 * step_mm
    assert not any(code in written for code in ("G5", "I", "P", "L"))
    assert [line.split("(")[1] for line in written.splitlines() if "(kept" in line] == [
        f"kept {n})" for n in range(len(blocks))
    ]
    assert done.added_blocks == written.count("\n") - 1 - len(blocks)


@pytest.mark.parametrize(("mode", "end"), [("G90", "X1 Y2"), ("G91", "X0 Y0")])
def test_a_spline_that_turns_back_on_itself_has_a_chord_of_no_length(tmp_path: Path, mode: str, end: str) -> None:
    text = HEAD + f"{mode}\nG5.1 {end} I10 J5\nG90 G1 X30\nM2\n"
    before = path_of(text)
    assert ((before.start_mm == before.end_mm).all(axis=1) & (before.line == 4)).sum() == 1
    written, done = mapped(tmp_path, text, MIXED)
    assert path_difference(path_of(written), displaced_path(before, MIXED)).distance_mm < 0.0006
    assert done.added_blocks >= 43


def test_chords_bend_with_the_field(tmp_path: Path) -> None:
    text = (
        HEAD + "G5 X40 Y25 I13 J0 P-13 Q0 F50\nX80 Y2 I10 J20 P-13 Q0\nG5.2 P1 L3 X92 Y1\nX93 Y30 P1\nX45 Y0 P2\nG5.3\n"
    )
    written, _ = mapped(tmp_path, text, MIXED)
    assert path_difference(path_of(written), displaced_path(path_of(text), MIXED)).distance_mm < 0.0006
    assert path_of(written).feed.max() == 100.0 and path_of(written).feed[-1] == 50.0


def test_the_command_takes_splines_and_leaves_what_no_field_reaches(tmp_path: Path) -> None:
    source, target = tmp_path / "curve.ngc", tmp_path / "out.ngc"
    source.write_text(HEAD + "G1 X0 Y0\nN10 G5.1 X10 Y0 I5 J5\nN20 M2\n")
    invoke("nc", "map", source, "--dialect", "linuxcnc", "--shift", "0.01,0,0", "--out", target, status=0)
    lines = target.read_text().splitlines()
    assert lines[1:4] == ["G17 G21 G90 F100", "G0 X1.01000 Y2 Z3", "G1 X0.01000 Y0"]
    assert lines[4].startswith("N10 G1 X0.23") and lines[-2].startswith("X10.01000 Y0.0000") and lines[-1] == "N20 M2"


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("#1=5\nG5 X10 Y#1 I3 J0 P-3 Q0\n", 4, "Y#1"),
        ("#1=5\nG5.2 P1 X#1 Y1\nX3 Y3 P1\nX9 Y9 P1\nG5.3\n", 7, "X#1"),
        ("G5.2 P1 X5 Y1\no1 repeat [2]\nX3 Y3 P1\no1 endrepeat\nG5.3\n", 7, "points of this spline"),
        ("o1 repeat [2]\nG5.1 X3 Y3 I1 J0\no1 endrepeat\n", 4, "runs several times"),
    ],
)
def test_splines_that_hang_on_more_are_refused(tmp_path: Path, text: str, line: int, words: str) -> None:
    with pytest.raises(TrueloopError) as refused:
        mapped(tmp_path, HEAD + text, affine_field(np.eye(3), (0.01, 0.0, 0.0)))
    assert (refused.value.code, refused.value.place.line) == (Code.NC_EDIT, line), refused.value
    assert words in refused.value.message


@pytest.mark.parametrize("spline", ["G5 X1 Y2 I0 J0 P0 Q0", "G5.1 X1 Y2 I0 J0"])
def test_a_spline_that_goes_nowhere_is_refused(tmp_path: Path, spline: str) -> None:
    """Its end would stay where it was, beside the displaced moves around it."""
    with pytest.raises(TrueloopError) as refused:
        mapped(tmp_path, f"{HEAD}{spline}\nG1 X9\nM2\n", TURNED)
    assert (refused.value.code, refused.value.place and refused.value.place.line) == (Code.NC_EDIT, 3)
