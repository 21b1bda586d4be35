"""`trueloop machine drift-fit` and `drift-predict`: known lags are learnt, judged, and predicted elsewhere."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import output_of
from trueloop.formats.tables.model_file import model_to_json
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.history import lagged
from trueloop.machine.model.model import Machine, MachineModel
from trueloop.machine.model.term import Term, chain_of


def _log(path: Path, seed: int, *, offset_um: float = 0.0, warmer: float = 0.0, displacement: bool = True) -> Path:
    """Fourteen hours of a hall and a spindle; z follows both late, by 1800 s."""
    rng = np.random.default_rng(seed)
    time_s = np.arange(0.0, 14 * 3600.0, 60.0)
    speed = np.repeat(rng.choice([0.0, 1000.0, 3000.0], 14), 60)
    speed[:60] = 0.0
    heat = lagged(time_s, (speed[:, None] / 1000) ** 2, np.array([1200.0]))[:, 0, 0]
    hall = (1 + warmer) * np.sin(time_s / 9000)
    felt = lagged(time_s, (heat + hall)[:, None], np.array([1800.0]))[:, 0, 0]
    columns = {"time_s": time_s, "spindle_rpm": speed, "T1_degC": 20 + hall, "T2_degC": 22 + heat + hall}
    if displacement:
        columns["z_um"] = offset_um + 3.0 * felt + rng.normal(0, 0.05, len(time_s))
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(np.stack(list(columns.values()), axis=1).tolist())
    return path


@pytest.fixture(scope="module")
def fitted(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("drift")
    told = json.loads(output_of("machine", "drift-fit", str(_log(folder / "log.csv", 5)), "-o", folder, "--json"))
    left = told["left_um_rms"]["z"]
    assert left["dynamic"] < 0.1 * left["raw"] and left["dynamic"] < 0.5 * left["static"]
    assert "drift model" in (folder / "drift.html").read_text()
    return folder / "drift.json"


def test_another_day_is_predicted_with_its_sign(fitted: Path, tmp_path: Path) -> None:
    """Its displacement was zeroed elsewhere: that offset is reported apart."""
    log, out = _log(tmp_path / "day.csv", 6, offset_um=100.0), tmp_path / "p.csv"
    left = json.loads(output_of("machine", "drift-predict", fitted, log, "-o", out, "--json"))["left_um_rms"]["z"]
    assert left["without_mean"] < 1.0 and left["as_read"] == pytest.approx(100, abs=1)
    read, written = (np.genfromtxt(path, delimiter=",", names=True) for path in (log, out))
    assert np.polyfit(written["z_um"], read["z_um"], 1)[0] == pytest.approx(1, abs=0.1)


def test_a_log_without_displacements_will_do(fitted: Path, tmp_path: Path) -> None:
    log, out = _log(tmp_path / "day.csv", 6, displacement=False), tmp_path / "p.csv"
    assert "written" in output_of("machine", "drift-predict", fitted, log, "-o", out)


def test_signals_beyond_the_data_need_their_name(fitted: Path, tmp_path: Path) -> None:
    log, out = _log(tmp_path / "day.csv", 5, warmer=9.0), tmp_path / "p.csv"
    said = output_of("machine", "drift-predict", fitted, log, "-o", out, status=3)
    assert "--extrapolate T1 --extrapolate T2" in said  # all of them at once
    assert "day.csv: MCH-RANGE: T" in said and "°C; the model was found from" in said and not out.exists()
    allowed = ["--extrapolate", "T1", "--extrapolate", "T2_degC"]
    assert "written" in output_of("machine", "drift-predict", fitted, log, "-o", out, *allowed)


def test_a_log_that_begins_with_the_spindle_turning_is_warned_of(fitted: Path, tmp_path: Path) -> None:
    """The model begins in equilibrium: the first two hours of a log cut off, what was felt in them is missing."""
    log, out = _log(tmp_path / "day.csv", 6), str(tmp_path / "p.csv")
    header, *rows = log.read_text().splitlines()
    turning = next(k for k, row in enumerate(rows) if float(row.split(",")[1]) > 0)
    late = tmp_path / "late.csv"
    late.write_text("\n".join([header, *rows[turning + 30 :], ""]))
    assert "MCH-HISTORY" not in output_of("machine", "drift-predict", fitted, log, "-o", out)
    said = output_of("machine", "drift-predict", fitted, late, "-o", out)
    assert "warning MCH-HISTORY: the log begins with spindle at" in said and "standard uncertainty" in said


def test_refusals(fitted: Path, tmp_path: Path) -> None:
    out = str(tmp_path / "p.csv")
    short = tmp_path / "short.csv"
    short.write_text("\n".join(_log(tmp_path / "day.csv", 6).read_text().splitlines()[:50]))
    assert "MCH-DATA" in output_of("machine", "drift-fit", short, "-o", tmp_path, status=3)
    renamed = tmp_path / "renamed.csv"
    renamed.write_text(short.read_text().replace("spindle_rpm", "speed_rpm"))
    assert "MCH-SIGNAL: 1 signals" in output_of(
        "machine", "drift-predict", str(fitted), str(renamed), "-o", out, status=3
    )
    assert "MCH-FILE" in output_of("machine", "drift-predict", short, short, "-o", out, status=3)


def test_a_drift_becomes_part_of_a_model_and_of_a_corrected_program(fitted: Path, tmp_path: Path) -> None:
    """What the tool drifted along Z by the end of the log is taken off every Z; after a zero, what it drifted since."""
    machine = Machine("VMC 3", chain_of("mill-gantry"))
    model, drifting, program = tmp_path / "model.json", tmp_path / "drifting.json", tmp_path / "part.ngc"
    model.write_text(
        model_to_json(MachineModel(machine, (Term(error_name("EX0S")),), np.zeros(1), np.zeros((1, 1))), {})
    )
    log = _log(tmp_path / "day.csv", 6, displacement=False)
    add = ("machine", "add-drift", model, fitted, "-o", drifting, "--channel")
    assert "is not one of z" in output_of(*add, "q=EZ0S", status=2)
    output_of(*add, "z=EZ0S")
    predicted = tmp_path / "p.csv"
    output_of("machine", "drift-predict", fitted, log, "-o", predicted)
    rows = np.genfromtxt(predicted, delimiter=",", names=True)
    program.write_text("G21 G90 G54\nG0 X0 Y0 Z5\nG1 Z-2 F200\nX200\nM2\n")
    for options, expected_um in (
        ([], rows["z_um"][-1]),
        (["--zeroed-s", "18000"], rows["z_um"][-1] - rows["z_um"][rows["time_s"] == 18000.0][0]),
    ):
        out = tmp_path / f"out{len(options)}"
        command = ("machine", "compensate", program, "-m", drifting, "--work-zero", "1=0,0,0", "-t", log, "-o", out)
        output_of(*command, *options)
        cut = next(line for line in (out / "part.ngc").read_text().splitlines() if line.startswith("G1 Z"))
        assert float(cut.split()[1][1:]) + 2 == pytest.approx(-expected_um / 1e3, abs=0.6e-3)
        assert ("temperatures_at_zero" in (out / "part.record.json").read_text()) is bool(options)
    assert "MCH-HISTORY" in output_of(*command, "--zeroed-s", "-5", status=3)
