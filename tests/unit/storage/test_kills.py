"""A writer that is killed leaves whole rows behind, and all that it had acknowledged; two writers lose nothing."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from scripts.store_kills import inspection
from trueloop.domain.inspection import Inspection
from trueloop.errors import Code, TrueloopError
from trueloop.storage.integrity import damage
from trueloop.storage.store import Store, find, keep, open_store

ROOT = Path(__file__).parents[3]
LONGEST_S = 600


def test_kills_lose_nothing_and_leave_nothing_half_written(place: str) -> None:
    kills = 20 if "://" in place else 60
    done = subprocess.run(
        [sys.executable, "-m", "scripts.store_kills", place, str(kills)],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=LONGEST_S,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    tally = json.loads(done.stdout)
    assert tally["kills"] == kills
    assert tally["acknowledged"] >= kills // 2  # the writers wrote
    assert (tally["lost"], tally["half_written"], tally["damaged"]) == (0, 0, 0)


WRITER = """
import sys
from dataclasses import replace
from scripts.store_kills import inspection
from trueloop.storage.store import keep, open_store
store = open_store(sys.argv[1], wait_s=60)
new = sum(keep(store, [inspection(number)])[0].new for number in range(20))
print(new)
store.close()
"""


def test_two_writers_of_the_same_keep_each_once(place: str) -> None:
    open_store(place, create=True).close()
    writers = [
        subprocess.Popen([sys.executable, "-c", WRITER, place], cwd=ROOT, stdout=subprocess.PIPE, text=True)
        for _ in range(2)
    ]
    new = [int(writer.communicate(timeout=LONGEST_S)[0]) for writer in writers]
    assert sum(new) == 20
    store = open_store(place)
    assert [one.value for one in sorted(find(store, Inspection), key=lambda one: one.value.sha256)] == [
        inspection(number) for number in range(20)
    ]
    assert damage(store) == []
    store.close()


MAKER = """
import sys, time
from pathlib import Path
from trueloop.storage.store import open_store
print(flush=True)
while not Path(sys.argv[2]).exists():
    time.sleep(0.0005)
open_store(sys.argv[1], create=True, wait_s=60).close()
"""


def test_six_processes_make_one_store_at_once(tmp_path: Path) -> None:
    store, start = tmp_path / "new.db", tmp_path / "start"
    makers = [
        subprocess.Popen([sys.executable, "-c", MAKER, str(store), str(start)], stdout=subprocess.PIPE, text=True)
        for _ in range(6)
    ]
    for maker in makers:
        assert maker.stdout is not None
        maker.stdout.readline()
    start.touch()
    for maker in makers:
        maker.communicate(timeout=LONGEST_S)
    assert [maker.returncode for maker in makers] == [0] * 6
    made = open_store(store)
    assert damage(made) == []
    made.close()


def test_a_store_that_another_writes_into_says_so(place: str) -> None:
    first = open_store(place, create=True)
    second = open_store(place, wait_s=0.2)
    with first.writing(), pytest.raises(TrueloopError) as refused:
        keep(second, [inspection(1)])
    assert refused.value.code is Code.STO_BUSY
    assert keep(second, [inspection(1)])[0].new
    assert len(find(first, Inspection)) == 1
    first.close()
    second.close()


def test_readers_do_not_wait_for_a_writer(store: Store, stored_at: str) -> None:
    keep(store, [inspection(1)])
    reader = open_store(stored_at, wait_s=0.2)
    with store.writing():
        assert len(find(reader, Inspection)) == 1
    reader.close()
