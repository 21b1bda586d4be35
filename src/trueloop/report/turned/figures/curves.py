"""The error curve of one feature: touches, fit, band, knots and end conditions; below it what the cut should leave."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.outcome import EARLIER_PARTS, Outcome, between_cuts_words, causes_um, outcomes
from trueloop.report import style
from trueloop.report.markup import esc, table
from trueloop.report.still import svg
from trueloop.report.style import Figure, Trace, plain
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.turned.error_curve.curve import ErrorCurve, coverage_factor
from trueloop.units import UM_PER_MM

SAMPLES: Final = 161
UPPER: Final = (0.42, 1.0)
LOWER: Final = (0.0, 0.3)
CLEAR_OF_ENDS: Final = 0.02


def error_curve(correction: Correction, index: int, width: int = 980, say: Texts = ENGLISH) -> Figure:
    """Feature `index` over its arc length from the chuck end, errors in µm, positive = material left on.

    Errors are those of the process: measured less what the semi-finish program commanded on purpose.
    Upper panel: touches with ±U, the fitted curve with its 95 % band, knots on the zero line, prescribed end values.
    Lower panel, scale of its own: predicted after the cut, and each touch predicted from the others.

    >>> job = trueloop.read_job(trueloop.example("modbas2/job.toml"))
    >>> dome = job.inputs.profile.names.index("dome")
    >>> figure = trueloop.error_curve(trueloop.compensate(job.inputs), dome)
    >>> figure["layout"]["xaxis"]["title"]["text"]
    'arc length from the chuck end (mm)'
    """
    curve = correction.model.curves[index]
    rows = correction.touches.of_feature(index)
    s = correction.touches.arc_length_mm[rows]
    along = np.linspace(0.0, curve.length_mm, SAMPLES)
    value, half_band = curve.value_mm(along) * UM_PER_MM, curve.half_band_mm(along) * UM_PER_MM
    touches = _touches(correction, rows, s, say)
    after = _after(correction, index, s, along, say)
    upper_seen = [*(value + half_band), *(value - half_band), *_reach(touches)]
    lower_seen = [y for trace in after for y in _reach(trace)]
    margin = CLEAR_OF_ENDS * curve.length_mm
    ends, notes = _end_conditions(curve, say)
    data = [_band(along, value, half_band, say), _fit(along, value, say), *_knots(curve, say), *ends, touches, *after]
    scale = say.per_mm, say.per_um
    drawn = {"data": [style.scaled(trace, *scale) for trace in data]}
    layout = style.layout(
        width,
        430,
        xaxis=style.axis(
            say("arc length from the chuck end ({mm})"),
            -margin * say.per_mm,
            (curve.length_mm + margin) * say.per_mm,
            width // 100,
        )
        | {"anchor": "y2", "zeroline": False},
        yaxis=style.axis(say("error ({um})"), *_range(upper_seen, say), 6, domain=list(UPPER)),
        yaxis2=style.axis(say("after ({um})"), *_range(lower_seen, say), 5, domain=list(LOWER)),
        annotations=[style.scaled(note, *scale) for note in notes],
        separators=say.separators,
    )
    return drawn | {"layout": layout}


def _range(seen_um: list[float], say: Texts) -> tuple[float, float]:
    low, high = style.padded(seen_um)
    return low * say.per_um, high * say.per_um


def _band(along: Array, value: Array, half_band: Array, say: Texts) -> Trace:
    both_ways = np.concatenate([along, along[::-1]]).tolist()
    outline = np.concatenate([value + half_band, (value - half_band)[::-1]]).tolist()
    return style.area(both_ways, outline, style.BAND, name=say("95 % band"))


def _fit(along: Array, value: Array, say: Texts) -> Trace:
    fit = style.lines(along.tolist(), value.tolist(), style.INK, 2, name=say("fitted curve"))
    hover = [
        say("fitted {error} {um} at {s} {mm}", error=say.error(e), s=say.mm(s, 2))
        for s, e in zip(along.tolist(), value.tolist(), strict=True)
    ]
    return fit | {"hoverinfo": "text", "hovertext": hover}


def _touches(correction: Correction, rows: Any, s: Array, say: Texts) -> Trace:
    """Filled circles, red and blue by sign, with ±U of gauging."""
    touches = correction.model.vectors
    error = touches.error_mm[rows] * UM_PER_MM
    k = coverage_factor()
    u = k * touches.standard_u_mm[rows] * UM_PER_MM
    hover = [
        say(
            "point {point}<br>error {error} ± {u} {um} (k = {k:.2f})",
            point=style.label(touches.point[i]),
            error=say.error(e),
            u=say.size(w),
            k=k,
        )
        for i, e, w in zip(rows, error, u, strict=True)
    ]
    colours = [style.colour_of(e) for e in error]
    return style.dots(s.tolist(), error.tolist(), hover, color=colours, size=8) | {
        "name": say("touches"),
        "error_y": {"type": "data", "array": u.tolist(), "color": style.INK, "thickness": 1.2, "width": 3},
    }


def _knots(curve: ErrorCurve, say: Texts) -> list[Trace]:
    """Triangles on the zero line."""
    knots = curve.knots_mm.tolist()
    hover = [say("knot at {s} {mm}", s=say.mm(s, 2)) for s in knots]
    traces = style.dots(knots, [0.0] * len(knots), hover, color=style.SOFT, symbol="triangle-up", size=9)
    return [traces | {"name": say("knots")}] if knots else []


def _end_conditions(curve: ErrorCurve, say: Texts) -> tuple[list[Trace], list[dict[str, Any]]]:
    """A square at each end of the feature whose value or slope was prescribed, with what was."""
    conditions, traces, notes = curve.conditions, [], []
    for s, value, slope, anchor in (
        (0.0, conditions.start_value_mm, conditions.start_slope, "left"),
        (curve.length_mm, conditions.end_value_mm, conditions.end_slope, "right"),
    ):
        if value is not None or slope is not None:
            words = _prescribed(value is not None, slope is not None, say)
            y = float(curve.value_mm(s)[0]) * UM_PER_MM
            traces.append(
                style.dots([s], [y], [words], color=style.INK, symbol="square-open", size=11)
                | {"name": say("end condition")}
            )
            gap = (0.03 if anchor == "left" else -0.03) * curve.length_mm
            notes.append(style.note(s + gap, y, words, xanchor=anchor))
    return traces, notes


def _prescribed(value: bool, slope: bool, say: Texts) -> str:
    if value and slope:
        return say("value and slope prescribed")
    return say("value prescribed") if value else say("slope prescribed")


def _after(correction: Correction, index: int, s: Array, along: Array, say: Texts) -> list[Trace]:
    """Lower panel: band of the next cut's error, what is left of each touch, and the same left out of the fit."""
    touches, prediction = correction.touches, correction.prediction
    rows = touches.of_feature(index)
    spread = correction.next_cut(index, along).expanded_u_mm * UM_PER_MM
    band = _band(along, np.zeros_like(along), spread, say) | {"name": say("next cut, ±U")}
    traces = [band | {"yaxis": "y2"}]
    for name, errors, marker in (
        (
            say("left out of the fit"),
            prediction.leave_one_out_mm,
            {"symbol": "diamond-open", "color": style.SOFT, "size": 9},
        ),
        (say("predicted after"), prediction.after_mm, {"symbol": "circle", "color": style.AFTER, "size": 7}),
    ):
        error = errors[rows] * UM_PER_MM
        known = np.isfinite(error)
        hover = [
            say("point {point}", point=style.label(touches.point[i])) + f"<br>{name} {say.error(e)} {say.um}"
            for i, e in zip(rows[known], error[known], strict=True)
        ]
        dots = style.dots(s[known].tolist(), error[known].tolist(), hover, **marker)
        traces.append(dots | {"name": name, "yaxis": "y2"})
    return traces


def _reach(trace: Trace) -> list[float]:
    spread = trace["error_y"]["array"] if "error_y" in trace else [0.0] * len(trace["y"])
    return [y + sign * u for y, u in zip(trace["y"], spread, strict=True) for sign in (-1, 1)]


@dataclass(frozen=True)
class CurvePicture:
    """The curve of the profile's `number`-th feature, from 0; `said`: what the picture shows, for who cannot see it."""

    number: int
    feature: str
    said: str


def curve_pictures(correction: Correction, say: Texts) -> Iterator[CurvePicture]:
    """Yields the features with a curve: one touch makes a constant, of which no picture shows more than its number."""
    for number, feature in enumerate(correction.profile.features):
        if len(correction.touches.of_feature(number)) > 1:
            yield CurvePicture(number, feature.name, _said(correction, number, say))


def curve_svg(correction: Correction, number: int, width: int, say: Texts) -> str:
    """Draws the picture of one of them."""
    return svg(error_curve(correction, number, width, say), style.label(_said(correction, number, say)))


def _said(correction: Correction, number: int, say: Texts) -> str:
    curve, rows = correction.model.curves[number], correction.touches.of_feature(number)
    along = np.linspace(0.0, curve.length_mm, SAMPLES)
    value, band = curve.value_mm(along) * UM_PER_MM, curve.half_band_mm(along) * UM_PER_MM
    left = np.abs(correction.prediction.after_mm[rows]) * UM_PER_MM
    return say(
        "Error curve of {feature}: {n} touches, fitted from {low} to {high} {um} (+ is material left on), 95 % band at "
        "most ± {band} {um}; predicted after the cut at most {left} {um}.",
        feature=correction.profile.features[number].name,
        n=len(rows),
        low=say.error(float(np.min(value))),
        high=say.error(float(np.max(value))),
        band=say.size(float(np.max(band))),
        left=say.size(float(np.nanmax(left))),
    )


def uncertainty(correction: Correction, say: Texts = ENGLISH) -> str:
    """Writes the budget of every feature, what its columns mean, and the source of the figures between cuts (HTML)."""
    headings = (
        say("feature"), say("probe"), say("curve"), say("process"), say("between cuts,<br>whole cut"),
        say("between cuts,<br>along the cut"), say("no touch"),
        *((say("earlier parts"),) if _by_memory(correction) else ()), say("U (95 %)"),
    )  # fmt: skip
    columns = say(
        "Standard uncertainties of the finished part's error in {um}, at the place of the feature where U is largest. "
        "Probe: its repeatability, in the fitted curve. Curve: the scatter of the touched cut, in the fitted curve. "
        "Process: the scatter of the finish cut by itself. Between cuts: what the finish cut does otherwise than the "
        "semi-finish cut, which the touches of one part cannot show. No touch: of an error that was estimated from "
        "other features."
    )
    if _by_memory(correction):
        columns += " " + say("Earlier parts: all of the next cut's error, its scatter included, where they tell it.")
    rows = [_row(correction, outcome, say) for outcome in outcomes(correction)]
    words = esc(say.note(between_cuts_words(correction.options.between_cuts)))
    return f"{table(headings, rows, words=(0,), name='budget', stacks=True)}<p>{words}</p><p class='note'>{columns}</p>"


def budget_words(correction: Correction) -> str:
    """Describes the largest of each cause over all features, as plain text."""
    causes = [causes_um(outcome.budget) for outcome in outcomes(correction)]
    named = {cause: None for one in causes for cause in one}
    largest = ", ".join(f"{cause} {plain(max(one.get(cause, 0.0) for one in causes))}" for cause in named)
    return f"Uncertainty budget, largest standard uncertainties in µm: {largest}."


def _by_memory(correction: Correction) -> bool:
    return any(curve.next_cut is not None for curve in correction.model.curves)


def _row(correction: Correction, outcome: Outcome, say: Texts) -> list[str]:
    found = causes_um(outcome.budget)
    if _by_memory(correction):
        found.setdefault(EARLIER_PARTS, 0.0)
    causes = [say.size(um) for um in found.values()]
    return [esc(correction.profile.names[outcome.index]), *causes, say.size(outcome.expanded_u_mm * UM_PER_MM)]
