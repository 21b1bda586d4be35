"""Faces that go round: full turns of cylinders, cones, balls, tori and turned splines, in files that the kernel writes.

Judged by the kernel's own points and by the solid itself: a step along a normal leads out of the material.
"""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.BRepFilletAPI import BRepFilletAPI_MakeFillet
from OCP.BRepPrimAPI import (
    BRepPrimAPI_MakeCone,
    BRepPrimAPI_MakeCylinder,
    BRepPrimAPI_MakeSphere,
    BRepPrimAPI_MakeTorus,
)
from OCP.Geom import Geom_ToroidalSurface
from OCP.gp import gp_Ax2, gp_Ax3, gp_Dir, gp_Pnt
from OCP.TopAbs import TopAbs_State

from tests.support.solids import turned_spline, written
from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.formats.cad import step as cad
from trueloop.formats.cad.kernel import kernel
from trueloop.formats.cad.step import CadFace, named_faces, read_faces, read_shape
from trueloop.geometry.surface import closest
from trueloop.surface.deviations.deviations import surface_deviations
from trueloop.surface.deviations.points import MeasuredPoints

RNG = np.random.default_rng(15)
TILTED = gp_Ax2(gp_Pnt(3.0, -7.0, 11.0), gp_Dir(0.3, -0.2, 0.9), gp_Dir(0.5, 0.6, 0.1))


def filleted(shaft: Any) -> Any:
    """A shaft with both its edges rounded by 3 mm."""
    rounded, occ = BRepFilletAPI_MakeFillet(shaft), kernel()
    edges, added = occ.Explorer(shaft, occ.EDGE), 0
    while edges.More():
        edge = occ.as_edge(edges.Current())
        if occ.Curve(edge).IsClosed() and not rounded.Contour(edge):
            rounded.Add(3.0, edge)
            added += 1
        edges.Next()
    assert added == 2
    return rounded.Shape()


def filleted_cylinder() -> Any:
    """40 mm in diameter and 40 mm long."""
    return filleted(BRepPrimAPI_MakeCylinder(TILTED, 20.0, 40.0).Shape())


SOLIDS: dict[str, Callable[[], Any]] = {
    "filleted cylinder": filleted_cylinder,
    "cone": lambda: BRepPrimAPI_MakeCone(TILTED, 20.0, 10.0, 30.0).Shape(),
    "cone to its apex": lambda: BRepPrimAPI_MakeCone(TILTED, 20.0, 0.0, 30.0).Shape(),
    "three quarters of a cone": lambda: BRepPrimAPI_MakeCone(TILTED, 20.0, 5.0, 30.0, 4.7).Shape(),
    "ball": lambda: BRepPrimAPI_MakeSphere(TILTED, 20.0).Shape(),
    "ball cap": lambda: BRepPrimAPI_MakeSphere(TILTED, 20.0, 0.3, np.pi / 2).Shape(),
    "torus": lambda: BRepPrimAPI_MakeTorus(TILTED, 30.0, 5.0).Shape(),
    "piece of a torus": lambda: BRepPrimAPI_MakeTorus(TILTED, 30.0, 5.0, -2.0, 1.0).Shape(),
    "turned spline": turned_spline,
}


def on_face(face: CadFace, count: int = 200) -> Array:
    """Points of the kernel's own face: seam among them, and ends, or all but where these are an apex or a pole."""
    occ = kernel()
    u0, u1, v0, v1 = occ.uv_bounds(face.handle)
    u, v = RNG.uniform(u0, u1, count), RNG.uniform(v0, v1, count)
    inset = 1e-4 * (v1 - v0)
    u[:10], u[10:20], v[20:30], v[30:40] = u0, u1, v0 + inset, v1 - inset
    whole = occ.surface_of(face.handle)
    return np.array([[p.X(), p.Y(), p.Z()] for p in map(whole.Value, u.tolist(), v.tolist())])


@pytest.mark.parametrize("name", SOLIDS)
def test_every_face_of_a_round_solid_is_the_kernel_s_to_the_last_digits(tmp_path: Path, name: str) -> None:
    faces = read_faces(written(SOLIDS[name](), tmp_path / "solid.step"))
    for face in faces:
        points = on_face(face)
        assert np.max(np.abs(closest(face.surface, points).distance_mm)) < 1e-8, str(face)
        assert face.loops == () or face.kind == "Plane"


@pytest.mark.parametrize("name", SOLIDS)
def test_normals_of_a_round_solid_lead_out_of_its_material(tmp_path: Path, name: str) -> None:
    path = written(SOLIDS[name](), tmp_path / "solid.step")
    occ, solid = kernel(), read_shape(path)
    for face in read_faces(path):
        (u0, u1), (v0, v1) = face.surface.domain
        u, v = (np.linspace(a + 0.02 * (b - a), b - 0.02 * (b - a), 8) for a, b in ((u0, u1), (v0, v1)))
        u, v = (a.ravel() for a in np.meshgrid(u, v))
        u, v = (a[~face.trimmed_away(u, v)] for a in (u, v))
        for side, wanted in ((0.2, TopAbs_State.TopAbs_OUT), (-0.2, TopAbs_State.TopAbs_IN)):
            for x, y, z in face.surface.point_mm(u, v) + side * face.surface.normal(u, v):
                assert BRepClass3d_SolidClassifier(solid, occ.Pnt(x, y, z), 1e-6).State() == wanted, str(face)


@pytest.mark.parametrize("start", [-4e-13, 0.0, 1e-12, 0.7, 3.1, 5.9])
@pytest.mark.parametrize("lacking", [-3e-12, 0.0, 4e-12])
def test_a_turn_that_edges_state_to_twelve_digits_is_a_turn(start: float, lacking: float) -> None:
    low, high = cad._within(start, start + 2 * np.pi - lacking, 0.0, 2 * np.pi, True)
    assert abs(low - start) < 1e-11
    assert high - low == pytest.approx(2 * np.pi, abs=1e-15)
    occ = kernel()
    torus = Geom_ToroidalSurface(gp_Ax3(), 30.0, 5.0)
    for extent in ((low, high, 0.0, 1.5), (0.0, 1.5, low, high), (low, high, low, high)):
        assert occ.to_bspline(occ.Trimmed(torus, *extent, True, True)).NbUPoles() > 2


def test_only_the_chosen_face_is_converted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A torus that the kernel cannot convert is in nobody's way, and refused with its number when it is asked for."""
    path = written(filleted_cylinder(), tmp_path / "shaft.step")
    occ = kernel()
    convert = occ.to_bspline

    def without_tori(trimmed: Any) -> Any:
        if "Toroidal" in type(trimmed.BasisSurface()).__name__:
            raise occ.Failure("Convert_TorusToBSplineSurface")
        return convert(trimmed)

    monkeypatch.setattr(occ, "to_bspline", without_tori)
    tori = [face.number for face in read_faces(path) if face.kind == "ToroidalSurface"]
    assert len(tori) == 2
    assert named_faces(path, [1])[0].surface.control_mm.shape == (7, 2, 3)
    with pytest.raises(TrueloopError, match=rf"B-spline surface of face {tori[0]}: ToroidalSurface, 559\.9 mm²") as no:
        _ = named_faces(path, [tori[0]])[0].surface
    assert no.value.code is Code.SRF_CAD
    assert no.value.place is not None and no.value.place.file == str(path)


def test_touches_all_round_a_fillet_deviate_by_what_was_left_on(tmp_path: Path) -> None:
    """By hand: the fillet of the shaft is a torus of 17 and 3 mm; 8 µm off along its radius, seam included."""
    path = written(filleted(BRepPrimAPI_MakeCylinder(20.0, 40.0).Shape()), tmp_path / "shaft.step")
    tori = (face for face in read_faces(path) if face.kind == "ToroidalSurface")
    top = max(tori, key=lambda face: float(np.max(face.surface.control_mm[..., 2])))
    at = np.linspace(0, 2 * np.pi, 40, endpoint=False), np.linspace(0.05, np.pi / 2 - 0.05, 9)
    turn, tilt = (a.ravel() for a in np.meshgrid(*at))
    r, z = 17 + 3.008 * np.cos(tilt), 37 + 3.008 * np.sin(tilt)
    points = np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)
    found = surface_deviations(top.surface, MeasuredPoints(points, name="A"))
    np.testing.assert_allclose(found.error_mm, 0.008, atol=1e-9)
    assert not np.any(top.trimmed_away(found.u, found.v))
