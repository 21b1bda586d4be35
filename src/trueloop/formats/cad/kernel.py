"""The parts of the CAD kernel Open CASCADE in use, under short names. It is loaded on first use: that is slow."""

from collections.abc import Iterator
from functools import cache, reduce
from importlib import import_module
from types import SimpleNamespace
from typing import Any, Final

from trueloop.errors import Code
from trueloop.extras import install_command

NAMES: Final = {
    "Failure": "Standard_Failure",
    "StepReader": "STEPControl_Reader",
    "StepWriter": "STEPControl_Writer",
    "Document": "TDocStd_Document",
    "DocumentReader": "STEPCAFControl_Reader",
    "Text": "TCollection_ExtendedString",
    "Label": "TDF_Label",
    "Labels": "collections.Sequence_TDF_Label",
    "Name": "TDataStd_Name",
    "Location": "TopLoc_Location",
    "ShapeTool": "XCAFDoc_ShapeTool",
    "shapes_of": "XCAFDoc_DocumentTool.ShapeTool_s",
    "IgesReader": "IGESControl_Reader",
    "IgesWriter": "IGESControl_Writer",
    "AS_IS": "STEPControl_StepModelType.STEPControl_AsIs",
    "DONE": "IFSelect_ReturnStatus.IFSelect_RetDone",
    "set_text": "Interface_Static.SetCVal_s",
    "Explorer": "TopExp_Explorer",
    "FACE": "TopAbs_ShapeEnum.TopAbs_FACE",
    "WIRE": "TopAbs_ShapeEnum.TopAbs_WIRE",
    "FORWARD": "TopAbs_Orientation.TopAbs_FORWARD",
    "REVERSED": "TopAbs_Orientation.TopAbs_REVERSED",
    "OUT": "TopAbs_State.TopAbs_OUT",
    "IN": "TopAbs_State.TopAbs_IN",
    "EDGE": "TopAbs_ShapeEnum.TopAbs_EDGE",
    "SHELL": "TopAbs_ShapeEnum.TopAbs_SHELL",
    "SOLID": "TopAbs_ShapeEnum.TopAbs_SOLID",
    "as_face": "TopoDS.Face",
    "as_edge": "TopoDS.Edge",
    "as_wire": "TopoDS.Wire",
    "as_shell": "TopoDS.Shell",
    "as_solid": "TopoDS.Solid",
    "WireExplorer": "BRepTools_WireExplorer",
    "Curve": "BRepAdaptor_Curve",
    "FreeCurve": "GeomAdaptor_Curve",
    "Curve2d": "BRepAdaptor_Curve2d",
    "C1": "GeomAbs_Shape.GeomAbs_C1",
    "CN": "GeomAbs_Shape.GeomAbs_CN",
    "Interpolate": "Geom2dAPI_Interpolate",
    "build_curves": "BRepLib.BuildCurves3d_s",
    "orient_closed": "BRepLib.OrientClosedSolid_s",
    "same_parameter": "BRepLib.SameParameter_s",
    "Check": "BRepCheck_Analyzer",
    "degenerated": "BRep_Tool.Degenerated_s",
    "surface_of": "BRep_Tool.Surface_s",
    "uv_bounds": "BRepTools.UVBounds_s",
    "SurfacePlaces": "ShapeAnalysis_Surface",
    "Differential": "GeomLProp_SLProps",
    "Trimmed": "Geom_RectangularTrimmedSurface",
    "to_bspline": "GeomConvert.SurfaceToBSplineSurface_s",
    "BSpline": "Geom_BSplineSurface",
    "MakeEdge": "BRepBuilderAPI_MakeEdge",
    "MakeWire": "BRepBuilderAPI_MakeWire",
    "MakeFace": "BRepBuilderAPI_MakeFace",
    "FaceClassifier": "BRepClass_FaceClassifier",
    "SolidClassifier": "BRepClass3d_SolidClassifier",
    "MakeSolid": "BRepBuilderAPI_MakeSolid",
    "Sewing": "BRepBuilderAPI_Sewing",
    "Projection": "GeomAPI_ProjectPointOnSurf",
    "Properties": "GProp_GProps",
    "measure": "BRepGProp.SurfaceProperties_s",
    "LINE": "GeomAbs_CurveType.GeomAbs_Line",
    "CIRCLE": "GeomAbs_CurveType.GeomAbs_Circle",
    "Pnt": "gp_Pnt",
    "Vec": "gp_Vec",
    "Pnt2d": "gp_Pnt2d",
    "Points2d": "collections.HArray1_gp_Pnt2d",
    "Points": "collections.Array2_gp_Pnt",
    "Reals2": "collections.Array2_double",
    "Reals": "collections.Array1_double",
    "Integers": "collections.Array1_int",
}
"""Short names of what is used. A class `Module_Name` stands in the module `Module` of OCP."""


@cache
def kernel() -> Any:
    """Returns the kernel's classes and functions. It prints nothing. Raises SRF-CAD-KERNEL if it is not installed."""
    try:
        found = _loaded()
    except ImportError as missing:
        raise Code.SRF_CAD_KERNEL.refusal(
            f"STEP and IGES need the CAD kernel, which cannot be loaded: {str(missing)!r}",
            hint=f"{install_command('cad')}; on Debian also: apt-get install libgl1 libx11-6",
        ) from None
    found.be_silent()
    return found


def edge_curves(face: Any) -> Iterator[Any]:
    """Yields the curve of every edge of a face; what is only a point in space bounds nothing."""
    occ = kernel()
    explorer = occ.Explorer(face, occ.EDGE)
    while explorer.More():
        edge = occ.as_edge(explorer.Current())
        if not occ.degenerated(edge):
            yield occ.Curve(edge)
        explorer.Next()


def _loaded() -> SimpleNamespace:
    import_module("OCP")  # where this fails, what is loaded of it counts for nothing
    found = SimpleNamespace(**{name: _resolved(path) for name, path in NAMES.items()})

    def be_silent() -> None:
        messenger = _resolved("Message.DefaultMessenger_s")()
        for printer in list(messenger.Printers()):
            messenger.RemovePrinter(printer)

    found.be_silent = be_silent
    return found


def _resolved(path: str) -> Any:
    first, *rest = path.split(".")
    module = import_module(f"OCP.{first.partition('_')[0]}")
    return reduce(getattr, rest, module if first == "collections" else getattr(module, first))
