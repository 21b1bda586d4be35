"""A client that is killed at any moment: nothing is cut twice, nothing but what was accepted, no touch is lost.

`python -m scripts.cell_kills FOLDER 100 100` does more of it.
"""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[4]
LONGEST_S = 600


def test_kills_of_the_client(tmp_path: Path) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "scripts.cell_kills", str(tmp_path), "30", "20"],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=LONGEST_S,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    found = json.loads(done.stdout)
    assert found["recorded"] >= 20 and found["kills"] >= 30
    wrong = ("cut_twice", "other_program", "touches_lost", "undelivered")
    assert {name: found[name] for name in wrong} == dict.fromkeys(wrong, 0)
