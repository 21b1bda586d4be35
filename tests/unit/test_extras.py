"""What hints and pages name as a way to install is one that works."""

import re
import tomllib
from pathlib import Path

import pytest

from scripts.manual.contents import ROOT, pages
from trueloop.extras import install_command

EXTRAS = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]


@pytest.mark.parametrize("extra", EXTRAS)
def test_an_extra_is_installed_by_the_packages_that_pyproject_lists(extra: str) -> None:
    """In double quotes: cmd.exe knows no others, and `>` outside of quotes writes a file."""
    assert install_command(extra) == " ".join(["pip install", *(f'"{one}"' for one in EXTRAS[extra])])


def test_no_page_or_message_asks_pip_for_trueloop_by_name() -> None:
    files = [*(ROOT / "src").glob("trueloop*/**/*.py"), *(page.source for page in pages() if page.source.exists())]
    by_name = re.compile(r"pip install ['\"]?trueloop")
    assert [str(file) for file in files if by_name.search(file.read_text(encoding="utf-8"))] == []


def test_every_extra_is_in_the_table_of_the_page() -> None:
    page = Path(ROOT, "docs", "installing.md").read_text(encoding="utf-8").partition("## Extras")[2]
    rows = dict(re.findall(r"^\| `(\w+)` \| ([^|]+) \|", page, re.M))
    packages = {extra: [re.split(r"[\[>=<]", one)[0] for one in needed] for extra, needed in EXTRAS.items()}
    assert {extra: cell.split(", ") for extra, cell in rows.items()} == packages
