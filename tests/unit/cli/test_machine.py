"""`trueloop machine` from readings to a corrected program, tables and components."""

import csv
import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import output_of
from tests.support.exact_kinematics import exact_error_of
from tests.support.machines import random_directions, random_model
from trueloop.arrays import Array
from trueloop.domain.inspection import BothInspections, Inspection, MachineStood
from trueloop.domain.tool import Machine
from trueloop.formats.jobs.machine_toml import read_machine
from trueloop.formats.record_file import read_record
from trueloop.formats.tables.model_file import read_model
from trueloop.machine.model.history import lagged
from trueloop.machine.model.model import MachineModel, State
from trueloop.storage.store import find, open_store

MACHINE = """
[machine]
name = "VMC 3"
serial = "4711"
structure = "mill-table-x"
[axes.X]
travel_mm = [0, 500]
[axes.Y]
travel_mm = [-200, 200]
[axes.Z]
travel_mm = [-300, 0]
[terms]
standard = "mill"
degree = 2
[[term]]
error = "EZ0S"
signals = { T1 = 20.0 }
"""

PROGRAM = "G21 G90 G54\nG0 X0 Y0 Z5\nG1 Z-2 F200\nX200 ( along )\nY100\nM2\n"


def _write_readings(path: Path, truth: MachineModel, rng: np.random.Generator, count: int, run: str) -> None:
    chain = truth.machine.chain
    positions = np.stack([rng.uniform(*chain.axis(name).travel, count) for name in "XYZ"], axis=1)
    warm, tool = rng.uniform(20, 30, count), rng.uniform(-100, 100, (count, 3))
    along = random_directions(count, rng)
    error = exact_error_of(truth, State(positions, 0.0, {"T1": warm}, tool))
    reading = np.einsum("ni,ni->n", along, error) + rng.normal(0, 0.5e-3, count)
    columns: list[Array] = [*positions.T, *tool.T, *along.T, 1e3 * reading, warm]
    names = [
        "X_mm",
        "Y_mm",
        "Z_mm",
        "tool_x_mm",
        "tool_y_mm",
        "tool_z_mm",
        "along_x",
        "along_y",
        "along_z",
        "reading_um",
        "T1_degC",
    ]
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow([*names, "u_um", "run", "absolute"])
        writer.writerows([*map(float, row), 0.5, run, "yes"] for row in zip(*columns, strict=True))


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A machine, two runs of readings of it, its model and a program."""
    where = tmp_path_factory.mktemp("machine")
    (where / "machine.toml").write_text(MACHINE)
    (where / "part.ngc").write_text(PROGRAM)
    machine, form = read_machine(where / "machine.toml")
    rng = np.random.default_rng(41)
    truth = random_model(machine, form.terms, rng)
    coefficients = truth.coefficients.copy()
    coefficients[-2:] = [0.0, 1.5e-3]
    truth = MachineModel(machine, form.terms, coefficients, truth.covariance)
    for run in ("1", "2"):
        _write_readings(where / f"run{run}.csv", truth, rng, 300, run)
    output_of("machine", "fit", where / "machine.toml", where / "run1.csv", where / "run2.csv", "-o", where / "model")
    return where


def test_fit_writes_a_model_and_its_page(folder: Path) -> None:
    model = read_model(folder / "model/model.json")
    assert model.machine.serial == "4711"
    own, frame = model.terms[:22], {str(term.name) for term in model.terms[22:]}
    assert frame == {"EB0X", "EC0X", "EA0Y", "EX0S", "EY0S", "EA0S", "EB0S", "EC0S"}
    growth = float(model.values(State(np.zeros((1, 3)), 0.0, {"T1": 30.0}))[own[-1].name][0])
    assert growth == pytest.approx(0.015, abs=0.5e-3)
    page = (folder / "model/machine.html").read_text()
    assert "EXX" in page and "VMC 3" in page
    assert page.count("<figure") == 19  # eighteen motions and the residuals


@pytest.mark.parametrize(("absolute", "left"), [("yes", 100.0), ("slope", 10.0), ("no", 0.0), ("", 0.0)])
def test_what_is_not_absolute_is_judged_without_its_zero_and_slope(
    folder: Path, tmp_path: Path, absolute: str, left: float
) -> None:
    """A straightness run along Y that reads X at 0.1 mm plus 50 µrad times the way: µm RMS of what counts."""
    y = np.linspace(-190, 190, 41)
    zero = read_model(folder / "model/model.json").error_mm(
        State(np.column_stack([np.full(41, 9.0), y, np.full(41, -9.0)]), 0.0, {"T1": 25.0})
    )
    rows = [f"9,{v},-9,X,{1e3 * e + 100 + 0.05 * v},25,{absolute}" for v, e in zip(y, zero[:, 0], strict=True)]
    path = tmp_path / "y.csv"
    path.write_text("\n".join(["X_mm,Y_mm,Z_mm,along,reading_um,T1_degC,absolute", *rows]))
    options = ("machine", "check", folder / "model/model.json", path)
    checked = json.loads(output_of(*options, "--json"))
    slope = np.sqrt(np.mean((0.05 * y) ** 2))
    expected = {100.0: np.hypot(100.0, slope), 10.0: slope, 0.0: 0.0}[left]
    assert 1e3 * checked["length_mm"]["rms"] == pytest.approx(expected, abs=1e-3)
    path.write_text(path.read_text().replace(f"25,{absolute}", "25,perhaps"))
    assert "MCH-FILE" in output_of(*options, status=3)


def test_show_and_check(folder: Path) -> None:
    shown = output_of("machine", "show", folder / "model/model.json", "-t", "T1=25")
    assert shown.splitlines()[0].startswith("EXX")
    checked = json.loads(output_of("machine", "check", folder / "model/model.json", folder / "run1.csv", "--json"))
    assert checked["length_mm"]["rms"] < 0.7e-3
    assert checked["length_mm"]["raw"] > 10e-3
    assert checked["angle_rad"] is None
    limited = ("machine", "check", folder / "model/model.json", folder / "run1.csv", "--json", "--limit-um", 0.1)
    assert json.loads(output_of(*limited, status=1)) == checked


def test_compensate_once_and_never_twice(folder: Path) -> None:
    options = ("-m", folder / "model/model.json", "--work-zero", "1=200,0,-150", "--tool", "*=0,0,-90")
    output_of(
        "machine", "compensate", folder / "part.ngc", *options, "-t", "T1=26", "-o", folder / "out", "--serial", "4711"
    )
    source = (folder / "out/part.ngc").read_text()
    assert source.startswith("(trueloop corrected ")
    assert "( along )" in source
    record = json.loads((folder / "out/part.record.json").read_text())
    assert read_record(folder / "out/part.record.json").machine == Machine("VMC 3", "4711")
    shown = output_of("record", "show", folder / "out/part.record.json")
    assert f"Correction {record['id']}" in shown and "30 error terms of VMC 3, 4711" in shown
    assert "none listed in the record" in shown
    assert record["id"] in source
    assert record["options"]["temperatures"] == {"T1": 26.0}
    again = output_of(
        "machine", "compensate", folder / "out/part.ngc", *options, "-t", "T1=26", "-o", folder / "twice", status=3
    )
    assert "CMP-TWICE" in again
    assert not (folder / "twice").exists()


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (["--work-zero", "2=200,0,-150", "-t", "T1=26"], "MCH-FRAME"),
        (["--work-zero", "1=400,0,-150", "-t", "T1=26"], "MCH-TRAVEL"),
        (["--work-zero", "1=200,0,-150", "-t", "T1=45"], "MCH-RANGE"),
        (["--work-zero", "1=200,0,-150"], "MCH-SIGNAL"),
        (["--work-zero", "1=200,0,-150", "-t", "T1=26", "--serial", "4712"], "model.json: MCH-MACHINE"),
    ],
)
def test_refusals(folder: Path, change: list[str], code: str) -> None:
    arguments = ("compensate", folder / "part.ngc", "-m", folder / "model/model.json", "-o", folder / "refused")
    assert code in output_of("machine", *arguments, *change, status=3)
    assert not (folder / "refused").exists()


def test_a_temperature_out_of_range_by_name(folder: Path) -> None:
    arguments = ("compensate", folder / "part.ngc", "-m", folder / "model/model.json", "-o", folder / "hot")
    said = output_of("machine", *arguments, "--work-zero", "1=200,0,-150", "-t", "T1=45", "--extrapolate", "T1")
    assert said.startswith("largest displacement X ")
    assert sorted(file.name for file in (folder / "hot").iterdir()) == ["part.ngc", "part.record.json"]


def test_export_says_how_far_the_table_is_from_the_model(folder: Path) -> None:
    target = folder / "tables/x.comp"
    said = output_of(
        "machine",
        "export",
        folder / "model/model.json",
        "--control",
        "linuxcnc",
        "--axis",
        "X",
        "-o",
        target,
        "-t",
        "T1=21",
    )
    assert "off the model by" in said
    rows = np.loadtxt(target)
    assert rows.shape == (101, 3)
    positions = np.column_stack([rows[:, 0], np.zeros((101, 2))])
    error = read_model(folder / "model/model.json").error_mm(State(positions, 1.0, {"T1": 21.0}))
    np.testing.assert_allclose(rows[:, 1] - rows[:, 0], error[:, 0], atol=1e-6)
    refused = output_of(
        "machine",
        *("export", folder / "model/model.json", "--control", "linuxcnc", "--axis", "X", "--error-of", "Y"),
        *("-o", folder / "tables/no.comp", "-t", "T1=21"),
        status=3,
    )
    assert "MCH-TABLE" in refused


def inspected(folder: Path) -> Path:
    """Touches on an ideal part, whose surface lies 10 µm outside, by a machine without process error."""
    model = read_model(folder / "model/model.json")
    rng = np.random.default_rng(42)
    nominal, normal = rng.uniform(-50, 50, (8, 3)), random_directions(8, rng)
    zero, signals = np.array([250.0, 0.0, -150.0]), {"T1": 24.0}
    machine_error = model.error_mm(State(nominal + zero, 0.0, signals))
    surface = nominal + 0.01 * normal
    columns = [nominal, normal, surface - machine_error, surface]
    names = [f"{kind}_{c}{unit}" for kind, unit in NAMES for c in "xyz"]
    rows = [[f"P{k}", *map(float, np.concatenate([c[k] for c in columns]))] for k in range(8)]
    file = folder / "inspections.csv"
    lines = ["# touch_u_um 0.5", ",".join(["point", *names]), *(",".join(map(str, row)) for row in rows)]
    file.write_text("\n".join(lines))
    return file


def test_decompose(folder: Path) -> None:
    """What is left is what the model does not know."""
    file, out = inspected(folder), folder / "parts"
    options = ("--work-zero", "250,0,-150", "--cutting", "T1=24", "--probing", "T1=24", "-o", out)
    output_of("machine", "decompose", file, "-m", folder / "model/model.json", *options)
    with (out / "components.csv").open() as table:
        found = list(csv.DictReader(table))
    assert all(float(row["error_pp_um"]) == pytest.approx(10.0, abs=0.01) for row in found)
    assert all(float(row["error_proc_resid_um"]) == pytest.approx(10.0, abs=0.05) for row in found)
    assert "ERROR_MTG" in (out / "components.html").read_text()


def test_decompose_keeps_what_either_device_found(folder: Path, tmp_path: Path) -> None:
    """The part is 10 µm too large by the measuring machine; the machine's probe saw that less its own error."""
    file, db = inspected(folder), str(tmp_path / "trueloop.db")
    output_of("db", "init", db)
    options = ("--work-zero", "250,0,-150", "--cutting", "T1=24", "--probing", "T1=24", "-o", tmp_path, "--db", db)
    call = ("machine", "decompose", file, "-m", folder / "model/model.json", *options)
    assert "1 part, 2 inspections" in output_of(*call, "--type", "PLATE", "--serial", "7")
    assert "kept already" in output_of(*call, "--type", "PLATE", "--serial", "7")
    assert "STO-OTHER-PART" in output_of(*call, "--type", "PLATE", "--serial", "8", status=3)
    output_of(*call, status=2)
    kept = {one.value.device: one.value for one in find(open_store(db), Inspection)}
    assert {one.part.serial for one in kept.values()} == {"7"}
    for device, is_ideal in (("measuring machine", True), ("machine's probe", False)):
        points = kept[device].points
        assert [point.name for point in points] == [f"P{k}" for k in range(8)]
        vectors = [np.array([getattr(point, name) for point in points]) for name in VECTORS]
        along = np.einsum("ni,ni->n", vectors[0] - vectors[1], vectors[2])
        assert np.allclose(along, 0.01, atol=1e-9) == is_ideal


def test_decompose_keeps_how_the_machine_stood(folder: Path, tmp_path: Path) -> None:
    """The tool of each point from the file, the stylus from the command; and which model, by its hash."""
    model, file, db = folder / "model/model.json", inspected(folder), str(tmp_path / "trueloop.db")
    head, *rows = [line for line in file.read_text().splitlines() if not line.startswith("#")]
    tools = [f"{row},{6 + 5 * (k % 3)},0,{12 - k}" for k, row in enumerate(rows)]
    file.write_text("\n".join(["# cmm_u_um 0.4", f"{head},tool_x_mm,tool_y_mm,tool_z_mm", *tools]))
    output_of("db", "init", db)
    options = ("--work-zero", "250,0,-150", "--cutting", "T1=23", "--probing", "T1=24.5", "-o", tmp_path, "--db", db)
    call = ("machine", "decompose", file, "-m", model, *options, "--type", "PLATE", "--serial", "7")
    assert "column tool_x_mm" in output_of(*call, "--tool", "1,2,3", status=2)
    output_of(*call, "--probe", "4,0,9", "--no-compensated", "--new-frame")
    (both,) = [one.value for one in find(open_store(db), BothInspections)]
    assert both.cutting == MachineStood(
        (250.0, 0.0, -150.0), tuple((6.0 + 5 * (k % 3), 0.0, 12.0 - k) for k in range(8)), {"T1": 23.0}
    )
    assert both.probing == MachineStood((250.0, 0.0, -150.0), ((4.0, 0.0, 9.0),), {"T1": 24.5})
    assert both.model_sha256 == hashlib.sha256(model.read_bytes()).hexdigest()
    assert (both.compensated, both.new_frame, both.touch_u_mm, both.cmm_u_mm) == (False, True, 0.0, 0.0004)
    assert (both.part.serial, both.machine.serial) == ("7", read_model(model).machine.serial)
    kept = {one.value.identity: one.value.device for one in find(open_store(db), Inspection)}
    assert (kept[both.on_machine], kept[both.on_cmm]) == ("machine's probe", "measuring machine")
    assert "STO-DIFFERS" in output_of(*call, status=3)
    output_of(*call, "--supersede")
    assert [one.value.compensated for one in find(open_store(db), BothInspections)] == [True]


VECTORS = ("measured_mm", "nominal_mm", "outward_normal")
NAMES = (("nominal", "_mm"), ("normal", ""), ("controller", "_mm"), ("cmm", "_mm"))


@pytest.mark.parametrize("control", ["siemens", "heidenhain"])
def test_tables_whose_sign_was_not_tried_say_so(folder: Path, control: str) -> None:
    out = folder / control / "x.com"
    arguments = ("export", folder / "model/model.json", "--control", control, "--axis", "X", "-o", out, "-t", "T1=21")
    assert "was not tried" in output_of("machine", *arguments)
    assert "x.com" in (folder / "heidenhain/x.cma").read_text() if control == "heidenhain" else True
    first = out.read_text()
    output_of("machine", *arguments, "--opposite-sign")
    assert out.read_text() != first


DYNAMIC = """
[[term]]
error = "EZ0S"
choose = { T1 = 20.0, T2 = 20.0, column = 20.0 }
most = 2
[lags.column]
of = "T1"
constant_s = [300, 20000]
"""


@pytest.fixture(scope="module")
def dynamic(folder: Path) -> Path:
    """A machine whose Z grows 2 µm/K an hour after T1; its model from three runs; a log of a morning."""
    where = folder / "dynamic"
    where.mkdir()
    (where / "machine.toml").write_text(
        MACHINE[: MACHINE.index("[[term]]")].replace("degree = 2", "degree = 1") + DYNAMIC
    )
    rng, runs = np.random.default_rng(43), []
    machine, form = read_machine(where / "machine.toml")
    truth = random_model(machine, form.terms, rng)
    for run in range(3):
        runs.append(where / f"run{run}.csv")
        _write_dynamic_run(runs[-1], truth, rng, run)
    said = output_of("machine", "fit", where / "machine.toml", *runs, "-o", where / "model")
    assert "EZ0S takes column" in said and "takes T2" not in said
    assert "run 'run2' predicted from the others: 0." in said
    time_s = np.arange(0, 7201, 60)
    rows = [f"{t},{20 + 6 * (t > 3600)},21" for t in time_s]
    (where / "log.csv").write_text("\n".join(["time_s,T1_degC,T2_degC", *rows]))
    return where


def _write_dynamic_run(path: Path, truth: MachineModel, rng: np.random.Generator, run: int) -> None:
    time_s = np.arange(0, 6 * 3600.0, 100.0)
    hall = 22 + 3 * np.sin(time_s / (4000 + 1000 * run))
    felt = lagged(time_s, hall[:, None], np.array([3600.0]))[:, 0, 0]
    count = len(time_s)
    positions = np.stack([rng.uniform(*truth.machine.chain.axis(n).travel, count) for n in "XYZ"], axis=1)
    tool, along = rng.uniform(-100, 100, (count, 3)), random_directions(count, rng)
    error = exact_error_of(truth, State(positions, 0.0, {}, tool)) + np.outer(2e-3 * (felt - 20), [0, 0, 1])
    reading = 1e3 * np.einsum("ni,ni->n", along, error) + rng.normal(0, 0.5, count)
    columns = np.column_stack([time_s, positions, tool, along, reading, hall, rng.uniform(20, 24, count)])
    names = "time_s,X_mm,Y_mm,Z_mm,tool_x_mm,tool_y_mm,tool_z_mm,along_x,along_y,along_z,reading_um,T1_degC,T2_degC"
    np.savetxt(path, columns, delimiter=",", header=names, comments="")


def test_a_dynamic_term_is_fitted_shown_and_used_with_a_log(dynamic: Path) -> None:
    model = dynamic / "model/model.json"
    read = read_model(model)
    assert read.lags[0].constant_s == pytest.approx(3600, rel=0.1)
    assert "time constant" in (dynamic / "model/machine.html").read_text()
    shown = output_of("machine", "show", model, "-t", dynamic / "log.csv")
    assert shown.startswith("column: T1 after 3")
    cold = output_of("machine", "show", model, "-t", "column=20")
    growth = [next(line.split()[1] for line in said.splitlines() if "EZ0S" in line) for said in (cold, shown)]
    # an hour after a step of 6 K a machine with a constant of an hour has felt 1 − 1/e of it, at 2 µm/K
    assert float(growth[1]) - float(growth[0]) == pytest.approx(2 * 6 * (1 - np.exp(-1)), abs=0.3)
    checked = json.loads(output_of("machine", "check", model, dynamic / "run1.csv", "--json"))
    assert checked["length_mm"]["rms"] < 0.6e-3
    options = ("--work-zero", "1=200,0,-150", "-m", model, "-t", dynamic / "log.csv")
    output_of("machine", "compensate", dynamic.parent / "part.ngc", *options, "-o", dynamic / "out")
    record = json.loads((dynamic / "out/part.record.json").read_text())
    assert record["options"]["temperatures"]["column"] == pytest.approx(20 + 6 * (1 - np.exp(-1)), abs=0.3)
    export = ("export", model, "--control", "linuxcnc", "--axis", "Z", "-t", dynamic / "log.csv", "-o")
    output_of("machine", *export, dynamic / "z.comp")
    assert "OUT-INPUT" in output_of("machine", *export, dynamic / "log.csv", status=4)


def test_one_reading_is_not_enough_for_a_dynamic_term(dynamic: Path) -> None:
    model = dynamic / "model/model.json"
    said = output_of("machine", "show", model, "-t", "T1=24", status=3)
    assert "MCH-HISTORY" in said and "one reading" in said
    steady = output_of("machine", "show", model, "-t", "column=24")
    assert "EZ0S" in steady
    (dynamic / "untimed.csv").write_text("X_mm,along,reading_um,T1_degC,T2_degC\n10,X,1,20,20\n20,X,1,20,20\n")
    assert "MCH-HISTORY" in output_of("machine", "check", model, dynamic / "untimed.csv", status=3)


def test_a_log_apart_from_the_readings(dynamic: Path) -> None:
    """Temperatures of their own file, a row a minute, readings without any."""
    rows = np.genfromtxt(dynamic / "run1.csv", delimiter=",", names=True)
    names = rows.dtype.names
    assert names is not None
    bare = [name for name in names if not name.startswith("T")]
    for file, columns in (("bare.csv", bare), ("past.csv", ["time_s", "T1_degC", "T2_degC"])):
        table = np.column_stack([rows[name] for name in columns])
        np.savetxt(dynamic / file, table, delimiter=",", header=",".join(columns), comments="")
    model, log = dynamic / "model/model.json", dynamic / "past.csv"
    both = [json.loads(output_of("machine", "check", model, dynamic / "run1.csv", "--json"))]
    both.append(json.loads(output_of("machine", "check", model, dynamic / "bare.csv", "--history", log, "--json")))
    assert both[0]["length_mm"]["rms"] == pytest.approx(both[1]["length_mm"]["rms"], rel=1e-9)


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("time_s,T1_degC\n0,20\n0,21\n", "MCH-FILE"),
        ("time_min,T1_degC\n0,20\n1,21\n", "MCH-UNIT"),
        ("T1_degC\n20\n21\n", "MCH-FILE"),
        ("time_s\n0\n1\n", "MCH-FILE"),
        ("time_s,T2_degC\n0,20\n1,21\n", "MCH-SIGNAL"),
        ("time_s,T1_degC\n0,20\n1,warm\n", "MCH-FILE"),
    ],
)
def test_logs_that_are_none(dynamic: Path, tmp_path: Path, text: str, code: str) -> None:
    (tmp_path / "log.csv").write_text(text)
    assert code in output_of("machine", "show", dynamic / "model/model.json", "-t", tmp_path / "log.csv", status=3)
