"""`trueloop surface`: files written, what is said, refusals with their status."""

import json
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from trueloop.cli.failure import ExitStatus
from trueloop.cli.main import app
from trueloop.formats.cad import read_face

EXAMPLE = Path(__file__).parents[3] / "examples" / "surface"


def run(*arguments: str | Path, status: int = 0) -> str:
    result = CliRunner().invoke(app, ["surface", *map(str, arguments)])
    assert result.exit_code == status, result.output
    return result.stdout if status == 0 else result.stderr


@pytest.fixture
def job(tmp_path: Path) -> Path:
    folder = tmp_path / "surface"
    shutil.copytree(EXAMPLE, folder)
    return folder / "surface.toml"


def edited(job: Path, old: str, new: str) -> Path:
    text = job.read_text(encoding="utf-8")
    assert old in text
    job.write_text(text.replace(old, new), encoding="utf-8")
    return job


def test_compensate_writes_surface_program_pattern_and_page(job: Path, tmp_path: Path) -> None:
    told = json.loads(run("compensate", job, "-o", tmp_path / "out", "--json"))
    assert {Path(file).name for file in told["files"]} == {
        *("corrected.step", "corrected.ngc", "pattern.json", "pattern.html"),
    }
    assert len(told["parts"]) == 10
    assert 10 < told["largest_um"] < 20
    assert told["uncertainty_um"] < 1
    assert read_face(tmp_path / "out" / "corrected.step").surface.control_mm.shape[2] == 3
    assert b"trueloop corrected: record" in (tmp_path / "out" / "corrected.ngc").read_bytes()
    again = edited(job, 'finish = "finish.ngc"', f'finish = "{tmp_path / "out" / "corrected.ngc"}"')
    assert "CMP-TWICE" in run("compensate", again, "-o", tmp_path / "out2", status=ExitStatus.REFUSED)
    assert not (tmp_path / "out2").exists()


def test_deviations_and_model_write_a_file_a_part(job: Path, tmp_path: Path) -> None:
    edited(job, 'points = ["parts/*.csv"]', 'points = ["parts/S01.csv", "parts/S02.csv"]')
    listed = run("deviations", job, "-o", tmp_path / "out").split()
    assert [Path(file).name for file in listed] == ["S01-deviations.csv", "S02-deviations.csv"]
    rows = (tmp_path / "out" / "S01-deviations.csv").read_text(encoding="utf-8").splitlines()
    assert rows[0] == "# S01: best fit, 625 points"
    assert len(rows) == 627
    model = json.loads(run("model", job, "-o", tmp_path / "out", "--json"))
    assert [part["alignment"] for part in model["parts"]] == ["best fit", "best fit"]
    assert all(part["moran_p"] > 0.01 for part in model["parts"])
    assert "SRF-PARTS" in run("pattern", job, "-o", tmp_path / "out", status=ExitStatus.REFUSED)


def test_two_workers_say_the_same_as_one(job: Path, tmp_path: Path) -> None:
    edited(job, 'points = ["parts/*.csv"]', 'points = ["parts/S0*.csv"]')
    one, two = (
        json.loads(run("pattern", job, "-o", tmp_path / "out", "--json", "--workers", workers))
        for workers in ("1", "2")
    )
    assert one == two


def test_path_prints_a_program_of_a_csv_grid_too(tmp_path: Path) -> None:
    rows = [f"{i + 1},{j + 1},{5 * i},{5 * j},{0.1 * i * j}" for i in range(6) for j in range(6)]
    grid = tmp_path / "grid.csv"
    grid.write_text("\n".join(["row,column,x_mm,y_mm,z_mm", *rows]), encoding="utf-8")
    program = run("path", grid, "--radius-mm", "3", "--scallop-um", "50", "--chord-um", "20")
    assert program.startswith("G17 G21 G40 G90 G94\n")
    assert program.endswith("M2\n")
    assert "SRF-PATH" in run("path", grid, "--radius-mm", "-1", status=ExitStatus.REFUSED)


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("ball_radius_mm = 2.0", "ball_radius_mm = 2.0\nball = 1", "JOB-KEY"),
        ('file = "nominal.step"', 'file = "nominal.stp"', "SRF-CAD"),
        ('file = "nominal.step"', 'file = "nominal.step"\nflip = true', "SRF-SIGN"),
        ('points = ["parts/*.csv"]', 'points = ["measured/*.csv"]', "SRF-FILE"),
        ("ball_radius_mm = 2.0", "ball_radius_mm = 8.0", "SRF-OFF"),
        ("weight = 1.0", "weight = 1.0\nmax_correction_um = 5.0", "CMP-SIZE"),
    ],
)
def test_refusals_have_their_code_and_write_nothing(job: Path, tmp_path: Path, old: str, new: str, code: str) -> None:
    said = run("compensate", edited(job, old, new), "-o", tmp_path / "out", status=ExitStatus.REFUSED)
    assert code in said
    assert "hint:" in said
    assert not (tmp_path / "out").exists()
