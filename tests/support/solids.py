"""Solids made by the CAD kernel, and the files it writes of them."""

from itertools import pairwise
from pathlib import Path
from typing import Any

from trueloop.formats.cad_kernel import kernel


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


def turned_spline() -> Any:
    """A spindle-shaped solid: a spline through five points, turned once round the z axis."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakeWire
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeRevol
    from OCP.collections import HArray1_gp_Pnt
    from OCP.GeomAPI import GeomAPI_Interpolate
    from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt

    through = [(8.0, 0.0), (12.0, 7.0), (9.0, 15.0), (11.0, 22.0), (6.0, 30.0)]
    points = HArray1_gp_Pnt(1, len(through))
    for k, (r, z) in enumerate(through, 1):
        points.SetValue(k, gp_Pnt(r, 0.0, z))
    spline = GeomAPI_Interpolate(points, False, 1e-9)
    spline.Perform()
    (r0, z0), (r1, z1) = through[0], through[-1]
    corners = [gp_Pnt(r1, 0, z1), gp_Pnt(0, 0, z1), gp_Pnt(0, 0, z0), gp_Pnt(r0, 0, z0)]
    wire = BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(spline.Curve()).Edge())
    for a, b in pairwise(corners):
        wire.Add(BRepBuilderAPI_MakeEdge(a, b).Edge())
    face = BRepBuilderAPI_MakeFace(wire.Wire()).Face()
    return BRepPrimAPI_MakeRevol(face, gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))).Shape()
