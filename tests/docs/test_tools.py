"""docs/tools.md: its commands run in order and print what the page says."""

import re
import shlex
from pathlib import Path

import pytest

from tests.support.cli import invoke
from trueloop.errors import Code

PAGE = (Path(__file__).parents[2] / "docs" / "tools.md").read_text(encoding="utf-8")
BLOCKS = [
    "\n".join(line.removeprefix("    ") for line in found.splitlines())
    for found in re.findall(r"(?:^    .*\n)+", PAGE, re.M)
]


def test_the_commands_of_the_page_print_what_it_says(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    printed, commands = "", 0
    for line in "\n".join(BLOCKS).splitlines():
        if line.startswith("trueloop "):
            printed = invoke(*shlex.split(line)[1:], status=0).output
            commands += 1
        else:
            assert line in printed
    assert commands == 7
    assert "corner 2" in printed and (tmp_path / "edge.html").is_file()


def test_the_page_names_every_code_of_tools() -> None:
    assert set(re.findall(r"EDG-[A-Z]+", PAGE)) == {code.value for code in Code if code.startswith("EDG-")}
