"""Deviation along a profile: constrained splines, lines, junctions, the nose model."""

from trueloop.error_curve.chain import TangentPolicy
from trueloop.error_curve.choose import ModelChoice
from trueloop.error_curve.curve import ErrorCurve
from trueloop.error_curve.fit_profile import ProfileErrorModel, fit_profile
from trueloop.error_curve.junctions import DisplacedJunction
from trueloop.error_curve.nose_fit import fit_nose_model, nose_touches
from trueloop.error_curve.nose_model import NoseModel, NosePrediction, NoseTouches
from trueloop.error_curve.options import FitOptions
from trueloop.error_curve.spline import EndConditions, Spline, least_squares_spline
from trueloop.error_curve.tangency import Tangency

__all__ = [
    "DisplacedJunction",
    "EndConditions",
    "ErrorCurve",
    "FitOptions",
    "ModelChoice",
    "NoseModel",
    "NosePrediction",
    "NoseTouches",
    "ProfileErrorModel",
    "Spline",
    "Tangency",
    "TangentPolicy",
    "fit_nose_model",
    "fit_profile",
    "least_squares_spline",
    "nose_touches",
]
