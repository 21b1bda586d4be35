"""What every error code's example prints, kept in expected.txt: python -m tests.errors.expected writes it anew.

A changed message is then seen, and read, in the difference of that file.
"""

import re
import tempfile
from pathlib import Path
from typing import Final

from trueloop.errors import Finding, TrueloopError

FILE: Final = Path(__file__).with_name("expected.txt")
FOLDER: Final = re.compile(r"/[\w./-]*/tmp[\w-]+\b(/)?|" + re.escape(str(Path(__file__).parents[2])) + "/")
"""Folders of the day: temporary ones, and the one of this checkout."""
OF_THE_DAY: Final = re.compile(r"\d+(?= bytes are free)|-?\d\.\d+e[+-]\d+")
"""Numbers that another machine gives otherwise: free bytes, and those that rounding alone makes."""


def words(said: TrueloopError | Finding) -> str:
    """Message and hint as printed, without what differs from run to run."""
    return OF_THE_DAY.sub("…", FOLDER.sub("", str(said)))


def kept() -> dict[str, str]:
    """What each example is expected to print, by its name."""
    blocks = FILE.read_text(encoding="utf-8").split("\n\n")
    return {name: text.rstrip("\n") for name, _, text in (block.partition("\n") for block in blocks)}


if __name__ == "__main__":
    from tests.errors.test_every_code import PRODUCERS, complaint

    with tempfile.TemporaryDirectory() as tempfile.tempdir:  # corrections are looked for in folders near a job
        found = (f"{area} {code}\n{words(complaint(code, produce))}" for area, code, produce in PRODUCERS)
        FILE.write_text("\n\n".join(found) + "\n", encoding="utf-8")
