"""docs/realtime-image.md: its commands run in order and print what the page says."""

import re
import shlex
from pathlib import Path

import pytest

from tests.support.cli import invoke
from tests.support.places import EXAMPLES

PAGE = (Path(__file__).parents[2] / "docs" / "realtime-image.md").read_text(encoding="utf-8")


def test_the_commands_of_the_page_print_what_it_says(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(EXAMPLES)
    printed, commands = "", 0
    making = PAGE[PAGE.index("## Making one") : PAGE.index("## The file")]
    for line in re.findall(r"^    (.*)$", making, re.M):
        if line.startswith("trueloop "):
            printed = invoke(*shlex.split(line)[1:], status=0).output
            commands += 1
        else:
            assert line in printed
    assert commands == 4
