"""Every real file is read, or refused with its place and a reason; no fault of ours reaches a user."""

import csv
import json
from pathlib import Path
from typing import Any

import pytest

from tests.support.cli import invoke
from tests.support.probing import EXAMPLES

FOLDERS = ("public/cmm", "public/qif", "public/qdas", "public/probe", "public/formats", "made/dmis")
NOT_READ = {".md", ".py", ".h"}
"""No inspections: what is told about the files, what makes them, a program."""
MODBAS2 = EXAMPLES / "modbas2" / "job.toml"


def files(corpus: Path) -> list[Path]:
    found = [path for folder in FOLDERS for path in sorted((corpus / "data" / folder).rglob("*")) if path.is_file()]
    return [path for path in found if path.suffix not in NOT_READ]


def inspections(path: Path, *options: object) -> list[dict[str, Any]]:
    result = invoke("measure", "read", path, "--json", *options)
    assert result.exit_code in (0, 1), result.output
    (file,) = json.loads(result.stdout)["files"]
    found: list[dict[str, Any]] = file["inspections"]
    return found


@pytest.mark.corpus
@pytest.mark.parametrize("options", [(), ("--unit", "mm"), ("--unit", "mm", "--job", MODBAS2)])
def test_every_file_is_read_or_refused_with_its_place_and_a_reason(corpus: Path, options: tuple[object, ...]) -> None:
    found = files(corpus)
    assert len(found) >= 15
    read = []
    for path in found:
        result = invoke("measure", "read", path, "--json", *options)
        assert result.exit_code in (0, 1, 3), f"{path.name}: {result.output}"
        if result.exit_code == 3:
            error = json.loads(result.stderr)["error"]
            assert error["place"]["file"] == str(path)
            assert error["hint"]
            continue
        read.append(path.name)
        (file,) = json.loads(result.stdout)["files"]
        assert file["format"]
        for one in file["inspections"]:
            assert len(one["values"]) == one["count"]
    assert len(read) >= (3 if not options else 5), read


@pytest.mark.corpus
def test_the_points_of_a_dmis_file_are_on_the_features_of_modbas2_with_the_errors_that_were_put_in(
    corpus: Path,
) -> None:
    folder = corpus / "data" / "made" / "dmis"
    (found,) = inspections(folder / "modbas2-semifinish.dmo", "--job", MODBAS2)
    with (folder / "modbas2-semifinish.truth.csv").open(encoding="utf-8") as file:
        truth = {row["feature"]: row for row in csv.DictReader(file)}
    with (EXAMPLES / "modbas2" / "touches.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    features = {f"P-{int(row['point']):02d}": row["feature"] for row in rows}
    touches = [one for one in found["values"] if one["quantity"] == "touch"]
    assert len(touches) == len(truth) == 32
    for one in touches:
        assert one["feature"] == features[one["characteristic"]]
        stated_um = float(truth[one["characteristic"]]["deviation_um"])
        assert one["deviation"] * 1000.0 == pytest.approx(stated_um, abs=0.15)  # coordinates to 0.1 µm in the file
    assert found["spindle_axis"] == "z"


@pytest.mark.corpus
def test_the_diameters_of_a_shaft_in_inch_are_those_of_its_truth(corpus: Path) -> None:
    folder = corpus / "data" / "made" / "dmis"
    runs = inspections(folder / "shaft-two-runs.dmo")
    with (folder / "shaft-two-runs.truth.csv").open(encoding="utf-8") as file:
        truth = list(csv.DictReader(file))
    found = [
        (str(one["run"]), value["feature"], value["actual"], value["deviation"], value["within"])
        for one in runs
        for value in one["values"]
        if value["quantity"] == "diameter"
    ]
    assert len(found) == len(truth)
    for (run, feature, actual, deviation, within), row in zip(found, truth, strict=True):
        assert (run, feature, str(within)) == (row["run"], row["feature"], row["in_tolerance"])
        assert actual == pytest.approx(float(row["actual_diameter_mm"]), abs=1e-5)
        assert deviation * 1000.0 == pytest.approx(float(row["deviation_um"]), abs=0.01)
