"""What a watched run is reduced to hides nothing: bands, tallies and events against plain counting."""

import json
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.support.refusals import refused
from trueloop.arrays import Array
from trueloop.controllers.linuxcnc.realtime.watch import layout_of, sampled_pins, samples_of, streams
from trueloop.errors import Code
from trueloop.realtime.samples import NONE, Samples, column_names, counted, empty, envelope, events, gathered, merged
from trueloop.report.realtime.page import parts_figure, run_page
from trueloop.report.realtime.run import FinishedPart, RunPage, largest_um, trace_of
from trueloop.report.style import LEFT_ON, TAKEN

NAMES = column_names("xz", ("T1_degC",))


def _samples(n: int, **columns: Array) -> Samples:
    whole: dict[str, Array] = {name: np.zeros(n) for name in NAMES}
    whole["time_s"] = np.asarray(np.arange(n) * 1e-3, np.float64)
    whole["fault_signal"] = -np.ones(n)
    return Samples(1e-3, "xz", ("T1_degC",), whole | columns)


@settings(max_examples=50, deadline=None)
@given(st.integers(1, 400), st.integers(0, 2**32), st.lists(st.integers(0, 400), max_size=4), st.integers(4, 50))
def test_bands_hold_every_period(n: int, seed: int, cuts: list[int], most: int) -> None:
    values = np.random.default_rng(seed).normal(size=n)
    samples = _samples(n, model_x_um=values)
    so_far = empty(["model_x_um"], 1e-3)
    ends = sorted({min(cut, n) for cut in cuts} | {0, n})
    for start, end in pairwise(ends):
        so_far = gathered(so_far, samples.rows(slice(start, end)), most)
    low, high = so_far.of("model_x_um")
    assert len(low) <= most
    each = round(so_far.step_s / 1e-3)
    for k in range(len(low)):
        stretch = values[k * each : (k + 1) * each]
        assert (low[k], high[k]) == (stretch.min(), stretch.max())
    fewer = merged(so_far, 3)
    assert fewer.low.shape[1] <= 3
    assert np.nanmin(fewer.low) == values.min()
    assert np.nanmax(fewer.high) == values.max()


@given(st.lists(st.lists(st.integers(0, 50), max_size=30), min_size=1, max_size=5), st.sampled_from([0.5, 0.99, 0.999]))
def test_quantiles_are_those_of_all_values(parts: list[list[int]], share: float) -> None:
    tally = NONE
    for part in parts:
        tally = counted(tally, np.array(part, np.float64))
    values = [value for part in parts for value in part]
    assert tally.total == len(values)
    if values:
        assert tally.quantile(share) == np.quantile(values, share, method="inverted_cdf")


def test_events_are_changes_with_their_reasons() -> None:
    phase = np.repeat([1.0, 2, 3, 2, 3, 4, 5, 6, 0], 10)
    waits = np.where(phase == 1, 1.0, 0.0)
    bad = np.where((phase == 4) | (phase == 5), 6.0, 0.0)
    fault = np.where(phase == 6, 6.0, 0.0)
    about = np.where(phase >= 4, 0.0, -1.0)
    samples = _samples(90, phase=phase, waits_for=waits, signal_fault=bad, fault=fault, fault_signal=about)
    found = events(samples)
    assert [round(1e3 * event.time_s) for event in found] == [0, 10, 50, 60, 70, 80]
    assert [event.alarming for event in found] == [False, False, True, True, True, False]
    said = [event.in_words() for event in found]
    assert said[2] == "frozen: a signal jumped (T1_degC)"
    assert said[4] == "faulted: a signal jumped (T1_degC)"
    assert said[5] == "off"
    cut = [*(first := events(samples.rows(slice(0, 55)))), *events(samples.rows(slice(55, None)), first[-1])]
    assert cut == found


def test_page_shows_a_spike_of_one_period_and_both_parts() -> None:
    spike = np.zeros(50_000)
    spike[23_456] = -41.5
    trace = trace_of(_samples(50_000, correction_x_um=spike))
    assert largest_um(trace, "correction") == {"X": 41.5, "Z": 0.0}
    along = np.linspace(0.0, 50.0, 300)
    part = FinishedPart("without", along, 8.0 * np.sin(along), ("dome",) * 300)
    page = run_page(RunPage("lathe <1>", parts=(part,), trace=trace))
    assert "lathe &lt;1&gt;" in page
    assert "41.500 µm" in page
    assert f"{part.rms_um:.2f}" in page
    assert len(page) < 1_000_000
    assert envelope(_samples(50_000, correction_x_um=spike), ["correction_x_um"]).low.min() == -41.5


def test_red_is_material_left_on() -> None:
    along = np.linspace(0.0, 50.0, 30)
    for sign, colour, other in ((1.0, LEFT_ON, TAKEN), (-1.0, TAKEN, LEFT_ON)):
        drawn = parts_figure((FinishedPart("a", along, sign * (1.0 + along), ("dome",) * 30),), 980)["data"]
        filled = {trace["fillcolor"]: np.array(trace["y"]) for trace in drawn if "fillcolor" in trace}
        assert sign * filled[colour].sum() > 0
        assert not filled[other].any()


def _head(**more: object) -> bytes:
    """What the reader says of a whole configuration; x on joint 0, z on joint 1."""
    wired = [[[pin.name] for pin in stream] for stream in streams(sampled_pins({0: 0, 2: 1}, 1))]
    for stream in wired:
        for pins in stream:
            pins += [f"joint.{joint}.pos-cmd" for axis, joint in ((0, 0), (2, 1)) if f"rtec.at-{axis}" in pins]
    head = {"columns": wired, "period_ns": 1_000_000, "clocks_per_ns": 2.5, "signals": 1, "mm_per_unit": 25.4}
    return json.dumps(head | {"samplers": 2} | more).encode()


def test_rows_of_pins_become_columns_in_mm_whatever_the_machine_counts_in() -> None:
    layout = layout_of(_head(), [("T1", "°C")])
    row = np.zeros((1, layout.width))
    values = {
        "rtec.periods": 5, "rtec.at-0": 1.0, "rtec.cmd-0": 1.5, "rtec.out-0": 1.501, "rtec.corr-0": 0.0254,
        "rtec.model-2": -0.002, "rtec.tool-2": 2.0, "joint.1.f-error": 1e-4, "rtec.write.time": 1000,
        "rtec.in-use-0": 21.5,
    }  # fmt: skip
    for pin, value in values.items():
        row[:, layout.place[pin]] = value
    samples = samples_of(row, layout, 2**32 - 1)
    said = {name: float(column[0]) for name, column in samples.columns.items()}
    expected = {
        "time_s": 6e-3, "command_x_mm": 25.4, "drive_x_mm": 25.4254, "correction_x_um": 25.4, "model_z_um": -2.0,
        "tool_z_mm": 50.8, "following_error_z_um": 2.54, "write_ns": 400.0, "T1_degC": 21.5,
    }  # fmt: skip
    assert {name: said[name] for name in expected} == pytest.approx(expected)
    assert set(samples.columns) == set(NAMES)


@pytest.mark.parametrize(
    ("said", "message"),
    [
        (b"", "0 LinuxCNC"),
        (b'{"error": "no rtec", "found": []}', "no LinuxCNC runs"),
        (b'{"error": "no rtec", "found": ["motmod"]}', "motmod"),
        (b'{"error": "no thread", "found": []}', "rtec.write"),
        (_head(columns=[]), "rtec.periods"),
        (_head(signals=2), "rtec.in-use-1"),
    ],
)
def test_what_cannot_be_watched_is_said(said: bytes, message: str) -> None:
    error = refused(layout_of, said)
    assert error.code is Code.RTC_CONNECTION
    assert message in error.message
    assert error.hint


def test_an_image_with_other_signals_is_refused() -> None:
    error = refused(layout_of, _head(), [("T1", "°C"), ("T2", "°C")])
    assert error.code is Code.RTC_CONNECTION
    assert "2 signals" in error.message
