"""Figures of a replay: root mean squares part by part, and one part place by place."""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from studies.replay.replay import Replayed
from trueloop.report import style
from trueloop.report.style import Figure
from trueloop.units import UM_PER_MM

COLOURS: Final = (style.SOFT, style.TAKEN, style.AFTER, "#b26a00", "#6a1b9a")
SYMBOLS: Final = ("circle-open", "diamond-open", "circle", "square", "triangle-up")
SIGNS: Final = ("○", "◇", "●", "■", "▲")
"""Colours, marks and their signs, by series: as cut, own fit, memory."""
SMALL: Final = 480
HALF_RANGE_UM: Final = 16.0
"""Errors beyond it widen a figure's own range; otherwise all parts have one scale."""


def key(names: Sequence[str]) -> str:
    """Which mark is which series, as HTML."""
    marks = (f'<b style="color:{colour}">{sign}</b>' for colour, sign in zip(COLOURS, SIGNS, strict=True))
    return ", ".join(f"{mark} {style.label(name)}" for mark, name in zip(marks, names, strict=False))


def parts_figure(serials: Sequence[str], series: Mapping[str, Sequence[float]], width: int) -> Figure:
    """Root mean squares, µm, over the parts in cutting order; a line a series, named beside its last part."""
    x = [float(k) for k in range(len(serials))]
    data, ends = [], {}
    for k, (name, values) in enumerate(series.items()):
        said = style.label(name)
        hover = [
            f"{style.label(serial)}<br>{said} {style.plain(value, 2)} µm"
            for serial, value in zip(serials, values, strict=True)
        ]
        data.append(style.lines([*x], [*values], COLOURS[k % 5], 1.2))
        data.append(style.dots(x, list(values), hover, color=COLOURS[k % 5], symbol=SYMBOLS[k % 5], size=8))
        ends[name] = values[-1]
    top = style.padded([value for values in series.values() for value in values])[1]
    beside = 1.0 if width < SMALL else 0.18
    every = 2 if width < SMALL else 1
    right = x[-1] + (0.5 if width < SMALL else 0.2 * len(serials))
    height = 330
    notes = [] if width < SMALL else _names(ends, x[-1] + beside, top / 15)
    return {
        "data": data,
        "layout": style.layout(
            width,
            height,
            xaxis=style.axis("part", -0.5, right)
            | {"tickvals": x[::every], "ticktext": [style.label(s) for s in serials[::every]]},
            yaxis=style.axis("RMS (µm)", 0.0, top, 6),
            annotations=notes,
        ),
    }


def _names(ends: Mapping[str, float], x: float, least: float) -> list[dict[str, object]]:
    places = style.apart(dict(ends), least)
    return [
        style.note(x, places[name], style.label(name), xanchor="left", font={"color": COLOURS[k % 5]})
        for k, name in enumerate(ends)
    ]


def places_figure(fit: Replayed, memory: Replayed, name: str) -> Figure:
    """One part over contact angle, µm: as cut, what its own fit would have left, and what memory would have."""
    finish = memory.part.finish
    assert finish is not None
    order = np.argsort(finish.contact_angle_rad)
    angle = np.degrees(finish.contact_angle_rad)[order]
    band = memory.predicted.half_band_mm[order] * UM_PER_MM
    shown = {"as cut": finish.error_mm, "own fit": fit.left_mm, name: memory.left_mm}
    if memory.own_fit:
        shown.pop("own fit", None)
        shown[name] = memory.left_mm
    outline = np.concatenate([band, -band[::-1]]).tolist()
    data = [style.area(np.concatenate([angle, angle[::-1]]).tolist(), outline, style.BAND, name="95 % band")]
    for k, (what, error_mm) in enumerate(shown.items()):
        error = (error_mm[order] * UM_PER_MM).tolist()
        hover = [
            f"point {style.label(finish.point[i])}, {a:.1f}°<br>{style.label(what)} {style.signed(e)} µm"
            for i, a, e in zip(order, angle, error, strict=True)
        ]
        mark = COLOURS.index(style.AFTER) if what == name else k
        data.append(style.dots(angle.tolist(), error, hover, color=COLOURS[mark], symbol=SYMBOLS[mark], size=7))
    low, high = style.padded([*band, *-band, *(e * UM_PER_MM for errors in shown.values() for e in errors)])
    return {
        "data": data,
        "layout": style.layout(
            SMALL,
            270,
            xaxis=style.axis("contact angle (°)", float(angle[0]) - 3.0, float(angle[-1]) + 3.0, 6),
            yaxis=style.axis("error (µm)", min(low, -HALF_RANGE_UM), max(high, HALF_RANGE_UM), 6),
        ),
    }
