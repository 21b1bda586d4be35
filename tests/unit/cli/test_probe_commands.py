"""`trueloop probe` and `simulate` from the outside: files in, files out."""

import csv
import hashlib
import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import invoke, output_of, run
from tests.support.probing import EXAMPLES, log_of
from trueloop.cli.probe import Control
from trueloop.controllers.probing import WRITERS
from trueloop.domain.inspection import Inspection
from trueloop.domain.life import Cut, InspectionLink, Stage
from trueloop.jobs.measure.probing import read_probing
from trueloop.storage.store import find, open_store

JOB = EXAMPLES / "loop" / "modbas2.toml"
MACHINE = EXAMPLES / "loop" / "machine.toml"


def test_every_control_is_offered() -> None:
    assert set(Control.__args__) == set(WRITERS)  # type: ignore[attr-defined]


@pytest.mark.parametrize("control", [name for name in WRITERS if name != "renishaw"])
def test_a_program_is_written_for_every_control(control: str, tmp_path: Path) -> None:
    run("probe", "program", JOB, "--control", control, "-o", tmp_path / "probe.nc")
    assert (tmp_path / "probe.nc").read_text().upper().count("POINT 32 ON DOME") == 1


@pytest.mark.parametrize("file", ["probe.toml", "../modbas2/touches.csv"])
def test_a_file_that_was_read_is_not_overwritten(file: str, tmp_path: Path) -> None:
    shutil.copytree(EXAMPLES, tmp_path / "examples")
    folder = tmp_path / "examples/loop"
    said = run("probe", "program", folder / JOB.name, "--control", "haas", "-o", folder / file, status=4)
    assert "OUT-INPUT" in said


def test_a_dome_faces_no_axis() -> None:
    assert "PRB-AXIS" in run("probe", "program", JOB, "--control", "renishaw", status=3)


def test_the_plan_lists_every_touch() -> None:
    touches = json.loads(run("probe", "plan", JOB, "--json"))["touches"]
    assert [touch["point"] for touch in touches] == [str(k) for k in range(1, 33)]


@pytest.mark.parametrize("control", ["fanuc", "haas", "siemens"])
def test_what_a_control_logged_becomes_the_touches_of_the_job(control: str, tmp_path: Path) -> None:
    probing = read_probing(JOB)
    plan, calibration = probing.plan, probing.probe.calibration
    assert calibration is not None
    normal = np.array([touch.normal for touch in plan.touches])
    error = np.linspace(-0.05, 0.09, 32)
    off = plan.approach.allowance_mm + error + calibration.radius_mm(normal)
    centres = np.array([touch.nominal_mm for touch in plan.touches]) + off[:, None] * normal
    (tmp_path / "log.txt").write_text(log_of(plan, centres, control=control))
    run("probe", "read", JOB, tmp_path / "log.txt", "--control", control, "-o", tmp_path / "touches.csv")
    with (tmp_path / "touches.csv").open() as file:
        found = [float(row["error_um"]) for row in csv.DictReader(file)]
    assert np.allclose(found, 1000 * error, atol=0.1)
    (tmp_path / "log.txt").write_text("X1.0Z1.0\n")
    said = run("probe", "read", JOB, tmp_path / "log.txt", "--control", control, status=3)
    assert "log.txt:1" in said and "PRB-OTHER" in said


@pytest.mark.parametrize("control", ["siemens", "fanuc"])
def test_trials_show_what_a_touch_repeats_to_and_a_drift_beside_it(control: str, tmp_path: Path) -> None:
    """Twelve trials with 0.8 µm of scatter and a drift of 9 µm; standard deviations by numpy from the drawn errors."""
    plan, trials, random = read_probing(JOB, trials=12).plan, 12, np.random.default_rng(3)
    errors = 0.0008 * random.standard_normal((trials, 32)) + np.linspace(0.0, 0.009, trials)[:, None] + 0.02
    normal = np.array([touch.normal for touch in plan.touches])
    off = plan.approach.allowance_mm + plan.stylus.ball_radius_mm + errors.ravel()
    centres = np.array([touch.nominal_mm for touch in plan.touches]) + off[:, None] * normal
    log = tmp_path / "log.txt"
    log.write_text(log_of(plan, centres, control=control))
    called = ("probe", "trials", JOB, log, "--control", control)
    found = json.loads(run(*called, "-o", tmp_path / "repeats.csv", "--json"))
    sd_um = 1000.0 * np.std(errors, axis=0, ddof=1)
    assert [one["scatter_um"] for one in found["points"]] == pytest.approx(sd_um.tolist(), abs=0.05)
    assert found["scatter_um"] == pytest.approx(np.sqrt(np.mean(sd_um**2)), abs=0.02)
    assert (found["trials"], found["degrees_of_freedom"]) == (12, 11 * 32)
    assert found["successive_um"] == pytest.approx(0.8 * np.sqrt(1.0 + 0.5 * (9.0 / 11.0 / 0.8) ** 2), rel=0.08)
    assert f"{found['scatter_um']:.2f} µm (standard deviation, 352" in run(*called)
    shown = output_of("diagnose", "fixture", tmp_path / "repeats.csv", status=1)
    assert shown.count("drift +") >= 30
    log.write_text("\n".join(log.read_text().splitlines()[:-1]) + "\n")
    refused = run(*called, status=3)
    assert "PRB-TRIALS" in refused and "has 11 touches, the one with most 12" in refused


def test_a_calibration_is_printed_as_the_probe_file_takes_it(tmp_path: Path) -> None:
    angle = np.radians(np.linspace(-45, 135, 25))
    centres = 14.0 * np.column_stack([np.sin(angle), np.cos(angle)]) + [60.0, 0.0]
    (tmp_path / "log.txt").write_text("".join(f"X{2 * x:.8f}Z{z:.8f}\n" for x, z in centres))
    said = run("probe", "calibrate", tmp_path / "log.txt", "--control", "haas", "--radius-mm", "12.5")
    assert said.startswith("[calibration]\neffective_radius_mm = 1.5000")
    assert said.endswith("from_deg = -45.0\nto_deg = 135.0\n")


def test_a_calibration_over_too_small_a_range_is_printed_with_a_warning(tmp_path: Path) -> None:
    angle, rng = np.radians(np.linspace(0, 90, 25)), np.random.default_rng(0)
    size = 14.0 + rng.uniform(-0.0005, 0.0005, 25)
    centres = size[:, None] * np.column_stack([np.sin(angle), np.cos(angle)])
    (tmp_path / "log.txt").write_text("".join(f"X{2 * x:.8f}Z{z:.8f}\n" for x, z in centres))
    said = invoke("probe", "calibrate", tmp_path / "log.txt", "--control", "haas", "--radius-mm", "12.5")
    assert said.stdout.startswith("[calibration]")
    assert "between 0° and 90° ball, lobing and artefact" in said.stderr


@pytest.fixture
def repeating(tmp_path: Path) -> Path:
    """The virtual machine whose finish cut repeats the semi-finish cut, but for its scatter."""
    file = tmp_path / "machine.toml"
    file.write_text(MACHINE.read_text() + "\n[transfer]\n")
    return file


def test_truth_and_estimate_stand_side_by_side(repeating: Path) -> None:
    told = json.loads(run("simulate", JOB, "--machine", repeating, "--seed", "3", "--json"))
    assert len(told["points"]) == 32 and 0.5 < told["true_residual_rms_um"] < 3.0
    assert abs(told["points"][0]["probed_um"] - told["points"][0]["semifinish_truth_um"]) < 1.5


def test_a_finish_cut_that_does_otherwise_leaves_more(repeating: Path) -> None:
    """The preset's does 1 to 5 µm otherwise: that much stays on the part, whatever the touches say."""
    alike, otherwise = (
        json.loads(run("simulate", JOB, "--machine", machine, "--seed", "3", "--json"))["true_residual_rms_um"]
        for machine in (repeating, MACHINE)
    )
    assert alike + 1.0 < otherwise < alike + 5.0


def test_a_study_tells_of_every_way_of_correcting(repeating: Path) -> None:
    told = json.loads(run("simulate", JOB, "--machine", repeating, "--parts", "2", "--json"))
    assert told["parts"] == 2 and told["uncorrected_rms_um"] > 20 * told["loop_rms_um"]


@pytest.fixture
def loop(tmp_path: Path) -> Path:
    """The example's folder, to be edited."""
    shutil.copytree(EXAMPLES, tmp_path / "examples")
    return tmp_path / "examples" / "loop"


def edited(file: Path, old: str, new: str) -> None:
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))


def test_a_probe_that_is_not_calibrated_is_told_with_the_probe_s_file(loop: Path) -> None:
    probing = read_probing(loop / "modbas2.toml")
    (loop / "log.txt").write_text(log_of(probing.plan, np.array([t.contact_mm for t in probing.plan.touches])))
    text = (loop / "probe.toml").read_text()
    (loop / "probe.toml").write_text(text[: text.index("[calibration]")])
    said = run("probe", "read", loop / "modbas2.toml", loop / "log.txt", "--control", "fanuc", status=3)
    assert said.startswith(f"{loop / 'probe.toml'}: PRB-CALIBRATION: the probe of 1.500 mm ball radius")
    assert "trueloop probe calibrate" in said


def test_a_ball_too_large_for_a_corner_is_told_with_job_point_and_feature(loop: Path) -> None:
    edited(loop / "probe.toml", "ball_radius_mm = 1.5", "ball_radius_mm = 15.0")
    edited(loop / "probe.toml", "effective_radius_mm = 1.4946", "effective_radius_mm = 14.9946")
    said = run("probe", "plan", loop / "modbas2.toml", status=3)
    assert said.startswith(f"{loop / 'modbas2.toml'}: PRB-BALL: at point '1' on 'cone' a ball of 30.000 mm overlaps")
    assert "smaller ball" in said


def test_a_virtual_ball_that_does_not_fit_is_told_as_a_real_one(loop: Path) -> None:
    (loop / "large.toml").write_text('preset = "nist"\n[probe]\nball_radius_mm = 15.0\n')
    said = run("simulate", loop / "modbas2.toml", "--machine", loop / "large.toml", status=3)
    assert said.startswith(f"{loop / 'modbas2.toml'}: PRB-BALL: at point '1' on 'cone' a ball of 30.000 mm overlaps")


@pytest.mark.parametrize(
    "directions, says",
    [
        ("calibrated_from_deg = 0", "`calibrated_from_deg` and `calibrated_to_deg` go together"),
        ("calibrated_from_deg = 0\ncalibrated_to_deg = 60", "`calibrated_to_deg` is 60 above"),
        ("calibrated_from_deg = 0\ncalibrated_to_deg = 400", "`calibrated_to_deg` is 400 above"),
    ],
)
def test_directions_that_no_calibration_has_are_told_with_the_machine_file(
    loop: Path, directions: str, says: str
) -> None:
    (loop / "turned.toml").write_text(f'preset = "nist"\n[probe]\nball_radius_mm = 1.5\n{directions}\n')
    said = run("simulate", loop / "modbas2.toml", "--machine", loop / "turned.toml", status=3)
    assert said.startswith(f"{loop / 'turned.toml'}:2: SIM-FILE: 'probe': {says}")


@pytest.mark.parametrize("job_unit, log_per_job", [("mm", 1 / 25.4), ("inch", 25.4)])
def test_a_log_in_the_other_unit_is_told_with_file_line_and_what_to_check(
    loop: Path, job_unit: str, log_per_job: float
) -> None:
    """Inches read as millimetres, and the reverse."""
    edited(loop / "probe.toml", 'unit = "mm"', f'unit = "{job_unit}"')
    contacts = np.array([t.contact_mm for t in read_probing(loop / "modbas2.toml").plan.touches])
    in_job_unit = contacts / (25.4 if job_unit == "inch" else 1.0)
    plan = read_probing(loop / "modbas2.toml").plan
    (loop / "log.txt").write_text(log_of(plan, in_job_unit * log_per_job))
    said = run("probe", "read", loop / "modbas2.toml", loop / "log.txt", "--control", "fanuc", status=3)
    assert said.startswith(f"{loop / 'log.txt'}:1: PRB-OTHER: 32 of 32 touches are at none of the job's 32 points")
    assert "in its unit and diameter mode" in said


def test_the_log_of_a_smaller_part_is_told_as_another_job_s(loop: Path) -> None:
    plan = read_probing(loop / "modbas2.toml").plan
    smaller = np.array([t.contact_mm for t in plan.touches]) - [3.0, 0.0]
    (loop / "log.txt").write_text(log_of(plan, smaller))
    said = run("probe", "read", loop / "modbas2.toml", loop / "log.txt", "--control", "fanuc", status=3)
    assert f"{loop / 'log.txt'}:" in said and "PRB-OTHER: " in said and "is this the log of this job" in said


def test_touches_where_the_approaches_began_are_told_with_file_and_line(loop: Path) -> None:
    probing = read_probing(loop / "modbas2.toml")
    (loop / "log.txt").write_text(log_of(probing.plan, np.array([t.start_mm for t in probing.plan.touches])))
    said = run("probe", "read", loop / "modbas2.toml", loop / "log.txt", "--control", "fanuc", status=3)
    assert said.startswith(
        f"{loop / 'log.txt'}:1: PRB-RETRACT: 32 of 32 touches are where the approach began, 2.000 mm"
    )


def test_a_missing_linuxcnc_is_told_with_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "/nowhere")
    said = run("linuxcnc", "loop", JOB, status=3)
    assert "CTL-LINUXCNC: 4 programs of LinuxCNC are missing" in said
    assert "apt-get install -y --no-install-recommends linuxcnc-uspace linuxcnc-uspace-dev" in said


def test_a_program_that_linuxcnc_stops_is_told_with_file_line_and_block(loop: Path) -> None:
    (loop / "bad.ngc").write_text("G18 G21 G8 G40 G54 G90 G94\nG0 X90 Z5\nG1 X80 F500\nG1 X99999\nM2\n")
    edited(loop / "modbas2.toml", 'finish = "', 'semifinish = "bad.ngc"\nfinish = "')
    said = run("linuxcnc", "loop", loop / "modbas2.toml", status=3)
    assert said.startswith(f"{loop / 'bad.ngc'}:4: CTL-PROGRAM: LinuxCNC stopped: ")
    assert "positive limit" in said and "'G1 X99999'" in said


def test_what_a_log_holds_is_kept_as_what_the_semi_finish_cut_left(loop: Path) -> None:
    plan = (probing := read_probing(loop / "modbas2.toml")).plan
    assert probing.probe.calibration is not None
    normal, error = np.array([touch.normal for touch in plan.touches]), np.linspace(-0.05, 0.09, 32)
    off = plan.approach.allowance_mm + error + probing.probe.calibration.radius_mm(normal)
    contacts = np.array([touch.nominal_mm for touch in plan.touches]) + off[:, None] * normal
    (loop / "log.txt").write_text(log_of(plan, contacts))
    command = ("probe", "read", loop / "modbas2.toml", loop / "log.txt", "--control", "fanuc")
    output = ("-o", loop / "touches.csv")
    invoke(*command, *output, status=0)
    assert not (loop / "trueloop.db").exists()  # without a serial number
    (loop / "touches.csv").unlink()

    said = invoke(*command, *output, "--serial", "17", status=0)
    assert "trueloop.db: 1 part, 1 inspection, 1 cut" in said.stderr and (loop / "touches.csv").is_file()
    store = open_store(loop / "trueloop.db")
    (inspection,) = (kept.value for kept in find(store, Inspection))
    (cut,) = (kept.value for kept in find(store, Cut))
    (link,) = (kept.value for kept in find(store, InspectionLink))
    assert inspection.part.serial == cut.part.serial == "17" and cut.stage is Stage.SEMIFINISH
    assert inspection.sha256 == hashlib.sha256((loop / "log.txt").read_bytes()).hexdigest()
    assert [touch.error_mm for touch in inspection.touches] == pytest.approx(error, abs=0.001)
    assert (link.inspection, link.cut, link.released) == (inspection.identity, cut.identity, False)

    again = invoke(*command, "--serial", "17", "--json", status=0)
    assert json.loads(again.stdout)["store"]["new"] == {} and len(find(store, Inspection)) == 1
    assert "STO-OTHER-PART" in invoke(*command, "--serial", "18", status=3).stderr
    without = invoke(*command, "--serial", "18", "--no-store", "--json", status=0)
    assert "store" not in json.loads(without.stdout) and len(find(store, Inspection)) == 1
