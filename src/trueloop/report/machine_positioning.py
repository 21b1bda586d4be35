"""Figures of tests: raw deviations and bands after ISO 230-2, drift over time after ISO 230-3."""

import numpy as np

from trueloop.geometry.feature import Array
from trueloop.machine.positioning import Positioning
from trueloop.report.style import AFTER, BAND, INK, SOFT, Figure, area, axis, dots, layout, lines, note, padded

COLOURS = (INK, AFTER, "#c8102e", "#1558b0", SOFT, "#b26a00", "#6a1b9a")


def positioning_figure(test: Positioning) -> Figure:
    """Every raw deviation, ▲ approached from below and ▼ from above, mean lines and the ± 2 s bands, µm."""
    at = test.target.tolist()
    traces = []
    for deviation, mean, spread, symbol, colour in (
        (test.deviation_up, test.mean_up, test.spread_up, "triangle-up", INK),
        (test.deviation_down, test.mean_down, test.spread_down, "triangle-down", AFTER),
    ):
        edge = [*(1e3 * (mean + 2 * spread)).tolist(), *(1e3 * (mean - 2 * spread)).tolist()[::-1]]
        traces.append(area([*at, *at[::-1]], edge, BAND))
        traces.append(lines(at, (1e3 * mean).tolist(), colour))
        x = np.repeat(test.target, deviation.shape[1]).tolist()
        y = (1e3 * deviation).ravel().tolist()
        traces.append(
            dots(x, y, [f"{b:.2f} µm at {a:g}" for a, b in zip(x, y, strict=True)], color=colour, symbol=symbol)
        )
    everything = 1e3 * np.concatenate([test.deviation_up, test.deviation_down]).ravel()
    low, high = padded(everything.tolist())
    words = (
        f"A {1e3 * test.accuracy.both:.2f} · E {1e3 * test.systematic.both:.2f} · R {1e3 * test.repeatability.both:.2f}"
    )
    words += f" · B {1e3 * test.reversal:.2f} · M {1e3 * test.mean_range:.2f} µm"
    span = 0.05 * (at[-1] - at[0])
    axes = {
        "xaxis": axis("target position", at[0] - span, at[-1] + span),
        "yaxis": axis("deviation (µm)", low, high),
        "annotations": [note(0.5 * (at[0] + at[-1]), high, words, yanchor="top")],
    }
    return {"data": traces, "layout": layout(980, 420, **axes)}


def drift_figure(time_s: Array, channels: dict[str, Array], title: str = "drift (µm)") -> Figure:
    """Channels over time in hours, each in its colour and named at its end."""
    hours = time_s / 3600
    traces, notes = [], []
    for (name, values), colour in zip(channels.items(), COLOURS * (1 + len(channels) // len(COLOURS)), strict=False):
        traces.append(lines(hours.tolist(), values.tolist(), colour))
        notes.append(note(float(hours[-1]), float(values[-1]), name, xanchor="left", font={"color": colour}))
    low, high = padded(np.concatenate(list(channels.values())).tolist())
    axes = {
        "xaxis": axis("time (h)", float(hours[0]), float(hours[-1]) * 1.08),
        "yaxis": axis(title, low, high),
        "annotations": notes,
    }
    return {"data": traces, "layout": layout(980, 420, **axes)}
