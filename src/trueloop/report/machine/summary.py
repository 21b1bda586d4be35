"""Models of a machine, of its drift and of drilled plates, in lines for people and as JSON."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, astuple
from math import degrees, isnan

from trueloop.machine.drift.hold_out import DriftRun
from trueloop.machine.drift.model import DriftModel
from trueloop.machine.identify.choice import Chosen
from trueloop.machine.identify.hold_out import HeldOut
from trueloop.machine.identify.identify import Identification
from trueloop.machine.model.history import Lag
from trueloop.machine.standards.plates import JudgedPattern
from trueloop.machine.standards.positioning import Positioning
from trueloop.report.machine.positioning import scale_of, values_of
from trueloop.units import UM_PER_MM


def fit_summary(
    found: Identification, chosen: Sequence[Chosen], held: Sequence[HeldOut], readings: int
) -> dict[str, object]:
    """A model found from so many readings."""
    return {
        "scatter": found.scatter,
        "readings": readings,
        "findings": [finding.message for finding in found.findings],
        "chosen": [f"{one.error}·{one.signal}" for one in chosen],
        "constants_s_and_u": {lag.name: [lag.constant_s, lag.u_relative * lag.constant_s] for lag in found.model.lags},
        "held_out": [asdict(run) for run in held],
    }


def fit_lines(found: Identification, chosen: Sequence[Chosen], held: Sequence[HeldOut], readings: int) -> Iterator[str]:
    """The same for people, without findings."""
    yield f"{len(found.model.terms)} terms from {readings} readings; scatter {found.scatter:.3g}"
    for one in chosen:
        yield f"  {one.error} takes {one.signal}: left out {one.rms_without:.3g} → {one.rms_with:.3g} RMS"
    for lag in found.model.lags:
        yield f"  {lag_line(lag)}"
    for run in held:
        for unit, left in run.by_unit.items():
            yield f"  run {run.run!r} predicted from the others: {left.rms:.2f} {unit} RMS, without {left.raw:.2f}"


def lag_line(lag: Lag) -> str:
    """A lag in a line."""
    power = f"^{lag.power}" if lag.power > 1 else ""
    sought = f" ± {2 * lag.u_relative * lag.constant_s:.2g} (95 %)" if lag.between_s else ", given"
    return f"{lag.name}: {lag.of}{power} after {lag.constant_s:.4g} s{sought}"


def drift_summary(models: Mapping[str, DriftModel], runs: Sequence[DriftRun]) -> dict[str, object]:
    """Drift models, and what they leave of the end of the log."""
    left = {
        run.channel: {"dynamic": run.rms_um, "static": run.static_rms_um, "raw": run.raw_um}
        | {"rezeroed_h": {f"{hours:g}": left for hours, left in run.rezeroed_um.items()}}
        for run in runs
    }
    return {"left_um_rms": left, "mean_constants_s": {name: model.mean_constant_s for name, model in models.items()}}


def drift_lines(runs: Sequence[DriftRun], share: float) -> Iterator[str]:
    """The same for people; `share` of the time was predicted."""
    yield f"last {100 * share:g} % of the time predicted from what was before, µm RMS:"
    for run in runs:
        yield f"  {run.channel:<8} {run.raw_um:7.2f} → {run.rms_um:.2f}, without the past {run.static_rms_um:.2f}"
    yield "where a reference zeroes it every so many hours:"
    for run in runs:
        every = ", ".join(f"{hours:g} h {left:.2f}" for hours, left in run.rezeroed_um.items())
        yield f"  {run.channel:<8} {every}"


def positioning_summary(test: Positioning) -> dict[str, object]:
    """The values of ISO 230-2: up, down and both, those that there are."""
    scale, unit = scale_of(test)
    return {"unit": unit} | {
        symbol: {way: scale * one for way, one in asdict(value).items() if not isnan(one)}
        for symbol, _, value in values_of(test)
    }


def positioning_lines(test: Positioning) -> Iterator[str]:
    """The same for people."""
    scale, unit = scale_of(test)
    for symbol, meaning, value in values_of(test):
        up, down, both = (scale * one for one in astuple(value))
        ways = f"   ↑ {up:.2f}  ↓ {down:.2f}" if not isnan(up) else ""
        yield f"{symbol}  {both:9.2f} {unit}  {meaning}{ways}"


def plates_summary(names: Sequence[str], judged: JudgedPattern) -> dict[str, object]:
    """Each plate's own similarity and what is left of it, alone and with the correction of the others."""
    rows = [
        {"plate": name, "offset_mm": fit.offset_mm, "scale": fit.scale, "rotation_rad": fit.rotation_rad}
        | {"left_um_rms": UM_PER_MM * fit.rms_mm, "after_others_um_rms": None if one is None else UM_PER_MM * one}
        for name, fit, one in zip(names, judged.fits, judged.after_mm, strict=True)
    ]
    why = judged.not_repeating
    return {"plates": rows, "table_off_um": UM_PER_MM * judged.table.deviation_mm, "repeats": not why, "why": why}


def plates_lines(names: Sequence[str], judged: JudgedPattern) -> Iterator[str]:
    """The same for people."""
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
