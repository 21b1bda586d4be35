"""What eight clients wait for the service with a store of many parts: `python -m benches.service [PARTS [FILE]]`.

`trueloop serve` is a process of its own; a FILE that is there already is taken as it is. Each client has a connection
that is kept, and asks without a pause, or ten times a second as a page does that many people have open. Processor time
is of one request, the service's and the clients': where the machine has other work, it says more than what was waited.
"""

import os
import random
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import Final

from benches.closed_loop import times_ms
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
            print(
                "| asked over HTTP | median, ms | 95 %, ms | 8 without a pause: median | 95 % | requests a second | ",
                end="",
            )
            print("processor of the service, ms | of the clients | load |\n|---|" + "---:|" * 8)
            for what, path in asked.items():
                paced = _paced(clients, path)
                closed, a_second, spent_ms, own_ms = _closed(served, headers, path)
                waited = (*_middle_and_95(paced), *_middle_and_95(closed))
                said = [*(f"{one:.1f}" for one in waited), f"{a_second:.0f}", f"{spent_ms:.2f}", f"{own_ms:.2f}"]
                print(f"| {what} | {' | '.join(said)} | {os.getloadavg()[0]:.1f} |", flush=True)


def _middle_and_95(times: list[float]) -> tuple[float, float]:
    return times[len(times) // 2], times[len(times) * 19 // 20]


def _closed(
    served: _Served, headers: Mapping[str, str], path: Callable[[], str]
) -> tuple[list[float], float, float, float]:
    """Without a pause: ms of every request, sorted; requests a second; processor's ms of the service and of clients."""
    assert served.process is not None
    times_ms(served.address, headers, path, CLIENTS, ASKED)  # files and statements are known from here on
    before_s, own_s, began = _processor_s(served.process.pid), time.process_time(), time.perf_counter()
    found = times_ms(served.address, headers, path, CLIENTS, CLIENTS * ASKED)
    took_s = time.perf_counter() - began
    spent_ms = 1000 * (_processor_s(served.process.pid) - before_s) / len(found)
    return found, len(found) / took_s, spent_ms, 1000 * (time.process_time() - own_s) / len(found)


def _paced(clients: list[Client], path: Callable[[], str]) -> list[float]:
    """Milliseconds of every request, sorted."""
    with ThreadPoolExecutor(CLIENTS) as pool:
        return sorted(one for each in pool.map(partial(_times, path=path), clients) for one in each)


def _times(client: Client, path: Callable[[], str]) -> list[float]:
    times = []
    for _ in range(ASKED):
        time.sleep(random.uniform(0.5, 1.5) * PAUSE_S)
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
