"""Linear algebra runs on one thread unless the user says otherwise: decided before numpy is there."""

import subprocess
import sys

import pytest

PROGRAM = """
import os, sys
from trueloop.cli import main
assert "numpy" not in sys.modules
sys.argv = ["trueloop", "--version"]
try:
    main.main()
except SystemExit:
    pass
print([os.environ[name] for name in main.THREADS])
"""


@pytest.mark.parametrize(("given", "expected"), [({}, "1"), ({"OPENBLAS_NUM_THREADS": "2"}, "2")])
def test_one_thread_unless_told(given: dict[str, str], expected: str) -> None:
    command = [sys.executable, "-c", PROGRAM]
    done = subprocess.run(command, check=True, env=given, capture_output=True, text=True, timeout=60)
    assert done.stdout.splitlines()[-1] == str([expected, "1", "1"])
