"""Pages of machine tests in a real browser: what a metrologist looks at is drawn, and nothing else is asked for."""

import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from tests.support.chromium import console_errors, dump_dom
from trueloop.cli.main import app
from trueloop.report.machine_positioning import drift_figure

TARGETS, CYCLES = 6, 5


def _page(arguments: list[str], page: Path) -> str:
    result = CliRunner().invoke(app, ["machine", *arguments, "-o", str(page)])
    assert result.exit_code == 0, result.output
    assert console_errors(page) == []
    return dump_dom(page)


@pytest.mark.parametrize(("unit", "shown"), [("mm", "target position (mm)"), ("deg", "target position (°)")])
def test_positioning_page_shows_every_deviation_and_all_values(tmp_path: Path, unit: str, shown: str) -> None:
    rng = np.random.default_rng(91)
    rows = [
        f"{60 * k},{way},{c},{60 * k + (0.004 if way == 'down' else 0) + rng.normal(0, 0.001)}"
        for way in ("up", "down")
        for c in range(CYCLES)
        for k in range(TARGETS)
    ]
    test = tmp_path / "x axis.csv"
    test.write_text("\n".join([f"target_{unit},approach,cycle,actual_{unit}", *rows]))
    dom = _page(["positioning", str(test)], tmp_path / "page.html")
    assert dom.count('class="plot js-plotly-plot"') == 1
    assert shown in dom and "ISO 230-2" in dom
    markers = re.findall(r'class="trace scatter[^>]*>.*?(?=class="trace scatter|$)', dom, flags=re.S)
    assert max(m.count('<path class="point"') for m in markers) == TARGETS * CYCLES
    assert all(f"<td>{value}" in dom for value in ("A –", "R –", "E –", "B –", "M –"))


def test_drift_page_shows_displacements_temperatures_and_speeds(tmp_path: Path) -> None:
    time_s = np.arange(0, 7200, 30)
    columns = [time_s, time_s / 600, -time_s / 900, 20 + time_s / 3600, 2000.0 * (time_s > 600)]
    log = tmp_path / "log.csv"
    np.savetxt(log, np.column_stack(columns), delimiter=",", header="time_s,x_um,z_um,t1_degC,s_rpm", comments="")
    dom = _page(["drift", str(log)], tmp_path / "page.html")
    assert dom.count('class="plot js-plotly-plot"') == 3
    assert all(words in dom for words in ("displacement (µm)", "temperature (°C)", "speed (rev/min)"))
    said = CliRunner().invoke(app, ["machine", "drift", str(log), "--window-h", "0.5"]).output
    assert float(said.split()[1]) == pytest.approx(7170 / 600, abs=0.01)
    assert float(said.splitlines()[0].split("all, ")[1].split()[0]) == pytest.approx(3.0, abs=0.01)


def test_names_at_the_ends_of_lines_that_meet_do_not_overlap() -> None:
    figure = drift_figure(np.arange(3.0), {f"c{k}": np.array([0.0, 10.0, 1.0 + 1e-3 * k]) for k in range(5)}, "µm")
    heights = sorted(note["y"] for note in figure["layout"]["annotations"])
    low, high = figure["layout"]["yaxis"]["range"]
    assert min(np.diff(heights)) > 0.04 * (high - low)
