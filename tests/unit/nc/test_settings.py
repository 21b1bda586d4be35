"""Settings at the head of CAM programs: what only says how closely the path is followed stays and stops nothing."""

from pathlib import Path

import numpy as np
import pytest

from tests.support.machined_path import corrected
from tests.support.machines import chain_with_travel
from tests.support.mapped import mapped, path_of
from trueloop.errors import Code, Severity, TrueloopError
from trueloop.machine.correct import Setup
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import Machine, MachineModel
from trueloop.machine.model.term import Part, Term, segments
from trueloop.nc.field import affine_field
from trueloop.nc.program.program import read_program
from trueloop.nc.program.tool_path import PER_MINUTE, PER_REVOLUTION
from trueloop.nc.program.understood import require_known_frame, require_understood

FANUC = "%\nO1\nG21 G17 G90\n{}\nG00 X1. Y2. Z5.\nG01 Z-1. F100.\nX10. Y8.\nM30\n%\n"
LATHE = "%\nO1\nG21 G18\n{}\nG00 X20. Z5.\nG01 Z-10. F0.1\nX30. Z-12.\nM30\n%\n"
SINUMERIK = "G71 G17 G90\n{}\nG0 X1 Y2 Z5\nG1 Z-1 F100\nX10 Y8\nM30\n"
KLARTEXT = "0 BEGIN PGM A MM\n{}\n1 L X+1 Y+2 Z+5 R0 FMAX\n2 L Z-1 F100\n3 L X+10 Y+8\n4 END PGM A MM\n"
LINUXCNC = "G21 G17 G90\n{}\nG0 X1 Y2 Z5\nG1 Z-1 F100\nX10 Y8\nM2\n"
HEADS = {
    "fanuc-mill": FANUC,
    "haas-mill": FANUC,
    "fanuc-lathe": LATHE,
    "haas-lathe": LATHE,
    "siemens": SINUMERIK,
    "heidenhain": KLARTEXT,
    "linuxcnc": LINUXCNC,
}
STRETCHED = MachineModel(
    Machine("mill", chain_with_travel("mill-table-x")),
    (Term(error_name("EXX"), (Part(segments(0.0, 500.0, 1, 1)),)),),
    np.array([0.0, 0.05]),
    np.zeros((2, 2)),
)
"""EXX = 0.1 µm a millimetre."""
SHIFT = affine_field(np.eye(3), (0.01, 0.0, -0.003))

HARMLESS = {
    "siemens": [
        *("CYCLE832(0.01,_FINISH,1)", "CYCLE832()", "CYCLE832(0.05, 3)", "SOFT", "BRISK", "DRIVE", "SOFTA(X,Y)"),
        *("JERKLIM[X]=75", "VELOLIM[X]=80", "ACC[X]=50", "FFWON", "FFWOF", "COMPON", "COMPCAD", "COMPSURF", "COMPOF"),
        *("G642", "G641 ADIS=0.02", "G645 CTOL=0.01", "ATOL[X]=0.02", "OTOL=0.1", "ORIWKS", "ORIAXES", "OST", "UPATH"),
        *("DYNFINISH", "CPRECON", "FIFOCTRL", "FGROUP(X,Y,Z)", "FNORM", "G60", "G9", "N5 G64 SOFT COMPCAD FFWON ; CAM"),
    ],
    "fanuc-mill": [
        *("G05.1 Q1", "G5.1Q0", "G05.1 Q1 R5", "G05.1 Q2 X0 Y0 Z0", "G05.1 Q3 X0 Y0 Z0", "G05 P10000", "G5P0"),
        *("G08 P1", "G08P0", "G61.1", "G61.1 P1", "G61", "G62", "G63", "G64"),
    ],
    "fanuc-lathe": ["G05.1 Q1", "G05 P10000", "G08 P1", "G64"],
    "haas-mill": ["G187 P3 E0.01", "G187 P1", "G187 E0.05", "G187", "G103 P1", "G103"],
    "haas-lathe": ["G187 P3 E0.01", "G103 P1"],
    "heidenhain": [
        "CYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.01\nCYCL DEF 32.2 HSC-MODE:1 TA0.5",
        *("M120 LA30", "M124 T0.01", "M112 T0.01 A10", "M103 F20", "FUNCTION RESET TCPM", "FUNCTION MODE MILL", "M129"),
    ],
    "linuxcnc": ["G64 P0.01 Q0.005", "G64 P.01", "G61", "G61.1"],
}
UNFOLLOWED = {
    "siemens": [
        *("CYCLE832(0.01,102001)", "CYCLE832(0.1,R1)", "TRAORI", "TRAORI(1)", "TCARR=1", 'CYCLE800(0,"T")'),
        *("CYCLE832(0.1,1) G1 X5", "CUT3DC", "TOFRAME", "BSPLINE"),
    ],
    "fanuc-mill": [
        *(
            "G05 P2",
            "G05 P10001",
            "G05",
            "G05.1 Q4",
            "G05.1",
            "G08",
            "G05.1 Q1 X5.",
            "G43.4 H1",
            "G68.2 X0 Y0 Z0 I0 J0 K0",
        ),
        "G187 P3",
    ],
    "fanuc-lathe": ["G05 P2", "G08 P2"],
    "haas-mill": ["G05.1 Q1", "G05 P10000", "G08 P1", "G61.1", "G254"],
    "haas-lathe": ["G05 P10000", "G05.1 Q1"],
    "heidenhain": [
        *(
            "FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS",
            "FUNCTION TCPM",
            "FUNCTION MODE TURN",
            "FUNCTION PARAXMODE X Y W",
        ),
        *("FUNCTION PROG PATH IS CONTOUR", "M128", "M128 F1000", "M114", "M144", "M143", "M118 X1 Y1"),
    ],
}


def _each(programs: dict[str, list[str]]) -> list[tuple[str, str]]:
    return [(dialect, setting) for dialect, settings in programs.items() for setting in settings]


@pytest.mark.parametrize(("dialect", "setting"), _each(HARMLESS))
def test_a_setting_changes_nothing_of_the_path_and_nothing_is_said_of_it(dialect: str, setting: str) -> None:
    text = HEADS[dialect].format(setting)
    program = read_program(text.encode(), dialect)
    path, without = program.run(), path_of(HEADS[dialect].format(""), dialect)
    assert np.array_equal(path.end_mm, without.end_mm)
    assert np.array_equal(path.feed, without.feed, equal_nan=True)
    assert np.array_equal(path.tool, without.tool)
    said = [found for found in (*program.findings, *path.findings) if found.code is not Code.NC_DIAMETER]
    assert [found.code for found in said if found.severity is not Severity.NOTE] == []
    require_understood(program)
    require_known_frame(path)


@pytest.mark.parametrize(("dialect", "setting"), _each(HARMLESS))
def test_a_displaced_program_keeps_it_as_it_is(dialect: str, setting: str, tmp_path: Path) -> None:
    text = HEADS[dialect].format(setting)
    after, _ = mapped(tmp_path, text, SHIFT, dialect)
    before = path_of(text, dialect).end_mm
    assert f"\n{setting}\n" in after
    assert np.allclose(path_of(after, dialect).end_mm - before, SHIFT.displacement_mm(before), atol=1e-4)


@pytest.mark.parametrize(("dialect", "setting"), _each(UNFOLLOWED))
def test_what_may_move_a_frame_or_is_not_known_stays_refused(dialect: str, setting: str, tmp_path: Path) -> None:
    text = HEADS[dialect].format(setting)
    with pytest.raises(TrueloopError) as refused:
        mapped(tmp_path, text, SHIFT, dialect)
    assert refused.value.code in (Code.NC_OPAQUE, Code.NC_CODE, Code.NC_WORD)
    program = read_program(text.encode(), dialect)
    with pytest.raises(TrueloopError):
        require_understood(program)
        require_known_frame(program.run(strict=False))


@pytest.mark.parametrize("dialect", ["fanuc-mill", "haas-mill", "siemens", "heidenhain", "linuxcnc"])
def test_a_machine_is_corrected_under_all_of_its_settings(dialect: str) -> None:
    after = corrected(
        HEADS[dialect].format("\n".join(HARMLESS[dialect])), STRETCHED, Setup({1: (0.0, 0.0, -100.0)}), dialect=dialect
    )
    assert all(f"\n{setting}\n" in after for setting in HARMLESS[dialect])
    before = path_of(HEADS[dialect].format(""), dialect).end_mm
    wanted_mm = before * np.array([1 - 1e-4, 1.0, 1.0])
    assert np.allclose(path_of(after, dialect).end_mm, wanted_mm, atol=6e-4)
    assert not np.allclose(before, wanted_mm, atol=6e-4)


def test_a_mode_of_klartext_beside_a_move_takes_nothing_of_it() -> None:
    path = read_program(KLARTEXT.format("1 L X+7 F100 M128").encode(), "heidenhain").run()
    assert path.end_mm[0, 0] == 7.0


def test_feed_a_revolution_of_klartext_has_to_be_given_anew() -> None:
    text = "0 BEGIN PGM A MM\n1 L X+1 F100\n2 L X+2 F0.2 M136\n3 L X+3 F50 M137\n"
    path = read_program(text.encode(), "heidenhain").run()
    assert path.feed_mode.tolist() == [PER_MINUTE, PER_REVOLUTION, PER_MINUTE]
    assert path.feed.tolist() == [100.0, 0.2, 50.0]
