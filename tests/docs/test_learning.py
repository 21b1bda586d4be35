"""docs/learning.md: its commands run in order and print what the page says; the example is what the simulator gives."""

import re
import shlex
import shutil
from pathlib import Path

import numpy as np
import pytest

from tests.support.cli import invoke
from tests.support.correction import EXAMPLES
from tests.support.edge_example import FOLDER, files, text_of

PAGE = (Path(__file__).parents[2] / "docs" / "learning.md").read_text(encoding="utf-8")
BLOCKS = [
    [line.removeprefix("    ") for line in found.splitlines()] for found in re.findall(r"(?:^    .*\n)+", PAGE, re.M)
]


def test_the_commands_of_the_page_print_what_it_says(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in ("edge", "modbas2"):
        shutil.copytree(EXAMPLES / name, tmp_path / "examples" / name)
    monkeypatch.chdir(tmp_path / "examples" / "edge")
    printed = ""
    for line in (line for block in BLOCKS for line in block):
        first, *rest = shlex.split(line) if line.startswith(("cp ", "trueloop ")) else (line,)
        if first == "cp":
            shutil.copy(*rest)
        elif first == "trueloop":
            printed = invoke(*rest, status=0).output
        else:
            assert line in printed, line
    assert "kept in trueloop.db" in printed


def test_the_example_is_what_the_simulator_gives() -> None:
    """To a digit of what is written: sums in another order round otherwise."""
    for name, vectors in files().items():
        written = (FOLDER / name).read_text(encoding="utf-8")
        rows = [text.splitlines()[2:] for text in (written, text_of(vectors))]
        there, made = (np.array([float(row.rpartition(",")[2]) for row in of]) for of in rows)
        assert there == pytest.approx(made, abs=0.11)
        assert [row.rpartition(",")[0] for row in rows[0]] == [row.rpartition(",")[0] for row in rows[1]]
