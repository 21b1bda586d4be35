"""What a surface's job names: nothing is counted twice, and nothing mistyped is passed over."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.support.refusals import refused
from tests.support.surfaces import points_to_csv
from trueloop.errors import Code
from trueloop.formats.jobs.surface_job import read_surface_job
from trueloop.jobs.surface.job import read_surface
from trueloop.loops.surface.correction import SurfaceInputs

JOB = """name = "Wave"
[surface]
file = "nominal.csv"
[gauging]
points = {points}
[model]
exclude = {exclude}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder whose name is no pattern, with a nominal surface and parts in two folders of it."""
    x, y = np.meshgrid(np.linspace(0, 50, 6), np.linspace(0, 50, 6), indexing="ij")
    points, folder = np.stack([x, y, np.sin(x / 14)], axis=2), tmp_path / "job [1]"
    for k, name in enumerate(("nominal", "parts/S01", "parts/S02", "again/S01", "again/S03")):
        file = folder / f"{name}.csv"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_bytes(points_to_csv((points + 0.001 * k).reshape(-1, 3), (6, 6)))
    return folder


def _read(folder: Path, points: list[str], exclude: tuple[str, ...] = ()) -> SurfaceInputs:
    path = folder / "surface.toml"
    path.write_text(JOB.format(points=points, exclude=list(exclude)))
    return read_surface(path).inputs


def _names(inputs: SurfaceInputs) -> list[str]:
    return [part.name for part in inputs.parts]


def test_patterns_are_filled_in_by_name_also_below_other_folders(folder: Path) -> None:
    assert _names(_read(folder, ["parts/*.csv", "again/S03.csv"])) == ["S01", "S02", "S03"]
    assert _names(_read(folder, [f"{folder.parent}/*/parts/*.csv"])) == ["S01", "S02"]
    assert _names(_read(folder, ["**/S02.csv"])) == ["S02"]


@pytest.mark.parametrize("points", [["parts/S0*.csv", "parts/S01.csv"], ["parts/S01.csv", "again/S01.csv"]])
def test_a_part_is_not_counted_twice_nor_taken_for_another_of_its_name(folder: Path, points: list[str]) -> None:
    refusal = refused(_read, folder, points)
    assert refusal.code is Code.SRF_TWICE
    assert "'S01'" in refusal.message and str(folder / points[1].replace("*", "1")) in refusal.message


def test_a_copy_under_another_name_is_no_further_part(folder: Path) -> None:
    shutil.copy(folder / "parts/S01.csv", folder / "parts/S09.csv")
    refusal = refused(_read, folder, ["parts/*.csv"])
    assert refusal.code is Code.SRF_TWICE
    assert "'S01.csv' and 'S09.csv'" in refusal.message


def test_the_nominal_surface_is_no_part(folder: Path) -> None:
    """As a part without an error it would make the correction smaller."""
    refusal = refused(_read, folder, ["parts/*.csv", "*.csv"])
    assert refusal.code is Code.SRF_FILE and "'nominal.csv'" in refusal.message


def test_every_pattern_must_be_like_a_file(folder: Path) -> None:
    refusal = refused(_read, folder, ["parts/*.csv", "prats/*.csv"])
    assert refusal.code is Code.SRF_FILE and "'prats/*.csv'" in refusal.message


def test_a_part_to_leave_out_must_be_there(folder: Path) -> None:
    assert _read(folder, ["parts/*.csv"], ("S01",)).options.exclude == ("S01",)
    refusal = refused(_read, folder, ["parts/*.csv"], ("S01", "S021"))
    assert (refusal.code, refusal.hint) == (Code.JOB_KEY, "did you mean 'S02'?")


def test_a_program_needs_its_cutter(folder: Path) -> None:
    path = folder / "surface.toml"
    path.write_text(JOB.format(points=["parts/S01.csv"], exclude=[]) + '[program]\nfinish = "finish.ngc"\n')
    refusal = refused(read_surface_job, path)
    assert refusal.code is Code.JOB_KEY
    assert refusal.message == "a [program] needs its [cutter]: `cutter.radius_mm`"
