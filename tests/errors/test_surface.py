"""Every way in which surfaces, their measurements and their models are refused."""

import sys
import tempfile
import unittest.mock
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

from tests.support.surfaces import SQUARE, on_grid, points_to_csv, random_surface, sphere, wavy_surface
from trueloop.arrays import Array
from trueloop.errors import Code, Finding, TrueloopError
from trueloop.formats.cad.kernel import kernel
from trueloop.formats.cad.step import named_faces, read_faces, write_surface
from trueloop.formats.measurements.surface_csv import read_points
from trueloop.geometry.surface import Surface, fit_grid
from trueloop.jobs.surface.job import ReadSurface, compare_jobs, read_surface
from trueloop.loops.batch import run_batch
from trueloop.loops.surface.figures import SurfaceFigures, check_support
from trueloop.loops.surface.surface import require_form_alone
from trueloop.nc.program.program import read_program
from trueloop.surface.compensation.cutter import Cutter
from trueloop.surface.compensation.program import corrected_program
from trueloop.surface.compensation.shift import SurfaceJob, corrected_surface
from trueloop.surface.deviations.deviations import inside_trim, sampling_advice, surface_deviations
from trueloop.surface.deviations.points import MeasuredPoints
from trueloop.surface.options import SurfaceOptions
from trueloop.surface.pattern.pattern import pattern_of
from trueloop.surface.separation.separate import of_size, separate
from trueloop.surface.separation.spline_surface import Places, Size
from trueloop_lab.simulator.zigzag import ZigzagOptions, zigzag

SURFACE = wavy_surface()
AT = np.linspace(0.05, 0.95, 8)
U, V = (a.ravel() for a in np.meshgrid(AT, AT, indexing="ij"))
NORMAL = SURFACE.normal(U, V)


def _measured(points: Array, ball_radius_mm: float = 0.0, shape: tuple[int, int] | None = None) -> object:
    return surface_deviations(SURFACE, MeasuredPoints(points, ball_radius_mm, shape, "A")).findings


def _points(lift_mm: float = 0.0) -> Array:
    return SURFACE.point_mm(U, V) + lift_mm * NORMAL


def _with(points: Array, index: int | slice, value: ArrayLike) -> Array:
    changed = points.copy()
    changed[index] = value
    return changed


def _odd_part() -> object:
    rng = np.random.default_rng(1)
    errors = [on_grid(random_surface(rng, 5, 0.002)) + rng.normal(0, 0.002, 625) for _ in range(6)]
    errors[2] = errors[2] + on_grid(random_surface(rng, 5, 0.02))
    parts = [of_size(SQUARE, e, Size(6, 6)) for e in errors]
    return pattern_of(parts, [f"S{k}" for k in range(1, 7)]).findings


def _off_the_trimmed_face() -> object:
    points = MeasuredPoints(_points(), name="A")
    found = surface_deviations(SURFACE, points)
    inside_trim(points, found, lambda u, v: u > 0.8)
    return found.findings


def _corrected(text: str) -> object:
    job = SurfaceJob(Cutter(3.0, 3.0))
    return corrected_program(read_program(text.encode(), "linuxcnc"), SURFACE, SURFACE, job, "0123456789abcdef")


def _written(name: str, write: Callable[[Path], object]) -> object:
    with tempfile.TemporaryDirectory() as folder:
        return write(Path(folder) / name)


def _trimmed_by_a_crossing() -> object:
    corners = np.array([[0, 0], [1, 1], [1, 0], [0, 1], [0, 0]], float)
    crossing = tuple(np.array(ends) for ends in pairwise(corners))
    return _written("crossing.step", lambda path: write_surface(SURFACE, path, (crossing,)))


def _two_faces(path: Path) -> object:
    occ = kernel()
    writer = occ.StepWriter()
    for z in (0.0, 5.0):
        writer.Transfer(occ.MakeFace(occ.surface_of(_kernel_face(z)), 1e-6).Face(), occ.AS_IS)
    writer.Write(str(path))
    return named_faces(path)[0]


def _kernel_face(z: float) -> object:
    moved = replace(SURFACE, control_mm=SURFACE.control_mm + np.array([0.0, 0.0, z]))
    with tempfile.TemporaryDirectory() as folder:
        write_surface(moved, Path(folder) / "one.step")
        return named_faces(Path(folder) / "one.step")[0].handle


def _without_kernel() -> object:
    """A process of its own in which the kernel's package cannot be imported."""
    kernel.cache_clear()
    with unittest.mock.patch.dict(sys.modules, {"OCP": None}):
        return kernel()


def _creased() -> object:
    x, y = np.meshgrid(np.linspace(0, 50, 5), np.linspace(0, 50, 5), indexing="ij")
    control = np.stack([x, y, 20 * np.abs(x - 25)], axis=2)
    knots = np.array([0, 0, 0.25, 0.5, 0.75, 1, 1])
    return corrected_surface(Surface((1, 1), knots, knots, control), random_surface(np.random.default_rng(1), 4, 1e-3))


def _correlated() -> Array:
    rng = np.random.default_rng(1)
    return rng.normal(0, 0.002, (13, 13)).repeat(2, axis=0).repeat(2, axis=1)[:25, :25].ravel()


TWICE = "row,column,x_mm,y_mm,z_mm\n1,1,0,0,0\n1,1,1,0,0\n1,2,2,0,0\n"
EMPTY_STEP = (
    b"ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
    b"FILE_SCHEMA(('AUTOMOTIVE_DESIGN'));\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n"
)


def _points_of(path: Path, text: str) -> object:
    path.write_text(text)
    return read_points(path)


def _lines(rows: int, columns: int) -> Places:
    """A part measured in lines along a grid."""
    at = np.linspace(0.05, 0.95, rows), np.linspace(0.05, 0.95, columns)
    u, v = (a.ravel() for a in np.meshgrid(*at, indexing="ij"))
    return Places(SURFACE.point_mm(u, v), u, v, *at)


def _part_twice(path: Path) -> object:
    path.write_text('name = "W"\n[surface]\nfile = "w.csv"\n[gauging]\npoints = ["S01.csv", "again/S01.csv"]\n')
    return read_surface(path)


def _compared_with_another_surface(nominal: Path) -> object:
    """Two jobs of one measured part; the second one's nominal surface is 1 mm higher."""

    def read(lift: float) -> ReadSurface:
        name = f"lift{lift:g}"
        grid = SURFACE.grid_mm(AT, AT).reshape(-1, 3) + np.array([0.0, 0.0, lift])
        nominal.with_name(f"{name}.csv").write_bytes(points_to_csv(grid, (8, 8)))
        nominal.with_name(f"{name}-S1.csv").write_bytes(points_to_csv(grid + 0.001, (8, 8)))
        job = nominal.with_name(f"{name}.toml")
        job.write_text(f'name = "W"\n[surface]\nfile = "{name}.csv"\n[gauging]\npoints = ["{name}-S1.csv"]\n')
        return read_surface(job)

    return compare_jobs(read(0.0), read(1.0))


def _cad_of(path: Path, content: bytes) -> object:
    path.write_bytes(content)
    return read_faces(path)


PRODUCERS: dict[Code, Callable[[], object]] = {
    Code.SRF_SURFACE: lambda: replace(SURFACE, degrees=(4, 3)),
    Code.SRF_DEGENERATE: lambda: replace(sphere(), control_mm=0 * sphere().control_mm).normal(
        np.array([0.5]), np.array([1.0])
    ),
    Code.SRF_SETUP: lambda: surface_deviations(SURFACE, MeasuredPoints(_points(0.3), name="A"), fit=True).findings,
    Code.SRF_GRID: lambda: fit_grid(np.full((5, 5, 3), np.nan)),
    Code.SRF_POINTS: lambda: _measured(_points()[:9]),
    Code.SRF_TRIM: _trimmed_by_a_crossing,
    Code.SRF_UNIT: lambda: _measured(_points() / 25.4),
    Code.SRF_SIGN: lambda: _measured(_points(-2.0), 2.0),
    Code.SRF_OFF: lambda: _measured(_with(_points(), 7, _points(1.5)[7])),
    Code.SRF_OUTSIDE: lambda: _measured(_with(_points(), 7, [-3.0, 20.0, 0.0])),
    Code.SRF_DUPLICATE: lambda: _measured(_with(_points(), 7, _points()[8])),
    Code.SRF_HOLES: lambda: _measured(_with(_points(), 7, np.nan), shape=(8, 8)),
    Code.SRF_BALL: lambda: sampling_advice(SURFACE, 0.0),
    Code.SRF_COMPARE: lambda: _written("w.csv", _compared_with_another_surface),
    Code.SRF_CAD: lambda: read_faces(Path("no-such-surface-1.step")),
    Code.SRF_CAD_KERNEL: _without_kernel,
    Code.SRF_CAD_CHOICE: lambda: _written("two.step", _two_faces),
    Code.SRF_CUTTER: lambda: Cutter(3.0, 4.0),
    Code.SRF_GOUGE: lambda: _corrected("G21 G90\nG1 X20 Y20 Z4.11 F100\nX30\nM2\n"),
    Code.SRF_TOLERANCE: _creased,
    Code.SRF_PROGRAM: lambda: _corrected("G21 G90\nG1 X20 Y20 Z40 F100\nX30\nM2\n"),
    Code.SRF_FILE: lambda: _written("part.csv", lambda path: _points_of(path, "x_mm,y_mm,z_mm\n1,2,x\n")),
    Code.SRF_TWICE: lambda: _written("surface.toml", _part_twice),
    Code.SRF_BATCH: lambda: list(run_batch(abs, [1, 2], scheduler="nowhere:1:2")),
    Code.SRF_PATH: lambda: zigzag(SURFACE, ZigzagOptions(3.0, scallop_mm=0.0)),
    Code.SRF_SUPPORT: lambda: check_support(SurfaceFigures(0.01, 0.001, 0.002, 0.6, 0.004, (1.0, 2.0, 3.0)), 0.5),
    Code.SRF_PARTS: lambda: require_form_alone(["S1"], SurfaceOptions()),
    Code.SRF_OUTLIER: _odd_part,
    Code.SRF_MODEL: lambda: separate(SQUARE, _correlated(), criterion="randomness"),
}


@pytest.mark.parametrize("code", PRODUCERS)
def test_refusal_names_code_values_and_hint(code: Code) -> None:
    try:
        said = PRODUCERS[code]()
    except TrueloopError as error:
        said = error
    if isinstance(said, tuple):
        said = said[0]
    assert isinstance(said, (TrueloopError, Finding))
    assert said.code is code
    assert any(character.isdigit() or character == "'" for character in said.message)
    assert said.hint


@pytest.mark.parametrize(
    ("code", "produce"),
    [
        (Code.SRF_SURFACE, lambda: replace(SURFACE, degrees=(0, 3))),
        (Code.SRF_SURFACE, lambda: replace(SURFACE, degrees=(26, 3))),
        (Code.SRF_SIGN, lambda: _measured(_points(0.5))),  # ball centres given as points
        (Code.SRF_HOLES, lambda: _measured(_with(_points(), slice(0, 20), np.nan), shape=(8, 8))),
        (Code.SRF_OUTSIDE, _off_the_trimmed_face),
        (Code.SRF_GRID, lambda: _measured(_points(), shape=(8, 9))),
        (Code.SRF_GRID, lambda: fit_grid(np.zeros((3, 5, 3)))),
        (Code.SRF_GRID, lambda: fit_grid(np.zeros((5, 5, 3)))),
        (Code.SRF_MODEL, lambda: of_size(Places(SQUARE.points_mm[:60], U[:60], V[:60]), np.zeros(60), Size(9, 9))),
        (Code.SRF_MODEL, lambda: separate(SQUARE, np.zeros(625))),
        (Code.SRF_POINTS, lambda: separate(_lines(3, 40), np.random.default_rng(1).normal(0, 1, 120), name="S1")),
        (Code.SRF_POINTS, lambda: separate(_lines(3, 3), np.random.default_rng(1).normal(0, 1, 9), name="S1")),
        (Code.SRF_FILE, lambda: _written("a.csv", lambda path: _points_of(path, "x_mm,y_mm\n1,2\n"))),
        (Code.SRF_FILE, lambda: _written("a.csv", lambda path: _points_of(path, "x_mm,y_mm,z_mm\n1,2\n"))),
        (Code.SRF_FILE, lambda: _written("a.csv", lambda path: _points_of(path, "x_mm,y_mm,z_mm\n"))),
        (Code.SRF_FILE, lambda: _written("a.csv", lambda path: _points_of(path, TWICE))),
        (Code.SRF_CAD, lambda: _written("a.step", lambda path: _cad_of(path, b"no STEP at all"))),
        (Code.SRF_CAD, lambda: _written("a.step", lambda path: _cad_of(path, EMPTY_STEP))),
        (Code.SRF_CAD, lambda: _written("a.stl", lambda path: _cad_of(path, b"solid"))),
        (Code.SRF_CAD, lambda: write_surface(SURFACE, Path("a.dwg"))),
        (Code.SRF_PROGRAM, lambda: _corrected("G21 G90 G17\nG0 X20 Y20 Z5\nG1 Z4.3 F100\nG2 X22 Y20 I1 J0\nM2\n")),
        (Code.SRF_PATH, lambda: zigzag(wavy_surface(50.0, 90.0), ZigzagOptions(6.0))),
        (Code.CMP_SIZE, lambda: corrected_surface(SURFACE, random_surface(np.random.default_rng(1), 5, 0.5))),
        (Code.CMP_SLOPE, lambda: corrected_surface(SURFACE, random_surface(np.random.default_rng(1), 90, 0.04))),
    ],
)
def test_other_ways_to_the_same_refusals(code: Code, produce: Callable[[], object]) -> None:
    try:
        said = produce()
    except TrueloopError as error:
        said = (error,)
    assert code in [item.code for item in said]  # type: ignore[attr-defined]
