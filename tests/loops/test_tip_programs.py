"""Programs that move the imaginary tip without G41 or G42, as CAM systems write them: read by hand, judged by the nose.

The nose's path is drawn by hand: lines and arcs beside the profile by the radius, and where they cross.
"""

from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import run
from tests.support.turned_by_hand import Erring, drawn, job, moves_of, off_nominal_mm
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.process_intermittent import compensate

NOSE_MM = 0.8
T3 = (3, 1)
SHAFT = drawn(
    (20.0, -60.0),
    ("big", (20.0, -40.0), T3),
    ("shoulder", (15.0, -40.0), T3),
    ("fillet", (12.0, -37.0), (15.0, -37.0), T3),
    ("seat", (12.0, -25.0), T3),
    ("cone", (10.0, -15.0), T3),
    ("pin", (10.0, -2.0), T3),
    ("edge", (8.0, 0.0), (8.0, -2.0), T3),
    ("front", (0.5, 0.0), T3),
)
STEEP = NOSE_MM * np.hypot(1.0, 0.2)
"""By how much the nose's centre is off a cone of 1:5, along x."""
CENTRE = [
    ("G0", 0.4, 5.0),
    ("G1", 0.4, 0.8),
    ("G1", 8.0, 0.8),
    ("G3 R2.8", 10.8, -2.0),
    ("G1", 10.8, -15.0 + (STEEP - NOSE_MM) / 0.2),
    ("G1", 12.8, -15.0 - (2.8 - STEEP) / 0.2),
    ("G1", 12.8, -37.0),
    ("G2 R2.2", 15.0, -39.2),
    ("G1", 20.8, -39.2),
    ("G1", 20.8, -60.0),
    ("G0", 25.0, -60.0),
    ("G0", 25.0, 50.0),
]
ERRS = {T3: Erring((0.012, -0.007), 0.006)}
HEADS = {
    "fanuc-lathe": "G21 G40 G99\nT0303\nG97 S1500 M3 F0.1",
    "linuxcnc": "G18 G21 G7 G40 G90\nT3 M6\nG43\nG97 S1500 M3\nG95 F0.1",
}


def program(dialect: str, off: tuple[float, float]) -> str:
    """The program that moves a point (x, z) nose radii off the centre."""

    def block(codes: str, x: float, z: float) -> str:
        code, *radius = codes.split()
        return " ".join([code, f"X{2 * (x + off[0] * NOSE_MM):.4f}", f"Z{z + off[1] * NOSE_MM:.4f}", *radius])

    return "\n".join([HEADS[dialect], *(block(*one) for one in CENTRE), "M2", ""])


def corrected(folder: Path, dialect: str, text: str, tool: str = "") -> Correction:
    (folder / "finish.nc").write_text(text)
    tables = (
        f"[tool]\nnumber = 3\nnose_radius_mm = {NOSE_MM}\n{tool}\n"
        f'[programs]\ndialect = "{dialect}"\nfinish = "finish.nc"\n[compensation]\nby = "contour"\n'
    )
    return compensate(read_job(job(folder, SHAFT, ERRS, tables)).inputs)


@pytest.mark.parametrize(
    ("dialect", "off", "stated", "said"),
    [
        ("fanuc-lathe", (-1, -1), "", "orientation 3"),
        ("fanuc-lathe", (-1, -1), "tip = 3", "orientation 3"),
        ("fanuc-lathe", (-1, 1), "", "orientation 4"),
        ("fanuc-lathe", (-1, 0), "", "orientation 8"),
        ("linuxcnc", (-1, -1), "", "orientation 2"),
        ("linuxcnc", (-1, -1), "tip = 2", "orientation 2"),
    ],
)
def test_the_nose_cuts_the_profile_less_the_error(
    dialect: str, off: tuple[float, float], stated: str, said: str, tmp_path: Path
) -> None:
    made = corrected(tmp_path, dialect, program(dialect, off), stated)
    assert any(said in note for note in made.notes)
    assert_less_the_error(made.corrected_program.decode(), off)


def assert_less_the_error(text: str, off: tuple[float, float]) -> None:
    shift = NOSE_MM * np.array(off)
    nose = [move.points(0.005) - shift for move in moves_of(text) if move.motion > 0]
    for piece in SHAFT:
        for share in (0.1, 0.3, 0.5, 0.7, 0.9):
            place, normal = piece.at(share)
            off_mm = off_nominal_mm(nose, place + NOSE_MM * normal, normal)
            assert off_mm == pytest.approx(-ERRS[T3].error_mm(normal), abs=1.5e-3), (piece.name, share)


def test_of_several_tools_the_tip_is_stated(tmp_path: Path) -> None:
    (tmp_path / "finish.nc").write_text(program("fanuc-lathe", (-1, -1)))
    tables = (
        f"[[tools]]\nnumber = 3\nnose_radius_mm = {NOSE_MM}\ntip = 3\n[compensation]\nby = 'contour'\n"
        '[programs]\ndialect = "fanuc-lathe"\nfinish = "finish.nc"\n'
    )
    run("compensate", job(tmp_path, SHAFT, ERRS, tables))
    assert_less_the_error((tmp_path / "out" / "corrected.nc").read_text(), (-1, -1))


@pytest.mark.parametrize("stated", ["tip = 0", "tip = 4"])
def test_another_tip_than_the_stated_one_is_not_tried(stated: str, tmp_path: Path) -> None:
    with pytest.raises(TrueloopError) as refused:
        corrected(tmp_path, "fanuc-lathe", program("fanuc-lathe", (-1, -1)), stated)
    assert refused.value.code is Code.NC_NO_MATCH


def test_the_path_of_the_centre_stays_what_it_was(tmp_path: Path) -> None:
    made = corrected(tmp_path, "fanuc-lathe", program("fanuc-lathe", (0, 0)))
    assert not any("orientation" in note for note in made.notes)
