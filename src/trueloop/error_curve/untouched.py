"""What to expect of a feature that nobody touched.

The safest guess is what the same part of the nose did elsewhere: touches of other features at the same contact angle.
Where there are none, tool offsets dX·sin φ + dZ·cos φ fitted to the touched features serve between their contact
angles. Beyond those nothing is known, and the feature stays as programmed (error 0): a correction that no touch
supports could spoil a good feature, while material left on can still be cut. The uncertainty is large in every case:
features of one part were found to stand 13 µm and more off what the same nose did on others.
"""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.gauging.error_vectors import ErrorVectors
from trueloop.geometry.feature import Array, contact_angle_rad
from trueloop.statistics import rms
from trueloop.units import UM_PER_MM

SAME_ANGLE_RAD: Final = math.radians(3.0)
"""Contact angles closer than this use the same stretch of the nose: 0.04 mm of a 0.8 mm radius."""

BETWEEN_FEATURES_MM: Final = 0.016
"""How far the cones of [6811 Tables 8, 10] stand off what the same nose did on the domes, RMS over the ten parts (11
to 17 µm on nine, 30 µm on one whose taper looks falsified): the prior spread between features."""


def expect(vectors: ErrorVectors, angle_rad: float) -> tuple[float, float, str]:
    """Error (mm), its standard uncertainty (mm) and the reason, for a feature cut at a contact angle."""
    angles = contact_angle_rad(vectors.outward_normal)
    near = np.abs(angles - angle_rad) < SAME_ANGLE_RAD
    if np.any(near):
        return _from_same_angle(vectors, near)
    if np.min(angles) < angle_rad < np.max(angles):
        return _from_offsets(vectors, angles, angle_rad)
    u = max(rms(vectors.error_mm), BETWEEN_FEATURES_MM)
    return 0.0, u, f"nothing was touched at contact angles near {math.degrees(angle_rad):.0f}°: left as programmed"


def _from_same_angle(vectors: ErrorVectors, near: NDArray[np.bool_]) -> tuple[float, float, str]:
    """Mean over the touched features, and how far one more feature may stand off it (the prior spread counts once)."""
    features = np.unique(vectors.feature_index[near])
    means = np.array([np.mean(vectors.error_mm[near & (vectors.feature_index == f)]) for f in features])
    spread = math.sqrt((BETWEEN_FEATURES_MM**2 + float(np.sum((means - np.mean(means)) ** 2))) / len(means))
    mean = float(np.mean(means))
    points = ", ".join(np.array(vectors.point)[near])
    why = f"the mean of {mean * UM_PER_MM:.1f} µm at the same contact angle elsewhere (touches {points})"
    return mean, spread * math.sqrt(1.0 + 1.0 / len(means)), why


def _from_offsets(vectors: ErrorVectors, angles: Array, angle_rad: float) -> tuple[float, float, str]:
    """Tool offsets by least squares over all touches."""
    design = np.column_stack([np.sin(angles), np.cos(angles)])
    offsets = np.linalg.lstsq(design, vectors.error_mm, rcond=None)[0]
    misfit = rms(vectors.error_mm - design @ offsets)
    value = float(offsets @ [math.sin(angle_rad), math.cos(angle_rad)])
    dx_um, dz_um = offsets * UM_PER_MM
    why = f"the tool offsets that fit the touches best (dX {dx_um:.1f} µm, dZ {dz_um:.1f} µm)"
    return value, math.hypot(misfit, BETWEEN_FEATURES_MM), why
