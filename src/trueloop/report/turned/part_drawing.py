"""The part that errors are drawn on: material, outline, spindle axis, names of features, scale bars.

z runs to the right and x, a radius, up; coordinates are mm.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.feature import Arc, Feature
from trueloop.geometry.profile import Profile
from trueloop.report import style
from trueloop.report.style import Trace
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.units import UM_PER_MM


def outline_mm(profile: Profile) -> Array:
    """The profile as a polyline, (n, 2) in (x, z)."""
    return np.concatenate([_points(feature) for feature in profile.features])


def material(outline: Array) -> list[Trace]:
    """The material, its mirrored half paler, its outline, and the spindle axis. The bar goes on towards the chuck."""
    x, z = outline[:, 0].tolist(), outline[:, 1].tolist()
    beyond = 0.03 * (max(z) - min(z))
    closed_z, closed_x = [z[0] - beyond, z[0] - beyond, *z, z[-1]], [0.0, x[0], *x, 0.0]
    mirrored = [-value for value in x]
    return [
        style.area(closed_z, closed_x, style.STEEL),
        style.area(closed_z, [-value for value in closed_x], style.PALE_STEEL),
        style.lines(z, x, style.SOFT, 1.2, name="nominal"),
        style.lines(z, mirrored, style.FAINT, 1.2),
        style.lines([min(z) - beyond, max(z) + beyond], [0, 0], style.SOFT, 1, line={"dash": "dashdot"}, name="axis"),
    ]


def feature_names(profile: Profile, touches: ErrorVectors, inward_mm: Array) -> list[dict[str, Any]]:
    """Each feature's name inside the material, where the feature is long enough to carry one.

    It stands between two touches, and deeper than their whiskers reach: `inward_mm` of shape (n,).
    """
    diagonal = diagonal_mm(profile)
    notes = []
    for i, feature in enumerate(profile.features):
        if feature.length_mm > 0.1 * diagonal:
            rows = touches.of_feature(i)
            s = _widest_gap(touches.arc_length_mm[rows], feature.length_mm)
            faces_z = float(feature.outward_normal(s)[1]) > 0.9
            deep = 0.015 * diagonal if faces_z else 0.04 * diagonal + float(np.max(inward_mm[rows], initial=0.0))
            at = feature.point_mm(s) - deep * feature.outward_normal(s)
            anchor = {"xanchor": "right" if faces_z else "center", "font": {"color": style.INK}}
            notes.append(style.note(float(at[1]), float(at[0]), style.label(feature.name), **anchor))
    return notes


def _widest_gap(arc_length_mm: Array, length_mm: float) -> float:
    """Middle of the widest stretch between touches, the one nearest the feature's middle where several are as wide."""
    stops = np.array([0.0, *arc_length_mm, length_mm])
    middles, widths = (stops[1:] + stops[:-1]) / 2, np.diff(stops)
    wide = middles[widths > 0.95 * np.max(widths)]
    return float(wide[np.argmin(np.abs(wide - length_mm / 2))])


def diagonal_mm(profile: Profile) -> float:
    """How large the part is: from the axis to the largest radius, and from end to end."""
    ends = np.array([point for feature in profile.features for point in (feature.start_mm, feature.end_mm)])
    return float(np.hypot(np.max(ends[:, 0]), np.ptp(ends[:, 1])))


def round_down(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that does not exceed a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(m * power for m in (1.0, 2.0, 5.0) if m * power <= value * (1 + 1e-9))


@dataclass(frozen=True)
class Strip:
    """The free strip along the top of the picture and its lowest line, in mm of the axes."""

    z_range: tuple[float, float]
    x_range: tuple[float, float]
    mm_per_px: float

    @property
    def left(self) -> float:
        """Where words begin."""
        return self.z_range[0] + 12 * self.mm_per_px

    @property
    def right(self) -> float:
        """Where bars end."""
        return self.z_range[1] - 12 * self.mm_per_px

    @property
    def bottom(self) -> float:
        """The line of words along the lower edge."""
        return self.x_range[0] + 16 * self.mm_per_px

    def line(self, number: int) -> float:
        """Height of a line of words, counted from the top, 19 px apart."""
        return self.x_range[1] - (16 + 19 * number) * self.mm_per_px


def scale_bars(strip: Strip, magnified: float) -> tuple[list[Trace], list[dict[str, Any]]]:
    """In the top strip: a bar for the part in mm and one for the errors in µm."""
    longest_mm = 120 * strip.mm_per_px
    part_mm, error_um = round_down(longest_mm), round_down(longest_mm / magnified * UM_PER_MM)
    at = strip.line(1)
    bars, notes = [], []
    for right, length_mm, words in (
        (strip.right, part_mm, f"part {part_mm:g} mm"),
        (
            strip.right - 170 * strip.mm_per_px,
            error_um / UM_PER_MM * magnified,
            f"error {error_um:g} µm (× {magnified:,.0f})",
        ),
    ):
        bars.append(style.lines([right - length_mm, right], [at, at], style.INK, 3))
        notes.append(style.note(right, strip.line(0), words, xanchor="right", font={"color": style.INK}))
    return bars, notes


def _points(feature: Feature) -> Array:
    count = 2 + int(60 * abs(feature.sweep_rad)) if isinstance(feature, Arc) else 2
    return feature.point_mm(np.linspace(0.0, feature.length_mm, count))
