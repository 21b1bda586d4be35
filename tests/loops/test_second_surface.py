"""A second correction of a surface is added to the first, which had cut its parts; a forward model cuts the parts."""

import json
import re
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import invoke
from tests.support.surfaces import points_to_csv

SIDE, RADIUS = 21, 3.0
AT = np.linspace(0.0, 50.0, SIDE)
X, Y = np.meshgrid(AT, AT, indexing="ij")
JOB = """name = "Plate"
[surface]
file = "nominal.csv"
[gauging]
points = ["{points}"]
{more}
[program]
finish = "finish.ngc"
[cutter]
radius_mm = 3.0
[output]
folder = "{out}"
"""
FIRST_UM, SECOND_UM, THIRD_UM = (16.0, 0.12), (5.0, 0.19), (3.0, 0.15)
"""Height and wave number of what a part is too high by: cut by the given program and by the corrected ones."""


def error_mm(x: np.ndarray, y: np.ndarray, wave: tuple[float, float]) -> np.ndarray:
    return 1e-3 * wave[0] * np.sin(wave[1] * x) * np.cos(0.8 * wave[1] * y)


def write_part(file: Path, wave: tuple[float, float], seed: int) -> None:
    high = error_mm(X, Y, wave) + np.random.default_rng(seed).normal(0.0, 3e-4, X.shape)
    file.parent.mkdir(exist_ok=True)
    file.write_bytes(points_to_csv(np.stack([X, Y, high], axis=2).reshape(-1, 3), X.shape))


@pytest.fixture
def shop(tmp_path: Path) -> Path:
    """A flat plate, its ball-end program, and three parts cut by it."""
    (tmp_path / "nominal.csv").write_bytes(points_to_csv(np.stack([X, Y, 0.0 * X], axis=2).reshape(-1, 3), X.shape))
    passes = [f"G1 X{x:.3f} Y{y:.3f} Z0.000\n" for x in np.arange(5.0, 46.0, 5.0) for y in np.arange(5.0, 46.0, 2.0)]
    (tmp_path / "finish.ngc").write_text("G21 G90\nG0 Z20\nG0 X5 Y5\nF300\n" + "".join(passes) + "G0 Z20\nM2\n")
    for k in range(3):
        write_part(tmp_path / "first" / f"A{k}.csv", FIRST_UM, k)
        write_part(tmp_path / "second" / f"B{k}.csv", SECOND_UM, 10 + k)
    return tmp_path


def compensate(shop: Path, points: str, out: str, more: str = "", *options: str) -> tuple[int, str]:
    job = shop / f"{out}.toml"
    job.write_text(JOB.format(points=points, out=out, more=more))
    done = invoke("surface", "compensate", job, *options)
    return done.exit_code, done.stdout + done.stderr


def off_mm(program: Path, *waves: tuple[float, float]) -> float:
    """How far the tips of a program lie off the plate lowered by the waves, RMS over its inner cuts.

    A tip of a ball on a gentle surface follows its height to the second order of the slope: R s²/2 < 0.02 µm.
    """
    rows = re.findall(r"G1 X([\d.]+) Y([\d.]+) Z(-?[\d.]+)", program.read_text())
    x, y, z = np.array(rows, float).T
    return float(np.sqrt(np.mean((z + sum(error_mm(x, y, wave) for wave in waves)) ** 2)))


def test_the_third_part_gets_both_corrections(shop: Path) -> None:
    assert compensate(shop, "first/*.csv", "o1")[0] == 0
    assert off_mm(shop / "o1" / "corrected.ngc", FIRST_UM) < 0.5e-3

    code, words = compensate(shop, "second/*.csv", "o2")
    assert code == 3 and "CMP-CUT-WITH" in words and "o1/record.json" in words and "gauging.cut_with" in words
    assert not (shop / "o2").exists()

    assert compensate(shop, "second/*.csv", "o2", 'cut_with = "o1/record.json"')[0] == 0
    assert off_mm(shop / "o2" / "corrected.ngc", FIRST_UM, SECOND_UM) < 0.7e-3
    record = json.loads((shop / "o2" / "record.json").read_text())
    first = json.loads((shop / "o1" / "record.json").read_text())
    assert record["cut_with"]["correction"] == first["id"]
    assert any(first["id"] in line and "in force" in line for line in record["decision"])
    assert "in force when the parts were cut" in (shop / "o2" / "pattern.html").read_text()

    for k in range(3):
        write_part(shop / "third" / f"C{k}.csv", THIRD_UM, 20 + k)
    assert compensate(shop, "third/*.csv", "o3", 'cut_with = "o2/record.json"')[0] == 0
    assert off_mm(shop / "o3" / "corrected.ngc", FIRST_UM, SECOND_UM, THIRD_UM) < 0.9e-3, "three in a row"


def test_parts_that_the_given_program_cut_are_corrected_alone(shop: Path) -> None:
    compensate(shop, "first/*.csv", "o1")
    assert compensate(shop, "first/*.csv", "o1b")[0] == 0, "the parts that it was made from need no statement"
    assert compensate(shop, "second/*.csv", "o2", 'cut_with = "given"')[0] == 0
    assert off_mm(shop / "o2" / "corrected.ngc", SECOND_UM) < 0.5e-3


@pytest.mark.parametrize(
    ("points", "more", "code"),
    [
        ("first/*.csv", 'cut_with = "o1/record.json"', "CMP-CUT-WITH"),
        ("second/*.csv", 'cut_with = "o1/record.json"\nmeasured_at = 2020-01-01T10:00:00Z', "MSR-OLD"),
        ("second/*.csv", 'cut_with = "o1/no.json"', "REC-FILE"),
        ("second/*.csv", f'cut_with = "o1/record.json"\nprogram_sha256 = "{"0" * 64}"', "CMP-OTHER-PROGRAM"),
    ],
)
def test_a_statement_that_cannot_be_is_refused(shop: Path, points: str, more: str, code: str) -> None:
    compensate(shop, "first/*.csv", "o1")
    status, words = compensate(shop, points, "o2", more)
    assert status == 3 and code in words


def test_the_correction_of_another_program_is_refused(shop: Path) -> None:
    compensate(shop, "first/*.csv", "o1")
    (shop / "finish.ngc").write_text((shop / "finish.ngc").read_text().replace("F300", "F200"))
    status, words = compensate(shop, "second/*.csv", "o2", 'cut_with = "o1/record.json"')
    assert status == 3 and "CMP-OTHER-PROGRAM" in words
    assert compensate(shop, "second/*.csv", "o3")[0] == 0, "what corrects another program did not cut these parts"


def test_a_store_keeps_apart_what_two_corrections_cut(shop: Path) -> None:
    job = shop / "o2.toml"
    job.write_text(JOB.format(points="first/*.csv", out="o1", more=""))
    assert invoke("surface", "add", job).exit_code == 0
    assert compensate(shop, "first/*.csv", "o1")[0] == 0
    job.write_text(JOB.format(points="second/*.csv", out="o2", more='cut_with = "o1/record.json"'))
    assert invoke("surface", "add", job).exit_code == 0
    write_part(shop / "more" / "D0.csv", SECOND_UM, 30)
    code, words = compensate(shop, "more/*.csv", "o3", 'cut_with = "o1/record.json"')
    assert code == 0 and "3 parts in the store" in words and "A0, A1, A2" in words, words
    assert off_mm(shop / "o3" / "corrected.ngc", FIRST_UM, SECOND_UM) < 0.7e-3

    code, words = compensate(shop, "second/*.csv", "o4", 'cut_with = "o3/record.json"')
    assert code == 3 and ("SRF-STORED" in words or "CMP-CUT-WITH" in words), words
