"""The part that errors are drawn on: material, axis, feature names, scale bars; z right, x (radius) up, mm."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.feature import Feature, least_radius_mm
from trueloop.geometry.profile import Profile, Side
from trueloop.report import style
from trueloop.report.style import Trace
from trueloop.report.texts.texts import Texts
from trueloop.units import UM_PER_MM

CHARACTER_PX: Final = 7.5
"""Width of a character in the figures' type; capitals are wider, most letters narrower."""
LINE_PX: Final = 16
BESIDE_PX: Final = 12
DEEP_PX: Final = 32
"""How far a feature's name is from its line: beside a face, below other features."""


def outline_mm(profile: Profile) -> Array:
    """Returns the profile as a polyline, (n, 2) in (x, z)."""
    return np.concatenate([_points(feature) for feature in profile.features])


WALL: Final = 0.12
"""How thick the wall about a bore is drawn, of the largest radius: how thick it is does not follow from the bore."""


def material(outline: Array, side: Side) -> list[Trace]:
    """Draws the material, its mirrored half paler, outline and spindle axis. The bar goes on towards the chuck."""
    x, z = outline[:, 0].tolist(), outline[:, 1].tolist()
    beyond = 0.03 * (max(z) - min(z))
    closed_z, closed_x = _closed(x, z, side, beyond)
    mirrored = [-value for value in x]
    return [
        style.area(closed_z, closed_x, style.STEEL),
        style.area(closed_z, [-value for value in closed_x], style.PALE_STEEL),
        style.lines(z, x, style.SOFT, 1.2, name="nominal"),
        style.lines(z, mirrored, style.FAINT, 1.2),
        style.lines([min(z) - beyond, max(z) + beyond], [0, 0], style.SOFT, 1, line={"dash": "dashdot"}, name="axis"),
    ]


def _closed(x: list[float], z: list[float], side: Side, beyond: float) -> tuple[list[float], list[float]]:
    """The material's outline (z, x): down to the axis, or of a bore out to a wall."""
    if side is Side.AROUND:
        return z, x
    if side is Side.INSIDE:
        wall = (1.0 + WALL) * max(x)
        return [*z, z[-1] - beyond, z[-1] - beyond, z[0]], [*x, x[-1], wall, wall]
    return [z[0] - beyond, z[0] - beyond, *z, z[-1]], [0.0, x[0], *x, 0.0]


def with_wall_mm(outline: Array, side: Side) -> Array:
    """Returns the outline and how far the material about it is drawn, (n, 2)."""
    if side is not Side.INSIDE:
        return outline
    return np.concatenate([outline, [[(1.0 + WALL) * outline[:, 0].max(), outline[0, 1]]]])


def feature_names(
    profile: Profile, marked_mm: Sequence[Array], inward_mm: Sequence[float], mm_per_px: float
) -> list[dict[str, Any]]:
    """Places each feature's name inside the material, where the feature is long enough and no other name is.

    By feature: it stands between two of the marks on it, at these arc lengths, and deeper than they reach.
    """
    diagonal = diagonal_mm(profile)
    notes: list[dict[str, Any]] = []
    taken: list[Box] = []
    for i, feature in enumerate(profile.features):
        if feature.length_mm > 0.1 * diagonal:
            s = _widest_gap(marked_mm[i], feature.length_mm)
            faces_z = float(feature.outward_normal(s)[1]) > 0.9
            deep = BESIDE_PX * mm_per_px if faces_z else DEEP_PX * mm_per_px + inward_mm[i]
            at = feature.point_mm(s) - deep * feature.outward_normal(s)
            anchor = {"xanchor": "right" if faces_z else "center", "font": {"color": style.INK}}
            box = Box.of_text(feature.name, float(at[1]), float(at[0]), faces_z, mm_per_px)
            if box.bottom > 0.0 and not any(box.meets(other) for other in taken):
                taken.append(box)
                notes.append(style.note(float(at[1]), float(at[0]), style.label(feature.name), **anchor))
    return notes


@dataclass(frozen=True)
class Box:
    """The area of a text, in mm of the axes."""

    left: float
    right: float
    bottom: float
    top: float

    @classmethod
    def of_text(cls, text: str, z: float, x: float, ends_there: bool, mm_per_px: float) -> "Box":
        """Makes the box of a text about its middle, or to the left of its end."""
        width, height = CHARACTER_PX * len(text) * mm_per_px, LINE_PX * mm_per_px
        right = z if ends_there else z + width / 2
        return cls(right - width, right, x - height / 2, x + height / 2)

    def meets(self, other: "Box") -> bool:
        """Returns whether both cover some place."""
        apart = self.right < other.left or other.right < self.left or self.top < other.bottom or other.top < self.bottom
        return not apart


def _widest_gap(arc_length_mm: Array, length_mm: float) -> float:
    """Middle of the widest stretch between touches, the one nearest the feature's middle where several are as wide."""
    stops = np.array([0.0, *arc_length_mm, length_mm])
    middles, widths = (stops[1:] + stops[:-1]) / 2, np.diff(stops)
    wide = middles[widths > 0.95 * np.max(widths)]
    return float(wide[np.argmin(np.abs(wide - length_mm / 2))])


def diagonal_mm(profile: Profile) -> float:
    """Returns how large the part is, mm: from the axis to the largest radius, and from end to end."""
    ends = np.array([point for feature in profile.features for point in (feature.start_mm, feature.end_mm)])
    return float(np.hypot(np.max(ends[:, 0]), np.ptp(ends[:, 1])))


def round_down(value: float) -> float:
    """Returns the largest of 1, 2, 5 times a power of ten that does not exceed a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(m * power for m in (1.0, 2.0, 5.0) if m * power <= value * (1 + 1e-9))


@dataclass(frozen=True)
class Strip:
    """The free strip along the top of the picture, so many `lines` high, and its lowest line, in mm of the axes."""

    z_range: tuple[float, float]
    x_range: tuple[float, float]
    mm_per_px: float
    lines: int

    @property
    def left(self) -> float:
        """Returns the x at which words begin."""
        return self.z_range[0] + 12 * self.mm_per_px

    @property
    def right(self) -> float:
        """Returns the x at which bars end."""
        return self.z_range[1] - 12 * self.mm_per_px

    @property
    def bottom(self) -> float:
        """Returns the height of the line of words along the lower edge."""
        return self.x_range[0] + 16 * self.mm_per_px

    def line(self, number: int) -> float:
        """Returns the height of a line of words, counted from the top, 19 px apart."""
        return self.x_range[1] - (16 + 19 * number) * self.mm_per_px


LONGEST_BAR_PX: Final = 120
BARS_APART_PX: Final = 170


def times(magnified: float, say: Texts) -> str:
    """Formats a magnification, thousands apart."""
    return f"{magnified:,.0f}".replace(",", "\u202f") if magnified >= 1.0 else say.spelled(f"{magnified:g}")


def scale_bars(strip: Strip, magnified: float, say: Texts) -> tuple[list[Trace], list[dict[str, Any]]]:
    """Draws in the top strip a bar for the part in mm and one for the errors in µm."""
    longest_mm = LONGEST_BAR_PX * strip.mm_per_px
    part = round_down(longest_mm * say.per_mm)
    error = round_down(longest_mm / magnified * UM_PER_MM * say.per_um)
    above = strip.lines - 2
    at = strip.line(above + 1)
    bars, notes = [], []
    for right, length_mm, words in (
        (strip.right, part / say.per_mm, say("part {length} {mm}", length=say.spelled(f"{part:g}"))),
        (
            strip.right - BARS_APART_PX * strip.mm_per_px,
            error / say.per_um / UM_PER_MM * magnified,
            say("error {error} {um} (× {times})", error=say.spelled(f"{error:g}"), times=times(magnified, say)),
        ),
    ):
        bars.append(style.lines([right - length_mm, right], [at, at], style.INK, 3))
        notes.append(style.note(right, strip.line(above), words, xanchor="right", font={"color": style.INK}))
    return bars, notes


def _points(feature: Feature) -> Array:
    count = 2 + int(60 * feature.length_mm / least_radius_mm(feature))
    return feature.point_mm(np.linspace(0.0, feature.length_mm, count))
