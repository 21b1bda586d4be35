"""Commands whose output goes to a stream that is not UTF-8: what it lacks is replaced, and nothing fails."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from trueloop.cli.main import plain

ROOT = Path(__file__).parents[3]


def _run(encoding: str, *arguments: str | Path) -> tuple[int, str, str]:
    done = subprocess.run(
        [sys.executable, "-c", "from trueloop.cli.main import main; main()", *map(str, arguments)],
        cwd=ROOT,
        env={**os.environ, "PYTHONIOENCODING": encoding, "PYTHONUTF8": "0"},
        capture_output=True,
        timeout=120,
        check=False,
    )
    of = encoding.partition(":")[0]
    return done.returncode, done.stdout.decode(of), done.stderr.decode(of)


@pytest.mark.parametrize(
    ("encoding", "part"),
    [
        ("ascii", "lens"),
        ("ascii:surrogateescape", "lens"),
        ("cp1252", "modbas2"),
        ("cp1252:surrogateescape", "modbas2"),
        ("cp437", "modbas2"),
        ("latin-1", "modbas2"),
    ],
)
def test_a_correction_is_shown_by_any_stream(encoding: str, part: str, tmp_path: Path) -> None:
    """`surrogateescape` is how Windows sets stdout up, and other systems in the locale C."""
    status, shown, messages = _run(encoding, "compensate", f"examples/{part}/job.toml", "-o", tmp_path)
    assert status == 0 and "INTERNAL" not in messages, messages
    assert "?" not in shown
    if encoding.startswith("ascii"):
        assert "RMS um" in shown and "+-U" in shown and "µ" not in shown


@pytest.mark.parametrize(
    ("arguments", "status"),
    [
        (("--help",), 0),
        (("compensate", "--help"), 0),
        (("part", "show", "examples/lens/job.toml"), 0),
        (("nc", "check", "examples/lens/finish.ngc"), 0),
        (("explain", "GEO-DXF"), 0),
        (("part", "show", "Öse–Ø12.toml"), 3),
    ],
)
def test_every_kind_of_command_writes_ascii(arguments: tuple[str, ...], status: int) -> None:
    found, shown, messages = _run("ascii", *arguments)
    assert found == status and "INTERNAL" not in messages, messages
    assert shown or messages


def test_json_keeps_every_character() -> None:
    _, escaped, _ = _run("cp1252", "part", "show", "--json", "examples/lens/job.toml")
    _, whole, _ = _run("utf-8", "part", "show", "--json", "examples/lens/job.toml")
    assert escaped.isascii() and json.loads(escaped) == json.loads(whole)


def test_what_the_user_wants_of_characters_that_are_missing_stays() -> None:
    _, shown, _ = _run("cp1252:xmlcharrefreplace", "part", "show", "examples/lens/job.toml")
    assert "&#8805;" in shown, "a curve's R ≥"


@pytest.mark.parametrize(
    ("text", "written"),
    [
        ("±2 µm − 3 μm", "+-2 um - 3 um"),
        ("R ≥ 20°, σ², Δφ", "R >= 20 deg, sigma2, Deltaphi"),
        ("Öse ﬁ €", "Ose fi ?"),
        ("\udc80", "?"),
    ],
)
def test_how_characters_are_replaced(text: str, written: str) -> None:
    assert plain(text) == written
