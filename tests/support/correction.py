"""A correction for tests of the report: the MODBAS2 example's part and touches, really fitted; its programs are stand-ins.

Small enough to give its parts any name and its programs any text. What the loop itself makes is tested with the loop.
"""

from pathlib import Path

import numpy as np

from trueloop.compensation.contour import centre_pieces, shifted_contour
from trueloop.compensation.decide import decide
from trueloop.compensation.prediction import predict
from trueloop.compensation.record import Record, sha256_of
from trueloop.compensation.shift import ZERO, Shift
from trueloop.compensation.table import correction_table
from trueloop.error_curve import ErrorCurve, fit_profile
from trueloop.formats.job import read_job
from trueloop.formats.profile_of_job import profile_of_table
from trueloop.formats.touches_csv import read_touches
from trueloop.gauging.touches import Gauging, error_vectors
from trueloop.loops.process_intermittent import Correction, Options

EXAMPLE = Path(__file__).parents[2] / "examples/modbas2"
NOSE_RADIUS_MM = 0.79375
SOURCE = b"N1 G70\nN2 G01 X(P46+0.0625) Z-1.76\nN3 G02 X0.0 Z0.03125 R1.49125 ! Dome\nN4 M30\n"


def modbas2_correction(part: str = "MODBAS2", corrected_program: bytes | None = None) -> Correction:
    """The example's correction, weight 1, tangent junctions by `part`."""
    profile = profile_of_table(read_job(EXAMPLE / "job.toml").part)
    touches = error_vectors(profile, read_touches(EXAMPLE / "touches.csv"), Gauging(z_reference="11"))
    model = fit_profile(profile, touches)
    shifts = tuple(_against(curve) for curve in model.curves)
    nothing = (ZERO,) * len(shifts)
    commanded = centre_pieces(profile, shifted_contour(profile, nothing, NOSE_RADIUS_MM))
    corrected = centre_pieces(profile, shifted_contour(profile, shifts, NOSE_RADIUS_MM))
    fitted = touches.error_mm - model.residual_mm
    at_touches = zip(touches.feature_index, touches.arc_length_mm, strict=True)
    curve_u = np.array([model.curves[i].standard_deviation_mm(s)[0] for i, s in at_touches])
    scatter = np.full(len(fitted), model.scatter_mm)
    return Correction(
        part=part,
        profile=profile,
        nose_radius_mm=NOSE_RADIUS_MM,
        touches=touches,
        options=Options(),
        model=model,
        decision=decide(touches.error_mm, touches.outward_normal, model.scatter_mm, np.inf, 0.001, 1.0),
        commanded_shift=nothing,
        corrected_shift=shifts,
        commanded=commanded,
        corrected=corrected,
        prediction=predict(
            touches.error_mm,
            fitted,
            touches.error_mm - model.leave_one_out_mm,
            np.zeros_like(fitted),
            curve_u,
            scatter,
            1.0,
        ),
        source_program=SOURCE,
        corrected_program=corrected_program or _with_many_moves(SOURCE),
        offsets_program=SOURCE,
        dialect="ge2000t",
        table=correction_table(commanded, corrected),
        record=Record(
            id="0123456789abcdef",
            made_at="2026-01-31T08:15:00+00:00",
            made_by="a test",
            trueloop_version="0.1.0",
            inputs_sha256={"finish.nc": sha256_of(SOURCE)},
            options={"weight": 1.0, "junctions": "part"},
            model={},
            decision=[],
            changes=[],
        ),
        notes=("the stand-in program is not the example's",),
    )


def _against(curve: ErrorCurve) -> Shift:
    return Shift(lambda s: -curve.value_mm(s).reshape(np.shape(s)), lambda s: -curve.slope(s).reshape(np.shape(s)))


def _with_many_moves(source: bytes) -> bytes:
    """One changed word, and the arc as twelve moves."""
    lines = source.decode().splitlines()
    lines[1] = lines[1].replace("0.0625", "0.0625-0.00096")
    lines[2:3] = [f"N3 G02 X{12 - k}.0 Z-{12 - k}.0 R1.4{k:02d}" for k in range(12)]
    return "\n".join([*lines, ""]).encode()
