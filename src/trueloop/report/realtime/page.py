"""The page of a run with the real-time corrector: finished parts, the run over time, faults, residual, times."""

from collections.abc import Iterable, Iterator
from typing import Any, Final

import numpy as np

from trueloop.arrays import Array, Integers
from trueloop.realtime.samples import Event
from trueloop.report import style
from trueloop.report.markup import esc, fields, figure_block, html_page, items, section, table
from trueloop.report.realtime.run import (
    ALARM,
    AXIS_COLOURS,
    CAUSES,
    NS_PER_US,
    WIDTHS,
    FinishedPart,
    Residual,
    RunPage,
    Timing,
    Trace,
    largest_um,
    signal_colour,
    trace_figures,
)
from trueloop.report.style import LEFT_ON, TAKEN, Figure, plain, signed

PANEL_PX: Final = 170
GAP_PX: Final = 26
MARGINS: Final = {"l": 68, "r": 16, "t": 24, "b": 52}
MOST: Final = 1500
"""Places of a part that are drawn: between them the largest and the least of each stretch."""


def parts_figure(parts: tuple[FinishedPart, ...], width: int) -> Figure:
    """Deviations, µm, over arc length."""
    ends = style.padded([float(value) for part in parts for value in part.deviation_um if np.isfinite(value)])
    start = min(float(part.along_mm.min()) for part in parts)
    end = max(float(part.along_mm.max()) for part in parts)
    whole = len(parts) * PANEL_PX + (len(parts) - 1) * GAP_PX
    height = MARGINS["t"] + MARGINS["b"] + whole
    axes: dict[str, Any] = {
        "xaxis": style.axis("arc length from the chuck end (mm)", start, end, 10 if width > 600 else 5)
    }
    data: list[dict[str, Any]] = []
    for k, part in enumerate(parts, 1):
        key = "" if k == 1 else str(k)
        top = whole - (k - 1) * (PANEL_PX + GAP_PX)
        domain = [0.0 if k == len(parts) else (top - PANEL_PX) / whole, top / whole]
        axes[f"yaxis{key}"] = style.axis(f"{style.label(part.name)} (µm)", *ends, 5) | {"domain": domain}
        data += _part(part, f"y{key}", end - start)
    return {"data": data, "layout": style.layout(width, height, margin=MARGINS, **axes)}


def _part(part: FinishedPart, panel: str, span_mm: float) -> list[dict[str, Any]]:
    """Returns the traces: areas above zero red, below it blue, and a line that shows the values."""
    order = np.argsort(part.along_mm, kind="stable")
    chosen = order[_telling(part.deviation_um[order])]
    along, deviation = part.along_mm[chosen], part.deviation_um[chosen]
    traces = []
    for run in _together(along, span_mm):
        x, y = _with_crossings(along[run], deviation[run])
        for colour, side in ((style.LEFT_ON, np.maximum), (style.TAKEN, np.minimum)):
            outline = [*side(y, 0.0).tolist(), 0.0, 0.0]
            filled = style.area([*x.tolist(), float(x[-1]), float(x[0])], outline, colour, yaxis=panel)
            traces.append(filled | {"opacity": 1})
        hover = [
            f"{style.label(part.name)}, {style.label(part.feature[i])}, {a:.2f} mm<br>{style.signed(d, 2)} µm"
            for i, a, d in zip(chosen[run], along[run], deviation[run], strict=True)
        ]
        line = style.lines([*along[run].tolist()], [*deviation[run].tolist()], style.INK, 0.7, yaxis=panel)
        traces.append(line | {"hovertext": hover, "hoverinfo": "text", "name": part.name})
    return traces


def _telling(values: Array) -> Integers:
    """Places to draw: all, or the least and the largest of each of many equal stretches, and both ends."""
    if len(values) <= MOST:
        return np.arange(len(values))
    kept = {0, len(values) - 1}
    for stretch in np.array_split(np.arange(len(values)), MOST // 2):
        kept |= {int(stretch[np.argmin(values[stretch])]), int(stretch[np.argmax(values[stretch])])}
    return np.array(sorted(kept))


def _together(along: Array, span_mm: float) -> list[slice]:
    """Runs without a gap of a twentieth of the profile or more, where nothing was measured."""
    breaks = (np.flatnonzero(np.diff(along) > span_mm / 20) + 1).tolist()
    return [slice(a, b) for a, b in zip([0, *breaks], [*breaks, len(along)], strict=True)]


def _with_crossings(x: Array, y: Array) -> tuple[Array, Array]:
    """With a place at every crossing of zero, so that both colours meet there."""
    k = np.flatnonzero(y[:-1] * y[1:] < 0)
    share = y[k] / (y[k] - y[k + 1])
    return np.insert(x, k + 1, x[k] + share * (x[k + 1] - x[k])), np.insert(y, k + 1, 0.0)


KICKER: Final = "trueloop · real-time correction"
MOST_EVENTS: Final = 200
SAID: Final = {"model": "asked for by the model", "table": "by the table", "correction": "in force"}


def run_page(run: RunPage) -> str:
    """Writes the page as HTML, all of it in one file."""
    verdict = f'<p class="verdict">{esc(run.verdict)}</p>' if run.verdict else ""
    head = f'<header><p class="kicker">{KICKER}</p><h1>{esc(run.title)}</h1>{verdict}</header>'
    return html_page(f"{esc(run.title)} – real-time correction", head + "".join(_sections(run)))


def _sections(run: RunPage) -> Iterator[str]:
    if run.parts:
        yield section("parts", "Finished parts", _parts_table(run.parts), _parts_figure(run.parts))
    if run.trace is not None:
        yield section("trace", "The run over time", _recorded(run.trace), _trace_figure(run.trace))
        yield section("events", "Faults and changes of state", _events(run.trace.events))
    if run.residuals:
        yield section("residual", "What was left, by the model", _residuals(run.residuals))
    if run.timings:
        yield section("times", "Times", _timings(run.timings, run.bare_ns))
    if run.conditions:
        yield section("conditions", "Conditions", fields((esc(k), esc(v)) for k, v in run.conditions.items()))
    if run.notes:
        yield section("notes", "Notes", items(map(esc, run.notes)))


def _parts_table(parts: tuple[FinishedPart, ...]) -> str:
    """A row a part, then a row for each of its features."""
    rows = []
    for part in parts:
        rows.append(_part_row(f"<b>{esc(part.name)}</b>", part.deviation_um))
        names = np.array(part.feature)
        rows += [
            _part_row(f"&emsp;{esc(name)}", part.deviation_um[names == name]) for name in dict.fromkeys(part.feature)
        ]
    head = ("part, feature", "places", "RMS<br>µm", "most left on<br>µm", "most taken<br>µm", "range<br>µm")
    return table(head, rows, name="parts-table")


def _part_row(name: str, deviation_um: Array) -> tuple[str, ...]:
    high, low = float(deviation_um.max()), float(deviation_um.min())
    root = float(np.sqrt(np.mean(deviation_um**2)))
    return (
        name,
        str(len(deviation_um)),
        plain(root, 2),
        signed(max(high, 0.0), 2),
        signed(min(low, 0.0), 2),
        plain(high - low, 2),
    )


def _parts_figure(parts: tuple[FinishedPart, ...]) -> str:
    caption = (
        f"Deviation along the normal, one scale for all parts: {_key(LEFT_ON, 'red')}: material left on, "
        f"{_key(TAKEN, 'blue')}: too much taken."
    )
    return figure_block("parts-figure", {kind: parts_figure(parts, width) for kind, width in WIDTHS.items()}, caption)


def _recorded(trace: Trace) -> str:
    lost = f"; {trace.lost} periods were not recorded" if trace.lost else ", none missing"
    largest = "".join(
        f" Largest correction in force along {axis}: {plain(value, 3)} µm."
        for axis, value in largest_um(trace, "correction").items()
    )
    return f"<p>{trace.periods} periods of {1e3 * trace.period_s:g} ms{lost}.{largest}</p>"


def _trace_figure(trace: Trace) -> str:
    axes = ", ".join(_key(AXIS_COLOURS[axis], axis.upper()) for axis in trace.axes)
    causes = ", ".join(_key(colour, SAID[cause]) for cause, (colour, _) in CAUSES.items())
    signals = ", ".join(_key(signal_colour(trace.signals, name), name) for name in trace.signals)
    caption = (
        f"Command: {axes}; x is a radius. Correction: {causes}."
        + (f" Signals in use: {signals}." if signals else "")
        + f" {_key(ALARM, 'Shaded')}: a signal is bad, or a fault. Each band reaches from the least to the largest "
        "value of its stretch of time: no period is hidden."
    )
    return figure_block("trace-figure", trace_figures(trace), caption)


def _events(events: tuple[Event, ...]) -> str:
    shown = _shortened(events)
    rows = [
        (
            f"{event.time_s:.3f}",
            str(event.line),
            f"<b>{esc(event.in_words())}</b>" if event.alarming else esc(event.in_words()),
        )
        for event in shown
    ]
    left_out = len(events) - len(shown)
    more = f"<p class='note'>{left_out} changes of state without a fault are left out here.</p>" if left_out else ""
    return table(("time<br>s", "program line", "state"), rows, words=(2,), name="events-table") + more


def _shortened(events: tuple[Event, ...]) -> list[Event]:
    """All of them, or the alarming ones of many; the last ones of very many."""
    if len(events) <= MOST_EVENTS:
        return list(events)
    return [event for event in events if event.alarming][-MOST_EVENTS:]


def _residuals(residuals: Iterable[Residual]) -> str:
    rows = [
        (
            esc(residual.name),
            plain(residual.uncorrected_um, 3),
            plain(residual.rms_nm, 2),
            plain(residual.worst_nm, 2),
            str(residual.periods),
            str(residual.left_out) + (f" ({esc(residual.why)})" if residual.left_out and residual.why else ""),
        )
        for residual in residuals
    ]
    head = ("run", "error to correct<br>µm RMS", "left<br>nm RMS", "largest<br>nm", "periods judged", "left out")
    return table(head, rows, name="residual-table", stacks=True)


def _timings(timings: Iterable[Timing], bare_ns: float | None) -> str:
    """In µs; the ratio is that of the medians."""
    rows = [
        (
            esc(timing.name),
            *(plain(value / NS_PER_US, 3) for value in (timing.median_ns, timing.p99_ns, timing.p999_ns)),
            *([plain(timing.median_ns / bare_ns, 2)] if bare_ns else []),
            str(timing.periods),
        )
        for timing in timings
    ]
    ratio = ["to the evaluator<br>alone"] if bare_ns else []
    head = ("what", "median<br>µs", "99 %<br>µs", "99.9 %<br>µs", *ratio, "times taken")
    alone = f"<p class='note'>The evaluator alone: {plain(bare_ns / NS_PER_US, 3)} µs (median).</p>" if bare_ns else ""
    return table(head, rows, name="times-table") + alone


def _key(colour: str, text: str) -> str:
    """A name in its colour."""
    return f'<b style="color:{colour}">■ {esc(text)}</b>'
