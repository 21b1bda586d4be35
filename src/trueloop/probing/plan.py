"""Gauging points, equally spaced on each feature [6811 §5.3]."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.errors import Code, TrueloopError
from trueloop.geometry.profile import Profile

MARGIN_MM: Final = 2.54
"""Arc length between a feature's end and its first point: 0.1 in, as on the arcs of [6517 Table 1] and [6811 §5.3]."""


@dataclass(frozen=True)
class Spacing:
    """The number of points on a feature and their margins from its ends, in mm of arc length.

    A single point lies in the middle, or at `at_mm` from the feature's start.
    """

    count: int
    start_margin_mm: float = MARGIN_MM
    end_margin_mm: float = MARGIN_MM
    at_mm: float | None = None


@dataclass(frozen=True)
class GaugingPoints:
    """Points on a profile, ordered along it; shapes (n,) and, for the last two, (n, 2)."""

    feature_index: NDArray[np.intp]
    arc_length_mm: Array
    nominal_mm: Array
    outward_normal: Array


def equally_spaced(
    profile: Profile, spacings: Mapping[str, Spacing], reachable_mm: Array | None = None
) -> GaugingPoints:
    """Places points on the named features, the first and last at their margins and the others evenly between.

    Margins count from the features' ends, or, with `reachable_mm` (n, 2) of a `CentrePath`, from the ends of what the
    nose reaches. Raises TCH-PLAN for a feature that the profile does not have, for no points, and where the margins
    leave no room.
    """
    for name in spacings:
        if name not in profile.names:
            raise _refusal(
                f"{len(spacings)} features are to be touched, but the profile has no '{name}'",
                f"the profile's features: {', '.join(profile.names)}",
            )
    intervals = [(0.0, feature.length_mm) for feature in profile.features] if reachable_mm is None else reachable_mm
    placed = [
        (i, arc_length)
        for i, (name, (low, high)) in enumerate(zip(profile.names, intervals, strict=True))
        if name in spacings
        for arc_length in _along(name, spacings[name], float(low), float(high))
    ]
    return _points(profile, placed)


def _along(name: str, spacing: Spacing, low: float, high: float) -> Array:
    if spacing.count < 1:
        raise _refusal(f"'{name}' is to get {spacing.count} points", "leave out features that are not to be touched")
    first, last = low + spacing.start_margin_mm, high - spacing.end_margin_mm
    if spacing.count == 1:
        first = last = (low + high) / 2 if spacing.at_mm is None else spacing.at_mm
    inside = low <= first and last <= high and (first < last or spacing.count == 1)
    if not inside:
        raise _refusal(
            f"{spacing.count} points on '{name}' from {first:.3f} mm to {last:.3f} mm: it can be touched from "
            f"{low:.3f} mm to {high:.3f} mm",
            "give smaller margins, or one point in the middle",
        )
    return np.linspace(first, last, spacing.count)


def _points(profile: Profile, placed: list[tuple[int, float]]) -> GaugingPoints:
    features = [profile.features[i] for i, _ in placed]
    arc_length = [s for _, s in placed]
    nominal = [feature.point_mm(s) for feature, s in zip(features, arc_length, strict=True)]
    normal = [feature.outward_normal(s) for feature, s in zip(features, arc_length, strict=True)]
    return GaugingPoints(
        np.array([i for i, _ in placed], dtype=np.intp),
        np.array(arc_length),
        np.reshape(nominal, (-1, 2)),
        np.reshape(normal, (-1, 2)),
    )


def _refusal(message: str, hint: str) -> TrueloopError:
    return Code.TCH_PLAN.refusal(message, hint=hint)
