"""docs/diagnosis.md: its commands run in order and print what the page says."""

import re
import shlex
import shutil
from pathlib import Path

import pytest

from tests.support.cli import invoke

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "diagnosis.md").read_text(encoding="utf-8")
BLOCKS = [
    [line.removeprefix("    ") for line in found.splitlines()] for found in re.findall(r"(?:^    .*\n)+", PAGE, re.M)
]


def test_the_commands_of_the_page_lead_from_an_empty_store_to_a_diagnosis(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    for file in (ROOT / "examples" / "diagnosis").iterdir():
        shutil.copy(file, tmp_path)
    monkeypatch.chdir(tmp_path)
    printed = ""
    for block in BLOCKS:
        if not block[0].startswith("trueloop "):
            assert [line for line in block if line not in printed] == []
            continue
        for line in block:
            words = shlex.split(line)[1:]
            printed = invoke(*words, status=1 if "fixture" in words else 0).output
    assert (tmp_path / "part-3" / "part.html").is_file()
