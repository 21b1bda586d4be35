"""Refusals of measured parts name the file at fault, and the line where one point is."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.support.refusals import refused
from tests.support.surfaces import points_to_csv, wavy_surface
from trueloop.arrays import Array
from trueloop.errors import Code, Place
from trueloop.formats.jobs.surface_job import read_surface_job
from trueloop.jobs.surface.job import correct_surface, read_surface
from trueloop.loops.surface.surface import SurfaceCorrection, correct, model_of, pattern_model

SIDE = 12
AT = np.linspace(0.05, 0.95, SIDE)
U, V = (a.ravel() for a in np.meshgrid(AT, AT, indexing="ij"))
SURFACE = wavy_surface()
NORMAL = SURFACE.normal(U, V)
JOB = """name = "Wave"
[surface]
file = "nominal.csv"
[gauging]
points = ["parts/*.csv"]
ball_radius_mm = {ball}
alignment = "{alignment}"
[model]
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    x, y = np.meshgrid(np.linspace(0, 50, 21), np.linspace(0, 50, 21), indexing="ij")
    nominal = np.stack([x, y, 4.0 * np.sin(x / 14) * np.cos(y / 17)], axis=2)
    (tmp_path / "nominal.csv").write_bytes(points_to_csv(nominal.reshape(-1, 3), (21, 21)))
    (tmp_path / "parts").mkdir()
    for k in range(3):
        _write(tmp_path, k + 1, lambda points: points)
    return tmp_path


def _write(folder: Path, number: int, change: Callable[[Array], Array]) -> Path:
    """A part of a pattern of micrometres, and what is wrong with it."""
    rng = np.random.default_rng(number)
    form = 0.005 * np.sin(6 * U) * np.cos(5 * V) + rng.normal(0, 0.001, len(U))
    file = folder / "parts" / f"S0{number}.csv"
    file.write_bytes(points_to_csv(change(SURFACE.point_mm(U, V) + form[:, None] * NORMAL), (SIDE, SIDE)))
    return file


def _job(folder: Path, more: str = "", ball: float = 0.0, alignment: str = "datum") -> Path:
    path = folder / "surface.toml"
    path.write_text(JOB.format(ball=ball, alignment=alignment) + more)
    return path


def _modelled(path: Path) -> object:
    inputs = read_surface(path).inputs
    return model_of(inputs.surface, inputs.parts, inputs.options)


def _with(index: int | slice, value: Callable[[Array], Array]) -> Callable[[Array], Array]:
    def change(points: Array) -> Array:
        points[index] = value(points)
        return points

    return change


@pytest.mark.parametrize(
    ("code", "change", "line", "ball"),
    [
        (Code.SRF_OFF, _with(7, lambda p: p[7] + [0, 0, 1.5]), 9, 0.0),
        (Code.SRF_OUTSIDE, _with(30, lambda p: p[30] - [20, 0, 0]), 32, 0.0),
        (Code.SRF_DUPLICATE, _with(20, lambda p: p[4]), 22, 0.0),
        (Code.SRF_UNIT, lambda p: p / 25.4, None, 0.0),
        (Code.SRF_SIGN, lambda p: p - 2.0 * NORMAL, None, 2.0),
        (Code.SRF_HOLES, _with(slice(3, 60), lambda p: np.full((57, 3), np.nan)), None, 0.0),
        (Code.SRF_POINTS, _with(slice(5, None), lambda p: np.full((len(p) - 5, 3), np.nan)), None, 0.0),
    ],
)
def test_measured_points_that_are_refused_name_their_file_and_line(
    folder: Path, code: Code, change: Callable[[Array], Array], line: int | None, ball: float
) -> None:
    at_fault = _write(folder, 1, change)
    refusal = refused(_modelled, _job(folder, ball=ball))
    assert (refusal.code, refusal.place) == (code, Place(str(at_fault), line))


def test_lines_are_those_of_the_file_behind_holes_and_comments(folder: Path) -> None:
    def change(points: Array) -> Array:
        points[3:6] = np.nan
        points[7] += [0, 0, 1.5]
        return points

    at_fault = _write(folder, 1, change)
    at_fault.write_text("# a comment\n" + at_fault.read_text())
    refusal = refused(_modelled, _job(folder))
    assert (refusal.code, refusal.place.line) == (Code.SRF_OFF, 9 - 3 + 1)
    assert at_fault.read_text().splitlines()[6].startswith("1,8,")


def test_points_cut_away_by_the_face_s_trimming_name_file_and_line(folder: Path) -> None:
    inputs = read_surface(_job(folder)).inputs
    at_fault = folder / "parts" / "S01.csv"
    refusal = refused(lambda: model_of(inputs.surface, inputs.parts, inputs.options, trim=lambda u, v: u > 0.9))
    assert (refusal.code, refusal.place) == (Code.SRF_OUTSIDE, Place(str(at_fault), SIDE * (SIDE - 1) + 2))


def test_a_part_farther_off_than_its_set_up_names_its_file(folder: Path) -> None:
    at_fault = _write(folder, 2, lambda points: points + np.array([0, 0, 0.4]))
    refusal = refused(_modelled, _job(folder, alignment="best-fit"))
    assert (refusal.code, refusal.place) == (Code.SRF_SETUP, Place(str(at_fault)))


def test_a_job_that_says_its_set_up_is_off_by_more_has_that_part_brought_back(folder: Path) -> None:
    at = _write(folder, 2, lambda points: points + np.array([0, 0, 0.4]))
    job = _job(folder, alignment="best-fit")
    job.write_text(job.read_text().replace("[model]", "setup_mm = 0.6\n[model]"))
    inputs = read_surface(job).inputs
    parts = model_of(inputs.surface, inputs.parts, inputs.options)
    (moved,) = [part.deviations.alignment for part in parts if part.deviations.name == at.stem]
    assert abs(moved.shift_mm[2] + 0.4) < 0.05


def test_warnings_of_a_part_name_its_file(folder: Path) -> None:
    at_fault = _write(folder, 2, _with(slice(20, 40), lambda p: np.full((20, 3), np.nan)))
    inputs = read_surface(_job(folder)).inputs
    found = [one for part in model_of(inputs.surface, inputs.parts, inputs.options) for one in part.deviations.findings]
    (holes,) = [one for one in found if one.code is Code.SRF_HOLES]
    assert str(holes).startswith(f"{at_fault}: warning SRF-HOLES: 20 of 144 points of 'S02' are missing\n  hint: ")


def test_what_is_said_of_a_part_s_model_names_its_file(folder: Path) -> None:
    spiked = _write(folder, 2, lambda points: points + np.where(np.arange(144) % 29, 0.0, 0.05)[:, None] * NORMAL)
    inputs = read_surface(_job(folder)).inputs
    parts = model_of(inputs.surface, inputs.parts, inputs.options)
    said = {one.place.file for part in parts for one in part.separation.findings if one.severity == "warning"}
    assert said == {str(spiked)}


def test_too_few_parts_name_the_job(folder: Path) -> None:
    job = _job(folder, 'exclude = ["S02"]\n')
    refusal = refused(lambda: correct_surface(read_surface(job)))
    assert (refusal.code, refusal.place) == (Code.SRF_PARTS, Place(str(job)))


@pytest.mark.parametrize(
    ("cells", "why"),
    [
        ("[-8, 20]", "greater than or equal to 8"),
        ("[0, 20]", "greater than or equal to 8"),
        ("[7, 20]", "greater than or equal to 8"),
        ("[20, 1001]", "less than or equal to 1000"),
        ('["20", 20]', "valid integer"),
        ("[20.5, 20]", "valid integer"),
        ("[true, 20]", "valid integer"),
        ("[20]", "model.cells"),
        ("[20, 20, 20]", "model.cells"),
        ("20", "model.cells"),
    ],
)
def test_cells_that_are_none_are_refused_with_key_and_line(folder: Path, cells: str, why: str) -> None:
    refusal = refused(read_surface_job, _job(folder, f"cells = {cells}\n"))
    assert refusal.code in (Code.JOB_KEY,)
    assert why in str(refusal) and "model.cells" in str(refusal)
    assert refusal.place.line == 9


def test_more_cells_than_points_are_refused_with_the_part(folder: Path) -> None:
    refusal = refused(_modelled, _job(folder, "cells = [40, 40]\n"))
    assert refusal.place.file == str(folder / "parts" / "S01.csv")


def test_parts_that_differ_by_their_set_up_alone_are_no_correction(folder: Path) -> None:
    """Set up 40 µm apart, with a form of 5 µm: by the datum nothing of the pattern is known, by the best fit it is."""
    for number, z_mm in ((1, 0.05), (2, -0.04), (3, 0.03)):
        _write(folder, number, _raised(z_mm))
    refusal = refused(_corrected, _job(folder))
    assert refusal.code is Code.SRF_PARTS and 'gauging.alignment = "best-fit"' in refusal.hint
    found = _corrected(_job(folder, alignment="best-fit"))
    assert 0.003 < found.model.figures.largest_mm < 0.008


def _corrected(path: Path) -> SurfaceCorrection:
    inputs = read_surface(path).inputs
    parts = model_of(inputs.surface, inputs.parts, inputs.options)
    return correct(pattern_model(inputs.surface, parts, inputs.options))


def _raised(z_mm: float) -> Callable[[Array], Array]:
    return lambda points: points + np.array([0.0, 0.0, z_mm])
