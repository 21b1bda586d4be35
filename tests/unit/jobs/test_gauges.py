"""Gauges by their checks on a calibrated ring, from the store; what a failing check says of the parts measured then."""

from collections.abc import Sequence
from dataclasses import replace
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest

from tests.support.series import reading
from tests.support.standards import FIRST, RING, STANDARD, check, checks
from trueloop.domain.inspection import Inspection
from trueloop.domain.part import Part, PartType
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.monitor.charts import control_charts, failed_checks, gauges_of
from trueloop.loops.monitor.chart import ChartOptions
from trueloop.report.markup import write_page
from trueloop.report.monitor.gauge import GaugeShape, gauge_page
from trueloop.storage.store import Store, keep, open_store

STEADY = [0.2, -0.1, 0.3, -0.2, 0.1, 0.0, -0.3, 0.2, 0.1, -0.1]


def store_of(*values: object) -> Store:
    store = open_store("sqlite://", create=True)
    keep(store, values)
    return store


def only(inspections: Sequence[Inspection], name: str | None = None) -> GaugeShape:
    (one,) = gauges_of(store_of(STANDARD, *inspections), name).gauges
    return one


def test_a_steady_gauge_has_no_alarm() -> None:
    one = only(checks(STEADY))
    assert (one.device, one.standard, one.characteristic, one.alarm) == ("bore gauge", "R7", "bore", False)
    assert one.bias_um == pytest.approx(np.mean(STEADY), abs=1e-3)
    assert one.expanded_u_um == pytest.approx(2 * np.hypot(np.std(STEADY, ddof=1) / np.sqrt(10), 0.3), abs=1e-3)
    assert len(one.chart.segments[0].charts) == 5 and one.remarks == [
        "no check has repeats: repeatability is not known"
    ]


def test_a_gauge_that_drifts_alarms_and_says_how_fast() -> None:
    one = only(checks([off + 0.4 * day for day, off in enumerate(STEADY)]))
    assert one.alarm and one.drift_um_per_day == pytest.approx(0.4, abs=0.05)
    assert any(text.startswith("drifts by +0.") for text in one.remarks)
    assert any(text.startswith("bias +1.") for text in one.remarks)


def test_a_check_fails_beyond_its_expanded_uncertainty() -> None:
    limit = 2 * np.hypot(0.5, 0.3)
    good, bad = only(checks([*STEADY, limit - 0.01])), only(checks([*STEADY, -(limit + 0.01)]))
    assert good.checks[-1].e_n == pytest.approx(0.991, abs=0.002)
    assert bad.checks[-1].e_n == pytest.approx(-1.009, abs=0.002) and bad.alarm
    assert bad.checks[-1].fails.startswith("check of bore gauge on R7 2026-03-11 07:00: −1.2 µm off, 1.0 times")
    assert "the last check fails: what it measured since the check before is in doubt" in bad.remarks


def test_without_a_stated_uncertainty_the_chart_decides() -> None:
    jumped = [check(day, off, u_um=None) for day, off in enumerate([*STEADY, 5.0])]
    one = only([replace(each) for each in jumped])
    assert one.checks[-1].e_n is None
    assert "the device states no uncertainty: checks are judged by the chart alone" in one.remarks


def test_repeats_are_one_check_and_devices_are_apart() -> None:
    store = store_of(STANDARD, check(0, 1.0, 2.0, 3.0), check(1, 0.5, device="probe"))
    both = gauges_of(store, None).gauges
    assert [(one.device, len(one.checks), one.repeatability_um) for one in both] == [
        ("bore gauge", 1, 1.0),
        ("probe", 1, None),
    ]
    assert [one.device for one in gauges_of(store, "probe").gauges] == ["probe"]


def test_the_latest_calibration_before_a_check_counts() -> None:
    (value,) = STANDARD.values
    again = replace(STANDARD, values=(replace(value, actual=value.actual + 0.002),), at=FIRST + timedelta(days=1.5))
    (one,) = gauges_of(store_of(STANDARD, again, *checks([2.0, 2.0, 2.0])), None).gauges
    assert [each.deviation_um for each in one.checks] == pytest.approx([2.0, 2.0, 0.0], abs=1e-6)


def test_no_standard_part_and_an_unknown_device_are_refused() -> None:
    for values, name in (((), None), ((STANDARD, *checks(STEADY)), "micrometer"), ((*checks(STEADY),), None)):
        with pytest.raises(TrueloopError) as refused:
            gauges_of(store_of(*values), name)
        assert refused.value.code is Code.MON_NONE


def _part(k: int, error_um: float) -> Inspection:
    part = Part(PartType("SHAFT"), f"{100 + k}")
    at = FIRST + timedelta(days=0.5 + k / 4)
    return Inspection(part, "readings", f"p{k}", 1, (reading("journal", error_um),), "bore gauge", measured_at=at)


def test_parts_measured_after_a_failing_check_alarm_with_the_gauge_as_their_likely_cause() -> None:
    off = [0.0, 0.1, -0.1, 0.2, -0.2, 9.0, 9.1]
    rng = np.random.default_rng(1)
    parts = [_part(k, rng.normal(0.0, 1.0) + (9.0 if k >= 18 else 0.0)) for k in range(26)]
    store = store_of(STANDARD, *checks(off), *parts)
    assert [bool(said) for _, said in failed_checks(store)["bore gauge"]] == [False] * 5 + [True, True]
    (one,) = control_charts(store, "SHAFT", (), ChartOptions(baseline=15)).characteristics
    cause = one.alarms[0].causes[0]
    assert (cause.kind, one.alarms[0].first) == ("gauge", "118")
    assert cause.probability > 0.5 and "check of bore gauge on R7" in cause.words


def test_the_page_is_written_in_both_languages(tmp_path: Path) -> None:
    shown = gauges_of(store_of(STANDARD, *checks([*STEADY, 5.0])), None)
    for language, word in (("en", "Gauges and probes"), ("de", "Messmittel und Taster")):
        _, html = write_page(shown, "gauges", gauge_page, tmp_path, language, "mm")  # type: ignore[arg-type]
        assert word in Path(html).read_text(encoding="utf-8")
    assert write_page(shown, "gauges", gauge_page, None, "en", "mm") == []
    assert RING.serial in shown.model_dump_json()
