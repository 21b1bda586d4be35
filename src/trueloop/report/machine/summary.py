"""Models of a machine, of its drift and of drilled plates, in lines for people and as JSON."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, astuple
from math import degrees, isnan

from trueloop.diagnosis.components import Components, FrameDiscrepancy
from trueloop.machine.drift import DriftModel, DriftRun, DriftTest
from trueloop.machine.identify.form import Chosen
from trueloop.machine.identify.identify import Identification
from trueloop.machine.identify.judge_fit import HeldOut
from trueloop.machine.model.history import Lag
from trueloop.machine.standards import JudgedPattern, Positioning
from trueloop.report.diagnosis.figures import surface_figures
from trueloop.report.diagnosis.values import point_shape
from trueloop.report.machine.positioning import POINTS, drift_figure, scale_of, values_of
from trueloop.report.markup import esc, figure_block, html_page, section, table
from trueloop.report.style import plain, signed
from trueloop.units import UM_PER_MM, URAD_PER_RAD

FIGURES = 12
"""Points that get a figure of their own, those of the largest ERROR_PP first."""


def components_page(points: tuple[str, ...], parts: Components, frame: FrameDiscrepancy | None) -> str:
    """Writes all points as a table, and the diagram of the points that are furthest off."""
    columns = (
        "error_pp",
        "error_mtg",
        "error_mtg_resid",
        "error_proc",
        "error_proc_resid",
        "u_error_mtg",
        "u_error_proc",
    )
    rows = [(esc(point), *(_cell(parts, name, k) for name in columns)) for k, point in enumerate(points)]
    furthest = sorted(range(len(points)), key=lambda k: -abs(float(parts.error_pp[k])))[:FIGURES]
    figures = [
        figure_block(f"point-{k}", surface_figures(point_shape(points[k], parts, k)), f"<b>{esc(points[k])}</b>")
        for k in furthest
    ]
    body = (
        '<header><p class="kicker">trueloop · error components at gauging points</p><h1>Machine, process, and the rest'
        "</h1><p class='note'>µm along the outward normal, + is material left on; u are standard uncertainties.</p>"
        f"{_frame(frame)}</header>"
        + section("table", "Components", table(("point", *columns), rows))
        + section("diagrams", "Surface/error diagrams", *figures)
    )
    return html_page("Error components", body)


def _cell(parts: Components, name: str, k: int) -> str:
    """µm; an uncertainty has no sign."""
    value = UM_PER_MM * float(getattr(parts, name)[k])
    return plain(value, 2) if name.startswith("u_") else signed(value, 2)


def _frame(frame: FrameDiscrepancy | None) -> str:
    if frame is None:
        return ""
    shift = ", ".join(signed(UM_PER_MM * float(v), 1) for v in frame.shift_mm)
    turn = ", ".join(signed(URAD_PER_RAD * float(v), 0) for v in frame.turn_rad)
    return (
        f"<p>Part coordinate system discrepancy taken out: shift ({shift}) µm, turn ({turn}) µrad; differences along "
        f"the normals {UM_PER_MM * frame.rms_before_mm:.1f} → {UM_PER_MM * frame.rms_after_mm:.1f} µm RMS.</p>"
    )


CAPTION = "The whole log as read, and the rows that were held out as predicted from those before them."


def drift_model_page(name: str, test: DriftTest, models: Mapping[str, DriftModel], runs: Sequence[DriftRun]) -> str:
    """Writes the page of what each model takes and leaves, and its channel over time."""
    head = (
        '<header><p class="kicker">trueloop · drift model</p>'
        f"<h1>{esc(name)}</h1><p class='meta'>{len(test.time_s)} rows in "
        f"{(test.time_s[-1] - test.time_s[0]) / 3600:.1f} h, the last {len(runs[0].predicted_um)} held out</p></header>"
    )
    columns = ("channel", "moved (µm RMS)", "left", "left without the past", "inputs and their mean time constants (s)")
    rows = [
        (
            esc(run.channel),
            plain(run.raw_um, 2),
            plain(run.rms_um, 2),
            plain(run.static_rms_um, 2),
            _inputs(models[run.channel]),
        )
        for run in runs
    ]
    figures = [figure_block(f"channel {run.channel}", _figure(test, run), CAPTION) for run in runs]
    body = head + section("left", "Rows held out", table(columns, rows)) + section("plots", "Over time", *figures)
    return html_page(f"{esc(name)} – drift model", body)


def _inputs(model: DriftModel) -> str:
    return ", ".join(f"{esc(name)} {constant:.0f}" for name, constant in model.mean_constant_s.items())


def _figure(test: DriftTest, run: DriftRun) -> dict[str, object]:
    moved = UM_PER_MM * test.displacement_mm[run.channel]
    held = len(run.predicted_um)
    both = moved.copy()
    both[-held:] = run.predicted_um
    channels = {"read": moved, "predicted": both}
    return drift_figure(test.time_s, channels, f"{run.channel} (µm)", max(1, len(moved) // POINTS))


def fit_summary(
    found: Identification, chosen: Sequence[Chosen], held: Sequence[HeldOut], readings: int
) -> dict[str, object]:
    """Summarizes a model identified from so many readings."""
    return {
        "scatter": found.scatter,
        "lack_of_fit": found.lack_of_fit,
        "readings": readings,
        "findings": [finding.message for finding in found.findings],
        "chosen": [f"{one.error}·{one.signal}" for one in chosen],
        "constants_s_and_u": {lag.name: [lag.constant_s, lag.u_relative * lag.constant_s] for lag in found.model.lags},
        "held_out": [asdict(run) for run in held],
    }


def fit_lines(
    identification: Identification, chosen: Sequence[Chosen], held: Sequence[HeldOut], readings: int
) -> Iterator[str]:
    """Yields lines of text on a fit, without its findings."""
    yield f"{len(identification.model.terms)} terms from {readings} readings; scatter {identification.scatter:.3g}"
    if identification.lack_of_fit > 1.0:
        times = f"{identification.lack_of_fit:.2g} times those by the scatter"
        yield f"  left-out runs are missed by what the model lacks, segments or a term: uncertainties are {times}"
    for one in chosen:
        yield f"  {one.error} takes {one.signal}: left out {one.rms_without:.3g} → {one.rms_with:.3g} RMS"
    for lag in identification.model.lags:
        yield f"  {lag_line(lag)}"
    for run in held:
        for unit, left in run.by_unit.items():
            yield f"  run {run.run!r} predicted from the others: {left.rms:.2f} {unit} RMS, without {left.raw:.2f}"


def lag_line(lag: Lag) -> str:
    """Describes a lag in a line."""
    power = f"^{lag.power}" if lag.power > 1 else ""
    sought = f" ± {2 * lag.u_relative * lag.constant_s:.2g} (95 %)" if lag.between_s else ", given"
    return f"{lag.name}: {lag.of}{power} after {lag.constant_s:.4g} s{sought}"


def drift_summary(models: Mapping[str, DriftModel], runs: Sequence[DriftRun]) -> dict[str, object]:
    """Summarizes drift models, and what they leave of the end of the log."""
    left = {
        run.channel: {"dynamic": run.rms_um, "static": run.static_rms_um, "raw": run.raw_um}
        | {"rezeroed_h": {f"{hours:g}": left for hours, left in run.rezeroed_um.items()}}
        for run in runs
    }
    return {"left_um_rms": left, "mean_constants_s": {name: model.mean_constant_s for name, model in models.items()}}


def drift_lines(runs: Sequence[DriftRun], share: float) -> Iterator[str]:
    """Yields lines of text on drift; `share` of the time was predicted."""
    yield f"last {100 * share:g} % of the time predicted from what was before, µm RMS:"
    for run in runs:
        yield f"  {run.channel:<8} {run.raw_um:7.2f} → {run.rms_um:.2f}, without the past {run.static_rms_um:.2f}"
    yield "where a reference zeroes it every so many hours:"
    for run in runs:
        every = ", ".join(f"{hours:g} h {left:.2f}" for hours, left in run.rezeroed_um.items())
        yield f"  {run.channel:<8} {every}"


def positioning_summary(test: Positioning) -> dict[str, object]:
    """Returns the values of ISO 230-2: up, down and both, those that there are."""
    scale, unit = scale_of(test)
    values = {
        symbol: {way: scale * one for way, one in asdict(value).items() if not isnan(one)}
        for symbol, _, value in values_of(test)
    }
    return {"unit": unit} | {symbol: known for symbol, known in values.items() if known}


def positioning_lines(test: Positioning) -> Iterator[str]:
    """Yields lines of text on a positioning test."""
    scale, unit = scale_of(test)
    for symbol, meaning, value in values_of(test):
        up, down, both = (scale * one for one in astuple(value))
        if not isnan(both):
            ways = f"   ↑ {up:.2f}  ↓ {down:.2f}" if not isnan(up) else ""
            yield f"{symbol}  {both:9.2f} {unit}  {meaning}{ways}"
        for arrow, one in (("↑", up), ("↓", down)) if isnan(both) else ():
            if not isnan(one):
                yield f"{symbol}{arrow} {one:9.2f} {unit}  {meaning}"


def plates_summary(names: Sequence[str], judged: JudgedPattern) -> dict[str, object]:
    """Summarizes each plate's own similarity and what is left of it, alone and with the correction of the others."""
    rows = [
        {"plate": name, "offset_mm": fit.offset_mm, "scale": fit.scale, "rotation_rad": fit.rotation_rad}
        | {"left_um_rms": UM_PER_MM * fit.rms_mm, "after_others_um_rms": None if one is None else UM_PER_MM * one}
        for name, fit, one in zip(names, judged.fits, judged.after_mm, strict=True)
    ]
    why = judged.not_repeating
    return {"plates": rows, "table_off_um": UM_PER_MM * judged.table.deviation_mm, "repeats": not why, "why": why}


def plates_lines(names: Sequence[str], judged: JudgedPattern) -> Iterator[str]:
    """Yields lines of text on plates."""
    for name, fit, one in zip(names, judged.fits, judged.after_mm, strict=True):
        x, y = fit.offset_mm
        with_others = "" if one is None else f", {UM_PER_MM * one:.2f} with the correction of the others"
        yield (
            f"{name}: offset {x:+.4f} {y:+.4f} mm, scale {fit.scale:.7f}, rotation {degrees(fit.rotation_rad):.4f}°; "
            f"left {UM_PER_MM * fit.rms_mm:.2f} µm RMS{with_others}"
        )
    pattern = judged.pattern
    yield (
        f"pattern: {UM_PER_MM * pattern.spread_mm:.1f} µm over {pattern.length_mm:.0f} mm, tools "
        f"{UM_PER_MM * pattern.tool_spread_mm:.1f} µm apart, {UM_PER_MM * pattern.noise_mm:.1f} µm that do not repeat"
    )
