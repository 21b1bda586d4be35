"""The parts of the CAD kernel Open CASCADE in use, under short names. It is loaded on first use: that is slow."""

from functools import cache
from types import SimpleNamespace
from typing import Any

from trueloop.errors import Code, TrueloopError
from trueloop.extras import install_command


@cache
def kernel() -> Any:
    """Returns the kernel's classes and functions. It prints nothing. Raises SRF-CAD-KERNEL if it is not installed."""
    try:
        found = _loaded()
    except ImportError as missing:
        raise TrueloopError(
            Code.SRF_CAD_KERNEL,
            f"STEP and IGES need the CAD kernel, which cannot be loaded: {str(missing)!r}",
            hint=f"{install_command('cad')}; on Debian also: apt-get install libgl1 libx11-6",
        ) from None
    found.be_silent()
    return found


def _loaded() -> SimpleNamespace:
    from OCP import collections
    from OCP.BRep import BRep_Tool
    from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Curve2d
    from OCP.BRepBuilderAPI import (
        BRepBuilderAPI_MakeEdge,
        BRepBuilderAPI_MakeFace,
        BRepBuilderAPI_MakeSolid,
        BRepBuilderAPI_MakeWire,
        BRepBuilderAPI_Sewing,
    )
    from OCP.BRepCheck import BRepCheck_Analyzer
    from OCP.BRepClass import BRepClass_FaceClassifier
    from OCP.BRepClass3d import BRepClass3d_SolidClassifier
    from OCP.BRepGProp import BRepGProp
    from OCP.BRepLib import BRepLib
    from OCP.BRepTools import BRepTools, BRepTools_WireExplorer
    from OCP.Geom import Geom_BSplineSurface, Geom_RectangularTrimmedSurface
    from OCP.Geom2dAPI import Geom2dAPI_Interpolate
    from OCP.GeomAbs import GeomAbs_CurveType, GeomAbs_Shape
    from OCP.GeomAdaptor import GeomAdaptor_Curve
    from OCP.GeomAPI import GeomAPI_ProjectPointOnSurf
    from OCP.GeomConvert import GeomConvert
    from OCP.GeomLProp import GeomLProp_SLProps
    from OCP.gp import gp_Pnt, gp_Pnt2d, gp_Vec
    from OCP.GProp import GProp_GProps
    from OCP.IFSelect import IFSelect_ReturnStatus
    from OCP.IGESControl import IGESControl_Reader, IGESControl_Writer
    from OCP.Interface import Interface_Static
    from OCP.Message import Message
    from OCP.ShapeAnalysis import ShapeAnalysis_Surface
    from OCP.Standard import Standard_Failure
    from OCP.STEPCAFControl import STEPCAFControl_Reader
    from OCP.STEPControl import STEPControl_Reader, STEPControl_StepModelType, STEPControl_Writer
    from OCP.TCollection import TCollection_ExtendedString
    from OCP.TDataStd import TDataStd_Name
    from OCP.TDF import TDF_Label
    from OCP.TDocStd import TDocStd_Document
    from OCP.TopAbs import TopAbs_Orientation, TopAbs_ShapeEnum, TopAbs_State
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS
    from OCP.XCAFDoc import XCAFDoc_DocumentTool, XCAFDoc_ShapeTool

    def be_silent() -> None:
        messenger = Message.DefaultMessenger_s()
        for printer in list(messenger.Printers()):
            messenger.RemovePrinter(printer)

    return SimpleNamespace(
        be_silent=be_silent,
        Failure=Standard_Failure,
        StepReader=STEPControl_Reader,
        StepWriter=STEPControl_Writer,
        Document=TDocStd_Document,
        DocumentReader=STEPCAFControl_Reader,
        Text=TCollection_ExtendedString,
        Label=TDF_Label,
        Labels=collections.Sequence_TDF_Label,
        Name=TDataStd_Name,
        Location=TopLoc_Location,
        ShapeTool=XCAFDoc_ShapeTool,
        shapes_of=XCAFDoc_DocumentTool.ShapeTool_s,
        IgesReader=IGESControl_Reader,
        IgesWriter=IGESControl_Writer,
        AS_IS=STEPControl_StepModelType.STEPControl_AsIs,
        DONE=IFSelect_ReturnStatus.IFSelect_RetDone,
        set_text=Interface_Static.SetCVal_s,
        Explorer=TopExp_Explorer,
        FACE=TopAbs_ShapeEnum.TopAbs_FACE,
        WIRE=TopAbs_ShapeEnum.TopAbs_WIRE,
        FORWARD=TopAbs_Orientation.TopAbs_FORWARD,
        REVERSED=TopAbs_Orientation.TopAbs_REVERSED,
        OUT=TopAbs_State.TopAbs_OUT,
        IN=TopAbs_State.TopAbs_IN,
        EDGE=TopAbs_ShapeEnum.TopAbs_EDGE,
        SHELL=TopAbs_ShapeEnum.TopAbs_SHELL,
        SOLID=TopAbs_ShapeEnum.TopAbs_SOLID,
        as_face=TopoDS.Face,
        as_edge=TopoDS.Edge,
        as_wire=TopoDS.Wire,
        as_shell=TopoDS.Shell,
        as_solid=TopoDS.Solid,
        WireExplorer=BRepTools_WireExplorer,
        Curve=BRepAdaptor_Curve,
        FreeCurve=GeomAdaptor_Curve,
        Curve2d=BRepAdaptor_Curve2d,
        C1=GeomAbs_Shape.GeomAbs_C1,
        CN=GeomAbs_Shape.GeomAbs_CN,
        Interpolate=Geom2dAPI_Interpolate,
        build_curves=BRepLib.BuildCurves3d_s,
        orient_closed=BRepLib.OrientClosedSolid_s,
        same_parameter=BRepLib.SameParameter_s,
        Check=BRepCheck_Analyzer,
        degenerated=BRep_Tool.Degenerated_s,
        surface_of=BRep_Tool.Surface_s,
        uv_bounds=BRepTools.UVBounds_s,
        SurfacePlaces=ShapeAnalysis_Surface,
        Differential=GeomLProp_SLProps,
        Trimmed=Geom_RectangularTrimmedSurface,
        to_bspline=GeomConvert.SurfaceToBSplineSurface_s,
        BSpline=Geom_BSplineSurface,
        MakeEdge=BRepBuilderAPI_MakeEdge,
        MakeWire=BRepBuilderAPI_MakeWire,
        MakeFace=BRepBuilderAPI_MakeFace,
        FaceClassifier=BRepClass_FaceClassifier,
        SolidClassifier=BRepClass3d_SolidClassifier,
        MakeSolid=BRepBuilderAPI_MakeSolid,
        Sewing=BRepBuilderAPI_Sewing,
        Projection=GeomAPI_ProjectPointOnSurf,
        Properties=GProp_GProps,
        measure=BRepGProp.SurfaceProperties_s,
        LINE=GeomAbs_CurveType.GeomAbs_Line,
        CIRCLE=GeomAbs_CurveType.GeomAbs_Circle,
        Pnt=gp_Pnt,
        Vec=gp_Vec,
        Pnt2d=gp_Pnt2d,
        Points2d=collections.HArray1_gp_Pnt2d,
        Points=collections.Array2_gp_Pnt,
        Reals2=collections.Array2_double,
        Reals=collections.Array1_double,
        Integers=collections.Array1_int,
    )
