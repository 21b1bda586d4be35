"""Pages of machine tests in a real browser: what a metrologist looks at is drawn, and nothing else is asked for."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from tests.support.chromium import console_errors, dump_dom
from tests.support.cli import invoke
from trueloop.diagnosis.components import Components, Inspections, error_components
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import Machine, MachineModel, State
from trueloop.machine.model.term import CONSTANT, Part, Term, chain_of
from trueloop.report.machine.positioning import drift_figure
from trueloop.report.machine.summary import components_page

TARGETS, CYCLES = 6, 5


def _page(arguments: list[str], out: Path, name: str = "") -> str:
    result = invoke("machine", *arguments, "-o", out)
    assert result.exit_code == 0, result.output
    page = out / name
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
    assert dom.count('<svg class="still"') == 1
    assert shown in dom and "ISO 230-2" in dom
    assert len(re.findall('data-tip="', dom)) >= 2 * TARGETS * CYCLES  # up and down
    assert all(f"<td>{value}" in dom for value in ("A –", "R –", "E –", "B –", "M –"))


def test_drift_page_shows_displacements_temperatures_and_speeds(tmp_path: Path) -> None:
    time_s = np.arange(0, 7200, 30)
    columns = [time_s, time_s / 600, -time_s / 900, 20 + time_s / 3600, 2000.0 * (time_s > 600)]
    log = tmp_path / "log.csv"
    np.savetxt(log, np.column_stack(columns), delimiter=",", header="time_s,x_um,z_um,t1_degC,s_rpm", comments="")
    dom = _page(["drift", str(log)], tmp_path / "page.html")
    assert dom.count('<svg class="still"') == 3
    assert all(words in dom for words in ("displacement (µm)", "temperature (°C)", "speed (rev/min)"))
    said = invoke("machine", "drift", log, "--window-h", "0.5").output
    assert float(said.split()[1]) == pytest.approx(7170 / 600, abs=0.01)
    assert float(said.splitlines()[0].split("all, ")[1].split()[0]) == pytest.approx(3.0, abs=0.01)


def test_names_at_the_ends_of_lines_that_meet_do_not_overlap() -> None:
    figure = drift_figure(np.arange(3.0), {f"c{k}": np.array([0.0, 10.0, 1.0 + 1e-3 * k]) for k in range(5)}, "µm")
    heights = sorted(note["y"] for note in figure["layout"]["annotations"])
    low, high = figure["layout"]["yaxis"]["range"]
    assert min(np.diff(heights)) > 0.04 * (high - low)


def test_model_page_draws_every_motion_and_the_residuals(tmp_path: Path) -> None:
    readings = tmp_path / "r.csv"
    rows = "".join(f"{50 * k},X,{k * k},0.5,{20 + (k * 7) % 5}\n" for k in range(10))
    readings.write_text(f"X_mm,along,reading_um,u_um,T1_degC\n{rows}")
    machine = tmp_path / "m.toml"
    machine.write_text(
        '[machine]\nname = "VMC 3"\nstructure = "mill-gantry"\n[axes.X]\ntravel_mm = [0, 500]\n'
        '[[term]]\nerror = "EXX"\nzero_at = [0]\n[[term]]\nerror = "EX0S"\nsignals = { T1 = 20.0 }\n'
    )
    dom = _page(["fit", str(machine), str(readings)], tmp_path, "machine.html")
    assert dom.count('<svg class="still"') == 2
    assert all(words in dom for words in ("X (mm)", "EXX (µm)", "VMC 3", "What the model leaves"))


def test_components_page_has_a_diagram_a_point(tmp_path: Path) -> None:
    page = tmp_path / "components.html"
    page.write_text(components_page(("P1", "P2"), _components(), None))
    assert console_errors(page) == []
    dom = dump_dom(page)
    assert dom.count('<svg class="still"') == 2 * 2, "each for a wide and a narrow window"
    assert dom.count("ERROR_MTG,RESID") >= 4 and "<br>+" not in dom


def _components() -> Components:
    """Two points of a machine that errs by 9 µm along x and a process that leaves 10 µm, both known."""
    normal = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    nominal = 10.0 * normal
    chain = chain_of("mill-gantry")
    model = MachineModel(
        Machine("mill", chain), (Term(error_name("EX0S"), (Part(CONSTANT),)),), np.array([0.009]), np.zeros((1, 1))
    )
    cut = nominal + 0.01 * normal
    state = State(chain.positions({name: nominal[:, k] for k, name in enumerate("XYZ")}))
    seen = Inspections(nominal, normal, cut - model.error_mm(state), cut, 5e-4, 5e-4)
    return error_components(model, seen, state, state, compensated=True)


def test_the_circular_page_draws_both_ways_and_names_the_cause(tmp_path: Path) -> None:
    """40 µrad of squareness at R 100: 4 µm wide. The figures of the page are those that are printed."""
    rows = ["test_id,axis,angle_deg,radius_nominal_mm,deviation_um"]
    for way, angles in (("ccw", range(360)), ("cw", range(359, -1, -1))):
        rows += [f"{way},XY,{a},100,{2 * np.sin(2 * np.radians(a)) + 0.05 * (-1) ** a:.4f}" for a in angles]
    bar = tmp_path / "bar <1>.csv"
    bar.write_text("\n".join(rows))
    dom = _page(["circular", str(bar)], tmp_path / "page.html")
    assert "bar &lt;1&gt;" in dom and "largest cause: squareness, +40.0 ±" in dom
    figure = re.search(r'<figure id="circle".*?</figure>', dom, re.S)
    assert figure is not None and len(re.findall("<path", figure[0])) >= 6
    printed = invoke("machine", "circular", bar, "--json")
    found = json.loads(printed.stdout)
    assert found["largest"] == "squareness" and abs(found["values"]["G ccw"] - 4.1) < 0.02
