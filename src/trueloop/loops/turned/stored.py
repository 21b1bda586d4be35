"""A turned part's correction as it is stored and sent: every type that it may hold, and the envelope about it."""

from dataclasses import asdict
from typing import Final

from trueloop.domain import values
from trueloop.domain.option import Limits
from trueloop.domain.record import Correction
from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Arc, Line
from trueloop.geometry.profile import Junction, JunctionKind, Profile, Side
from trueloop.loops.turned import correction as turned
from trueloop.loops.turned.error_sources import FeatureSources, Share, Source
from trueloop.loops.turned.from_memory import FromMemory
from trueloop.loops.turned.part_on_machine import CompMtg, PartOnMachine, Standing
from trueloop.machine.model import model as machine_model
from trueloop.machine.model.chain import Axis, AxisKind, Chain, ErrorName
from trueloop.machine.model.history import Lag
from trueloop.machine.model.term import Part, PositionBasis, Term
from trueloop.memory.expected import Expected
from trueloop.turned.compensation.contour import CentrePiece, ShiftedFeature
from trueloop.turned.compensation.decide import AxisDecision, Decision, UnmovedDecision
from trueloop.turned.compensation.displaced import Constant, DisplacedFeature, Then
from trueloop.turned.compensation.prediction import CorrectionTable, Prediction
from trueloop.turned.compensation.shift import Shift
from trueloop.turned.error_curve.bad_touches import SuspectTouch
from trueloop.turned.error_curve.budget import Budget
from trueloop.turned.error_curve.curve import ErrorCurve
from trueloop.turned.error_curve.fit_profile import ProfileErrorModel
from trueloop.turned.error_curve.junctions import DisplacedJunction, Tangency
from trueloop.turned.fit.between_cuts import BetweenCuts, NextCut
from trueloop.turned.fit.chain_fit import TangentPolicy
from trueloop.turned.fit.choose import ModelChoice
from trueloop.turned.fit.options import BadTouches, FitOptions
from trueloop.turned.fit.spline import EndConditions, Spline
from trueloop.turned.options import Options
from trueloop.turned.program.by_tool import ByTool, MovedFeature, ToolAnswer
from trueloop.turned.program.wear_numbers import WearOffset
from trueloop.turned.touches.error_vectors import ErrorVectors, Seen

CODEC: Final = values.CODEC.with_more(
    *(Correction, Limits),
    *(Line, Arc, Curve, Junction, JunctionKind, Profile, Side, ErrorVectors, Seen, Options, BetweenCuts, EndConditions),
    *(ProfileErrorModel, FitOptions, TangentPolicy, BadTouches, ErrorCurve, Spline, SuspectTouch, DisplacedJunction),
    *(
        Tangency,
        ModelChoice,
        Decision,
        AxisDecision,
        UnmovedDecision,
        Prediction,
        Budget,
        WearOffset,
        CorrectionTable,
        turned.Composed,
    ),
    *(ByTool, MovedFeature, ToolAnswer, NextCut, FromMemory, Expected, FeatureSources, Share, Source),
    *(CentrePiece, ShiftedFeature, DisplacedFeature, Shift, Constant, Then, CompMtg, Standing, PartOnMachine),
    *(machine_model.MachineModel, Chain, Axis, AxisKind, Term, ErrorName, PositionBasis, Lag),
    TurnedCorrection=turned.Correction,
    MachineOfModel=machine_model.Machine,
    PartOfTerm=Part,
)


def enveloped(correction: turned.Correction) -> Correction[turned.Correction]:
    """Puts the correction in the envelope that all products share."""
    return Correction(correction.record, asdict(correction.options.limits), correction)
