"""docs/tools.md names every code of tools."""

import re
from pathlib import Path

from trueloop.errors import Code

PAGE = (Path(__file__).parents[2] / "docs" / "tools.md").read_text(encoding="utf-8")


def test_the_page_names_every_code_of_tools() -> None:
    assert set(re.findall(r"EDG-[A-Z]+", PAGE)) == {code.value for code in Code if code.startswith("EDG-")}
