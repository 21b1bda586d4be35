"""`trueloop nc features`: the mapping of blocks to features, and what it refuses to guess."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from typer.testing import Result

from tests.support.cli import invoke
from trueloop.cli.terminal import ExitStatus

MODBAS2 = Path(__file__).parents[3] / "examples" / "modbas2"
ARRIVED, COLLAR, DOME, LEFT = 17, 23, 29, 32
UNDER_G42 = """G21 G18 G8 G90 G40 F100
G0 X30 Z5
G42 G1 X0 Z0
G1 X19.99
G1 Z-30
G40 G1 X40 Z-35
M2
"""
PLUG = """
[part]
name = "plug"
unit = "mm"
x_is = "radius"
start = [20.0, -30.0]
feature = [{ name = "cylinder", to = [20.0, 0.0] }, { name = "face", to = [0.0, 0.0] }]
[tool]
nose_radius_mm = 0.4
[programs]
dialect = "linuxcnc"
finish = "finish.ngc"
[gauging]
touches = "touches.csv"
"""


def _run(job: Path, *arguments: str) -> Result:
    return invoke("nc", "features", job, *arguments)


@pytest.fixture
def edited(tmp_path: Path) -> Callable[..., Path]:
    """The job of MODBAS2 without its touches, the lines of its finish program changed."""

    def job(change: Callable[[list[str]], list[str]], extra: str = "") -> Path:
        shutil.copy(MODBAS2 / "semifinish.nc", tmp_path)
        lines = (MODBAS2 / "finish.nc").read_bytes().decode("latin-1").splitlines(keepends=True)
        (tmp_path / "finish.nc").write_bytes("".join(change(lines)).encode("latin-1"))
        text = (MODBAS2 / "job.toml").read_text(encoding="utf-8").replace("[programs]", f"[programs]\n{extra}")
        (tmp_path / "job.toml").write_text(text, encoding="utf-8")
        return tmp_path / "job.toml"

    return job


def test_each_feature_with_its_line_block_and_deviation() -> None:
    told = json.loads(_run(MODBAS2 / "job.toml", "--json").stdout)
    lines = [[block["line"] for block in feature["blocks"]] for feature in told["features"]]
    assert lines == [[line] for line in range(COLLAR, DOME + 1)]
    (dome,) = told["features"][-1]["blocks"]
    assert dome["block"] == "N0420 G02 X0.00000 Z00.03125 F0.005 R(P46/2-0.3+0.03125)   ! Dome"
    assert (dome["motion"], dome["path"]) == ("arc", "nose centre")
    assert (dome["from_mm"], dome["to_mm"]) == pytest.approx((0.0, told["features"][-1]["length_mm"]), abs=1e-9)
    # The cone's centre path is rounded to 1e-5 in on the diameter.
    (cone,) = told["features"][2]["blocks"]
    assert 0.05 < cone["deviation_um"] < 0.127


def test_the_table_says_the_same() -> None:
    result = _run(MODBAS2 / "job.toml")
    assert result.exit_code == ExitStatus.DONE, result.stderr
    (row,) = [line for line in result.stdout.splitlines() if line.startswith("dome")]
    assert row.split()[1:3] == ["29", "N0420"] and row.split()[-1] == "+0.00"


def test_feature_that_nothing_cuts_stands_without_blocks(edited: Callable[..., Path]) -> None:
    job = edited(lambda lines: lines[: DOME - 1] + lines[DOME:])
    result = _run(job)
    assert result.exit_code == ExitStatus.FINDINGS
    assert "dome               –  not known" in result.stdout and "main-cylinder     26" in result.stdout
    assert "NC-NO-MATCH: no feed move cuts 'dome'" in result.stderr and "finish.nc" in result.stderr


def _cut_twice(lines: list[str]) -> list[str]:
    """The finish pass once more behind the first, from its arrival to its leaving."""
    return lines[:LEFT] + lines[ARRIVED - 1 : LEFT] + lines[LEFT:]


def test_pass_that_comes_twice_is_asked_for_and_chosen_by_its_lines(edited: Callable[..., Path]) -> None:
    again = LEFT - ARRIVED + 1
    result = _run(edited(_cut_twice), "--json")
    assert result.exit_code == ExitStatus.FINDINGS
    dome = json.loads(result.stdout)["features"][-1]
    assert dome["blocks"] == [] and dome["error"]["code"] == "NC-AMBIGUOUS"
    assert f"'dome' is cut 2 times within 0.125 mm, by lines {DOME}, {DOME + again}" in dome["error"]["message"]
    assert "finish_lines = [from, to]" in dome["error"]["hint"]
    chosen = _run(edited(_cut_twice, f"finish_lines = [{LEFT + 1}, {LEFT + again}]"), "--json")
    assert chosen.exit_code == ExitStatus.DONE, chosen.stderr
    lines = [block["line"] for feature in json.loads(chosen.stdout)["features"] for block in feature["blocks"]]
    assert lines == list(range(COLLAR + again, DOME + again + 1))


def test_contour_under_g42_with_a_slip_of_its_own(tmp_path: Path) -> None:
    """X19.99 on the radius (G8) is a cylinder 10 µm too thin; the face is cut outwards, against the profile."""
    (tmp_path / "finish.ngc").write_text(UNDER_G42)
    (tmp_path / "job.toml").write_text(PLUG)
    result = _run(tmp_path / "job.toml", "--json")
    assert result.exit_code == ExitStatus.DONE, result.stderr
    cylinder, face = (feature["blocks"][0] for feature in json.loads(result.stdout)["features"])
    assert (cylinder["line"], cylinder["path"], face["line"]) == (5, "contour, G42", 4)
    assert cylinder["deviation_um"] == pytest.approx(-10.0, abs=1e-6) and face["deviation_um"] == 0.0
    assert cylinder["from_mm"] == pytest.approx(30.0) and cylinder["to_mm"] == pytest.approx(0.0)
