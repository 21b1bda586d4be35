"""The files that ARCHITECTURE.md names on a touch's way into a program are run by that command, in that order."""

import re
import sys
from pathlib import Path
from types import FrameType

import pytest

from scripts.manual.contents import ROOT
from tests.support.cli import run

PACKAGE = ROOT / "src/trueloop"
SECTION = re.compile(r"^## One correction, file by file\n(.*?)^## ", re.M | re.S)
FILE = re.compile(r"`([a-z_/]+\.py)`")


def first_calls(tmp_path: Path) -> list[str]:
    """The files of the package in the order in which a correction first calls a function of theirs."""
    run("examples", "modbas2", "-o", tmp_path)
    job = next(tmp_path.glob("**/job.toml"))
    run(
        "compensate", job, "-o", tmp_path / "before", "--no-store"
    )  # modules are imported: what runs then is none of it
    called: dict[str, None] = {}

    def note(frame: FrameType, event: str, _: object) -> None:
        if event == "call":
            called.setdefault(frame.f_code.co_filename, None)

    sys.setprofile(note)
    try:
        run("compensate", job, "-o", tmp_path / "out", "--no-store")
    finally:
        sys.setprofile(None)
    return [str(Path(name).relative_to(PACKAGE)) for name in called if name.startswith(f"{PACKAGE}/")]


def test_the_files_on_a_touchs_way_are_run_in_the_order_in_which_they_are_named(tmp_path: Path) -> None:
    found = SECTION.search((ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8"))
    assert found
    named = list(dict.fromkeys(FILE.findall(found[1])))
    called = first_calls(tmp_path)
    assert [name for name in named if name not in called] == []
    assert sorted(named, key=called.index) == named
    counts = re.search(r"(\d+) of about (\d+) files", " ".join(found[1].split()))
    assert counts and int(counts[1]) == len(named)
    assert int(counts[2]) == pytest.approx(len(called), rel=0.15)
