"""What eight clients wait for the service with a store of many parts: `python -m benches.service [PARTS [FILE]]`.

`trueloop serve` is a process of its own; a FILE that is there already is taken as it is. Each client has a connection
that is kept, and asks without a pause, or ten times a second as a page does that many people have open.
"""

import random
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Final

from benches.factory import fill
from scripts.cell_kills import _Served
from scripts.service_memory import Client, _processor_s, _signed_in
from tests.support.service import PASSWORD
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.store.codec import store_codec
from trueloop.server.identity.accounts import NewAccount, add_account
from trueloop.storage.store import Store, open_store

CLIENTS: Final = 8
ASKED: Final = 100
PAUSE_S: Final = 0.1


def main(parts: int = 100_000, file: str = "") -> None:
    """Fill a store, serve it, then time."""
    with tempfile.TemporaryDirectory() as name:
        place = Path(file or Path(name) / "trueloop.db")
        _filled(place, parts)
        drawn = random.Random(1)
        asked: dict[str, Callable[[], str]] = {
            "parts, a page": lambda: "parts",
            "orders, a page": lambda: "orders",
            "today": lambda: "today",
            "the life of a part": lambda: f"parts/{drawn.randrange(1, parts)}/life",
        }
        with _Served(Path(name), str(place)) as served:
            headers = {"Cookie": _signed_in(served.address)}
            clients = [Client(served.address, headers) for _ in range(CLIENTS)]
            print("| asked over HTTP | median, ms | 95 %, ms | 8 without a pause: 95 %, ms | processor, ms |")
            print("|---|---:|---:|---:|---:|")
            for what, path in asked.items():
                paced, _ = _asked(served, clients, path, PAUSE_S)
                closed, spent_ms = _asked(served, clients, path, 0.0)
                said = (paced[len(paced) // 2], paced[len(paced) * 19 // 20], closed[len(closed) * 19 // 20], spent_ms)
                print(f"| {what} | {' | '.join(f'{one:.1f}' for one in said)} |")


def _asked(
    served: _Served, clients: list[Client], path: Callable[[], str], pause_s: float
) -> tuple[list[float], float]:
    """Milliseconds of every request, sorted, and of processor of the service for one."""
    assert served.process is not None
    before_s = _processor_s(served.process.pid)
    with ThreadPoolExecutor(CLIENTS) as pool:
        found = [one for each in pool.map(partial(_times, path=path, pause_s=pause_s), clients) for one in each]
    return sorted(found), 1000 * (_processor_s(served.process.pid) - before_s) / len(found)


def _times(client: Client, path: Callable[[], str], pause_s: float) -> list[float]:
    times = []
    for _ in range(ASKED):
        time.sleep(random.uniform(0.5, 1.5) * pause_s)
        began = time.perf_counter()
        assert client.ask("GET", path()) == 200
        times.append(1000 * (time.perf_counter() - began))
    return times


def _filled(place: Path, parts: int) -> None:
    there = place.exists()
    store = open_store(place, create=not there, codec=store_codec())
    if not there:
        fill(store, parts)
    _account(store)
    store.close()


def _account(store: Store) -> None:
    try:
        add_account(store, NewAccount("admin", "admin", PASSWORD), datetime.now(UTC))
    except TrueloopError as there:
        if there.code is not Code.SRV_ACCOUNT:
            raise


if __name__ == "__main__":
    main(int(sys.argv[1]) if sys.argv[1:] else 100_000, *sys.argv[2:3])
