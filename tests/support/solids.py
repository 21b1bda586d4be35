"""Solids made by the CAD kernel, and the files it writes of them."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from trueloop.formats.cad.kernel import kernel
from trueloop.geometry.feature import Feature, Line, Point


def written(shape: Any, path: Path, unit: str = "MM") -> Path:
    """A STEP file of a shape."""
    occ = kernel()
    writer = occ.StepWriter()
    occ.set_text("write.step.unit", unit)
    try:
        assert writer.Transfer(shape, occ.AS_IS) == occ.DONE
        assert writer.Write(str(path)) == occ.DONE
    finally:
        occ.set_text("write.step.unit", "MM")
    return path


SPINDLE = [(8.0, 0.0), (12.0, 7.0), (9.0, 15.0), (11.0, 22.0), (6.0, 30.0)]
"""(x, z) through which a spline goes."""


def spindle() -> Any:
    """The kernel's spline through the points of `SPINDLE`."""
    from OCP.collections import HArray1_gp_Pnt
    from OCP.GeomAPI import GeomAPI_Interpolate
    from OCP.gp import gp_Pnt

    points = HArray1_gp_Pnt(1, len(SPINDLE))
    for k, (r, z) in enumerate(SPINDLE, 1):
        points.SetValue(k, gp_Pnt(r, 0.0, z))
    spline = GeomAPI_Interpolate(points, False, 1e-9)
    spline.Perform()
    return spline.Curve()


def turned_spline() -> Any:
    """A spindle-shaped solid: a spline through five points, turned once round the z axis."""
    from OCP.gp import gp_Pnt

    (r0, z0), (r1, z1) = SPINDLE[0], SPINDLE[-1]
    return _turned_curve(spindle(), [gp_Pnt(r1, 0, z1), gp_Pnt(0, 0, z1), gp_Pnt(0, 0, z0), gp_Pnt(r0, 0, z0)])


def paraboloid(radius: float, edge: float, as_b_spline: bool) -> Any:
    """A cylinder whose free end is z = −x²/(2 R), exact as a Bézier curve; its face turned, or as a B-spline."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_NurbsConvert
    from OCP.collections import Array1_gp_Pnt
    from OCP.Geom import Geom_BezierCurve
    from OCP.gp import gp_Pnt

    low, poles = -(edge**2) / (2 * radius), Array1_gp_Pnt(1, 3)
    for k, (x, z) in enumerate([(edge, low), (edge / 2, 0.0), (0.0, 0.0)], 1):
        poles.SetValue(k, gp_Pnt(x, 0, z))
    corners = [gp_Pnt(0, 0, 0), gp_Pnt(0, 0, -20), gp_Pnt(edge, 0, -20), gp_Pnt(edge, 0, low)]
    solid, occ = _turned_curve(Geom_BezierCurve(poles), corners), kernel()
    if not as_b_spline:
        return solid
    faces, sewing = occ.Explorer(solid, occ.FACE), occ.Sewing(1e-5)
    while faces.More():
        face = occ.as_face(faces.Current())
        dome = type(occ.surface_of(face)).__name__ == "Geom_SurfaceOfRevolution"
        sewing.Add(BRepBuilderAPI_NurbsConvert(face).Shape() if dome else face)
        faces.Next()
    sewing.Perform()
    closed = occ.MakeSolid(occ.as_shell(occ.Explorer(sewing.SewedShape(), occ.SHELL).Current())).Solid()
    occ.orient_closed(closed)
    return closed


def _turned_curve(curve: Any, corners: Sequence[Any]) -> Any:
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeRevol
    from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt

    wire = BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(curve).Edge())
    for a, b in pairwise(corners):
        wire.Add(BRepBuilderAPI_MakeEdge(a, b).Edge())
    face = BRepBuilderAPI_MakeFace(wire.Wire()).Face()
    return BRepPrimAPI_MakeRevol(face, gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))).Shape()


def turned(features: Sequence[Feature], bore_mm: float = 0.0, place: Any = None) -> Any:
    """The solid that a profile bounds, turned about the z axis, closed by a face at the chuck, with a bore or none;
    moved to a place (gp_Ax3) with its axis.
    """
    from OCP.BRepBuilderAPI import (
        BRepBuilderAPI_MakeEdge,
        BRepBuilderAPI_MakeFace,
        BRepBuilderAPI_MakeWire,
        BRepBuilderAPI_Transform,
    )
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeRevol
    from OCP.GC import GC_MakeArcOfCircle
    from OCP.gp import gp_Ax1, gp_Ax3, gp_Dir, gp_Pnt, gp_Trsf

    def at(point: Point) -> Any:
        return gp_Pnt(point[0], 0.0, point[1])

    (_, z0), (x1, z1) = features[0].start_mm, features[-1].end_mm
    wire = BRepBuilderAPI_MakeWire()
    for feature in features:
        start, middle, end = (at(tuple(feature.point_mm(s))) for s in (0, feature.length_mm / 2, feature.length_mm))
        straight = isinstance(feature, Line)
        curve = None if straight else GC_MakeArcOfCircle(start, middle, end).Value()
        wire.Add((BRepBuilderAPI_MakeEdge(start, end) if straight else BRepBuilderAPI_MakeEdge(curve)).Edge())
    corners = [(x1, z1), *([(bore_mm, z1)] if x1 > bore_mm else []), (bore_mm, z0), features[0].start_mm]
    for a, b in pairwise(corners):
        wire.Add(BRepBuilderAPI_MakeEdge(at(a), at(b)).Edge())
    face = BRepBuilderAPI_MakeFace(wire.Wire()).Face()
    solid = BRepPrimAPI_MakeRevol(face, gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))).Shape()
    if place is None:
        return solid
    move = gp_Trsf()
    move.SetTransformation(place, gp_Ax3())
    return BRepBuilderAPI_Transform(solid, move).Shape()


def revolved(section: Sequence[Point | tuple[Point, Point]], place: Any = None) -> Any:
    """The solid of a closed section, (x, z): straight to each point, or, of a pair, round through the first to the
    second; it starts at the last.
    """
    from OCP.BRepBuilderAPI import (
        BRepBuilderAPI_MakeEdge,
        BRepBuilderAPI_MakeFace,
        BRepBuilderAPI_MakeWire,
        BRepBuilderAPI_Transform,
    )
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeRevol
    from OCP.GC import GC_MakeArcOfCircle
    from OCP.gp import gp_Ax1, gp_Ax3, gp_Dir, gp_Pnt, gp_Trsf

    wire, at = BRepBuilderAPI_MakeWire(), _end(section[-1])
    for step in section:
        middle, end = step if isinstance(step[0], tuple) else (None, step)
        here, there = gp_Pnt(at[0], 0.0, at[1]), gp_Pnt(end[0], 0.0, end[1])
        if middle is None:
            wire.Add(BRepBuilderAPI_MakeEdge(here, there).Edge())
        else:
            arc = GC_MakeArcOfCircle(here, gp_Pnt(middle[0], 0.0, middle[1]), there).Value()
            wire.Add(BRepBuilderAPI_MakeEdge(arc).Edge())
        at = _end(step)
    face = BRepBuilderAPI_MakeFace(wire.Wire()).Face()
    solid = BRepPrimAPI_MakeRevol(face, gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))).Shape()
    if place is None:
        return solid
    move = gp_Trsf()
    move.SetTransformation(place, gp_Ax3())
    return BRepBuilderAPI_Transform(solid, move).Shape()


def _end(step: Any) -> Point:
    x, z = step[1] if isinstance(step[0], tuple) else step
    return x, z


def without(solid: Any, *tools: Any) -> Any:
    """The solid less others."""
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut

    for tool in tools:
        solid = BRepAlgoAPI_Cut(solid, tool).Shape()
    return solid


def drill(at: tuple[float, float, float], along: tuple[float, float, float], radius: float, deep: float) -> Any:
    """A cylinder to cut with."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt

    return BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(*at), gp_Dir(*along)), radius, deep).Shape()


def block(low: tuple[float, float, float], high: tuple[float, float, float]) -> Any:
    """A box between two corners."""
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox
    from OCP.gp import gp_Pnt

    return BRepPrimAPI_MakeBox(gp_Pnt(*low), gp_Pnt(*high)).Shape()
