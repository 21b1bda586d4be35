"""Increments are corrected as positions are; those of X are radii under DIAM90 of a Sinumerik, else diameters."""

import re
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import run
from trueloop.arrays import Array
from trueloop.nc.program.program import read_program

POSITIONS = """; shaft
G18 G90 G71
{mode}
G54
T="FINISH" D1
G97 S1500 M3
G0 X40 Z2
G0 X0
G42 G1 Z0 F0.1
X22
X24 Z-1
Z-20
X27
G3 X30 Z-21.5 CR=1.5
G1 Z-35
X34
Z-50
G40 X42
G0 X100 Z100
M30
"""
JOB = """[part]
name = "shaft"
x_is = "diameter"
start = [34, -50]
feature = [
  { name = "collar", to = [34, -35] }, { name = "step", to = [30, -35] }, { name = "seat", to = [30, -21.5] },
  { name = "edge", to = [27, -20], radius = 1.5 }, { name = "shoulder", to = [24, -20] },
  { name = "pin", to = [24, -1] }, { name = "chamfer", to = [22, 0] }, { name = "front", to = [0, 0] },
]
[tool]
nose_radius_mm = 0.4
number = 1
[programs]
dialect = "siemens"
finish = "f.mpf"
cut_with = "given"
[gauging]
readings = "r.csv"
[compensation]
by = "contour"
[output]
folder = "o"
"""
READINGS = """feature,z_mm,diameter_mm,uncertainty_um
pin,-5,24.020,1
pin,-15,24.028,1
seat,-25,30.022,1
seat,-33,30.030,1
collar,-40,34.036,1
collar,-48,34.028,1
"""
STEPS: tuple[tuple[str, str, tuple[float, ...]], ...] = (
    ("X27\n", "X{}\n", (1.5,)),
    ("G3 X30 Z-21.5", "G3 X{} Z{}", (1.5, -1.5)),
    ("G1 Z-35\nX34\n", "G1 Z{}\nX{}\n", (-13.5, 2)),
)


def program(mode: str, by: str) -> str:
    """The program with a shoulder, an edge, a seat and a step in increments: G91 or IC(); X in the mode's unit."""
    text = POSITIONS.format(mode=mode)
    for positions, words, values in STEPS:
        scaled = [v * 2 if mode == "DIAMON" and v > 0 else v for v in values]
        text = text.replace(positions, words.format(*(f"=IC({v:g})" if by == "IC" else f"{v:g}" for v in scaled)))
    return text.replace("Z-20\nX", "Z-20\nG91 X").replace("\nZ-50", "\nG90 Z-50") if by == "G91" else text


def contour(folder: Path, source: str) -> Array:
    """Ends (x as a radius, z) of the corrected moves."""
    folder.mkdir()
    for name, text in (("f.mpf", source), ("job.toml", JOB), ("r.csv", READINGS)):
        (folder / name).write_text(text)
    run("compensate", folder / "job.toml", "--no-store", "-o", folder / "o")
    path = read_program((folder / "o" / "corrected.mpf").read_bytes(), "siemens").run()
    return np.unique(path.end_mm[:, [0, 2]].round(3), axis=0)


@pytest.mark.parametrize("mode", ["DIAM90", "DIAMON"])
@pytest.mark.parametrize("by", ["G91", "IC"])
def test_increments_lead_to_the_contour_of_positions(tmp_path: Path, mode: str, by: str) -> None:
    source = program(mode, by)
    assert bool(re.search(r"G91|IC\(", source))
    by_increments, by_positions = contour(tmp_path / "i", source), contour(tmp_path / "p", POSITIONS.format(mode=mode))
    away = np.linalg.norm(by_increments[:, None] - by_positions[None], axis=2)
    assert away.min(axis=1).max() < 0.0012 and away.min(axis=0).max() < 0.0012


LEAD_IN = """G18 G21 G8 G40 G90 G64 P0.002
T1 M6 G43 H1
G97 S1000 M3
G0 X30 Z20
{}
G1 X10.4 F0.1
G1 Z-30
G1 X20.4
G0 X40 Z30
M2
"""


def test_a_feed_move_added_before_a_contour_is_an_increment_under_g91(tmp_path: Path) -> None:
    """The face stands 15 µm too far out: the rapid ends where it did, and a feed move goes on from there."""
    part = 'start = [10, -28]\nfeature = [{ name = "cyl", to = [10, 0] }, { name = "face", to = [9, 0] }]\n'
    (tmp_path / "t.csv").write_text(
        "point,feature,nominal_x_mm,nominal_z_mm,error_um\n1,cyl,10,-20,10\n2,cyl,10,-5,12\n3,face,9.5,0,15\n"
    )
    (tmp_path / "job.toml").write_text(
        f'[part]\nname = "s"\n{part}[tool]\nnose_radius_mm = 0.4\nnumber = 1\n[gauging]\ntouches = "t.csv"\n'
        '[programs]\ndialect = "linuxcnc"\nfinish = "f.ngc"\ncut_with = "given"\n[compensation]\nby = "contour"\n'
    )
    ends = []
    for lead in ("G0 X8.5 Z0.4", "G91 G0 X-21.5 Z-19.6\nG90"):
        source = LEAD_IN.format(lead)
        if lead.startswith("G91"):
            source = source.replace("\nG90\nG1 X10.4", "\nG1 X1.9").replace("Z-30\n", "Z-30.4\nG90\n")
        (tmp_path / "f.ngc").write_text(source)
        run("compensate", tmp_path / "job.toml", "--no-store", "-o", tmp_path / "o")
        path = read_program((tmp_path / "o" / "corrected.ngc").read_bytes(), "linuxcnc").run()
        ends.append(path.end_mm[:, [0, 2]])
    np.testing.assert_allclose(ends[0], ends[1], atol=2e-5)
