"""The error curve of one feature: touches, fit, band, knots and end conditions; below it what the cut should leave."""

from typing import Any, Final

import numpy as np

from trueloop.arrays import Array
from trueloop.loops.turned.correction import Correction
from trueloop.report import style
from trueloop.report.style import Figure, Trace
from trueloop.turned.error_curve.coverage import coverage_factor
from trueloop.turned.error_curve.curve import ErrorCurve
from trueloop.units import UM_PER_MM

SAMPLES: Final = 161
UPPER: Final = (0.42, 1.0)
LOWER: Final = (0.0, 0.3)
CLEAR_OF_ENDS: Final = 0.02


def error_curve(correction: Correction, index: int, width: int = 980) -> Figure:
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
    touches = _touches(correction, rows, s)
    after = _after(correction, index, s, along)
    upper_seen = [*(value + half_band), *(value - half_band), *_reach(touches)]
    lower_seen = [y for trace in after for y in _reach(trace)]
    margin = CLEAR_OF_ENDS * curve.length_mm
    ends, notes = _end_conditions(curve)
    layout = style.layout(
        width,
        430,
        xaxis=style.axis("arc length from the chuck end (mm)", -margin, curve.length_mm + margin, width // 100)
        | {"anchor": "y2", "zeroline": False},
        yaxis=style.axis("error (µm)", *style.padded(upper_seen), 6, domain=list(UPPER)),
        yaxis2=style.axis("after (µm)", *style.padded(lower_seen), 5, domain=list(LOWER)),
        annotations=notes,
    )
    data = [_band(along, value, half_band), _fit(along, value), *_knots(curve), *ends, touches, *after]
    return {"data": data, "layout": layout}


def _band(along: Array, value: Array, half_band: Array) -> Trace:
    both_ways = np.concatenate([along, along[::-1]]).tolist()
    outline = np.concatenate([value + half_band, (value - half_band)[::-1]]).tolist()
    return style.area(both_ways, outline, style.BAND, name="95 % band")


def _fit(along: Array, value: Array) -> Trace:
    fit = style.lines(along.tolist(), value.tolist(), style.INK, 2, name="fitted curve")
    hover = [f"fitted {style.signed(e)} µm at {style.plain(s, 2)} mm" for s, e in zip(along, value, strict=True)]
    return fit | {"hoverinfo": "text", "hovertext": hover}


def _touches(correction: Correction, rows: Any, s: Array) -> Trace:
    """Filled circles, red and blue by sign, with ±U of gauging."""
    touches = correction.model.vectors
    error = touches.error_mm[rows] * UM_PER_MM
    k = coverage_factor()
    u = k * touches.standard_u_mm[rows] * UM_PER_MM
    hover = [
        f"point {style.label(touches.point[i])}<br>error {style.signed(e)} ± {style.plain(w)} µm (k = {k:.2f})"
        for i, e, w in zip(rows, error, u, strict=True)
    ]
    colours = [style.colour_of(e) for e in error]
    return style.dots(s.tolist(), error.tolist(), hover, color=colours, size=8) | {
        "name": "touches",
        "error_y": {"type": "data", "array": u.tolist(), "color": style.INK, "thickness": 1.2, "width": 3},
    }


def _knots(curve: ErrorCurve) -> list[Trace]:
    """Triangles on the zero line."""
    knots = curve.knots_mm.tolist()
    hover = [f"knot at {style.plain(s, 2)} mm" for s in knots]
    traces = style.dots(knots, [0.0] * len(knots), hover, color=style.SOFT, symbol="triangle-up", size=9)
    return [traces | {"name": "knots"}] if knots else []


def _end_conditions(curve: ErrorCurve) -> tuple[list[Trace], list[dict[str, Any]]]:
    """A square at each end of the feature whose value or slope was prescribed, with what was."""
    conditions, traces, notes = curve.conditions, [], []
    for s, value, slope, anchor in (
        (0.0, conditions.start_value_mm, conditions.start_slope, "left"),
        (curve.length_mm, conditions.end_value_mm, conditions.end_slope, "right"),
    ):
        held = [name for name, number in (("value", value), ("slope", slope)) if number is not None]
        if held:
            words = f"{' and '.join(held)} prescribed"
            y = float(curve.value_mm(s)[0]) * UM_PER_MM
            traces.append(
                style.dots([s], [y], [words], color=style.INK, symbol="square-open", size=11)
                | {"name": "end condition"}
            )
            gap = (0.03 if anchor == "left" else -0.03) * curve.length_mm
            notes.append(style.note(s + gap, y, words, xanchor=anchor, font={"size": 11}))
    return traces, notes


def _after(correction: Correction, index: int, s: Array, along: Array) -> list[Trace]:
    """Lower panel: band of the next cut's error, what is left of each touch, and the same left out of the fit."""
    touches, prediction = correction.touches, correction.prediction
    rows = touches.of_feature(index)
    spread = correction.next_cut(index, along).expanded_u_mm * UM_PER_MM
    band = _band(along, np.zeros_like(along), spread) | {"name": "next cut, ±U"}
    traces = [band | {"yaxis": "y2"}]
    for name, errors, marker in (
        (
            "left out of the fit",
            prediction.leave_one_out_mm,
            {"symbol": "diamond-open", "color": style.SOFT, "size": 9},
        ),
        ("predicted after", prediction.after_mm, {"symbol": "circle", "color": style.AFTER, "size": 7}),
    ):
        error = errors[rows] * UM_PER_MM
        known = np.isfinite(error)
        hover = [
            f"point {style.label(touches.point[i])}<br>{name} {style.signed(e)} µm"
            for i, e in zip(rows[known], error[known], strict=True)
        ]
        dots = style.dots(s[known].tolist(), error[known].tolist(), hover, **marker)
        traces.append(dots | {"name": name, "yaxis": "y2"})
    return traces


def _reach(trace: Trace) -> list[float]:
    spread = trace["error_y"]["array"] if "error_y" in trace else [0.0] * len(trace["y"])
    return [y + sign * u for y, u in zip(trace["y"], spread, strict=True) for sign in (-1, 1)]
