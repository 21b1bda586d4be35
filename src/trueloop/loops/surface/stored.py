"""A surface's correction as it is stored and sent: every type that it may hold, and the envelope about it."""

from dataclasses import asdict
from typing import Final

from trueloop.domain import values
from trueloop.domain.correction import Correction
from trueloop.domain.limits import Limits
from trueloop.errors import Code, Finding, Place, Severity
from trueloop.geometry.surface import Surface
from trueloop.loops.surface.correction import RecordedCorrection
from trueloop.loops.surface.figures import SurfaceFigures
from trueloop.loops.surface.surface import Part, SurfaceCorrection, SurfaceModel
from trueloop.loops.surface.touches import WorstTouch
from trueloop.surface.compensation.program import CorrectedProgram
from trueloop.surface.compensation.shift import CorrectedSurface
from trueloop.surface.deviations.alignment import Alignment
from trueloop.surface.deviations.deviations import SurfaceDeviations
from trueloop.surface.on_face import OnFace
from trueloop.surface.options import SurfaceOptions
from trueloop.surface.pattern.kriging import Process
from trueloop.surface.pattern.outlier import Outlier
from trueloop.surface.pattern.pattern import Pattern
from trueloop.surface.pattern.support import Support
from trueloop.surface.separation.moran import Null
from trueloop.surface.separation.neighbourhood import Neighbourhood
from trueloop.surface.separation.normality import Normality
from trueloop.surface.separation.outlying_point import OutlyingPoint
from trueloop.surface.separation.places import Places
from trueloop.surface.separation.separate import Separation, Trial
from trueloop.surface.separation.spline_surface import Size, SplineSurface

CODEC: Final = values.CODEC.with_more(
    *(Correction, Limits, Finding, Severity, Code, Place, Surface, SurfaceOptions, SurfaceDeviations, Alignment),
    *(Separation, Trial, Neighbourhood, Places, SplineSurface, Size, Null, Normality, WorstTouch, OutlyingPoint),
    *(Pattern, Outlier, Support, Process, OnFace, SurfaceFigures, SurfaceModel, SurfaceCorrection, CorrectedSurface),
    *(CorrectedProgram,),
    PartOfSurface=Part,
)


def enveloped(done: RecordedCorrection) -> Correction[SurfaceCorrection]:
    """The correction in the envelope that all products share."""
    return Correction(done.record, asdict(done.correction.model.options.limits), done.correction)
