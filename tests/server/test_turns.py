"""How many quick requests are worked on at a time."""

import asyncio
import urllib.error
import urllib.request
from concurrent.futures import ThreadPoolExecutor
from threading import Barrier, Event
from typing import Final

import pytest
from starlette.requests import Request

from tests.support.awaited import awaited
from tests.support.served import served
from trueloop.server import guarded
from trueloop.server.access import ACCESS
from trueloop.server.gates import AT_ONCE, turn
from trueloop.server.identity.keys import Who
from trueloop.storage.store import Store

REQUESTS: Final = 7


async def _most_at_once() -> int:
    inside, most = 0, 0

    async def request() -> None:
        nonlocal inside, most
        async with turn():
            inside += 1
            most = max(most, inside)
            await asyncio.sleep(0)
            inside -= 1

    await asyncio.gather(*(request() for _ in range(REQUESTS)))
    return most


def test_no_more_than_so_many_at_once_in_each_loop() -> None:
    assert [awaited(_most_at_once()) for _ in range(2)] == [AT_ONCE, AT_ONCE]


async def _next_after_a_failure() -> str:
    for _ in range(AT_ONCE + 1):
        try:
            async with turn():
                raise ValueError
        except ValueError:
            pass
    async with turn():
        return "served"


def test_a_request_that_fails_leaves_its_turn_to_the_next() -> None:
    assert awaited(asyncio.wait_for(_next_after_a_failure(), 10)) == "served"


def test_what_changes_streams_or_draws_does_not_queue_with_them() -> None:
    quick = {path for (method, path), access in ACCESS.items() if access.quick}
    assert {method for (method, path), access in ACCESS.items() if access.quick} == {"GET"}
    assert quick >= {"/parts", "/parts/{id}/life", "/orders", "/today"}
    slow = ("/events", "/machines/{name:path}/trace", "/machines/{name:path}/corrector", "/proposals/{id}/picture")
    assert quick.isdisjoint((*slow, "/charts/{part_type:path}", "/diagnosis/part/{serial:path}"))


def test_requests_whose_sender_is_looked_up_hold_nobody_up(store: Store, monkeypatch: pytest.MonkeyPatch) -> None:
    """Noting that somebody was there may wait for whoever writes; as many as are worked on at once do so here."""
    look_up, free, waiting = guarded.known, Event(), Barrier(AT_ONCE + 1)

    def known(here: guarded.Service, request: Request) -> Who:
        if "x-waits" in request.headers:
            waiting.wait(30)
            free.wait(30)
        return look_up(here, request)

    monkeypatch.setattr(guarded, "known", known)
    with served(store) as address, ThreadPoolExecutor(AT_ONCE) as pool:
        try:
            held = [pool.submit(_status, address, {"X-Waits": "1"}) for _ in range(AT_ONCE)]
            waiting.wait(30)
            assert _status(address, {}) == 401
        finally:
            free.set()
        assert [one.result(30) for one in held] == [401] * AT_ONCE


def _status(address: str, headers: dict[str, str]) -> int:
    try:
        with urllib.request.urlopen(urllib.request.Request(f"{address}/api/v1/parts", headers=headers), timeout=20):
            return 200
    except urllib.error.HTTPError as refused:
        refused.close()
        return refused.code
