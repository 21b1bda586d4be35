"""A service that is killed at any moment has done what it acknowledged, and nothing by halves."""

import json
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).parents[3]
LONGEST_S = 600


def test_kills_lose_no_fact_and_offer_no_cut_twice(place: str) -> None:
    kills = 40 if "://" in place else 60
    done = subprocess.run(
        [sys.executable, "-m", "scripts.factory_kills", place, str(kills)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=LONGEST_S,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    tally = json.loads(done.stdout)
    assert tally["kills"] >= kills
    assert tally["acknowledged"] >= kills  # the cells worked
    wrong = ("lost", "offered_twice", "not_as_its_facts", "without_event", "damaged")
    assert {name: tally[name] for name in wrong} == dict.fromkeys(wrong, 0)
