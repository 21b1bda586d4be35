"""docs/db.md: its commands run in order and print what the page says."""

import re
import shlex
import shutil
from pathlib import Path

import pytest

from tests.support.cli import invoke

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "db.md").read_text(encoding="utf-8")
BLOCKS = [
    [line.removeprefix("    ") for line in found.splitlines()]
    for found in re.findall(r"(?:^    .*\n)+", PAGE.partition("\n## Labels")[0], re.M)
]


def test_the_commands_of_the_page_print_what_it_says(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    for name in ("job.toml", "touches.csv", "finish.nc", "semifinish.nc"):
        shutil.copy(ROOT / "examples" / "modbas2" / name, tmp_path)
    monkeypatch.chdir(tmp_path)
    assert len(BLOCKS) >= 14
    for command, *expected in BLOCKS:
        assert command.startswith("trueloop db ")
        ran = invoke(*shlex.split(command)[1:], status=0)
        if command.endswith("--json"):  # what the page has a person do then
            Path("mended.json").write_text(ran.stdout.replace('"2511"', '"2512"'), encoding="utf-8")
        printed = ran.output
        places = [printed.index(line.rstrip()) for line in expected]
        assert places == sorted(places), command
