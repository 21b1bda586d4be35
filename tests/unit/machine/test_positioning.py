"""ISO 230-2 by hand on a small table, its CSV, and drift windows."""

from pathlib import Path

import numpy as np
import pytest

from trueloop.errors import Code, TrueloopError
from trueloop.formats.measurements.positioning_data import read_positioning
from trueloop.machine.drift import drift
from trueloop.machine.standards import positioning
from trueloop.report.machine.positioning import positioning_page
from trueloop.report.machine.summary import positioning_lines, positioning_summary

UP = np.array([[1.0, 3.0], [6.0, 6.0], [2.0, 4.0]])
DOWN = np.array([[0.0, 2.0], [3.0, 5.0], [5.0, 5.0]])


def test_values_by_hand() -> None:
    """Means ↑ 2 6 3, ↓ 1 4 5; spreads √2 0 √2, √2 √2 0."""
    result = positioning(np.array([0.0, 10.0, 20.0]), UP, DOWN)
    root = np.sqrt(2.0)
    assert result.reversal == 2.0
    assert result.mean_reversal == pytest.approx(1 / 3)
    assert result.mean_range == pytest.approx(5.0 - 1.5)
    assert (result.systematic.up, result.systematic.down, result.systematic.both) == (4.0, 4.0, 5.0)
    assert result.repeatability.up == pytest.approx(4 * root)
    assert result.repeatability.both == pytest.approx(4 * root + 1)
    assert result.accuracy.up == pytest.approx(6 - (2 - 2 * root))
    assert result.accuracy.both == pytest.approx((4 + 2 * root) - (1 - 2 * root))


@pytest.mark.parametrize(
    ("targets", "readings", "unit", "target_mm", "reading_mm"),
    [
        ("target_in", "actual_in", None, 25.4, 25.4),
        ("target_mm", "actual_in", None, 1.0, 25.4),
        ("target_in", "actual_um", None, 25.4, 1e-3),
        ("target_mm", "actual_um", "in", 1.0, 25.4),  # --unit: that of the readings, in place of the heading's
    ],
)
def test_a_csv_in_any_order_and_unit(
    tmp_path: Path, targets: str, readings: str, unit: str | None, target_mm: float, reading_mm: float
) -> None:
    rows = [
        f"{target / target_mm!r},{way},{cycle + 1},{float(target + 1e-3 * table[k, cycle]) / reading_mm!r}"
        for way, table in (("up", UP), ("down", DOWN))
        for cycle in (1, 0)
        for k, target in ((2, 20.0), (0, 0.0), (1, 10.0))
    ]
    path = tmp_path / "x.csv"
    path.write_text("\n".join([f"{targets},approach,cycle,{readings}", *rows]))
    result = read_positioning(path, unit)
    np.testing.assert_allclose(result.deviation_up, 1e-3 * UP, atol=1e-12)
    np.testing.assert_allclose(result.deviation_down, 1e-3 * DOWN, atol=1e-12)


@pytest.mark.parametrize("way", ["up", "down"])
def test_a_test_of_one_way_has_the_values_of_that_way_alone(tmp_path: Path, way: str) -> None:
    """ISO 230-2: A, R and E of one way by the same hand arithmetic; no reversal. Deviations in their own column."""
    table = UP if way == "up" else DOWN
    rows = [f"{10 * k},{way},{cycle},{table[k, cycle]}" for k in range(3) for cycle in (0, 1)]
    path = tmp_path / "x.csv"
    path.write_text("\n".join(["target_mm,approach,cycle,deviation_um", *rows]))
    test, of_both = read_positioning(path), positioning(np.array([0.0, 10.0, 20.0]), 1e-3 * UP, 1e-3 * DOWN)
    for name in ("accuracy", "repeatability", "systematic"):
        assert getattr(getattr(test, name), way) == pytest.approx(getattr(getattr(of_both, name), way))
        assert np.isnan(getattr(test, name).both)
    assert np.isnan(test.reversal)
    assert [line.split()[0] for line in positioning_lines(test)] == [
        f"{symbol}{'↑↓'[way == 'down']}" for symbol in "ARE"
    ]
    assert set(positioning_summary(test)) == {"unit", "A", "R", "E"}
    page = positioning_page("x", test)
    assert "from one side" in page and "reversal value" not in page


@pytest.mark.parametrize(("unit", "per_unit_rad"), [("arcsec", 1e3 * np.pi / 648000), ("deg", np.pi / 180)])
def test_deviations_of_a_rotary_axis_are_in_their_own_unit(tmp_path: Path, unit: str, per_unit_rad: float) -> None:
    deviation = {"arcsec": 1.0, "deg": 0.001}[unit]
    rows = [
        f"{10 * k},{way},{cycle},{deviation * (k + cycle)}"
        for k in (0, 1)
        for way in ("up", "down")
        for cycle in (0, 1)
    ]
    path = tmp_path / "x.csv"
    path.write_text("\n".join([f"target_deg,approach,cycle,deviation_{unit}", *rows]))
    test = read_positioning(path)
    np.testing.assert_allclose(test.deviation_up, 1e-3 * per_unit_rad * np.array([[0, 1], [1, 2]]), atol=1e-15)


def _made(path: Path, heading: str, scale: float) -> Path:
    """Deviations of 1 to 12 µm, times `scale`, at five targets."""
    rows = [
        f"{100 * k},{way},{cycle},{scale * (2.0 * k + 3.0 * (way == 'up') + cycle):g}"
        for cycle in (1, 2)
        for k in range(5)
        for way in ("up", "down")
    ]
    path.write_text("\n".join([f"target_mm,approach,cycle,{heading}", *rows, ""]))
    return path


@pytest.mark.parametrize(
    ("heading", "scale", "unit", "other"),
    [("deviation_um", 1e-3, "mm", "um"), ("deviation_mm", 1.0, "um", "mm"), ("deviation_in", 1e-3, "mm", "in")],
)
def test_readings_in_another_unit_than_their_heading_are_refused_and_stated(
    tmp_path: Path, heading: str, scale: float, unit: str, other: str
) -> None:
    """The largest is 13 µm: 0.013 µm, 13 mm or 330 µm as the heading states it."""
    path = _made(tmp_path / "test.csv", heading, scale)
    with pytest.raises(TrueloopError, match="as the heading states") as refused:
        read_positioning(path)
    assert refused.value.code is Code.MCH_UNIT and f"--unit {unit}, or --unit {other}" in refused.value.hint
    right = read_positioning(_made(tmp_path / "right.csv", "deviation_um", 1.0))
    assert read_positioning(path, unit).accuracy.both == pytest.approx(right.accuracy.both)
    if heading == "deviation_um":
        assert read_positioning(path, other).accuracy.both == pytest.approx(1e-3 * right.accuracy.both)


def test_targets_of_a_few_hundred_micrometers_are_millimeters(tmp_path: Path) -> None:
    path = tmp_path / "test.csv"
    rows = [f"{at},{way},{c},{at + 0.002 * c}" for at in (0, 100, 300) for way in ("up", "down") for c in (1, 2)]
    path.write_text("\n".join(["target_um,approach,cycle,actual_um", *rows, ""]))
    with pytest.raises(TrueloopError, match="span 300 µm as the heading states") as refused:
        read_positioning(path)
    assert refused.value.code is Code.MCH_UNIT
    assert read_positioning(path, "mm").mean_up[0] == pytest.approx(0.003)
    assert read_positioning(path, "um").mean_up[0] == pytest.approx(0.003e-3)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("target_mm,approach,cycle,actual_deg\n0,up,1,0\n", Code.MCH_FILE),
        ("target_mm,approach,cycle,actual_mm\n0,up,1,zero\n", Code.MCH_FILE),
        ("target_mm,approach,cycle,actual_mm\n0,sideways,1,0\n", Code.MCH_FILE),
        ("target_ft,approach,cycle,actual_ft\n0,up,1,0\n", Code.MCH_UNIT),
        ("target_mm,approach,cycle,actual_mm\n0,up,1,0\n0,down,1,0\n", Code.MCH_DATA),
        ("target_mm,approach,cycle,actual_mm\n0,up,1,0\n0,up,2,0\n9,up,1,7.9\n9,up,2,7.9\n", Code.MCH_UNIT),
        ("target_mm,approach,cycle,actual_mm,deviation_um\n0,up,1,0,0\n", Code.MCH_FILE),
        ("UNIT=mm\nTGT_DATA[1]=0\nREF_DATA_FWD[1]=0.1\n", Code.MCH_FILE),
    ],
)
def test_what_is_no_positioning_test(tmp_path: Path, text: str, code: Code) -> None:
    path = tmp_path / "x.csv"
    path.write_text(text)
    with pytest.raises(TrueloopError) as refusal:
        read_positioning(path)
    assert refusal.value.code is code
    assert refusal.value.place.file == str(path)


def test_drift_finds_the_worst_window() -> None:
    time_s = np.arange(0.0, 7200.0, 60.0)
    values = np.where(time_s < 3600, 0.0, (time_s - 3600) / 600)
    found = drift(time_s, values, "X", 1800.0)
    assert found.total_range == pytest.approx(3540 / 600)
    assert found.window_range == pytest.approx(3.0)
    assert found.window_start_s >= 3600
    with pytest.raises(TrueloopError, match="30 rows"):
        drift(time_s[:30], values[:30], "X", 1800.0)
