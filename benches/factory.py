"""What the service shows out of a store of many parts: `python -m benches.factory [PARTS [PLACE]]`.

Parts of orders of 400, each with its steps, runs and facts. Prints the median and the 95th percentile of each view over
random parts and pages, alone and with eight readers at once. Readers share one interpreter: eight are eight threads.
"""

import json
import random
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta
from hashlib import sha256
from pathlib import Path
from typing import Any, Final

from sqlalchemy import insert, text

from tests.support.factory import AT, ENGINEER, PLAN, SHA, keep_programs
from trueloop.domain.factory import FactKind, PartState, Run, RunFact
from trueloop.domain.part import Part, PartType
from trueloop.domain.tool import Machine
from trueloop.factory import requests as ask
from trueloop.factory.carry_out import carry_out
from trueloop.factory.shown.orders import order_rows, today
from trueloop.factory.shown.parts import part_life, part_rows
from trueloop.storage.kinds import joined
from trueloop.storage.schema import EVENT, TABLES, stamp
from trueloop.storage.store import Store, open_store

IN_ORDER: Final = 400
CALLS: Final = 200
TOLD: Final = (FactKind.SENT, FactKind.VERIFIED, FactKind.STARTED, FactKind.ENDED)


def main(parts: int = 100_000, place: str = "") -> None:
    """Fill a store, then time."""
    with tempfile.TemporaryDirectory() as name:
        store = open_store(place or Path(name) / "trueloop.db", create=True)
        began = time.perf_counter()
        fill(store, parts)
        print(f"{parts} parts in {time.perf_counter() - began:.0f} s, {store.engine.dialect.name}\n")
        drawn = random.Random(1)
        views: dict[str, Callable[[], object]] = {
            "plain SQL: 50 parts": lambda: plain(store, drawn.randrange(50, parts)),
            "parts, a page": lambda: part_rows(store, cursor=str(drawn.randrange(50, parts))),
            "parts of a state, a page": lambda: part_rows(
                store, state=PartState.RELEASED, cursor=str(drawn.randrange(50, parts))
            ),
            "a part by its serial number": lambda: part_rows(store, serial=str(drawn.randrange(parts))),
            "orders, a page": lambda: order_rows(store),
            "the life of a part": lambda: part_life(store, drawn.randrange(1, parts)),
            "today": lambda: today(store, AT + timedelta(days=1)),
        }
        print("| view | median, ms | 95 %, ms | 95 %, ms, 8 at once |\n|---|---:|---:|---:|")
        for view, call in views.items():
            alone = sorted(timed(call) for _ in range(CALLS))
            with ThreadPoolExecutor(8) as pool:
                together = sorted(pool.map(lambda _, one=call: timed(one), range(CALLS)))
            shown = (alone[CALLS // 2], alone[int(CALLS * 0.95)], together[int(CALLS * 0.95)])
            print(f"| {view} | {' | '.join(f'{one:.1f}' for one in shown)} |")
        store.close()


def timed(call: Callable[[], object]) -> float:
    """Milliseconds."""
    began = time.perf_counter()
    call()
    return (time.perf_counter() - began) * 1000


def plain(store: Store, before: int) -> list[Any]:
    """What a list costs at least."""
    with store.reading() as connection:
        query = text("SELECT id, serial FROM part WHERE id < :n ORDER BY id DESC LIMIT 50")
        return list(connection.execute(query, {"n": before}))


def fill(store: Store, parts: int) -> None:
    """Orders as they are planned, all but the last two of them done."""
    keep_programs(store)
    for sha in SHA.values():
        carry_out(store, ask.ReleaseProgram(sha, "ran in"), ENGINEER, AT)
    for first in range(0, parts, IN_ORDER):
        serials = tuple(map(str, range(first, min(first + IN_ORDER, parts))))
        plan = ask.PlanOrder("shaft", "B", "lathe", serials, PLAN.blocks, PLAN.job_toml)
        carry_out(store, plan, ENGINEER, AT)
    done = max(parts // IN_ORDER - 2, 0)
    with store.writing() as connection:
        run = "\"order\" || '.' || part || '.' || no || '.1'"
        orders = f'(SELECT "order" FROM order_state WHERE number <= {done})'
        connection.execute(
            text(f"UPDATE step SET state = 'recorded', run = {run}, attempts = 1 WHERE \"order\" IN {orders}")
        )
        connection.execute(text(f"UPDATE part_state SET state = 'released' WHERE \"order\" IN {orders}"))
        connection.execute(text(f"UPDATE order_state SET state = 'done' WHERE number <= {done}"))
        for table, rows in told(store, done * IN_ORDER):
            connection.execute(insert(table), rows)


def told(store: Store, parts: int) -> Iterator[tuple[Any, list[dict[str, Any]]]]:
    """A run with its facts for every step that moves, and an event each, some parts at a time."""
    for first in range(0, parts, 1000):
        runs, facts, events = [], [], []
        for row in range(first + 1, min(first + 1000, parts) + 1):
            order = f"O{(row - 1) // IN_ORDER + 1}"
            part = Part(PartType("shaft", "B"), str(row - 1))
            for no in (0, 1, 3):
                key = f"{order}.{row}.{no}.1"
                runs.append(_row(store, Run(key, order, part, no, 1, Machine("lathe"), sent_sha256=key)))
                runs[-1] |= {"work_order": order, "machine": "lathe", "part_type": "shaft", "serial": part.serial}
                facts += [_row(store, RunFact(key, kind, AT, "cell")) | {"run": key} for kind in TOLD]
                said = {"what": "recorded", "subject": f"part:{row}", "document": json.dumps({"run": key})}
                events.append({"at": stamp(AT), "who": "cell", **said})
        yield TABLES["run"], runs
        yield TABLES["run_fact"], facts
        yield EVENT, events


def _row(store: Store, value: Any) -> dict[str, Any]:
    document = store.codec.to_json(value)
    kept = {"identity": joined(value.identity), "version": 1, "kept_at": stamp(AT), "kept_by": "cell", "reason": ""}
    return {**kept, "sha256": sha256(document.encode()).hexdigest(), "document": document}


if __name__ == "__main__":
    main(int(sys.argv[1]) if sys.argv[1:] else 100_000, *sys.argv[2:3])
