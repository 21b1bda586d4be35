"""Limits of a correction: beyond them it is refused, never clamped in silence."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime

import numpy as np

from trueloop.errors import Code, TrueloopError
from trueloop.geometry.feature import Arc
from trueloop.turned.compensation.contour import CentrePiece
from trueloop.turned.compensation.shift import Shift
from trueloop.units import UM_PER_MM

SAMPLES = 201


@dataclass(frozen=True)
class Limits:
    """What is accepted. Sizes and scatter in mm along the normal, slopes in mm per mm of arc, age in hours."""

    correction_mm: float = 0.150
    slope: float = 0.040
    scatter_mm: float = 0.010
    age_hours: float = 24.0


def check_limits(
    pieces: Sequence[CentrePiece], corrections: Sequence[Shift], limits: Limits, what: str = "the correction"
) -> None:
    """Refuses a correction that is too large or too steep anywhere the nose cuts, saying where and by how much."""
    for piece, correction in zip(pieces, corrections, strict=True):
        feature = piece.shifted.feature
        s = np.linspace(max(piece.start_mm, 0.0), min(piece.end_mm, feature.length_mm), SAMPLES)
        size, slope = np.abs(correction.value_mm(s)), np.abs(correction.slope(s))
        for code, values, limit, unit, key in (
            (Code.CMP_SIZE, size, limits.correction_mm, "µm", "max_correction_um"),
            (Code.CMP_SLOPE, slope, limits.slope, "µm/mm", "max_slope_um_per_mm"),
        ):
            k = int(np.argmax(values))
            if values[k] > limit:
                x, z = feature.point_mm(s[k])
                raise TrueloopError(
                    code,
                    f"{what} of {feature.name!r} reaches {values[k] * UM_PER_MM:.1f} {unit} at x {x:.3f} mm "
                    f"(radius), z {z:.3f} mm; the limit is {limit * UM_PER_MM:.1f} {unit}",
                    hint="look at the touches there first: a bad touch is likelier than such an error",
                    override=f"compensation.{key} in the job",
                )


def check_nose(pieces: Sequence[CentrePiece]) -> None:
    """Refuses a concave arc that the correction makes too tight for the nose, and a feature that it leaves nothing of.

    The centre paths of such an arc and its neighbours do not cross where they should, or the arc's own turns back.
    """
    tight = [piece for piece in pieces if _radius_left_mm(piece) <= piece.shifted.nose_radius_mm]
    lost = sorted((piece for piece in pieces if not _cuts(piece)), key=_radius_left_mm)
    for piece in (*tight, *lost):
        feature, nose_mm = piece.shifted.feature, piece.shifted.nose_radius_mm
        what = f"the nose (radius {nose_mm:.4f} mm) does not fit into {feature.name!r} as corrected"
        if isinstance(feature, Arc):
            what += f": the arc's radius is {feature.radius_mm:.4f} mm, bent tighter than the nose by its correction"
        hint = "take a smaller nose, or look at the touches there and beside it: a bad one bends the contour most"
        raise TrueloopError(Code.GEO_NOSE, what, hint=hint)


def _radius_left_mm(piece: CentrePiece) -> float:
    """Radius of a concave arc less the most by which it is moved out of the material; infinite for other features."""
    feature = piece.shifted.feature
    if not isinstance(feature, Arc) or feature.curvature_per_mm(0.0) > 0:
        return np.inf
    s = np.linspace(0.0, feature.length_mm, SAMPLES)
    return feature.radius_mm - float(np.max(piece.shifted.shift.value_mm(s)))


def _cuts(piece: CentrePiece) -> bool:
    """Whether any of the feature itself is cut."""
    return max(piece.start_mm, 0.0) < min(piece.end_mm, piece.shifted.feature.length_mm)


def check_offset(offset_mm: tuple[float, float], limits: Limits) -> None:
    """Refuses a tool offset (x as a radius, z) that is too large along either axis."""
    for axis, value_mm in zip("XZ", offset_mm, strict=True):
        if abs(value_mm) > limits.correction_mm:
            raise TrueloopError(
                Code.CMP_SIZE,
                f"the tool offset on {axis} would be {value_mm * UM_PER_MM:+.1f} µm{' (radius)' * (axis == 'X')}; the "
                f"limit is {limits.correction_mm * UM_PER_MM:.1f} µm",
                hint="a constant this large is likelier a ball radius, an allowance or a datum that the job leaves out",
                override="compensation.max_correction_um in the job",
            )


def check_scatter(scatter_mm: float, limits: Limits, cause: str = "") -> None:
    """Refuses touches that scatter about what was fitted by more than the limit: then little of the error repeats.

    cause: what is known of where the scatter comes from, a clause for the message.
    """
    if scatter_mm > limits.scatter_mm:
        raise TrueloopError(
            Code.CMP_SCATTER,
            f"the touches scatter by {scatter_mm * UM_PER_MM:.1f} µm (one standard deviation) about what was fitted; "
            f"the limit is {limits.scatter_mm * UM_PER_MM:.1f} µm{f'; {cause}' if cause else ''}",
            hint="look for a bad touch, a loose probe or chatter: what does not repeat cannot be corrected",
            override="compensation.max_scatter_um in the job",
        )


def check_age(measured_at: datetime, now: datetime, limits: Limits) -> None:
    """Refuses touches that are older than the limit, or from the future. Both times know their zone, or neither."""
    age_hours = (now - measured_at).total_seconds() / 3600
    if age_hours < 0:
        raise TrueloopError(
            Code.CMP_AGE,
            f"the touches were taken {-age_hours:.1f} h from now ({measured_at.isoformat(timespec='minutes')})",
            hint="set the clock, or the time and its zone that the job gives",
        )
    if age_hours > limits.age_hours:
        raise TrueloopError(
            Code.CMP_AGE,
            f"the touches were taken {age_hours:.1f} h ago ({measured_at.isoformat(timespec='minutes')}); "
            f"the limit is {limits.age_hours:g} h",
            hint="probe the part again: machine and tool have changed since",
            override="compensation.max_age_hours in the job",
        )
