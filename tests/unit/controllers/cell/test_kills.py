"""A client that is killed at any moment: nothing is cut twice, nothing but what was accepted, no touch is lost.

`python -m scripts.cell_kills FOLDER 100 100` does more of it, and `… 100 100 linuxcnc` with LinuxCNC.
"""

import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[4]
LONGEST_S = 600


@pytest.mark.parametrize(("machine", "kills", "steps"), [("stand-in", 30, 20), ("linuxcnc", 5, 3)])
def test_kills_of_the_client(tmp_path: Path, machine: str, kills: int, steps: int) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "scripts.cell_kills", str(tmp_path), str(kills), str(steps), machine],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=LONGEST_S,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    found = json.loads(done.stdout)
    assert found["recorded"] >= steps and found["kills"]["cell"] >= kills
    wrong = ("cut_twice", "other_program", "touches_lost", "undelivered")
    assert {name: found[name] for name in wrong} == dict.fromkeys(wrong, 0)
