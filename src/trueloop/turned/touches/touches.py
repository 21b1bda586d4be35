"""Touches to error vectors: what the probe reported, as part errors along the nominal normal.

`e = n · (measured − nominal) − ball radius − allowance`, positive = material left on [6876 glossary, PARTERROR]. A
touch that was not exactly along n keeps its normal component only. The part's z is taken from a reference point
[6811 §5.1].
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.inspection import Touch
from trueloop.domain.option import Option
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.profile import Profile
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.plausibility import (
    check_ball_side,
    check_order,
    check_positions,
    check_scale,
    check_sizes,
    check_stated_sign,
)
from trueloop.units import UM_PER_MM

REFERENCE_FACES: Final = 0.5
"""A z reference must look along z: |n_z| of at least cos 60°, or its error would be divided by a small number."""


@dataclass(frozen=True)
class Gauging:
    """The conditions of the touches. Ranges are those of repeated probing, along x and along z [6811 §4.1].

    >>> trueloop.Gauging(ball_radius_mm=1.5).range_x_mm
    0.0015
    """

    ball_radius_mm: Annotated[
        float,
        Option(
            "gauging.ball_radius_mm", "Radius of the probe's ball, where measured points are ball centres.", least=0
        ),
    ] = 0.0
    allowance_mm: Annotated[
        float,
        Option(
            "gauging.measured_allowance_mm",
            "What the cut was to leave on, where measured points are of the oversize surface.",
        ),
    ] = 0.0
    range_x_mm: Annotated[
        float,
        Option(
            "gauging.repeatability_diameter_um",
            "Range of repeated touches along x. The standard uncertainty is the range by √12.",
            least=0,
        ),
    ] = 1.5 / UM_PER_MM
    range_z_mm: Annotated[float, Option("gauging.repeatability_face_um", "The same along z.", least=0)] = (
        0.5 / UM_PER_MM
    )
    readings_u_mm: Annotated[
        float,
        Option(
            "gauging.readings_u_um",
            "Standard uncertainty of readings that state none, of a diameter on the diameter: a workshop micrometer "
            "in good order and a part within some kelvin of 20 °C.",
            above=0,
        ),
    ] = 2.0 / UM_PER_MM
    z_reference: Annotated[
        str | None,
        Option(
            "gauging.z_reference",
            "The point, on a face, from which the part's z is taken: its error is zero by definition. Left out, z is "
            "as reported.",
        ),
    ] = None


def standard_uncertainty_mm(outward_normal: Array, gauging: Gauging) -> Array:
    """Returns the type B uncertainty of an error along n: u = R/√12 on each axis [6811 §5.1], projected on n. (n, 2) →
    (n,).

    The ranges of 1.5 µm and 0.5 µm give 0.43 µm on a cylinder and 0.14 µm on a face. Valid while repeatability is
    all that matters: temperature and geometry of the machine are left out, as in the report.
    """
    u_x, u_z = gauging.range_x_mm / math.sqrt(12), gauging.range_z_mm / math.sqrt(12)
    normal = np.atleast_2d(outward_normal)
    return np.hypot(normal[:, 0] * u_x, normal[:, 1] * u_z)


def in_order(profile: Profile, touches: Sequence[Touch]) -> list[Touch]:
    """Touches in their order along the profile: each on the feature that it names, else on the nearest."""

    def along_mm(touch: Touch) -> float:
        nearest = int(profile.locate(np.array([touch.nominal_mm])).feature_index[0])
        index = profile.names.index(touch.feature) if touch.feature in profile.names else nearest
        return profile.start_of(index) + float(profile.features[index].locate(touch.nominal_mm)[0])

    return sorted(touches, key=along_mm)


def error_vectors(profile: Profile, touches: Sequence[Touch], gauging: Gauging) -> ErrorVectors:
    """Returns part errors of the touches, ordered along the profile. Raises TCH errors for implausible touches.

    >>> profile = trueloop.read_part(trueloop.example("modbas2/job.toml")).profile
    >>> touches = trueloop.read_touches(trueloop.example("modbas2/touches.csv"))
    >>> errors = trueloop.error_vectors(profile, touches, trueloop.Gauging(z_reference="11"))
    >>> print(errors.error_mm[:2], errors.outward_normal[0].round(3))  # along the outward normal (x, z)
    [0.090297 0.09271 ] [0.875 0.484]
    """
    feature_index, arc_length = _place(profile, touches)
    normal = np.array([profile.features[i].outward_normal(s) for i, s in zip(feature_index, arc_length, strict=True)])
    nominal = np.array([touch.nominal_mm for touch in touches])
    vectors = ErrorVectors(
        point=tuple(touch.point for touch in touches),
        feature_index=feature_index,
        arc_length_mm=arc_length,
        error_mm=_part_error(touches, nominal, normal, gauging),
        standard_u_mm=standard_uncertainty_mm(normal, gauging),
        at_reference=np.zeros(len(touches), dtype=np.bool_),
        nominal_mm=nominal,
        outward_normal=normal,
    )
    check_scale(touches, vectors.error_mm, vectors.standard_u_mm)
    check_order(profile, vectors, [touch.line for touch in touches])
    return vectors if gauging.z_reference is None else _from_reference(vectors, gauging.z_reference)


def _place(profile: Profile, touches: Sequence[Touch]) -> tuple[np.ndarray[tuple[int], np.dtype[np.intp]], Array]:
    """Returns feature and arc length of each touch: on the feature it names, else on the nearest."""
    if not touches:
        raise Code.TCH_FILE.refusal(
            "there are 0 touches", hint="one row a touch: feature, point, nominal, measured or error"
        )
    check_positions(profile, touches)
    names = profile.names
    nearest = profile.locate(np.array([touch.nominal_mm for touch in touches]))
    index = np.array(
        [
            nearest.feature_index[k] if touch.feature is None else names.index(touch.feature)
            for k, touch in enumerate(touches)
        ],
        dtype=np.intp,
    )
    arc_length = [
        float(profile.features[i].locate(touch.nominal_mm)[0]) for i, touch in zip(index, touches, strict=True)
    ]
    return index, np.array(arc_length)


def _part_error(touches: Sequence[Touch], nominal: Array, normal: Array, gauging: Gauging) -> Array:
    """Returns the stated errors, or n · (measured − nominal) less the ball and the intended allowance."""
    given = np.array([np.nan if touch.error_mm is None else touch.error_mm for touch in touches])
    measured = np.array([(np.nan, np.nan) if t.measured_mm is None else t.measured_mm for t in touches])
    along_normal = np.einsum("ij,ij->i", normal, measured - nominal)
    found = along_normal - gauging.ball_radius_mm - gauging.allowance_mm
    check_stated_sign(touches, given, found)
    error = np.where(np.isnan(given), found, given)
    check_ball_side(touches, error, gauging.ball_radius_mm)
    expected = nominal + (gauging.ball_radius_mm + gauging.allowance_mm) * normal
    check_sizes(touches, error, measured, expected, normal)
    return error


def no_reference(point: str, touches: int) -> TrueloopError:
    """Returns the error for a z reference that was not touched."""
    return Code.TCH_REFERENCE.refusal(
        f"the z reference {point!r} is not one of the {touches} touches",
        hint="`gauging.z_reference` names a point as it stands in the touches' column `point`; readings need none: "
        "they count from a face of their own",
        values={"point": point},
    )


def _from_reference(vectors: ErrorVectors, point: str) -> ErrorVectors:
    """Shifts the part frame along z so that the error at the reference point is zero [6811 §5.1]."""
    if point not in vectors.point:
        raise no_reference(point, len(vectors.point))
    k = vectors.point.index(point)
    facing = float(vectors.outward_normal[k, 1])
    if abs(facing) < REFERENCE_FACES:
        raise Code.TCH_REFERENCE.refusal(
            f"the z reference {point!r} faces x: its normal is ({vectors.outward_normal[k, 0]:.3f}, {facing:.3f})",
            hint="take z from a point on a face",
            values={"point": point},
        )
    share = vectors.outward_normal[:, 1] / facing
    u_shared = np.hypot(vectors.standard_u_mm, np.abs(share) * vectors.standard_u_mm[k])
    at_reference = np.arange(len(vectors.point)) == k
    return replace(
        vectors,
        error_mm=np.where(at_reference, 0.0, vectors.error_mm - share * vectors.error_mm[k]),
        standard_u_mm=np.where(at_reference, vectors.standard_u_mm, u_shared),
        at_reference=at_reference,
    )
