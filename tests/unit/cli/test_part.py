"""`trueloop part`: the profile shown, and made from a program or a drawing."""

import json
import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from ezdxf.filemanagement import new

from tests.support.cli import invoke
from trueloop.arrays import Array
from trueloop.cli.terminal import ExitStatus
from trueloop.formats.jobs.job import read_turned_job
from trueloop.formats.jobs.part_tables import PartTable
from trueloop.formats.jobs.profile_of_job import profile_of_table
from trueloop.geometry.profile import Profile

EXAMPLES = Path(__file__).parents[3] / "examples"
MODBAS2 = EXAMPLES / "modbas2"
FROM_MODBAS2 = ("part", "from-program", str(MODBAS2 / "finish.nc"), "--nose-radius-mm", "0.79375")
SET = ("--set", "P42=8", "--set", "P46=3.52", "-s", "P47=0")


def _profile(table: str) -> Profile:
    return profile_of_table(PartTable.model_validate(tomllib.loads(table)["part"]))


def _ends(profile: Profile) -> Array:
    return np.array([feature.end_mm for feature in profile.features])


def test_a_program_gives_the_profile_that_the_job_spells_out() -> None:
    """The job's coordinates are the drawing's; the program's are rounded to 1e-5 in, on the diameter."""
    result = invoke(*FROM_MODBAS2, *SET)
    assert result.exit_code == ExitStatus.DONE, result.stderr
    made, drawn = _profile(result.stdout), profile_of_table(read_turned_job(MODBAS2 / "job.toml").part)
    assert np.allclose(_ends(made), _ends(drawn), rtol=0, atol=0.0005)
    assert [junction.kind for junction in made.junctions] == [junction.kind for junction in drawn.junctions]


def test_the_table_goes_to_a_file_with_its_decisions_and_name(tmp_path: Path) -> None:
    path = tmp_path / "new" / "part.toml"
    result = invoke(*FROM_MODBAS2, *SET, "--name", "dome, 3.52 in", "--output", str(path))
    assert (result.exit_code, result.stdout) == (ExitStatus.DONE, "")
    text = path.read_text()
    assert tomllib.loads(text)["part"]["name"] == "dome, 3.52 in"
    assert text.startswith("# Lines ")


def test_a_table_never_overwrites_its_program(tmp_path: Path) -> None:
    program = tmp_path / "finish.nc"
    program.write_bytes((MODBAS2 / "finish.nc").read_bytes())
    result = invoke("part", "from-program", str(program), "--nose-radius-mm", "0.79375", *SET, "-o", str(program))
    assert result.exit_code == ExitStatus.OUTPUT
    assert "OUT-INPUT" in result.stderr
    assert program.read_bytes() == (MODBAS2 / "finish.nc").read_bytes()


def test_lines_choose_the_pass() -> None:
    result = invoke(*FROM_MODBAS2, *SET, "--lines", "26", "29")
    assert [feature.name for feature in _profile(result.stdout).features] == [
        "cylinder-1", "face-1", "cylinder-2", "arc-1"
    ]  # fmt: skip


@pytest.fixture
def drawing(tmp_path: Path) -> Path:
    """A stepped shaft with a dome, 3 features, in inches."""
    path = tmp_path / "shaft.dxf"
    document = new(units=1)
    bulge = -math.tan(math.radians(90) / 4)
    document.modelspace().add_lwpolyline([(0, 2, 0), (3, 2, 0), (3, 1, bulge), (4, 0, 0)], format="xyb")
    document.saveas(path)
    return path


def test_a_drawing_gives_its_profile(drawing: Path) -> None:
    result = invoke("part", "from-dxf", str(drawing))
    assert result.exit_code == ExitStatus.DONE, result.stderr
    ends = np.array([(2, 3), (1, 3), (0, 4)]) * 25.4
    assert np.allclose(_ends(_profile(result.stdout)), ends, rtol=0, atol=1e-8)
    assert tomllib.loads(result.stdout)["part"]["name"] == "shaft"


def test_the_unit_of_a_drawing_can_be_given(drawing: Path) -> None:
    result = invoke("part", "from-dxf", str(drawing), "--unit", "mm")
    assert np.allclose(_ends(_profile(result.stdout))[0], (2, 3), rtol=0, atol=1e-8)


def test_show_as_json_is_the_profile() -> None:
    shown = json.loads(invoke("part", "show", str(MODBAS2 / "job.toml"), "--json").stdout)
    profile = profile_of_table(read_turned_job(MODBAS2 / "job.toml").part)
    assert shown["part"] == "MODBAS2, 3.52 in"
    assert [feature["name"] for feature in shown["features"]] == list(profile.names)
    assert [feature["end_mm"] for feature in shown["features"]] == _ends(profile).tolist()
    kinds = [junction["kind"] for junction in shown["junctions"]]
    assert kinds == ["corner"] * 5 + ["tangent"]
    assert shown["junctions"][0]["turn_deg"] == pytest.approx(90.0)
    reached = dict(zip(profile.names, (feature["reachable_mm"] for feature in shown["features"]), strict=True))
    assert reached["collar"] == pytest.approx([0.0, profile.features[0].length_mm])
    assert reached["main-face"][1] == pytest.approx(0.3 * 25.4 - 0.79375)


def test_show_for_people_has_a_row_a_feature() -> None:
    lines = invoke("part", "show", str(MODBAS2 / "job.toml")).stdout.splitlines()
    assert lines[0].startswith("MODBAS2, 3.52 in: 7 features, ")
    (dome,) = [line for line in lines if line.startswith("dome")]
    assert "convex arc R 37.0840, 90.00°" in dome
    (neck,) = [line for line in lines if line.startswith("small-cylinder")]
    assert neck.endswith("tangent, +0.000°")


def test_show_needs_the_part_and_the_tool_only(tmp_path: Path) -> None:
    """Touches that are not taken yet do not matter."""
    (tmp_path / "job.toml").write_bytes((MODBAS2 / "job.toml").read_bytes())
    shown = invoke("part", "show", str(tmp_path / "job.toml"), status=ExitStatus.DONE).stdout
    assert shown == invoke("part", "show", str(MODBAS2 / "job.toml")).stdout
    assert shown.startswith("MODBAS2, 3.52 in: 7 features, ")
