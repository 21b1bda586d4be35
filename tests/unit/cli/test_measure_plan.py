"""`trueloop measure plan` from the outside."""

import csv
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import run
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


@pytest.mark.parametrize("name", ["job.toml", "touches.csv", "finish.nc"])
def test_what_is_read_is_not_overwritten(name: str, tmp_path: Path) -> None:
    folder = tmp_path / "modbas2"
    shutil.copytree(JOB.parent, folder)
    before = (folder / name).read_bytes()
    assert "OUT-INPUT" in run("measure", "plan", folder / "job.toml", "-o", folder / name, status=4)
    assert (folder / name).read_bytes() == before
