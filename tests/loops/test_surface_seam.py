"""A program over two tangent faces: a face corrected alone ends with a step, which is named; both together do not."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.cli import output_of, run
from tests.support.solids import written
from trueloop.arrays import Array
from trueloop.cli.terminal import ExitStatus
from trueloop.errors import Code, TrueloopError
from trueloop.formats.cad.step import read_faces
from trueloop.jobs.surface.job import correct_surface, read_surface

SEAM_MM, HIGH_MM, LONG_MM, WIDE_MM, FALL_MM, BALL_MM = 25.0, 20.0, 50.0, 20.0, 50.0, 3.0


def solid() -> Any:
    """A bar whose top is level up to x = 25 and goes on, without an edge to feel, as a cylinder of radius 50."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
    from OCP.BRepPrimAPI import BRepPrimAPI_MakePrism
    from OCP.GC import GC_MakeArcOfCircle
    from OCP.gp import gp_Pnt, gp_Vec

    def falls(x: float) -> Any:
        return gp_Pnt(x, 0, HIGH_MM - FALL_MM + float(np.sqrt(FALL_MM**2 - (x - SEAM_MM) ** 2)))

    seam, corner, low, start = gp_Pnt(SEAM_MM, 0, HIGH_MM), falls(LONG_MM), gp_Pnt(LONG_MM, 0, 0), gp_Pnt(0, 0, 0)
    begin = gp_Pnt(0, 0, HIGH_MM)
    arc = GC_MakeArcOfCircle(seam, falls(40.0), corner).Value()
    wire = BRepBuilderAPI_MakeWire()
    for edge in ((begin, seam), (arc,), (corner, low), (low, start), (start, begin)):
        wire.Add(BRepBuilderAPI_MakeEdge(*edge).Edge())
    return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(wire.Wire()).Face(), gp_Vec(0, WIDE_MM, 0)).Shape()


def tip(x: float) -> tuple[float, float]:
    """The tip's x and z where a ball touches the top, its touch at x."""
    turn = np.arcsin(max(0.0, x - SEAM_MM) / FALL_MM)
    touched = HIGH_MM - FALL_MM * (1 - np.cos(turn))
    return x + BALL_MM * np.sin(turn), touched + BALL_MM * np.cos(turn) - BALL_MM


def inside_out(solid: Any) -> Any:
    """The faces of a solid, each with its normals into the material."""
    from OCP.BRep import BRep_Builder
    from OCP.TopAbs import TopAbs_FACE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS_Compound

    faces, builder, each = TopoDS_Compound(), BRep_Builder(), TopExp_Explorer(solid, TopAbs_FACE)
    builder.MakeCompound(faces)
    while each.More():
        builder.Add(faces, each.Current().Reversed())
        each.Next()
    return faces


def job(folder: Path, last_mm: float, more: str = "", flip: bool = False) -> Path:
    """Parts whose level face is 12 µm too high at the seam, and a ball's passes from before the part to `last_mm`."""
    faces = read_faces(written(inside_out(solid()) if flip else solid(), folder / "bar.step"))
    (number,) = [k.number for k in faces if k.kind == "Plane" and k.area_mm2 == pytest.approx(SEAM_MM * WIDE_MM)
                 and np.min(k.surface.control_mm[..., 2]) > HIGH_MM - 1.0]  # fmt: skip
    x, y = (c.ravel() for c in np.meshgrid(np.linspace(0.5, 24.5, 25), np.linspace(0.5, 19.5, 20), indexing="ij"))
    for k in range(3):
        high = HIGH_MM + 0.012 * np.cos((x - SEAM_MM) / 6) + np.random.default_rng(k).normal(0, 3e-4, len(x))
        rows = [f"{a:.5f},{b:.5f},{c:.6f}" for a, b, c in zip(x, y, high, strict=True)]
        (folder / f"P{k}.csv").write_text("\n".join(["x_mm,y_mm,z_mm", *rows, ""]))
    lines = ["%", "O1", "G21 G17 G40 G49 G80 G90 G54", "S9000 M3", "G0 X-2. Y1. Z40."]
    for y_mm in np.arange(1.0, 20.0, 2.0):
        ways = [tip(at) for at in np.append(np.arange(0.0, last_mm, 2.5), last_mm)]
        lines += [f"G0 X-2. Y{y_mm:.1f}", "G1 Z20. F900.", *(f"X{a:.5f} Z{c:.5f}" for a, c in ways), "G0 Z40."]
    (folder / "finish.nc").write_text("\n".join([*lines, "M30", "%", ""]))
    path = folder / "job.toml"
    path.write_text(
        f'name = "bar"\n[surface]\nfile = "bar.step"\nface = {number}\nflip = {str(flip).lower()}\n'
        '[gauging]\npoints = ["P*.csv"]\n'
        f'[program]\nfinish = "finish.nc"\ndialect = "fanuc-mill"\n[cutter]\nradius_mm = {BALL_MM}\n'
        f'[compensation]\ncad_file = "none"\n{more}'
    )
    return path


@pytest.mark.parametrize("flip", [False, True])
def test_a_step_towards_the_next_face_that_the_program_cuts_on_is_refused(tmp_path: Path, flip: bool) -> None:
    """12 µm lie at the seam; half of it is taken away, the next face keeps all of its own: 6 µm, 60 µm/mm."""
    with pytest.raises(TrueloopError) as caught:
        correct_surface(read_surface(job(tmp_path, 45.0, "weight = 0.5\n", flip)))
    assert caught.value.code is Code.CMP_SLOPE
    assert caught.value.values["slope_um_per_mm"] == pytest.approx(60.0, abs=4.0)
    assert "at x 25.0" in caught.value.message
    (beside,) = [k.number for k in read_faces(tmp_path / "bar.step") if k.kind == "CylindricalSurface"]
    assert caught.value.hint.startswith(f"name face {beside} in surface.face too")
    assert caught.value.override == "compensation.max_slope_um_per_mm in the job"


def test_a_step_within_the_limit_is_reported_where_it_is(tmp_path: Path) -> None:
    """A fifth of 12 µm: record, page and what is printed have it; a program that ends on the face has none."""
    path = job(tmp_path, 45.0, "weight = 0.2\n")
    done = correct_surface(read_surface(path))
    (step,) = [one for one in done.correction.findings if one.code is Code.CMP_SLOPE]
    assert step.values["slope_um_per_mm"] == pytest.approx(24.0, abs=1.6) and "at x 25.0" in step.message
    assert f"CMP-SLOPE: {step.message}" in str(done.record.model["findings"])
    assert "CMP-SLOPE" in output_of("surface", "compensate", path, "--no-store", "-o", tmp_path / "out")
    assert "CMP-SLOPE" in (tmp_path / "out" / "pattern.html").read_text(encoding="utf-8")
    ends = correct_surface(read_surface(job(tmp_path, 24.9, "weight = 0.2\n")))
    assert not [one for one in ends.correction.findings if one.code is Code.CMP_SLOPE]


@pytest.mark.parametrize(
    ("last_mm", "more"), [(24.9, ""), (45.0, "weight = 0.2\n"), (45.0, "max_slope_um_per_mm = 200.0\n")]
)
def test_passes_that_end_on_the_face_small_steps_and_steps_that_are_allowed_pass(
    tmp_path: Path, last_mm: float, more: str
) -> None:
    """They overrun the sharp edge at x = 0: no face goes on there."""
    done = correct_surface(read_surface(job(tmp_path, last_mm, more)))
    assert done.correction.program is not None
    assert done.correction.program.cutting_moves > 50


def test_a_pattern_that_a_fixture_makes_is_corrected_by_the_datum_and_named_as_a_motion(tmp_path: Path) -> None:
    """By hand: the parts stand 12 µm high and lean by 0.5 µm/mm; a best fit leaves nothing of it to correct."""
    path = job(tmp_path, 24.9)
    for file in sorted(tmp_path.glob("P*.csv")):
        x, y, z = np.loadtxt(file, delimiter=",", skiprows=1).T
        level = z - 0.012 * np.cos((x - SEAM_MM) / 6) + 0.012 + 5e-4 * (x - 12.5)
        rows = [f"{a:.5f},{b:.5f},{c:.6f}" for a, b, c in zip(x, y, level, strict=True)]
        file.write_text("\n".join(["x_mm,y_mm,z_mm", *rows, ""]))
    found = correct_surface(read_surface(path)).correction
    (named,) = [one for one in found.findings if one.code is Code.SRF_SETUP]
    assert found.model.figures.rigid > 0.98 and named.message.startswith("100 % of the pattern")
    path.write_text(path.read_text().replace("[gauging]\n", '[gauging]\nalignment = "best-fit"\n'))
    with pytest.raises(TrueloopError) as caught:
        correct_surface(read_surface(path))
    assert caught.value.code is Code.SRF_PARTS


def wave_mm(x: Array) -> Array:
    """An error of both top faces, material left on: level at the seam."""
    return np.asarray(0.012 * np.cos((x - SEAM_MM) / 6))


def scan(path: Path, seed: int, error_mm: Array | float, at: tuple[Array, Array]) -> None:
    """The top of a bar, clamped 0.05 mm and half a milliradian off: points, and their normals."""
    rng, (x, y) = np.random.default_rng(seed), at
    turn = np.arcsin(np.maximum(0.0, x - SEAM_MM) / FALL_MM)
    normal = np.column_stack([np.sin(turn), 0 * x, np.cos(turn)])
    points = np.column_stack([x, y, HIGH_MM - FALL_MM * (1 - np.cos(turn))])
    points += (error_mm + rng.normal(0, 3e-4, len(x)))[:, None] * normal
    points += np.array([0.03, -0.05, 0.05]) + np.cross([3e-4, -5e-4, 2e-4], points)
    rows = [",".join(f"{value:.6f}" for value in row) for row in np.column_stack([points, normal])]
    path.write_text("\n".join(["X,Y,Z,NX,NY,NZ", *rows, ""]))


def of_both(folder: Path) -> tuple[Path, tuple[Array, Array]]:
    """The job of the bar's two top faces, one part, and where it is measured; passes in steps of 0.1 mm."""
    one = job(folder, 25.0)
    faces = read_faces(folder / "bar.step")
    (round_one,) = [face.number for face in faces if face.kind == "CylindricalSurface"]
    rng = np.random.default_rng(7)
    x, y = rng.uniform(0.3, 49.5, 1200), rng.uniform(0.3, WIDE_MM - 0.3, 1200)
    scan(folder / "S1.csv", 1, wave_mm(x), (x, y))
    text = (
        one.read_text()
        .replace("\nface = ", f"\nface = [{round_one}, ")
        .replace("\nflip = false", "]\nflip = false")
        .replace('points = ["P*.csv"]', 'points = ["S1.csv"]\nunit = "mm"\nalignment = "best-fit"\ncut_with = "given"')
    )
    one.write_text(text)
    lines = ["%", "O1", "G21 G17 G40 G49 G80 G90 G54", "S9000 M3", "G0 X2. Y1. Z40."]
    for y_mm in (4.0, 11.0, 16.0):
        ways = [tip(at) for at in np.arange(1.0, 45.0, 0.1)]
        lines += [f"G0 X0.9 Y{y_mm:.1f}", "G1 Z20.5 F900.", *(f"G1 X{a:.5f} Z{c:.5f}" for a, c in ways), "G0 Z40."]
    (folder / "finish.nc").write_text("\n".join([*lines, "M5", "G91 G28 Z0.", "G28 X0. Y0.", "M30", "%", ""]))
    return one, (x, y)


def left_um(program: Path) -> tuple[Array, Array]:
    """Where a program's ball touches the top, x, and how far from the nominal one it cuts, more left on positive."""
    rows = [line.split() for line in program.read_text().splitlines() if line.startswith("G1 X")]
    x, z = np.array([[float(word[1:]) for word in row if word[0] in "XZ"] for row in rows]).T
    out, up = x - SEAM_MM, z + BALL_MM - HIGH_MM + FALL_MM
    level = out <= 0
    off = np.where(level, up - FALL_MM, np.hypot(out, up) - FALL_MM) - BALL_MM
    return np.where(level, x, SEAM_MM + FALL_MM * out / np.hypot(out, up)), 1e3 * off


def without_set_up(x: Array, um: Array) -> Array:
    """What no motion of the part makes."""
    turn = np.arcsin(np.maximum(0.0, x - SEAM_MM) / FALL_MM)
    normal = np.column_stack([np.sin(turn), np.cos(turn)])
    z = HIGH_MM - FALL_MM * (1 - np.cos(turn))
    made = np.column_stack([normal, x * normal[:, 1] - z * normal[:, 0]])
    return np.asarray(um - made @ np.linalg.lstsq(made, um, rcond=None)[0])


def test_faces_that_a_program_cuts_together_are_corrected_by_one_part_without_a_step(tmp_path: Path) -> None:
    """One scan of one part that sits 0.05 mm off: a tenth of the error is left, and at the seam blocks of 0.1 mm differ
    by no more than the error itself does. A second part that shows no error keeps the correction as it is, in whatever
    order its job names the faces.
    """
    path, at = of_both(tmp_path)
    done = output_of("surface", "compensate", path, "--no-store", "-o", tmp_path / "first")
    assert "CMP-SLOPE" not in done
    x, given = left_um(tmp_path / "finish.nc")
    touched, cut = left_um(tmp_path / "first" / "corrected.nc")
    before, after = (without_set_up(x, um + 1e3 * wave_mm(x)) for x, um in ((x, given), (touched, cut)))
    assert np.sqrt(np.mean(after**2)) < 0.1 * np.sqrt(np.mean(before**2))
    step = np.abs(np.diff(cut))[(np.abs(touched[1:] - SEAM_MM) < 1.0) & (np.abs(np.diff(touched)) < 0.2)]
    assert len(step) > 50 and np.max(step) < 0.1

    scan(tmp_path / "S2.csv", 2, 0.0, at)
    path.write_text(path.read_text().replace("S1.csv", "S2.csv").replace('"given"', '"first/record.json"'))
    path.write_text(re.sub(r"face = \[(\d+), (\d+)\]", r"face = [\2, \1]", path.read_text()))
    run("surface", "compensate", path, "--no-store", "-o", tmp_path / "second")
    again = left_um(tmp_path / "second" / "corrected.nc")[1]
    assert np.max(np.abs(without_set_up(touched, again - cut))) < 0.4


def test_a_face_that_the_job_names_and_no_move_cuts_is_refused(tmp_path: Path) -> None:
    path, _ = of_both(tmp_path)
    program = tmp_path / "finish.nc"
    rows = program.read_text().splitlines()
    level = [row for row in rows if not row.startswith("G1 X") or float(row.split()[1][1:]) < SEAM_MM - 1.0]
    program.write_text("\n".join(level))
    (round_one,) = [k.number for k in read_faces(tmp_path / "bar.step") if k.kind == "CylindricalSurface"]
    told = run("surface", "compensate", path, "--no-store", "-o", tmp_path / "out", status=ExitStatus.REFUSED)
    assert f"0 moves of the program cut face {round_one}, of 2 that the job names" in " ".join(told.split())


def test_several_faces_are_taken_by_compensate_alone_and_named_once(tmp_path: Path) -> None:
    path, _ = of_both(tmp_path)
    for command in ("pattern", "model", "deviations"):
        assert "SRF-CAD-CHOICE" in run("surface", command, path, "-o", tmp_path / "out", status=ExitStatus.REFUSED)
    run("db", "init", tmp_path / "trueloop.db")
    assert "SRF-CAD-CHOICE" in run("surface", "compensate", path, "-o", tmp_path / "out", status=ExitStatus.REFUSED)
    grid = path.with_name("grid.csv")
    grid.write_text("row,column,x_mm,y_mm,z_mm\n")
    text = path.read_text()
    path.write_text(text.replace("bar.step", grid.name))
    assert "is a grid of points, 1 surface" in run("surface", "compensate", path, status=ExitStatus.REFUSED)
    path.write_text(text.replace("face = [", "face = [2, 2, "))
    assert "names a face twice" in run("surface", "compensate", path, status=ExitStatus.REFUSED)
