"""Pages of tests: positioning after ISO 230-2 with its raw data, drift over time after ISO 230-3."""

from collections.abc import Mapping, Sequence
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.machine.drift import Drift, DriftTest
from trueloop.machine.standards import BothWays, Positioning
from trueloop.report.markup import esc, figure_block, html_page, section, table
from trueloop.report.style import (
    AFTER,
    BAND,
    INK,
    LEFT_ON,
    SOFT,
    TAKEN,
    Figure,
    apart,
    area,
    axis,
    dots,
    label,
    layout,
    lines,
    note,
    padded,
    plain,
)
from trueloop.units import UM_PER_MM

COLOURS: Final = (INK, AFTER, LEFT_ON, TAKEN, SOFT, "#b26a00", "#6a1b9a", "#5d4037", "#00838f", "#827717")
WIDTH: Final = 980
ARCSECONDS: Final = 3600 * 180 / np.pi


def values_of(test: Positioning) -> list[tuple[str, str, BothWays]]:
    """Returns symbol, meaning and value of what the standard requires, mm or rad; B and M stand for both ways alone."""
    nan = float("nan")
    return [
        ("A", "accuracy", test.accuracy),
        ("R", "repeatability", test.repeatability),
        ("E", "systematic deviation", test.systematic),
        ("B", "reversal value", BothWays(nan, nan, test.reversal)),
        ("B̄", "mean reversal value", BothWays(nan, nan, test.mean_reversal)),
        ("M", "range of the mean deviation", BothWays(nan, nan, test.mean_range)),
    ]


def scale_of(test: Positioning) -> tuple[float, str]:
    """Returns factor to, and name of, the unit in which deviations are printed: µm, or arcseconds."""
    return (ARCSECONDS, "″") if test.angular else (UM_PER_MM, "µm")


def positioning_page(name: str, test: Positioning) -> str:
    """Writes the page of the values of ISO 230-2 and every raw deviation."""
    scale, unit = scale_of(test)
    rows = [
        (f"{esc(symbol)} – {esc(meaning)}", *(plain(scale * v, 2) for v in (value.both, value.up, value.down)))
        for symbol, meaning, value in values_of(test)
        if not np.isnan([value.both, value.up, value.down]).all()
    ]
    targets, approaches = max(test.deviation_up.shape, test.deviation_down.shape)
    ways = "each way" if test.deviation_up.size and test.deviation_down.size else "from one side"
    head = (
        '<header><p class="kicker">trueloop · positioning after ISO 230-2</p>'
        f"<h1>{esc(name)}</h1><p class='meta'>{targets} targets, {approaches} approaches {ways}</p>"
        "<p class='note'>Deviation is actual minus target position; ↑ is approached from below, ↓ from above. Bands "
        "are the mean ± 2 s of the approaches.</p></header>"
    )
    drawn = section("plot", "Deviations", figure_block("positioning", positioning_figure(test), CAPTION))
    return html_page(
        f"{esc(name)} – ISO 230-2",
        head
        + drawn
        + section("values", "Values", table((f"value ({unit})", "both ways", "↑", "↓"), rows))
        + section("targets", "Targets", _targets(test, scale, unit)),
    )


CAPTION: Final = (
    "▲ approached from below, ▼ from above, with their means; dotted: the mean of both. Dashed: the limits between "
    "which the accuracy A lies."
)


def _targets(test: Positioning, scale: float, unit: str) -> str:
    at = np.degrees(test.target) if test.angular else test.target
    columns = (test.mean_up, test.spread_up, test.mean_down, test.spread_down, test.mean_up - test.mean_down)
    rows = [(plain(at[k], 4), *(plain(scale * float(c[k]), 2) for c in columns)) for k in range(len(at))]
    head = ("target (°)" if test.angular else "target (mm)", "mean ↑", "s ↑", "mean ↓", "s ↓", f"reversal ({unit})")
    return table(head, rows)


def positioning_figure(test: Positioning) -> Figure:
    """Draws every raw deviation, ▲ approached from below and ▼ from above, mean lines, ± 2 s bands, the limits of A."""
    scale, unit = scale_of(test)
    at = (np.degrees(test.target) if test.angular else test.target).tolist()
    traces, edges = [], []
    for deviation, mean, spread, symbol, colour in (
        (test.deviation_up, test.mean_up, test.spread_up, "triangle-up", INK),
        (test.deviation_down, test.mean_down, test.spread_down, "triangle-down", AFTER),
    ):
        if not deviation.size:
            continue
        upper, lower = (scale * (mean + k * spread) for k in (2.0, -2.0))
        edges += [*upper.tolist(), *lower.tolist()]
        traces.append(area([*at, *at[::-1]], [*upper.tolist(), *lower.tolist()[::-1]], BAND))
        traces.append(lines(at, (scale * mean).tolist(), colour))
        x = np.repeat(at, deviation.shape[1]).tolist()
        y = (scale * deviation).ravel().tolist()
        hover = [f"{plain(b, 2)} {unit} at {a:g}" for a, b in zip(x, y, strict=True)]
        traces.append(dots(x, y, hover, color=colour, symbol=symbol))
    if test.deviation_up.size and test.deviation_down.size:
        traces.append(lines(at, (0.5 * scale * (test.mean_up + test.mean_down)).tolist(), SOFT, line={"dash": "dot"}))
    span = 0.05 * (at[-1] - at[0])
    ends: list[float | None] = [at[0] - span, at[-1] + span]
    traces += [lines(ends, [limit, limit], LEFT_ON, 1, line={"dash": "dash"}) for limit in (min(edges), max(edges))]
    everything = scale * np.concatenate([test.deviation_up.ravel(), test.deviation_down.ravel()])
    low, high = padded([*everything.tolist(), *edges])
    shown = [
        (symbol, scale * next(one for one in (value.both, value.up, value.down) if not np.isnan(one)))
        for symbol, _, value in values_of(test)
        if symbol != "B̄" and not np.isnan([value.both, value.up, value.down]).all()
    ]
    words = " · ".join(f"{symbol} {plain(value, 2)}" for symbol, value in shown) + f" {unit}"
    axes = {
        "xaxis": axis("target position (°)" if test.angular else "target position (mm)", at[0] - span, at[-1] + span),
        "yaxis": axis(f"deviation ({unit})", low, high + 0.08 * (high - low)),
        "annotations": [note(0.5 * (at[0] + at[-1]), high + 0.03 * (high - low), words, font={"color": INK})],
    }
    return {"data": traces, "layout": layout(WIDTH, 460, **axes)}


def drift_page(name: str, test: DriftTest, drifts: Sequence[Drift]) -> str:
    """Displacements and temperatures over time, and the ranges of ISO 230-3."""
    every = max(1, len(test.time_s) // POINTS)
    moved = {channel: UM_PER_MM * (values - values[0]) for channel, values in test.displacement_mm.items()}
    panels = (("displacement (µm)", moved), ("temperature (°C)", test.temperature), ("speed (rev/min)", test.speed))
    figures = [
        figure_block(title.split()[0], drift_figure(test.time_s, channels, title, every), "")
        for title, channels in panels
        if channels
    ]
    head = (
        '<header><p class="kicker">trueloop · drift after ISO 230-3</p>'
        f"<h1>{esc(name)}</h1><p class='meta'>{len(test.time_s)} rows in "
        f"{(test.time_s[-1] - test.time_s[0]) / 3600:.1f} h; displacements from the start</p></header>"
    )
    names = ("channel", "range over all (µm)", f"largest within {drifts[0].window_s / 3600:g} h", "from (h)")
    rows = [
        (
            esc(d.channel),
            *(plain(v, 2) for v in (UM_PER_MM * d.total_range, UM_PER_MM * d.window_range, d.window_start_s / 3600)),
        )
        for d in drifts
    ]
    body = head + section("plots", "Over time", *figures) + section("ranges", "Ranges", table(names, rows))
    return html_page(f"{esc(name)} – ISO 230-3", body)


POINTS: Final = 1000
"""Rows drawn: more than a figure has pixels would not be seen."""


def drift_figure(time_s: Array, channels: Mapping[str, Array], title: str, every: int = 1) -> Figure:
    """Channels over time in hours, each in its colour and named at its end; every so many rows are drawn."""
    hours = time_s / 3600
    low, high = padded_around(np.concatenate(list(channels.values())))
    traces, notes = [], []
    places = apart({name: float(values[-1]) for name, values in channels.items()}, 0.045 * (high - low))
    for k, (name, values) in enumerate(channels.items()):
        colour = COLOURS[k % len(COLOURS)]
        traces.append(lines(hours[::every].tolist(), values[::every].tolist(), colour))
        notes.append(note(float(hours[-1]), places[name], f" {label(name)}", xanchor="left", font={"color": colour}))
    axes = {
        "xaxis": axis("time (h)", float(hours[0]), float(hours[0] + 1.08 * (hours[-1] - hours[0]))),
        "yaxis": axis(title, min(low, *places.values()), max(high, *places.values())),
        "annotations": notes,
    }
    return {"data": traces, "layout": layout(WIDTH, 420, **axes)}


def padded_around(values: Array) -> tuple[float, float]:
    """Returns the range of values, widened a little; zero need not be in it."""
    middle = 0.5 * float(values.min() + values.max())
    low, high = padded((values - middle).tolist(), share=0.05)
    return middle + low, middle + high
