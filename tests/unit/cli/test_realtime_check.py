"""`trueloop realtime check`: a record made by a formula, judged by the model; exit status by what is left."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.support import erring_lathe
from tests.support.cli import invoke
from tests.unit.realtime.test_judge import corrected_run
from trueloop.arrays import Array
from trueloop.formats.realtime.samples_csv import read_samples, samples_csv
from trueloop.formats.tables.model_file import model_to_json
from trueloop.jobs.realtime.watched import driven_run
from trueloop.realtime.samples import Samples, column_names

UNITS = {"T1": "°C"}


@pytest.fixture
def model(tmp_path: Path) -> Path:
    file = tmp_path / "model.json"
    file.write_text(model_to_json(replace(erring_lathe.model(), units=UNITS)))
    return file


def recorded(folder: Path, *, off_mm: float = 0.0, phase: float = 3.0, lost: bool = False) -> Path:
    """The run as `samples.csv`."""
    driven = corrected_run(off_mm)
    count = len(driven.command_mm)
    columns: dict[str, Array] = {name: np.zeros(count) for name in column_names("xz", ("T1_degC",))}
    columns["time_s"] = 1e-3 * np.arange(count, dtype=np.float64)
    columns["T1_degC"] = np.asarray(driven.signals["T1"])
    columns["phase"] = np.full(count, phase)
    for axis, k in (("x", 0), ("z", 2)):
        columns[f"command_{axis}_mm"] = driven.command_mm[:, k]
        columns[f"drive_{axis}_mm"] = driven.drive_mm[:, k]
    samples = Samples(1e-3, "xz", ("T1_degC",), columns)
    if lost:
        samples = samples.rows(np.delete(np.arange(count), 700))
    file = folder / "samples.csv"
    file.write_bytes(samples_csv(samples))
    return file


def test_a_run_that_is_right_passes(tmp_path: Path, model: Path) -> None:
    done = invoke("realtime", "check", recorded(tmp_path), model, "--json")
    found = json.loads(done.stdout)
    assert done.exit_code == 0 and found["within"] and found["rms_nm"] < 0.1
    assert found["reversals"] == 2 and found["judged"] == 1600


def test_a_run_that_is_off_does_not(tmp_path: Path, model: Path) -> None:
    file = recorded(tmp_path, off_mm=3e-6)  # on each of the axes, Y among them in the formula's run but not recorded
    done = invoke("realtime", "check", file, model)
    assert done.exit_code == 1 and "4.24" in done.stdout
    assert invoke("realtime", "check", file, model, "--limit-nm", "4.3").exit_code == 0


@pytest.mark.parametrize(("given", "why"), [({"phase": 1.0}, "in force in 0 of 1600"), ({"lost": True}, "1 periods")])
def test_what_cannot_be_judged_is_refused(tmp_path: Path, model: Path, given: dict[str, float], why: str) -> None:
    done = invoke("realtime", "check", recorded(tmp_path, **given), model)  # type: ignore[arg-type]
    assert done.exit_code == 3 and "RTC-SAMPLES" in done.output and why in done.output


def test_signals_that_were_not_recorded_are_named(tmp_path: Path, model: Path) -> None:
    other = tmp_path / "other.json"
    other.write_text(model_to_json(replace(erring_lathe.model(), units={"T1": "rev/min"})))
    done = invoke("realtime", "check", recorded(tmp_path), other)
    assert done.exit_code == 3 and "T1_rpm" in done.output


def test_tool_and_program_are_those_of_the_record(tmp_path: Path) -> None:
    """The tool is that of the image less the offset in force; lines count where the image's own program runs."""
    samples = read_samples(recorded(tmp_path))
    count = len(samples)
    columns = {**samples.columns, "tool_x_mm": np.full(count, 4.0), "line": np.full(count, 7.0)}
    columns["program"] = np.where(np.arange(count) < 100, 1.0, 2.0)
    run = driven_run(replace(samples, columns=columns), [("T1", "°C")], (1.0, 0.0, 3.0), "samples.csv")
    assert np.array_equal(run.tool_mm, np.tile([-3.0, 0.0, 3.0], (count, 1)))
    assert run.line[:100].tolist() == [7] * 100 and not run.line[100:].any()
