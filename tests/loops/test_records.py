"""What every example job records is read back equal, and shown in words."""

import json
from pathlib import Path

import pytest

from tests.support.cli import run
from trueloop.domain.record import Record, sha256_of
from trueloop.formats.record_file import read_record
from trueloop.jobs.surface.job import correct_surface, read_surface
from trueloop.jobs.turned.job import read_job
from trueloop.loops.turned.process_intermittent import compensate

EXAMPLES = Path(__file__).parents[2] / "examples"
JOBS = sorted(path.parent.name for path in EXAMPLES.glob("*/job.toml"))


def _written(folder: Path, record: Record) -> Path:
    file = folder / "record.json"
    file.write_text(record.to_json())
    return file


@pytest.mark.parametrize("name", JOBS)
def test_the_record_of_a_turned_part_is_read_back_equal(name: str, tmp_path: Path) -> None:
    inputs = read_job(EXAMPLES / name / "job.toml").inputs
    record = compensate(inputs).record
    back = read_record(_written(tmp_path, record))
    assert back == record
    (inspection,) = back.inspections
    assert inspection.sha256 in record.inputs_sha256.values()
    assert inspection.count == len(inspection.values) == len(inputs.touches.point)
    assert back.tool is not None and back.tool.corner_radius_mm == inputs.nose_radius_mm
    assert back.program is not None and back.program.sha256 in record.inputs_sha256.values()


def test_a_record_is_shown_in_words(tmp_path: Path) -> None:
    record = compensate(read_job(EXAMPLES / "modbas2" / "job.toml").inputs).record
    shown = run("record", "show", _written(tmp_path, record))
    for words in (
        f"Correction {record.id}",
        "the finish program of a turned part, by touches",
        "finish.nc (ge2000t, inch as stated by the program, line 8)",
        "number 1, nose or corner radius 0.79375 mm",
        "32 touches of MODBAS2, 3.52 in",
        "error curves of 7 features; scatter 1.30 µm, 21 degrees of freedom",
        "correction: at most 150 µm",
        "age of the measurement: at most 24 h",
        *record.decision,
        "13 in the program, each listed in the record",
        f"{record.made_at} by",
    ):
        assert words in shown
    assert all(f"{digest}  {name}" in shown for name, digest in record.inputs_sha256.items())


def test_a_record_is_shown_as_json(tmp_path: Path) -> None:
    record = compensate(read_job(EXAMPLES / "facetst" / "job.toml").inputs).record
    shown = json.loads(run("record", "show", _written(tmp_path, record), "--json"))
    assert shown["inputs_sha256"] == record.inputs_sha256
    assert shown["limits"][1] == {"name": "slope of the correction", "value": 40.0, "unit": "µm/mm"}
    assert (shown["changes"], shown["components"]) == (len(record.changes), 0)
    assert "values" not in shown["inspections"][0]


def test_the_record_of_a_surface_is_read_back_equal_and_names_its_inspections(tmp_path: Path) -> None:
    read = read_surface(EXAMPLES / "surface" / "surface.toml")
    record = correct_surface(read).record
    assert read_record(_written(tmp_path, record)) == record
    assert [one.part.serial for one in record.inspections] == [part.name for part in read.inputs.parts]
    assert {one.sha256 for one in record.inspections} <= set(record.inputs_sha256.values())
    for one in record.inspections:
        rows = (EXAMPLES / "surface" / "parts" / f"{one.part.serial}.csv").read_text().splitlines()[1:]
        assert (one.count, one.values, one.frame) == (len(rows), (), "device")
    shown = run("record", "show", tmp_path / "record.json")
    assert f"pattern of {len(record.inspections)} parts; random errors 2.13 µm" in shown
    assert "radius 3 mm, nose or corner radius 3 mm" in shown


HOLES = "G21 G90\nG81 X100. Y0. Z-5. R2. F100\nX0. Y200.\nG80\nM30\n"


def test_drilled_points_have_a_record(tmp_path: Path) -> None:
    source = tmp_path / "holes.nc"
    source.write_text(HOLES)
    out = tmp_path / "out" / "holes.nc"
    run("machine", "points", source, "-d", "fanuc-mill", "--quadrupole", "1e-4,0", "-o", out)
    record = read_record(out.with_name("holes.record.json"))
    assert record.id in out.read_text()
    assert record.inputs_sha256 == {"program": sha256_of(HOLES.encode())}
    assert [(word.line, word.before, word.after) for word in record.changes] == [
        (2, "100.", "99.990"),
        (3, "200.", "200.020"),
    ]
    assert record.edits == 2 and record.options["limit_mm"] == 0.15
    assert "quadrupole" in run("record", "show", out.with_name("holes.record.json"))


def test_a_displaced_program_has_a_record(tmp_path: Path) -> None:
    source = tmp_path / "part.ngc"
    source.write_text("G21 G90\nG1 X10. Y0. Z0. F100\nM2\n")
    out = tmp_path / "moved.ngc"
    run("nc", "map", source, "--shift", "0.01,0,0", "-o", out)
    record = read_record(tmp_path / "moved.record.json")
    assert record.id in out.read_text()
    assert (record.edits, record.options["limit_mm"]) == (1, None)
    assert record.program is not None and (record.program.name, record.program.unit) == ("part.ngc", "mm")
    shown = run("record", "show", tmp_path / "moved.record.json")
    assert "correction: no limit" in shown and "largest correction 10.0 µm" in shown
