"""Whether the service's memory grows: `trueloop serve` as a process of its own, asked REQUESTS times by eight clients.

`python -m scripts.service_memory [REQUESTS [URL]]`; 1,000,000 are a day of a busy shop. Pages are read as people read
them, a cell says what its machine does and asks for work, some requests are refused. The store is SQLite, or the empty
database at URL. Prints the slope of the resident memory over the requests after the first fifth, with its standard
error from means of stretches (single samples follow one another), and the processor time of a request.
"""

import http.client
import json
import os
import sys
import tempfile
import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from itertools import count, islice
from pathlib import Path
from typing import Final
from urllib.parse import urlsplit

import numpy as np

from scripts.cell_kills import _Served
from tests.support.full_shop import full_shop
from tests.support.service import PASSWORD
from trueloop.arrays import Array
from trueloop.jobs.store.codec import store_codec
from trueloop.server.identity.accounts import NewAccount, add_account
from trueloop.server.identity.keys import NewKey, add_key
from trueloop.storage.store import Store, open_store

CLIENTS: Final = 8
SAMPLES: Final = 400
STRETCHES: Final = 16
READ: Final = (
    *("today", "orders", "orders/O1", "parts", "parts/1/life", "parts/2/life", "proposals", "alarms", "machines"),
    *("machines/lathe", "programs", "certificates", "series", "tools", "me", "event-log", "parts/9999/life"),
)
_KEYS: Final = count()


class Client:
    """One connection: a person's, or a cell's."""

    def __init__(self, address: str, headers: Mapping[str, str]) -> None:
        self._connection = http.client.HTTPConnection(urlsplit(address).netloc, timeout=120)
        self._headers = {"Origin": address, **headers}

    def ask(self, method: str, path: str, body: object = None) -> int:
        """The status."""
        headers = self._headers | {"Content-Type": "application/json", "Idempotency-Key": f"m{next(_KEYS)}"}
        self._connection.request(method, f"/api/v1/{path}", json.dumps(body) if body is not None else None, headers)
        answer = self._connection.getresponse()
        answer.read()
        return answer.status


def main(requests: int = 1_000_000, url: str = "") -> None:
    """Serves, asks, and says what came of it."""
    with tempfile.TemporaryDirectory() as name:
        db = url or str(Path(name) / "trueloop.db")
        store = open_store(db, create=True, codec=store_codec())
        key = _shop(store)
        store.close()
        with _Served(Path(name), db) as served:
            assert served.process is not None
            cookie = _signed_in(served.address)
            before_s, done, kib = _processor_s(served.process.pid), [0.0], [_resident_kib(served.process.pid)]
            began = time.perf_counter()
            with ThreadPoolExecutor(CLIENTS) as pool:
                clients = [_client(served.address, cookie, key, k) for k in range(CLIENTS)]
                for sample in range(1, SAMPLES + 1):
                    list(pool.map(_stretch, clients, [requests // SAMPLES // CLIENTS] * CLIENTS))
                    done.append(sample * (requests // SAMPLES // CLIENTS * CLIENTS))
                    kib.append(_resident_kib(served.process.pid))
            spent_s = _processor_s(served.process.pid) - before_s
            _say(np.array(done), np.array(kib), spent_s, time.perf_counter() - began)


def _shop(store: Store) -> str:
    """Something of everything, an account and a cell's key."""
    full_shop(store)
    add_account(store, NewAccount("admin", "admin", PASSWORD), datetime.now(UTC))
    return add_key(store, NewKey("lathe", "cell", 30), "test", datetime.now(UTC)).key


def _signed_in(address: str) -> str:
    connection = http.client.HTTPConnection(urlsplit(address).netloc, timeout=120)
    body = json.dumps({"name": "admin", "password": PASSWORD})
    connection.request("POST", "/api/v1/session", body, {"Origin": address, "Content-Type": "application/json"})
    answer = connection.getresponse()
    answer.read()
    return str(answer.headers["Set-Cookie"]).split(";")[0]


def _client(address: str, cookie: str, key: str, number: int) -> tuple[Client, bool]:
    """Every fourth is a cell."""
    cell = number % 4 == 3
    return Client(address, {"Authorization": f"Bearer {key}"} if cell else {"Cookie": cookie}), cell


def _stretch(client: tuple[Client, bool], requests: int) -> None:
    """So many requests."""
    asks, cell = client
    for k in islice(count(), requests):
        if not cell:
            status = asks.ask("GET", READ[k % len(READ)])
        elif k % 4:
            status = asks.ask("POST", "cell/heartbeat", {"state": "idle", "program": "", "line": k})
        elif k % 8:
            at = datetime.now(UTC).isoformat()
            status = asks.ask("POST", "cell/temperatures", {"signals": {"spindle": 23.5}, "at": at, "run": ""})
        else:
            status = asks.ask("POST", "cell/next", {})
        assert status in (200, 204, 404, 409), status


def _resident_kib(pid: int) -> float:
    status = Path(f"/proc/{pid}/status").read_text()
    return float(status.partition("VmRSS:")[2].split()[0])


def _processor_s(pid: int) -> float:
    user, system = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[11:13]
    return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


def slope_of(done: Array, kib: Array) -> tuple[float, float]:
    """KiB a request, and its standard error: a line through the means of stretches, the first fifth left out."""
    kept = done >= done[-1] / 5
    x, y = (np.array([part.mean() for part in np.array_split(one[kept], STRETCHES)]) for one in (done, kib))
    away = x - x.mean()
    slope = float(away @ y / (away @ away))
    rest = y - y.mean() - slope * away
    return slope, float(np.sqrt(rest @ rest / (STRETCHES - 2) / (away @ away)))


def _say(done: Array, kib: Array, spent_s: float, took_s: float) -> None:
    slope, error = slope_of(done, kib)
    print(f"{done[-1]:.0f} requests in {took_s:.0f} s, {1e3 * spent_s / done[-1]:.2f} ms of processor time each")
    tenths = [f"{kib[k * (len(kib) - 1) // 10] / 1024:.1f}" for k in range(11)]
    print(f"resident at each tenth, MiB: {', '.join(tenths)}")
    print(
        f"slope after a fifth: {slope * 1e6 / 1024:+.2f} ± {error * 1e6 / 1024:.2f} MiB per 1,000,000 requests (1 s.e.)"
    )


if __name__ == "__main__":
    main(int(sys.argv[1]) if sys.argv[1:] else 1_000_000, *sys.argv[2:3])
