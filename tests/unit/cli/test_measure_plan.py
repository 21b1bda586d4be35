"""`trueloop measure plan` from the outside."""

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import run
from tests.support.dmis import read_text
from tests.support.probing import EXAMPLES

JOB = EXAMPLES / "modbas2" / "job.toml"


def test_the_list_holds_the_points_of_the_jobs_touches(tmp_path: Path) -> None:
    run("measure", "plan", JOB, "-o", tmp_path / "points.csv")
    with (tmp_path / "points.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    with (JOB.parent / "touches.csv").open(encoding="utf-8") as file:
        touches = list(csv.DictReader(line for line in file if not line.startswith("#")))
    assert [row["point"] for row in rows] == [touch["point"] for touch in touches]
    found = np.array([[float(row[name]) for name in ("x_mm", "y_mm", "z_mm")] for row in rows])
    x, z = (np.array([float(touch[name]) for touch in touches]) for name in ("nominal_x_mm", "nominal_z_mm"))
    assert np.allclose(found, np.stack([x, 0 * x, z], axis=1), atol=6e-5)
    assert "-0.0000," not in (tmp_path / "points.csv").read_text(encoding="utf-8")


def test_the_points_of_a_spacing_stay_clear_of_the_ends_by_the_balls_radius(tmp_path: Path) -> None:
    folder = EXAMPLES / "loop"
    text = (
        (folder / "modbas2.toml")
        .read_text(encoding="utf-8")
        .replace('touches = "../', 'spacing_mm = 10.0\ntouches = "../')
    )
    job = tmp_path / "loop" / "job.toml"
    job.parent.mkdir()
    job.write_text(text.replace('"../', f'"{EXAMPLES}/'), encoding="utf-8")
    (job.parent / "probe.toml").write_bytes((folder / "probe.toml").read_bytes())
    rows = list(csv.DictReader(run("measure", "plan", job).splitlines()))
    x = [float(row["x_mm"]) for row in rows if row["feature"] == "main-cylinder"]
    assert len(x) > 5 and set(x) == {44.704}


@pytest.mark.parametrize("angles", [["--angle", "0", "--angle", "360"], ["--angle", "nan"]])
def test_angles_that_are_none_are_refused(angles: list[str]) -> None:
    assert "TCH-PLAN" in run("measure", "plan", JOB, *angles, status=3)


def test_what_is_read_is_not_overwritten(tmp_path: Path) -> None:
    folder = tmp_path / "modbas2"
    shutil.copytree(JOB.parent, folder)
    before = (folder / "touches.csv").read_bytes()
    assert "OUT-INPUT" in run("measure", "plan", folder / "job.toml", "-o", folder / "touches.csv", status=4)
    assert (folder / "touches.csv").read_bytes() == before


@pytest.mark.parametrize("name", ["job.toml", "finish.nc", "points"])
def test_a_name_that_is_neither_a_program_s_nor_a_list_s_is_a_usage_error(name: str, tmp_path: Path) -> None:
    assert name in run("measure", "plan", JOB, "-o", tmp_path / name, status=2)
    assert not list(tmp_path.iterdir())


def _program(tmp_path: Path, *options: str, asked: str = "") -> str:
    """The program of MODBAS2, with characteristics added to its job."""
    folder = tmp_path / "modbas2"
    shutil.copytree(JOB.parent, folder)
    job = (folder / "job.toml").read_text(encoding="utf-8")
    (folder / "job.toml").write_text(job.replace("[tool]", f"{asked}\n[tool]"), encoding="utf-8")
    run("measure", "plan", folder / "job.toml", "-o", tmp_path / "part.dms", *options)
    return (tmp_path / "part.dms").read_text(encoding="utf-8")


def test_a_program_s_points_are_those_of_the_job_turned_by_the_angle(tmp_path: Path) -> None:
    lines = _program(tmp_path, "--angle", "90").splitlines()
    assert "F(P1)=FEAT/POINT,CART,0,63.8721,-149.1631,0,0.874791,0.4845" in lines
    at = lines.index("MEAS/POINT,F(P1),1")
    assert lines[at - 1] == "GOTO/CART,0,67.3713,-147.2251"  # 63.8721 + 4 · 0.874791, −149.1631 + 4 · 0.4845
    assert lines[at + 1 : at + 4] == ["PTMEAS/CART,0,63.8721,-149.1631,0,0.874791,0.4845", "ENDMES", "OUTPUT/FA(P1)"]
    assert sum(line.startswith("MEAS/POINT") for line in lines) == 32
    assert (lines[0], lines[-1]) == ("DMISMN/'MODBAS2, 3.52 in',05.2", "ENDFIL")
    assert {"UNITS/MM,ANGDEC", "SNSET/APPRCH,3", "SNSET/RETRCT,3"} <= set(lines)
    assert max(map(len, lines)) <= 78 or all(line.startswith("$$") for line in lines if len(line) > 78)


DIAMETER = """
[[part.characteristic]]
name = "D main"
quantity = "diameter"
feature = "main-cylinder"
lower_limit = 3.519
upper_limit = 3.5215
"""


def test_a_diameter_of_the_drawing_is_measured_as_a_circle_with_its_limits(tmp_path: Path) -> None:
    program = _program(tmp_path, asked=DIAMETER)
    lines = program.splitlines()
    # 3.52 in = 89.408 mm, z from −4.51 in to −1.76 in: its middle −3.135 in = −79.629 mm
    assert "F(D_main)=FEAT/CIRCLE,OUTER,CART,0,0,-79.629,0,0,1,89.408" in lines
    assert "T(D_main)=TOL/DIAM,-0.0254,0.0381" in lines
    at = lines.index("MEAS/CIRCLE,F(D_main),4")
    places = [line for line in lines[at:] if line.startswith("PTMEAS")]
    assert places == [
        "PTMEAS/CART,44.704,0,-79.629,1,0,0",
        "PTMEAS/CART,0,44.704,-79.629,0,1,0",
        "PTMEAS/CART,-44.704,0,-79.629,-1,0,0",
        "PTMEAS/CART,0,-44.704,-79.629,0,-1,0",
    ]
    assert "OUTPUT/FA(D_main),TA(D_main)" in lines
    read = read_text(program, name="part.dms")
    assert not read.inspections and ["no actual" in read.remarks[1].text, len(read.remarks)] == [True, 2]
    (asked,) = read.characteristics
    assert (asked.name, asked.quantity.value) == ("D_main", "diameter")
    assert (asked.nominal, asked.lower_limit, asked.upper_limit) == pytest.approx((89.408, 89.3826, 89.4461))


def test_a_diameter_at_one_z_of_a_cone_is_touched_there_along_its_normal(tmp_path: Path) -> None:
    asked = DIAMETER.replace("main-cylinder", "cone").replace('feature = "cone"', 'feature = "cone"\nat_z_mm = -120.0')
    limits = "lower_limit = 3.519\nupper_limit = 3.5215\n"
    lines = _program(tmp_path, asked=asked.replace(limits, 'tolerance = "±0.002"\n')).splitlines()
    # the cone runs from x 67.564, z −155.829 to 44.704, −114.554: at z −120 its radius is
    # 44.704 + (−114.554 + 120) · 22.86 / 41.275 = 47.7202 mm, its normal (41.275, 22.86) / 47.1823
    assert "PTMEAS/CART,47.7202,0,-120,0.874791,0,0.4845" in lines
    assert "PTMEAS/CART,-47.7202,0,-120,-0.874791,0,0.4845" in lines
    (circle,) = [line for line in lines if line.startswith("F(D_main)")]
    assert circle.startswith("F(D_main)=FEAT/CIRCLE,OUTER,CART,0,0,-120,0,0,1,95.44")
    assert "T(D_main)=TOL/DIAM,-0.0508,0.0508" in lines


def test_a_limit_on_one_side_alone_has_no_words_in_dmis(tmp_path: Path) -> None:
    program = _program(tmp_path, asked=DIAMETER.replace("upper_limit = 3.5215\n", ""))
    assert "F(D_main)=" in program and "TOL/" not in program


def test_a_ball_too_large_for_a_point_is_refused_with_the_point(tmp_path: Path) -> None:
    said = run("measure", "plan", JOB, "-o", tmp_path / "part.dms", "--ball-radius-mm", "9", status=3)
    assert "PRB-BALL" in said and "'11'" in said
    assert not list(tmp_path.iterdir())
