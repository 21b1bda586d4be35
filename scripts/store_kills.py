"""Kills a program that writes into a store, a thousand times at any moment, and looks at what is left.

`python -m scripts.store_kills PLACE [COUNT]`, where PLACE is a new file or an empty database. Each time a process keeps
inspections with their touches and says so one by one; it is killed without warning after a while drawn by chance. Then
the store must open; every inspection that was acknowledged must be there, whole; one that was not, whole or not at all.
Prints what came of it as JSON; ends with 1 where anything was lost, half written or damaged.
"""

import json
import os
import random
import select
import signal
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from typing import Final

from trueloop.domain.inspection import Inspection, Touch
from trueloop.domain.part import Part, PartType
from trueloop.storage.integrity import damage
from trueloop.storage.store import find, keep, open_store

TOUCHES: Final = 400
"""Of each inspection: enough for a kill to fall between two pages."""
LONGEST_S: Final = 60.0
"""No writer is waited for longer."""
WITHIN_S: Final = 0.1
"""A writer is killed within this time of its first word: it keeps several inspections meanwhile."""


@dataclass
class Tally:
    """Of how many kills; how many inspections were said to be kept and were found; and what must stay 0.

    `unacknowledged` were found whole though the writer was killed before it could say so.
    """

    kills: int = 0
    acknowledged: int = 0
    unacknowledged: int = 0
    lost: int = 0
    half_written: int = 0
    damaged: int = 0


def inspection(number: int) -> Inspection:
    """One that is known by its number alone, so that what is read can be compared with what was meant."""
    touches = tuple(
        Touch(str(k), (10.0 + number / 7, -k / 3), "dome", error_mm=(number + k) / 7e3, line=k) for k in range(TOUCHES)
    )
    return Inspection(Part(PartType("shaft"), str(number)), "touches", f"{number:064x}", TOUCHES, touches)


def killed(write: Callable[[int], None], after_s: float) -> list[str]:
    """Forks a writer, kills it, and returns what it had acknowledged: the lines that it wrote to what it was given."""
    said, says = os.pipe()
    writer = os.fork()
    if writer == 0:
        try:
            write(says)
        finally:
            os._exit(1)
    os.close(says)
    try:
        if not select.select([said], [], [], LONGEST_S)[0]:
            raise SystemExit(f"the writer kept nothing for {LONGEST_S:g} s")
        time.sleep(after_s)
    finally:
        os.kill(writer, signal.SIGKILL)
        os.waitpid(writer, 0)
    with os.fdopen(said) as words:
        return words.read().split("\n")[:-1]


def _write(place: str, first: int, says: int) -> None:
    store = open_store(place)
    for number in range(first, first + 10**6):
        keep(store, [inspection(number)])
        os.write(says, b"%d\n" % number)


def looked_at(place: str, first: int, acknowledged: list[int], row: int, tally: Tally) -> tuple[int, int]:
    """Counts what is there from inspection `first` on, and returns the next number and the last row."""
    store = open_store(place)
    number = first
    while kept := find(store, Inspection, file_sha256=f"{number:064x}"):
        tally.half_written += kept[0].value != inspection(number)
        tally.unacknowledged += number not in acknowledged
        row, number = max(row, kept[0].row), number + 1
    tally.acknowledged += len(acknowledged)
    tally.lost += len([one for one in acknowledged if one >= number])
    tally.damaged += len(damage(store, after=max(0, row - (number - first))))
    tally.kills += 1
    store.close()
    return number, row


def main(place: str, count: int = 1000) -> int:
    """Makes the store, kills its writers, and says what came of it."""
    open_store(place, create=True).close()
    drawn, tally, number, row = random.Random(1), Tally(), 0, 0
    for _ in range(count):
        acknowledged = [int(one) for one in killed(partial(_write, place, number), drawn.uniform(0.0, WITHIN_S))]
        number, row = looked_at(place, number, acknowledged, row, tally)
    print(json.dumps(asdict(tally)))
    return int(bool(tally.lost or tally.half_written or tally.damaged))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], *map(int, sys.argv[2:3])))
