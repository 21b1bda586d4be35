"""`trueloop new` from the outside."""

import csv
import json
import os
import pty
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import run
from tests.unit.formats.test_dxf_sheet import SHAFT, Sheet
from trueloop.jobs.turned.job import read_part

EXAMPLES = Path(__file__).parents[3] / "examples"
FINISH = EXAMPLES / "linuxcnc" / "finish.ngc"
RADIUS = ("--nose-radius-mm", "0.79375")


def rows(file: Path) -> list[dict[str, str]]:
    with file.open(encoding="utf-8") as lines:
        return list(csv.DictReader(line for line in lines if not line.startswith("#")))


def test_a_job_from_a_program_has_the_part_that_the_program_cuts(tmp_path: Path) -> None:
    run("new", FINISH, *RADIUS, "--folder", tmp_path / "job", "--measured", "points")
    made, listed = read_part(tmp_path / "job" / "job.toml"), read_part(EXAMPLES / "linuxcnc" / "job.toml")
    ends, expected = (np.array([one.end_mm for one in part.profile.features]) for part in (made, listed))
    np.testing.assert_allclose(ends, expected, atol=0.0005)
    assert made.name == "finish" and made.nose_radius_mm == 0.79375


def test_the_diameters_to_measure_are_those_of_the_part(tmp_path: Path) -> None:
    """MODBAS2 by hand: collar Ø 5.72, main cylinder Ø 3.52 and small cylinder Ø 2.92 in; from face to face 4.375 in."""
    run("new", FINISH, *RADIUS, "--folder", tmp_path / "job")
    found = rows(tmp_path / "job" / "readings.csv")
    sizes = {(row["feature"], float(row["nominal"])) for row in found if row["quantity"] == "diameter"}
    assert sizes == {("cylinder-1", 5.72), ("cylinder-2", 3.52), ("cylinder-3", 2.92)}
    (length,) = [row for row in found if row["quantity"] == "length"]
    assert (length["feature"], length["from"], float(length["nominal"])) == ("face-1", "face-2", 4.375)
    assert all(row["value_in"] == "" for row in found)
    places = [float(row["z_in"]) for row in found if row["feature"] == "cylinder-2"]
    assert len(places) == 3 and all(-4.51 < z < -1.76 for z in places)


def test_points_to_touch_lie_on_the_part(tmp_path: Path) -> None:
    run("new", FINISH, *RADIUS, "--folder", tmp_path / "job", "--measured", "points")
    part, found = read_part(tmp_path / "job" / "job.toml"), rows(tmp_path / "job" / "touches.csv")
    points = np.array([[25.4 * float(row[f"nominal_{axis}_in"]) for axis in "xz"] for row in found])
    assert float(np.max(np.abs(part.profile.locate(points).distance_mm))) < 1e-4
    assert {row["feature"] for row in found} == set(part.profile.names)


def test_names_are_those_of_the_drawing_and_of_the_program_alike(tmp_path: Path) -> None:
    """PIECS11 from its drawing, and from its program alone: the same features under the same names."""
    finish = EXAMPLES / "piecs11" / "finish.nc"
    options = (finish, *RADIUS, "-d", "ge2000t", "--set", "P42=8", "--measured", "points", "--json")
    drawn = json.loads(run("new", *options, "--drawing", EXAMPLES / "dxf" / "piecs11.dxf", "--folder", tmp_path / "a"))
    cut = json.loads(run("new", *options, "--folder", tmp_path / "b"))
    assert drawn["features"] == ["face-1", "cylinder-1", "face-2", "cone-1", "arc-1"]
    assert set(cut["features"]) <= set(drawn["features"])
    assert read_part(tmp_path / "a" / "job.toml").profile.names == tuple(drawn["features"])


def test_a_job_that_is_there_is_not_written_over(tmp_path: Path) -> None:
    run("new", FINISH, *RADIUS, "--folder", tmp_path)
    (tmp_path / "readings.csv").write_text("filled in")
    (tmp_path / "job.toml").unlink()
    assert "JOB-EXISTS" in run("new", FINISH, *RADIUS, "--folder", tmp_path, status=3)
    assert (tmp_path / "readings.csv").read_text() == "filled in" and not (tmp_path / "job.toml").exists()


def test_a_move_that_is_not_understood_is_not_left_out_of_the_part(tmp_path: Path) -> None:
    """A cone whose `Z-90..` is no number: the part would end before it."""
    finish = tmp_path / "finish.nc"
    finish.write_text("G21 G40 G99\nT0303\nG00 X20. Z3.\nG01 G42 Z0. F0.1\nX28. Z-22.\nX58. Z-90..\nG40 X64.\nM30\n")
    given = (finish, *RADIUS, "-d", "fanuc-lathe")
    assert "NC-WORD" in run("new", *given, "--folder", tmp_path / "job", status=3)
    assert "NC-WORD" in run("part", "from-program", *given, status=3)
    run("new", *given, "--folder", tmp_path / "job", "--accept-unknown-words")
    assert "accept_unknown_words = true" in (tmp_path / "job" / "job.toml").read_text()


@pytest.mark.parametrize(
    ("arguments", "said", "status"),
    [
        ((FINISH,), "--nose-radius-mm", 2),
        (("finsh.ngc", *RADIUS), "NC-FILE", 3),
        ((FINISH, "--nose-radius-mm", "30"), "GEO-NARROW", 3),
        ((FINISH, *RADIUS, "--drawing", "part.pdf"), "GEO-DXF", 3),
        ((FINISH, *RADIUS, "--drawing", EXAMPLES / "facetst" / "part.dxf"), "GEO-DXF", 3),
    ],
)
def test_what_cannot_be_begun_is_refused_and_nothing_is_written(
    arguments: tuple[object, ...], said: str, status: int, tmp_path: Path
) -> None:
    assert said in run("new", *arguments, "--folder", tmp_path / "job", status=status)
    assert not (tmp_path / "job").exists()


def test_at_a_terminal_it_asks_for_what_is_missing(tmp_path: Path) -> None:
    """Answers that are none of the choices are asked for again."""
    ours, theirs = pty.openpty()
    command = [sys.executable, "-c", "from trueloop.cli.main import main; main()"]
    finish = EXAMPLES / "shaft" / "finish.nc"
    with subprocess.Popen(
        [*command, "new", str(finish)], cwd=tmp_path, stdin=theirs, stdout=theirs, stderr=theirs
    ) as it:
        os.close(theirs)
        os.write(ours, b"wide\n-1\nnan\n0,8\nmy shaft\ncaliper\ngauge\nfanuc\nfanuc-lathe\n")
        said = b""
        while True:
            try:
                said += os.read(ours, 4096)
            except OSError:  # the terminal's other end was closed
                break
        assert it.wait(timeout=60) == 0, said.decode()
    os.close(ours)
    assert b"wide is not a number: type it as 0.8 or 0,8" in said and b"nan is not a finite number" in said
    assert b"-1.0 is not a finite number from 0 up" in said and said.count(b"Nose radius") == 4
    assert said.count(b"Measured with a micrometer") == said.count(b"may be for several controls") == 2
    part = read_part(tmp_path / "my-shaft" / "job.toml")
    assert (part.name, part.nose_radius_mm) == ("my shaft", 0.8)


def test_one_of_two_parts_of_a_sheet_is_chosen_and_z_counts_from_its_free_end(tmp_path: Path) -> None:
    sheet = Sheet((-20.0, 40.0)).bush()
    sheet.at = (80.0, 40.0)
    drawing, program, job = sheet.shaft().border().saved(tmp_path), tmp_path / "shaft.nc", tmp_path / "job"
    contour = "G42 G01 X0. Z0. F0.1\nX18.\nZ-20.\nX30.\nZ-60.\nX-2.\nG40 Z-65.\n"
    program.write_text(f"%\nO0001\nG21 G18 G90\nT0101\nG00 X-2. Z5.\n{contour}G00 X60. Z50.\nM30\n%\n")
    options = (program, "--nose-radius-mm", "0.8", "-d", "fanuc-lathe", "--drawing", drawing, "--folder", job)
    assert "GEO-DXF-CHOICE" in run("new", *options, status=3)
    run("new", *options, "--outline", "2", "--zero", "free-end")
    profile = read_part(job / "job.toml").profile
    ends = [profile.features[0].start_mm, *(one.end_mm for one in profile.features)]
    np.testing.assert_allclose(ends, SHAFT, atol=1e-9)


@pytest.mark.parametrize("wrong", [("--outline", "2"), ("--zero", "free-end")])
def test_a_choice_needs_a_drawing_to_choose_in(tmp_path: Path, wrong: tuple[str, str]) -> None:
    said = run("new", FINISH, *RADIUS, *wrong, "--folder", tmp_path / "job", status=2)
    assert "--drawing" in said and not (tmp_path / "job").exists()
