"""The section of turned solids: made by the CAD kernel from known profiles, read back as their lines and arcs."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
from OCP.gp import gp_Ax2, gp_Ax3, gp_Dir, gp_Pnt

from tests.support.cli import run
from tests.support.profiles import facetst, modbas2, piecs11, polyline
from tests.support.refusals import refused
from tests.support.solids import SPINDLE, paraboloid, spindle, turned, turned_spline, written
from trueloop.errors import Code
from trueloop.formats.cad.step_profile import read_step_profile
from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Arc, Feature
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.jobs.turned.job import read_part

PROFILES = {"facetst": facetst(), "modbas2": modbas2(), "piecs11": piecs11()}


def same(found: Sequence[Feature], wanted: Sequence[Feature], atol_mm: float = 1e-7) -> None:
    assert [type(feature) for feature in found] == [type(feature) for feature in wanted]
    for read, nominal in zip(found, wanted, strict=True):
        share = np.linspace(0, 1, 9)
        points, expected = read.point_mm(share * read.length_mm), nominal.point_mm(share * nominal.length_mm)
        np.testing.assert_allclose(points, expected, atol=atol_mm)
        if isinstance(read, Arc) and isinstance(nominal, Arc):
            assert read.sweep_rad == pytest.approx(nominal.sweep_rad, abs=1e-9)


@pytest.mark.parametrize("unit", ["MM", "INCH"])
@pytest.mark.parametrize("name", PROFILES)
def test_a_turned_solid_gives_the_profile_it_was_made_of(tmp_path: Path, name: str, unit: str) -> None:
    """And the face at the chuck, which closed it. The file's unit makes no difference."""
    profile: Profile = PROFILES[name]
    read = read_step_profile(written(turned(profile.features), tmp_path / "part.step", unit))
    same(read.features[1:], profile.features)
    assert read.features[0].name == "face-1" and read.features[0].start_mm[0] == pytest.approx(0, abs=1e-9)
    checked_profile(read.features)


def test_where_it_lies_and_points_in_the_file_is_found(tmp_path: Path) -> None:
    """Moved and tilted: z is counted along the axis, from the point of it nearest to the origin."""
    along = np.array([0.6, 0.0, 0.8])
    place = gp_Ax3(gp_Pnt(*(np.array([0.0, 25.0, 0.0]) - 10 * along).tolist()), gp_Dir(*along.tolist()))
    read = read_step_profile(written(turned(modbas2().features, place=place), tmp_path / "part.step"))
    moved = [(f.start_mm[0], f.start_mm[1] + 10) for f in read.features[1:]]
    np.testing.assert_allclose(moved, [f.start_mm for f in modbas2().features], atol=1e-7)
    assert "along (0.600000, 0.000000, 0.800000)" in read.notes[0] and "y 25.0000" in read.notes[0]


def test_a_solid_with_its_free_end_at_the_small_z_is_turned_round(tmp_path: Path) -> None:
    back = gp_Ax3(gp_Pnt(0, 0, 0), gp_Dir(0, 0, -1))
    path = written(turned(piecs11().features, place=back), tmp_path / "part.step")
    same(read_step_profile(path, turned_round=True).features[1:], piecs11().features)
    assert read_step_profile(path).features[0].start_mm[1] == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("bore_mm", [6.0, 21.0])
def test_the_outside_of_a_bored_part_is_that_of_a_full_one(tmp_path: Path, bore_mm: float) -> None:
    shaft = polyline([(30.0, -50.0), (30.0, -20.0), (25.0, -20.0), (25.0, 0.0)])
    read = read_step_profile(written(turned(shaft, bore_mm), tmp_path / "part.step"))
    same(read.features[1:4], shaft)
    np.testing.assert_allclose([read.features[0].start_mm, read.features[-1].end_mm], [(bore_mm, -50), (bore_mm, 0)])
    assert len(read.features) == 5


def test_a_blind_hole_and_a_cross_hole_are_no_outside(tmp_path: Path) -> None:
    """Holes of 4 and 3 mm radius: one on the axis from the free end, one across, in one of the sections."""
    profile = polyline([(30.0, -50.0), (30.0, -20.0), (25.0, -20.0), (25.0, 0.0), (0.0, 0.0)])
    part: Any = turned(profile)
    across = gp_Ax2(gp_Pnt(0, 0, -35), gp_Dir(math.cos(0.4), math.sin(0.4), 0))
    for hole in (
        BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(0, 0, -15), gp_Dir(0, 0, 1)), 4.0, 30.0),
        BRepPrimAPI_MakeCylinder(across, 3.0, 80.0),
    ):
        part = BRepAlgoAPI_Cut(part, hole.Shape()).Shape()
    read = read_step_profile(written(part, tmp_path / "part.step"))
    same(read.features[1:-1], profile[:-1])
    np.testing.assert_allclose(read.features[-1].end_mm, (4.0, 0.0), atol=1e-7)
    assert "100%" not in read.notes[0]


def test_the_profile_is_cut_where_the_program_begins_and_ends(tmp_path: Path) -> None:
    """By hand: the dome of radius 37.084 ends the part at z = 0; at z = −10 it is sqrt(37.084² − 27.084²) wide."""
    path = written(turned(modbas2().features), tmp_path / "part.step")
    read = read_step_profile(path, from_z_mm=-100.0, to_z_mm=-10.0)
    assert [f.name for f in read.features] == ["cylinder-1", "face-1", "cylinder-2", "arc-1"]
    np.testing.assert_allclose(read.features[0].start_mm, (44.704, -100.0), atol=1e-9)
    np.testing.assert_allclose(read.features[-1].end_mm, (math.sqrt(37.084**2 - 27.084**2), -10.0), atol=1e-9)
    assert refused(lambda: read_step_profile(path, from_z_mm=5.0)).code is Code.GEO_STEP


def test_a_spline_is_a_curve_through_its_points(tmp_path: Path) -> None:
    """The kernel's own spline, at 200 places, lies on the curve that is read from the solid's file."""
    read = read_step_profile(written(turned_spline(), tmp_path / "part.step"))
    curve = read.features[1]
    assert isinstance(curve, Curve) and [f.name for f in read.features] == ["face-1", "curve-1", "face-2"]
    np.testing.assert_allclose([curve.start_mm, curve.end_mm], [SPINDLE[0], SPINDLE[-1]], atol=1e-7)
    spline = spindle()
    places = np.linspace(spline.FirstParameter(), spline.LastParameter(), 200).tolist()
    points = [(point.X(), point.Z()) for point in map(spline.Value, places)]
    assert np.max(np.abs(curve.locate(points)[1])) < 1e-7
    checked_profile(read.features)


@pytest.mark.parametrize("as_b_spline", [False, True], ids=["turned", "b-spline surface"])
def test_a_paraboloid_is_exact(tmp_path: Path, as_b_spline: bool) -> None:
    """z = −x²/(2 R) with R = 40 on a cylinder of 16 mm, also where the file has a B-spline surface for it."""
    read = read_step_profile(written(paraboloid(40.0, 16.0, as_b_spline), tmp_path / "lens.step"))
    curve = read.features[-1]
    assert isinstance(curve, Curve)
    x, z = curve.point_mm(np.linspace(0, curve.length_mm, 101)).T
    np.testing.assert_allclose(z, -x * x / 80.0, atol=1e-7)
    np.testing.assert_allclose([x[0], x[-1]], [16.0, 0.0], atol=1e-7)
    assert np.all(curve.outward_normal(curve.length_mm / 2) > 0)


def test_a_job_and_the_command_line_take_the_solid(tmp_path: Path) -> None:
    """The table that part from-step prints, and part.step in a job, are the profile that the solid was made of."""
    path = written(turned(modbas2().features), tmp_path / "dome.step")
    table = run("part", "from-step", path, "--from-z-mm", "-163.4")
    assert table.startswith("# The axis runs through x 0.0000")
    rest = (
        '[tool]\nnose_radius_mm = 0.8\n[programs]\ndialect = "linuxcnc"\nfinish = "f.ngc"\n'
        '[gauging]\ntouches = "t.csv"\nball_radius_mm = 1.0\n'
    )
    (tmp_path / "spelt.toml").write_text(table + rest, encoding="utf-8")
    head = '[part]\nname = "dome"\nstep = "dome.step"\nstep_from_z_mm = -163.4\n'
    (tmp_path / "read.toml").write_text(head + rest, encoding="utf-8")
    spelt, read = (read_part(tmp_path / f"{name}.toml").profile.features for name in ("spelt", "read"))
    same(spelt, read, 1e-8)
    same(read[1:], modbas2().features[1:])
    assert read[0].start_mm[1] == pytest.approx(-163.4)
    assert "cylinder-1" in run("part", "show", tmp_path / "read.toml")
