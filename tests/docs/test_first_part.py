"""docs/first-part.md: its commands run in order, print what the page says, and correct by what arithmetic asks for."""

import re
import shlex
import shutil
from pathlib import Path

import pytest

from tests.support.cli import invoke

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "first-part.md").read_text(encoding="utf-8")
BLOCKS = [
    "\n".join(line.removeprefix("    ") for line in found.splitlines())
    for found in re.findall(r"(?:^    .*\n)+", PAGE, re.M)
]


@pytest.fixture
def after(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    """The folder after all commands of the page, with the readings of the page filled in."""
    shutil.copy(ROOT / "examples" / "shaft" / "finish.nc", tmp_path)
    monkeypatch.chdir(tmp_path)
    printed = ""
    for block in BLOCKS:
        if block.startswith("trueloop "):
            printed = invoke(*shlex.split(block)[1:], status=0).output
        elif block.startswith("# serial"):
            (tmp_path / "shaft" / "readings.csv").write_text(block + "\n", encoding="utf-8")
        else:
            places = [printed.index(line.rstrip()) for line in block.splitlines()]
            assert places == sorted(places), block
    return tmp_path


def test_the_page_leads_from_a_program_and_six_readings_to_a_corrected_program(after: Path) -> None:
    """By hand: the journal reads Ø 24.013, so X 23.987; the seat Ø 44.031 and Ø 44.027, so X 43.971 in its middle."""
    assert sum(block.startswith("trueloop ") for block in BLOCKS) <= 5
    before, now = (
        [float(word) for word in re.findall(r"X(-?[\d.]+)", text.read_text(encoding="utf-8"))]
        for text in (after / "finish.nc", after / "shaft" / "out" / "corrected.nc")
    )
    assert 24.0 in before and 23.987 in now
    ends = [x for x in now if 43.9 < x < 44.0]  # at Z-80 and Z-112: the readings' middle is the cylinder's
    assert len(ends) == 2 and sum(ends) / 2 == pytest.approx(44.0 - 0.029, abs=0.0006)
    assert ends[0] > ends[1], "thicker at the chuck: more is taken off there"


def test_the_rows_of_the_page_are_those_that_were_written(after: Path) -> None:
    written = invoke(
        *("new", "finish.nc", "--dialect", "fanuc-lathe", "--nose-radius-mm", "0.8", "--folder", "again"), status=0
    )
    rows = (after / "again" / "readings.csv").read_text(encoding="utf-8").splitlines()
    filled = (after / "shaft" / "readings.csv").read_text(encoding="utf-8").splitlines()
    assert "again/readings.csv" in written.output
    assert [row.rpartition(",")[0] for row in rows if row[0] != "#"] == [
        row.rpartition(",")[0] for row in filled if row[0] != "#"
    ]
