"""Subprograms in files of their own: read with the program that calls them, corrected where the contour is theirs."""

from collections.abc import Mapping
from pathlib import Path

import pytest

from tests.support.everyday import driven, off_mm
from tests.support.turned_by_hand import Erring, drawn, job
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.machine.mapped_program import displace_program, program_obstacles
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.field import similarity_field

T1 = (1, 1)
SHAFT = drawn(
    (15.0, -40.0),
    ("seat2", (15.0, -20.0), T1),
    ("shoulder", (10.0, -20.0), T1),
    ("seat1", (10.0, -1.0), T1),
    ("edge", (9.0, 0.0), T1),
    ("front", (4.0, 0.0), T1),
)
ERRS = {T1: Erring((0.011, -0.006))}
CONTOUR = "G42 G1 Z0. F0.1\nX18.\nX20. Z-1.\nZ-20.\nX30.\nZ-40.\nG40 G1 X38.\n"
FANUC = "%\nO1000\nG21 G40 G99\nT0101\nG97 S900 M3\nG0 X8. Z4.\nM98 P2000\nG0 X140. Z70.\nM30\n%\n"
SINUMERIK = "G18 G71 G90 G40 DIAMON G54\nT1 D1\nG97 S900 M4 G95 F0.1\nG0 X8 Z4\nCONTOUR\nG0 X140 Z70\nM30\n"
CYCLE95 = (
    "G18 G71 G90 G40 DIAMON G54\nT1 D1\nG97 S900 M4 G95 F0.1\nG0 X38 Z4\n"
    'CYCLE95("CONTOUR",2,0.1,0.2,,0.3,0.1,0.1,5,,,1)\nG0 X140 Z70\nM30\n'
)


def corrected(folder: Path, dialect: str, finish: str, files: Mapping[str, str], stated: str = "sub") -> Correction:
    (folder / "finish.nc").write_text(finish)
    (folder / "sub").mkdir()
    for name, text in files.items():
        (folder / "sub" / name).write_text(text)
    tables = (
        "[tool]\nnumber = 1\nnose_radius_mm = 0.4\n[compensation]\nby = 'contour'\n"
        f'[programs]\ndialect = "{dialect}"\nfinish = "finish.nc"\nfolder = "{stated}"\n'
    )
    return compensate(read_job(job(folder, SHAFT, ERRS, tables)).inputs)


def assert_less_the_error(text: str, dialect: str) -> None:
    (passes,) = [one for one in driven(text, dialect) if len(one) >= len(SHAFT)]
    for piece in SHAFT:
        for share in (0.1, 0.5, 0.9):
            (x, z), (nx, nz) = piece.at(share)
            off = off_mm(passes, (float(x), float(z)), (float(nx), float(nz)))
            assert off == pytest.approx(-ERRS[T1].error_mm(piece.at(share)[1]), abs=1.3e-3), (piece.name, text)


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("O2000", "%\nO2000 (CONTOUR)\n" + CONTOUR + "M99\n%\n"),
        ("2000.nc", CONTOUR + "M99\n"),
        ("o2000.NC", "O2000\n" + CONTOUR + "M99"),
    ],
)
def test_a_fanuc_subprogram_is_found_by_its_number(name: str, text: str, tmp_path: Path) -> None:
    others = {"O3000": "O3000\nG0 X0\nM99\n", "readme.txt": "O2000"}
    made = corrected(tmp_path, "fanuc-lathe", FANUC, {name: text, **others})
    written = made.corrected_program.decode()
    assert_less_the_error(written, "fanuc-lathe")
    assert written.count("O2000") == 1
    assert "O3000" not in written
    assert written.endswith("M99\n%\n")
    assert any(f"{name} (from line 10)" in note for note in made.notes)


def test_what_a_subprogram_calls_is_read_too(tmp_path: Path) -> None:
    files = {"O2000": "O2000\nM98 P2001\nM99\n", "O2001": "O2001\n" + CONTOUR + "M99\n"}
    assert_less_the_error(corrected(tmp_path, "fanuc-lathe", FANUC, files).corrected_program.decode(), "fanuc-lathe")


def test_a_sinumerik_subprogram_is_found_by_its_name(tmp_path: Path) -> None:
    made = corrected(tmp_path, "siemens", SINUMERIK, {"CONTOUR.SPF": CONTOUR + "M17\n"})
    before, called = made.corrected_program.decode().split("%_N_CONTOUR_SPF\n")
    head, tail = before.split("CONTOUR\n")
    assert_less_the_error(head + called.replace("M17\n", "") + tail, "siemens")


def test_the_contour_of_a_stock_removal_cycle_is_read_from_its_file(tmp_path: Path) -> None:
    contour = "G0 X8 Z1\n" + CONTOUR.replace("G42 G1", "G1").replace("G40 G1 X38.\n", "X38\n") + "M17\n"
    written = corrected(tmp_path, "siemens", CYCLE95, {"CONTOUR.SPF": contour}).corrected_program.decode()
    called = written.split("%_N_CONTOUR_SPF\n")[1].replace("M17\n", "")
    assert_less_the_error("DIAMON\nG42\n" + called + "G40 G1 X40\n", "siemens")


def test_a_folder_that_is_not_there_is_refused_by_its_name(tmp_path: Path) -> None:
    with pytest.raises(TrueloopError) as refused:
        corrected(tmp_path, "fanuc-lathe", FANUC, {}, stated="elsewhere")
    assert refused.value.code is Code.NC_FILE
    assert "elsewhere" in str(refused.value.place)


def test_a_control_whose_calls_are_not_looked_for_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TrueloopError) as refused:
        corrected(tmp_path, "okuma-lathe", FANUC, {})
    assert refused.value.code is Code.NC_DIALECT


@pytest.mark.parametrize(
    ("dialect", "main", "name", "called", "written"),
    [
        (
            "heidenhain",
            "0 BEGIN PGM A MM\n1 L X+1 Y+2 Z+9 R0 FMAX\n2 CALL PGM TNC:\\P\\B.H\n3 L X+7 FMAX\n4 END PGM A MM\n",
            "b.h",
            "0 BEGIN PGM B MM\n1 L X+5 F100\n2 END PGM B MM\n",
            "1 L X+5.1000 F100",
        ),
        ("siemens", "G71 G90 G0 X1 Y2 Z9\nSLOT\nX7\nM30\n", "SLOT.SPF", "G1 X5 F100\nM17\n", "G1 X5.1000 F100"),
        (
            "fanuc-mill",
            "%\nO1\nG21 G90 G0 X1. Y2. Z9.\nM98 P20\nX7.\nM30\n%\n",
            "O0020",
            "%\nO20\nG1 X5. F100.\nM99\n%\n",
            "G1 X5.100 F100.",
        ),
    ],
)
def test_a_program_is_mapped_with_those_of_its_folder(
    tmp_path: Path, dialect: str, main: str, name: str, called: str, written: str
) -> None:
    """Each is written on its own: no line of another's, those that have to be first in front, and marked."""
    (tmp_path / "main.nc").write_text(main)
    (tmp_path / name).write_text(called)
    (tmp_path / "OTHER.SPF").write_text("X999\n")
    field = similarity_field(shift_mm=(0.1, 0.0, 0.0))
    out = tmp_path / "out" / "main.nc"
    assert displace_program(tmp_path / "main.nc", out, field, dialect=dialect).called == (name,)
    assert sorted(file.name for file in out.parent.iterdir()) == sorted(["main.nc", "main.record.json", name])
    mapped = (out.parent / name).read_text().splitlines()
    assert [line for line in mapped if "trueloop" not in line] == [
        written if "5" in line and "100" in line else line for line in called.splitlines()
    ]
    assert "trueloop corrected" in (out.parent / name).read_text()
    assert len(out.read_text().splitlines()) == len(main.splitlines()) + 1


def test_what_refuses_a_called_program_names_its_file_and_line(tmp_path: Path) -> None:
    (tmp_path / "main.nc").write_text("G71 G90 G0 X1 Y2 Z9\nSLOT\nM30\n")
    (tmp_path / "SLOT.SPF").write_text("G1 X5 F100\nG2 X9 I=Q\nM17\n")
    found = program_obstacles(tmp_path / "main.nc", similarity_field(shift_mm=(0.1, 0.0, 0.0)), dialect="siemens")
    assert (Path(found[0].place.file or "").name, found[0].place.line) == ("SLOT.SPF", 2)
