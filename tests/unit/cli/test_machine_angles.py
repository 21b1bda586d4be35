"""Angles are printed in µrad and limited in µrad, lengths in µm, also where both are read."""

import json
import re
from pathlib import Path

import pytest

from tests.support.cli import output_of

MACHINE = """
[machine]
name = "VMC 3"
serial = "4711"
structure = "mill-table-x"
[axes.X]
travel_mm = [0, 500]
[axes.Y]
travel_mm = [-200, 200]
[axes.Z]
travel_mm = [-300, 0]
[[term]]
error = "EXX"
degree = 1
[[term]]
error = "EBX"
degree = 1
"""
STATIONS = range(0, 501, 50)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A model of a machine that grows 20 µm/m and pitches 100 µrad/m, from two runs of each kind."""
    where = tmp_path_factory.mktemp("angles")
    (where / "machine.toml").write_text(MACHINE)
    for run in (1, 2):
        _write(where / f"angles{run}.csv", "B", "reading_urad", 0.1, run)
        _write(where / f"lengths{run}.csv", "X", "reading_um", 0.02, run)
    return where


@pytest.fixture(scope="module")
def fitted(folder: Path) -> str:
    return output_of("machine", "fit", folder / "machine.toml", *sorted(folder.glob("*.csv")), "-o", folder / "model")


def _write(path: Path, along: str, unit: str, per_mm: float, run: int, offset: float = 0.0) -> None:
    """Readings that rise with X; the two runs differ by what the model cannot know, ±0.5 from station to station.

    They are absolute: else each run's zero, and the slope of straightness, would be unknowns and an offset no error.
    """
    noise = [0.5 * (-1) ** (k + run) for k in range(len(STATIONS))]
    rows = [f"{x},{along},{per_mm * x + offset + e},{run},yes" for x, e in zip(STATIONS, noise, strict=True)]
    path.write_text("\n".join([f"X_mm,along,{unit},run,absolute", *rows]))


def test_fit_and_its_page_tell_each_kind_in_its_own_unit(folder: Path, fitted: str) -> None:
    """The raw RMS of 0 … 50 µrad is near 30, of 0 … 10 µm near 6; left are the ± 0.5 of both."""
    told = [line.split("others: ")[1].split() for line in fitted.splitlines() if "predicted" in line]
    assert [words[1] for words in told] == ["µm", "µrad"] * 2
    assert all(float(words[0]) == pytest.approx(0.5, rel=0.35) for words in told)
    assert [float(words[4]) for words in told] == pytest.approx([5.92, 29.6] * 2, rel=0.02)
    page = (folder / "model/machine.html").read_text()
    held = page[page.index("Runs predicted from the others") :]
    assert re.findall(r">(µ\w+)</td>", held) == ["µm", "µrad"] * 2


@pytest.mark.parametrize(("limit", "status"), [(499, 1), (501, 0)])
def test_a_limit_on_angles_is_in_urad(folder: Path, fitted: str, limit: float, status: int) -> None:
    _write(folder / "off.csv", "B", "reading_urad", 0.1, 1, offset=500.0)
    said = output_of(
        "machine", "check", folder / "model/model.json", folder / "off.csv", "--limit-urad", limit, status=status
    )
    assert "after the model 499.95 µrad" in said and "µm" not in said


def test_angles_do_not_dilute_a_limit_on_lengths(folder: Path, fitted: str) -> None:
    _write(folder / "long.csv", "X", "reading_um", 0.02, 1, offset=12.0)
    files = [folder / "angles1.csv", folder / "long.csv"]
    output_of("machine", "check", folder / "model/model.json", *files, "--limit-um", 11.9, status=1)
    told = json.loads(output_of("machine", "check", folder / "model/model.json", *files, "--limit-um", 12.2, "--json"))
    assert told["length_mm"]["rms"] == pytest.approx(12e-3, rel=0.01)
    assert told["angle_rad"]["rms"] == pytest.approx(0.5e-6, rel=0.35)


def test_a_limit_on_what_was_not_read_is_refused(folder: Path, fitted: str) -> None:
    said = output_of("machine", "check", folder / "model/model.json", folder / "angles1.csv", "--limit-um", 1, status=2)
    assert "limits nothing" in said
