"""Damage that files had which were taken for a fault of trueloop, or went through in silence."""

from datetime import UTC, datetime
from pathlib import Path

import pytest

from tests.property.test_readers import DXF, MODEL
from tests.support.places import EXAMPLES
from tests.support.refusals import refused
from trueloop.errors import Code
from trueloop.formats.cad.dxf import read_dxf
from trueloop.formats.jobs.job import read_turned_job
from trueloop.formats.jobs.surface_job import read_surface_job
from trueloop.formats.tables.model_file import read_model
from trueloop.formats.toml_tables import options_from
from trueloop.turned.options import Options
from trueloop_lab.files.virtual_machine_toml import read_virtual_machine


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "file"


def _job(path: Path, table: str, line: str, example: str = "modbas2/job.toml") -> Path:
    """An example's job with a line more, or in place of the one of its key."""
    key = line.split(" =", maxsplit=1)[0]
    text = (EXAMPLES / example).read_text(encoding="utf-8")
    lines = [old for old in text.splitlines() if not old.startswith(f"{key} =")]
    if f"[{table}]" not in lines:
        lines.append(f"[{table}]")
    lines.insert(lines.index(f"[{table}]") + 1, line)
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("table", "line"),
    [
        ("compensation", "weight = true"),
        ("compensation", 'weight = "1"'),
        ("compensation", "max_correction_um = 1e300"),
        ("gauging", "measured_at = 2026"),
        ("gauging", "measured_at = 0001-01-01T00:00:00"),
        ("gauging", "measured_allowance_mm = nan"),
        ("gauging", "ball_radius_mm = inf"),
        ("programs", "parameters = { P46 = inf }"),
        ("programs", "parameters = { P46 = true }"),
        ("programs", "finish_lines = [true, 9]"),
        ("tool", "number = 1e3"),
    ],
)
def test_what_is_no_number_or_date_of_a_job_is_refused_with_its_line(path: Path, table: str, line: str) -> None:
    refusal = refused(read_turned_job, _job(path, table, line))
    assert refusal.code is Code.JOB_KEY
    assert f"{table}.{line.split(' =', maxsplit=1)[0]}" in refusal.message
    assert refusal.place.line == path.read_text().splitlines().index(line) + 1


@pytest.mark.parametrize(
    ("table", "line"), [("cutter", "axis = [0, 0, nan]"), ("gauging", "measured_at = 9"), ("model", "exponent = true")]
)
def test_what_is_no_number_or_date_of_a_surface_is_refused(path: Path, table: str, line: str) -> None:
    refusal = refused(read_surface_job, _job(path, table, line, "surface/surface.toml"))
    assert refusal.code is Code.JOB_KEY and f"{table}.{line.split(' =', maxsplit=1)[0]}" in refusal.message


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            'file = "nominal.step"',
            'file = "nominal.step"\nface = [3, 0]',
            "'surface.face.1': Input should be greater than",
        ),
        (
            'file = "nominal.step"',
            'file = "nominal.step"\nface = "3"',
            "'surface.face': Input should be a valid integer",
        ),
        (
            "[cutter]\nradius_mm = 3.0",
            "[[cutter]]\ntool = 1\nradius_mm = -3.0",
            "'cutter.0.radius_mm': Input should be",
        ),
        ("[cutter]\nradius_mm = 3.0", "[[cutter]]\ntool = 1\nradius = 3.0", "'cutter.0.radius' is no key"),
    ],
)
def test_of_one_value_or_several_the_one_that_is_wrong_is_named(path: Path, old: str, new: str, message: str) -> None:
    whole = (EXAMPLES / "surface/surface.toml").read_text()
    assert old in whole
    path.write_text(whole.replace(old, new))
    refusal = refused(read_surface_job, path)
    assert message in refusal.message and refusal.place.line is not None


def test_a_time_is_read_in_its_zone_and_a_whole_number_is_a_number(path: Path) -> None:
    job = read_turned_job(_job(path, "gauging", "measured_at = 2026-03-01T08:30:00+02:00"))
    assert job.gauging.measured_at == datetime(2026, 3, 1, 6, 30, tzinfo=UTC)
    assert options_from(Options, read_turned_job(_job(path, "compensation", "weight = 1"))).weight == 1.0


@pytest.mark.parametrize("text", ["a = " + "[" * 5000, "a = " + "9" * 5000, "a = 2026-13-45"])
def test_text_that_python_itself_does_not_read_as_toml_is_refused(path: Path, text: str) -> None:
    path.write_text(text)
    assert refused(read_turned_job, path).code is Code.JOB_SYNTAX


@pytest.mark.parametrize(
    ("good", "bad"),
    [
        ('"between_s": [1, 2]', '"between_s": [1]'),
        ("[0, 0.1]", "[0, NaN]"),
        ("[0, 0.1]", '["a", "b"]'),
        ('"error": "EXX"', '"error": "EQX"'),
        ('"breaks": [0, 500]', '"breaks": []'),
    ],
)
def test_a_damaged_model_is_refused_with_its_file(path: Path, good: str, bad: str) -> None:
    assert good in MODEL
    path.write_text(MODEL.replace(good, bad))
    refusal = refused(read_model, path)
    assert refusal.code in (Code.MCH_FILE, Code.MCH_NAME, Code.MCH_BASIS)
    assert refusal.place.file == str(path)


@pytest.mark.parametrize(
    ("good", "bad"),
    [
        ("10\n0\n20\n30\n11", "10\n1e999\n20\n30\n11"),
        ("10\n0\n20\n30\n11", "10\nnan\n20\n30\n11"),
        ("40\n10\n", "40\n1e308\n"),
        ("50\n0\n", "50\ninf\n"),
        ("70\n4\n", "70\nfour\n"),
    ],
)
def test_a_damaged_drawing_is_refused(path: Path, good: str, bad: str) -> None:
    assert good in DXF
    path.write_text(DXF.replace(good, bad))
    refusal = refused(read_dxf, path)
    assert refusal.place.file == str(path) and refusal.code.startswith("GEO-")


def test_an_entity_without_a_layer_is_on_layer_0(path: Path) -> None:
    path.write_text(DXF.replace("LINE\n8\n0\n", "LINE\n"))
    assert len(read_dxf(path, layer="0").features) == len(read_dxf(path).features)


def test_a_nose_that_is_none_is_told_with_its_file(path: Path) -> None:
    nose = "[nose]\nradius_mm = 0.8\nwear_angle_deg = [0, 17, 34]\nwear_um = [0, 80, 0]\n"
    path.write_text(f'preset = "nist"\n{nose}')
    refusal = refused(read_virtual_machine, path)
    assert (refusal.code, refusal.place.file) == (Code.SIM_NOSE, str(path))


def test_a_drawing_whose_header_does_not_end_is_refused(path: Path) -> None:
    path.write_text("0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n")
    assert refused(read_dxf, path).code is Code.GEO_DXF
