"""`trueloop compensate` and `trueloop demo`: what is written and what is said."""

import csv
import io
import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ndtri, stdtrit
from typer.testing import Result

from tests.support.cli import invoke
from trueloop.cli.terminal import ExitStatus
from trueloop.domain.record import sha256_of
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.process_intermittent import compensate

EXAMPLES = Path(__file__).parents[3] / "examples"
JOB = EXAMPLES / "modbas2" / "job.toml"
FILES = ["corrected.nc", "offsets.nc", "table.csv", "report.html", "report.json", "record.json"]


def _run(*arguments: str) -> Result:
    return invoke(*arguments, status=ExitStatus.DONE)


@pytest.fixture(scope="module")
def correction() -> Correction:
    """The same job by way of Python."""
    return compensate(read_job(JOB).inputs)


@pytest.fixture(scope="module")
def output(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where the command put its results; what it said lies beside them."""
    folder = tmp_path_factory.mktemp("results")
    for name, arguments in (("said.txt", ()), ("said.json", ("--json",))):
        result = _run("compensate", str(JOB), "--output", str(folder / "modbas2"), *arguments)
        (folder / name).write_text(result.stdout)
    return folder / "modbas2"


def test_the_files_hold_the_correction(output: Path, correction: Correction) -> None:
    assert sorted(path.name for path in output.iterdir()) == sorted(FILES)
    assert (output / "corrected.nc").read_bytes() == correction.corrected_program
    assert (output / "offsets.nc").read_bytes() == correction.offsets_program
    record = json.loads((output / "record.json").read_text())
    assert record["id"] == correction.record.id
    assert record["inputs_sha256"]["touches.csv"] == sha256_of((JOB.parent / "touches.csv").read_bytes())
    assert correction.record.id in (output / "report.html").read_text()
    rows = list(csv.DictReader(io.StringIO((output / "table.csv").read_text())))
    assert [row["feature"] for row in rows] == list(correction.table.feature)


def test_the_summary_has_a_line_a_feature_and_calls_a_prediction_one(output: Path, correction: Correction) -> None:
    lines = (output.parent / "said.txt").read_text().splitlines()
    assert lines[0] == f"MODBAS2, 3.52 in, correction {correction.record.id}"
    names = [line.split()[0] for line in lines[4:11]]
    assert names == list(correction.profile.names)
    dome = lines[10].split()
    on_dome = correction.touches.of_feature(6)
    assert float(dome[2]) == pytest.approx(
        1000 * np.sqrt(np.mean(correction.prediction.before_mm[on_dome] ** 2)), abs=0.05
    )
    assert float(dome[4]) == pytest.approx(
        1000 * np.sqrt(np.mean(correction.prediction.after_mm[on_dome] ** 2)), abs=0.05
    )
    assert any(line.startswith("+ is material left on. Predicted: ") for line in lines)
    assert f"- {correction.decision.x.words}" in lines
    assert lines[-8] == "Run corrected.nc. Written:"
    assert lines[-7:-1] == [f"  {output / name}" for name in FILES]
    assert lines[-1].startswith("kept in no store: the part has no serial number")


def test_json_says_the_same_to_machines(output: Path, correction: Correction) -> None:
    said = json.loads((output.parent / "said.json").read_text())
    assert (said["part"], said["record_id"]) == ("MODBAS2, 3.52 in", correction.record.id)
    assert said["program_to_run"] == "corrected.nc"
    assert said["files"] == [str(output / name) for name in FILES]
    assert [feature["feature"] for feature in said["features"]] == list(correction.profile.names)
    cone = said["features"][2]
    on_cone = correction.touches.of_feature(2)
    assert cone["touches"] == len(on_cone) == 5
    worst = 1000 * correction.prediction.before_mm[on_cone].max()
    assert cone["before_worst_um"] == pytest.approx(worst)
    k = stdtrit(correction.model.degrees_of_freedom, 0.975)  # Student's, two-sided 95 %
    budget = correction.prediction.budget
    u = 1000 * np.hypot(k * budget.found_mm, ndtri(0.975) * budget.stated_mm)[on_cone].max()
    assert cone["predicted_expanded_u_um"] == pytest.approx(u)
    assert said["features"][0]["before_rms_um"] is None
    assert said["decision"] == {"x": correction.decision.x.words, "z": correction.decision.z.words, "readings": ""}


def test_the_output_folder_of_the_job_is_relative_to_the_job(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shutil.copytree(EXAMPLES / "modbas2", tmp_path / "parts" / "modbas2")
    monkeypatch.chdir(tmp_path)
    said = json.loads(_run("compensate", "parts/modbas2/job.toml", "--json").stdout)
    assert said["files"] == [f"out/modbas2/{name}" for name in FILES]
    assert sorted(path.name for path in (tmp_path / "out" / "modbas2").iterdir()) == sorted(FILES)


def test_programs_keep_the_ending_of_their_source(tmp_path: Path) -> None:
    _run("compensate", str(EXAMPLES / "linuxcnc" / "job.toml"), "-o", str(tmp_path))
    assert {path.name for path in tmp_path.iterdir()} == {
        "corrected.ngc", "offsets.ngc", "table.csv", "report.html", "report.json", "record.json"
    }  # fmt: skip
    told = set(re.findall(r"(?:corrected|offsets)\.\w+", (tmp_path / "report.html").read_text()))
    assert told == {"corrected.ngc", "offsets.ngc"}


@pytest.mark.parametrize("part", ["facetst", "modbas2", "piecs11"])
def test_the_demo_runs_every_part_into_a_folder_of_its_name(
    part: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    said = json.loads(_run("demo", part, "--json").stdout)
    assert said["part"].lower().startswith(part)
    assert said["files"] == [str(Path("out") / part / name) for name in FILES]
    assert sorted(path.name for path in (tmp_path / "out" / part).iterdir()) == sorted(FILES)


def test_the_demo_without_a_name_is_modbas2(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert _run("demo").stdout.startswith("MODBAS2, 3.52 in, ")
