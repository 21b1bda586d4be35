"""A bushing in one program: turned outside by an OD tool, bored by a bar; its profile goes around.

LinuxCNC's interpreter says where the program sends each nose, circles of these noses leave the part. By hand: a
bore's normal looks to the axis, so that a bar that stands too far out by d leaves a bore too large, an error of −d, and
its offset gets smaller, as that of an OD tool that stands too far out and leaves +d.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import invoke, run
from tests.support.grooved import Cutting, Place, dense, surface_mm
from tests.support.linuxcnc import Tool, interpret
from trueloop.arrays import Array
from trueloop.jobs.turned.job import read_cuts
from trueloop.jobs.turned.job_files import JobFiles
from trueloop.loops.turned.part import SetupCorrection, correct_setup

OD, BAR = 1, 2
NOSE_MM = {OD: 0.8, BAR: 0.4}
PROGRAM = """\
G21 G18 G7 G40 G90 G95
G97 S800 M3
T1 M6 G43 H1
G00 X70.0000 Z0.8000
G01 X38.0000 Z0.8000 F0.1
G00 Z5.0000
G00 X61.6000 Z5.0000
G01 X61.6000 Z-40.0000
G00 X80.0000 Z-40.0000
G00 X80.0000 Z20.0000
T2 M6 G43 H2
G00 X39.2000 Z5.0000
G01 X39.2000 Z-24.6000 F0.08
G01 X29.2000 Z-24.6000
G01 X29.2000 Z-40.0000
G00 X26.0000 Z-40.0000
G00 X26.0000 Z20.0000
M2
"""
"""Nose centres, X a diameter: Ø 60 + 1.6, the face z 0 + 0.8; the bores Ø 40 − 0.8 and Ø 30 − 0.8, their shoulder
z −25 + 0.4."""

UP, DOWN, FORWARDS = (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0)
PLACES = (
    *(Place("od", 30.0, z, UP, OD) for z in (-35.0, -20.0, -5.0)),
    *(Place("face", x, 0.0, FORWARDS, OD) for x in (28.0, 25.0, 22.0)),
    *(Place("bore", 20.0, z, DOWN, BAR) for z in (-4.0, -12.0, -20.0)),
    *(Place("shoulder", x, -25.0, FORWARDS, BAR) for x in (19.0, 17.5, 16.0)),
    *(Place("throat", 15.0, z, DOWN, BAR) for z in (-28.0, -33.0, -38.0)),
)
OFF = {OD: Cutting((0.012, -0.004)), BAR: Cutting((0.010, 0.006))}


def commanded(file: Path) -> Mapping[int, Array]:
    """Where LinuxCNC sends the centre of each nose, at feed."""
    lines, paths = file.read_text().splitlines(), {OD: list[Array](), BAR: list[Array]()}
    bar = next(number for number, line in enumerate(lines, 1) if line.startswith("T2"))
    for move in interpret(file, tools=[Tool(OD, NOSE_MM[OD]), Tool(BAR, NOSE_MM[BAR])]):
        if move.kind == "line":
            (x0, _, z0), (x1, _, z1) = move.start_mm, move.end_mm
            paths[BAR if move.line > bar else OD].append(dense([(x0, z0), (x1, z1)]))
    return {edge: np.concatenate(pieces) for edge, pieces in paths.items()}


def cut_um(text: str, folder: Path, cuttings: Mapping[int, Cutting]) -> list[float]:
    """Errors at all places of the part that a program cuts."""
    (folder / "cut.ngc").write_text(text)
    paths = commanded(folder / "cut.ngc")
    return [1e3 * surface_mm(paths[p.edge], NOSE_MM[p.edge], cuttings[p.edge], p) for p in PLACES]


def job(folder: Path, rows: Sequence[str], more: str = "", head: str = "nominal_x_mm,nominal_z_mm,error_um") -> Path:
    (folder / "finish.ngc").write_text(PROGRAM)
    (folder / "touches.csv").write_text("\n".join([f"point,feature,{head}", *rows, ""]))
    (folder / "job.toml").write_text(
        '[part]\nname = "bushing"\nside = "around"\nstart = [30, -40]\nfeature = [{ name = "od", to = [30, 0] },\n'
        '{ name = "face", to = [20, 0] }, { name = "bore", to = [20, -25] }, { name = "shoulder", to = [15, -25] },\n'
        '{ name = "throat", to = [15, -40] }]\n[[tools]]\nnumber = 1\nnose_radius_mm = 0.8\n'
        '[[tools]]\nnumber = 2\nnose_radius_mm = 0.4\nname = "bar"\n'
        f'[programs]\ndialect = "linuxcnc"\nfinish = "finish.ngc"\n[gauging]\ntouches = "touches.csv"\n{more}'
    )
    return folder / "job.toml"


def rows_of(errors_um: Sequence[float], but: Sequence[str] = ()) -> list[str]:
    pairs = enumerate(zip(PLACES, errors_um, strict=True), 1)
    return [f"{k},{p.feature},{p.x_mm},{p.z_mm},{e:.6f}" for k, (p, e) in pairs if p.feature not in but]


def corrected(path: Path) -> SetupCorrection:
    return correct_setup(read_cuts(JobFiles.of(path)).setups[0])


def test_the_model_errs_as_it_is_told(tmp_path: Path) -> None:
    """A bar too far out by 0.010 leaves the bore 0.020 too large in diameter: −10 µm; the shoulder keeps 6 µm on."""
    found = dict(zip([p.feature for p in PLACES], cut_um(PROGRAM, tmp_path, OFF), strict=True))
    wanted = {"od": 12.0, "face": -4.0, "bore": -10.0, "shoulder": 6.0, "throat": -10.0}
    assert found == pytest.approx(wanted, abs=0.06)


def test_each_tool_gets_its_own_offset(tmp_path: Path) -> None:
    """Both stand too far out, so both offsets on X get smaller: the bore grows by none of it, it shrinks."""
    errors = np.array(cut_um(PROGRAM, tmp_path, OFF)) + np.tile([0.2, -0.2, 0.2], len(PLACES) // 3)
    joint = corrected(job(tmp_path, rows_of(errors.tolist())))
    wear = {one.tool: one.correction.wear for one in joint.edges if one.correction is not None}
    assert (wear["T1"].x, wear["T1"].z) == pytest.approx((-0.024, 0.004), abs=5e-4)
    assert (wear["T2"].x, wear["T2"].z) == pytest.approx((-0.020, -0.006), abs=5e-4)
    assert joint.program is None


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["as touched", "turned round"])
def test_the_contours_of_both_are_in_one_program(sign: float, tmp_path: Path) -> None:
    """Ø 40 of the bore is cut at Ø 39.200 − 0.020, Ø 60 at 61.600 − 0.024; with the sign turned all is there twice."""
    errors = cut_um(PROGRAM, tmp_path, OFF)
    path = job(tmp_path, rows_of([sign * e for e in errors]), '[compensation]\nby = "contour"\n')
    run("compensate", path, "-o", tmp_path / "out")
    text = (tmp_path / "out" / "corrected.ngc").read_text()
    left = np.array(cut_um(text, tmp_path, OFF))
    np.testing.assert_allclose(left, (1.0 - sign) * np.array(errors), atol=0.15)
    if sign > 0:
        assert "X39.18" in text.split("G00 X39.2")[1] and "X61.576" in text.split("G00 X61.6")[1]


def test_a_tool_that_cuts_nothing_measured_is_left(tmp_path: Path) -> None:
    errors = cut_um(PROGRAM, tmp_path, OFF)
    path = job(tmp_path, rows_of(errors, ["bore", "shoulder", "throat"]), '[compensation]\nby = "contour"\n')
    said = " ".join(run("compensate", path, "-o", tmp_path / "out").split())
    assert "T2 cuts nothing that was measured: " in said and "throat stay as programmed" in said
    given, written = PROGRAM.split("T2 M6")[1], (tmp_path / "out" / "corrected.ngc").read_text().split("T2 M6")[1]
    assert written == given


def test_tools_that_both_cut_a_feature_are_refused(tmp_path: Path) -> None:
    """The bar faces as well, at the same z."""
    path = job(tmp_path, rows_of([0.0] * len(PLACES)))
    faced = PROGRAM.replace("T2 M6 G43 H2\n", "T2 M6 G43 H2\nG00 X64. Z0.4\nG01 X38. Z0.4\n")
    (tmp_path / "finish.ngc").write_text(faced)
    said = run("compensate", path, "-o", tmp_path / "out", status=3)
    assert "NC-TOOLS" in said and "'face' is cut by 2 tools" in said and "[feature.face] tool = 2" in said


def test_a_bore_touched_as_an_outside_diameter_is_refused(tmp_path: Path) -> None:
    """By its name, and by the ball on the other side of the surface."""
    good = [f"{k},{p.feature},{p.x_mm},{p.z_mm},0.0" for k, p in enumerate(PLACES, 1)]
    named = [row.replace("bore", "od") for row in good]
    assert "TCH-OFF-PROFILE" in invoke("compensate", job(tmp_path, named), status=3).output
    head = "nominal_x_mm,nominal_z_mm,measured_x_mm,measured_z_mm"
    ball = []
    for k, p in enumerate(PLACES, 1):
        out = p.normal if p.feature != "bore" else UP  # the ball's centre 1 mm above the bore's wall: in the metal
        ball.append(f"{k},{p.feature},{p.x_mm},{p.z_mm},{p.x_mm + out[0]},{p.z_mm + out[1]}")
    path = job(tmp_path, ball, head=head)
    path.write_text(path.read_text().replace("[gauging]\n", "[gauging]\nball_radius_mm = 1.0\n"))
    said = invoke("compensate", path, status=3).output
    assert "TCH-OFF-PROFILE" in said and "the ball radius" in said


def test_diameters_of_a_micrometer_have_the_signs_of_their_sides(tmp_path: Path) -> None:
    """Ø 60.024 outside: 12 µm left on. Ø 40.020 and Ø 30.020 inside: 10 µm too much taken, and the offset shrinks."""
    path = job(tmp_path, [])
    (tmp_path / "readings.csv").write_text(
        "# uncertainty_um: 1\nfeature,quantity,actual_mm\n"
        "od,diameter,60.024\nod,diameter,60.024\nod,diameter,60.024\n"
        "bore,diameter,40.020\nbore,diameter,40.020\nthroat,diameter,30.020\nthroat,diameter,30.020\n"
    )
    path.write_text(path.read_text().replace('touches = "touches.csv"', 'readings = "readings.csv"'))
    joint = corrected(path)
    wear = {one.tool: one.correction.wear for one in joint.edges if one.correction is not None}
    assert (wear["T1"].x, wear["T2"].x) == pytest.approx((-0.024, -0.020), abs=1e-3)
