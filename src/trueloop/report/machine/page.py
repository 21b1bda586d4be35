"""One page per machine model: what was found, how sure it is, what it left, how it predicts runs it has not seen."""

from collections.abc import Sequence

import numpy as np

from trueloop.machine.identify.form import Chosen
from trueloop.machine.identify.identify import Identification
from trueloop.machine.identify.judge_fit import HeldOut
from trueloop.machine.identify.observations import Observations
from trueloop.machine.model.history import Lag
from trueloop.machine.model.model import TermCurve, curves
from trueloop.report.markup import esc, figure_block, html_page, items, section, table
from trueloop.report.style import AFTER, BAND, INK, LEFT_ON, Figure, area, axis, dots, layout, lines, padded, plain
from trueloop.units import UM_PER_MM, URAD_PER_RAD

WIDTH = 480


def machine_page(
    found: Identification, chosen: Sequence[Chosen], readings: Observations, held: Sequence[HeldOut]
) -> str:
    """Writes the page of a model just identified, at the mean of each signal in the data; `readings` hold its lags."""
    model = found.model
    signals = {name: float(np.mean(readings.state.signals[name])) for name in model.needs()}
    drawn = curves(model, signals)
    figures = [
        figure_block(f"term-{c.error}", term_figure(c), _caption(c), small=True) for c in drawn if "0" not in c.error
    ]
    rows = [_row(curve) for curve in drawn]
    findings = items(f"{esc(f.code)}: {esc(f.message)} – {esc(f.hint)}" for f in found.findings)
    body = (
        '<header><p class="kicker">trueloop · model of a machine’s own errors</p>'
        f"<h1>{esc(model.machine.name)}</h1>"
        f"<p class='meta'>{len(model.terms)} error terms, {len(readings)} readings in {len(set(readings.run))} runs, "
        f"{found.degrees_of_freedom} degrees of freedom, scatter {found.scatter:.3g}</p>"
        "<p class='note'>An error is actual minus commanded, the tool as seen from the work; COMP_MTG is its negative."
        f"{_at(signals)}</p></header>"
        + section("terms", "Errors over the travel", table(("error", "least", "most", "largest u", "unit"), rows))
        + section("curves", "Curves", f'<div class="figures">{"".join(figures)}</div>')
        + _thermal(model.lags, chosen)
        + section(
            "left", "What the model leaves", figure_block("residuals", residual_figure(found, readings), RESIDUALS)
        )
        + section("held", "Runs predicted from the others", _held(held))
        + (section("findings", "Findings", findings) if found.findings else "")
    )
    return html_page(f"{esc(model.machine.name)} – machine model", body)


RESIDUALS = "Reading minus model in order of the readings; red: outliers that the robust fit counts less."


def term_figure(curve: TermCurve) -> Figure:
    """One error along its axis with its 95 % band; return travel dashed where it differs.

    >>> machine, form = trueloop.read_machine(trueloop.example("machine/machine.toml"))
    >>> readings = trueloop.read_readings(trueloop.example("machine/readings.csv"), machine.chain)
    >>> found, _ = trueloop.fit_form(machine, form, readings)
    >>> figure = trueloop.term_figure(trueloop.curves(found.model, {"T1": 25.0})[0])
    >>> figure["layout"]["yaxis"]["title"]["text"]
    'EXX (µm)'
    """
    turns = curve.error[2] in "ABC"
    at = (np.degrees(curve.position) if turns else curve.position).tolist()
    band = [*(curve.forward + 2 * curve.u).tolist(), *(curve.forward - 2 * curve.u).tolist()[::-1]]
    traces = [area([*at, *at[::-1]], band, BAND), lines(at, curve.forward.tolist(), INK)]
    if not np.allclose(curve.forward, curve.reverse):
        traces.append(lines(at, curve.reverse.tolist(), AFTER, line={"dash": "dash"}))
    low, high = padded([*band, *curve.reverse.tolist()])
    axes = {
        "xaxis": axis(f"{curve.error[2]} ({'°' if turns else 'mm'})", at[0], at[-1]),
        "yaxis": axis(f"{curve.error} ({curve.unit})", low, high),
    }
    return {"data": traces, "layout": layout(WIDTH, 300, **axes)}


def residual_figure(identification: Identification, readings: Observations) -> Figure:
    """Residuals in order, µm or µrad.

    >>> machine, form = trueloop.read_machine(trueloop.example("machine/machine.toml"))
    >>> readings = trueloop.read_readings(trueloop.example("machine/readings.csv"), machine.chain)
    >>> found, _ = trueloop.fit_form(machine, form, readings)
    >>> trueloop.residual_figure(found, readings)["layout"]["yaxis"]["title"]["text"]
    'µm or µrad'
    """
    values = np.where(readings.is_angle, URAD_PER_RAD, UM_PER_MM) * identification.residual
    order = np.arange(1, len(values) + 1)
    traces = []
    for rows, colour in ((~identification.outlier, INK), (identification.outlier, LEFT_ON)):
        hover = [f"{esc(readings.run[k])}, reading {k + 1}: {plain(float(values[k]), 2)}" for k in np.flatnonzero(rows)]
        traces.append(dots(order[rows].tolist(), values[rows].tolist(), hover, color=colour, size=4))
    low, high = padded(values.tolist())
    axes = {"xaxis": axis("reading", 0, len(values) + 1), "yaxis": axis("µm or µrad", low, high)}
    return {"data": traces, "layout": layout(2 * WIDTH, 300, **axes)}


def _row(curve: TermCurve) -> tuple[str, ...]:
    both = np.concatenate([curve.forward, curve.reverse])
    numbers = (float(both.min()), float(both.max()), float(curve.u.max()))
    return (curve.error, *(plain(number, 2) for number in numbers), curve.unit)


def _caption(curve: TermCurve) -> str:
    return f"<b>{esc(curve.error)}</b>"


def _thermal(lags: Sequence[Lag], chosen: Sequence[Chosen]) -> str:
    """Which sensors were chosen, and how fast what they drive follows them."""
    parts = []
    if chosen:
        rows = [(esc(c.error), esc(c.signal), plain(c.rms_without, 3), plain(c.rms_with, 3)) for c in chosen]
        parts.append(table(("error", "takes", "RMS left out without", "RMS with it"), rows))
    if lags:
        rows = [
            (esc(g.name), esc(g.of) + ("²" if g.power == 2 else ""), plain(g.constant_s, 0), _band(g)) for g in lags
        ]
        parts.append(table(("lag", "of", "time constant (s)", "95 % band ± (s)"), rows))
    return section("thermal", "Sensors and time constants", *parts) if parts else ""


def _band(lag: Lag) -> str:
    return plain(2 * lag.u_relative * lag.constant_s, 0) if lag.between_s else "given"


def _held(held: Sequence[HeldOut]) -> str:
    if not held:
        return "<p>All readings are of one run, or no run can be spared: nothing was held out.</p>"
    rows = [
        (esc(run.run), str(left.readings), *(plain(v, 2) for v in (left.raw, left.rms, left.largest)), unit)
        for run in held
        for unit, left in run.by_unit.items()
    ]
    return table(("run", "readings", "RMS before", "RMS after", "largest after", "unit"), rows)


def _at(signals: dict[str, float]) -> str:
    if not signals:
        return ""
    return " Curves are drawn at " + ", ".join(f"{esc(name)} = {value:.1f}" for name, value in signals.items()) + "."
