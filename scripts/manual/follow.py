"""Follows a page word by word with the `trueloop` that is installed, and prints how long that took.

`python -m scripts.manual.follow first-part.md` in an empty folder. It needs no more than a reader has: every command is
a process of its own, found on the PATH; what the page shows as a file is written, and what it prints is compared.
"""

import shutil
import sys
import time
from pathlib import Path

from scripts.manual.contents import ROOT
from scripts.manual.snippets import snippets
from tests.support.dialogue import run_page


def follow(page: Path) -> None:
    """Raises AssertionError where something else is printed than the page shows."""
    began = time.monotonic()
    run_page(page, installed=True)
    commands = sum(len(one.commands()) for one in snippets(page.read_text(encoding="utf-8")))
    took_s = time.monotonic() - began
    print(f"{page.name}: {commands} commands by {shutil.which('trueloop')}, all as shown, in {took_s:.1f} s")


if __name__ == "__main__":
    for name in sys.argv[1:] or ["first-part.md"]:
        follow(ROOT / "docs" / name)
