"""`trueloop surface`: files written, what is said, refusals with their status."""

import json
import shutil
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.support.cli import run
from trueloop.arrays import Array
from trueloop.cli.terminal import ExitStatus
from trueloop.domain.record import sha256_of
from trueloop.formats.cad.kernel import kernel
from trueloop.formats.cad.step import CadFace, named_faces, read_faces
from trueloop.jobs.surface.job import read_surface

EXAMPLE = Path(__file__).parents[3] / "examples" / "surface"


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


@pytest.fixture(scope="module")
def corrected(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], Path]:
    """What correcting the example says, and the folder it writes."""
    folder = tmp_path_factory.mktemp("corrected")
    return json.loads(run("surface", "compensate", EXAMPLE / "surface.toml", "-o", folder, "--json")), folder


def test_compensate_writes_surface_program_pattern_maps_and_record(corrected: tuple[dict[str, Any], Path]) -> None:
    told, folder = corrected
    names = [f"S{k:02d}" for k in range(1, 11)]
    assert {Path(file).name for file in told["files"]} == {
        *("corrected.step", "corrected.ngc", "pattern.json", "pattern.html", "maps.svg", "record.json"),
        *(f"{name}-maps.csv" for name in names),
    }
    assert [part["name"] for part in told["parts"]] == names
    assert 10 < told["largest_um"] < 20
    assert told["uncertainty_um"] < 1
    assert "age was not checked" in told["notes"][0]
    assert named_faces(folder / "corrected.step")[0].surface.control_mm.shape[2] == 3


def test_the_record_says_what_was_corrected_by_what(corrected: tuple[dict[str, Any], Path]) -> None:
    told, folder = corrected
    record = json.loads((folder / "record.json").read_text(encoding="utf-8"))
    assert record["id"] == told["record"]
    inputs = {"surface.toml", "nominal.step", "finish.ngc", *(f"parts/S{k:02d}.csv" for k in range(1, 11))}
    assert set(record["inputs_sha256"]) == inputs
    assert all(record["inputs_sha256"][name] == sha256_of((EXAMPLE / name).read_bytes()) for name in inputs)
    assert np.max(np.abs(record["model"]["control_um"])) > told["largest_um"] - 0.1
    assert len(record["model"]["parts"]) == 10
    assert len(record["changes"]) > 2000
    for name in ("corrected.step", "corrected.ngc"):
        assert f"trueloop corrected: record {record['id']}".encode() in (folder / name).read_bytes()


def test_maps_of_a_part_add_up(corrected: tuple[dict[str, Any], Path]) -> None:
    """Measured is deterministic and random; what is predicted is as small as the part's own share and noise."""
    rows = np.genfromtxt(corrected[1] / "S04-maps.csv", delimiter=",", skip_header=1, names=True)
    assert len(rows) == 625
    np.testing.assert_allclose(rows["measured_um"], rows["deterministic_um"] + rows["random_um"], atol=2e-4)
    assert np.std(rows["predicted_um"]) < 0.6 * np.std(rows["measured_um"])
    assert np.std(rows["predicted_um"]) > np.std(rows["random_um"])
    np.testing.assert_allclose(rows["nx"] ** 2 + rows["ny"] ** 2 + rows["nz"] ** 2, 1.0, atol=1e-6)
    assert np.mean(rows["uncertainty_um"]) == pytest.approx(corrected[0]["uncertainty_um"], rel=0.3)


@pytest.mark.parametrize(
    ("old", "new"), [('file = "nominal.step"', 'file = "{}.step"'), ('finish = "finish.ngc"', 'finish = "{}.ngc"')]
)
def test_what_was_corrected_once_is_not_corrected_again(
    corrected: tuple[dict[str, Any], Path], job: Path, tmp_path: Path, old: str, new: str
) -> None:
    again = edited(job, old, new.format(corrected[1] / "corrected"))
    said = run("surface", "compensate", again, "-o", tmp_path / "out", status=ExitStatus.REFUSED)
    assert "CMP-TWICE" in said
    assert corrected[0]["record"] in said
    assert not (tmp_path / "out").exists()


def test_deviations_and_model_write_a_file_a_part(job: Path, tmp_path: Path) -> None:
    edited(job, 'points = ["parts/*.csv"]', 'points = ["parts/S01.csv", "parts/S02.csv"]')
    listed = run("surface", "deviations", job, "-o", tmp_path / "out").split()
    assert [Path(file).name for file in listed] == ["S01-deviations.csv", "S02-deviations.csv"]
    rows = (tmp_path / "out" / "S01-deviations.csv").read_text(encoding="utf-8").splitlines()
    assert rows[0] == "# S01: best fit, 625 points"
    assert len(rows) == 627
    model = json.loads(run("surface", "model", job, "-o", tmp_path / "out", "--json"))
    assert [part["alignment"] for part in model["parts"]] == ["best fit", "best fit"]
    assert all(part["moran_p"] > 0.01 for part in model["parts"])
    rows = (tmp_path / "out" / "S01-model.csv").read_text(encoding="utf-8").splitlines()
    assert rows[1] == "u,v,x_mm,y_mm,z_mm,measured_um,deterministic_um,random_um"
    assert len(rows) == 627


def test_one_part_is_corrected_by_what_it_tells_of_others(job: Path, tmp_path: Path) -> None:
    """Parts of the example differ by 0.8 µm about a pattern of 4.3 µm. Where they differ by far more, one part tells
    nothing of the next.
    """
    many = json.loads(run("surface", "pattern", job, "-o", tmp_path / "many", "--json"))
    edited(job, 'points = ["parts/*.csv"]', 'points = ["parts/S04.csv"]')
    one = json.loads(run("surface", "compensate", job, "-o", tmp_path / "one", "--json"))
    assert any(finding.startswith("SRF-PARTS: how much parts differ is not seen in") for finding in one["findings"])
    columns = ("pattern_um", "uncertainty_um")
    told, of_one = (_maps(tmp_path / folder / "S04-maps.csv", columns) for folder in ("many", "one"))
    off_um = np.abs(told[:, 0] - of_one[:, 0])
    assert np.mean(off_um <= np.hypot(told[:, 1], of_one[:, 1])) > 0.9
    assert np.sqrt(np.mean(off_um**2)) < 0.3 * np.sqrt(np.mean(told[:, 0] ** 2))
    assert many["uncertainty_um"] < one["uncertainty_um"]
    edited(job, "target_um = 1.0", "part_to_part_um = 50")
    none = json.loads(run("surface", "pattern", job, "-o", tmp_path / "none", "--json"))
    assert none["largest_um"] < 1e-6


def _maps(file: Path, columns: tuple[str, ...]) -> Array:
    rows = [line.split(",") for line in file.read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    return np.array([[float(row[rows[0].index(column)]) for column in columns] for row in rows[1:]])


def test_points_measured_twice_are_averaged_and_told_by_every_command(job: Path, tmp_path: Path) -> None:
    """A scan, its columns without a grid, in which one point stands twice."""
    file = job.parent / "parts" / "S01.csv"
    rows = [row.split(",", 2)[2] for row in file.read_text(encoding="utf-8").splitlines()]
    file.write_text("\n".join([*rows, rows[78]]), encoding="utf-8")
    edited(job, 'points = ["parts/*.csv"]', 'points = ["parts/S01.csv"]')
    for command in ("deviations", "model"):
        told = json.loads(run("surface", command, job, "-o", tmp_path / "out", "--json"))
        (finding,) = [f for f in told["findings"] if f.startswith("SRF-DUPLICATE")]
        assert "points 78 and 626" in finding
        assert "SRF-DUPLICATE" in run("surface", command, job, "-o", tmp_path / "out")
    assert len((tmp_path / "out" / "S01-deviations.csv").read_text(encoding="utf-8").splitlines()) == 627


def test_two_workers_say_the_same_as_one(job: Path, tmp_path: Path) -> None:
    edited(job, 'points = ["parts/*.csv"]', f"points = {[f'parts/S0{k}.csv' for k in range(1, 5)]}")
    one, two = (
        json.loads(run("surface", "pattern", job, "-o", tmp_path / "out", "--json", "--workers", workers))
        for workers in ("1", "2")
    )
    assert one == two


def test_path_prints_a_program_of_a_csv_grid_too(tmp_path: Path) -> None:
    rows = [f"{i + 1},{j + 1},{5 * i},{5 * j},{0.1 * i * j}" for i in range(6) for j in range(6)]
    grid = tmp_path / "grid.csv"
    grid.write_text("\n".join(["row,column,x_mm,y_mm,z_mm", *rows]), encoding="utf-8")
    program = run("surface", "path", grid, "--radius-mm", "3", "--scallop-um", "50", "--chord-um", "20")
    assert program.startswith("G17 G21 G40 G90 G94\n")
    assert program.endswith("M2\n")
    assert "--radius-mm" in run("surface", "path", grid, "--radius-mm", "-1", status=ExitStatus.USAGE)


def test_a_scan_of_many_scattered_points_is_written_point_by_point(job: Path, tmp_path: Path) -> None:
    """10⁵ points on a face of CAD: no step of it asks the kernel point by point."""
    surface, rng = named_faces(job.parent / "nominal.step")[0].surface, np.random.default_rng(6)
    u, v = rng.uniform(0.001, 0.999, (2, 100_000))
    error = 0.01 * np.sin(9 * u) + rng.normal(0, 0.002, len(u))
    points = surface.point_mm(u, v) + error[:, None] * surface.normal(u, v)
    np.savetxt(job.parent / "scan.csv", points, "%.7f", ",", header="x_mm,y_mm,z_mm", comments="")
    edited(job, 'points = ["parts/*.csv"]', 'points = ["scan.csv"]')
    edited(edited(job, "ball_radius_mm = 2.0", "ball_radius_mm = 0.0"), 'alignment = "best-fit"', 'alignment = "datum"')
    run("surface", "deviations", job, "-o", tmp_path / "out")
    rows = np.loadtxt(tmp_path / "out" / "scan-deviations.csv", delimiter=",", skiprows=2, usecols=range(2, 11))
    np.testing.assert_allclose(rows[:, -1], 1e3 * error, atol=2e-3)
    np.testing.assert_allclose(rows[:, :2], np.column_stack([u, v]), atol=1e-6)


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("ball_radius_mm = 2.0", "ball_radius_mm = 2.0\nball = 1", "JOB-KEY"),
        ('file = "nominal.step"', 'file = "nominal.stp"', "SRF-CAD"),
        ('file = "nominal.step"', 'file = "nominal.step"\nflip = true', "SRF-SIGN"),
        ('points = ["parts/*.csv"]', 'points = ["measured/*.csv"]', "SRF-FILE"),
        ("target_um = 1.0", f"exclude = {[f'S{k:02}' for k in range(1, 11)]}", "SRF-PARTS"),
        ("ball_radius_mm = 2.0", "ball_radius_mm = 8.0", "SRF-OFF"),
    ],
)
def test_refusals_have_their_code_and_write_nothing(job: Path, tmp_path: Path, old: str, new: str, code: str) -> None:
    refused(edited(job, old, new), tmp_path, code)


@pytest.mark.parametrize(
    ("old", "new", "code", "override"),
    [
        ("weight = 1.0", "weight = 1.0\nmax_correction_um = 5.0", "CMP-SIZE", "max_correction_um"),
        ("weight = 1.0", "weight = 1.0\nmax_slope_um_per_mm = 0.5", "CMP-SLOPE", "max_slope_um_per_mm"),
        ("weight = 1.0", "weight = 1.0\nmax_scatter_um = 1.0", "CMP-SCATTER", "max_scatter_um"),
        ("[model]", "measured_at = 2001-02-03T04:05:06Z\n[model]", "CMP-AGE", "max_age_hours"),
        ("[model]", f'program_sha256 = "{"0" * 64}"\n[model]', "CMP-OTHER-PROGRAM", "program_sha256"),
    ],
)
def test_what_must_not_be_applied_is_refused_with_its_override(
    job: Path, tmp_path: Path, old: str, new: str, code: str, override: str
) -> None:
    edited(job, 'points = ["parts/*.csv"]', 'points = ["parts/S0*.csv"]')
    said = refused(edited(job, old, new), tmp_path, code)
    assert override in said.split("override:")[1]


def test_the_program_that_cut_the_parts_and_parts_of_today_are_taken(job: Path, tmp_path: Path) -> None:
    edited(job, 'points = ["parts/*.csv"]', 'points = ["parts/S0*.csv"]')
    digest = sha256_of((job.parent / "finish.ngc").read_bytes())
    edited(job, "[model]", f'measured_at = {datetime.now(UTC).isoformat()}\nprogram_sha256 = "{digest}"\n[model]')
    assert json.loads(run("surface", "compensate", job, "-o", tmp_path / "out", "--json"))["notes"] == []


def _without(rows: list[str]) -> list[str]:
    return [row for row in rows if not row.startswith(("3,", "4,", "5,", "6,", "7,", "8,", "9,"))]


def _moved(row: str, column: int, by_mm: float) -> str:
    cells = row.split(",")
    cells[column] = str(float(cells[column]) + by_mm)
    return ",".join(cells)


def _scaled(rows: list[str]) -> list[str]:
    return [",".join([*row.split(",")[:2], *(f"{float(x) / 25.4:.8f}" for x in row.split(",")[2:])]) for row in rows]


@pytest.mark.parametrize(
    ("code", "spoilt"),
    [
        ("SRF-HOLES", _without),
        ("SRF-FILE", lambda rows: [*rows, rows[7]]),
        ("SRF-DUPLICATE", lambda rows: [*rows[:-1], ",".join(["25,25", *rows[7].split(",")[2:]])]),
        ("SRF-UNIT", _scaled),
        ("SRF-OFF", lambda rows: [*rows[:-1], _moved(rows[-1], 4, 12.0)]),
        ("SRF-OUTSIDE", lambda rows: [*rows[:-1], _moved(rows[-1], 3, 2.0)]),
        ("SRF-POINTS", lambda rows: [row.partition(",")[2].partition(",")[2] for row in rows[:10]]),
        ("SRF-FILE", lambda rows: [*rows[:5], "1,6,a,b,c", *rows[6:]]),
    ],
)
def test_spoilt_measurements_are_refused(
    job: Path, tmp_path: Path, code: str, spoilt: Callable[[list[str]], list[str]]
) -> None:
    file = job.parent / "parts" / "S03.csv"
    head, *rows = file.read_text(encoding="utf-8").splitlines()
    rows = spoilt(rows)
    head = head if rows[0].count(",") == 4 else "x_mm,y_mm,z_mm"
    file.write_text("\n".join([head, *rows]) + "\n", encoding="utf-8")
    assert "S03" in refused(job, tmp_path, code)


def test_a_point_in_the_bore_of_a_trimmed_face_is_refused(tmp_path: Path) -> None:
    """A plate of 50 × 50 mm with a bore of 20 mm in its middle: its top is touched where there is no material."""
    job, at = bored_job(tmp_path), np.linspace(1, 49, 17)
    measured(tmp_path / "S1.csv", at, at, clear_mm=10.1)
    assert "S1-deviations.csv" in run("surface", "deviations", job, "-o", tmp_path / "good")
    measured(tmp_path / "S1.csv", at, at, clear_mm=0.0)
    said = run("surface", "deviations", job, "-o", tmp_path / "out", status=ExitStatus.REFUSED)
    assert "SRF-OUTSIDE" in said
    assert not (tmp_path / "out").exists()


def test_normals_that_the_program_contradicts_are_refused_by_every_command(job: Path, tmp_path: Path) -> None:
    edited(job, 'file = "nominal.step"', 'file = "nominal.step"\nflip = true')
    for command in ("deviations", "model", "pattern", "compensate"):
        said = run("surface", command, job, "-o", tmp_path / "out", status=ExitStatus.REFUSED)
        assert "SRF-SIGN" in said and "surface.flip" in said


def test_the_dialect_of_a_surface_program_is_that_of_its_text(job: Path, tmp_path: Path) -> None:
    """Siemens words are taken for Siemens; a program that several controls understand is not guessed."""
    source = (job.parent / "finish.ngc").read_text(encoding="utf-8")
    (job.parent / "finish.mpf").write_text(f"N5 R1=3 ; Radius\n{source}".replace("G21", "G71"), encoding="utf-8")
    edited(job, 'points = ["parts/*.csv"]', 'points = ["parts/S01.csv"]')
    edited(job, 'finish = "finish.ngc"', 'finish = "finish.mpf"')
    assert read_surface(job).inputs.program.dialect.name == "siemens"  # type: ignore[union-attr]
    (job.parent / "finish.mpf").write_text(source, encoding="utf-8")
    said = run("surface", "deviations", job, "-o", tmp_path / "out", status=ExitStatus.REFUSED)
    assert "NC-DIALECT" in said and 'program.dialect = "linuxcnc" or program.dialect = "' in " ".join(said.split())


def test_sampling_prints_the_grid_for_a_ball() -> None:
    """50 mm square, a little longer along its waves; ball of 2 mm [MPM §7: 25 × 25]."""
    nominal = EXAMPLE / "nominal.step"
    told = json.loads(run("surface", "sampling", nominal, "--ball-radius-mm", "2", "--json"))
    assert 26 <= told["rows"] <= 28 and 26 <= told["columns"] <= 28
    assert (told["step_mm"], told["shortest_wave_mm"], told["reaches_everywhere"]) == (2.0, 4.0, True)
    said = run("surface", "sampling", nominal, "--ball-radius-mm", "60", "--step-mm", "5")
    assert "5 mm apart: it resolves waves of 10 mm" in said and "does not reach the ground" in said
    assert "--step-mm" in run(
        "surface", "sampling", nominal, "--ball-radius-mm", "2", "--step-mm", "0", status=ExitStatus.USAGE
    )


def test_a_missing_job_points_to_the_page_of_surface_jobs(tmp_path: Path) -> None:
    said = run("surface", "compensate", tmp_path / "jop.toml", status=ExitStatus.REFUSED)
    assert "JOB-MISSING" in said and "docs/surface.md" in said


def test_the_corrected_surface_of_a_bored_plate_is_bored(tmp_path: Path) -> None:
    job, at = bored_job(tmp_path), np.linspace(1, 49, 17)
    for k in range(1, 5):
        measured(tmp_path / f"S{k}.csv", at, at, clear_mm=10.1, seed=k)
    said = run("surface", "compensate", job, "-o", tmp_path / "out")
    assert "not trimmed" not in said
    face = named_faces(tmp_path / "out" / "corrected.step")[0]
    (u0, u1), (v0, v1) = face.surface.domain
    u, v = (u0 + u1) / 2 + (u1 - u0) * np.array([0.0, 0.19, 0.21]), np.full(3, (v0 + v1) / 2)
    assert face.trimmed_away(u, v).tolist() == [True, True, False]


def test_a_corrected_surface_that_cannot_be_trimmed_is_written_whole_and_said_to_be(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    job, at = bored_job(tmp_path), np.linspace(1, 49, 17)
    for k in range(1, 5):
        measured(tmp_path / f"S{k}.csv", at, at, clear_mm=10.1, seed=k)
    monkeypatch.setattr("trueloop.formats.cad.step.trimmed_face", lambda *_: None)
    said = run("surface", "compensate", job, "-o", tmp_path / "out")
    assert "corrected.step is the whole patch, not trimmed" in " ".join(said.split())
    assert named_faces(tmp_path / "out" / "corrected.step")[0].loops == ()


def bored_job(folder: Path) -> Path:
    """A job for the top of a bored plate, its parts S1.csv and so on."""
    faces = plate_with_bore(folder / "plate.step")
    top = next(face.number for face in faces if np.allclose(face.surface.control_mm[..., 2], 10.0))
    job = folder / "job.toml"
    job.write_text(
        f'name = "plate"\n[surface]\nfile = "plate.step"\nface = {top}\n[gauging]\npoints = ["S*.csv"]\n',
        encoding="utf-8",
    )
    return job


def measured(path: Path, x: Array, y: Array, *, clear_mm: float, seed: int = 0) -> None:
    """A grid on the plate, wavy by 4 µm, without the places nearer to the bore's middle than `clear_mm`."""
    rng = np.random.default_rng(seed)
    lines = [
        f"{i},{j},{a},{b},{10.002 + 0.004 * np.sin(a / 9) + rng.normal(0, 0.001):.6f}"
        for i, a in enumerate(x, 1) for j, b in enumerate(y, 1) if np.hypot(a - 25, b - 25) > clear_mm
    ]  # fmt: skip
    path.write_text("\n".join(["row,column,x_mm,y_mm,z_mm", *lines]), encoding="utf-8")


def refused(job: Path, tmp_path: Path, code: str) -> str:
    said = run("surface", "compensate", job, "-o", tmp_path / "out", status=ExitStatus.REFUSED)
    assert code in said
    assert "hint:" in said
    assert not (tmp_path / "out").exists()
    return said


def plate_with_bore(path: Path) -> list[CadFace]:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Cut
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeBox, BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
    from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer

    kernel()
    bore = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(25, 25, -5), gp_Dir(0, 0, 1)), 10.0, 30.0).Shape()
    plate = BRepAlgoAPI_Cut(BRepPrimAPI_MakeBox(50.0, 50.0, 10.0).Shape(), bore).Shape()
    writer = STEPControl_Writer()
    writer.Transfer(plate, STEPControl_StepModelType.STEPControl_AsIs)
    writer.Write(str(path))
    return read_faces(path)


def test_a_surface_is_simulated_from_the_command_line(tmp_path: Path) -> None:
    job = EXAMPLE / "simulate.toml"
    told = json.loads(run("surface", "simulate", job, "--machine", EXAMPLE / "mill.toml", "--parts", "3", "--json"))
    assert told["parts"] == 3 and told["places_measured"] == 625
    assert told["corrected_truth_um"] < 0.6 * told["programmed_truth_um"]
    (tmp_path / "mill.toml").write_text("[process]\npattern_mm = 0.008\n")
    said = run("surface", "simulate", job, "--machine", tmp_path / "mill.toml", status=ExitStatus.REFUSED)
    assert "SIM-FILE" in said and "mill.toml:2" in said and "pattern_um" in said
