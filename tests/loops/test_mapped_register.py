"""Programs that set the position register (G50, G92) under a shift: by hand arithmetic, and NIST's as they were run."""

from pathlib import Path

import numpy as np
import pytest

from tests.support.mapped import FREE, mapped
from tests.support.refusals import refused
from trueloop.domain.option import MapOptions
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.machine.mapped_program import map_program
from trueloop.nc.field import similarity_field
from trueloop.nc.program.program import read_program

SHIFT_MM = (0.1, 0.0, -0.25)
SHIFT = similarity_field(shift_mm=SHIFT_MM)


def body(folder: Path, text: str, dialect: str, options: MapOptions = FREE) -> list[str]:
    """The mapped program's lines without the mark."""
    written = mapped(folder, text, SHIFT, dialect, options)[0].splitlines()
    return [line for line in written if "trueloop corrected" not in line]


def test_the_way_to_the_register_stays_and_the_cut_moves(tmp_path: Path) -> None:
    """0.1 mm on the radius are 0.2 mm of X: 0.007874 in, and -0.25 mm of Z are -0.009843 in. P41 matters nowhere."""
    source = (
        "G70 G94\nG00 X0 Z(P41)\nG92 X30.4 Z2.0\nT0300\nG00 X6.2 Z.1\nG95\nG01 F.01 X5.0 Z-1.0\n"
        "G81 X4.0 Z-1.5 F.01 P1=.1 P2=-1.2\nG94\nG01 F100. X30.4 Z2.0 T00 M05\nG92 X0 Z(P41)\nG00 X0 Z10.\nM30\n"
    )
    assert body(tmp_path, source, "ge2000t") == [
        "G70 G94",
        "G00 X0 Z(P41)",
        "G92 X30.4 Z2.0",
        "T0300",
        "G00 X6.20787 Z.09016",
        "G95",
        "G01 F.01 X5.00787 Z-1.00984",
        "G81 X4.00787 Z-1.50984 F.01 P1=.1 P2=-1.20984",
        "G94",
        "G01 F100. X30.4 Z2.0 T00 M05",
        "G92 X0 Z(P41)",
        "G00 X0 Z10.",
        "M30",
    ]


@pytest.mark.parametrize("back", [["G00 X200. Z300."], ["G00 X200.", "Z300."], ["G00 Z300. M5", "X200. T0100"]])
def test_the_next_part_begins_where_this_one_did(tmp_path: Path, back: list[str]) -> None:
    """G50 names the place where the tool stands: a return 0.25 mm beside it would shift each part further."""
    cut = ["G00 X40. Z2.", "G01 Z-30. F0.2", "G00 X44."]
    shifted = ["G00 X40.200 Z1.750", "G01 Z-30.250 F0.2", "G00 X44.200"]
    source = ["O1", "G21 G50 X200. Z300. S2000", *cut, *back, "M30"]
    assert body(tmp_path, "\n".join(source) + "\n", "fanuc-lathe") == [*source[:2], *shifted, *back, "M30"]


@pytest.mark.parametrize(
    ("back", "written"),
    [
        (["G00 U156. W330."], ["G00 U155.800 W330.250"]),
        (["G00 X200. W330."], ["G00 X200. W330.250"]),
        (["G00 U156.", "W300.", "W30. T0100"], ["G00 U155.800", "W300.", "W30.250 T0100"]),
    ],
)
def test_a_return_by_increments_ends_at_the_same_place(tmp_path: Path, back: list[str], written: list[str]) -> None:
    """The cut left the tool at X 44.2, Z -30.25: the increments that lead back differ by as much."""
    cut = ["O1", "G21 G50 X200. Z300. S2000", "G00 X40. Z2.", "G01 Z-30. F0.2", "G00 X44."]
    assert body(tmp_path, "\n".join([*cut, *back, "M30"]) + "\n", "fanuc-lathe")[5:-1] == written


LOOP = (
    "G21 G50 X200. Z300.\n#1=0\nWHILE [#1 LT 2] DO1\nG00 X40. Z2.\nG01 Z-30. F0.2\nG00 X44.\n{}#1=#1+1\nEND1\n{}M30\n"
)


def test_a_return_behind_a_loop_stays(tmp_path: Path) -> None:
    """Blocks behind the loop run once, after all others."""
    written = body(tmp_path, LOOP.format("", "G00 U156.\nZ300.\n"), "fanuc-lathe")
    assert written[3:6] == ["G00 X40.200 Z1.750", "G01 Z-30.250 F0.2", "G00 X44.200"]
    assert written[-3:] == ["G00 U155.800", "Z300.", "M30"]


def test_a_return_within_a_loop_is_refused(tmp_path: Path) -> None:
    """Blocks that run again do not show which one is the last: the next part would begin beside this one's place."""
    error = refused(mapped, tmp_path, LOOP.format("X200. Z300.\n", ""), SHIFT, "fanuc-lathe")
    assert (error.code, error.place.line) == (Code.NC_MAP, 7)
    assert "0.25000 mm off the place at which it sets its coordinates" in error.message


def test_only_a_return_that_ends_there_stays(tmp_path: Path) -> None:
    """Between two tools the way out is displaced like any other: nothing is set there."""
    source = "G21 G50 X200. Z300.\nG00 X40. Z2.\nG01 Z-30. F0.2\n{}M30\n"
    for back, written in (
        ("G00 X200. Z299.\n", ["G00 X200.200 Z298.750"]),
        ("G00 X200. Z300.\nX40. Z2.\nG01 Z-9.\n", ["G00 X200.200 Z299.750", "X40.200 Z1.750", "G01 Z-9.250"]),
    ):
        assert body(tmp_path, source.format(back), "fanuc-lathe")[3:-1] == written


def test_a_register_set_in_the_cut_is_refused(tmp_path: Path) -> None:
    """Its coordinates would be displaced twice; along an axis that it does not name they go on."""
    source = "G21 G90\nG0 X10. Y0. Z0.\nG1 X20. F100.\nG92 {}\nG1 X40.\nM30\n"
    error = refused(mapped, tmp_path, source.format("X0."), SHIFT, "fanuc-mill")
    assert (error.code, error.place.line) == (Code.NC_MAP, 4)
    assert "0.10000 mm off" in error.message
    assert body(tmp_path, source.format("Y0."), "fanuc-mill")[3:] == ["G92 Y0.", "G1 X40.100", "M30"]


def test_a_variable_of_an_osp_is_no_axis(tmp_path: Path) -> None:
    """V1 names no Y: a cut that names X and Z alone is displaced, by sums where values are computed."""
    source = "V1=10\nG90 G95 G00 X=V1*2 Z5\nG01 Z-5 F0.2\nX=V1+4 Z=-V1\nM02\n"
    written = body(tmp_path, source, "okuma-lathe", MapOptions(limit_mm=np.inf, slope=np.inf, unit="mm"))
    paths = [
        read_program(text.encode(), "okuma-lathe", unit="mm").run() for text in (source, "\n".join(written) + "\n")
    ]
    assert written[0] == "V1=10"
    assert paths[1].end_mm - paths[0].end_mm == pytest.approx(np.tile(SHIFT_MM, (3, 1)), abs=1e-9)


def test_an_osp_file_begins_with_its_name_and_its_arcs_keep_their_radius(tmp_path: Path) -> None:
    """The OSP sends a program behind `$NAME%`; L is the radius of an arc, which a shift leaves as it is."""
    source = "$SHAFT.MIN%\nO1\nG90 G95 G00 X40 Z2\nG01 Z0 F0.2\nG03 X44 Z-2 L2\nG01 Z-30\nM02\n"
    options = MapOptions(limit_mm=np.inf, slope=np.inf, unit="mm")
    shifted = ["G90 G95 G00 X40.200 Z1.750", "G01 Z-0.250 F0.2", "G03 X44.200 Z-2.250 L2", "G01 Z-30.250", "M02"]
    assert body(tmp_path, source, "okuma-lathe", options) == ["$SHAFT.MIN%", "O1", *shifted]
    grown = similarity_field(scale=1.005)
    written = mapped(tmp_path, source, grown, "okuma-lathe", options)[0].splitlines()
    assert "G03 X44.220 Z-2.010 L2.010" in written


CALLED = "OMAIN\nG90 G95 G00 X40 Z2\nCALL OSUB\nG00 X50\nCALL O7\nM02\nOSUB\nG01 Z-30 F0.2\nRTS\nO7\nG01 X60\nRTS\n"


def test_programs_that_an_osp_calls_by_name_are_run_and_displaced(tmp_path: Path) -> None:
    """A program ends with RTS. What stands behind the name, and a program that is not in the file, is not followed."""
    options = MapOptions(limit_mm=np.inf, slope=np.inf, unit="mm")
    path = read_program(CALLED.encode(), "okuma-lathe", unit="mm").run()
    assert path.end_mm[:, [0, 2]].tolist() == [[20.0, 2.0], [20.0, -30.0], [25.0, -30.0], [30.0, -30.0]]
    moved = ["G90 G95 G00 X40.200 Z1.750", "CALL OSUB", "G00 X50.200", "CALL O7", "M02", "OSUB", "G01 Z-30.250 F0.2"]
    assert body(tmp_path, CALLED, "okuma-lathe", options) == ["OMAIN", *moved, "RTS", "O7", "G01 X60.200", "RTS"]
    twice = body(tmp_path, CALLED.replace("CALL OSUB", "CALL OSUB Q2"), "okuma-lathe", options)
    assert twice == [
        "OMAIN",
        *(line.replace("CALL OSUB", "CALL OSUB Q2") for line in moved),
        "RTS",
        "O7",
        "G01 X60.200",
        "RTS",
    ]
    for other in ("CALL OSUB D=5", "CALL OGONE"):
        error = refused(mapped, tmp_path, CALLED.replace("CALL OSUB", other), SHIFT, "okuma-lathe", options)
        assert (error.code, error.place.line) == (Code.NC_OPAQUE, 3)


@pytest.mark.corpus
def test_nists_turning_programs_are_mapped(corpus: Path, tmp_path: Path) -> None:
    """All but the one whose arc lost its words in the scan. Cuts move by the shift, to a step of 1e-5 in; places where
    the register is set stay, and so does what it calls them."""
    given = {"P46": 3.52, "P44": 0.0, "P45": 0.0, "P47": 0.0, "P48": 0.0}
    damaged = []
    for file in sorted((corpus / "data" / "nist" / "programs").glob("*.nc")):
        target = tmp_path / file.name
        try:
            map_program(file, target, SHIFT, FREE, dialect="ge2000t", parameters=given)
        except TrueloopError as error:
            damaged.append((file.stem, error.code))
            continue
        known = {**given, "P41": 20.0, "P42": 20.0}
        before, after = (read_program(path.read_bytes(), "ge2000t").run(known) for path in (file, target))
        moved = after.end_mm - before.end_mm
        stays = np.flatnonzero(np.abs(moved).max(axis=1) == 0.0)
        cuts = np.setdiff1d(np.arange(len(before)), stays)
        assert np.abs(moved[cuts] - SHIFT_MM).max() < 0.51e-5 * 25.4
        assert (stays[0], *stays[-2:]) == (0, len(before) - 2, len(before) - 1)
        assert before.end_mm[stays].tolist() == after.end_mm[stays].tolist()
        assert len(cuts) > 5
    assert damaged == [("360021", Code.NC_ARC)]
