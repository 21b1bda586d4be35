"""`trueloop measure map`: the mapping that is proposed, shown and written, and what is said where there is a choice."""

import shlex
from itertools import takewhile
from pathlib import Path

import pytest

from tests.support.cli import output_of, run
from tests.support.workbooks import write_xlsx

TEXT = "Merkmal;Soll [mm];Ist;OT;UT\nDurchmesser 1;25;25,013;0,05;-0,02\n"


def _file(folder: Path, text: str, name: str = "part.csv") -> Path:
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_the_mapping_is_written_beside_the_table_and_reads_it(tmp_path: Path) -> None:
    path = _file(tmp_path, TEXT)
    shown = run("measure", "map", path)
    assert "nominal          Soll [mm]" in shown
    assert "+0.0130" in shown
    mapping = tmp_path / "part.map.toml"
    assert 'lower_tolerance = "with its sign"' in mapping.read_text(encoding="utf-8")
    by_mapping = run("measure", "read", path, "--mapping", mapping)
    assert "25.0130" in by_mapping
    assert "columns by their headings" not in by_mapping
    assert "columns by their headings" in " ".join(run("measure", "read", path).split())


def test_it_states_the_number_of_inspections_that_the_file_holds(tmp_path: Path) -> None:
    """Two of them are shown."""
    path = _file(tmp_path, "Name;Soll [mm];Teil 1;Teil 2;Teil 3\nD1;25;25,01;25,02;25,03\n")
    shown, by_mapping = run("measure", "map", path), run("measure", "read", path)
    assert "3 inspections" in shown and "3 inspections" in by_mapping
    assert "25.0300" in by_mapping and "25.0300" not in shown


def test_a_choice_is_left_to_the_user_with_the_command_that_makes_it(tmp_path: Path) -> None:
    folder = tmp_path / "Serie 1"
    folder.mkdir()
    path = _file(folder, "Name;Nominal [mm];Istwert;Messwert\nD1;25;25,01;25,02\n")
    refused = output_of("measure", "map", path, status=3)
    assert "2 columns may be the actual: 'Istwert', 'Messwert'" in refused
    assert not (folder / "part.map.toml").exists()
    hint = refused.partition("hint: say which: trueloop ")[2]
    command = [*takewhile(lambda word: word != "--column", shlex.split(hint)), "--column", "actual=Istwert"]
    assert command[:3] == ["measure", "map", str(path)]
    assert "25.0100" in run(*command, "--output", tmp_path / "other.toml")
    shown = run("measure", "map", path, "--column", "actual=Messwert", "--output", tmp_path / "own.toml")
    assert "25.0200" in shown
    assert "ignored          Istwert" in shown
    assert (tmp_path / "own.toml").is_file()


def test_a_mapping_that_lacks_a_unit_is_written_and_the_lack_is_reported(tmp_path: Path) -> None:
    path = _file(tmp_path, "Name;Nominal;Actual\nD1;1;1,01\n")
    assert "MSR-UNIT" in output_of("measure", "map", path, status=3)
    assert "unit" not in (tmp_path / "part.map.toml").read_text()
    assert "25.6540" in run("measure", "map", path, "--unit", "inch")
    assert 'unit = "inch"' in (tmp_path / "part.map.toml").read_text()


def test_a_sheet_by_its_name_and_a_heading_that_is_not_there(tmp_path: Path) -> None:
    rows: list[list[object]] = [["Name", "Nominal [mm]", "Actual [mm]"], ["D1", 25, 25.01]]
    path = write_xlsx(tmp_path / "book.xlsx", {"First op": rows, "Second op": rows})
    assert "--sheet 'First op'" in output_of("measure", "map", path, status=3)
    assert "of sheet 'Second op'" in run("measure", "map", path, "--sheet", "Second op")
    assert 'sheet = "Second op"' in (tmp_path / "book.map.toml").read_text()
    refused = output_of("measure", "map", path, "--sheet", "First op", "--column", "actual=Ist", status=3)
    assert "'Ist' is not one of its columns" in refused


@pytest.mark.parametrize("wrong", ["act=Ist", "actual"])
def test_a_meaning_that_is_none_is_a_usage_error(tmp_path: Path, wrong: str) -> None:
    assert "no MEANING=HEADING" in output_of("measure", "map", _file(tmp_path, TEXT), "--column", wrong, status=2)


def test_the_table_itself_is_never_overwritten(tmp_path: Path) -> None:
    path = _file(tmp_path, TEXT)
    assert "OUT-INPUT" in output_of("measure", "map", path, "--output", path, status=4)
    assert path.read_text(encoding="utf-8") == TEXT
