"""The process-intermittent loop: touches after the semi-finish cut to a corrected finish program.

This module only strings pieces together: match the program with the profile, fit error curves to the touches, turn
them into a compensated contour, check it, write it into the program.
"""

from dataclasses import dataclass

from trueloop.compensation.contour import CentrePiece
from trueloop.compensation.decide import Decision
from trueloop.compensation.limits import Limits
from trueloop.compensation.prediction import Prediction
from trueloop.compensation.record import Record
from trueloop.compensation.shift import Shift
from trueloop.compensation.table import CorrectionTable
from trueloop.gauging.error_vectors import ErrorVectors
from trueloop.geometry.profile import Profile


@dataclass(frozen=True)
class Options:
    """How to compensate. Lengths in mm."""

    weight: float = 1.0
    junctions: str = "part"
    knot_every: int | None = None
    chord_tolerance_mm: float = 0.0005
    arcs: str = "auto"
    limits: Limits = Limits()


@dataclass(frozen=True)
class Correction:
    """Everything one correction is made of and was made from: what the report shows and the files hold."""

    part: str
    profile: Profile
    nose_radius_mm: float
    touches: ErrorVectors
    options: Options
    model: "object"  # ProfileErrorModel
    decision: Decision
    commanded_shift: tuple[Shift, ...]
    corrected_shift: tuple[Shift, ...]
    commanded: tuple[CentrePiece, ...]
    corrected: tuple[CentrePiece, ...]
    prediction: Prediction
    source_program: bytes
    corrected_program: bytes
    offsets_program: bytes
    dialect: str
    table: CorrectionTable
    record: Record
    notes: tuple[str, ...]
