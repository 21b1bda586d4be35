"""The page that shows a run while it goes on, and its data ten times a second."""

import json
import math
from collections.abc import Sequence
from typing import Any, Final

import numpy as np

from trueloop.realtime.samples import ALARMING, Event, Samples
from trueloop.report.markup import esc, html_page, section, table
from trueloop.report.realtime.run import ALARM, AXIS_COLOURS, CAUSES, NS_PER_US, by_unit, signal_colour, trace_names
from trueloop.report.style import plain, signed

WINDOW_S: Final = 60.0
"""Shown of the trace."""
DECIMALS: Final = {"mm": 6, "um": 4}
ROWS: Final = {
    "command": ("command", "mm"),
    "drive": ("drive", "mm"),
    "model": ("asked for by the model", "um"),
    "table": ("asked for by the table", "um"),
    "correction": ("correction in force", "um"),
    "following_error": ("following error", "um"),
}
OTHER: Final = {
    "time": "time (s)",
    "line": "program line",
    "age": "oldest signal (s)",
    "write": "rtec.write, median (µs)",
    "thread": "servo thread, median / largest (µs)",
    "periods": "periods recorded / lost",
}


def live_page(title: str, axes: str, signals: Sequence[str]) -> str:
    """Writes the page; everything in it that changes has an id, which `told` fills."""
    rows = [
        (f"{words} ({'µm' if unit == 'um' else unit})", *(_cell(f"{what}_{axis}_{unit}") for axis in axes))
        for what, (words, unit) in ROWS.items()
    ]
    head = ("", *(f'<b style="color:{AXIS_COLOURS[axis]}">{axis.upper()}</b>' for axis in axes))
    of_signals = [
        (f'<b style="color:{signal_colour(signals, name)}">■ {esc(name)}</b>', _cell(name)) for name in signals
    ]
    body = (
        f'<header><p class="kicker">trueloop · real-time correction, live</p><h1>{esc(title)}</h1>'
        f'<p class="verdict" id="state">waiting for the first period</p>'
        f'<p class="meta" id="fault">no fault yet</p></header>'
        + section("now", "Now", table(head, rows, name="axes-table"), _signals(of_signals), _others())
        + section(
            "trace", f"The last {WINDOW_S:.0f} s", '<canvas id="live" width="1000" height="600"></canvas>', _key()
        )
        + f'<script type="application/json" id="panels">{_panels(axes, signals)}</script>'
    )
    return html_page(f"{esc(title)} – live", body, "realtime/live.js", connects=True)


def _cell(name: str) -> str:
    return f'<span id="{esc(name)}">–</span>'


def _signals(rows: Sequence[tuple[str, str]]) -> str:
    return "<h3>Signals in use</h3>" + table(("signal", "value"), rows, name="signals-table") if rows else ""


def _others() -> str:
    return "<h3>Program and times</h3>" + table(
        ("", ""), [(words, _cell(name)) for name, words in OTHER.items()], name="others-table"
    )


def _key() -> str:
    causes = {"model": "asked for by the model", "table": "by the table", "correction": "in force"}
    marks = ", ".join(f'<b style="color:{CAUSES[cause][0]}">■ {said}</b>' for cause, said in causes.items())
    alarm = f'<b style="color:{ALARM}">■ shaded</b>: a signal is bad, or a fault'
    return f'<p class="note">Correction: {marks}; {alarm}. Bands: least to largest value of each stretch.</p>'


def _panels(axes: str, signals: Sequence[str]) -> str:
    """The data that the script draws, in JSON that cannot end the element it stands in."""
    panels: list[dict[str, Any]] = [
        {"title": "command (mm)", "lines": [[f"command_{axis}_mm", AXIS_COLOURS[axis]] for axis in axes]}
    ]
    for axis in axes:
        of_axis = [[f"{cause}_{axis}_um", colour] for cause, (colour, _) in CAUSES.items()]
        panels.append({"title": f"{axis.upper()}: correction (µm)", "lines": of_axis, "zero": True})
    for unit, names in by_unit(signals).items():
        panels.append({"title": unit, "lines": [[name, signal_colour(signals, name)] for name in names]})
    content = {"panels": panels, "window_s": WINDOW_S, "alarm": ALARM}
    return json.dumps(content, ensure_ascii=False).replace("<", "\\u003c")


def told(samples: Samples, last: Event, fault: Event | None, periods: int, lost: int) -> dict[str, Any]:
    """Returns what the page gets of the newest periods: bands for the trace, and every text by its id."""
    drawn = {name: samples.columns[name] for name in trace_names(samples.axes, samples.signals)}
    low = {name: _plain(np.fmin.reduce(column)) for name, column in drawn.items()}
    high = {name: _plain(np.fmax.reduce(column)) for name, column in drawn.items()}
    return {
        "from": float(samples.time_s[0]),
        "to": float(samples.time_s[-1]) + samples.period_s,
        "low": low,
        "high": high,
        "alarm": bool(np.isin(samples.count("phase"), ALARMING).any()),
        "said": _texts(samples, last, fault) | {"periods": f"{periods} / {lost}"},
    }


def silence(for_s: float) -> dict[str, Any]:
    """Returns what the page gets while nothing comes."""
    return {"alarm": True, "said": {"state": f"no period has come for {for_s:.0f} s"}}


def _texts(samples: Samples, last: Event, fault: Event | None) -> dict[str, str]:
    """Values of the last period; times over all of them."""
    now = {name: float(column[-1]) for name, column in samples.columns.items()}
    texts = {
        f"{what}_{axis}_{unit}": signed(now[f"{what}_{axis}_{unit}"], DECIMALS[unit])
        for what, (_, unit) in ROWS.items()
        for axis in samples.axes
    }
    texts |= {name: plain(now[name], 4) for name in samples.signals}
    write, thread = (samples.columns[name] / NS_PER_US for name in ("write_ns", "thread_ns"))
    return texts | {
        "state": last.in_words(),
        "fault": f"last fault or bad signal at {fault.time_s:.3f} s: {fault.in_words()}" if fault else "no fault yet",
        "time": f"{now['time_s']:.3f}",
        "line": str(int(now["line"])),
        "age": plain(now["oldest_age_s"], 2),
        "write": plain(float(np.median(write)), 2),
        "thread": f"{plain(float(np.median(thread)), 2)} / {plain(float(thread.max()), 2)}",
    }


def _plain(value: float) -> float | None:
    """JSON has no word for NaN."""
    return float(value) if math.isfinite(value) else None
