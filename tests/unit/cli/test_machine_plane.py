"""`trueloop machine plates` and `points`: a pattern put into plates is found, tabled, and taken out of a program."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import output_of
from trueloop.arrays import Array
from trueloop.machine.standards import LeftOut, not_repeating


def _error_mm(at: Array) -> Array:
    return 0.02 * np.sin(at / 60.0) + 0.004


def _report(path: Path, seed: int, shift_mm: float, sign: float = 1.0) -> Path:
    """Holes where the machine put them: its pattern, and the plate lay `shift_mm` off."""
    rng = np.random.default_rng(seed)
    nominal = rng.uniform(-150, 150, (60, 2))
    measured = nominal + sign * _error_mm(nominal) + shift_mm + rng.normal(0, 0.0005, nominal.shape)
    rows = np.column_stack([measured, nominal, measured - nominal, np.full((60, 3), 2.167)])
    lines = [" ".join(f"{value:.5f}" for value in row) for row in rows]
    path.write_text("\n".join(["Plate", "Meas X Meas Y", *lines]))
    return path


@pytest.fixture
def reports(tmp_path: Path) -> list[str]:
    return [str(_report(tmp_path / f"plate-{k}.txt", k, 0.1 * k)) for k in (1, 2)]


def test_plates_to_a_corrected_program(tmp_path: Path, reports: list[str]) -> None:
    """The pattern holds the shape; what all plates have of offset, scale and rotation is theirs, not the machine's."""
    field, out = tmp_path / "field.csv", tmp_path / "out.nc"
    told = json.loads(output_of("machine", "plates", *reports, "-o", field, "--step-mm", "5", "--json"))
    assert all(row["after_others_um_rms"] < 0.3 * row["left_um_rms"] for row in told["plates"])
    assert told["table_off_um"] < 0.1
    at = np.array([[x, y] for x in (-100, -50, 0, 50, 100) for y in (-90, 0, 90)], dtype=np.float64)
    program = tmp_path / "holes.nc"
    program.write_text("G21 G90\n" + "".join(f"X{x:.5f} Y{y:.5f}\n" for x, y in at))
    said = output_of("machine", "points", program, "-t", field, "-d", "linuxcnc", "-o", out)
    assert "over 15 points" in said
    lines = [line.split() for line in out.read_text().splitlines() if line.startswith("X")]
    moved = np.array([[float(word[1:]) for word in words] for words in lines])
    left = moved + _error_mm(at) - at
    columns = np.column_stack([np.ones(len(at)), at[:, 0] + 1j * at[:, 1]])
    drilled, commanded = (v[:, 0] + 1j * v[:, 1] for v in (left, _error_mm(at)))
    rest, whole = (v - columns @ np.linalg.lstsq(columns, v, rcond=None)[0] for v in (drilled, commanded))
    assert np.abs(rest).max() < 0.15 * np.abs(whole).max()


def test_one_plate_has_no_others_to_judge_it(reports: list[str]) -> None:
    assert json.loads(output_of("machine", "plates", reports[0], "--json"))["plates"][0]["after_others_um_rms"] is None
    said = output_of("machine", "plates", reports[0])
    assert "with the correction of the others" not in said
    assert "MCH-PATTERN: 0 plates were left out" in said


def test_a_pattern_that_does_not_repeat_is_questioned_and_its_table_refused(tmp_path: Path) -> None:
    """Plates of a machine whose pattern turned round from one to the next: each is predicted worse than without."""
    turned = [_report(tmp_path / f"plate-{k}.txt", k, 0.0, (-1.0) ** k) for k in range(4)]
    field, out, program = tmp_path / "field.csv", tmp_path / "out.nc", tmp_path / "holes.nc"
    told = json.loads(output_of("machine", "plates", *turned, "-o", field, "--json"))
    assert not told["repeats"] and "worse" in told["why"]
    assert "warning MCH-PATTERN: 4 plates left out" in output_of("machine", "plates", *turned)
    program.write_text("G21 G90\nX10. Y0.\n")
    command = ("machine", "points", program, "-t", field, "-d", "linuxcnc", "-o", out)
    said = output_of(*command, status=3)
    assert "field.csv: MCH-PATTERN" in said and "--unproven" in said and not out.exists()
    assert "over 1 points" in output_of(*command, "--unproven")
    handmade = tmp_path / "handmade.csv"
    handmade.write_text("\n".join(line for line in field.read_text().splitlines() if line[0] != "#"))
    assert "over 1 points" in output_of("machine", "points", program, "-t", handmade, "-d", "linuxcnc", "-o", out)


@pytest.mark.parametrize(
    ("pairs", "repeats"),
    [
        ([(8.3, 9.9)] * 3, False),
        ([(8.0, 7.3)] * 3, False),
        ([(8.0, 7.1)] * 3, True),
        ([(8.0, 4.0), (8.0, 8.1)], False),
        ([(8.0, 4.0), (8.0, 4.0), (8.0, 8.1)], True),
        ([(8.0, 4.0)], False),
    ],
)
def test_which_patterns_count_as_repeating(pairs: list[tuple[float, float]], repeats: bool) -> None:
    left = [LeftOut("plate", before / 1e3, after / 1e3) for before, after in pairs]
    assert (not_repeating(left) == "") is repeats


@pytest.mark.parametrize(
    ("program", "options", "status", "words"),
    [
        ("G21\nX100. Y0.\n", ["--quadrupole", "3e-3,0"], 3, "CMP-SIZE: a correction of X by 300.0 µm"),
        (
            "G21\nX100. Y0.\n",
            ["--quadrupole", "3e-3,0", "--limit-um", "300"],
            0,
            "largest correction X 300.0 Y 0.0 µm over 1",
        ),
        ("(trueloop corrected 12)\nX1. Y1.\n", ["--quadrupole", "3e-5,0"], 3, "holes.nc:1: CMP-TWICE"),
        ("G21 G91\nX1. Y1.\n", ["--quadrupole", "3e-5,0"], 3, "holes.nc:2:1: MCH-PROGRAM"),
        ("X1. Y1.\n", ["--quadrupole", "3e-5"], 2, "not M,DEG"),
        ("X1. Y1.\n", ["--quadrupole", "nan,0"], 2, "not M,DEG"),
        ("X1. Y1.\n", [], 2, "give --quadrupole or --table"),
        ("X1. Y1.\n", ["--table", "no-such.csv"], 3, "NC-FIELD: there is no file"),
    ],
)
def test_points_says_what_it_does_not_take(
    tmp_path: Path, program: str, options: list[str], status: int, words: str
) -> None:
    source, out = tmp_path / "holes.nc", tmp_path / "out.nc"
    source.write_text(program)
    assert words in output_of(
        "machine", "points", str(source), "-d", "linuxcnc", "-o", str(out), *options, status=status
    )
    assert out.exists() == (status == 0)


def test_frames_move_only_when_told(tmp_path: Path) -> None:
    source, out = tmp_path / "holes.nc", tmp_path / "out.nc"
    source.write_text("G21 G90\nG52 X100. Y0.\nX100. Y0.\nG4 X100.\nG68 X100. Y0. R5.\n")
    arguments = ["points", str(source), "-d", "fanuc-mill", "-o", str(out), "--quadrupole", "1e-4,0"]
    output_of("machine", *arguments)
    assert out.read_text().splitlines()[2:] == ["G52 X100. Y0.", "X99.990 Y0.", "G4 X100.", "G68 X100. Y0. R5."]
    output_of("machine", *arguments, "--all-words")
    assert out.read_text().splitlines()[2:] == ["G52 X99.990 Y0.", "X99.990 Y0.", "G4 X100.", "G68 X100. Y0. R5."]


def test_plates_name_what_is_no_report(tmp_path: Path, reports: list[str]) -> None:
    damaged = tmp_path / "damaged.txt"
    damaged.write_text("Meas X\n1 2 3\n")
    assert "MCH-FILE" in output_of("machine", "plates", damaged, status=3)
    few = tmp_path / "few.txt"
    few.write_text("\n".join(Path(reports[0]).read_text().splitlines()[:8]))
    assert "6 holes on 1 plates do not determine a pattern" in output_of("machine", "plates", few, status=3)
    assert "OUT-INPUT" in output_of("machine", "plates", reports[0], "-o", reports[0], status=4)
