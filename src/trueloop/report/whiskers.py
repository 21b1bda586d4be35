"""The part with its errors as whiskers: each error, magnified, along the outward normal where the part was touched.

z runs to the right and x, a radius, up, to equal scale. The half above the spindle axis shows the part as measured,
the mirrored half below it the part as predicted: one part, one scale, before and after.
"""

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from trueloop.geometry.feature import Arc, Array, Feature
from trueloop.geometry.profile import Profile
from trueloop.loops.process_intermittent import Correction
from trueloop.report import style
from trueloop.report.style import Figure, Trace
from trueloop.units import UM_PER_MM

COVERAGE: Final = 2.0
"""k: every ± and U in report and figures is k standard uncertainties, about 95 %."""

WIDTH: Final = 980
HEIGHT_WITHIN: Final = (360, 940)
LONGEST_SHARE: Final = 0.12
"""The longest whisker's part of the profile's diagonal, at most."""


@dataclass(frozen=True)
class Half:
    """Errors to be drawn on one half of the part: `side` 1 above the axis, −1 below; `u_mm` standard uncertainty."""

    heading: str
    error_mm: Array
    u_mm: Array
    side: int


def before_and_after(correction: Correction) -> Figure:
    """Above the axis the measured errors, below it the predicted ones, at the same magnification."""
    touches, prediction = correction.touches, correction.prediction
    halves = (
        Half("Before: measured", prediction.before_mm, touches.standard_u_mm, 1),
        Half("After: predicted", prediction.after_mm, prediction.standard_u_mm, -1),
    )
    return _figure(correction, halves, magnification(correction.profile, prediction.before_mm))


def after_enlarged(correction: Correction) -> Figure:
    """The predicted errors alone, at a magnification of their own, each with its expanded uncertainty."""
    prediction = correction.prediction
    half = Half("After: predicted, enlarged", prediction.after_mm, prediction.standard_u_mm, 1)
    expanded = np.abs(prediction.after_mm) + COVERAGE * prediction.standard_u_mm
    return _figure(correction, (half,), magnification(correction.profile, expanded), uncertainty=True)


def magnification(profile: Profile, error_mm: Array) -> float:
    """1, 2 or 5 times a power of ten, so that the longest whisker stays within its share of the diagonal."""
    longest = float(np.max(np.abs(error_mm), initial=0.0))
    if longest == 0.0:
        return 1.0
    return round_down(LONGEST_SHARE * _diagonal(profile) / longest)


def round_down(value: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that does not exceed a positive value."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(m * power for m in (1.0, 2.0, 5.0) if m * power <= value * (1 + 1e-9))


def _figure(correction: Correction, halves: tuple[Half, ...], magnified: float, uncertainty: bool = False) -> Figure:
    profile = correction.profile
    outline = np.concatenate([_points(feature) for feature in profile.features])
    traces = _part(outline)
    for half in halves:
        if uncertainty:
            traces += _uncertainty(correction, half, magnified)
        traces += _whiskers(correction, half, magnified, uncertainty)
    z_range, x_range = _ranges(outline, correction, halves, magnified)
    strip = Strip(z_range, x_range)
    notes = [*_names(profile), *_headings(halves, strip)]
    bars, bar_notes = _scale_bars(strip, magnified)
    height = WIDTH * (x_range[1] - x_range[0]) / (z_range[1] - z_range[0])
    layout = style.layout(
        WIDTH,
        round(min(max(height, HEIGHT_WITHIN[0]), HEIGHT_WITHIN[1])),
        xaxis=style.axis("z (mm)", *z_range, zeroline=False, constrain="domain"),
        yaxis=style.axis("x (mm, radius)", *x_range, zeroline=False, scaleanchor="x", scaleratio=1, constrain="domain"),
        annotations=[*notes, *bar_notes],
        meta={"magnification": magnified},
    )
    return {"data": [*traces, *bars], "layout": layout}


def _part(outline: Array) -> list[Trace]:
    """The material, its mirrored half paler, its outline, and the spindle axis."""
    x, z = outline[:, 0].tolist(), outline[:, 1].tolist()
    closed_z, closed_x = [z[0], *z, z[-1]], [0.0, *x, 0.0]
    mirrored = [-value for value in x]
    beyond = 0.03 * (max(z) - min(z))
    return [
        style.area(closed_z, closed_x, style.STEEL),
        style.area(closed_z, [-value for value in closed_x], style.PALE_STEEL),
        style.lines(z, x, style.SOFT, 1.2, name="nominal"),
        style.lines(z, mirrored, style.FAINT, 1.2),
        style.lines([min(z) - beyond, max(z) + beyond], [0, 0], style.SOFT, 1, line={"dash": "dashdot"}, name="axis"),
    ]


def tips_mm(correction: Correction, error_mm: Array, magnified: float) -> Array:
    """Where whiskers end, (n, 2) in (x, z): nominal point + magnification × error × outward normal."""
    touches = correction.touches
    return touches.nominal_mm + (magnified * error_mm)[:, None] * touches.outward_normal


def _whiskers(correction: Correction, half: Half, magnified: float, uncertainty: bool) -> list[Trace]:
    """Red whiskers out of the material, blue ones into it, a marker at each tip, and the points' names."""
    touches, error = correction.touches, half.error_mm
    mirror = np.array([half.side, 1.0])
    feet, tips = touches.nominal_mm * mirror, tips_mm(correction, error, magnified) * mirror
    hover = _hover(correction, half)
    traces: list[Trace] = []
    for name, colour, chosen in (
        ("material left on", style.LEFT_ON, error > 0),
        ("too much taken", style.TAKEN, error < 0),
        ("nominal", style.SOFT, error == 0),
    ):
        rows = np.flatnonzero(chosen)
        if len(rows):
            z, x = _segments(feet[rows], tips[rows])
            traces.append(style.lines(z, x, colour, 2.2, name=f"{name}, {half.heading}"))
            tip_z, tip_x = tips[rows, 1].tolist(), tips[rows, 0].tolist()
            traces.append(style.dots(tip_z, tip_x, [hover[i] for i in rows], color=colour, size=6, symbol="circle"))
    return [*traces, _point_names(correction, half, magnified, uncertainty)]


def _uncertainty(correction: Correction, half: Half, magnified: float) -> list[Trace]:
    """A wide pale whisker from error − U to error + U."""
    spread = COVERAGE * half.u_mm
    low, high = (tips_mm(correction, half.error_mm + sign * spread, magnified) for sign in (-1, 1))
    z, x = _segments(low, high)
    return [style.lines(z, x, style.FAINT, 6, opacity=0.6, name="±U")]


def _segments(start: Array, end: Array) -> tuple[list[float | None], list[float | None]]:
    """Separate strokes from start to end, (n, 2) each, as the coordinates (z, x) of one broken polyline."""
    z: list[float | None] = []
    x: list[float | None] = []
    for a, b in zip(start.tolist(), end.tolist(), strict=True):
        z += [a[1], b[1], None]
        x += [a[0], b[0], None]
    return z, x


def _hover(correction: Correction, half: Half) -> list[str]:
    touches, names = correction.touches, correction.profile.names
    return [
        f"{style.label(names[touches.feature_index[i]])}, point {style.label(touches.point[i])}<br>"
        f"{half.heading.split(':')[1].strip().split(',')[0]} {style.signed(half.error_mm[i] * UM_PER_MM)} "
        f"± {style.plain(COVERAGE * half.u_mm[i] * UM_PER_MM)} µm (k = {COVERAGE:g})<br>"
        f"x {style.plain(touches.nominal_mm[i, 0], 3)} mm, z {style.plain(touches.nominal_mm[i, 1], 3)} mm"
        for i in range(len(touches.point))
    ]


def _point_names(correction: Correction, half: Half, magnified: float, uncertainty: bool) -> Trace:
    """Names beside the whiskers, outside the material; where touches are crowded some are left out, never the worst."""
    touches = correction.touches
    gap = 0.022 * _diagonal(correction.profile)
    reach = half.error_mm + (COVERAGE * half.u_mm if uncertainty else 0.0)
    outward = np.maximum(reach * magnified, 0.0) + gap
    at = (touches.nominal_mm + outward[:, None] * touches.outward_normal) * np.array([half.side, 1.0])
    sizes = [half.error_mm, 0.0 * reach, reach]
    strokes = np.stack([tips_mm(correction, size, magnified) for size in sizes]) * np.array([half.side, 1.0])
    shown = _uncrowded(at, strokes, int(np.argmax(np.abs(half.error_mm))), gap)
    return {
        "type": "scatter",
        "mode": "text",
        "x": at[shown, 1].tolist(),
        "y": at[shown, 0].tolist(),
        "text": [style.label(touches.point[i]) for i in shown],
        "textfont": {"size": 10, "color": style.SOFT},
        "hoverinfo": "skip",
    }


def _uncrowded(at: Array, strokes: Array, always: int, gap: float) -> list[int]:
    """Those of the places (n, 2) that keep a gap from each other and off the strokes (m, n, 2) of other touches."""
    shown = [always]
    for i in range(len(at)):
        clear_of_names = np.all(np.linalg.norm(at[shown] - at[i], axis=1) > gap)
        others = np.delete(strokes, i, axis=1)
        if clear_of_names and np.all(np.linalg.norm(others - at[i], axis=2) > 0.6 * gap):
            shown.append(i)
    return sorted(shown)


def _points(feature: Feature) -> Array:
    count = 2 + int(60 * abs(feature.sweep_rad)) if isinstance(feature, Arc) else 2
    return feature.point_mm(np.linspace(0.0, feature.length_mm, count))


def _diagonal(profile: Profile) -> float:
    ends = np.array([point for feature in profile.features for point in (feature.start_mm, feature.end_mm)])
    return float(np.hypot(np.max(ends[:, 0]), np.ptp(ends[:, 1])))


def _ranges(
    outline: Array, correction: Correction, halves: tuple[Half, ...], magnified: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Axis ranges (z, x) that hold the part, all whiskers, and a strip for the scale bars at the top."""
    reach = [half.error_mm + (COVERAGE * half.u_mm if len(halves) == 1 else 0.0) for half in halves]
    seen = np.concatenate([outline, *(tips_mm(correction, error, magnified) for error in reach)])
    pad = 0.05 * _diagonal(correction.profile)
    top = float(np.max(seen[:, 0])) + 2.6 * pad
    bottom = -top + 1.2 * pad if len(halves) == 2 else -1.5 * pad
    return (float(np.min(seen[:, 1])) - pad, float(np.max(seen[:, 1])) + pad), (bottom, top)


def _names(profile: Profile) -> list[dict[str, Any]]:
    """Each feature's name inside the material, where the feature is long enough to carry one."""
    diagonal = _diagonal(profile)
    notes = []
    for feature in profile.features:
        middle = feature.length_mm / 2
        at = feature.point_mm(middle) - 0.06 * diagonal * feature.outward_normal(middle)
        if feature.length_mm > 0.1 * diagonal:
            notes.append(style.note(float(at[1]), float(at[0]), style.label(feature.name), font={"color": style.INK}))
    return notes


def _headings(halves: tuple[Half, ...], strip: "Strip") -> list[dict[str, Any]]:
    """What each half shows, and at the top what the colours mean."""
    notes = []
    for half in halves:
        at = strip.line(0) if half.side > 0 else strip.bottom
        heading = {"size": 14, "color": style.INK}
        notes.append(style.note(strip.left, at, f"<b>{half.heading}</b>", xanchor="left", font=heading))
    for k, (words, colour) in enumerate((("material left on", style.LEFT_ON), ("too much taken", style.TAKEN))):
        notes.append(style.note(strip.left, strip.line(k + 1), words, xanchor="left", font={"color": colour}))
    return notes


def _scale_bars(strip: "Strip", magnified: float) -> tuple[list[Trace], list[dict[str, Any]]]:
    """In the top strip: a bar for the part in mm and one for the errors in µm."""
    part_mm = round_down(0.12 * strip.width)
    error_um = round_down(0.12 * strip.width / magnified * UM_PER_MM)
    at = strip.line(1)
    bars, notes = [], []
    for right, length_mm, words in (
        (strip.right, part_mm, f"part {part_mm:g} mm"),
        (
            strip.right - 0.18 * strip.width,
            error_um / UM_PER_MM * magnified,
            f"error {error_um:g} µm (× {magnified:,.0f})",
        ),
    ):
        bars.append(style.lines([right - length_mm, right], [at, at], style.INK, 3))
        notes.append(style.note(right, strip.line(0), words, xanchor="right", font={"color": style.INK}))
    return bars, notes


@dataclass(frozen=True)
class Strip:
    """The free strip along the top of the picture and its lowest line, in mm of the axes; lines are 20 px apart."""

    z_range: tuple[float, float]
    x_range: tuple[float, float]

    @property
    def width(self) -> float:
        """Of the whole picture."""
        return self.z_range[1] - self.z_range[0]

    @property
    def left(self) -> float:
        """Where words begin."""
        return self.z_range[0] + 0.015 * self.width

    @property
    def right(self) -> float:
        """Where bars end."""
        return self.z_range[1] - 0.015 * self.width

    @property
    def bottom(self) -> float:
        """The line of words along the lower edge."""
        return self.x_range[0] + 0.02 * self.width

    def line(self, number: int) -> float:
        """Height of a line of words, counted from the top."""
        return self.x_range[1] - (0.02 + 0.022 * number) * self.width
