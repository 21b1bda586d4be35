"""`trueloop measure next` from the outside: its table, its files, and a log of its program read back."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import run
from tests.support.probing import log_of
from trueloop.controllers.probing.settings import settings_of
from trueloop.formats.measurements.touches_csv import read_touches
from trueloop.jobs.measure.probing import read_listed

EXAMPLES = Path(__file__).parents[3] / "examples"
PROBED = EXAMPLES / "loop" / "modbas2.toml"
MODBAS2 = EXAMPLES / "modbas2" / "job.toml"


def test_untouched_features_come_first_and_the_files_hold_what_is_listed(tmp_path: Path) -> None:
    """MODBAS2's collar and step face were not touched; its dome was, in 23 places."""
    told = json.loads(run("measure", "next", MODBAS2, "--with", "cmm", "-o", tmp_path / "next", "--json"))
    assert [one["feature"] for one in told["measurements"]] == ["collar", "step-face"]
    assert told["criterion"] == "rms_um" and told["measurements"][0]["before"] == told["before"] > told["after"]
    rows = list(csv.DictReader((tmp_path / "next" / "cmm.csv").read_text().splitlines()))
    assert {f"{row['point']} (cmm)" for row in rows} == {one["name"] for one in told["measurements"]}
    program = (tmp_path / "next" / "cmm.dms").read_text()
    assert program.count("PTMEAS/CART") == 2 and "F(collar_" in program
    table = run("measure", "next", MODBAS2, "--with", "cmm")
    assert table.splitlines()[0].split() == ["measure", "with", "minutes", "before", "after"]
    assert f"{told['before']:.2f} µm now, {told['after']:.2f} µm after 0.4 minutes" in table


def test_sizes_are_written_as_a_sheet_to_fill_in(tmp_path: Path) -> None:
    told = json.loads(run("measure", "next", MODBAS2, "--with", "micrometer", "-o", tmp_path / "next", "--json"))
    lines = (tmp_path / "next" / "sheet.csv").read_text().splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert {row["characteristic"] for row in rows} == {one["name"] for one in told["measurements"]} != set()
    assert all(row["value_in"] == "" for row in rows)


@pytest.mark.parametrize("measured", ["gauge", "points"])
def test_the_job_that_new_writes_is_planned_before_anything_is_filled_in(measured: str, tmp_path: Path) -> None:
    """Its file has empty cells: for `measure next` a part not measured yet, for `measure plan` the points to touch."""
    program, folder = EXAMPLES / "shaft" / "finish.nc", tmp_path / "job"
    run("new", program, "--nose-radius-mm", 0.8, "-d", "fanuc-lathe", "--measured", measured, "--folder", folder)
    told = run("measure", "next", folder / "job.toml", "--with", "micrometer")
    assert told.startswith("No file of touches or readings that the job names has a value") and "cylinder-1" in told
    if measured == "points":
        points = len((folder / "touches.csv").read_text().splitlines()) - 1
        assert len(run("measure", "plan", folder / "job.toml").splitlines()) - 1 == points > 10


def test_a_sheet_that_was_filled_in_is_not_written_over(tmp_path: Path) -> None:
    next_sheet = "measure", "next", MODBAS2, "--with", "micrometer", "-o", tmp_path
    whole_sheet = "measure", "sheet", MODBAS2, "-o", tmp_path / "sheet.csv"
    for command in (next_sheet, whole_sheet):
        run(*command)
        run(*command)  # without a value it is written anew
    file = tmp_path / "sheet.csv"
    filled = file.read_text().rstrip("\n") + "1.2\n"
    file.write_text(filled)
    for command in (next_sheet, whole_sheet):
        assert "OUT-INPUT" in run(*command, status=4) and file.read_text() == filled


def test_a_log_of_the_planned_touches_becomes_touches_with_their_signs(tmp_path: Path) -> None:
    """The ball's centre 7 µm further out than planned: material left on.

    By hand, with the calibration of the probe file (effective radius 1.4946 of 1.5 mm, −0.5 µm cosine): 7 + 5.4 µm on
    the collar, at 90°, and 7 + 5.4 + 0.5 µm on the face, at 0°.
    """
    run("measure", "next", PROBED, "--with", "probe", "-c", "fanuc", "-o", tmp_path / "next")
    listed = tmp_path / "next" / "probe.csv"
    probing = read_listed(PROBED, listed)
    assert "G38.2" not in (tmp_path / "next" / "probe.nc").read_text()
    settings = settings_of(probing.part.name, probing.probe.program, probing.probe.probe)
    contact = np.array([touch.contact_mm for touch in probing.plan.touches])
    out = contact + 0.007 * np.array([touch.normal for touch in probing.plan.touches])
    log = tmp_path / "log.txt"
    log.write_text(log_of(probing.plan, out, program=settings))
    touches = tmp_path / "more.csv"
    run("probe", "read", PROBED, log, "-c", "fanuc", "--points", listed, "-o", touches, "--no-store")
    found = read_touches(touches)
    assert {touch.feature for touch in found} == {"collar", "step-face"}
    assert [touch.error_mm for touch in found] == pytest.approx([0.0124, 0.0129], abs=1e-5)


def test_what_is_mistyped_is_named(tmp_path: Path) -> None:
    told = run("measure", "next", MODBAS2, "--with", "micromter", status=2)
    assert "'micromter' is not one of probe, micrometer, cmm" in told
    assert "'probe=0' is not KIND=MINUTES" in run("measure", "next", MODBAS2, "--minutes", "probe=0", status=2)
    listed = tmp_path / "points.csv"
    listed.write_text("point,feature,x_mm,z_mm,normal_x,normal_z\n1,colar,72.6,-159.2,1,0\n")
    told = run("probe", "read", PROBED, listed, "-c", "fanuc", "--points", listed, "--no-store", status=3)
    assert "TCH-PLAN" in told and "'colar'" in told and "points.csv" in told
