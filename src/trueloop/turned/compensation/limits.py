"""A compensated contour against the limits of a correction (`domain.option`), and against its nose."""

from collections.abc import Sequence

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.option import Limits, allowed_by
from trueloop.errors import Code
from trueloop.geometry.feature import is_curved, least_radius_mm
from trueloop.turned.compensation.displaced import CentrePiece
from trueloop.turned.compensation.shift import Shift
from trueloop.units import UM_PER_MM
from trueloop.wording import Um, wording

SAMPLES = 201


def check_limits(pieces: Sequence[CentrePiece], corrections: Sequence[Shift], limits: Limits) -> None:
    """Refuses a correction that is too large or too steep anywhere the nose cuts, saying where and by how much.

    The slope counts without that of the rigid shift d (x, z) next to the whole correction: of n·d it is κ t·d, which on
    an edge of radius R is d/R, however right the correction is. A feature that does not follow that shift counts as it
    is.
    """
    places = [cut_mm(piece) for piece in pieces]
    values = [shift.value_mm(s) for shift, s in zip(corrections, places, strict=True)]
    # The shift (x, z) whose share n·d along all that is cut comes nearest to these values, (2,)
    lengths = [np.sqrt(max(float(s[-1] - s[0]), 0.0) / len(s)) for s in places]
    normals = [piece.shifted.feature.outward_normal(s) for piece, s in zip(pieces, places, strict=True)]
    rows = np.concatenate([length * normal for length, normal in zip(lengths, normals, strict=True)])
    wanted = np.concatenate([length * value for length, value in zip(lengths, values, strict=True)])
    rigid = np.asarray(np.linalg.lstsq(rows, wanted, rcond=None)[0])
    for piece, correction, s, size in zip(pieces, corrections, places, values, strict=True):
        feature = piece.shifted.feature
        of_shift = feature.curvature_per_mm(s) * (feature.tangent(s) @ rigid)
        slope = correction.slope(s)
        steep = np.minimum(np.abs(slope), np.abs(slope - of_shift))
        check_along(piece, np.abs(size), steep, limits, wording("the correction"))


def cut_mm(piece: CentrePiece) -> Array:
    """Returns evenly spaced arc lengths over the part of a feature that the nose cuts, (n,)."""
    return np.linspace(max(piece.start_mm, 0.0), min(piece.end_mm, piece.shifted.feature.length_mm), SAMPLES)


def check_along(piece: CentrePiece, size_mm: Array, slope: Array, limits: Limits, what: str) -> None:
    """Checks sizes and slopes at `cut_mm`, (n,), against the limits."""
    feature = piece.shifted.feature
    for code, values, limit, unit, field in (
        (Code.CMP_SIZE, size_mm, limits.correction_mm, "µm", "correction_mm"),
        (Code.CMP_SLOPE, slope, limits.slope, "µm/mm", "slope"),
    ):
        k = int(np.argmax(values))
        if values[k] > limit:
            x, z = feature.point_mm(cut_mm(piece)[k])
            raise code.refusal(
                wording(
                    "{what} of {feature!r} reaches {size:.1f} {unit} at x {x:.3f} mm (radius), z {z:.3f} mm; the limit "
                    "is {limit:.1f} {unit}",
                    what=what,
                    feature=feature.name,
                    size=float(values[k]) * UM_PER_MM,
                    unit=unit,
                    x=float(x),
                    z=float(z),
                    limit=limit * UM_PER_MM,
                ),
                hint=wording(
                    "look first at the touches that determine it, there or beside it: a bad touch is likelier than "
                    "such an error"
                ),
                override=allowed_by(field),
                values=dict(zip(code.values, (float(values[k]) * UM_PER_MM, limit * UM_PER_MM), strict=True)),
            )


def check_nose(pieces: Sequence[CentrePiece]) -> None:
    """Refuses a concave feature that the correction makes too tight for the nose, and one that it leaves nothing of.

    The centre paths of such an arc and its neighbours do not cross where they should, or the arc's own turns back.
    """
    tight = [piece for piece in pieces if _radius_left_mm(piece) <= piece.shifted.nose_radius_mm]
    lost = sorted((piece for piece in pieces if not _cuts(piece)), key=_radius_left_mm)
    for piece in (*tight, *lost):
        feature, nose_mm = piece.shifted.feature, piece.shifted.nose_radius_mm
        what = f"the nose (radius {nose_mm:.4f} mm) does not fit into {feature.name!r} as corrected"
        if is_curved(feature):
            what += f": its radius is {least_radius_mm(feature):.4f} mm, bent tighter than the nose by its correction"
        hint = "take a smaller nose, or look at the touches there and beside it: a bad one bends the contour most"
        raise Code.GEO_NOSE.refusal(what, hint=hint, values={"nose_radius_mm": nose_mm})


def _radius_left_mm(piece: CentrePiece) -> float:
    """Returns the least radius of a concave feature, less its displacement out of the material; else infinite."""
    feature = piece.shifted.feature
    s = np.linspace(0.0, feature.length_mm, SAMPLES)
    curvature = feature.curvature_per_mm(s)
    radius = np.divide(-1.0, curvature, out=np.full(SAMPLES, np.inf), where=curvature < 0.0)
    return float(np.min(radius - piece.shifted.shift.value_mm(s)))


def _cuts(piece: CentrePiece) -> bool:
    """Returns whether any of the feature itself is cut."""
    return max(piece.start_mm, 0.0) < min(piece.end_mm, piece.shifted.feature.length_mm)


def check_offset(offset_mm: tuple[float, float], limits: Limits) -> None:
    """Refuses a tool offset (x as a radius, z) that is too large along either axis."""
    for axis, value_mm in zip("XZ", offset_mm, strict=True):
        if abs(value_mm) > limits.correction_mm:
            raise Code.CMP_SIZE.refusal(
                wording(
                    "the tool offset on {axis} would be {size}{radius}; the limit is {limit}",
                    axis=axis,
                    size=Um(value_mm, "+.1f"),
                    radius=" (radius)" * (axis == "X"),
                    limit=Um(limits.correction_mm),
                ),
                hint="a constant this large is likelier a ball radius, an allowance, a datum or the tip that a program "
                "without G41 and G42 moves (`tool.tip`), which the job leaves out",
                override=allowed_by("correction_mm"),
                values={"size_um": abs(value_mm) * UM_PER_MM, "limit_um": limits.correction_mm * UM_PER_MM},
            )
