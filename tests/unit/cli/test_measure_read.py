"""`trueloop measure read` from the outside."""

import csv
import json
from pathlib import Path

import pytest

from tests.support.cli import invoke, output_of, run
from tests.support.shaft import SHAFT, write_job
from trueloop.formats.inspections.known import read_measured_file
from trueloop.formats.inspections.measured_file import StatedFacts
from trueloop.formats.measurements.touches_csv import read_touches
from trueloop.jobs.measure.measured import read_measured, read_part_of_job

PRINT = """   COMPONENT NO 4                    FEATURE NO 1
SIZE D30.0000   ACTUAL 30.0232   TOL 0.0200   DEV 0.0232
          +++++OUT OF TOL+++++ ERROR  0.0032
   COMPONENT NO 4                    FEATURE NO 2
SIZE D40.0000   ACTUAL 40.0012   TOL 0.0200   DEV 0.0012
   COMPONENT NO 4                    FEATURE NO 3
SIZE 40.0000   ACTUAL 40.0040   TOL 0.0200   DEV 0.0040
POSN X0.0000   ACTUAL 0.0200   DEV 0.0200
"""
POINTS = """G800 N1 X15. Y0. Z-30. I1. J0. K0. O0. U0.01 L0.01
G801 N1 X16.51 Y0. Z-30. R1.5
G800 N2 X0. Y5. Z0. I0. J0. K1. O0. U0.01 L0.01
G801 N2 X0. Y5. Z1.49 R1.5
"""


@pytest.fixture
def job(tmp_path: Path) -> Path:
    return write_job(tmp_path)


def written(folder: Path, text: str, name: str = "out.txt") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_without_a_job_it_shows_what_the_file_says(tmp_path: Path) -> None:
    text = run("measure", "read", written(tmp_path, PRINT), "--unit", "mm")
    assert "print-out of Renishaw macros, utf-8, unit mm, 1 inspection" in text
    assert "30.0232" in text
    assert "+0.0232" in text
    assert "OUT" in text
    assert "matched" not in text


def test_with_a_job_each_value_is_on_a_feature_or_said_why_not(tmp_path: Path, job: Path) -> None:
    assert "3 of 3 matched" in run("measure", "read", written(tmp_path, PRINT), "--unit", "mm", "--job", job)
    file = written(tmp_path, PRINT.replace("SIZE 40.0000   ACTUAL 40.0040", "SIZE 37.0000   ACTUAL 37.0040"))
    text = run("measure", "read", file, "--unit", "mm", "--job", job)
    assert "2 of 3 matched" in text
    assert "no feature has a nominal length of 37.0000 mm" in text
    assert "no errors of the profile, kept: 1" in text
    (found,) = json.loads(run("measure", "read", file, "--unit", "mm", "--job", job, "--json"))["files"]
    (inspection,) = found["inspections"]
    values = {one["characteristic"]: one for one in inspection["values"]}
    assert [inspection[key] for key in ("matched", "not_matched", "kept")] == [2, 1, 1]
    journal = values["1 SIZE D"]
    assert (journal["feature"], journal["by"], journal["within"]) == ("journal", "geometry", False)
    assert journal["deviation"] == pytest.approx(0.0232)
    assert values["3 SIZE"]["candidates"] == []
    assert values["3 POSN X"]["is_error"] is False


def test_touches_are_written_with_their_errors_and_read_back(tmp_path: Path, job: Path) -> None:
    out = tmp_path / "touches.csv"
    output_of("measure", "read", written(tmp_path, POINTS), "--unit", "mm", "--job", job, "-o", out)
    touches = read_touches(out)
    assert [(one.point, one.feature, one.nominal_mm) for one in touches] == [
        ("1", "journal", (15.0, -30.0)),
        ("2", "end", (5.0, 0.0)),
    ]
    assert [one.error_mm for one in touches] == pytest.approx([0.01, -0.01])  # the ball's radius is taken off


def test_readings_are_written_with_the_parts_names_and_limits(tmp_path: Path, job: Path) -> None:
    mapping = written(tmp_path, '[features]\n"3 SIZE" = "shoulder from END"\n', "names.toml")
    out = tmp_path / "readings.csv"
    without = PRINT.replace("40.0040   TOL 0.0200   DEV 0.0040", "40.0040   DEV 0.0040")
    output_of("measure", "read", written(tmp_path, without), "--unit", "mm", "-j", job, "-m", mapping, "-o", out)
    with out.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    keys = ("feature", "from", "quantity", "value_mm", "nominal", "upper_limit")
    assert [tuple(row[key] for key in keys) for row in rows] == [
        ("journal", "", "diameter", "30.0232", "30", "30.02"),
        ("collar", "", "diameter", "40.0012", "40", "40.02"),
        ("shoulder", "end", "length", "40.004", "40", ""),
    ]


def test_written_readings_are_gauge_readings_that_are_read_back_the_same(tmp_path: Path, job: Path) -> None:
    out = tmp_path / "readings.csv"
    file = written(tmp_path, PRINT + "ANG 33.6901   ACTUAL 33.7400   TOL 0.1000   DEV 0.0499\n")
    output_of("measure", "read", file, "--unit", "mm", "--job", job, "-o", out)
    back = read_measured_file(out, StatedFacts())
    assert back.format == "gauge readings (CSV)"
    first = read_measured(file, StatedFacts("mm"), read_part_of_job(job)).on_part[0].matches
    assert first is not None
    sizes = {one.characteristic: one for one in back.inspections[0].readings}
    assert len(sizes) == len(first.readings) == 4
    for match in first.readings:
        before, after = match.reading, sizes[match.reading.characteristic]
        assert (after.feature, after.quantity) == (SHAFT.names[match.feature_index], before.quantity)
        for name in ("actual", "nominal", "lower_limit", "upper_limit"):
            assert getattr(after, name) == pytest.approx(getattr(before, name), abs=1e-6)


def test_touches_and_readings_of_one_file_go_to_two(tmp_path: Path, job: Path) -> None:
    out = tmp_path / "t.csv"
    output_of("measure", "read", written(tmp_path, PRINT + POINTS), "--unit", "mm", "--job", job, "-o", out)
    assert len(read_touches(out)) == 2
    assert (tmp_path / "t-readings.csv").read_text(encoding="utf-8").count("\n") == 4


@pytest.mark.parametrize("name", ["out.txt", "job.toml", "names.toml"])
def test_no_input_is_overwritten(name: str, tmp_path: Path, job: Path) -> None:
    file, mapping = written(tmp_path, PRINT), written(tmp_path, "[features]\n", "names.toml")
    before = (tmp_path / name).read_bytes()
    call = ("measure", "read", file, "--unit", "mm", "--job", job, "-m", mapping, "-o", tmp_path / name)
    assert "OUT-INPUT" in run(*call, status=4)
    assert (tmp_path / name).read_bytes() == before


def test_what_must_not_be_used_is_shown_ends_with_1_and_is_not_written(tmp_path: Path, job: Path) -> None:
    file = written(tmp_path, PRINT.replace("D30.0000   ACTUAL 30", "D12.0000   ACTUAL 12").replace("D40.0", "D7.0"))
    file.write_text(file.read_text(encoding="utf-8").replace("SIZE 40.", "SIZE 37."), encoding="utf-8")
    found = invoke("measure", "read", file, "--unit", "mm", "--job", job, status=1)
    assert "MSR-PART: 0 of 3 values" in found.stdout
    assert "MSR-PART" in run("measure", "read", file, "--unit", "mm", "--job", job, "-o", tmp_path / "r.csv", status=3)
    assert not (tmp_path / "r.csv").exists()


def test_of_several_parts_one_is_chosen(tmp_path: Path, job: Path) -> None:
    file = written(tmp_path, PRINT + PRINT.replace("NO 4", "NO 5").replace("30.0232", "30.0100"))
    call = ("measure", "read", file, "--unit", "mm", "--job", job)
    assert "MSR-SERIAL" in run(*call, "-o", tmp_path / "r.csv", status=3)
    output_of(*call, "--run", 2, "-o", tmp_path / "r.csv")
    assert "30.01," in (tmp_path / "r.csv").read_text(encoding="utf-8")
    assert "MSR-SERIAL" in run(*call, "--serial", "A7", status=3)
    assert "has no inspection run 3" in run(*call, "--run", 3, status=3)


@pytest.mark.parametrize(
    ("mapping", "said"),
    [
        ('[features]\n"1 SIZE D" = "jurnal"\n', "jurnal"),
        ('[features]\n"3 SIZE" = "shoulder from and"\n', "'and'"),
        ("[features\n", "TOML"),
        ('features = "all"\n', "MSR-MAPPING"),
    ],
)
def test_a_list_of_names_that_is_wrong_is_refused(mapping: str, said: str, tmp_path: Path, job: Path) -> None:
    names = written(tmp_path, mapping, "names.toml")
    text = run("measure", "read", written(tmp_path, PRINT), "--unit", "mm", "--job", job, "-m", names, status=3)
    assert said in text
    assert "MSR-MAPPING" in text


def test_files_of_two_parts_are_not_written_as_one(tmp_path: Path, job: Path) -> None:
    text = "feature;quantity;serial;actual [mm];nominal [mm]\njournal;diameter;A{};30,01;30\n"
    first, second = (written(tmp_path, text.format(k), f"part{k}.csv") for k in (1, 2))
    assert "MSR-SERIAL" in run("measure", "read", first, second, "--job", job, "-o", tmp_path / "r.csv", status=3)
    same = written(tmp_path, text.format(1).replace("30,01", "30,02"), "again.csv")
    output_of("measure", "read", first, same, "--job", job, "-o", tmp_path / "r.csv")
    assert (tmp_path / "r.csv").read_text(encoding="utf-8").count("journal") >= 2


def test_an_output_without_a_job_is_a_wrong_command_line(tmp_path: Path) -> None:
    assert "--job" in run("measure", "read", written(tmp_path, PRINT), "--unit", "mm", "-o", tmp_path / "r", status=2)


def test_a_point_is_found_on_its_feature_whatever_lines_stand_around_it(tmp_path: Path, job: Path) -> None:
    file = written(tmp_path, "START\n" + POINTS + "END\n")
    (found,) = json.loads(run("measure", "read", file, "--unit", "mm", "--job", job, "--json"))["files"]
    (inspection,) = found["inspections"]
    assert inspection["spindle_axis"] == "z"
    assert [one["feature"] for one in inspection["values"]] == [SHAFT.names[2], SHAFT.names[-1]]
