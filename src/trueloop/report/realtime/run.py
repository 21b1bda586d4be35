"""The content of a page of a run. All of it but the title may be missing.

The page that shows a run while it goes on, and its data ten times a second.

A recorded run over time, one panel below the other: commands, correction by cause for each axis, signals, faults.

Every trace is a band from the least to the largest value of a stretch of time, so that no single period is hidden.
"""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array, by_content
from trueloop.realtime.samples import ALARMING, NONE, Envelope, Event, Samples, Tally, counted, envelope, events, merged
from trueloop.report import style
from trueloop.report.markup import esc, html_page, section, table
from trueloop.report.style import Figure, plain, signed
from trueloop.statistics import rms
from trueloop.units import SIGNALS

NS_PER_US = 1e3


@by_content
@dataclass(frozen=True)
class FinishedPart:
    """One part as measured: deviations along the normal, µm, positive where material is left on.

    `along_mm` (n,): arc length along the whole profile from the chuck end. `feature`: the name at each place.
    """

    name: str
    along_mm: Array
    deviation_um: Array
    feature: tuple[str, ...]

    @property
    def rms_um(self) -> float:
        """Returns the root mean square of all places."""
        return rms(self.deviation_um)


@dataclass(frozen=True)
class Timing:
    """How long something takes, ns: half of all periods, 99 % and 99.9 % of them take no longer."""

    name: str
    periods: int
    median_ns: float
    p99_ns: float
    p999_ns: float


def timing_of(name: str, each_ns: Array | Tally) -> Timing:
    """Computes the timing from the time of each period, or from how often each came."""
    tally = each_ns if isinstance(each_ns, Tally) else counted(NONE, each_ns)
    return Timing(name, tally.total, *(tally.quantile(share) for share in (0.5, 0.99, 0.999)))


@dataclass(frozen=True)
class Residual:
    """Errors that a run left, by a model that does not know the corrector.

    `uncorrected_um`: root mean square of the error that there was to correct. `periods`: how many were judged;
    `left_out` and `why`: those that were not.
    """

    name: str
    periods: int
    rms_nm: float
    worst_nm: float
    uncorrected_um: float
    left_out: int = 0
    why: str = ""


@by_content
@dataclass(frozen=True)
class Trace:
    """A recorded run as a page draws it. `lost`: periods that were not recorded."""

    axes: str
    signals: tuple[str, ...]
    envelope: Envelope
    events: tuple[Event, ...]
    periods: int
    lost: int
    period_s: float


def trace_names(axes: str, signals: Sequence[str]) -> tuple[str, ...]:
    """Columns that a trace draws."""
    drawn = [f"{what}_{axis}_{unit}" for what, unit in DRAWN for axis in axes]
    return (*drawn, *signals, "oldest_age_s")


DRAWN = (("command", "mm"), ("model", "um"), ("table", "um"), ("correction", "um"), ("following_error", "um"))


def trace_of(samples: Samples) -> Trace:
    """Makes the trace of a whole record."""
    drawn = envelope(samples, trace_names(samples.axes, samples.signals))
    found = tuple(events(samples))
    return Trace(
        axes=samples.axes,
        signals=samples.signals,
        envelope=drawn,
        events=found,
        periods=len(samples),
        lost=samples.lost,
        period_s=samples.period_s,
    )


@dataclass(frozen=True)
class RunPage:
    """A page. `verdict`: one sentence on what it shows. `conditions`: names with their values, as plain text.

    `parts`: the finished parts in the order to be shown, the one without the corrector first. `bare_ns`: median of the
    evaluator alone, which the timings are compared with. `notes`: what else a reader must know, a sentence each.
    """

    title: str
    verdict: str = ""
    conditions: Mapping[str, str] = field(default_factory=dict)
    parts: tuple[FinishedPart, ...] = ()
    trace: Trace | None = None
    residuals: tuple[Residual, ...] = ()
    timings: tuple[Timing, ...] = ()
    bare_ns: float | None = None
    notes: tuple[str, ...] = ()


def largest_um(trace: Trace, what: str) -> dict[str, float]:
    """Returns the largest amount of a column by axis, µm, as `correction`: {"X": 42.1}; zero without a record."""
    columns = {axis.upper(): np.concatenate(trace.envelope.of(f"{what}_{axis}_um")) for axis in trace.axes}
    return {axis: float(np.nanmax(np.abs(values), initial=0.0)) for axis, values in columns.items()}


AXIS_COLOURS: Final = {"x": "#0072b2", "y": "#9a3c7d", "z": "#b26a00"}
CAUSES: Final = {"model": ("#0072b2", 3.0), "table": ("#e69f00", 2.4), "correction": (style.INK, 1.2)}
"""Colour and width of line by cause: what is in force is drawn last, over what was asked for."""
SIGNAL_COLOURS: Final = ("#b2182b", "#1b7837", "#542788", "#8c510a", "#2166ac", "#4d4d4d")
ALARM: Final = "#d55e00"
PANEL_PX: Final = 150
GAP_PX: Final = 22
MARGINS: Final = {"l": 68, "r": 16, "t": 24, "b": 52}
STRETCHES: Final = {"wide": 900, "narrow": 300}
WIDTHS: Final = {"wide": 980, "narrow": 370}


def trace_figures(trace: Trace) -> dict[str, Figure]:
    """Draws the trace for a wide window and for a narrow one."""
    return {kind: trace_figure(trace, WIDTHS[kind], STRETCHES[kind]) for kind in WIDTHS}


def trace_figure(trace: Trace, width: int, stretches: int) -> Figure:
    """Draws the whole run in a picture of this width in px."""
    drawn = merged(trace.envelope, stretches)
    panels = [
        ("command (mm)", [(f"command_{axis}_mm", AXIS_COLOURS[axis], 1.4) for axis in trace.axes]),
        *(
            (f"{axis.upper()}: correction (µm)", [(f"{cause}_{axis}_um", *CAUSES[cause]) for cause in CAUSES])
            for axis in trace.axes
        ),
        *(
            (unit, [(name, signal_colour(trace.signals, name), 1.4) for name in names])
            for unit, names in by_unit(trace.signals).items()
        ),
    ]
    end = drawn.low.shape[1] * drawn.step_s
    heights = _domains(len(panels))
    height = MARGINS["t"] + MARGINS["b"] + len(panels) * PANEL_PX + (len(panels) - 1) * GAP_PX
    axes: dict[str, Any] = {"xaxis": style.axis("time (s)", 0.0, end, 10 if width > 600 else 5)}
    data: list[dict[str, Any]] = []
    for k, (title, columns) in enumerate(panels, 1):
        key = "" if k == 1 else str(k)
        ends = _range(drawn, [name for name, *_ in columns], with_zero="correction" in title)
        axes[f"yaxis{key}"] = style.axis(title, *ends, 6) | {"domain": list(heights[k - 1])}
        data += [_alarm(span, ends, f"y{key}") for span in alarms(trace, end)]
        data += [_band(drawn, name, colour, line, f"y{key}") for name, colour, line in columns]
    return {"data": data, "layout": style.layout(width, height, margin=MARGINS, **axes)}


def by_unit(signals: Sequence[str]) -> dict[str, list[str]]:
    """Signals of one unit share a panel."""
    found: dict[str, list[str]] = {}
    for name in signals:
        unit = next((f"signals ({said})" for suffix, said in SIGNALS.items() if name.endswith(suffix)), "signals")
        found.setdefault(unit, []).append(name)
    return found


def signal_colour(signals: Sequence[str], name: str) -> str:
    """Returns the colour of a signal, by its place among all."""
    return SIGNAL_COLOURS[signals.index(name) % len(SIGNAL_COLOURS)]


def alarms(trace: Trace, end_s: float) -> list[tuple[float, float, str]]:
    """Returns when something was wrong: from, to, and what."""
    following = [*(event.time_s for event in trace.events[1:]), end_s]
    return [
        (event.time_s, until, event.in_words())
        for event, until in zip(trace.events, following, strict=True)
        if event.alarming
    ]


def _domains(count: int) -> list[tuple[float, float]]:
    """Shares of the plotting area, from its top."""
    whole = count * PANEL_PX + (count - 1) * GAP_PX
    tops = [whole - k * (PANEL_PX + GAP_PX) for k in range(count)]
    return [(0.0 if top == PANEL_PX else (top - PANEL_PX) / whole, top / whole) for top in tops]


def _range(drawn: Envelope, names: Sequence[str], with_zero: bool) -> tuple[float, float]:
    values = np.concatenate([np.concatenate(drawn.of(name)) for name in names])
    values = values[np.isfinite(values)]
    if with_zero or not len(values):
        return style.padded(values.tolist(), 0.08, 0.1)
    low, high = float(values.min()), float(values.max())
    pad = 0.08 * max(high - low, 0.1)
    return low - pad, high + pad


def _band(drawn: Envelope, name: str, colour: str, line: float, panel: str) -> dict[str, Any]:
    """A closed outline for each run of stretches that were recorded."""
    low, high = drawn.of(name)
    x: list[float | None] = []
    y: list[float | None] = []
    for run in _runs(np.isfinite(low)):
        time, least, most = drawn.time_s[run], low[run], high[run]
        x += [*time.tolist(), *time[::-1].tolist(), None]
        y += [*most.tolist(), *least[::-1].tolist(), None]
    return style.lines(x, y, colour, line, fill="toself", fillcolor=colour, yaxis=panel, name=name)


def _alarm(span: tuple[float, float, str], ends: tuple[float, float], panel: str) -> dict[str, Any]:
    """A rectangle over the time in which something was wrong, which says what."""
    start, end, said = span
    x, y = [start, start, end, end], [ends[0], ends[1], ends[1], ends[0]]
    hover = [f"{start:.3f} s: {style.label(said)}"] * 4
    area = style.lines([*x], [*y], ALARM, 0.8, fill="toself", fillcolor="rgba(213,94,0,0.14)", yaxis=panel)
    return area | {"hovertext": hover, "hoverinfo": "text"}


def _runs(good: Array) -> list[slice]:
    """The unbroken runs of true values."""
    ends = np.flatnonzero(np.diff(np.concatenate([[False], good, [False]]).astype(int)))
    return [slice(int(a), int(b)) for a, b in zip(ends[::2], ends[1::2], strict=True)]


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
    """Writes the page; what changes in it has an id, for which `told` returns the text."""
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
