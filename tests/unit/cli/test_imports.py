"""A command imports its own module, not those of the others: `trueloop` starts at once."""

import json
import subprocess
import sys

import pytest

LOADED = """
import json, sys
from trueloop.cli.main import app
try:
    app(sys.argv[1:])
except SystemExit:
    print(json.dumps([name for name in sys.modules if name.startswith("trueloop")]))
"""


def loaded(*words: str) -> set[str]:
    """The modules of trueloop that a process holds after a command."""
    run = subprocess.run([sys.executable, "-c", LOADED, *words], capture_output=True, text=True, check=True)
    return set(json.loads(run.stdout.splitlines()[-1]))


def test_the_version_imports_no_command() -> None:
    assert loaded("--version") == {"trueloop", "trueloop.cli", "trueloop.cli.main", "trueloop.cli.plain_output"}


@pytest.mark.parametrize(("command", "own"), [("tool", "trueloop.cli.tool"), ("explain", "trueloop.cli.help")])
def test_a_command_imports_none_of_the_others(command: str, own: str) -> None:
    others = {"trueloop.cli.machine", "trueloop.cli.series", "trueloop.cli.db", "trueloop.cli.surface"}
    found = loaded(command, "--help")
    assert own in found and not others & found
