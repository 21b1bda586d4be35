"""The part with its errors as whiskers: each error, magnified, along the outward normal where the part was touched.

z runs to the right and x, a radius, up, to equal scale. The half above the spindle axis shows the part as measured,
the mirrored half below it the part as predicted: one part, one scale, before and after.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.profile import Profile
from trueloop.loops.turned.correction import Correction
from trueloop.report import style
from trueloop.report.style import Figure, Trace
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.report.turned.figures.part_drawing import (
    CHARACTER_PX,
    Box,
    Strip,
    diagonal_mm,
    feature_names,
    material,
    outline_mm,
    round_down,
    scale_bars,
    with_wall_mm,
)
from trueloop.turned.compensation.targets import Prediction
from trueloop.turned.error_curve.curve import coverage_factor
from trueloop.units import UM_PER_MM

WIDTH: Final = 980
NARROW: Final = 480
"""Width on a telephone."""
HIGHEST: Final = 0.96
"""The picture's height, at most, over its width."""
FRAME: Final = (80, 82)
"""Pixels of width and height that axes and margins take."""
LINE_PX: Final = 19
WIDE_LINES: Final = 2
"""Lines of words at the top; a narrow picture has the bars below them."""
NAME_GAP_PX: Final = 20
"""From a whisker to its point's name, and between names."""
LONGEST_SHARE: Final = 0.12
"""The longest whisker's part of the profile's diagonal, at most."""

LEAST_MM: Final = 1e-4
"""Errors below 0.1 µm are not blown up any further."""


@dataclass(frozen=True)
class Half:
    """Errors on one half of the part: `side` 1 above the axis, −1 below; ± `expanded_u_mm` (95 %); `label` in hover."""

    heading: str
    label: str
    error_mm: Array
    expanded_u_mm: Array
    side: int
    draws_u: bool = False

    @property
    def spread_mm(self) -> Array:
        """Returns the expanded uncertainty as far as it is drawn, mm."""
        return self.expanded_u_mm * self.draws_u


def before_and_after(correction: Correction, width: int = WIDTH, say: Texts = ENGLISH) -> Figure:
    """Above the axis the measured errors, below it the predicted ones, at the same magnification.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> figure = trueloop.before_and_after(trueloop.compensate(job.inputs))
    >>> figure["layout"]["meta"]["magnification"]
    200.0
    """
    touches, prediction = correction.touches, correction.prediction
    halves = (
        Half(
            say("Before: measured"), say("measured"), prediction.before_mm, coverage_factor() * touches.standard_u_mm, 1
        ),
        Half(say("After: predicted"), say("predicted"), *_predicted(prediction), -1),
    )
    return _figure(correction, halves, magnification(correction.profile, prediction.before_mm), width, say)


def after_enlarged(correction: Correction, width: int = WIDTH, say: Texts = ENGLISH) -> Figure:
    """The predicted errors alone, at a magnification of their own, each with its expanded uncertainty.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> enlarged = trueloop.after_enlarged(trueloop.compensate(job.inputs))
    >>> enlarged["layout"]["meta"]["magnification"]
    2000.0
    """
    prediction = correction.prediction
    heading = say("After: predicted, enlarged")
    half = Half(heading, say("predicted"), *_predicted(prediction), 1, draws_u=True)
    largest = magnification(correction.profile, np.abs(half.error_mm) + half.spread_mm)
    return _figure(correction, (half,), largest, width, say)


def _predicted(prediction: Prediction) -> tuple[Array, Array]:
    return prediction.after_mm, prediction.expanded_u_mm


def magnification(profile: Profile, error_mm: Array) -> float:
    """Returns 1, 2 or 5 times a power of ten, so that the longest whisker stays within its share of the diagonal."""
    longest = float(np.max(np.abs(error_mm), initial=LEAST_MM))
    return round_down(LONGEST_SHARE * diagonal_mm(profile) / longest)


def _figure(correction: Correction, halves: tuple[Half, ...], magnified: float, width: int, say: Texts) -> Figure:
    profile = correction.profile
    outline = outline_mm(profile)
    strip = _strip(with_wall_mm(outline, profile.side), correction, halves, magnified, width)
    traces = material(outline, profile.side)
    for half in halves:
        traces += [*_uncertainty(correction, half, magnified), *_whiskers(correction, half, magnified, strip, say)]
    inward_mm = magnified * np.maximum(halves[0].spread_mm - halves[0].error_mm, 0.0)
    rows = [correction.touches.of_feature(i) for i in range(len(profile.features))]
    marked_mm = [correction.touches.arc_length_mm[row] for row in rows]
    deepest_mm = [float(np.max(inward_mm[row], initial=0.0)) for row in rows]
    names = feature_names(profile, marked_mm, deepest_mm, strip.mm_per_px)
    bars, bar_notes = scale_bars(strip, magnified, say)
    z_axis = style.axis(say("z ({mm})"), *_in(say, strip.z_range), width // 110, zeroline=False, constrain="domain")
    x_axis = style.axis(say("x ({mm}, radius)"), *_in(say, strip.x_range), zeroline=False, constrain="domain")
    x_axis |= {"scaleanchor": "x", "scaleratio": 1, **_radii(x_axis, say)}
    layout = style.layout(
        width,
        FRAME[1] + round((strip.x_range[1] - strip.x_range[0]) / strip.mm_per_px),
        xaxis=z_axis,
        yaxis=x_axis,
        annotations=[
            style.scaled(note, say.per_mm, say.per_mm) for note in [*names, *_headings(halves, strip, say), *bar_notes]
        ],
        meta={"magnification": magnified},
        separators=say.separators,
    )
    return {"data": [style.scaled(trace, say.per_mm, say.per_mm) for trace in [*traces, *bars]], "layout": layout}


def _in(say: Texts, ends_mm: tuple[float, float]) -> tuple[float, float]:
    return ends_mm[0] * say.per_mm, ends_mm[1] * say.per_mm


def _radii(axis: dict[str, Any], say: Texts) -> dict[str, Any]:
    """A radius has no sign: below the spindle axis it counts downwards."""
    at = style.round_ticks(axis["range"], axis["dtick"])
    return {"tickvals": at, "ticktext": [say.spelled(style.tick(abs(value))) for value in at]}


def tips_mm(correction: Correction, error_mm: Array, magnified: float) -> Array:
    """Returns the ends of whiskers, (n, 2) in (x, z): nominal point + magnification × error × outward normal."""
    touches = correction.touches
    return touches.nominal_mm + (magnified * error_mm)[:, None] * touches.outward_normal


def _whiskers(correction: Correction, half: Half, magnified: float, strip: Strip, say: Texts) -> list[Trace]:
    """Red whiskers out of the material, blue ones into it, a marker at each tip, and the points' names."""
    touches, error = correction.touches, half.error_mm
    mirror = np.array([half.side, 1.0])
    feet, tips = touches.nominal_mm * mirror, tips_mm(correction, error, magnified) * mirror
    hover = _hover(correction, half, say)
    colours = np.array([style.colour_of(value) for value in error * UM_PER_MM])
    traces: list[Trace] = []
    for name, colour in (
        (say("material left on"), style.LEFT_ON),
        (say("too much taken"), style.TAKEN),
        (say("nominal"), style.SOFT),
    ):
        rows = np.flatnonzero(colours == colour)
        if len(rows):
            z, x = _segments(feet[rows], tips[rows])
            traces.append(style.lines(z, x, colour, 2.2, name=f"{name}, {half.heading}"))
            tip_z, tip_x = tips[rows, 1].tolist(), tips[rows, 0].tolist()
            traces.append(style.dots(tip_z, tip_x, [hover[i] for i in rows], color=colour, size=6, symbol="circle"))
    return [*traces, _point_names(correction, half, magnified, strip)]


def _uncertainty(correction: Correction, half: Half, magnified: float) -> list[Trace]:
    """A wide pale whisker from error − U to error + U."""
    if not half.draws_u:
        return []
    low, high = (tips_mm(correction, half.error_mm + sign * half.spread_mm, magnified) for sign in (-1, 1))
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


def _hover(correction: Correction, half: Half, say: Texts) -> list[str]:
    touches, names = correction.touches, correction.profile.names
    return [
        say(
            "{feature}, point {point}<br>{kind} {error} ± {u} {um} (95 %)<br>x {x} {mm}, z {z} {mm}",
            feature=style.label(names[touches.feature_index[i]]),
            point=style.label(touches.point[i]),
            kind=half.label,
            error=say.error(half.error_mm[i] * UM_PER_MM),
            u=say.size(half.expanded_u_mm[i] * UM_PER_MM),
            x=say.mm(touches.nominal_mm[i, 0]),
            z=say.mm(touches.nominal_mm[i, 1]),
        )
        for i in range(len(touches.point))
    ]


def _point_names(correction: Correction, half: Half, magnified: float, strip: Strip) -> Trace:
    """Names beside the whiskers, outside the material; where touches are crowded some are left out, never the worst."""
    touches = correction.touches
    gap = NAME_GAP_PX * strip.mm_per_px
    reach = half.error_mm + half.spread_mm
    outward = np.maximum(reach * magnified, 0.0) + gap
    at = (touches.nominal_mm + outward[:, None] * touches.outward_normal) * np.array([half.side, 1.0])
    sizes = [half.error_mm, 0.0 * reach, reach]
    strokes = np.stack([tips_mm(correction, size, magnified) for size in sizes]) * np.array([half.side, 1.0])
    boxes = [
        Box.of_text(name, z, x, False, strip.mm_per_px) for name, (x, z) in zip(touches.point, at.tolist(), strict=True)
    ]
    shown = _uncrowded(at, strokes, int(np.argmax(np.abs(half.error_mm))), gap, boxes)
    return {
        "type": "scatter",
        "mode": "text",
        "x": at[shown, 1].tolist(),
        "y": at[shown, 0].tolist(),
        "text": [style.label(touches.point[i]) for i in shown],
        "textfont": {"size": 10 if strip.lines == WIDE_LINES else 12, "color": style.SOFT},
        "hoverinfo": "skip",
    }


def _uncrowded(at: Array, strokes: Array, always: int, gap: float, boxes: Sequence[Box]) -> list[int]:
    """Those of the places (n, 2) that keep a gap, whose `boxes` do not meet, off the strokes (m, n, 2) of others."""
    shown = [always]
    for i in range(len(at)):
        clear_of_names = np.all(np.linalg.norm(at[shown] - at[i], axis=1) > gap)
        others = np.delete(strokes, i, axis=1)
        apart = not any(boxes[i].meets(boxes[k]) for k in shown)
        if apart and clear_of_names and np.all(np.linalg.norm(others - at[i], axis=2) > 0.6 * gap):
            shown.append(i)
    return sorted(shown)


def _strip(outline: Array, correction: Correction, halves: tuple[Half, ...], magnified: float, width: int) -> Strip:
    """The ranges (z, x) that hold the part, all whiskers with their names, and lines of words at the top; the scale.

    On a narrow picture the bars have lines of their own.
    """
    reach = [half.error_mm + half.spread_mm for half in halves]
    seen = np.concatenate([outline, *(tips_mm(correction, error, magnified) for error in reach)])
    low, high = float(np.min(seen[:, 1])), float(np.max(seen[:, 1]))
    plot_px, most_px, lines = width - FRAME[0], HIGHEST * width - FRAME[1], WIDE_LINES if width > NARROW else 4
    beside_px = 2.0 * NAME_GAP_PX
    top_px, bottom_px = 30.0 + NAME_GAP_PX + LINE_PX * lines, 36.0 if len(halves) == 2 else 10.0
    highest = float(np.max(np.abs(seen[:, 0])))
    span = highest * len(halves)
    mm_per_px = max((high - low) / (plot_px - 2 * beside_px), span / (most_px - top_px - bottom_px))
    beside = (plot_px * mm_per_px - (high - low)) / 2
    top, bottom = highest + top_px * mm_per_px, highest - span - bottom_px * mm_per_px
    return Strip((low - beside, high + beside), (bottom, top), mm_per_px, lines)


def _headings(halves: tuple[Half, ...], strip: Strip, say: Texts) -> list[dict[str, Any]]:
    """Labels each half, and explains the colours at the top."""
    notes = []
    for half in halves:
        at = strip.line(0) if half.side > 0 else strip.bottom
        heading = {"size": 14, "color": style.INK}
        notes.append(style.note(strip.left, at, f"<b>{half.heading}</b>", xanchor="left", font=heading))
    px = 0.0
    for words, colour in ((say("+ material left on"), style.LEFT_ON), (say("− too much taken"), style.TAKEN)):
        left = strip.left + px * strip.mm_per_px
        notes.append(style.note(left, strip.line(1), words, xanchor="left", font={"color": colour}))
        px += CHARACTER_PX * (len(words) + 1)
    return notes
