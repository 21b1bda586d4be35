"""A job that names its control's tool table: the nose comes from it, and a correction by offset is written into it."""

import json
from pathlib import Path

import pytest

from tests.loops.test_contour_under_g42 import OWN_SHIFT
from tests.support.cli import invoke, run

TABLE = "%\nG21\nG10 P3 X-0.1 Z.05 R0. Q3\nG10 P10003 X-155.5 Z-80.25 R0.4 Q3\nG10 P4 X1. Z1. R0. Q3\n%\n"
PLACES = [(28, -50, 1, 0), (23, -35, 0, 1), (22, -35, 0, 1), (15, -20, 1, 0), (15, -8, 1, 0)]


def job(folder: Path, tool: str, error_mm: tuple[float, float] = (0.012, -0.004), table: str = TABLE) -> Path:
    """A pin, 24 µm too thick and 4 µm too short; touches repeat within 0.1 µm."""
    rows = [
        f"{k},{x},{z},{1000 * (nx * error_mm[0] + nz * error_mm[1]) + (0.1, -0.1)[k % 2]}"
        for k, (x, z, nx, nz) in enumerate(PLACES)
    ]
    (folder / "finish.nc").write_bytes(OWN_SHIFT)
    (folder / "touches.csv").write_text("\n".join(["point,nominal_x_mm,nominal_z_mm,error_um", *rows, ""]))
    (folder / "offsets.txt").write_text(table)
    (folder / "job.toml").write_text(
        f'[part]\nname = "pin"\nfrom_program = true\n[tool]\n{tool}\n'
        '[programs]\ndialect = "fanuc-lathe"\nfinish = "finish.nc"\n[gauging]\ntouches = "touches.csv"\n'
    )
    return folder / "job.toml"


HELD = 'number = 3\ntable = "offsets.txt"'


def test_the_new_table_is_written_beside_the_results(tmp_path: Path) -> None:
    path = job(tmp_path, HELD)
    run("compensate", path, "-o", tmp_path / "out")
    new = (tmp_path / "out" / "new-offsets.txt").read_text()
    record = json.loads((tmp_path / "out" / "record.json").read_text())
    mark = f" (trueloop offset {record['id']} of {record['tool_offset']['measured_sha256'][:16]})"
    assert new == TABLE.replace("P3 X-0.1 Z.05 R0. Q3", f"P3 X-0.124 Z0.054 R0. Q3{mark}")
    held = record["tool_offset"]["held"]["row"]
    assert (held["x"], held["z"], held["unit"], held["kind"]) == ("-0.1", "0.05", "mm", "wear")


def test_the_same_touches_are_not_taken_out_a_second_time(tmp_path: Path) -> None:
    """The new table in the place of the old one, the job run again; and a dump of the control, without the comment."""
    path, table = job(tmp_path, HELD), tmp_path / "offsets.txt"
    run("compensate", path, "-o", tmp_path / "out")
    new = (tmp_path / "out" / "new-offsets.txt").read_text()
    table.write_text(new)
    assert "OFS-TWICE" in run("compensate", path, "-o", tmp_path / "out", status=3)
    table.write_text(new.replace(new[new.index(" (true") : new.index(")") + 1], ""))
    command = ("offsets", "apply", tmp_path / "out" / "record.json", "--table", table, "-o", tmp_path / "n.txt")
    assert "OFS-TWICE" in run(*command, status=3)
    table.write_text(TABLE.replace("X-0.1 ", "X-0.11 "))
    assert "OFS-CHANGED" in run(*command, status=3)
    table.write_text(TABLE)
    told = json.loads(run(*command, "--json"))
    assert [(one["axis"], one["is"], one["before"], one["after"]) for one in told["numbers"]] == [
        ("X", "diameter", -0.1, -0.124),
        ("Z", "radius", 0.05, 0.054),
    ]
    assert (tmp_path / "n.txt").read_text() == new


def test_a_job_can_be_applied_without_its_record(tmp_path: Path) -> None:
    path = job(tmp_path, "number = 3\nnose_radius_mm = 0.4")
    told = run("offsets", "apply", path, "--table", tmp_path / "offsets.txt", "-o", tmp_path / "new.txt")
    assert "tool 3, wear, line 3: X (diameter) -0.1 → -0.124 mm" in told
    assert "tool 3, wear, line 3: Z 0.05 → 0.054 mm" in told


@pytest.mark.parametrize(
    ("tool", "code"),
    [
        (f"{HELD}\nnose_radius_mm = 0.8", "OFS-NOSE"),
        (f'{HELD}\ntable_name = "FINISH"', "OFS-NAME"),
        (f'{HELD}\ntable_unit = "inch"', "OFS-UNIT"),
        ('number = 9\ntable = "offsets.txt"', "OFS-TOOL"),
        ('table = "offsets.txt"', "JOB-KEY"),
        ('number = 3\ntable = "offset.txt"', "OFS-FILE"),
        ('number = 4\ntable = "offsets.txt"', "OFS-NOSE"),
        ('number = 4\nnose_radius_mm = 0.4\ntable = "offsets.txt"', "OFS-TOOL"),
    ],
)
def test_a_table_that_does_not_go_with_the_job_is_refused(tmp_path: Path, tool: str, code: str) -> None:
    assert code in run("compensate", job(tmp_path, tool), "-o", tmp_path / "out", status=3)
    assert not (tmp_path / "out").exists()


def test_a_contour_that_is_corrected_leaves_the_table(tmp_path: Path) -> None:
    path = job(tmp_path, HELD)
    path.write_text(path.read_text() + '[compensation]\nby = "contour"\n')
    run("compensate", path, "-o", tmp_path / "out")
    assert not (tmp_path / "out" / "new-offsets.txt").exists()
    command = ("offsets", "apply", path, "--table", tmp_path / "offsets.txt", "-o", tmp_path / "new.txt")
    assert "OFS-NONE" in run(*command, status=3)


def test_reading_shows_every_row(tmp_path: Path) -> None:
    job(tmp_path, HELD)
    told = invoke("offsets", "read", tmp_path / "offsets.txt", status=0).stdout
    assert "3 rows, mm" in told and "T3" in told and "-155.5" in told
    rows = json.loads(run("offsets", "read", tmp_path / "offsets.txt", "--json"))["rows"]
    assert [(row["tool"], row["kind"], row["x"], row["nose"]) for row in rows] == [
        (3, "wear", -0.1, 0.0),
        (3, "geometry", -155.5, 0.4),
        (4, "wear", 1.0, 0.0),
    ]


def test_a_table_from_before_the_wear_that_is_stated_as_entered_is_refused(tmp_path: Path) -> None:
    """The next table would go back by what was entered: X −0.1 − 0.004 in place of −0.124 − 0.004."""
    run("compensate", job(tmp_path, HELD), "-o", tmp_path / "out")
    path = job(tmp_path, HELD, (0.002, 0.0))
    path.write_text(path.read_text().replace("[gauging]", 'cut_with = "out/record.json"\ncut_by = "wear"\n[gauging]'))
    assert "OFS-CHANGED" in run("compensate", path, "-o", tmp_path / "o2", "--no-store", status=3)
    (tmp_path / "offsets.txt").write_text((tmp_path / "out" / "new-offsets.txt").read_text())
    run("compensate", path, "-o", tmp_path / "o2", "--no-store")
    assert "X-0.128 " in (tmp_path / "o2" / "new-offsets.txt").read_text()


def test_a_table_that_holds_the_offset_of_a_correction_that_ran_in_a_program_is_refused(tmp_path: Path) -> None:
    """Its offset, X −0.024 on the diameter and Z +0.004, would be in force a second time."""
    contour = '[compensation]\nby = "contour"\n'
    path = job(tmp_path, HELD)
    path.write_text(path.read_text() + contour)
    run("compensate", path, "-o", tmp_path / "out")
    path = job(tmp_path, HELD, (0.002, 0.0))
    text = path.read_text().replace("[gauging]", 'cut_with = "out/record.json"\ncut_by = "corrected"\n[gauging]')
    path.write_text(text + contour)
    run("compensate", path, "-o", tmp_path / "o2", "--no-store")
    for row, code in (("X-0.124 Z.054", 3), ("X-0.123 Z.054", 0)):
        (tmp_path / "offsets.txt").write_text(TABLE.replace("X-0.1 Z.05", row))
        said = run("compensate", path, "-o", tmp_path / "o3", "--no-store", status=code)
        assert ("OFS-CHANGED" in said and "stated as run in a program: 'corrected'" in said) == bool(code)
